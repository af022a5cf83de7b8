"""Why a search inside the verifier ends without its answer.

Does: the roots of the exceptions that searches raise for whoever began them.
Assumes: whoever begins a search catches what it may raise, so no user meets one of these.
Does not: cover what a user can mend (codegen/errors.py), or certificates that the checker refuses (`RejectedError`,
  checker/reading.py, which imports nothing of this).

    UnansweredError
    |-- SpentError           a budget has ended
    |   |-- BudgetError         zones: search nodes
    |   |-- FacesError          zones: faces of a volume
    |   |-- TooLongError        episodes: answers of a proof
    |   |-- ReachBudgetError    reach: what a stage is allowed
    |   `-- BudgetSpentError    spending: all that claims about a stated system may spend
    `-- BeyondError          what is asked has no answer of this kind
        |-- BeyondZonesError    zones: a test that bounds no coordinate and no difference of two
        |-- NoCertificateError  episodes: no proof in any form (LeftOpenError: a start is left open)
        `-- UndefinedError      systems: an expression without bounds over a box
"""


class UnansweredError(Exception):
    """A search ends without its answer."""


class SpentError(UnansweredError):
    """A budget has ended."""


class BeyondError(UnansweredError):
    """The question asked has no answer of this kind."""


def tell_of_goal(goal: str | None, words: str) -> str:
    """Puts the goal, if there is one, before words."""
    return words if goal is None else f"goal {goal}: {words}"
