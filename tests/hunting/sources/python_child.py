"""Python's own answers to a folder of sources: `python -m tests.hunting.sources.python_child FOLDER`.

Does: runs each source, asks it rows around its own numbers in order and backwards, and writes
  rows and answers beside it.
Assumes: the sources are ours; a process that computes too long is ended by its timer.
Does not: know how sources are imported.
"""

import ast
import contextlib
import enum
import importlib
import json
import os
import signal
import sys
import types
import warnings
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from tests.hunting.sources import observing

SECONDS = 20
CALLED = ("abs", "max", "min", "float", "int", "round")
AGAIN = 300  # rows that are asked twice, the second time backwards
MANY = 400  # numbers of one source


def numbers_of(tree: ast.AST, space: dict[str, Any]) -> list[float]:
    """Every number in a file, and those that its constant expressions and its names come to."""
    out: set[float] = set()
    for node in ast.walk(tree):
        if isinstance(node, (ast.Constant, ast.UnaryOp, ast.BinOp, ast.Subscript, ast.Call, ast.Attribute)) and _plain(
            node, space
        ):
            with contextlib.suppress(Exception):
                _collect(
                    eval(compile(ast.fix_missing_locations(ast.Expression(node)), "constant", "eval"), space), out, 2
                )
    for name, value in space.items():
        if not name.startswith("__"):
            _collect(value, out, 3)
    return sorted(out)[:MANY]


def _plain(node: ast.expr, space: dict[str, Any]) -> bool:
    for each in ast.walk(node):
        if isinstance(each, ast.Call) and not (isinstance(each.func, ast.Name) and each.func.id in CALLED):
            return False
        if isinstance(each, ast.Name) and each.id not in space and each.id not in CALLED:
            return False
        if isinstance(each, (ast.NamedExpr, ast.Await, ast.Yield, ast.YieldFrom, ast.Lambda)):
            return False
    return True


def _collect(value: Any, out: set[float], levels: int) -> None:
    if isinstance(value, (bool, np.bool_)) or levels < 0:
        return
    if isinstance(value, (int, float, np.integer, np.floating)):
        with contextlib.suppress(OverflowError):
            out.add(float(value))
    elif isinstance(value, dict):
        for each in [*value.keys(), *value.values()]:
            _collect(each, out, levels - 1)
    elif isinstance(value, (list, tuple, set, frozenset)):
        for each in value:
            _collect(each, out, levels - 1)
    elif hasattr(value, "__dict__") and not isinstance(value, (types.ModuleType, types.FunctionType)):
        for name, each in list(vars(value).items()):
            if not name.startswith("__"):
                _collect(each, out, levels - 1)


def label_of(value: Any) -> tuple[Any, ...]:
    """An answer as JSON: its kind and itself."""
    if isinstance(value, enum.Enum):
        own = value.value if isinstance(value.value, (int, float, str)) else repr(value.value)
        return "member", value.name, own, isinstance(value, int)
    if isinstance(value, str):
        return "text", str(value)
    if isinstance(value, (bool, np.bool_, int, np.integer)):
        return "number", int(value)
    if isinstance(value, (float, np.floating)):
        return "number", float(value).hex()
    if isinstance(value, (list, tuple, np.ndarray)):
        with contextlib.suppress(TypeError, ValueError):
            return "numbers", *(float(each).hex() for each in value)
    return "other", type(value).__name__


def given_as(form: str, names: list[str], row: Any) -> tuple[Any, ...]:
    """The arguments of one call; a row is a list of Python's floats, or an array."""
    if form == "row":
        return (row,)
    if form == "columns":
        return tuple(row)
    if form == "names":
        return (dict(zip(names, row, strict=True)),)
    return (types.SimpleNamespace(**dict(zip(names, row, strict=True))),)


def ask(entry: Any, job: dict[str, Any], rows: list[Any], labels: dict[Any, int]) -> np.ndarray:
    """The label of each row, in their order."""
    out = np.zeros(len(rows), np.int32)
    for number, row in enumerate(rows):
        try:
            label = label_of(entry(*given_as(job["form"], job["names"], row)))
        except Exception as error:
            label = "raised", type(error).__name__
        out[number] = labels.setdefault(label, len(labels))
    return out


def answer(job: dict[str, Any], place: Path) -> None:
    """Runs one source and writes what it answers."""
    module = types.ModuleType(place.stem)
    sys.modules[place.stem] = module
    labels: dict[Any, int] = {}
    said: dict[str, Any] = {"failed": ""}
    try:
        exec(compile(job["source"], place.name, "exec"), module.__dict__)
        entry = eval(job["entry"], module.__dict__)
        numbers = numbers_of(ast.parse(job["source"]), module.__dict__)
    except Exception as error:
        place.with_suffix(".answers").write_text(json.dumps({"failed": f"{type(error).__name__}: {error}"}))
        return
    tests = [(tuple(terms), bound, {int(key): ends for key, ends in box.items()}) for terms, bound, box in job["tests"]]
    rows = observing.draw(["float" if job["single"] else "double"] * len(job["names"]), numbers, tests, job["seed"])
    if job["nan"]:
        rows[::17, 0] = np.nan
        rows[5::23, -1] = np.nan
    arrays: dict[str, np.ndarray] = {}
    for number, form in enumerate(job["given"]):
        some = rows[number :: number + 1]  # half of them for a second form
        held = some.tolist() if form == "floats" else list(some.astype(form))
        arrays[f"{form} rows"] = some
        arrays[form] = ask(entry, job, held, labels)
        arrays[f"{form} again"] = ask(entry, job, held[:AGAIN][::-1], labels)[::-1]
    np.savez(place.with_suffix(".npz"), **arrays)
    said["labels"] = list(labels)
    said["names"] = {name: value for name, value in vars(module).items() if type(value) is int}
    place.with_suffix(".answers").write_text(json.dumps(said))


def in_turn(jobs: list[tuple[Path, Callable[[], None]]]) -> None:
    """Runs jobs, each of which writes its file last; one that dies or has no end costs its own file alone."""
    first = 0
    while first < len(jobs):
        child = os.fork()
        if child == 0:
            try:
                for _, run in jobs[first:]:
                    signal.setitimer(signal.ITIMER_PROF, SECONDS)  # of the processor, which others may use too
                    run()
            finally:
                os._exit(0)
        os.waitpid(child, 0)
        missing = (number for number in range(first, len(jobs)) if not jobs[number][0].exists())
        first = next(missing, len(jobs)) + 1


def main(folder: Path) -> None:
    """Answers every job of a folder."""
    warnings.simplefilter("ignore")
    np.seterr(all="ignore")
    for module in (
        "dataclasses",
        "enum",
        "functools",
        "math",
        "collections",
        "itertools",
        "operator",
        "typing",
        "bisect",
        "re",
    ):
        importlib.import_module(module)  # once for all processes
    silent = os.open(os.devnull, os.O_WRONLY)
    os.dup2(silent, 1)
    os.dup2(silent, 2)
    jobs = json.loads((folder / "jobs.json").read_text())
    in_turn(
        [
            (folder / f"job_{number}.answers", partial(answer, job, folder / f"job_{number}.py"))
            for number, job in enumerate(jobs)
        ]
    )


if __name__ == "__main__":
    main(Path(sys.argv[1]))
