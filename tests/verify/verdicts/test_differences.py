"""Where two profiles act differently, against enumeration by the judge of the hunt, which shares nothing with the
verifier; and proofs that they act alike.
"""

import itertools
import json
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from codegen import ir, policy_json
from codegen.errors import InputError, UnknownNameError
from codegen.observe import observe
from tests.hunting import places, questions, reading, teams
from tests.support.altered import altered, read_game
from tests.support.strategies import with_trees
from tests.support.teams import DOWN, LEFT, STAY, UP, nested, team, towards, tree
from verify.certificates.games import to_json
from verify.checker import decisions
from verify.checker.reading import RejectedError
from verify.claims.formula import And, Or
from verify.claims.region_files import everywhere
from verify.claims.relations import alike
from verify.kinds import MACHINE
from verify.question import Budgets
from verify.result import Verdict
from verify.states.state import sample
from verify.verdicts.differences import difference, differing_leaves, example

pytestmark = pytest.mark.solver


def changed(rng, policy):
    """A policy's tree: as it is, with another action at a leaf, with a threshold beside one, or another tree."""
    tree, kind = policy.tree, rng.random()
    splits = np.flatnonzero((tree.feature != ir.NO_FEATURE) & (np.abs(tree.threshold) > 1e-30))
    if kind < 0.25:
        return tree
    if kind < 0.6 or not len(splits):
        action = tree.action.copy()
        leaf = rng.choice(ir.leaves(tree))
        action[leaf] = (action[leaf] + 1 + rng.integers(len(policy.actions) - 1)) % len(policy.actions)
        return replace(tree, action=action)
    if kind < 0.8:
        threshold = tree.threshold.copy()
        node = rng.choice(splits)
        threshold[node] = np.nextafter(threshold[node], np.float32(rng.choice([-np.inf, np.inf])))
        return replace(tree, threshold=threshold)
    return nested(teams.wild(rng, policy, 3))


def pairs(wanted=lambda case: True):
    """(case about both profiles for the judge, first, second, region)."""
    for seed in itertools.count():
        asked = questions.drawn(seed)
        if asked.case.semantics != MACHINE or asked.case.eps or not wanted(asked.case):
            continue
        first, rng = asked.question.profile, np.random.default_rng(seed)
        policies = tuple(replace(one, tree=changed(rng, one), grown=None) for one in first.agents)
        yield case_of(asked.case, second := replace(first, agents=policies)), first, second, asked.question.region


def case_of(case, second):
    """The agents of the second profile beside the first's, in a team of their own."""
    told = reading.read(policy_json.dumps(second)).agents
    others = tuple(replace(one, name=f"{one.name} second", team="second") for one in told)
    return replace(case, profile=replace(case.profile, agents=(*case.profile.agents, *others)))


def names_of(profile):
    return [policy.agent for policy in profile.agents]


def leaves_of(case, states, goal, agent):
    """The leaves of an agent in the first and the second profile, [batch] each, and where its actions differ."""
    at = case.at(states, goal)
    both = [case.profile.agent(name) for name in (agent, f"{agent} second")]
    leaves = [reading.leaves(one, at, MACHINE) for one in both]
    actions = [one.action[own] for one, own in zip(both, leaves, strict=True)]
    return leaves[0], leaves[1], actions[0] != actions[1]


def exactly(row, names):
    """The exact numbers of a state by name, and 0 by the name ""."""
    return {name: Fraction(value) for name, value in places.described(row, names).items()} | {"": Fraction(0)}


def inside(bounds, at):
    """Whether a state lies in a zone; `at` as `exactly` gives it."""
    gaps = ((at[a] - at[b], most, below) for (a, b), (most, below) in bounds.items())
    return all(gap < most or (gap == most and not below) for gap, most, below in gaps)


def within(region, at):
    """Whether a state lies in a region; `at` as `exactly` gives it."""
    return (
        all(low <= at[name] <= high for name, (low, high) in region.box.items())
        and all(low <= at[a] - at[b] <= high for a, b, (low, high) in region.differences)
        and all(max(abs(at[f"{a}.{x}"] - at[f"{b}.{x}"]) for x in "xy") >= d for a, b, d in region.apart)
    )


def check_states(case, found, states, goal):
    """Each state is in exactly one zone of each agent that acts differently there, and that zone names its leaves."""
    seen = 0
    for one in found.agents:
        first, second, other = leaves_of(case, states, goal, one.agent)
        zones = [(zone, zone.failing.bounds(zone.branch)) for zone in one.zones if zone.failing.goal == goal]
        for row, state in enumerate(states.tolist()):
            at = exactly(state, case.names)
            if not within(found.question.region, at):
                continue
            here = [differing_leaves(found, zone) for zone, bounds in zones if inside(bounds, at)]
            assert here == ([(first[row], second[row])] if other[row] else [])
            seen += bool(other[row])
    return seen


