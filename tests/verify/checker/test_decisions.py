"""Certificates: read back, bound to their question, checked; and what the checker refuses."""

import json
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from codegen.errors import InputError
from codegen.policy_json import content_hash
from tests.support.altered import altered, of_goals, read_game, sealed
from tests.support.certificates import ensure_caught, judge_changes
from tests.support.teams import STAY, UP, team, team_in, towards, tree
from tests.support.zone_cases import NAVIGATION, deception, near_roles, random_region, stated, switching
from verify.certificates.games import to_json
from verify.certificates.proofs import varint
from verify.checker import decisions
from verify.checker.certificate import numbers
from verify.checker.decisions import check_certificate
from verify.checker.reading import RejectedError
from verify.claims.catalogue import find_property
from verify.claims.decisions import DistinctTargets, OwnTarget, formula
from verify.claims.formula import FALSE, TRUE, Goal, Not, disjunction, negate
from verify.claims.region import Region
from verify.claims.region_files import start_region
from verify.kinds import MACHINE, REAL, Semantics
from verify.result import Verdict
from verify.zones import engine as zones
from verify.zones import search, tables

pytestmark = pytest.mark.solver


def certified(profile, claim, region, semantics=MACHINE):
    """The certificate of a claim that holds."""
    found = zones.decide(stated(profile, formula(profile, claim), region, semantics))
    assert found.verdict is Verdict.PROVED
    asked = formula(profile, claim)
    return of_goals(content_hash(profile), claim, asked, region, semantics, found.inhabitant, found.proofs)


@pytest.fixture(scope="module")
def roles(profile):
    """A team whose claim leaves settle, and its certificate."""
    pair = team(profile, towards(0, 0), towards(1, 1))
    return pair, certified(pair, find_property("distinct_targets", pair), start_region(pair.world))


@pytest.fixture(scope="module")
def switchers(profile):
    """A team whose proof needs both trees, in a region with differences and distances, and its certificate."""
    pair = team(profile, *switching(0.1))
    start = start_region(pair.world)
    half = (Fraction(-1, 2), Fraction(1, 3))
    apart = (("agent_0", "agent_1", Fraction(1, 5)),)
    region = Region(start.box, start.goals, (("agent_0.x", "landmark_1.x", half),), apart, name="region.toml")
    return pair, certified(pair, find_property("distinct_targets", pair, radius=Fraction(3, 50)), region)


@pytest.mark.parametrize("which", ["roles", "switchers"])
@pytest.mark.smoke
def test_a_certificate_comes_back_and_is_accepted(which, request):
    pair, made = request.getfixturevalue(which)
    text = to_json(made)
    back = read_game(text)
    assert back == made and to_json(back) == text
    assert check_certificate(back, pair) > 10


def test_real_semantics_is_named_and_not_the_machines(profile):
    """Proved over the reals only: standing still is wrong in the sliver where float32 rounds to the threshold."""
    pair = team(profile, towards(0, 0), towards(1, 1))
    asked = find_property("distinct_targets", pair, radius=Fraction(float(np.float32(0.05))))
    real = certified(pair, asked, start_region(pair.world), REAL)
    assert check_certificate(read_game(to_json(real)), pair) > 10
    with pytest.raises(RejectedError):
        check_certificate(altered(real, semantics=MACHINE), pair)


# --- what a certificate is bound to


def test_another_policy_is_told(roles, profile):
    _, made = roles
    other = team(profile, towards(0, 0), tree(STAY))
    with pytest.raises(InputError, match="another profile"):
        check_certificate(made, other)
    with pytest.raises(RejectedError):
        check_certificate(altered(made, profile=content_hash(other)), other)


def test_the_formula_must_be_the_propertys(roles):
    pair, made = roles
    for changed in (TRUE, Not(FALSE), formula(pair, replace(made.claim.property, radius=Fraction(1)))):
        with pytest.raises(RejectedError, match="not the one that distinct_targets has"):
            check_certificate(altered(made, formula=changed), pair)
    assert check_certificate(altered(made, property=None), pair) > 10
    strange = OwnTarget(made.claim.property.team, landmarks=("landmark_7", "landmark_8"))
    with pytest.raises(RejectedError, match="not the one that own_target has"):
        check_certificate(altered(made, property=strange), pair)


def test_every_goal_needs_its_proof(roles):
    pair, made = roles
    with pytest.raises(RejectedError, match="goals"):
        check_certificate(altered(made, proofs={"landmark_0": made.proof.proofs["landmark_0"]}), pair)


def test_an_empty_region_is_refused(roles):
    """Everything holds in a region without points: no inhabitant, no certificate."""
    pair, made = roles
    empty = replace(made.header.region, differences=(("agent_0.x", "agent_1.x", (Fraction(3), Fraction(4))),))
    assert zones.decide(stated(pair, made.claim.formula, empty)).verdict is Verdict.VACUOUS
    with pytest.raises(RejectedError, match="not a state of the region"):
        check_certificate(altered(made, region=empty), pair)
    with pytest.raises(InputError, match="inhabitant"):
        check_certificate(altered(made, region=empty, inhabitant={}), pair)


