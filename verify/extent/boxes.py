"""Regions in which a claim holds and means something.

Does: grows nothing, shrinks: starts from a box around a conflicting world state and cuts counterexamples off until the
  claim is proved; keeps boxes whose conflict share is positive and in which the shuffled control is refuted.
Assumes: a decision procedure that returns models; bounds on a decimal grid, so that region files are short and exact.
Does not: find the largest such region.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from codegen.ir import PolicyProfile
from verify.claims.decisions import DecisionClaim
from verify.claims.region import Interval, Region, Verdict, everywhere
from verify.question import DecisionQuestion, from_start
from verify.solver.decide import decide
from verify.states import shares
from verify.states.state import State, sample, state_at

GRID = Fraction(1, 100)
CUTS = 60  # counterexamples that are cut off before a seed is given up
SEEDS_DRAWN = 20_000
TRIAL_SAMPLES = 4_000


@dataclass(frozen=True)
class Found:
    """A proved box: the region, its conflict share (of TRIAL_SAMPLES states), its share of the start volume."""

    region: Region
    conflict: float
    volume: float


def proved_boxes(profile: PolicyProfile, claim: DecisionClaim, seed: int) -> Iterator[Found]:
    """Boxes in which the claim is proved, the conflict share is positive and the shuffled control is refuted.

    One conflicting world state after another, drawn with `seed`, serves as the centre; yields while there are any.
    """
    question, start = from_start(profile, claim), everywhere(profile)
    coordinates, goals = sample(start, profile.world, SEEDS_DRAWN, seed)
    conflicting = shares.conflicts(question, coordinates)
    if conflicting is None:
        return
    for row in np.flatnonzero(conflicting & ~shares.violating(question, coordinates)):
        centre = state_at(start, profile.world, coordinates[row], int(goals[row]))
        region = shrunk(question, centre)
        if region is None:
            continue
        share = shares.measure(question.within(region), seed, TRIAL_SAMPLES).conflict
        conflict = share.value if share else 0.0
        if conflict and decide(question.within(region).control).verdict is Verdict.VIOLATED:
            yield Found(region, conflict, _volume(region, start))


def best_proved_box(profile: PolicyProfile, claim: DecisionClaim, seed: int, candidates: int = 6) -> Found | None:
    """Of the first boxes found, the one with the most conflicting volume; None when there is none."""
    boxes = [found for _, found in zip(range(candidates), proved_boxes(profile, claim, seed), strict=False)]
    return max(boxes, key=lambda found: found.conflict * found.volume, default=None)


def shrunk(question: DecisionQuestion, centre: State) -> Region | None:
    """A box around `centre` (goal fixed) in which the claim is proved, cut out of the region; None when cuts run out.

    Each counterexample is cut off on the coordinate on which it is farthest from the centre, halfway between them.
    """
    box = dict(question.region.box)
    goals = () if centre.goal is None else (centre.goal,)
    for _ in range(CUTS):
        region = Region(box, goals, name="shrunk")
        decision = decide(question.within(region))
        if decision.verdict is Verdict.PROVED:
            return region
        if decision.answer is None or decision.answer.model is None:
            return None
        cut = _cut(box, centre, decision.answer.model)
        if cut is None:
            return None
        box |= cut
    return None


def _cut(box: dict[str, Interval], centre: State, model: dict[str, Fraction]) -> dict[str, Interval] | None:
    name = max(model, key=lambda key: abs(model[key] - Fraction(centre.position[key])))
    middle = Fraction(centre.position[name])
    halfway = (model[name] + middle) / 2
    low, high = box[name]
    if model[name] > middle:
        face = Fraction(int(halfway / GRID // 1)) * GRID  # rounded away from the counterexample
        return {name: (low, face)} if middle <= face < model[name] else None
    face = -Fraction(int(-halfway / GRID // 1)) * GRID
    return {name: (face, high)} if model[name] < face <= middle else None


def _volume(region: Region, start: Region) -> float:
    """The region's share of the start region's volume."""
    share = 1.0
    for name, (low, high) in region.box.items():
        least, most = start.box[name]
        share *= float((high - low) / (most - least)) if least < most else 1.0
    return share
