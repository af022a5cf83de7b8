"""What all benchmarks share: figures beside their targets, one way to print them, turns, and what a command spends.

Does: makes a figure, reads the options that all have, prints figures or their JSON, times ways in turns, runs a command
  and says how it ended, how many seconds of CPU it took and how much memory.
Assumes: a POSIX system.
Does not: measure anything of the product by itself.
"""

import argparse
import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any, NamedTuple

LIMIT = 600  # seconds of CPU that a command may take
Figure = dict[str, Any]


def figure(
    name: str, value: float, reach: float | None = None, stretch: float | None = None, better: str = "lower"
) -> Figure:
    """A figure, beside its targets where it has some."""
    targets = {} if reach is None else {"reach": reach, "stretch": reach if stretch is None else stretch}
    return {"name": name, "value": value, "better": better, **targets}


def listed(values: Mapping[str, float], targets: Mapping[str, tuple[float, float, str]]) -> list[Figure]:
    """The figures of values that have targets: reach, stretch, and which is better."""
    return [figure(name, value, *targets[name]) for name, value in values.items()]


def reader(doc: str | None) -> argparse.ArgumentParser:
    """A parser of a benchmark's options, with its docstring as help and --json."""
    parser = argparse.ArgumentParser(description=doc, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", action="store_true", help="figures as JSON")
    return parser


def tell(figures: Iterable[Figure], as_json: bool) -> None:
    """Prints figures: one JSON object, or a line for each as it comes."""
    if as_json:
        print(json.dumps({"figures": list(figures)}))
        return
    for each in figures:
        goal = f"  (reach {each['reach']:g}, stretch {each['stretch']:g})" if "reach" in each else ""
        value = f"{each['value']:,}" if isinstance(each["value"], int) else f"{each['value']:.4g}"
        print(f"{each['name']}: {value}{goal}", flush=True)


def seconds(work: Callable[[], Any], clock: Callable[[], float] = time.process_time) -> tuple[float, Any]:
    """The seconds that a call takes, of CPU unless another clock is given, and what it returns."""
    began = clock()
    found = work()
    return clock() - began, found


def interleave(
    ways: Mapping[str, Callable[[], Any]], rounds: int, clock: Callable[[], float] = time.process_time
) -> dict[str, list[float]]:
    """The seconds of each way in each round, in turns."""
    times = {name: list[float]() for name in ways}
    for order in turns(list(ways), rounds):
        for name in order:
            times[name].append(seconds(ways[name], clock)[0])
    return times


def interleave_commands(
    commands: Mapping[str, Iterable[object]], rounds: int, codes: tuple[int, ...] = (0,)
) -> dict[str, list[float]]:
    """The seconds of CPU of each command in each round, in turns, after one round that is not counted. `codes`: how
    they may end.
    """
    times = {name: list[float]() for name in commands}
    for order in turns(list(commands), rounds + 1):
        for name in order:
            ended = spent_by(*commands[name])
            assert ended.code in codes, f"{name} failed"
            times[name].append(ended.seconds)
    return {name: each[1:] for name, each in times.items()}


def turns(everybody: list[Any], rounds: int) -> Iterator[list[Any]]:
    """Everybody, once in each round, beginning with another one each time."""
    for turn in range(rounds):
        first = turn % len(everybody)
        yield everybody[first:] + everybody[:first]


def with_children() -> float:
    """The seconds of CPU of this process and of those that it started and that ended."""
    return sum(os.times()[:4])


class Ended(NamedTuple):
    """How a command ended: exit code, seconds of CPU, megabytes at most."""

    code: int
    seconds: float
    megabytes: float


# A process counts the memory of the one that it came from, and a benchmark grows: so a small one stands between.
SPENDING = """
import os, resource, subprocess, sys
limit, *words = sys.argv[1:]
command = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
resource.prlimit(command.pid, resource.RLIMIT_CPU, (int(limit), int(limit)))
_, status, used = os.wait4(command.pid, 0)
print(os.waitstatus_to_exitcode(status), used.ru_utime + used.ru_stime, used.ru_maxrss)
"""


def spent(*words: object, limit: int = LIMIT) -> Ended:
    """A command of maviper's, which finds its modules compiled, and how it ended."""
    return spent_by(sys.executable, "-m", "maviper", *words, limit=limit)


def spent_by(*words: object, limit: int = LIMIT) -> Ended:
    """Any command, and how it ended."""
    compiled = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    command = [sys.executable, "-S", "-c", SPENDING, str(limit), *map(str, words)]
    ended = subprocess.run(command, capture_output=True, text=True, check=True, env=compiled)
    code, took, kilobytes = ended.stdout.split()
    return Ended(int(code), float(took), int(kilobytes) / 1024)
