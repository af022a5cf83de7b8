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
import json
import os
import time
from collections import Counter
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from tests.hunting import asking, driven, episodes, files, following, game_sums, outputs, questions, systems
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


SAVED_EVERY = 50


class Record:
    """Counts of one kind of questions, in `folder` where there is one."""

    def __init__(self, kind: str, folder: Path | None, first: int = 0) -> None:
        self.kind, self._folder = kind, folder
        self.first = self.next = first
        self.counts: Counter[str] = Counter()
        self.depths: Counter[int] = Counter()
        self.wrong: list[dict[str, Any]] = []
        self.seconds = 0.0
        if folder is not None:
            folder.mkdir(parents=True, exist_ok=True)
            if self._state.exists():
                self._load()

    @property
    def _state(self) -> Path:
        assert self._folder is not None
        return self._folder / f"{self.kind}.json"

    def _load(self) -> None:
        kept = json.loads(self._state.read_text())
        self.first, self.next, self.seconds, self.wrong = kept["first"], kept["next"], kept["seconds"], kept["wrong"]
        self.counts = Counter(kept["counts"])
        self.depths = Counter({int(depth): count for depth, count in kept["depths"].items()})

    def add(self, told: Any, seconds: float) -> None:
        """Notes the answer to the next question."""
        self.next = told.seed + 1
        self.seconds += seconds
        self.depths[told.depth] += 1
        self.counts["asked"] += 1
        self.counts[f"verdict {told.verdict.partition(':')[0]}"] += 1
        self.counts[f"claim {told.kind}"] += 1
        for key, value in told.tally().items():
            self.counts[key] += int(value)
        self.wrong += [{"seed": told.seed, "claim": told.kind, "wrong": text[:2_000]} for text in told.wrong]
        if self._folder is not None and (told.wrong or self.counts["asked"] % SAVED_EVERY == 0):
            self.save()

    def save(self) -> None:
        """Writes the state, whole or not at all."""
        if self._folder is None:
            return
        kept = {key: getattr(self, key) for key in ("kind", "first", "next", "seconds", "wrong")}
        kept |= {"counts": dict(sorted(self.counts.items())), "depths": dict(sorted(self.depths.items()))}
        beside = self._state.with_suffix(".part")
        beside.write_text(json.dumps(kept, indent=1, ensure_ascii=True) + "\n")
        beside.replace(self._state)

    @property
    def median_depth(self) -> int:
        """Half of the teams' deepest trees have at least so many splits on a path."""
        return sorted(self.depths.elements())[sum(self.depths.values()) // 2] if self.depths else 0

    def share(self, key: str) -> float:
        """Of all questions."""
        return self.counts[key] / max(1, self.counts["asked"])

    @property
    def reads(self) -> bool:
        """Whether sources are read, and no claims are asked."""
        return self.counts["verdict IMPORTED"] + self.counts["verdict REFUSED"] > 0

    @property
    def row(self) -> str:
        """The figures as a row of a table."""
        if self.reads:
            came, rows = self.share("verdict IMPORTED"), self.counts["rows compared"]
            return f"| {self.kind} | {self.counts['asked']:,} | {came:.1%} | {rows:,} | {len(self.wrong)} |".replace(
                "%", " %"
            )
        shares = ("proved, not vacuous", "verdict VIOLATED", "verdict UNKNOWN", "bound within 2 % of the extreme")
        forged, refused = self.counts["certificates forged"], self.counts["certificates forged, refused"]
        told = [f"{self.share(key):.1%}".replace("%", " %") for key in shares]
        return " | ".join([f"| {self.kind}", f"{self.counts['asked']:,}", *told, f"{refused} of {forged}", ""]).rstrip()

    def show(self, say: Callable[[str], None] = print) -> None:
        """The figures."""
        asked = self.counts["asked"]
        say(f"{self.kind}: seeds {self.first} to {self.next - 1}, {asked} questions, {self.seconds:.0f} CPU s")
        if self.reads:
            say(f"  come in {self.share('verdict IMPORTED'):.2%}, {asked / max(1e-9, self.seconds):.1f} per CPU s")
            self._show_counts(say)
            return
        proved, violated = self.share("proved, not vacuous"), self.share("verdict VIOLATED")
        unknown, depth = self.share("verdict UNKNOWN"), self.median_depth
        say(f"  proved and not vacuous {proved:.1%}, violated {violated:.1%}, unknown {unknown:.2%}, depth {depth}")
        self._show_counts(say)

    def _show_counts(self, say: Callable[[str], None]) -> None:
        for key, count in sorted(self.counts.items()):
            say(f"  {key:<40} {count:>9}")
        say(f"  wrong words: {len(self.wrong)}")
        for one in self.wrong[:20]:
            say(f"    seed {one['seed']} ({one['claim']}): {one['wrong'][:300]}")


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
