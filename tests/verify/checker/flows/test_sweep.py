"""Trajectories by scipy never leave the sets of a sweep: at the ends of steps, and in tubes between them."""

import numpy as np
import pytest

from tests.support.flows import CASES, NEAR, case, outside, starts_of, trajectories, watched
from verify.checker.flows.sweep import FlowSweep, Plan
from verify.checker.reading import RejectedError

PLANS = {
    "whole": Plan((0,), 4, 2),
    "order 2": Plan((0,), 2, 4),
    "cut": Plan((1, 2, 0, 0, 0), 6, 1),
    "cells": Plan((0,), 4, 2, {0: 0.0625, 1: 0.125}),
}


@pytest.mark.parametrize("plan", PLANS)
@pytest.mark.parametrize("name", CASES)
def test_no_trajectory_leaves_the_sets(name, plan):
    system, profile, claim = case(*CASES[name])
    plan, random = PLANS[plan], np.random.default_rng(0)
    seen = watched(FlowSweep(profile, system, claim), plan)
    starts = starts_of(system, 60, random)
    ends = np.array([[float(end) for end in system.flow.error.get(one.name, (0, 0))] for one in system.variables])
    errors = ends[:, 0] + np.round(random.random(starts.shape)) * (ends[:, 1] - ends[:, 0])
    states = trajectories(system, profile, starts, plan.steps, errors)
    assert len(seen) == claim.steps * plan.steps
    assert outside(seen, states, 0) <= 1e-9
    between = trajectories(system, profile, starts, 3 * plan.steps, errors)
    for part in range(3):
        assert outside(seen, between[:, part::3], 1) <= 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_a_hundred_thousand_trajectories_stay(name):
    system, profile, claim = case(*CASES[name])
    seen, random = watched(FlowSweep(profile, system, claim), PLANS["whole"]), np.random.default_rng(1)
    for _ in range(34):
        starts = starts_of(system, 1_000, random)
        assert outside(seen, trajectories(system, profile, starts, 2), 0) <= 1e-9


def test_a_claim_that_a_trajectory_breaks_is_refused():
    text, profile, claim = CASES["pendulum"]
    system, profile, claim = case(text, profile, claim.replace("[0, 1]", "[0, 0.6]"))
    for plan in PLANS.values():
        with pytest.raises(RejectedError, match="a state may be out of the region"):
            FlowSweep(profile, system, claim).run(plan)


def test_between_samples_a_claim_may_fail():
    """x = cos t meets 1 at whole turns, so at samples a turn apart; between them it does not."""
    text, profile, _ = CASES["turning"]
    text = text.replace("error = { x = 0.001, y = [-0.002, 0.001] }", "").replace('"0.5 s"', '"6.283185307 s"')
    text = text.replace("[0.9, 1.1]", "1").replace("[-0.1, 0.1]", "0").replace("0.2", "0").replace("= 12", "= 2")
    claim = NEAR.replace("[-2, 2]", "[0.9, 1.1]")
    plan = Plan((0,), 6, 40)
    assert FlowSweep(*_asked(text, profile, claim + "at_samples = true\n")).run(plan) > 0
    with pytest.raises(RejectedError, match="in period 0 a state may be out of the region"):
        FlowSweep(*_asked(text, profile, claim)).run(plan)


def _asked(text, profile, claim):
    system, profile, claim = case(text, profile, claim)
    return profile, system, claim


@pytest.mark.parametrize("cuts", [(1, 0), (3, 0, 0), (0, 0), ()])
def test_cuts_that_are_none_are_refused(cuts):
    system, profile, claim = case(*CASES["pendulum"])
    with pytest.raises(RejectedError, match="the cuts of the start"):
        FlowSweep(profile, system, claim).run(Plan(cuts, 4, 1))