def test_zones_are_where_the_judge_sees_different_actions():
    """At and beside the edges of tests and regions; leaves, thresholds and whole trees were changed."""
    seen, verdicts = 0, []
    for number, (case, first, second, region) in enumerate(itertools.islice(pairs(), 40)):
        found = difference(first, second, names_of(first), region)
        verdicts += [one.verdict for one in found.agents]
        for goal in case.goals:
            own = replace(case, profile=reading.read(policy_json.dumps(first if number % 2 else second)))
            states = places.sampled(own, goal, np.random.default_rng(number))
            if len(states):
                seen += check_states(case, found, states[::5], goal)
    assert seen > 300 and {Verdict.PROVED, Verdict.VIOLATED} <= {*verdicts}


@pytest.mark.slow
def test_small_regions_are_answered_as_enumeration_does():
    """Regions with at most one free coordinate on each axis: the judge lists a state of every cell."""
    said = []
    for case, first, second, region in itertools.islice(pairs(places.enumerable), 60):
        cells = [(goal, places.cells(case, goal)) for goal in case.goals]
        if any(states is None for _, states in cells):
            continue
        found = difference(first, second, names_of(first), region)
        for one in found.agents:
            other, some = False, False
            for goal, states in cells:
                inner = [row for row in states if within(region, exactly(row.tolist(), case.names))]
                some |= bool(inner)
                other |= bool(inner) and bool(leaves_of(case, np.array(inner), goal, one.agent)[2].any())
            if some:
                assert one.verdict is (Verdict.VIOLATED if other else Verdict.PROVED)
                said.append(one.verdict)
            else:  # real states at most
                assert one.verdict is not Verdict.VIOLATED
    assert said.count(Verdict.VIOLATED) > 5 and said.count(Verdict.PROVED) > 20


# --- shares and examples


def acting(profile, agent, coordinates):
    policy = profile.policy(agent)
    return ir.act(policy, observe(policy.features, coordinates, profile.world, policy.numbers))


def planted(profile, agent="agent_0", seed=0):
    """The profile with another action at one leaf that some state of the start region reaches."""
    policy, (coordinates, _) = profile.policy(agent), sample(everywhere(profile), profile.world, 2_000, seed)
    reached = ir.apply(policy.tree, observe(policy.features, coordinates, profile.world, policy.numbers))
    leaf = int(np.bincount(reached).argmax())
    action = policy.tree.action.copy()
    action[leaf] = (action[leaf] + 1) % len(policy.actions)
    return with_tree(profile, agent, replace(policy.tree, action=action)), leaf


def with_tree(profile, agent, tree):
    agents = tuple(replace(one, tree=tree, grown=None) if one.agent == agent else one for one in profile.agents)
    return replace(profile, agents=agents)


def test_a_planted_leaf_is_found_and_measured(profile):
    second, leaf = planted(profile)
    found = difference(profile, second, names_of(profile), everywhere(profile))
    by_agent = {one.agent: one for one in found.agents}
    assert found.verdict is Verdict.VIOLATED
    assert {name for name, one in by_agent.items() if one.verdict is Verdict.VIOLATED} == {"agent_0"}
    one = by_agent["agent_0"]
    assert {differing_leaves(found, zone) for zone in one.zones} == {(leaf, leaf)} and one.complete
    coordinates, _ = sample(everywhere(profile), profile.world, 200_000, 5)
    counted = (acting(profile, "agent_0", coordinates) != acting(second, "agent_0", coordinates)).mean()
    assert one.span[0] == one.span[1] == found.together[0] == found.together[1]
    assert abs(float(one.span[0]) - counted) < 0.005 and counted > 0.01
    for zone in one.zones:
        state = example(found.question, zone)
        at = state.coordinates(profile)
        assert acting(profile, "agent_0", at) != acting(second, "agent_0", at)


def test_the_share_of_some_agent_counts_each_state_once(profile):
    second, _ = planted(planted(profile)[0], "agent_1", 1)
    found = difference(profile, second, names_of(profile), everywhere(profile))
    coordinates, _ = sample(everywhere(profile), profile.world, 200_000, 6)
    other = [acting(profile, name, coordinates) != acting(second, name, coordinates) for name in names_of(profile)]
    least, most = found.together
    assert least == most and abs(float(least) - np.any(other, axis=0).mean()) < 0.005
    assert least < sum(one.span[0] for one in found.agents)


