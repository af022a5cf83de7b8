"""A standing hunt for false words of the verifier: random questions, every answer judged by other means.

    python -m tests.hunt FOLDER [--kinds decisions,episodes,...] [--minutes 60] [--count N] [--first SEED]
    python -m tests.hunt FOLDER --show                          `generated/hunt`: the questions that are on record
    python -m tests.hunt --seed 4711 [--kinds episodes]        one question again, with every check

Does: asks questions from their seeds, goes on where the folder's last run ended, keeps what is wrong, prints figures.
Assumes: nothing; a finding is a seed, which asks the same question again.
Does not: mend, or minimise what it finds.

The judge (hunting/reading, meaning, places, judge, playing, stated, giving, summing) knows profiles by their files and
claims by their definitions, and imports nothing of ours. A verdict is wrong when it refutes it: PROVED by any violating
state or start, VIOLATED by a counterexample that is none. UNKNOWN is counted.

Kinds of sources ask readers instead (hunting/sources): random Python and C of the subset that the manual states, and
sources one step out of it (`-beyond`). Python itself and compiled C are the judge. A reading is wrong when one row is
decided otherwise. Kinds end in `-compared` where sources are also compared by the product itself, as a user has it.
"""

import argparse
import os
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from tests.hunting import asking, driven, episodes, files, following, game_sums, outputs, questions, systems
from tests.hunting.record import Record
from tests.hunting.sources import c_sources, python_sources

KINDS: dict[str, Callable[[int, bool], Any]] = {
    "decisions": lambda seed, thorough: asking.ask(questions.drawn(seed), thorough),
    "episodes": lambda seed, thorough: episodes.ask(episodes.drawn(seed), thorough),
    "contacts": lambda seed, thorough: episodes.ask(episodes.drawn(seed, episodes.PUSHING), thorough),
    "doubles": lambda seed, thorough: asking.ask(questions.drawn(seed, doubled=True), thorough),
    "systems": systems.ask,
    "files": files.ask,
    "following": following.ask,
    "outputs": outputs.ask,
    "driven": driven.ask,
    "game-sums": game_sums.ask,
    "double-episodes": lambda seed, thorough: episodes.ask(episodes.drawn(seed, doubled=True), thorough),
    "python-sources": python_sources.ask,
    "python-beyond": partial(python_sources.ask, beyond=True),
    "python-compared": partial(python_sources.ask, run=True),
    "python-beyond-compared": partial(python_sources.ask, beyond=True, run=True),
    "c-sources": c_sources.ask,
    "c-beyond": partial(c_sources.ask, beyond=True),
    "c-compared": partial(c_sources.ask, run=True),
    "c-beyond-compared": partial(c_sources.ask, beyond=True, run=True),
}
READING = tuple(kind for kind in KINDS if kind.startswith(("python-", "c-")))


def hunt(kind: str, folder: Path | None, count: int | None, seconds: float | None, first: int = 0) -> Record:
    """Asks the next `count` questions, or for so many seconds, or until interrupted."""
    record, begun = Record(kind, folder, first), time.monotonic()
    try:
        while count is None or record.next < record.first + count:
            if seconds is not None and time.monotonic() - begun >= seconds:
                break
            last = spend()
            told = KINDS[kind](record.next, False)
            record.add(told, spend() - last)
    except KeyboardInterrupt:
        pass
    record.save()
    return record


def spend() -> float:
    """CPU seconds so far, those of ended children among them."""
    return sum(os.times()[:4])


def main() -> int:
    """The command; 1 where something is wrong."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", type=Path, help="where the record is kept")
    parser.add_argument("--kinds", default=",".join(KINDS))
    parser.add_argument("--minutes", type=float, help="for each kind; without it and --count until interrupted")
    parser.add_argument("--count", type=int, help="questions of each kind, those of earlier runs included")
    parser.add_argument("--first", type=int, default=0, help="the first seed of a new record")
    parser.add_argument("--seed", type=int, help="ask this question again")
    parser.add_argument("--show", action="store_true", help="print the record")
    given = parser.parse_args()
    kinds = given.kinds.split(",")
    if given.seed is not None:
        found = [KINDS[kind](given.seed, True) for kind in kinds]
        print(*found, sep="\n")
        return int(any(told.wrong for told in found))
    seconds = 0.0 if given.show else None if given.minutes is None else 60 * given.minutes
    records = [hunt(kind, given.folder, given.count, seconds, given.first) for kind in kinds]
    for record in records:
        record.show()
    return int(any(record.wrong for record in records))


if __name__ == "__main__":
    raise SystemExit(main())
