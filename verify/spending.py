"""What a search may spend, how far it is, and why it ends without its answer.

Does: one budget, counted in boxes: adds up boxes, symbolic states, linear programs and steps of play, and says what is
  left; hands numbers and a few words from inside a search to a listener that the caller set for the time of a call; the
  roots of the exceptions that searches raise for whoever began them.
Assumes: costs and counts that do not depend on the machine; listeners that return soon; whoever begins a search catches
  what it may raise, so no user meets one of these.
Does not: print, measure time, or change what is searched; cover what a user can mend (codegen/errors.py), or
  certificates that the checker refuses (`RejectedError`, checker/reading.py, which imports nothing of this).

A box takes about a microsecond. All else counts as the boxes that take as long, measured on small systems. So one limit
says when a search stops, whatever it was trying, and how far it is.

    UnansweredError
    |-- SpentError           a budget has ended
    |   |-- BudgetError         zones: search nodes
    |   |-- FacesError          zones: faces of a volume
    |   |-- TooLongError        episodes: answers of a proof
    |   |-- ReachBudgetError    reach: what a stage is allowed
    |   `-- BudgetSpentError    all that claims about a stated system may spend
    `-- BeyondError          what is asked has no answer of this kind
        |-- BeyondZonesError    zones: a test that bounds no coordinate and no difference of two
        |-- NoCertificateError  episodes: no proof in any form (LeftOpenError: a start is left open)
        `-- UndefinedError      systems: an expression without bounds over a box
"""

from __future__ import annotations

from collections.abc import Callable, Generator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass

from codegen.wording import format_count


class UnansweredError(Exception):
    """A search ends without its answer."""


class SpentError(UnansweredError):
    """A budget has ended."""


class BeyondError(UnansweredError):
    """The question asked has no answer of this kind."""


def tell_of_goal(goal: str | None, words: str) -> str:
    """Puts the goal, if there is one, before words."""
    return words if goal is None else f"goal {goal}: {words}"


Listener = Callable[[int, int, str], None]  # done, of at most, in words
_listener: ContextVar[Listener | None] = ContextVar("listener", default=None)


@contextmanager
def listening(listener: Listener) -> Generator[None]:
    """Everything that is told inside goes to `listener`."""
    before = _listener.set(listener)
    try:
        yield
    finally:
        _listener.reset(before)


def tell(done: int, most: int, words: str) -> None:
    """That `done` of at most `most` are done; `words`: what they are, and what else is known."""
    listener = _listener.get()
    if listener is not None:
        listener(done, most, words)


def tell_spent(boxes: int, most: int, words: str = "") -> None:
    """Tells how far a search about a stated system is, in boxes of its budget."""
    tell(min(boxes, most), most, f"boxes of the budget{words}")


OPTION = "--effort"
FORM, STATE, PROGRAM = 10, 100, 400  # boxes that an affine form, a symbolic state and a linear program take as long as
SET = 120  # and one set of states of a flow


class BudgetSpentError(SpentError):
    """The whole budget is spent."""


@dataclass
class Spending:
    """The amount spent so far, of at most so many boxes."""

    most: int
    boxes: int = 0
    played: int = 0  # states of random episodes; each counts as a box
    states: int = 0  # symbolic ones
    programs: int = 0

    @property
    def total(self) -> int:
        """All of it, in boxes."""
        return self.boxes + self.played + STATE * self.states + PROGRAM * self.programs

    @property
    def left(self) -> int:
        """The boxes that may still be spent."""
        return max(self.most - self.total, 0)

    def ensure_left(self, boxes: int = 1) -> None:
        """BudgetSpentError where less than that is left."""
        if self.left < boxes:
            raise BudgetSpentError(OPTION)

    def take(self, boxes: int) -> None:
        """Adds boxes, and tells how far the search is."""
        self.boxes += boxes
        self.tell()

    def tell(self, words: str = "") -> None:
        """Tells how far the search is."""
        tell_spent(self.total, self.most, words)

    @property
    def words(self) -> str:
        """Words for what was spent on what, as reports say it."""
        kinds = (
            (self.boxes, "box"),
            (self.played, "played state"),
            (self.states, "symbolic state"),
            (self.programs, "linear program"),
        )
        some = [format_count(*kind) for kind in kinds if kind[0]] or [format_count(0, "box")]
        return some[0] if len(some) == 1 else f"{', '.join(some[:-1])} and {some[-1]}"