def test_the_share_of_some_agent_counts_zones_without_a_float64_state(profile):
    """Doubles far out are too coarse for the adversary's zone; agents read places of their own, so shares multiply."""
    trees = {"adversary_0": (0, 1e-20, LEFT, UP), "agent_0": (3, 0.2, UP, DOWN), "agent_1": (4, 0.1, UP, DOWN)}
    changed = {"adversary_0": (0, 2e-20, LEFT, UP), "agent_0": (3, 0.2, UP, STAY), "agent_1": (4, 0.1, STAY, DOWN)}
    first, second = (
        with_trees({name: tree((at, cut, 1, 2), *acts) for name, (at, cut, *acts) in own.items()}, profile)
        for own in (trees, changed)
    )
    region, far = everywhere(first), (Fraction(2**20), Fraction(2**20 + 1))
    region = replace(region, box=dict(region.box) | {"landmark_0.x": far, "adversary_0.x": far})
    found = difference(first, second, names_of(first), region)
    assert [one.verdict for one in found.agents] == [Verdict.UNKNOWN, Verdict.VIOLATED, Verdict.VIOLATED]
    none = Fraction(1)
    for one in found.agents:
        assert 0 < one.span[0] == one.span[1]
        none *= 1 - one.span[0]
    assert found.together == (1 - none, 1 - none)


def test_a_threshold_beside_another_is_found(profile):
    tree = towards(0, 0)
    threshold = tree.threshold.copy()
    threshold[2] = np.nextafter(threshold[2], np.float32(1))
    first = team(profile, tree, towards(0, 1))
    second = team(profile, replace(tree, threshold=threshold), towards(0, 1))
    found = difference(first, second, ["agent_0"], everywhere(first))
    state = found.agents[0].example.coordinates(first)
    assert found.verdict is Verdict.VIOLATED and 0 < found.together[0] < Fraction(1, 10**6)
    assert acting(first, "agent_0", state) != acting(second, "agent_0", state)


def test_trees_that_differ_as_texts_may_act_alike(profile):
    """A split whose sides do the same, and a leaf that no state reaches."""
    split = {"feature": [2, -1, -1], "threshold": [0.1, 0, 0], "left": [1, -1, -1], "right": [2, -1, -1]}
    twice = ir.Tree(**{key: np.array(value) for key, value in split.items()}, action=np.array([-1, UP, UP]))
    once = ir.Tree(*(np.array([value]) for value in (-1, 0, -1, -1, UP)))
    beyond = replace(twice, threshold=np.array([9.0, 0, 0]), action=np.array([-1, UP, DOWN]))
    first, second = team(profile, twice, beyond), team(profile, once, once)
    found = difference(first, second, ["agent_0", "agent_1"], everywhere(first))
    assert found.verdict is Verdict.PROVED and found.certificate is not None and found.branches > 0
    assert found.together == (0, 0)


# --- budgets and errors


def test_budgets_are_counts_and_said(profile):
    second = team(profile, towards(0, 0), towards(1, 1))
    short = difference(
        profile, second, ["agent_0"], everywhere(profile), budgets=Budgets(max_nodes=1, option="--max-nodes")
    )
    assert short.verdict is Verdict.UNKNOWN and "--max-nodes" in short.agents[0].reason
    few = difference(profile, second, ["agent_0"], everywhere(profile), budgets=Budgets(max_cells=1))
    whole = difference(profile, second, ["agent_0"], everywhere(profile))
    least, most = few.agents[0].span
    assert few.verdict is Verdict.VIOLATED and not few.agents[0].complete and "--effort" in few.agents[0].reason
    assert 0 < least < whole.agents[0].span[0] == whole.agents[0].span[1] < most == 1


def test_profiles_that_cannot_be_compared_are_refused(profile):
    agents = names_of(profile)

    def other(**members):
        policies = tuple(replace(one, **members) if one.agent == "agent_0" else one for one in profile.agents)
        return replace(profile, agents=policies)

    own = profile.policy("agent_0")
    mute = tuple(replace(one, meaning=None) for one in own.features)
    cases = [
        (replace(profile, agents=profile.agents[:-1]), "the second profile has no agent agent_1"),
        (other(features=own.features[::-1]), "agent_0 has different features in the two profiles"),
        (other(actions=own.actions[::-1]), "agent_0 has different actions in the two profiles"),
        (other(team="others"), "agent_0 has a different team in the two profiles"),
        (replace(profile, world=replace(profile.world, dt=0.2)), "different worlds: dt"),
    ]
    for second, said in cases:
        with pytest.raises(InputError, match=said):
            difference(profile, second, agents, everywhere(profile))
    with pytest.raises(UnknownNameError, match="agent_7"):
        difference(profile, profile, ["agent_7"], everywhere(profile))
    with pytest.raises(InputError, match="has no meaning"):
        difference(other(features=mute), other(features=mute), agents, everywhere(profile))


