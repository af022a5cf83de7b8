"""The sweep of a claim about a flow: sets that hold every state at all times, each of which has to meet the claim.

Does: cuts the start as a proof says, joins sets where it says so, sends them down the trees at each sample, cuts them
  by cases, makes the jumps of samples, moves them through a period in steps, and asks the claim of every set at samples
  and of every tube between them; answers the same of single boxes, for replays.
Assumes: steps.py, cases.py, covers/trees.py and covers/cuts.py bound what they are asked.
Does not: read documents, or choose how to cut, join and step.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from codegen.ir import Bool, Int64, PolicyProfile
from verify.checker.covers.boxes import BoxList
from verify.checker.covers.cuts import RegionCut, linear
from verify.checker.covers.parts import Parts, StartBox
from verify.checker.covers.rounding import ceiling, ensure_arithmetic, floor
from verify.checker.covers.trees import digits, split_by_trees
from verify.checker.flows.cases import FlowCases
from verify.checker.flows.programs import Stepping
from verify.checker.flows.sampling import PACE, LateTrees, pace_flow, pace_of
from verify.checker.flows.series import FlowReading
from verify.checker.flows.sets import SetList, beside, build_sets
from verify.checker.flows.spans import Spans
from verify.checker.flows.steps import EXACT, FlowStep, build_frames
from verify.checker.reading import RejectedError
from verify.systems.claims import SystemClaim
from verify.systems.expressions import Name
from verify.systems.system import Flow, System

MAX_PARTS = 1 << 18  # of the start
AT_ONCE = 1 << 11  # parts that are swept together
MAX_SETS = 1 << 18  # of one list
MAX_SWEPT = 50_000_000  # sets over all steps
FEW = 50  # sets, fewer of which take as long
NOT_SHOWN = "no enclosure of its states over a step was shown"
NOT_STATED = "a state may be where nothing says how it moves"


@dataclass(frozen=True)
class Plan:
    """The way in which a claim is shown. `cuts`: of the start, as covers have them; `widths`: of cells, by column, in
    which sets are joined at samples; none: sets keep the frames of their start. `order` of the series, `steps` of a
    period. `levels`: how often cells become narrower, beginning with `widths`, 0 for one list of cells; then sets are
    joined at `every` so many samples.
    """

    cuts: Sequence[int]
    order: int
    steps: int
    widths: Mapping[int, float] = field(default_factory=dict[int, float])
    every: int = 1
    levels: int = 0


class SeenStep(NamedTuple):
    """A step of a period: its number, its sets, boxes of all states in it, and boxes of those at its end."""

    period: int
    step: int
    sets: SetList
    tube: Spans
    after: Spans


class _Move(NamedTuple):
    """The motion of the sets of one case: steps between samples, and what jumps at one."""

    step: FlowStep
    jump: FlowStep | None


Watch = Callable[[SeenStep], None]
SetWatch = Callable[[int, SetList], None]  # told of the sets at every sample


class FlowSweep:
    """The sweep for one claim. `open`: the parts that were not shown, by their numbers, and why; `watch` is told of
    every step, for drawings and tests, `sampled` of the sets at every sample; `swept` sets so far, which took
    as long as `spent` sets of long lists, at most `most`.
    """

    def __init__(self, profile: PolicyProfile, system: System, claim: SystemClaim) -> None:
        assert system.flow is not None
        self._system, self._claim, self._profile = system, claim, profile
        names = [one.name for one in system.variables]
        self.columns = {name: column for column, name in enumerate(names)}
        self._trees = [LateTrees(system, policy, self.columns) for policy in profile.agents]
        self._regions = [RegionCut(list(map(linear, region)), self.columns) for region in claim.regions]
        self._start = Parts(system, MAX_PARTS, AT_ONCE)
        self._flow, self._pace = system.flow, pace_of(system.flow)
        self._flows = [pace_flow(each) for each in system.flow.each]
        self._readings = [FlowReading(each, names) for each in self._flows]
        self._errors = [[each.error.get(name, EXACT) for name in names] for each in self._flows]
        self.jumps = [_jump_of(each, names) for each in self._flows]
        self._cases = FlowCases(system, self.columns)
        self._held: dict[int, dict[str, tuple[float, float]]] = {}
        self._moves: dict[Stepping, list[_Move]] = {}
        self.swept, self.spent, self.most = 0, 0, MAX_SWEPT
        self.open: dict[int, str] = {}
        self.watch: Watch | None = None
        self.sampled: SetWatch | None = None

    def run(self, plan: Plan) -> int:
        """Counts the sets asked about. RejectedError where one may break the claim, or could not be followed."""
        ensure_arithmetic()
        for starts in self._start.cut(plan.cuts):
            self.follow(starts, plan)
            if self.open:
                raise RejectedError(next(iter(self.open.values())))
        return self.swept

    def follow(self, starts: Sequence[StartBox], plan: Plan) -> None:
        """Follows parts of the start; `open` has those that were not shown."""
        kept = 0 if plan.widths else 1
        self.follow_sets(build_sets(self._start.box_starts(starts), kept), plan, 0, self.last)

    def follow_sets(self, sets: SetList, plan: Plan, first: int, end: int) -> SetList:
        """Follows sets from a sample to a later one, where they are not asked about unless it is the last; `open` has
        the parts that were not shown.
        """
        self.open = {}
        moves, joins = self._find_moves(plan), plan.widths and not plan.levels
        with np.errstate(all="ignore"):  # what overflows is not finite, and is left open
            for period in range(first, end + (end == self.last)):
                sets = sets.join_by_cell(plan.widths) if joins else sets
                if self.sampled is not None:
                    self.sampled(period, sets)
                sets = self._ask_at_sample(sets, period)
                if period == self.last or not sets.size:
                    break
                boxes = split_by_trees(self._trees, sets.numbered)
                sets = self._limit_sets(sets.narrow_to(boxes))
                sets = self._drop_bad(sets, self._cases.beyond(sets.numbered), NOT_STATED)
                held = zip(self._cases.within(sets.numbered), moves, strict=True)
                sets = beside([self._through(sets.narrow_to(each), move, plan, period) for each, move in held])
        if end == self.last and self._claim.says.once and sets.size:
            self._leave(sets, np.ones(sets.size, dtype=np.bool_), "an episode may not get into the region")
        return sets

    def _find_moves(self, plan: Plan) -> list[_Move]:
        """Returns the motion of the sets of each case."""
        how = Stepping(plan.order, self._flow.period / plan.steps)
        if how not in self._moves:
            of = zip(self._readings, self._errors, self.jumps, strict=True)
            self._moves[how] = [_Move(FlowStep(reading, errors, how), jump) for reading, errors, jump in of]
        return self._moves[how]

    def _through(self, sets: SetList, move: _Move, plan: Plan, period: int) -> SetList:
        """One period. Beside the frames of their start, sets have one of the sample, which is dropped after it."""
        inside = self._jump_sets(sets._replace(frames=(build_frames(sets.box), *sets.frames)), move.jump)
        for number in range(plan.steps):
            if not inside.size:
                break
            self.spent += max(inside.size, FEW)
            if self.spent > self.most:
                raise RejectedError(f"more than {self.most:,} sets")
            self.swept += inside.size
            moved = move.step.move_sets(inside.box, inside.frames, self.inputs(inside.joint))
            self._leave(inside, ~moved.shown, NOT_SHOWN)
            kept = moved.shown & ~moved.empty
            inside = inside.take(kept)
            tube, frames = moved.tube.at(kept), tuple(frame.at(kept) for frame in moved.frames)
            after = SetList(moved.box.at(kept), frames, inside.part, inside.joint)
            if self.watch is not None:
                self.watch(SeenStep(period, number, inside, tube, after.box))
            inside = self._ask_in_period(after, tube, period, number + 1 == plan.steps)
        return inside._replace(frames=inside.frames[1:])

    def _jump_sets(self, sets: SetList, jump: FlowStep | None) -> SetList:
        """The sets after what jumps at a sample."""
        if jump is None or not sets.size:
            return sets
        moved = jump.jump_sets(sets.box, sets.frames, self.inputs(sets.joint))
        self._leave(sets, ~moved.shown, NOT_SHOWN)
        kept = moved.shown & ~moved.empty
        frames = tuple(frame.at(kept) for frame in moved.frames)
        return SetList(moved.box.at(kept), frames, sets.part[kept], sets.joint[kept])

    def inputs(self, joint: Int64) -> dict[str, Spans]:
        """Returns the inputs held in each set."""
        numbers, of = np.unique(joint, return_inverse=True)
        known = [self._of_joint(int(number)) for number in numbers]
        names = list(known[0]) if known else []
        return {
            name: Spans(*(np.array([each[name][side] for each in known])[of.reshape(len(joint))] for side in (0, 1)))
            for name in names
        }

    def _of_joint(self, joint: int) -> dict[str, tuple[float, float]]:
        if joint not in self._held:
            held: dict[str, tuple[float, float]] = {}
            for policy, action in zip(self._profile.agents, digits(joint, self._trees), strict=True):
                values = self._flow.held[policy.agent, policy.actions[action].name]
                held |= {name: (floor(value), ceiling(value)) for name, value in values.items()}
            if any(self._flow.jitter):
                held[PACE] = floor(self._pace[0]), ceiling(self._pace[1])
            self._held[joint] = held
        return self._held[joint]

    # --- the claim

    def _ask_at_sample(self, sets: SetList, period: int) -> SetList:
        """The sets that are followed further from a sample."""
        says, claim = self._claim.says, self._claim
        if says.once:
            return self._outside(sets)
        if says.avoided:
            return self._none(sets, self._in_some(sets.numbered), f"at sample {period} a state may be in the region")
        if period < claim.by:
            return sets
        return self._none(sets, self._beyond(sets.numbered), f"at sample {period} a state may be out of the region")

    def _ask_in_period(self, sets: SetList, tube: Spans, period: int, last: bool) -> SetList:
        """The sets after a step that are followed further. `tube`: boxes of all states in the step."""
        says, claim = self._claim.says, self._claim
        if claim.at_samples:
            return sets
        if says.once:
            return sets if last else self._outside(sets)
        along = BoxList.of(tube.low, tube.high, np.arange(sets.size), sets.joint)
        if says.avoided:
            return self._none(sets, self._in_some(along), f"in period {period} a state may be in the region")
        if period < claim.by:
            return sets
        return self._none(sets, self._beyond(along), f"in period {period} a state may be out of the region")

    def _none(self, sets: SetList, boxes: BoxList, why: str) -> SetList:
        """The sets without those of which boxes were found."""
        bad = np.zeros(sets.size, dtype=np.bool_)
        bad[boxes.part] = True
        return self._drop_bad(sets, bad, why)

    def _beyond(self, boxes: BoxList) -> BoxList:
        for region in self._regions:
            boxes = region.outside(boxes)
        return boxes

    def _in_some(self, boxes: BoxList) -> BoxList:
        lists = [region.within(boxes) for region in self._regions]
        return BoxList(*(np.concatenate(column) for column in zip(*lists, strict=True)))

    def _outside(self, sets: SetList) -> SetList:
        """Narrows the sets to what may not lie in the regions."""
        return sets.narrow_to(self._beyond(sets.numbered))

    # --- single boxes, [1, variables]

    def surely_outside(self, box: Spans) -> bool:
        """Returns True if no state of a box lies in a region."""
        return self._in_some(_as_list(box)).size == 0

    def surely_inside(self, box: Spans) -> bool:
        """Returns True if every state of a box lies in a region."""
        return self._beyond(_as_list(box)).size == 0

    def only_action(self, box: Spans, way: int = 0) -> int | None:
        """The joint action in all states of a box, where all observations are late in one way; None where there are
        several.
        """
        joints = np.unique(split_by_trees([tree.ways[way] for tree in self._trees], _as_list(box)).joint)
        return int(joints[0]) if len(joints) == 1 else None

    def cases_of(self, box: Spans) -> list[int]:
        """The cases that hold every state of a box; none where another one may hold some of them."""
        boxes = _as_list(box)
        met = [number for number, each in enumerate(self._cases.within(boxes)) if each.size]
        return met if set(met) <= set(self._cases.surely(boxes)) else []

    def name_actions(self, joint: int) -> dict[str, str]:
        """A joint action by names."""
        chosen = zip(self._profile.agents, digits(joint, self._trees), strict=True)
        return {policy.agent: policy.actions[action].name for policy, action in chosen}

    # --- parts that are left open

    def _leave(self, sets: SetList, bad: Bool, why: str) -> None:
        for part in np.unique(sets.part[bad]).tolist():
            self.open.setdefault(part, why)

    def _drop_bad(self, sets: SetList, bad: Bool, why: str) -> SetList:
        """The sets of all other parts, without those that are bad."""
        if not bad.any():
            return sets
        self._leave(sets, bad, why)
        return sets.take(~bad)

    def _limit_sets(self, sets: SetList) -> SetList:
        if sets.size > MAX_SETS:
            raise RejectedError(f"a list has more than {MAX_SETS:,} sets")
        return sets

    @property
    def last(self) -> int:
        """The number of the last sample."""
        return self._claim.steps

    @property
    def starts(self) -> BoxList:
        """Boxes around all starts, which are one part."""
        return self._start.box_starts([box for boxes in self._start.cut([0]) for box in boxes])

    @property
    def whole(self) -> StartBox | None:
        """A box around all starts; None where bounds show that there are none."""
        return self._start.whole


def _jump_of(flow: Flow, names: Sequence[str]) -> FlowStep | None:
    """Returns the step that moves sets at samples; None where nothing jumps."""
    if not flow.jumps:
        return None
    values = {name: flow.jumps.get(name, Name(name)) for name in names}
    return FlowStep(FlowReading(replace(flow, rates=values), names), (), Stepping(1, Fraction(1)))


def _as_list(box: Spans) -> BoxList:
    none = np.zeros(len(box.low), dtype=np.int64)
    return BoxList.of(box.low, box.high, none, none)
