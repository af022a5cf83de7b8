"""Proofs made step by step: the checker follows each of them to its end, merged or not, and no other one.

Hulls of symbolic states: they hold each of their states exactly, say so in short numbers, and are hardly wider.
"""

from contextlib import suppress
from fractions import Fraction as F
from itertools import count

import numpy as np
import pytest

from tests.support.altered import altered
from tests.support.system_cases import balancing, box, double_integrator, form, pendulum, stays, switching
from tests.verify.reach.random_systems import case
from verify.certificates.proofs import encode_numbers
from verify.checker.certificate import numbers
from verify.checker.reading import RejectedError
from verify.checker.systems.branch_proofs import BITS, Proof, SystemQuestions
from verify.checker.systems.reading import UNIT, Branch
from verify.reach import search as searching
from verify.reach.decide import whole
from verify.reach.play import Starts, courses
from verify.reach.replay import replay_course
from verify.reach.search import Hulls, Merging, ReachBudgetError, SystemProver, Unfolding
from verify.systems.claims import Pattern, SystemClaim
from verify.systems.system import HalfSpace

MERGE = Merging(2, 1)


class OpenError(Exception):
    """Something is left open."""


def leave(branch, stated):
    raise OpenError


def proved(system, profile, claim, merging, max_states=20_000):
    """(the part with its proof, what the prover counted); OpenError where it is none."""
    prover = SystemProver(max_states, 20_000, leave)
    return Unfolding(profile, system, claim, whole(system, claim), prover).run(merging), prover


def checked(system, profile, claim, part, proof=None):
    """As the checker follows a proof; RejectedError."""
    answers = Proof(numbers(part.proof if proof is None else proof, BITS))
    SystemQuestions(profile, system, claim, part, answers).run()
    answers.ensure_read()


CASES = {
    "an axis": (double_integrator(axes=1, steps=4), switching(1), {"x": (-2, 2), "vx": (-3, 3)}, 4),
    "errors": (double_integrator(axes=1, error=F(1, 50), steps=4), switching(1), {"x": (-2, 2), "vx": (-3, 3)}, 4),
    "a pendulum": (pendulum(steps=3), balancing(), {"angle": (-1, 1)}, 3),
}


@pytest.mark.parametrize("merging", [None, MERGE, Merging(0, 1), Merging(2, 4)])
@pytest.mark.parametrize("name", CASES)
def test_the_checker_follows_the_proof(name, merging):
    system, profile, bounds, steps = CASES[name]
    claim = stays(system, steps, **bounds)
    part, prover = proved(system, profile, claim, merging)
    checked(system, profile, claim, part)
    assert part.followed == tuple(one.name for one in system.variables)
    assert bool(part.hulls) == (merging is not None)
    assert {hull.step for hull in part.hulls} <= set(range(1, steps + 1)) and prover.states > steps


def test_hulls_keep_the_number_of_symbolic_states_small():
    system, profile = double_integrator(axes=1, steps=7), switching(1)
    claim = stays(system, 7, x=(-4, 4), vx=(-9, 9))
    (_, plain), (_, merged) = (proved(system, profile, claim, merging) for merging in (None, Merging(3, 1)))
    assert merged.states < plain.states / 2


@pytest.mark.parametrize("merging", [None, MERGE])
def test_no_proof_with_another_length_or_fewer_hulls_is_followed(merging):
    system, profile, bounds, steps = CASES["an axis"]
    claim = stays(system, steps, **bounds)
    part, _ = proved(system, profile, claim, merging)
    answers = list(numbers(part.proof, BITS))
    wrong = [(part, encode_numbers(answers[:-1])), (part, encode_numbers([*answers, 0]))]
    wrong += [(altered(part, hulls=part.hulls[:-1]), part.proof)] * bool(part.hulls)
    narrow = tuple(altered(hull, region=(*hull.region, HalfSpace(form(1)))) for hull in part.hulls)
    wrong += [(altered(part, hulls=narrow), part.proof)] * bool(part.hulls)
    for other, proof in wrong:
        with pytest.raises(RejectedError):
            checked(system, profile, claim, other, proof)


@pytest.mark.parametrize("merging", [None, MERGE])
def test_what_does_not_hold_is_left_open(merging):
    system, profile, _, steps = CASES["an axis"]
    with pytest.raises(OpenError):
        proved(system, profile, stays(system, steps, x=(F(-1, 4), F(1, 4))), merging)


def test_a_budget_ends_at_a_symbolic_state():
    system, profile, bounds, steps = CASES["an axis"]
    with pytest.raises(ReachBudgetError, match="a stage") as raised:
        proved(system, profile, stays(system, steps, **bounds), None, 3)
    assert raised.value.branch.step <= steps and not raised.value.all_spent


@pytest.mark.parametrize("merging", [None, MERGE, Merging(1, 2)])
def test_of_random_systems_only_what_no_episode_breaks_is_proved(merging):
    """And each proof is followed. Episodes are sampled, and played exactly."""
    outcomes = {"proved": 0, "open": 0}
    for seed in range(24):
        system, profile, claim = case(np.random.default_rng([seed, 9]))
        if claim.about_decisions:
            continue
        try:
            part, _ = proved(system, profile, claim, merging, 150)
        except (OpenError, ReachBudgetError):
            outcomes["open"] += 1
            continue
        outcomes["proved"] += 1
        checked(system, profile, claim, part)
        for course in courses(profile, system, claim, Starts(50)):
            assert replay_course(profile, system, claim, course) is None, seed
    assert min(outcomes.values()) > 4, outcomes


