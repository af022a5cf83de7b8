"""Trajectories by scipy never leave the sets of a sweep: at the ends of steps, and in tubes between them.

Sweeps by levels: marked boxes hold what episodes do, and what is not shown is left open.

Certificates of flows: written and read, and refused where anything in them was changed for another claim.
"""

from dataclasses import replace
from fractions import Fraction as F

import numpy as np
import pytest

from codegen.errors import InputError
from codegen.policy_json import content_hash
from tests.support.altered import altered, of_hashes
from tests.support.flows import CASES, EXACTLY, NEAR, SIDES, case, off_by, outside, starts_of, trajectories, watched
from tests.support.system_cases import box
from verify.certificates.proofs import encode_numbers
from verify.certificates.systems import to_json
from verify.checker.accept import accept
from verify.checker.flows.sweep import FlowSweep, LevelSweep, Plan
from verify.checker.reading import RejectedError
from verify.checker.systems.proofs import FlowSets, from_json
from verify.systems import documents
from verify.systems.claims import Pattern

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
    claim = NEAR.replace("[-2, 2]", "[0.9, 1.1]")
    plan = Plan((0,), 6, 40)
    assert FlowSweep(*_exactly(claim + "at_samples = true\n")).run(plan) > 0
    with pytest.raises(RejectedError, match="in period 0 a state may be out of the region"):
        FlowSweep(*_exactly(claim)).run(plan)


@pytest.mark.parametrize(("says", "beyond"), [("stays_in", "[{}, 2]"), ("avoids", "[-2, {}]")])
def test_a_step_is_asked_in_parts_where_its_tube_is_too_wide(says, beyond):
    """One of 40 steps a turn ends near -1, and its tube goes on to -1.003; one of 39 has -1 between its ends."""
    tubes = watched(FlowSweep(*_exactly(NEAR)), Plan((0,), 6, 40))
    assert min(low[:, 0].min() for _, along in tubes.values() for low, _ in along) < -1.001
    holds, fails = (NEAR.replace("stays_in", says).replace("[-2, 2]", beyond.format(x)) for x in (-1.0005, -0.9999))
    assert FlowSweep(*_exactly(holds)).run(Plan((0,), 6, 40)) == len(tubes)
    for steps in (39, 40):
        with pytest.raises(RejectedError, match="in period 0 a state may be"):
            FlowSweep(*_exactly(fails)).run(Plan((0,), 6, steps))


def _exactly(claim):
    system, profile, claim = case(EXACTLY, SIDES, claim)
    return profile, system, claim


@pytest.mark.parametrize("cuts", [(1, 0), (3, 0, 0), (0, 0), ()])
def test_cuts_that_are_none_are_refused(cuts):
    system, profile, claim = case(*CASES["pendulum"])
    with pytest.raises(RejectedError, match="the cuts of the start"):
        FlowSweep(profile, system, claim).run(Plan(cuts, 4, 1))


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
        assert off_by(boxes, starts if at == 0 else states[at - 1, -1]) < 1e-9
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
    assert levels.levels == 5 and sweep.sampled is not None and 0.0 <= levels.share < 1.0


def test_too_many_sets_are_no_level():
    system, profile, claim = case(*CASES["pendulum"])
    sweep = FlowSweep(profile, system, claim)
    levels = LevelSweep(sweep, Plan((0,), 4, 1, WIDE["pendulum"], 4, 2))
    sweep.most = 100
    with pytest.raises(RejectedError, match="more than 100 sets"):
        levels.descend()
    assert levels.levels == 0 and levels.share == 0.0


SYSTEM, TEAM, CLAIM = case(*CASES["pendulum"])


def certificate(**changes):
    start = {"angle": F(11, 10), "spin": F(1, 10)}
    hashes = content_hash(TEAM), documents.content_hash(SYSTEM)
    return altered(of_hashes(*hashes, CLAIM, start, FlowSets(4, 1, {}, encode_numbers([0]))), **changes)


