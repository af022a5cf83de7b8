"""Floating-point flags: what NumPy does at an underflow, an overflow or a NaN, stated for whole calls.

Does: runs a function with NumPy's own defaults, whatever the process has set (`np.seterr`), and puts that back.
Assumes: what ends in a warning by default is a fault, and handled where it is expected.
Does not: import NumPy before the function is called, or reach into threads, which begin with the defaults.
"""

from collections.abc import Callable
from functools import wraps
from typing import ParamSpec, TypeVar

Given = ParamSpec("Given")
Answer = TypeVar("Answer")


def defaults(verb: Callable[Given, Answer]) -> Callable[Given, Answer]:
    """The function, run with NumPy's default handling of floating-point flags."""

    @wraps(verb)
    def run(*given: Given.args, **named: Given.kwargs) -> Answer:
        import numpy as np

        with np.errstate(divide="warn", over="warn", under="ignore", invalid="warn"):
            return verb(*given, **named)

    return run