def test_a_claim_of_no_step_is_about_the_start():
    system, profile, _, _ = CASES["an axis"]
    claim = SystemClaim(Pattern.STAYS_IN, (system.start,), 0)
    part, prover = proved(system, profile, claim, MERGE)
    checked(system, profile, claim, part)
    assert not part.hulls and prover.states == 1


def search_of(system, profile, claim):
    def go_on(branch, stated):
        """What is left open is of no interest here."""

    prover = SystemProver(2_000, 2_000, go_on)
    search = SystemQuestions(profile, system, claim, whole(system, claim), prover)
    return search, Hulls(search, prover.programs)


def level(search, steps):
    """The symbolic states after so many steps."""
    found = list(search.roots())
    for _ in range(steps):
        found = [after for branch in found for after in search.follow_branch(branch)]
    return found


def states_of(branch, rng, most):
    """Some states of a symbolic state: values of its unknowns that its box and rows allow, drawn and at ends."""
    unknowns = sorted({one for weights in branch.motion.weights.values() for one in weights})
    found = []
    for _ in range(most):
        share = rng.choice([0, 1, 2, 3, 4], len(unknowns)) if rng.random() < 0.7 else rng.integers(0, 5, len(unknowns))
        values = {}
        for unknown, part in zip(unknowns, share.tolist(), strict=True):
            span = branch.box.get(unknown, UNIT)
            part = F(min(max(part, int(span.low_open)), 4 - int(span.high_open)), 4)
            values[unknown] = span.low + (span.high - span.low) * part
        if all(_allowed(row, values) for row in branch.rows):
            state = {
                name: branch.at[name] + sum((w * values[one] for one, w in branch.motion.weights[name].items()), F(0))
                for name in branch.at
            }
            found.append(state)
    return found


def _allowed(row, values):
    total = sum(weight * values[unknown] for unknown, weight in row.direction.weights)
    beyond = total - row.end if row.upper else row.end - total
    return beyond < 0 or (beyond == 0 and not row.strict)


def drawn(seed):
    """A maker of hulls for a random system, and its symbolic states after a step or two."""
    for rng in (np.random.default_rng([seed, more]) for more in count()):
        system, profile, claim = case(rng)
        if system.pieces and not claim.about_decisions:
            search, made = search_of(system, profile, claim)
            with suppress(ReachBudgetError):
                branches = level(search, int(rng.integers(1, 3)))[:40]
                if branches:
                    return made, branches, rng
    raise AssertionError("seeds never end")


@pytest.mark.parametrize("seed", range(12))
def test_a_hull_holds_every_state_of_its_branches(seed):
    made, branches, rng = drawn(seed)
    hull = made.hull(branches)
    assert hull.step == branches[0].step
    seen = 0
    for branch in branches:
        for state in states_of(branch, rng, 12):
            seen += 1
            assert all(half.holds(state) for half in hull.region)
    assert seen


@pytest.mark.parametrize("seed", range(12))
def test_groups_are_a_partition_into_so_many_parts(seed):
    made, branches, _ = drawn(seed)
    whole_groups = made.group_branches(branches, 1)
    for parts in (1, 2, 4):
        groups = made.group_branches(branches, parts)
        assert sorted(number for group in groups for number in group) == list(range(len(branches)))
        assert len(whole_groups) <= len(groups) <= parts * len(whole_groups)
        for group in groups:
            assert sum(set(group) <= set(one) for one in whole_groups) == 1, "only what decides alike"


def test_a_box_is_its_own_hull():
    """Bounds that are exact and short stay as they are."""
    system, profile = double_integrator(axes=1), switching(1)
    claim = SystemClaim(Pattern.STAYS_IN, (box(x=(-9, 9)),), 3)
    search, made = search_of(system, profile, claim)
    (start,) = level(search, 0)
    region = {half for half in made.hull([start]).region if len(half.form.terms) == 1}
    assert region >= set(system.start)


def test_numbers_of_hulls_are_short_and_their_slack_is_small():
    rng = np.random.default_rng(3)
    for low, width in rng.uniform(-9, 9, (200, 2)).tolist():
        low, high = F(low), F(low) + abs(F(width))
        below, above = searching._widen_bounds(low, high)
        slack = max(high - low, F(searching.LEAST)) / 2 ** (searching.FINENESS - 2)
        assert low - slack <= below < low and high < above <= high + slack
        assert all(end.denominator & (end.denominator - 1) == 0 for end in (below, above)), "a power of two below"
    assert searching._is_short(F(1, 3)) and not searching._is_short(F(1, 2**40 + 1))


def test_directions_are_each_variable_then_sums_then_what_these_were_before():
    """x and v, and what x was before a step: x + v/5, so that hulls keep how both hang together."""
    system, profile = double_integrator(axes=1), switching(1)
    claim = SystemClaim(Pattern.STAYS_IN, (box(x=(-9, 9)),), 3)
    search, _ = search_of(system, profile, claim)
    found = searching._directions(search)
    assert found[:2] == [((F(1), name),) for name in search.reading.order]
    assert ((F(1), "vx"), (F(5), "x")) in found or ((F(1), "x"), (F(1, 5), "vx")) in found
    assert all(terms[0][0] == 1 for terms in found) and len(found) == len(set(found))
    assert len(found) <= searching.MAX_EACH * len(search.reading.order)


def test_a_branch_is_what_a_step_leads_to():
    """The account of symbolic states above is the system's own: each state after a step is some state's successor."""
    system, profile = double_integrator(axes=1), switching(1)
    claim = SystemClaim(Pattern.STAYS_IN, (box(x=(-9, 9)),), 3)
    search, _ = search_of(system, profile, claim)
    (start,) = level(search, 0)
    assert isinstance(start, Branch)
    for state in states_of(start, np.random.default_rng(0), 20):
        assert all(half.holds(state) for half in system.start)
