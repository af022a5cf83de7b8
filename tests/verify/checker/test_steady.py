"""Certificates about features that are off: bound to their eps and property; what the checker refuses."""

import json
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from codegen.errors import InputError
from codegen.policy_json import dumps
from maviper.verification.files.certificates import check_file
from tests.support.altered import altered, read_game, sealed
from tests.support.certificates import ensure_caught, judge_changes
from tests.support.teams import STAY, UP, team, towards, tree
from tests.support.zone_cases import noisy, noisy_roles, random_region
from verify.certificates.games import to_json
from verify.checker import reading as bounds
from verify.checker import thresholds
from verify.checker.decisions import check_certificate
from verify.checker.reading import RejectedError
from verify.claims.catalogue import find_property
from verify.claims.decisions import STEADY, DistinctTargets, OwnTarget
from verify.claims.files import read_properties
from verify.claims.formula import FALSE, TRUE, Linear
from verify.claims.region import Region
from verify.claims.region_files import start_region
from verify.kinds import Semantics
from verify.question import Budgets, Question
from verify.result import Verdict
from verify.solver.solve import decide
from verify.subjects import Game
from verify.verdicts.decisions import by_zones
from verify.zones import engine as zones
from verify.zones import tables

pytestmark = pytest.mark.solver
EPS = Fraction(1, 25)


def proved(profile, claim, region):
    """The certificate that goes with the verdict, read back from its text."""
    zoned = by_zones(Question(Game(profile), claim, region, budgets=Budgets(10**9)))
    assert zoned.opinion.verdict is Verdict.PROVED and zoned.branches > 0
    text = to_json(zoned.certificate)
    back = read_game(text)
    assert back == zoned.certificate and to_json(back) == text
    return back


@pytest.fixture(scope="module")
def roles(profile):
    """Fixed roles with tests nearer to one another than errors, and the certificate that they are steady."""
    pair = team(profile, towards(0, 0), towards(1, 1))
    return pair, proved(pair, DistinctTargets("defenders", eps=EPS), start_region(pair.world))


def test_a_certificate_states_its_errors(roles):
    pair, made = roles
    document = json.loads(to_json(made))
    assert document["eps"] == "1/25"
    assert document["property"]["name"] == STEADY and document["property"]["of"] == "distinct_targets"
    assert document["property"]["eps"] == "1/25"
    assert check_certificate(made, pair) > 10


def test_without_errors_a_certificate_says_nothing_of_them(roles):
    pair, _ = roles
    plain = proved(pair, find_property("distinct_targets", pair), start_region(pair.world))
    assert "eps" not in to_json(plain) and '"of"' not in to_json(plain)


def test_the_proof_of_the_property_itself_does_not_pass_for_steady(roles):
    """Nor the reverse, though it would be true: each states what its proof is about."""
    pair, made = roles
    plain = proved(pair, find_property("distinct_targets", pair), start_region(pair.world))
    with pytest.raises(RejectedError, match="errors up to 1/25, but the proof about errors up to 0"):
        check_certificate(altered(plain, property=made.claim.property), pair)
    with pytest.raises(RejectedError):
        check_certificate(altered(plain, property=made.claim.property, eps=EPS), pair)
    with pytest.raises(RejectedError, match="errors up to 0, but the proof about errors up to 1/25"):
        check_certificate(altered(made, property=plain.claim.property), pair)
    false = replace(made.claim.property, eps=Fraction(1, 4))
    assert decide(Question(Game(pair), false, plain.header.region)).verdict is Verdict.VIOLATED
    for proofs in (plain.proof.proofs, made.proof.proofs):
        with pytest.raises(RejectedError):
            check_certificate(altered(plain, property=false, eps=false.eps, proofs=proofs), pair)
        with pytest.raises(RejectedError):
            check_certificate(altered(plain, property=None, eps=false.eps, proofs=proofs), pair)
    assert check_certificate(altered(made, property=None), pair) > 10, (
        "a formula without a name may be said of errors too"
    )


@pytest.mark.parametrize("eps", [Fraction(-1, 100), Fraction(-9), Fraction(10**10)])
def test_errors_out_of_range_are_refused(roles, eps):
    """Negative errors would make sides narrower: a proof of less than what is claimed."""
    pair, made = roles
    with pytest.raises((InputError, RejectedError)):
        check_certificate(altered(made, property=replace(made.claim.property, eps=eps), eps=eps), pair)
    with pytest.raises(InputError, match="eps must be between"):
        check_certificate(altered(made, property=None, eps=eps), pair)


@pytest.mark.parametrize(
    "change",
    [
        {"eps": "0"}, {"eps": "-1/25"}, {"eps": "much"}, {"eps": "1e-99999999"}, {"eps": ""},
        {"property": {"name": STEADY, "team": "defenders", "eps": "1/25", "of": "steady"}},
        {"property": {"name": STEADY, "team": "defenders", "eps": "1/25", "of": "alive_leaves"}},
        {"property": {"name": STEADY, "team": "defenders", "eps": "1/25", "of": ""}},
        {"property": {"name": STEADY, "team": "defenders", "eps": "1/25"}},
        {"property": {"name": "distinct_targets", "team": "defenders", "eps": "1/25"}},
        {"property": {"name": "distinct_targets", "team": "defenders", "of": "own_target"}},
        {"property": {"name": "formula", "team": "defenders"}},
        {"property": {"team": "defenders", "eps": "1/25", "of": "distinct_targets"}},
    ],
)  # fmt: skip
def test_damaged_errors_are_told(roles, change):
    _, made = roles
    with pytest.raises(InputError, match="does not hold what it should"):
        read_game(sealed(json.loads(to_json(made)) | change))


def test_an_edited_eps_is_told(roles):
    _, made = roles
    document = json.loads(to_json(made))
    for edited in (document | {"eps": "1/20"}, {key: value for key, value in document.items() if key != "eps"}):
        with pytest.raises(InputError, match="edited after"):
            read_game(json.dumps(edited))
        if "eps" in edited:
            edited["eps"] = 0.04
            with pytest.raises(InputError, match="does not hold what it should"):
                read_game(json.dumps(edited))


def test_steady_without_its_errors_is_refused(roles):
    """The member left out and the hash made again: the property still states them."""
    pair, made = roles
    document = json.loads(to_json(made))
    del document["eps"]
    with pytest.raises(RejectedError, match="but the proof about errors up to 0"):
        check_certificate(read_game(sealed(document)), pair)


def test_claims_of_ones_own_are_certified_with_their_errors(profile):
    """With a formula, or with an assumption, the certificate has no name, and its errors all the same."""
    pair = team(profile, tree((2, 0.0, 1, 2), STAY, UP), tree(STAY))
    source = '[[property]]\nformula = "landmark_0.x - agent_0.x < 1/10 or acts(agent_0) == up"\neps = 0.05'
    ((own, region, _),) = read_properties(source, pair, "claims", lambda name: start_region(pair.world))
    made = proved(pair, own, region)
    assert made.claim.property is None and made.header.eps == Fraction(1, 20)
    with pytest.raises(RejectedError):
        check_certificate(altered(made, eps=Fraction(1, 5)), pair)
    assert (
        by_zones(Question(Game(pair), replace(own, eps=Fraction(1, 5)), region, budgets=Budgets(10**9))).opinion.verdict
        is Verdict.VIOLATED
    )


# --- changes, with all hashes made again: what is accepted, holds


@pytest.mark.slow
def test_no_certificate_of_a_false_claim_is_accepted(profile):
    """600 changes of certificates of several teams; a change that keeps the claim true may pass."""
    rng = np.random.default_rng(31)
    teams = []
    while len(teams) < 6:
        pair, claim = noisy_roles(rng, profile)
        zoned = by_zones(Question(Game(pair), claim, start_region(pair.world), budgets=Budgets(10**9)))
        if zoned.certificate is not None:
            teams.append((pair, zoned.certificate))
    passed, refused = judge_changes(rng, teams, 600, ("tree", "region", "property", "errors", "proof"))
    assert all(refused[kind] > 10 for kind in ("tree", "property", "errors", "proof")), refused
    assert sum(passed.values()) < 400 and passed["errors"] > 0, passed


# --- bugs in the engine: its certificates are refused


def errors_forgotten(patch):
    real = zones.split_sides
    patch.setattr(zones, "split_sides", lambda policy, semantics, eps: real(policy, semantics))


def errors_too_small(patch):
    real = zones.split_sides
    patch.setattr(zones, "split_sides", lambda policy, semantics, eps: real(policy, semantics, eps / 2))


def one_side_exact(patch):
    real = tables.sides

    def half(feature, threshold, numbers, semantics, eps):
        return real(feature, threshold, numbers, semantics, eps)[0], real(feature, threshold, numbers, semantics)[1]

    patch.setattr(tables, "sides", half)


