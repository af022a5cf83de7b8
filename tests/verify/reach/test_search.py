"""Proofs made step by step: the checker follows each of them to its end, merged or not, and no other one."""

from fractions import Fraction as F

import numpy as np
import pytest

from tests.support.altered import altered
from tests.support.system_cases import balancing, double_integrator, form, pendulum, stays, switching
from tests.verify.reach.random_systems import case
from verify.certificates.proofs import encode_numbers
from verify.checker.certificate import numbers
from verify.checker.reading import RejectedError
from verify.checker.systems.branch_proofs import BITS, Proof, SystemQuestions
from verify.reach.decide import whole
from verify.reach.play import Starts, courses
from verify.reach.replay import replay_course
from verify.reach.search import Merging, ReachBudgetError, SystemProver, Unfolding
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
