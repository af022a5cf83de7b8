"""Tiers of cases: of some the README's line asks the first ones alone; of sweeps `.ci/run` asks a small form, as slow
tests; every case is asked nightly.
"""

from collections.abc import Iterable
from typing import Any

import pytest

EVERY = 4  # of so many cases of a sweep one is slow


def sweep(cases: Iterable[Any], every: int = EVERY) -> list[Any]:
    """The cases of a sweep for `parametrize`: the first of every few is slow, the others are nightly."""
    given = (case if isinstance(case, type(pytest.param())) else pytest.param(case) for case in cases)
    return [
        pytest.param(*case.values, id=case.id, marks=pytest.mark.nightly if number % every else pytest.mark.slow)
        for number, case in enumerate(given)
    ]


def first_of(count: int, cases: Iterable[Any]) -> list[Any]:
    """The cases for `parametrize`: the README's line asks so many, and all others are nightly."""
    given = [case if isinstance(case, tuple) else (case,) for case in cases]
    return [pytest.param(*case, marks=[pytest.mark.nightly] * (at >= count)) for at, case in enumerate(given)]