@pytest.mark.parametrize("name", ["agent_9.x", "", "goal.z"])
def test_unknown_coordinates_are_told(roles, name):
    pair, made = roles
    box = {**made.header.region.box, name: (Fraction(0), Fraction(1))}
    with pytest.raises(InputError, match="does not have"):
        check_certificate(altered(made, region=replace(made.header.region, box=box)), pair)


# --- a thousand changes, with all hashes made again: what is accepted, holds


@pytest.mark.slow
@pytest.mark.parametrize("which", ["roles", "switchers"])
def test_no_certificate_of_a_false_claim_is_accepted(which, request):
    """500 changes each; a change that keeps the claim true may pass."""
    kinds = ("tree", "region", "property", "proof")
    passed, refused = judge_changes(np.random.default_rng(17), [request.getfixturevalue(which)], 500, kinds)
    # fixed roles hold in every region
    wrong = ("tree", "property", "proof") if which == "roles" else kinds
    assert all(refused[kind] > 15 for kind in wrong) and sum(passed.values()) < 300, (refused, passed)


def test_proofs_of_other_claims_are_refused(roles):
    """The denial's proof, an empty proof, and numbers without end."""
    pair, made = roles
    for proof in (b"", b"\0", b"\1", b"\0\0\0", varint(2**62) * 3, b"\xff" * 40, bytes(range(60))):
        with pytest.raises(RejectedError):
            check_certificate(altered(made, proofs=dict.fromkeys(made.proof.proofs, proof)), pair)
    with pytest.raises(RejectedError):
        decisions.check(
            pair, (negate(made.claim.formula),), made.header.region, "landmark_0", Semantics(), numbers(b"")
        )
    for longer in (b"\0", b"\1\0"):
        with pytest.raises(RejectedError, match="continues"):
            check_certificate(
                altered(made, proofs={goal: proof + longer for goal, proof in made.proof.proofs.items()}), pair
            )


# --- bugs in the engine: its certificates are refused


def backwards(patch):
    real = tables.problem

    def swapped(table):
        made = real(table)
        return altered(made, edges=[(component, b, a) for component, a, b in made.edges])

    patch.setattr(zones, "problem", swapped)