def test_long_sums_are_decided_by_the_solver_alone():
    from tests.support.meanings import with_meanings

    base = with_meanings({f"agent_{k}": towards(0, 0) for k in (0, 1)})
    feature = replace(base.policy("agent_0").features[0], meaning=ir.Meaning(((1.0, "agent_0.x"), (1.0, "agent_1.x"))))
    policy = base.policy("agent_0")
    sums = replace(policy, features=(feature, *policy.features[1:]))
    split = {"feature": [0, -1, -1], "threshold": [0.1, 0, 0], "left": [1, -1, -1], "right": [2, -1, -1]}
    tree = ir.Tree(**{key: np.array(value) for key, value in split.items()}, action=np.array([-1, UP, DOWN]))
    first = replace(base, agents=tuple(sums if one is policy else one for one in base.agents))
    first = with_tree(first, "agent_0", tree)
    second = with_tree(first, "agent_0", replace(tree, action=np.array([-1, UP, STAY])))
    found = difference(first, second, ["agent_0"], everywhere(first))
    assert found.verdict is Verdict.VIOLATED and "Z3 decides alone" in found.agents[0].reason
    state = found.agents[0].example.coordinates(first)
    assert acting(first, "agent_0", state) != acting(second, "agent_0", state)
    same = difference(first, first, ["agent_0"], everywhere(first))
    assert same.verdict is Verdict.PROVED and same.certificate is None


# --- certificates


@pytest.fixture(scope="module")
def proved(profile):
    """Two texts of one team, and the certificate that they act alike."""
    second = replace(profile, provenance=replace(profile.provenance, seed=profile.provenance.seed + 1))
    found = difference(profile, second, names_of(profile), everywhere(profile))
    assert found.verdict is Verdict.PROVED
    return profile, second, found.certificate


def test_a_certificate_is_read_back_and_accepted(proved):
    first, second, certificate = proved
    again = read_game(to_json(certificate))
    assert again == certificate and decisions.check_certificate(again, first, second) > 0
    stated = json.loads(to_json(certificate))
    assert stated["against"] == policy_json.content_hash(second)


def test_agents_may_be_named_in_any_order_and_twice(proved):
    first, second, certificate = proved
    found = difference(first, second, [*reversed(names_of(first)), "agent_0"], everywhere(first))
    assert found.certificate == certificate and [one.agent for one in found.agents] == names_of(first)


def test_a_certificate_is_about_both_profiles(proved):
    first, second, certificate = proved
    for profiles in ((first, None), (first, first), (second, second), (second, first)):
        with pytest.raises(InputError):
            decisions.check_certificate(certificate, *profiles)


def test_no_proof_shows_what_is_false(proved):
    """The proof for a twin, and each way to change one byte of it, for a team that acts differently in one leaf."""
    first, _, certificate = proved
    second, _ = planted(first)
    forged = altered(certificate, against=policy_json.content_hash(second))
    rng, refused = np.random.default_rng(4), 0
    for _ in range(150):
        with pytest.raises(RejectedError):
            decisions.check_certificate(forged, first, second)
        refused += 1
        goal = list(certificate.proof.proofs)[int(rng.integers(len(certificate.proof.proofs)))]
        proof = bytearray(certificate.proof.proofs[goal])
        proof[int(rng.integers(len(proof)))] = int(rng.integers(128))
        forged = altered(forged, proofs={**certificate.proof.proofs, goal: bytes(proof)})
    assert refused == 150


def test_a_certificate_claims_nothing_but_that_agents_act_alike(proved):
    first, second, certificate = proved
    whole = certificate.claim.formula
    others = [
        Or(whole.parts),
        And((*whole.parts, *whole.parts)),
        And(tuple(reversed(whole.parts))),
        And(tuple(Or(part.parts[:-1]) for part in whole.parts)),
        And(()),
    ]
    for stated in others:
        with pytest.raises((RejectedError, InputError)):
            decisions.check_certificate(altered(certificate, formula=stated), first, second)
    with pytest.raises(RejectedError):
        decisions.check_certificate(altered(certificate, eps=Fraction(1, 100)), first, second)
    fewer = alike(first, names_of(first)[:1])
    with pytest.raises(RejectedError):  # another claim needs another proof
        decisions.check_certificate(altered(certificate, formula=fewer), first, second)
