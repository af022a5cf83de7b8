"""Three false words that were mended, put back: what the hunt must find again.

Does: patches the verifier so that it has one of them.
Assumes: pytest's monkeypatch, or anything with its `setattr`.
Does not: look for them.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from verify.checker import decisions as checking
from verify.claims import claim, decisions
from verify.counterexamples import search
from verify.episodes import certificates as making
from verify.episodes import unroll
from verify.kinds import MACHINE
from verify.question import DecisionQuestion
from verify.states import shares
from verify.verdicts import decisions as judging


@dataclass(frozen=True)
class Planted:
    """A false word, and among which questions it shows."""

    name: str
    kind: str
    plant: Callable[[Any], None]
    shows: str  # what is wrong then says so


def _signs(patch: Any) -> None:
    """Two tests of a sign at thresholds on either side of 0 are one test, so starts at 0 are lost; what the search for
    a certificate leaves open stays proved.
    """
    line = unroll._line

    def one_test(*given: Any) -> tuple[float, bool] | bool:
        found = line(*given)
        return found if isinstance(found, bool) else (found[0], False)

    patch.setattr(unroll, "_line", one_test)
    patch.setattr(making, "LeftOpenError", making.NoCertificateError)


def _nobody(patch: Any) -> None:
    """A claim about a team that there is not is true of all of nobody, also in a certificate."""
    known_names = checking.ensure_known_names
    patch.setattr(decisions, "ensure_team", lambda profile, team: None)
    patch.setattr(claim, "ensure_team", lambda profile, team: None)
    patch.setattr(
        checking, "ensure_known_names", lambda profile, header, team, *rest: known_names(profile, header, None, *rest)
    )


def _real(patch: Any) -> None:
    """States that violate a claim in real arithmetic are sought by it, but judged and simplified by the machine's."""
    violates, violating, shortfall, confirmed = (
        search.violates,
        shares.violating,
        search.shortfall,
        search.confirm_point,
    )

    def float_states_only(question: DecisionQuestion, *given: Any) -> Any:
        try:
            return confirmed(question, *given)
        except StopIteration:
            return None, 0

    patch.setattr(search, "violates", lambda question, state: violates(question.by(MACHINE), state))
    patch.setattr(search, "draw_states", shares.draw_states.__wrapped__)  # nothing that was drawn without the fault
    patch.setattr(shares, "violating", lambda question, states: violating(question.by(MACHINE), states))
    patch.setattr(search, "shortfall", lambda question, state: shortfall(question.by(MACHINE), state))
    patch.setattr(search, "_failing_in_both", lambda *given: [])
    patch.setattr(search, "_simplify_model", lambda question, goal, model: (None, 0))
    patch.setattr(search, "confirm_point", float_states_only)
    patch.setattr(judging, "confirm_point", float_states_only)


PLANTED = (
    Planted("starts at which a sign is 0 are lost", "episodes", _signs, "proved, but fails"),
    Planted("a certificate about a team that there is not is accepted", "decisions", _nobody, "about nobody"),
    Planted("real arithmetic is judged by the machine's", "decisions", _real, "where the claim holds"),
)