def wrong_bound(patch):
    real = tables.problem
    patch.setattr(
        zones, "problem", lambda table: replace(p := real(table), weights=[w - p.scale // 9 for w in p.weights])
    )


def all_strict(patch):
    """Weak cycles of sum zero taken for empty."""
    real = tables.problem
    patch.setattr(zones, "problem", lambda table: replace(p := real(table), weights=[w - 1 for w in p.weights]))


def right_forgotten(patch):
    real = tables.zone_tree

    def pruned(*given):
        made = real(*given)
        return altered(made, sides=[(left, None) for left, _ in made.sides])

    patch.setattr(zones, "zone_tree", pruned)


def choices_forgotten(patch):
    real = tables._join_flats

    def first_only(everyone, parts):
        return real(everyone, parts if everyone else [part for part in parts if part is not None][:1])

    patch.setattr(tables, "_join_flats", first_only)


def sides_swapped(patch):
    real = tables.sides
    patch.setattr(tables, "sides", lambda *given: real(*given)[::-1])


def thresholds_as_written(patch):
    real = tables.sides
    patch.setattr(tables, "sides", lambda feature, threshold, numbers, *_: real(feature, threshold, numbers, REAL))


def lemmas_believed(patch):
    class Believing(search.ZoneSearch):
        def lemmas(self, tree, parts, allowed):
            stream, masks = super().lemmas(tree, parts, allowed)
            return stream, [3] * len(masks)

    patch.setattr(zones, "search", Believing)


BUGS = {
    bug.__name__: bug
    for bug in (
        backwards, wrong_bound, all_strict, right_forgotten, choices_forgotten, sides_swapped, thresholds_as_written,
        lemmas_believed,
    )
}  # fmt: skip


@pytest.mark.parametrize("name", BUGS)
def test_bugs_of_the_engine_are_caught(profile, name, monkeypatch):
    """Some proof is refused, and every one of a false claim."""
    rng = np.random.default_rng(5)
    questions = []
    for _ in range(60):
        pair, claim = near_roles(rng, profile) if rng.random() < 0.7 else deception(rng, 3)
        region = start_region(pair.world) if rng.random() < 0.5 else random_region(rng, pair)
        questions.append((pair, claim, region))
    sliver = team(profile, towards(0, 0), towards(1, 1))  # fails only where float32 rounds down to the threshold
    claim = find_property("distinct_targets", sliver, radius=Fraction(float(np.float32(0.05))))
    ensure_caught(BUGS[name], monkeypatch, [*questions, (sliver, claim, start_region(sliver.world))])


def test_three_agents_with_velocities(profile):
    """A world without goals has one proof, for no goal; in the file its name is empty."""
    world = NAVIGATION
    trio = team_in(world, [tree(UP)] * 3)
    start = start_region(world.spec)
    low = {name: (Fraction(-3), Fraction(-2)) for name in start.box if name.startswith("agent") and name.endswith("y")}
    made = certified(trio, DistinctTargets("agents"), Region({**start.box, **low}, ()))
    written = to_json(made)
    assert set(made.proof.proofs) == {""} and list(json.loads(written)["proofs"]) == [""]
    assert read_game(written) == made and check_certificate(read_game(written), trio) == 4


def test_no_property_whose_formula_says_less_is_accepted(roles):
    """Of steady and alive_leaves the formula is not all that they claim: a certificate cannot be about them."""
    pair, made = roles
    document = json.loads(to_json(made))
    named = document["property"]
    for other in ({**named, "name": "steady"}, {"name": "alive_leaves", "team": "defenders"}, {**named, "eps": "5"}):
        with pytest.raises(InputError, match="does not hold what it should"):
            read_game(sealed(document | {"property": other}))
    with pytest.raises(InputError, match="margin must be between"):
        claim = replace(made.claim.property, margin=Fraction(-1))
        check_certificate(altered(made, property=claim, formula=formula(pair, claim)), pair)


def test_the_goals_place_cannot_be_bounded_apart_from_its_landmark(roles):
    """`goal.x` is another name of a coordinate that the region bounds: free, it would make a region of nothing."""
    pair, made = roles
    far = {"goal.x": Fraction(5), "goal.y": Fraction(5)}
    odd = replace(
        made.header.region, box={**made.header.region.box, **{name: (value, value) for name, value in far.items()}}
    )
    with pytest.raises(InputError, match=r"goal\.x"):
        check_certificate(altered(made, region=odd, inhabitant={**made.header.inhabitant, **far}), pair)
    loose = replace(made.header.region, differences=(("agent_0.vx", "agent_1.x", (Fraction(0), Fraction(1))),))
    with pytest.raises(InputError, match=r"agent_0\.vx"):
        check_certificate(altered(made, region=loose), pair)


def forged_for_all(made, pair):
    """A certificate for one goal, said to be for all: with its proof for each."""
    region = start_region(pair.world)
    (proof,) = made.proof.proofs.values()
    return altered(made, region=region, proofs=dict.fromkeys(region.goals, proof))


def test_a_proof_for_one_goal_is_none_for_another_where_a_test_names_the_goal(profile):
    pair = team(profile, towards(-1, 0), towards(1, 1))  # agent_0 goes to the goal: at landmark_1 both go there
    first = replace(start_region(pair.world), goals=("landmark_0",))
    made = certified(pair, find_property("distinct_targets", pair), first)
    assert check_certificate(made, pair) > 0
    with pytest.raises(RejectedError, match="goal landmark_1"):
        check_certificate(forged_for_all(made, pair), pair)


def test_a_proof_for_one_goal_is_none_for_another_where_the_claim_names_the_goal(profile):
    pair = team(profile, tree(STAY), tree(STAY))
    first = replace(start_region(pair.world), goals=("landmark_0",))
    asked = disjunction(Goal("landmark_0"), formula(pair, find_property("own_target", pair)))
    found = zones.decide(stated(pair, asked, first))
    made = of_goals(content_hash(pair), None, asked, first, MACHINE, found.inhabitant, found.proofs)
    assert found.verdict is Verdict.PROVED and check_certificate(made, pair) >= 0
    with pytest.raises(RejectedError, match="goal landmark_1"):
        check_certificate(forged_for_all(made, pair), pair)


def test_goals_that_nothing_names_are_one_question(roles, monkeypatch):
    """Proof, nodes and branches are those of each goal asked alone; the checker reads equal proofs once."""
    pair, made = roles
    question = stated(pair, made.claim.formula, made.header.region)
    alone = {goal: zones.decide(question.for_one_goal(goal)) for goal in made.header.region.goals}
    assert made.proof.proofs == {goal: one.proofs[goal] for goal, one in alone.items()}
    # the region's state is sought once
    assert zones.decide(question).nodes == sum(one.nodes for one in alone.values()) - (len(alone) - 1)
    single = [altered(made, region=question.for_one_goal(goal).region, proofs=alone[goal].proofs) for goal in alone]
    branches, read = sum(check_certificate(one, pair) for one in single), list[object]()
    real = decisions.check
    monkeypatch.setattr(decisions, "check", lambda *asked: read.append(asked) or real(*asked))
    assert check_certificate(made, pair) == branches and len(read) == 1
    other = made.header.region.goals[1]
    with pytest.raises(RejectedError, match=f"goal {other}"):
        check_certificate(altered(made, proofs={**made.proof.proofs, other: made.proof.proofs[other][:-1]}), pair)
