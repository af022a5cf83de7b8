"""What a kind of claim needs beside its verdict, as functions.

Does: names them.
Assumes: a module that has them for each kind.
Does not: know the kinds (table.py).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from codegen.ir import PolicyProfile
    from verify.result import AnyResult, Verdict


def _nothing(*_: object) -> dict[str, str]:
    return {}


@dataclass(frozen=True)
class Procedure:
    """The functions that handle one kind of claim."""

    answer: Callable[[Any, Any, str | None], AnyResult]  # a question, by its bench; where it holds, for the file named
    verdict: Callable[[Any, Any], tuple[Verdict, str]]  # of a question, by its bench, with the reason
    certificate: Callable[[Any], str]  # a certificate as text
    counterexample: Callable[[PolicyProfile, Any], tuple[dict[str, Any], str] | None]  # and where it is, in words
    # files of where a result holds, which has a number; and what the solver is asked of a question, which has one
    places: Callable[[PolicyProfile, int, Any], dict[str, str]] = _nothing
    solver_files: Callable[[int, Any], dict[str, str]] = _nothing
