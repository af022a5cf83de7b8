"""Observations that generated functions must refuse, and whether they do.

Does: makes what is no observation of an agent, for the functions that take one and for those that take many.
Assumes: a refusal is a ValueError or a TypeError, which says what was wanted and what was given.
Does not: judge decisions (selfcheck.py).
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np


def single(n: int, asks: bool) -> list[Any]:
    """Lists values that are no observation of n numbers. `asks`: whether a decision asks for any; others go unread."""
    zeros = [0.0] * n
    lengths: list[Any] = [[], zeros[1:], [*zeros, 0.0], tuple(zeros[1:]), np.zeros(n - 1), np.zeros(2 * n)]
    shapes: list[Any] = [np.zeros((1, n)), np.zeros((n, 1)), np.zeros((n, n)), np.zeros(())]
    texts: list[Any] = [None, 0.0, "0" * n, bytes(n), np.zeros(n, dtype="U3")]
    others: list[Any] = [["0.0"] * n, [b"0.0"] * n, [None] * n, [0j] * n, np.zeros(n, dtype=complex), [[0.0]] * n]
    return [*lengths, *shapes, *texts, *(others if asks else [])]


def many(n: int) -> list[Any]:
    """Lists values that are no array of observations of n numbers."""
    widths: list[Any] = [np.zeros((2, width), dtype=np.float32) for width in (n - 1, n + 1, 2 * n)]
    shapes: list[Any] = [np.zeros(n), np.zeros((2, n, n)), [[0.0] * n, [0.0] * (n + 1)], None]
    return [
        *widths,
        *shapes,
        [["0.0"] * n],
        [[None] * n],
        np.zeros((2, n), dtype="U3"),
        np.zeros((2, n), dtype=complex),
    ]


def find_accepted(function: Callable[[Any], Any], given: Sequence[Any]) -> list[str]:
    """Describes, in words, each given value that the function does not refuse."""
    descriptions: list[str] = []
    for each in given:
        try:
            said = f"is answered by {function(each)!r:.20}"
        except (TypeError, ValueError):
            continue
        except Exception as error:  # an accident further on, which tells the caller nothing
            said = f"ends in {type(error).__name__}"
        descriptions.append(f"{type(each).__name__} {each!r:.60} {said}")
    return descriptions
