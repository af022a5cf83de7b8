"""Compiled C's own answers to a folder of jobs: `python -m tests.hunting.sources.c_child FOLDER`.

Does: asks each function of each shared object, and writes what it answers.
Assumes: a process that computes too long is ended by its timer; one that dies leaves no answers.
Does not: compile.
"""

import ctypes
import json
import os
import sys
from functools import partial
from pathlib import Path

import numpy as np

from tests.hunting.sources.python_child import in_turn

AGAIN = 300  # rows that are asked twice, the second time backwards


def ask(library: ctypes.CDLL, name: str, rows: np.ndarray, whole: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The answer to each row, and where there is none."""
    rows, whole = np.ascontiguousarray(rows), np.ascontiguousarray(whole)
    out, idle = np.zeros(len(rows), np.int64), np.zeros(len(rows), np.uint8)
    given = [each.ctypes.data_as(ctypes.c_void_p) for each in (rows, whole, out, idle)]
    getattr(library, f"drive_{name}")(given[0], given[1], ctypes.c_long(len(rows)), given[2], given[3])
    return out, idle


def answer(folder: Path, seed: int) -> None:
    """Asks one program in every build."""
    arrays: dict[str, np.ndarray] = {}
    with np.load(folder / f"rows_{seed}.npz") as kept:
        rows, whole = kept["rows"], kept["whole"]
    for path in sorted(folder.glob("*.so")):
        library = ctypes.CDLL(str(path))
        build = path.stem
        arrays[build], arrays[f"{build} idle"] = ask(library, str(seed), rows, whole)
        if build == "plain":
            again, idle = ask(library, str(seed), rows[:AGAIN][::-1], whole[:AGAIN][::-1])
            arrays["again"], arrays["again idle"] = again[::-1], idle[::-1]
            labels = (ctypes.c_longlong * 16).in_dll(library, f"labels_{seed}")
            arrays["labels"] = np.array(list(labels))
    np.savez(folder / f"answers_{seed}.npz", **arrays)


def main(folder: Path) -> None:
    """Answers every job of a folder."""
    silent = os.open(os.devnull, os.O_WRONLY)
    os.dup2(silent, 1)
    os.dup2(silent, 2)
    seeds = json.loads((folder / "jobs.json").read_text())
    in_turn([(folder / f"answers_{seed}.npz", partial(answer, folder, seed)) for seed in seeds])


if __name__ == "__main__":
    main(Path(sys.argv[1]))
