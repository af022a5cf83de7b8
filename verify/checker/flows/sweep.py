"""The sweep of a claim about a flow: sets that hold every state at all times, each of which has to meet the claim.

Does: cuts the start as a proof says, joins sets where it says so, sends them down the trees at each sample, cuts them
  by cases, makes the jumps of samples, moves them through a period in steps, and asks the claim of every set at samples
  and of every tube between them; answers the same of single boxes, for replays; says whether a certificate fits a
  profile and a system, and its sets show the claim.
Assumes: steps.py, samples.py and covers bound what they are asked; a certificate that anyone made.
Does not: read documents (../systems/proofs.py), or choose how to cut, join and step.

A tube around a step reaches beyond the states in it by as much as they may bend in that step. Where it may break the
claim and the end of the step does not, the step is made again in parts, whose tubes are asked instead.

Sets are joined at all samples in cells of one width, or by levels: cells become narrower where wider ones did not show
the claim. A level has boxes at each sample where sets are joined. What leaves them lies in boxes of this level at the
next such sample, or in marked boxes of levels before. A box is marked if all that was followed of it up to that sample
met the claim, and so are all boxes of its level that hold what left it. So every episode that is in a marked box at its
sample meets the claim from then on. At the next level, whose cells are half as wide, only what lies in no such box is
followed. Numbers of cells are hashed to find boxes; whether they hold a part is asked of bounds.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from codegen.errors import InputError
from codegen.ir import Bool, Float64, Int64, PolicyProfile
from verify.checker.certificate import REMAKE, numbers
from verify.checker.covers.boxes import BoxList, Parts, Regions, StartBox, cut, least_of_runs, multipliers, widths_of
from verify.checker.covers.rounding import around, ceiling, ensure_arithmetic, floor
from verify.checker.covers.trees import choices_of, split_by_trees
from verify.checker.flows.intervals import Spans
from verify.checker.flows.samples import PACE, FlowCases, LateTrees, pace_flow, pace_of
from verify.checker.flows.series import FlowReading, Stepping
from verify.checker.flows.steps import EXACT, FlowStep, Moved, SetList, beside, build_frames, build_sets
from verify.checker.reading import RejectedError
from verify.checker.systems.branch_proofs import ensure_asked
from verify.checker.systems.proofs import FlowSets, SystemCertificate
from verify.systems.claims import SystemClaim
from verify.systems.expressions import Name
from verify.systems.system import System

MAX_PARTS = 1 << 18  # of the start
AT_ONCE = 1 << 11  # parts that are swept together
MAX_SETS, MAX_CUT = 1 << 18, 1 << 20  # of one list; boxes before they are joined
MAX_SWEPT = 50_000_000  # sets over all steps
FEW = 50  # sets, fewer of which take as long
PARTS = 8  # of a step whose tube may break the claim
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
    """The motion of the sets of one case: steps between samples, parts of a step, and what jumps at a sample."""

    step: FlowStep
    part: FlowStep
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
        self._regions = Regions(claim.regions, self.columns)
        self._start = Parts(system, MAX_PARTS, AT_ONCE)
        self._flow, self._pace = system.flow, pace_of(system.flow)
        self._flows = [pace_flow(each) for each in system.flow.each]
        self._readings = [FlowReading(each, names) for each in self._flows]
        self._errors = [[each.error.get(name, EXACT) for name in names] for each in self._flows]
        self.jumps: list[FlowStep | None] = []  # None where nothing jumps
        for each in self._flows:
            reading = FlowReading(replace(each, rates={x: each.jumps.get(x, Name(x)) for x in names}), names)
            self.jumps.append(FlowStep(reading, (), Stepping(1, Fraction(1))) if each.jumps else None)
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
        how = Stepping(plan.order, self._flow.period / plan.steps)
        if how not in self._moves:
            of = zip(self._readings, self._errors, self.jumps, strict=True)
            part = how._replace(seconds=how.seconds / PARTS)
            self._moves[how] = [
                _Move(FlowStep(reading, errors, how), FlowStep(reading, errors, part), jump)
                for reading, errors, jump in of
            ]
        moves, joins = self._moves[how], plan.widths and not plan.levels
        with np.errstate(all="ignore"):  # what overflows is not finite, and is left open
            for period in range(first, end + (end == self.last)):
                sets = sets.join_by_cell(plan.widths) if joins else sets
                if self.sampled is not None:
                    self.sampled(period, sets)
                if self._claim.says.once:
                    sets = self._outside(sets)
                else:
                    sets = self._drop_broken(sets, self._breaks(sets.box, period), f"at sample {period}")
                if period == self.last or not sets.size:
                    break
                boxes = split_by_trees(self._trees, sets.numbered)
                sets = sets.narrow_to(boxes)
                if sets.size > MAX_SETS:
                    raise RejectedError(f"a list has more than {MAX_SETS:,} sets")
                sets = self._drop_bad(sets, self._cases.beyond(sets.numbered), NOT_STATED)
                held = zip(self._cases.within(sets.numbered), moves, strict=True)
                sets = beside([self._through(sets.narrow_to(each), move, plan, period) for each, move in held])
        if end == self.last and self._claim.says.once and sets.size:
            self._leave(sets, np.ones(sets.size, dtype=np.bool_), "an episode may not get into the region")
        return sets

    def _through(self, sets: SetList, move: _Move, plan: Plan, period: int) -> SetList:
        """One period. Beside the frames of their start, sets have one of the sample, which is dropped after it."""
        inside = sets._replace(frames=(build_frames(sets.box), *sets.frames))
        if move.jump is not None and sets.size:
            moved = move.jump.jump_sets(inside.box, inside.frames, self.inputs(inside.joint))
            inside = self._keep_shown(inside, moved)
        for number in range(plan.steps):
            if not inside.size:
                break
            self.spent += max(inside.size, FEW)
            if self.spent > self.most:
                raise RejectedError(f"more than {self.most:,} sets")
            self.swept += inside.size
            moved = move.step.move_sets(inside.box, inside.frames, self.inputs(inside.joint))
            after, kept = self._keep_shown(inside, moved), moved.shown & ~moved.empty
            inside, tube = inside.take(kept), moved.tube.at(kept)
            if self.watch is not None:
                self.watch(SeenStep(period, number, inside, tube, after.box))
            broken = self._may_break(inside, moved_to=after.box, tube=tube, part=move.part, period=period)
            inside = self._drop_broken(after, broken, f"in period {period}")
            if self._claim.says.once and not self._claim.at_samples and number + 1 < plan.steps:
                inside = self._outside(inside)
        return inside._replace(frames=inside.frames[1:])

    def _keep_shown(self, sets: SetList, moved: Moved) -> SetList:
        """The sets after a step or jump; those of which it was not shown are left open."""
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
            chosen = [self._flow.held[choice] for choice in choices_of(joint, self._profile.agents)]
            held = {name: around(value) for values in chosen for name, value in values.items()}
            if any(self._flow.jitter):
                held[PACE] = floor(self._pace[0]), ceiling(self._pace[1])
            self._held[joint] = held
        return self._held[joint]

    # --- the claim

    def _may_break(self, sets: SetList, moved_to: Spans, tube: Spans, part: FlowStep, period: int) -> Bool:
        """Returns True for each set of which some state may break the claim in a step: by `tube`, boxes of all states
        in it, and where these are too wide but boxes at the end are not, by tubes of parts of the step.
        """
        if self._claim.at_samples or self._claim.says.once:
            return np.zeros(sets.size, dtype=np.bool_)
        broken = self._breaks(tube, period)
        tried = np.flatnonzero(broken)
        tried = tried[~self._breaks(moved_to.at(tried), period)]
        if not tried.size:
            return broken
        broken[tried] = False
        inputs, box, frames = self.inputs(sets.joint[tried]), sets.box.at(tried), sets.take(tried).frames
        self.spent += PARTS * tried.size
        for _ in range(PARTS):
            moved = part.move_sets(box, frames, inputs)
            broken[tried] |= ~moved.shown | self._breaks(moved.tube, period)
            box, frames = moved.box, moved.frames
        return broken

    def _breaks(self, boxes: Spans, period: int) -> Bool:
        """Returns True for each box of which some state may break the claim."""
        avoided, broken = self._claim.says.avoided, np.zeros(len(boxes.low), dtype=np.bool_)
        if avoided or period >= self._claim.by:
            numbered = BoxList.of(boxes.low, boxes.high, np.arange(len(broken)), np.zeros_like(broken, dtype=np.int64))
            broken[(self._regions.within(numbered) if avoided else self._regions.outside(numbered)).part] = True
        return broken

    def _drop_broken(self, sets: SetList, broken: Bool, when: str) -> SetList:
        """The sets without those of which some state may break the claim."""
        where = "in" if self._claim.says.avoided else "out of"
        return self._drop_bad(sets, broken, f"{when} a state may be {where} the region")

    def _outside(self, sets: SetList) -> SetList:
        """Narrows the sets to what may not lie in the regions."""
        return sets.narrow_to(self._regions.outside(sets.numbered))

    # --- single boxes, [1, variables]

    def surely_outside(self, box: Spans) -> bool:
        """Returns True if no state of a box lies in a region."""
        return self._regions.within(_as_list(box)).size == 0

    def surely_inside(self, box: Spans) -> bool:
        """Returns True if every state of a box lies in a region."""
        return self._regions.outside(_as_list(box)).size == 0

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
        return dict(choices_of(joint, self._profile.agents))

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


def _as_list(box: Spans) -> BoxList:
    none = np.zeros(len(box.low), dtype=np.int64)
    return BoxList.of(box.low, box.high, none, none)


class _Span(NamedTuple):
    """A level between two samples. Its boxes: `hashes` of their cells, sorted, `bounds`, which are `marked`; of what
    came into them, from which box of the span before (`sources`) into which (`targets`).
    """

    hashes: Int64
    bounds: Float64
    marked: Bool
    sources: Int64
    targets: Int64

    def hold(self, parts: BoxList, hashes: Int64) -> Bool:
        """Returns True for each part that lies in a marked box."""
        place = np.minimum(np.searchsorted(self.hashes, hashes), len(self.hashes) - 1)
        inside = (parts.bounds >= self.bounds[place]).all(axis=1)
        return np.asarray((self.hashes[place] == hashes) & self.marked[place] & inside)


class LevelSweep:
    """The levels of a `plan`, whose `levels` says how many it needs; `why`: what was not shown at last."""

    def __init__(self, sweep: FlowSweep, plan: Plan) -> None:
        self._sweep, self.plan, self._told = sweep, plan, sweep.sampled
        self.why = ""
        self._seen: list[tuple[int, SetList]] = []
        self._levels: list[tuple[Mapping[int, float], dict[int, _Span]]] = []

    @property
    def levels(self) -> int:
        """The number of levels followed."""
        return len(self._levels)

    @property
    def share(self) -> float:
        """The share of the last level's boxes that are marked; 0 before the first."""
        marked = [each.marked for _, spans in self._levels[-1:] for each in spans.values()]
        return float(np.concatenate(marked).mean()) if marked else 0.0

    def run(self) -> int:
        """Follows all levels; returns the number of sets asked about. RejectedError where the claim is not shown."""
        shown = [self.descend() for _ in range(self.plan.levels)]
        if not shown[-1]:
            raise RejectedError(self.why)
        return self._sweep.swept

    def descend(self) -> bool:
        """Follows one more level; whether all starts are shown. RejectedError for too many sets; then it was none."""
        widths = {column: width * 0.5**self.levels for column, width in self.plan.widths.items()}
        parts, last, spans = self._sweep.starts, self._sweep.last, dict[int, _Span]()
        seen: list[list[tuple[int, SetList]]] = []
        for first in range(0, max(last, 1), self.plan.every):
            parts, hashes = _hash_cells(self._drop_shown(parts, first), widths)
            if not parts.size:
                break
            order = np.argsort(hashes, kind="stable")
            hashes, parts = hashes[order], parts.take(order)
            begins = np.flatnonzero(np.diff(hashes, prepend=hashes[0] - 1))
            boxes, bounds = np.arange(len(begins)), least_of_runs(parts.bounds, begins)
            marked, targets = boxes >= 0, np.repeat(boxes, np.diff(begins, append=len(hashes)))
            spans[first] = _Span(hashes[begins], bounds, marked, parts.part, targets)
            joined = BoxList(bounds, boxes, np.zeros_like(boxes))
            self._seen = []
            self._sweep.sampled = None if self._told is None else lambda at, sets: self._seen.append((at, sets))
            try:
                begun, end = build_sets(joined, int(self.plan.every > 1)), min(first + self.plan.every, last)
                sets = self._sweep.follow_sets(begun, self.plan, first, end)
            finally:
                self._sweep.sampled = self._told
            parts = BoxList.of(sets.box.low, sets.box.high, sets.part, np.zeros_like(sets.part))
            left = self._sweep.open  # boxes that were not shown up to the end, and why
            marked[list(left)] = False
            self.why = next(iter(left.values()), self.why)
            seen.append(self._seen)
        ordered = list(spans.values())
        for before, after in zip(reversed(ordered[:-1]), reversed(ordered[1:]), strict=True):
            before.marked[after.sources[~after.marked[after.targets]]] = False  # left for a box that is not marked
        self._levels.append((widths, spans))
        if self._told is not None:
            for span, lists in zip(ordered, seen, strict=True):
                for at, sets in lists:
                    self._told(at, sets.take(span.marked[sets.part]))
        return all(span.marked.all() for span in ordered[:1])

    def _drop_shown(self, parts: BoxList, first: int) -> BoxList:
        """Returns the parts that lie in no marked box of the levels before, cut by their cells."""
        for widths, spans in self._levels:
            if first in spans and parts.size:
                parts, hashes = _hash_cells(parts, widths)
                parts = parts.take(~spans[first].hold(parts, hashes))
        return parts


