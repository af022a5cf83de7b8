"""Work side by side in processes.

Does: calls a function for each of several arguments, in as many processes as asked, results in order.
Assumes: arguments and results can be sent to a process.
Does not: leave a process behind.
"""

from collections.abc import Callable, Iterator, Sequence
from typing import Any


def side_by_side(function: Callable[..., Any], arguments: Sequence[Sequence[Any]], jobs: int) -> Iterator[Any]:
    """`function(*each)` for each of `arguments`; with one job in this process, as results are asked for."""
    if jobs == 1 or len(arguments) == 1:
        yield from (function(*each) for each in arguments)
        return
    from joblib import Parallel, delayed
    from joblib.externals.loky import get_reusable_executor

    try:
        parallel = Parallel(n_jobs=min(jobs, len(arguments)), return_as="generator")
        yield from parallel(delayed(function)(*each) for each in arguments)  # pyright: ignore[reportOptionalIterable]
    finally:
        get_reusable_executor().shutdown(wait=True)