def test_a_certificate_is_read_as_it_was_written():
    wide = {"angle": F(1, 8), "spin": F(1, 4)}
    for made in (
        certificate(),
        certificate(cells={"angle": F(1, 16)}, cuts=encode_numbers([1, 0, 0])),
        certificate(cells=wide, joined_every=4, levels=2),
    ):
        again = from_json(to_json(made))
        assert again == made and again.claim.at_samples is False
        assert accept(again, TEAM, SYSTEM) > 20


@pytest.mark.parametrize("change", [{"profile": "0" * 64}, {"system": "0" * 64}, {"cells": {"speed": F(1)}}])
def test_another_profile_system_or_variable_is_told(change):
    with pytest.raises(InputError):
        accept(certificate(**change), TEAM, SYSTEM)


FORGED = {
    "levels without cells": {"joined_every": 4, "levels": 1},
    "joins without levels": {"cells": {"angle": F(1, 8)}, "joined_every": 4},
    "no level": {"cells": {"angle": F(1, 8)}, "joined_every": 4, "levels": -1},
    "cuts beside levels": {
        "cells": {"angle": F(1, 8)},
        "joined_every": 4,
        "levels": 1,
        "cuts": encode_numbers([1, 0, 0]),
    },
    "too few levels": {"cells": {"angle": F(4), "spin": F(8)}, "joined_every": 1, "levels": 1},
    "order 0": {"order": 0},
    "no steps": {"steps": 0},
    "cuts that end": {"cuts": encode_numbers([1, 0])},
    "cuts that go on": {"cuts": encode_numbers([0, 0])},
    "cells of no width": {"cells": {"angle": F(0)}},
    "cells of a negative width": {"cells": {"angle": F(-1, 8)}},
    "no start": {"inhabitant": {"angle": F(3), "spin": F(0)}},
    "a narrower region": {"claim": replace(CLAIM, regions=(box(angle=(0, F(6, 10))),))},
    "an earlier time": {"claim": replace(CLAIM, by=5)},
    "another pattern": {"claim": replace(CLAIM, pattern=Pattern.AVOIDS, by=0)},
    "a region that is left": {"claim": replace(CLAIM, pattern=Pattern.STAYS_IN, by=0)},
    "a region that is never met": {
        "claim": replace(CLAIM, pattern=Pattern.REACHES, by=0, regions=(box(angle=(2, 3)),))
    },
    "steps without samples": {"claim": replace(CLAIM, at_samples=None)},
}


@pytest.mark.parametrize("name", FORGED)
def test_a_forged_certificate_is_refused(name):
    with pytest.raises(RejectedError):
        accept(certificate(**FORGED[name]), TEAM, SYSTEM)


@pytest.mark.parametrize("count", [4, pytest.param(200, marks=pytest.mark.slow)])
def test_random_forgeries_are_refused_whatever_the_plan(count):
    """Regions that an episode leaves: no plan may show them."""
    random = np.random.default_rng(0)
    for _ in range(count):
        high = F(int(random.integers(20, 62)), 100)
        plan = {
            "order": int(random.integers(1, 9)),
            "steps": int(random.integers(1, 3)),
            "cells": {} if random.random() < 0.5 else {"angle": F(1, int(random.integers(4, 40)))},
            "cuts": encode_numbers([[0], [1, 0, 0], [2, 0, 0]][random.integers(3)]),
        }
        claim = replace(CLAIM, regions=(box(angle=(0, high)),), at_samples=bool(random.random() < 0.5))
        with pytest.raises(RejectedError):
            accept(certificate(claim=claim, **plan), TEAM, SYSTEM)


def test_a_system_in_steps_has_no_such_certificate():
    with pytest.raises(InputError, match="moves in steps"):
        accept(certificate(), TEAM, replace(SYSTEM, flow=None))
