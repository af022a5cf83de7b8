"""Work side by side in processes, of this machine or of a Dask cluster.

Does: calls a function for each of several arguments, in as many processes as asked, results in order or as they come.
Assumes: arguments and results can be sent to a process; a cluster's workers have this package too.
Does not: leave a process behind.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from codegen.errors import InputError, MissingToolError

CONNECT_SECONDS = 10  # for a scheduler to answer, and for its first worker


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


def as_they_come(function: Callable[..., Any], arguments: Iterable[Sequence[Any]], jobs: int) -> Iterator[Any]:
    """As `side_by_side`, in the order in which calls end. Of `arguments`, only a few are taken ahead."""
    if jobs == 1:
        yield from (function(*each) for each in arguments)
        return
    from joblib import Parallel, delayed
    from joblib.externals.loky import get_reusable_executor

    try:
        parallel = Parallel(n_jobs=jobs, return_as="generator_unordered", batch_size=1)
        yield from parallel(delayed(function)(*each) for each in arguments)  # pyright: ignore[reportOptionalIterable]
    finally:
        get_reusable_executor().shutdown(wait=True)


def on_dask(function: Callable[..., Any], arguments: Iterable[Sequence[Any]], scheduler: str | None) -> Iterator[Any]:
    """As `as_they_come`, on the workers of a Dask cluster, which does the work of lost workers again.

    `scheduler`: its address; None: as Dask is configured (DASK_SCHEDULER_ADDRESS). MissingToolError without Dask, or
    when no scheduler answers, has no worker, or goes away.
    """
    from joblib import Parallel, delayed, parallel_config

    with _client(scheduler) as client, parallel_config(backend="dask", client=client):
        parallel = Parallel(return_as="generator_unordered", batch_size=1)
        yield from parallel(delayed(function)(*each) for each in arguments)  # pyright: ignore[reportOptionalIterable]


@contextmanager
def _client(scheduler: str | None) -> Iterator[Any]:
    try:
        import dask  # pyright: ignore[reportMissingImports]
        from distributed import Client  # pyright: ignore[reportMissingImports]
    except ImportError:
        raise MissingToolError("Dask is not installed", "--backend dask", "pip install 'maviper[scale]'") from None
    address = scheduler or dask.config.get("scheduler-address", None)
    if not address:
        advice = "give --scheduler ADDRESS, or set DASK_SCHEDULER_ADDRESS"
        raise InputError("which Dask scheduler is not said", "--backend dask", advice)
    try:
        client = Client(address, timeout=CONNECT_SECONDS, set_as_default=False)
    except (OSError, ValueError) as error:
        advice = "start one with `dask scheduler`, or check the address"
        raise MissingToolError(f"no Dask scheduler answers: {error}".split("\n")[0], address, advice) from None
    with client:
        yield client