def barred_without_reason(patch):
    real = zones.find_barred_sides

    def more(policy, splits):
        tested = {}
        for node, feature in enumerate(policy.tree.feature.tolist()):
            tested.setdefault(feature, []).append(node)
        again = [nodes[-1] for feature, nodes in tested.items() if feature >= 0 and len(nodes) > 1]
        return real(policy, splits) | {(node, 1) for node in again}

    patch.setattr(zones, "find_barred_sides", more)


def places_reversed(patch):
    real = tables._places
    patch.setattr(tables, "_places", lambda splits: {split: -place for split, place in real(splits).items()})


BUGS = (errors_forgotten, errors_too_small, one_side_exact, barred_without_reason, places_reversed)


@pytest.mark.parametrize("bug", BUGS, ids=lambda bug: bug.__name__)
def test_bugs_of_the_engine_are_caught(profile, bug, monkeypatch):
    """Some proof is refused, and every one of a false claim."""
    rng = np.random.default_rng(32)
    questions = []
    for _ in range(60):
        pair, claim = noisy(rng, profile)
        region = start_region(pair.world) if rng.random() < 0.6 else random_region(rng, pair)
        questions.append((pair, claim, region))
    ensure_caught(bug, monkeypatch, questions)


def test_the_checker_bars_what_contradicts_and_no_more(profile):
    """Its own account of sides that no measured value reaches, against the engine's, on random trees."""
    rng = np.random.default_rng(33)
    barred = 0
    for _ in range(60):
        pair, claim = noisy(rng, profile)
        for policy in pair.team("defenders"):
            theirs = zones.find_barred_sides(policy, tables.split_sides(policy, Semantics().arithmetic, claim.eps))
            reading = bounds.Reading([policy.agent], "landmark_0")
            found = reading.tree(policy, Semantics(eps=claim.eps))
            alive, waiting = set(), [0]
            while waiting:
                node = waiting.pop()
                if not isinstance(found[node], int):
                    alive |= {(node, side) for side, (flat, _) in zip((0, 1), found[node], strict=True) if flat}
                    waiting += [child for flat, child in found[node] if flat]
            ends = {node for node, _ in alive}
            false = {
                (node, side)
                for node in ends
                for side in (0, 1)
                if (node, side) not in alive and _sides(policy, node)[side] != FALSE
            }
            linear = {(node, side) for node, side in false if _linear(policy, node)}
            assert linear == {(node, side) for node, side in theirs if node in ends}
            barred += len(linear)
    assert barred > 20


def _sides(policy, node):
    feature = policy.features[int(policy.tree.feature[node])]
    return thresholds.sides(feature, float(policy.tree.threshold[node]), policy.numbers)


def _linear(policy, node):
    left, right = _sides(policy, node)
    return isinstance(left, Linear) and TRUE not in (left, right)


def test_the_check_says_what_was_proved(profile, tmp_path, capsys):
    pair = team(profile, towards(0, 0), towards(1, 1))
    (tmp_path / "profile.json").write_text(dumps(pair))
    claim = OwnTarget("defenders", eps=EPS)
    left = Linear(((Fraction(1), "agent_0.x"),), Fraction(0))
    said = {
        "named": (claim, "steady of the defenders, eps 0.04, of own_target in region start"),
        "assuming": (
            replace(claim, assume=left),
            "a formula, though every feature is off by up to 0.04 in region start",
        ),
    }
    for name, (asked, line) in said.items():
        path = tmp_path / f"{name}.json"
        path.write_text(to_json(proved(pair, asked, start_region(pair.world))))
        assert line in check_file(path).subject


def test_a_region_of_one_point_is_enough_for_a_refusal(profile):
    """Exactly at the edge of the errors: the certificate for a hair less does not pass for them."""
    box = dict.fromkeys(start_region(profile.world).box, (Fraction(0), Fraction(0)))
    box |= {f"landmark_{k}.{axis}": (Fraction(1), Fraction(1)) for k in (0, 1) for axis in "xy"}
    one = team(profile, tree((2, 0.75, 1, 2), STAY, UP), tree(UP))
    end, little = 1 - Fraction(3, 4) - Fraction(1, 2**25) - Fraction(1, 2**54), Fraction(1, 2**200)
    claim = DistinctTargets("defenders", eps=end - little)
    made = proved(one, claim, Region(box, ("landmark_0",)))
    with pytest.raises(RejectedError):
        check_certificate(altered(made, property=replace(claim, eps=end), eps=end), one)
