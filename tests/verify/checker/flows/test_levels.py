"""Sweeps by levels: marked boxes hold what episodes do, and what is not shown is left open."""

from dataclasses import replace
from fractions import Fraction as F

import numpy as np
import pytest

from tests.support.flows import CASES, case, starts_of, trajectories
from tests.support.system_cases import box
from verify.checker.flows.sweep import FlowSweep, LevelSweep, Plan
from verify.checker.reading import RejectedError

WIDE = {"pendulum": {0: 0.25, 1: 0.5}, "mixed": {0: 0.5, 1: 0.5, 2: 0.5}, "turning": {0: 0.5, 1: 0.5}}


@pytest.mark.parametrize("every", [1, 4, 50])
@pytest.mark.parametrize("name", CASES)
def test_told_sets_hold_all_episodes(name, every):
    system, profile, claim = case(*CASES[name])
    sweep, told = FlowSweep(profile, system, claim), {}
    sweep.sampled = lambda at, sets: told.setdefault(at, []).append(sets.box)
    levels = LevelSweep(sweep, Plan((0,), 4, 2, WIDE[name], every, 1))
    shown = any(levels.descend() for _ in range(6))
    assert shown and sweep.swept > 0
    starts = starts_of(system, 60, np.random.default_rng(0))
    states = trajectories(system, profile, starts, 2)
    for at, boxes in told.items():
        points = starts if at == 0 else states[at - 1, -1]
        low, high = (np.concatenate(ends) for ends in zip(*boxes, strict=True))
        off = np.maximum(low[None] - points[:, None], points[:, None] - high[None]).max(axis=2).min(axis=1)
        assert off.max() < 1e-9
    assert set(told) == set(range(claim.steps + 1))


def test_what_fails_is_shown_by_no_level():
    system, profile, claim = case(*CASES["pendulum"])
    claim = replace(claim, regions=(box(angle=(0, F(6, 10))),))
    sweep = FlowSweep(profile, system, claim)
    told = []
    sweep.sampled = lambda at, sets: told.append(sets.size)
    levels = LevelSweep(sweep, Plan((0,), 4, 1, WIDE["pendulum"], 4, 5))
    with pytest.raises(RejectedError, match="out of the region"):
        levels.run()
    assert levels.levels == 5 and sweep.sampled is not None


def test_too_many_sets_are_no_level():
    system, profile, claim = case(*CASES["pendulum"])
    sweep = FlowSweep(profile, system, claim)
    levels = LevelSweep(sweep, Plan((0,), 4, 1, WIDE["pendulum"], 4, 2))
    sweep.most = 100
    with pytest.raises(RejectedError, match="more than 100 sets"):
        levels.descend()
    assert levels.levels == 0
