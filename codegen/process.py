"""What belongs to the whole process: floating-point flags, threads and filters of warnings, stated or held aside for a
call.

Does: runs a function with NumPy's own defaults, whatever the process has set (`np.seterr`), and puts that back, or with
  one thread of linear algebra; ignores Python's warnings in a call, one thread at a time, since these filters are those
  of the whole process.
Assumes: short calls; what ends in a warning by default is a fault, and handled where it is expected.
Does not: change anything for good, import NumPy before a function is called, or reach into threads, which begin with
  the defaults.
"""

import threading
import warnings
from collections.abc import Callable, Generator
from contextlib import contextmanager
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


def one_thread(verb: Callable[Given, Answer]) -> Callable[Given, Answer]:
    """The function, run with one thread of linear algebra, of NumPy imported before. Our matrix products are small:
    beside other processes, more threads took ten times as long.
    """

    @wraps(verb)
    def run(*given: Given.args, **named: Given.kwargs) -> Answer:
        from threadpoolctl import threadpool_limits  # pyright: ignore[reportMissingTypeStubs]

        with threadpool_limits(1, "blas"):
            return verb(*given, **named)

    return run


FILTERS = threading.RLock()  # held by whoever changes them: threads that overlap put back the wrong ones


@contextmanager
def silence_warnings() -> Generator[None]:
    """No warning is shown or raised."""
    with FILTERS, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield
