"""Runs of several seeds: one folder each, and the best of their results.

Does: says which folders and numbers such a run may have, chooses by score, and writes the table of scores.
Assumes: results come in the order of their seeds; higher scores are better.
Does not: run anything.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

from codegen.errors import InputError
from maviper.files import runs

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
    if jobs < 1 or not 1 <= seeds <= MAX_SEEDS:
        raise InputError(f"--seeds must be from 1 to {MAX_SEEDS}, --jobs at least 1", "--seeds, --jobs")


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
