"""All claims about a team in a stated system, decided together: one search, one budget.

Does: the order of work. Boxes that cover all episodes come first, for all claims at once; episodes are played in what
  these leave open; then each claim in turn gets a stage of symbolic states and linear programs, and so on.
Assumes: a checked profile, system and claims.
Does not: read or write files.

The order does not depend on the budget, which only says when to stop. So whatever a budget answers, a larger one
answers too, after the same work. Where a claim has no answer at the end, episodes are played beyond the budget: what
these break, a larger budget answers by them or before, and may take longer.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from fractions import Fraction

import numpy as np

from codegen.ir import Float64, PolicyProfile
from codegen.policy_json import content_hash
from verify.boxes.covering import CoveredClaims, Covering, Search
from verify.certificates.proofs import encode_numbers
from verify.checker.covers.certificates import CoverCertificate, check_together
from verify.checker.reading import RejectedError
from verify.question import Budgets
from verify.reach.forever.lasting import lasting
from verify.reach.formwise import formwise
from verify.reach.play.samples import Starts, courses
from verify.reach.play.shrinking import shrink_counterexample
from verify.reach.replay import replay_course
from verify.reach.results import OpenState, ReachOutcome, about_nothing
from verify.reach.symbolic import Allowed, SymbolicSearch, helping, open_state, start_of
from verify.reach.unfolding import Merging
from verify.reach.witnesses import inhabitant
from verify.result import Verdict
from verify.spending import OPTION, BudgetSpentError, Spending
from verify.systems import documents
from verify.systems.claims import SystemClaim
from verify.systems.system import System

STAGES = (  # how symbolic states are merged, and the symbolic states and linear programs that are tried at first
    (None, 50_000, 2_000),  # without errors bounds settle most questions
    (Merging(16, 1), 20_000, 30_000),
    (Merging(64, 4), 20_000, 30_000),
    (Merging(256, 16), 40_000, 30_000),
)
GROWTH = 4  # of what is tried, once no stage had enough
FIRST_SAMPLES = 256  # episodes that are played before anything is proved, where no boxes are tried
LASTING = 2_000_000  # boxes for an invariant


@dataclass
class Together:
    """The claims, numbered in order, with the answers so far. Claims for ever are decided one by one."""

    profile: PolicyProfile
    system: System
    claims: Sequence[SystemClaim]
    budgets: Budgets
    _found: dict[int, ReachOutcome] = field(default_factory=dict[int, ReachOutcome])
    _open: dict[int, OpenState] = field(default_factory=dict[int, OpenState])

    def __post_init__(self) -> None:
        self.spending = Spending(self.budgets.max_boxes)
        self._left = dict(enumerate(self.claims))  # by number
        self._start: Mapping[str, Fraction] | Verdict | None = None
        self._searches: dict[int, SymbolicSearch] = {}
        self._work = self._run_stages()

    def outcome(self, number: int) -> ReachOutcome:
        """The answer to a claim, with what was spent on all until it was known."""
        while number not in self._found:
            next(self._work)
        return self._found[number]

    def _settle(self, number: int, outcome: ReachOutcome) -> None:
        spent = self.spending
        counts = {"states": spent.states, "programs": spent.programs, "boxes": outcome.boxes or spent.boxes}
        self._found[number] = replace(outcome, **counts)
        del self._left[number]

    def _run_stages(self) -> Iterator[None]:
        """All work, with a pause wherever a claim may have been settled."""
        samples = self.budgets.samples
        still, ever, moving = self._groups()
        try:
            if self.budgets.covers:
                yield from self._try_covers(moving)
            else:
                self._play(moving, self._first)
            self._play((*still, *ever), self._first)
            yield
            for number in ever:
                self._for_ever(number)
                yield
            if samples > FIRST_SAMPLES:
                self._play(still if self.budgets.covers else (*still, *moving), Starts(samples))
            yield from self._symbolic()
        except BudgetSpentError:
            self._play_last(tuple(self._left))
            for number in tuple(self._left):
                self._settle(number, self._report_spent(number))
        yield

    def _groups(self) -> tuple[tuple[int, ...], tuple[int, ...], tuple[int, ...]]:
        """Claims about decisions, about all steps, and about some steps."""
        says = [claim.says for claim in self.claims]
        still = tuple(number for number, each in enumerate(says) if each.still)
        ever = tuple(number for number, each in enumerate(says) if each.ever)
        return still, ever, tuple(number for number in range(len(says)) if number not in (*still, *ever))

    # --- boxes

    def _try_covers(self, asked: Sequence[int]) -> Iterator[None]:
        """PROVED where boxes that the checker accepts cover all episodes; VIOLATED by a start of a part left open."""
        claims = [self.claims[number] for number in asked]
        if not claims:
            return
        by_forms = formwise(self.profile, self.system, claims)
        search = Search(self.profile, self.system, claims, self.spending, by_forms)
        for cover in search.iterate_covers():
            if isinstance(cover, CoveredClaims):
                self._accept([asked[place] for place in cover.claims], cover.covering)
            else:
                self._play_open({asked[place]: parts for place, parts in cover.parts.items()}, cover.played)
            search.left &= {place for place, number in enumerate(asked) if number in self._left}
            yield

    def _accept(self, numbers: Sequence[int], covering: Covering) -> None:
        """Settles the claims whose cover the checker accepts; a razor-thin one it refuses, as it rounds outward. Those
        whose lists are the same are checked by one sweep, and one by one where it refuses that.
        """
        state = self._inhabitant
        if isinstance(state, Verdict):
            for number in numbers:
                self._settle(number, about_nothing(self.claims[number], state))
            return
        hashes = content_hash(self.profile), documents.content_hash(self.system)
        cuts = encode_numbers(covering.cuts)
        covers = {
            number: CoverCertificate(*hashes, self.claims[number], state, covering.widths, cuts, covering.forms)
            for number in numbers
        }
        alike = [] if covering.forms else [number for number in numbers if not self.claims[number].says.once]
        groups = [alike] if len(alike) > 1 else []
        for group in (*groups, *([number] for number in numbers)):
            left = [number for number in group if number in self._left]
            with suppress(RejectedError):
                shown = check_together([covers[number] for number in left], self.profile, self.system) if left else []
                for number, count in zip(left, shown, strict=True):
                    self._settle(number, ReachOutcome(Verdict.PROVED, certificate=covers[number], branches=count))

    @property
    def _inhabitant(self) -> Mapping[str, Fraction] | Verdict:
        """A start, for claims about episodes."""
        if self._start is None:
            about = next(claim for claim in self.claims if not claim.about_decisions)
            self._start = inhabitant(self.system, about)
        return self._start

    # --- episodes

    def _play_open(self, open_: Mapping[int, tuple[Float64, Float64]], played: int) -> None:
        """VIOLATED where one of some episodes from what is left open breaks a claim."""
        names = [one.name for one in self.system.variables]
        for number, (low, high) in open_.items():
            ends = zip(names, low[0].tolist(), high[0].tolist(), strict=True)
            self._open[number] = OpenState(0, {name: (least, most) for name, least, most in ends})
        lows, highs = (np.concatenate(ends) for ends in zip(*open_.values(), strict=True))
        some = np.linspace(0, len(lows) - 1, min(len(lows), played)).astype(np.int64)
        self._play(tuple(open_), Starts(min(played, self.budgets.samples), (lows[some], highs[some])))

    def _play_last(self, numbers: Sequence[int]) -> None:
        """As `_play`, all samples for each of the claims that would have no answer: whatever is left of the budget, so
        that a claim that is plainly false is VIOLATED with any. They are played alone, so that all budgets play the
        same.
        """
        for number in numbers:
            self._play((number,), Starts(self.budgets.samples), whatever_is_left=True)

    @property
    def _first(self) -> Starts:
        return Starts(min(self.budgets.samples, FIRST_SAMPLES))

    def _play(self, numbers: Sequence[int], at: Starts, whatever_is_left: bool = False) -> None:
        """VIOLATED where one of so many random episodes breaks a claim."""
        asked = {number: self.claims[number] for number in numbers if number in self._left}
        if not asked or not at.episodes:
            return
        states = at.episodes * (1 + max(claim.steps for claim in asked.values()))
        if not whatever_is_left:
            self.spending.ensure_left(states)
        self.spending.played += states
        for number, course in courses(self.profile, self.system, asked, at):
            counterexample = replay_course(self.profile, self.system, self.claims[number], course)
            if counterexample is not None:
                counterexample = shrink_counterexample(self.profile, self.system, self.claims[number], counterexample)
                self._settle(number, ReachOutcome(Verdict.VIOLATED, counterexample=counterexample))
                del asked[number]

    # --- for ever, and symbolic states

    def _for_ever(self, number: int) -> None:
        if number not in self._left:
            return
        most = min(self.spending.left, LASTING)
        outcome = lasting(self.profile, self.system, self.claims[number], most)
        with suppress(BudgetSpentError):  # the outcome says more than that: which state leaves, and where it goes
            self.spending.states += outcome.states
            self.spending.programs += outcome.programs
            self.spending.take(outcome.boxes)
        if outcome.verdict is Verdict.UNKNOWN:
            self._play_last((number,))
        if number in self._left:
            self._settle(number, outcome)

    def _symbolic(self) -> Iterator[None]:
        """Stages of all claims in turn, until each has an answer. BudgetSpentError."""
        self._searches = {
            number: SymbolicSearch(self.profile, self.system, self.claims[number], self.spending)
            for number in self._left
        }
        growth = 1
        while self._left:
            for merging, states, programs in STAGES:
                for number in tuple(self._left):
                    outcome = self._searches[number].try_stage(merging, Allowed(states * growth, programs * growth))
                    if outcome is not None and outcome.verdict is Verdict.UNKNOWN:
                        self._play_last((number,))
                    if outcome is not None and number in self._left:
                        self._settle(number, outcome)
                    if number not in self._left:
                        yield
            growth *= GROWTH

    def _report_spent(self, number: int) -> ReachOutcome:
        """No answer, since all is spent."""
        searched = self._searches.get(number)
        left = searched.open if searched is not None and searched.open is not None else self._open.get(number)
        start = start_of(self.system, self.claims[number]) if left is None else None
        left = open_state(start) if start is not None else left
        spent, most = self.spending, self.spending.most
        said = f"stopped after {spent.words} without a proof: {OPTION} is {most:,}"
        more = f"a larger {OPTION} than {most:,}"
        return ReachOutcome(Verdict.UNKNOWN, said, left, helping(self.system, self.claims[number], more))
