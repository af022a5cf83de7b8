"""What earlier proofs still show after a change of trees, of a system, or of a claim's numbers.

Does: keeps the parts of a proof that hold as they were, and proves the others again: of an invariant its cells, of
  walks the parts of the claim; has the checker accept the whole.
Assumes: proofs that anyone made; a question that was checked.
Does not: answer by what was proved before. A claim whose proof cannot be renewed is asked as if there were none.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from typing import NamedTuple

from codegen.errors import InputError
from codegen.wording import format_count
from verify.checker.certificate import numbers
from verify.checker.covers.boxes import widths_of
from verify.checker.covers.invariants import check_part, names_of, read_cells
from verify.checker.reading import RejectedError
from verify.checker.systems.branch_proofs import close_branches, ensure_closed
from verify.checker.systems.proofs import (
    Cover,
    FlowSets,
    FollowedPart,
    Invariant,
    InvariantPart,
    SystemProof,
    Walks,
)
from verify.question import Question
from verify.reach.covering import Search
from verify.reach.decide import SymbolicSearch, ensure_stated
from verify.reach.programs import prove
from verify.reach.results import ReachOutcome
from verify.reach.unbounded import CellSearch
from verify.result import Verdict
from verify.spending import BudgetSpentError, Spending
from verify.subjects import ClosedLoop
from verify.systems.claims import SystemClaim

MOST = 400_000  # boxes for what no longer holds: a search from nothing may be better
AFRESH = "the earlier proof does not hold any more: all was proved again"


class Renewed(NamedTuple):
    """A proof, and how many of its parts are as they were; how many are new. Without a noun it has no parts."""

    proof: SystemProof
    kept: int = 0
    again: int = 0
    noun: str = ""

    @property
    def words(self) -> str:
        """What holds as it was."""
        if not self.again:
            counted = f" ({format_count(self.kept, self.noun)})" if self.noun else ""
            return f"the earlier proof holds as it was{counted}, so nothing was proved again"
        told = format_count(self.kept + self.again, self.noun)
        return f"{self.kept:,} of {told} hold as they were; {self.again:,} proved again"


def renew(question: Question[SystemClaim], decide: Callable[[Question[SystemClaim]], ReachOutcome]) -> ReachOutcome:
    """The answer: by the first of the question's earlier proofs that can be renewed, else as `decide` finds it."""
    assert isinstance(question.subject, ClosedLoop)
    profile, system = question.profile, question.subject.system
    ensure_stated(profile, system)
    for proof in question.since:
        spending = Spending(min(question.budgets.max_boxes, MOST))
        with suppress(RejectedError, InputError, BudgetSpentError):
            found = _renew_proof(question, proof, spending)
            outcome = prove(profile, system, question.claim, found.proof)
            return replace(outcome, boxes=spending.boxes, reused=found.words)
    outcome = decide(question)
    return replace(outcome, reused=AFRESH) if question.since and outcome.verdict is Verdict.PROVED else outcome


def _renew_proof(question: Question[SystemClaim], proof: SystemProof, spending: Spending) -> Renewed:
    """A proof that may show the claim. RejectedError where none was found; BudgetSpentError."""
    assert isinstance(question.subject, ClosedLoop)
    asked = question.profile, question.subject.system, question.claim
    if not _list_named(proof) <= {one.name for one in question.subject.system.variables}:
        raise RejectedError("the proof names variables that the system does not have")
    match proof:
        case Cover():
            if not Search(*asked, spending).holds(proof):
                raise RejectedError("parts of the start stay open")
            return Renewed(proof)
        case FlowSets():
            return Renewed(proof)
        case Invariant():  # its parts hold as they were, or grow from the cells that they had
            kept, parts, again = 0, list[InvariantPart](), 0
            for part in proof.parts:
                try:
                    count, _ = check_part(part, question.claim, *asked[:2], None)
                    kept, parts = kept + count, [*parts, part]
                except RejectedError:
                    search = CellSearch(*asked, spending.left)
                    widths_of(part.widths)
                    parts.append(search.grow(part))
                    spending.take(search.spent)
                    cells = (read_cells(numbers(each.cells), len(part.widths)) for each in (part, parts[-1]))
                    before, after = map(len, cells)
                    kept, again = kept + before, again + after - before
            return Renewed(Invariant(tuple(parts)), kept, again, "cell")
        case Walks():  # what no longer holds is proved again, unless that is all
            symbolic, shown, again = SymbolicSearch(*asked, spending), list[FollowedPart](), 0
            for followed in proof.parts:
                ensure_closed(question.subject.system, followed)
                try:
                    close_branches(*asked, followed, followed.proof)
                    shown.append(followed)
                except RejectedError:
                    again += 1
                    if again == len(proof.parts):
                        raise
                    shown.append(symbolic.prove_again(followed))
            return Renewed(Walks(tuple(shown)), len(shown) - again, again, "part")


def _list_named(proof: SystemProof) -> set[str]:
    """Lists the variables that a proof names."""
    match proof:
        case Cover(cells) | FlowSets(cells=cells):
            return set(cells)
        case Invariant(parts):
            return {name for part in parts for name in (*part.followed, *part.joined)}
        case Walks(parts):
            hulls = [half for part in parts for hull in part.hulls for half in hull.region]
            return {name for part in parts for name in part.followed}.union(*map(names_of, hulls))
