"""Claims about all steps, decided by invariants.

Does: asks for which variables an invariant is needed; tries the regions that a user gives, those of the claim, then
  cells that grow from the start; has the checker accept what was found, or says which state leaves.
Assumes: a checked system; a claim about all steps.
Does not: look for counterexamples.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import replace

from codegen.ir import PolicyProfile
from verify.certificates.systems import certify
from verify.checker.accept import accept
from verify.checker.covers.invariants import names_of
from verify.checker.reading import RejectedError
from verify.checker.systems.proofs import Invariant, InvariantPart
from verify.reach.covering import close_names, set_anew
from verify.reach.forever.cells import Approach, CellSearch
from verify.reach.forever.leaving import LeftError
from verify.reach.forever.regions import RegionSearch
from verify.reach.results import OpenState, ReachOutcome, about_nothing
from verify.reach.witnesses import inhabitant
from verify.result import Verdict
from verify.spending import Spending
from verify.systems.claims import SystemClaim
from verify.systems.system import Polytope, System

IN_A_ROW = (1, 2, 4, 8)  # states in regions, from which another one is to follow; what fewer show, more show too
FEW, SHARE = 4_096, 8  # boxes of the first question about a claim's own regions; the part of all boxes of later ones
HELPS = ("a larger region, or a smaller start region", "another region that episodes stay in, as `invariant`")
CHANGED = ("another invariant, or none, so that one is looked for",)
SPENT = "a larger --max-boxes than {most:,}"


class InvariantSearch:
    """The answer to one claim. `left`: what leaves; `given`: what leaves the invariant that a user gives."""

    def __init__(self, profile: PolicyProfile, system: System, claim: SystemClaim, most: int) -> None:
        self._profile, self.system, self.claim, self._most = profile, system, claim, most
        self._anew = set_anew(system)
        self._cells = CellSearch(profile, system, claim, most)
        self._by_regions, self.walking = 0, Spending(most)
        self.left: LeftError | None = None
        self.given: LeftError | None = None

    @property
    def spent(self) -> int:
        """Boxes so far, and what steps by exact rows took, in boxes."""
        return self.boxes + self.walking.total

    @property
    def boxes(self) -> int:
        """Boxes so far."""
        return self._cells.spent + self._by_regions

    def add_spending(self, outcome: ReachOutcome) -> ReachOutcome:
        """An outcome with what was spent."""
        return replace(outcome, boxes=self.boxes, states=self.walking.states, programs=self.walking.programs)

    def iterate_invariants(self) -> Iterator[tuple[InvariantPart, ...]]:
        """Lists of parts, each of which may show the whole claim, in the order in which they are tried."""
        if self.claim.invariant:
            part = self._walk_regions(self.claim.invariant)
            left = max(self._most - self.walking.total, 0)
            part = self._of_regions(self.claim.invariant, IN_A_ROW, left) if part is None else part
            self.given, self.left = self.left, None
            if part is not None:
                yield (part,)
        for together in (False, True):
            parts = [self._part(names) for names in self._groups(together)]
            shown = tuple(part for part in parts if part is not None)
            if len(shown) == len(parts):
                yield shown

    def _part(self, names: tuple[str, ...]) -> InvariantPart | None:
        """An invariant of some variables."""
        asked = tuple(tuple(half for half in region if names_of(half) <= set(names)) for region in self.claim.regions)
        usable = all(asked) and {name for region in asked for half in region for name in names_of(half)} == set(names)
        part = self._of_regions(asked, IN_A_ROW[:1], min(FEW, self._most)) if usable else None
        if part is None:
            part = self._cells.part(names)
            self.left = self._cells.left or self.left
        later = usable and part is None
        return self._of_regions(asked, IN_A_ROW[1:], self._most // SHARE) if later else part

    def _walk_regions(self, regions: Sequence[Polytope]) -> InvariantPart | None:
        """Regions as an invariant, where exact rows show one step from them."""
        search = RegionSearch(self._profile, self.system, self.claim, regions, min(FEW, self._most))
        try:
            return search.walk_regions(self._approaches(regions), max(self._most - self.spent, 0))
        except RejectedError:
            return None
        finally:
            self._by_regions += search.spent
            self.walking.states += search.walking.states
            self.walking.programs += search.walking.programs
            self._cells.most = max(self._cells.most - search.walking.total, 0)

    def _approaches(self, regions: Sequence[Polytope]) -> list[Approach]:
        named = {name for region in regions for half in region for name in names_of(half)}
        return self._cells.approaches([one.name for one in self.system.variables if one.name in named])

    def _of_regions(self, regions: Sequence[Polytope], in_a_row: Sequence[int], most: int) -> InvariantPart | None:
        """Regions as an invariant, where they are one."""
        approaches = self._approaches(regions)
        for steps in in_a_row:
            search = RegionSearch(self._profile, self.system, self.claim, regions, most)
            try:
                return search.part(steps, approaches)
            except LeftError as left:
                self.left = left if self.left is None or left.exact is not None else self.left
                if left.begins:  # more steps ask for more
                    break
            except RejectedError:  # not bounded, not finite, or too many
                pass
            finally:
                self._by_regions += search.spent
        return None

    def _groups(self, together: bool) -> list[tuple[str, ...]]:
        """The variables that halves of the claim need, with all that these depend on. `together`: and all that stand
        in one test with them.
        """
        regions = self.claim.regions
        halves = [names_of(half) for half in regions[0]] if len(regions) == 1 else []
        asked = halves or [{name for region in regions for half in region for name in names_of(half)}]
        groups: list[frozenset[str]] = []
        for names in asked:
            closed = frozenset(self._close_names(names, together))
            if not any(closed <= other for other in groups):
                groups = [other for other in groups if not other <= closed] + [closed]
        return [tuple(one.name for one in self.system.variables if one.name in names) for names in groups]

    def _close_names(self, names: set[str], together: bool) -> set[str]:
        closed = set(names).union(*(piece.where for piece in self.system.pieces))
        closed = closed.union(*(names_of(half) for piece in self.system.pieces for half in piece.when))
        tests = [
            {name for name, _ in known[feature.name].form.terms}
            for policy in self._profile.agents
            for known in [self.system.features[policy.agent]]
            for feature in policy.features
        ]
        tests += [names_of(half) for region in self.claim.assuming for half in region]
        before = -1
        while len(closed) > before:
            before = len(closed)
            closed = close_names(self.system, closed, tests if together else ())
            # a rounding that is tested with them alone is one cell more, and without it the test would be open
            closed = closed.union(*(test for test in tests if test - self._anew <= closed and test & closed))
        return closed


def lasting(profile: PolicyProfile, system: System, claim: SystemClaim, most: int) -> ReachOutcome:
    """The answer, after about so many boxes at most."""
    search = InvariantSearch(profile, system, claim, most)
    for parts in search.iterate_invariants():
        state = inhabitant(system, claim)
        if isinstance(state, Verdict):
            return search.add_spending(about_nothing(claim, state))
        made = certify(profile, system, claim, state, Invariant(parts))
        with suppress(RejectedError):
            sets = accept(made, profile, system)
            return search.add_spending(ReachOutcome(Verdict.PROVED, certificate=made, branches=sets))
    return _unknown(search, most)


def _unknown(search: InvariantSearch, most: int) -> ReachOutcome:
    """No answer, with the state that leaves and where it goes."""
    if inhabitant(search.system, search.claim) is Verdict.VACUOUS:
        return search.add_spending(about_nothing(search.claim, Verdict.VACUOUS))
    left = search.given or search.left
    helps = (*(CHANGED if search.given else ()), *HELPS)
    helps = (*helps, SPENT.format(most=most)) if search.spent >= most else helps
    said = f"no invariant was found after {replace(search.walking, boxes=search.boxes).words}"
    if left is None:
        return search.add_spending(ReachOutcome(Verdict.UNKNOWN, said, None, helps))
    said = f"{said}; the one that is given is none: {left.words}" if search.given else f"{said}: {left.words}"
    return search.add_spending(ReachOutcome(Verdict.UNKNOWN, said, OpenState(left.step, left.cell), helps))
