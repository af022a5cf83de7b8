"""How a report tells of one kind of claim, as functions, and what it says of several kinds.

Does: names them; counts the sets of a proof, and says what they show.
Assumes: a module that has them for each kind.
Does not: know the kinds (kinds.py).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from codegen.ir import PolicyProfile
from codegen.wording import format_count

POSITIONS = "Positions are finite float64. Agents may leave the region during an episode (see the on-policy states)."
SHARES = (
    "Shares are estimated from uniform samples, with 95 % Wilson intervals. The verdict does not depend on them.",
)

SETS = {  # by what the checker counts: one of them, and what they do
    "boxes": ("box", "cover all episodes"),
    "forms": ("form", "cover all episodes"),
    "sets": ("set", "hold all states at all times"),
    "cells": ("cell", "hold what they become"),
}


@dataclass(frozen=True)
class Telling:
    """The way in which a report tells of one kind of claim."""

    facts: Callable[[PolicyProfile, Any, str], dict[str, Any]]  # of a result, with the command that repeats it
    limits: Callable[[PolicyProfile, Sequence[Any]], list[str]]  # what the verdicts do not say
    trusted: tuple[str, ...]  # what proofs rest on
    lines: Callable[[Any], tuple[str, list[str]]] | None = None  # what was asked, and lines under it; None: of a game


def sets(told: Mapping[str, Any]) -> str:
    """Counts the sets of a result's proof, in words; "" where it is none by sets."""
    proof = told.get("certificate", {})
    return next((format_count(proof[kind], noun) for kind, (noun, _) in SETS.items() if kind in proof), "")


def describe_sets(told: Mapping[str, Any]) -> str:
    """The same with what they show."""
    proof = told.get("certificate", {})
    return next((f"{sets(told)} {does}" for kind, (_, does) in SETS.items() if kind in proof), "")
