"""Random Python sources, imported and asked beside Python itself: kinds `python-sources` and `python-beyond`.

Does: imports so many sources at once, has Python answer them in one process, and compares.
Assumes: python_child.py runs sources; judging.py knows what is wrong.
Does not: draw sources.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from tests.hunting.sources import judging, python_beyond, python_programs
from tests.hunting.sources.drafts import Program, take
from tests.hunting.sources.judging import Import, Told

ROOT = Path(__file__).parents[3]
SHORT = 500  # characters of a source that a finding keeps


def program(seed: int, beyond: bool) -> Program:
    """The source of a seed."""
    return take(python_programs.make, seed, python_beyond.STEPS) if beyond else python_programs.make(seed)[1]


def judge(programs: list[Program], run: bool = False) -> list[Told]:
    """Imports programs, has Python answer, and compares."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        every = [Told(each.seed, kind=each.step or each.form) for each in programs]
        imports = [
            judging.read(each, folder / f"policy_{place}.py", told, run)
            for place, (each, told) in enumerate(zip(programs, every, strict=True))
        ]
        asked = [place for place, each in enumerate(imports) if each is not None]
        jobs = [job_of(each) for each in imports if each is not None]
        (folder / "jobs.json").write_text(json.dumps(jobs))
        command = [sys.executable, "-m", "tests.hunting.sources.python_child", str(folder)]
        subprocess.run(command, cwd=ROOT, check=True, stdin=subprocess.DEVNULL)
        for number, place in enumerate(asked):
            read = imports[place]
            assert read is not None
            _judge_answers(read, folder / f"job_{number}.py", jobs[number]["given"], every[place])
    for told, each in zip(every, programs, strict=True):
        told.wrong = [f"{text}\n{each.source[:SHORT]}" for text in told.wrong]
    return every


def job_of(read: Import) -> dict[str, Any]:
    """What Python is asked."""
    program = read.program
    given = ["floats"] * ("floats" in read.given) + [
        each for each in ("float64", "float32") if f"{each} array" in read.given
    ]
    return {
        "source": program.source,
        "entry": program.entry,
        "form": program.form,
        "names": [feature.name for feature in program.features],
        "given": given,
        "single": given == ["float32"],
        "nan": read.nan,
        "tests": read.tests,
        "seed": program.seed,
    }


def _judge_answers(read: Import, place: Path, given: list[str], told: Told) -> None:
    if not given:
        told.wrong.append(f"given what? {read.given}")
        return
    if not place.with_suffix(".answers").exists():
        told.wrong.append("Python comes to no end, or dies")
        return
    said = json.loads(place.with_suffix(".answers").read_text())
    if said["failed"]:
        told.wrong.append(f"Python does not run it: {said['failed']}")
        return
    if all(tuple(each) == ("raised", "TypeError") for each in said["labels"]):
        told.unasked = True  # a step made it take another kind of observation than the program that it was drawn from
        return
    with np.load(place.with_suffix(".npz")) as arrays:
        for form in given:
            rows, again = arrays[f"{form} rows"], arrays[f"{form} again"]
            other = np.flatnonzero(arrays[form][: len(again)] != again)
            if len(other):
                told.wrong.append(f"Python answers {form} {rows[other[0]].tolist()} in two ways: state")
            else:
                judging.compare(read, rows, arrays[form], said["labels"], f"given {form}", told, said["names"])


ask = judging.asking(program, judge)
