"""How to cut the start, step a period and join sets, so that the checker's sweep shows a claim about a flow.

Does: tries plans, the cheap ones first: whole starts with frames, cuts of the start, sets joined in ever smaller cells,
  by levels or all of one width.
Assumes: a checked profile, system and claim about continuous time.
Does not: prove: a plan that is found here is run again as a certificate.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from itertools import count
from math import floor, log2

import numpy as np

from codegen.ir import NO_FEATURE, PolicyProfile
from verify.checker.covers.boxes import StartBox, halves
from verify.checker.flows.sweep import FEW as FEW_SETS
from verify.checker.flows.sweep import PARTS, FlowSweep, LevelSweep, Plan, SeenStep
from verify.checker.reading import RejectedError
from verify.checker.systems.proofs import WHOLE, FlowSets
from verify.reach.covering import CutPart
from verify.spending import SET, tell_spent
from verify.systems.claims import SystemClaim
from verify.systems.expressions import Name, affine, names
from verify.systems.system import System

CURVED = ((4, 1), (5, 2), (6, 4), (8, 8), (8, 20))  # order of the series and steps of a period
STRAIGHT = ((12, 1), (12, 4), (12, 16), (12, 50))
FIRST = 20_000  # sets for cuts of the start at first, and for cells of one width; four times as many in each round
MANY = FEW_SETS  # sets of a part at each step, beyond which it is cut and not followed further
ASIDE = 0.125  # how much the width of a variable counts on which no decision depends
WIDER = 64.0  # times are cells of levels in a variable that moves nothing of what the claim bounds
CELLS = tuple(range(2, 7))  # into how many parts, as powers of two, what episodes range over is cut
JOINS = 6  # samples, at every so many of which sets are joined by levels; or at the first one only
NEARLY = 2 / 3  # of the boxes of a level: where so many were shown, the next one may take all sets that are left
MAX_LEVELS, LEVELLED = 10, 5  # of cells, and variables that are cut by them
LEVELLED_FROM = 2  # the place of the first level's cells: wider ones seldom show anything, and a few sets take as long
MAX_POWER = 18  # of 2: cells of a list that could be followed, if a set ranged over all of them
MAX_DEPTH = 20  # of cuts of the start
NARROW = 1e-200
FEW = 8  # parts that are looked at for what would help
AT_ONCE = 128  # parts that are swept together
SMALLER = "a start region in smaller parts: a larger --effort"


class _Trying:
    """The progress with one order and number of steps: cuts of the start so far, their parts that are still to be shown
    and those that cannot be cut further; the levels and cells that may still show it.
    """

    def __init__(self, how: tuple[int, int], whole: StartBox) -> None:
        self.how, self.whole, self.root = how, whole, CutPart(whole)
        self.pending, self.lost = [self.root], list[CutPart]()
        self.cells: list[dict[int, float]] | None = None
        self.levels = list[LevelSweep]()

    @property
    def goes_on(self) -> bool:
        """True if more sets may help."""
        return self.cells is None or bool(self.pending or self.cells or self.levels)


class PlanSearch:
    """The search for one plan. `spent`: sets so far; `open`: parts of the start that were left open at last; `why`."""

    def __init__(self, profile: PolicyProfile, system: System, claim: SystemClaim, most: int) -> None:
        assert system.flow is not None
        self.sweep = FlowSweep(profile, system, claim)
        self._names = [one.name for one in system.variables]
        self._most, self._steps = most, max(claim.steps, 1)
        tested: set[str] = set()  # variables that trees test, and cases
        for policy in profile.agents:
            for place in {int(each) for each in policy.tree.feature if each != NO_FEATURE}:
                feature = system.features[policy.agent][policy.features[place].name]
                tested |= {name for name, _ in feature.form.terms}
        tested = {each.get(name, name) for name in tested for each in system.flow.seen}
        whens = [half for case in system.flow.cases for half in case.when]
        self._tested = tested | {name for half in whens for name, _ in half.form.terms}
        deciding = _moving(self._tested, system)
        bounded = {name for region in claim.regions for half in region for name, _ in half.form.terms}
        # what the claim hangs on by decisions alone, if at all
        self._apart = set(self._names) - _moving(bounded, system)
        kept = system.flow.kept  # what starts as another variable is cut with it
        weights = {name: 1.0 if name in deciding else ASIDE for name in self._names} | dict.fromkeys(kept, 0.0)
        self._weights = np.array([weights[name] for name in self._names])
        self.open: list[StartBox] = []
        self.why = ""
        self.how = CURVED[0]
        straight = all(affine(rate) is not None for each in system.flow.each for rate in each.rates.values())
        self._hows = STRAIGHT if straight else CURVED

    @property
    def spent(self) -> int:
        """Sets that were asked about, over all attempts; few sets of a step count as more."""
        return self.sweep.spent

    def plans(self) -> Iterator[FlowSets]:
        """Proofs that show the claim, the cheap ones first: in each turn with one more way to step, and with more sets
        for those of before.
        """
        whole, tries, pending = self.sweep.whole, list[_Trying](), list(self._hows)
        if whole is None:
            return
        for turn in count():
            while pending and len(tries) <= turn:
                self.how = how = pending.pop(0)
                if self._find_open([whole], Plan((), *how), self._once) == []:
                    yield FlowSets(*how, {}, WHOLE)
                # If some starts alone are left open, tubes are too wide, and no cut helps. They may also become too
                # many sets to say so, before these are joined in cells.
                points = [whole.low, whole.high, 0.5 * whole.low + 0.5 * whole.high]
                alone = [StartBox(point, point) for point in points]
                open_ = self._find_open(alone, Plan((), *how), max(FIRST, self._once))
                if open_ != []:
                    self.open = [whole]
                if not open_:
                    tries.append(_Trying(how, whole))
            tries = [each for each in tries if each.goes_on]
            if not tries and not pending:
                return
            for number, each in enumerate(tries):
                self.how = each.how
                if self._left <= self._once:
                    return
                yield from self._by(whole, each, max(FIRST, self._once) * 4 ** max(turn - number, 0))

    def _by(self, whole: StartBox, trying: _Trying, allowed: int) -> Iterator[FlowSets]:
        """Proofs with one order and number of steps: cuts, cells of what is tested, levels, cells of all in turn."""
        how = trying.how
        cuts = self._by_cuts(trying, min(allowed, self._left))
        if cuts is not None:
            yield FlowSets(*how, {}, cuts)
        if trying.cells is None:
            trying.cells = list(self._cells(whole, how))
            trying.levels = list(self._levels(trying.cells, how))
        few = [widths for widths in trying.cells if len(widths) < max(map(len, trying.cells))]
        yield from self._by_cells(few, trying, allowed)
        for levels in tuple(trying.levels):
            if self._descend(levels, 4 * allowed if levels.plan.every == JOINS else allowed):
                yield self._name_widths(levels.plan, levels.levels)
            if levels.levels >= MAX_LEVELS:
                trying.levels.remove(levels)
        yield from self._by_cells([widths for widths in trying.cells if widths not in few], trying, allowed)

    def _by_cells(self, cells: Sequence[dict[int, float]], trying: _Trying, allowed: int) -> Iterator[FlowSets]:
        """Proofs with cells of one width; those that left something open are not tried again."""
        for widths in cells:
            plan = Plan((), *trying.how, widths)
            open_ = self._find_open([trying.whole], plan, min(allowed, self._left))
            if open_ == []:
                yield self._name_widths(plan)
            if open_ is None:  # narrower cells take more sets
                return
            assert trying.cells is not None
            trying.cells.remove(widths)

    def _name_widths(self, plan: Plan, levels: int = 0) -> FlowSets:
        widths = {self._names[column]: Fraction(width) for column, width in plan.widths.items()}
        return FlowSets(plan.order, plan.steps, widths, WHOLE, plan.every, levels)

    def _levels(self, cells: Sequence[dict[int, float]], how: tuple[int, int]) -> Iterator[LevelSweep]:
        """Sweeps by levels, which begin with wide cells of all variables."""
        full = [widths for widths in cells if len(widths) == max(map(len, cells))]
        first = full[min(LEVELLED_FROM, len(full) - 1)] if full else {}
        widest = {
            column: width * (WIDER if self._names[column] in self._apart else 1) for column, width in first.items()
        }
        for every in (JOINS, self.sweep.last) if 0 < len(widest) <= LEVELLED and self.sweep.last > JOINS else ():
            yield LevelSweep(self.sweep, Plan((0,), *how, widest, every, 1))

    def _descend(self, levels: LevelSweep, allowed: int) -> bool:
        """Follows as many levels as show the claim; whether they do, as they may take too many sets where most boxes of
        the level before were not shown.
        """
        self.sweep.most = self.sweep.spent + min(allowed, self._left)
        try:
            while levels.levels < MAX_LEVELS:
                if levels.share > NEARLY:
                    self.sweep.most = self.sweep.spent + self._left
                if levels.descend():
                    return True
                self.why = levels.why or self.why
        except RejectedError as error:
            self.why = str(error)
        finally:
            tell_spent(SET * self.spent, SET * self._most)
        return False

    @property
    def _once(self) -> int:
        """The number of sets that following a part once may take, with steps that are made again in parts."""
        return (MANY + PARTS) * self._steps * self.how[1]

    @property
    def _left(self) -> int:
        return max(self._most - self.spent, 0)

    def _find_open(self, parts: Sequence[StartBox], plan: Plan, allowed: int) -> list[int] | None:
        """The parts that are left open, by their places; None where that took too many sets."""
        self.sweep.spent += len(parts)  # what is left open at once counts too, so that a search ends
        self.sweep.most = self.spent + min(allowed, self._left)
        try:
            self.sweep.follow(parts, plan)
        except RejectedError as error:
            self.why = str(error)
            return None
        finally:
            tell_spent(SET * self.spent, SET * self._most)
        self.why = next(iter(self.sweep.open.values()), self.why)
        return sorted(self.sweep.open)

    def _by_cuts(self, trying: _Trying, allowed: int) -> bytes | None:
        """Cuts of the start after which all of its parts are shown; None where some are left open, in `pending`."""
        end = self.spent + allowed
        each = self._once
        while trying.pending and end - self.spent >= each:
            count = min(AT_ONCE, (end - self.spent) // each)
            some, trying.pending = trying.pending[:count], trying.pending[count:]
            open_ = self._find_open([part.box for part in some], Plan((), *trying.how), each * len(some))
            for part in some if open_ is None else [some[place] for place in open_]:
                halved = part.cut(trying.whole, self._weights, MAX_DEPTH)
                trying.pending += halved
                trying.lost += [] if halved else [part]
        self.open = [part.box for part in (*trying.lost, *trying.pending)]
        if self.open:
            trying.pending = [] if trying.lost else trying.pending
            return None
        return trying.root.cuts

    def _cells(self, whole: StartBox, how: tuple[int, int]) -> Iterator[dict[int, float]]:
        """Widths of cells, the wide ones first: of the variables that are tested, then of all."""
        low, high = whole.low.copy(), whole.high.copy()

        def see(told: SeenStep) -> None:
            if told.after.low.size:
                np.minimum(low, np.where(np.isfinite(told.after.low), told.after.low, low).min(axis=0), out=low)
                np.maximum(high, np.where(np.isfinite(told.after.high), told.after.high, high).max(axis=0), out=high)

        self.sweep.watch = see
        shares = np.random.default_rng(0).random((FEW, len(low)))
        points = whole.low + shares * (whole.high - whole.low)
        self._find_open([StartBox(point, point) for point in points], Plan((), *how), FIRST)
        self.sweep.watch = None
        scale = high - low  # about how far each variable ranges at samples
        ranging = [column for column in range(len(scale)) if scale[column] > NARROW]
        tested = [column for column in ranging if self._names[column] in self._tested]
        for columns in (tested, ranging) if tested != ranging else (ranging,):
            for power in CELLS:
                if columns and power * len(columns) <= MAX_POWER:
                    yield {column: 2.0 ** (floor(log2(scale[column])) - power) for column in columns}

    def helps(self) -> list[str]:
        """Lists what would show parts that are left open, the best first, by a try with some of them."""
        some, (order, steps) = self.open[:FEW], self.how
        if not some:
            return []
        again = self._share_open(some, order, steps)
        if not again:  # each alone is shown
            return [SMALLER]
        shares = {
            SMALLER: self._share_open([half for one in some for half in self._halve_box(one)], order, steps),
            "a shorter period, or more steps of it": self._share_open(some, order, 3 * steps),
            "a series of higher order": self._share_open(some, order + 4, steps),
        }
        return [words for words in sorted(shares, key=lambda words: shares[words]) if shares[words] < again]

    def _share_open(self, parts: Sequence[StartBox], order: int, steps: int) -> float:
        """The share of some parts that are left open."""
        open_ = self._find_open(parts, Plan((), order, steps), FIRST)
        return 1.0 if open_ is None else len(open_) / len(parts)

    def _halve_box(self, one: StartBox) -> list[StartBox]:
        boxes = [one]
        for column in range(len(one.low)):
            if one.high[column] > one.low[column]:
                boxes = [half for each in boxes for half in halves(each, column)]
        return boxes if len(boxes) <= 64 else boxes[:64]


def _moving(some: set[str], system: System) -> set[str]:
    """Some variables, such as those that are tested, and all that move them."""
    assert system.flow is not None
    moving, before = set(some), -1
    while len(moving) > before:
        before = len(moving)
        for name in tuple(moving):
            for flow in system.flow.each:
                moved = (flow.rates[name], flow.jumps.get(name, Name(name)))
                moving |= {each for one in moved for each in names(one)} & flow.rates.keys()
    return moving
