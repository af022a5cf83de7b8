"""Calls side by side: in as many processes as asked, on a cluster, or one for each seed, of which the best is kept.

Does: runs a function for each of several arguments, results in order or as they come; says which folders and numbers a
  run of several seeds may have, chooses by score, and writes the table of scores.
Assumes: arguments and results can be sent to a process; a cluster's workers have this package too. Higher scores are
  better.
Does not: leave a process behind.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

from codegen.errors import InputError, MissingToolError
from maviper.files import runs

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
        yield from parallel(delayed(function)(*each) for each in arguments)
    finally:
        get_reusable_executor().shutdown(wait=True)


def as_they_come(function: Callable[..., Any], arguments: Iterable[Sequence[Any]], jobs: int) -> Iterator[Any]:
    """Yields results like `side_by_side`, in the order in which calls end. Of `arguments`, only a few are taken ahead.

    MissingToolError where a process was killed, as a machine does that runs out of memory.
    """
    if jobs == 1:
        yield from (function(*each) for each in arguments)
        return
    from joblib.externals.loky import get_reusable_executor
    from joblib.externals.loky.process_executor import TerminatedWorkerError

    try:
        yield from _iterate_results(function, arguments, n_jobs=jobs)
    except TerminatedWorkerError:
        advice = "is there memory for so many? what is finished is kept: run the command again"
        raise MissingToolError("a process that worked for this one was killed", f"--jobs {jobs}", advice) from None
    finally:
        get_reusable_executor().shutdown(wait=True)


def on_dask(function: Callable[..., Any], arguments: Iterable[Sequence[Any]], scheduler: str | None) -> Iterator[Any]:
    """Yields results like `as_they_come`, on the workers of a Dask cluster, which does the work of lost workers again.

    `scheduler`: its address; None: as Dask is configured (DASK_SCHEDULER_ADDRESS). MissingToolError without Dask, or
    when no scheduler answers, has no worker, or goes away.
    """
    import logging
    from concurrent.futures import CancelledError

    from joblib import parallel_config

    client = _client(scheduler)
    distributed: Any = import_module("distributed")
    address = client.scheduler.address
    log = logging.getLogger("distributed.client")
    before = log.level
    log.setLevel(logging.CRITICAL)  # what goes wrong is told below, in one line
    try:
        with client, parallel_config(backend="dask", client=client):
            yield from _iterate_results(function, arguments)
    except (CancelledError, OSError) as error:  # the latter is also a TimeoutError, of the first worker
        what = "no worker came" if isinstance(error, TimeoutError) else "the connection to the Dask scheduler is lost"
        raise MissingToolError(what, address, "what is finished is kept: run the command again") from None
    except distributed.KilledWorker as error:
        advice = "is there memory for it? what is finished is kept: run the command again"
        raise MissingToolError(f"one call after another ended a Dask worker: {error.task}", address, advice) from None
    finally:
        log.setLevel(before)


def _iterate_results(function: Callable[..., Any], arguments: Iterable[Sequence[Any]], **how: Any) -> Iterator[Any]:
    """The results, as they come."""
    from joblib import Parallel, delayed

    parallel = Parallel(return_as="generator_unordered", batch_size=1, **how)
    yield from parallel(delayed(function)(*each) for each in arguments)


def _client(scheduler: str | None) -> Any:
    try:
        config: Any = import_module("dask.config")
        distributed: Any = import_module("distributed")
    except ImportError:
        raise MissingToolError("Dask is not installed", "--backend dask", "pip install 'maviper[scale]'") from None
    address = scheduler or config.get("scheduler-address", None)
    if not address:
        advice = "give --scheduler ADDRESS, or set DASK_SCHEDULER_ADDRESS"
        raise InputError("which Dask scheduler is not said", "--backend dask", advice)
    try:
        return distributed.Client(address, timeout=CONNECT_SECONDS, set_as_default=False)
    except (OSError, ValueError):
        advice = "start one with `dask scheduler`, or check the address"
        raise MissingToolError("no Dask scheduler answers", address, advice) from None


MAX_SEEDS = 1_000
SEEDS_FILE = "seeds.json"
Made = TypeVar("Made")


class Scored(NamedTuple):
    """The worth of the result of one seed."""

    score: float
    said: str = ""  # what its line says after the score
    measured: Mapping[str, Any] = {}  # further entries of the table


def ensure_counts(seeds: int, jobs: int) -> None:
    """InputError for numbers of seeds or jobs out of their range."""
    if not 1 <= seeds <= MAX_SEEDS:
        raise InputError(f"the number of seeds must be from 1 to {MAX_SEEDS}, not {seeds}", "--seeds")
    if jobs < 1:
        raise InputError(f"the number of jobs must be at least 1, not {jobs}", "--jobs")


def folder_of(run: Path, seed: int) -> Path:
    """The folder of one seed's run, in the folder of a run of several seeds."""
    return run / f"seed-{seed}"


def is_resumed(folder: Path, resume: bool) -> bool:
    """Returns True if the run of one seed goes on: its run of several does, and had come as far as this seed."""
    return resume and (folder / runs.CONFIG_FILE).exists()


def best_of(
    run: Path,
    seeds: Sequence[int],
    results: Iterable[Made],
    score: Callable[[Made], Scored],
    say: Callable[[str, str], None],
) -> tuple[int, Made]:
    """The seed with the highest score, the first of equals, and its result; writes the table into the run's folder.

    `say`: shows a label and a line, once for each result as it comes, and at last for the best.
    """
    kept: list[Made] = []
    scores: list[Scored] = []
    for seed, result in zip(seeds, results, strict=True):
        kept.append(result)
        scores.append(score(result))
        say("seed", f"{seed}: score {scores[-1].score:.3f}{scores[-1].said}")
    best = max(range(len(kept)), key=lambda place: (scores[place].score, -place))
    table = {str(seed): {"score": one.score, **one.measured} for seed, one in zip(seeds, scores, strict=True)}
    runs.write(run / SEEDS_FILE, runs.as_json({"best": seeds[best], "seeds": table}))
    say("best", f"seed {seeds[best]}")
    return seeds[best], kept[best]
