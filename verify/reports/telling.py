"""How a report tells of one kind of claim, as functions, and what it says of several kinds.

Does: names them.
Assumes: a module that has them for each kind.
Does not: know the kinds (kinds.py).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from codegen.ir import PolicyProfile

POSITIONS = "Positions are finite float64. Agents may leave the region during an episode (see the on-policy states)."
SHARES = (
    "Shares are estimated from uniform samples, with 95 % Wilson intervals. The verdict does not depend on them.",
)


@dataclass(frozen=True)
class Telling:
    """How a report tells of one kind of claim."""

    facts: Callable[[PolicyProfile, Any, str], dict[str, Any]]  # of a result, with the command that repeats it
    limits: Callable[[PolicyProfile, Sequence[Any]], list[str]]  # what the verdicts do not say
    trusted: tuple[str, ...]  # what proofs rest on
    lines: Callable[[Any], tuple[str, list[str]]] | None = None  # what was asked, and lines under it; None: of a game
