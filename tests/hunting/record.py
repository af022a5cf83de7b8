"""The record of a hunt: how far it came, what was answered, what was wrong; a folder that a later run goes on in.

Does: counts answers, keeps findings as JSON lines and the state as JSON, written atomically; prints the figures.
Assumes: questions are asked in the order of their seeds.
Does not: ask.
"""

import json
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

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