def _hash_cells(parts: BoxList, widths: Mapping[int, float]) -> tuple[BoxList, Int64]:
    """Boxes cut at the bounds of cells, and hashes of the cells that they lie in."""
    parts, cells = cut(parts, widths, MAX_CUT)
    return parts, cells @ multipliers(cells.shape[1])


MAX_ORDER, MAX_STEPS = 30, 1_000
MAX_LEVELS, MAX_EVERY = 20, 1 << 20


def check_certificate(
    certificate: SystemCertificate,
    proof: FlowSets,
    profile: PolicyProfile,
    system: System,
    watch: SetWatch | None = None,
) -> int:
    """Checks a certificate with this proof; the number of its sets over all steps. `watch` is told of the sets, by
    sample.

    InputError when it is about another profile or system, or names what they do not have; RejectedError when its sets
    do not show the claim.
    """
    if system.flow is None:
        raise InputError("the certificate is about continuous time", f"system {system.name} moves in steps", REMAKE)
    ensure_asked(certificate, set(proof.cells), profile, system)
    if certificate.claim.about_decisions or certificate.claim.at_samples is None:
        raise RejectedError("sets of a flow show claims about continuous time only")
    if not 1 <= proof.order <= MAX_ORDER or not 1 <= proof.steps <= MAX_STEPS:
        raise RejectedError(f"the order is not from 1 to {MAX_ORDER}, or the steps are not from 1 to {MAX_STEPS}")
    named = widths_of(proof.cells)
    sweep = FlowSweep(profile, system, certificate.claim)
    sweep.sampled = watch
    widths = {sweep.columns[name]: width for name, width in named.items()}
    cuts, every, levels = list(numbers(proof.cuts)), proof.joined_every, proof.levels
    plan = Plan(cuts, proof.order, proof.steps, widths, every, levels)
    if levels == 0 and every == 1:
        return sweep.run(plan)
    if not widths or cuts != [0] or not 1 <= levels <= MAX_LEVELS or not 1 <= every <= MAX_EVERY:
        raise RejectedError(
            f"the levels are not from 1 to {MAX_LEVELS}, or the samples between joins not from 1 to {MAX_EVERY:,}, "
            "or there are no cells, or cuts beside them"
        )
    return LevelSweep(sweep, plan).run()
