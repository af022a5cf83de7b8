"""Recipes: of which cells, line-ups and measures a number of the report is made, and how.

Does: finds the cells of a comparison; writes ratios, robustness, exploitability and attention as weighted terms.
Assumes: the line-ups that cells are played with; algorithms that are compared share their seeds and so their episodes.
Does not: judge a number (verdicts.py), or show it.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from codegen.ir import Float64
from maviper.evaluation.exploitability import OWN
from maviper.reproduction import register
from maviper.reproduction.cells.cell import BLOCKS, CROSSPLAY, EXPERT, EXPLOITABILITY, EXTRACTION
from maviper.reproduction.cells.making import CHOSEN_ON
from maviper.reproduction.cells.table import Results, Row
from maviper.reproduction.statistics import INVERSE, RATIO, REWARD, VALUE, Estimate, Term, estimate
from maviper.worlds import World, find
from maviper.worlds.world import RETURN

OPPONENTS = ("maviper", "iviper", "imitation", "fitted-q", "expert")  # of the paper's Tables 1, 3 and 4
Path_ = tuple[str, ...]


@lru_cache(maxsize=64)
def game_of(name: str) -> World:
    """The game of a name, to be asked only: one is made once, which takes longer than what is asked of it."""
    return find(name)


@dataclass(frozen=True)
class Source:
    """Values of one line-up for each seed; or, of each seed's facts, the weighted sum of those at some paths."""

    places: tuple[tuple[str, str], ...]  # (cell, line-up) of each seed
    measure: str = ""
    facts: tuple[tuple[float, Path_], ...] = ()
    absolute: bool = False  # of the sum of facts

    def rows(self, results: Results) -> list[tuple[Float64, Float64]]:
        """Each seed's episodes and values. KeyError where a cell lacks them."""
        if not self.facts:
            return [results.values(cell)[lineup, self.measure] for cell, lineup in self.places]
        sums = [sum(weight * fact(results.facts(cell), path) for weight, path in self.facts) for cell, _ in self.places]
        return [(np.zeros(1), np.array([abs(each) if self.absolute else each])) for each in sums]

    @property
    def document(self) -> dict[str, Any]:
        """The source as plain data."""
        return {"places": self.places, "measure": self.measure, "facts": self.facts, "absolute": self.absolute}


def fact(facts: Mapping[str, Any], path: Path_) -> float:
    """A number in the facts of a cell. KeyError where there is none."""
    node: Any = facts
    for name in path:
        node = node[name]
    if not isinstance(node, int | float):
        raise KeyError(path)
    return float(node)


@dataclass(frozen=True)
class Part:
    """One term of a number, before its values are read. `mode`: as of `Term`."""

    weight: float
    ours: Source
    theirs: Source | None = None
    mode: str = VALUE

    @property
    def document(self) -> dict[str, Any]:
        """The part as plain data."""
        theirs = None if self.theirs is None else self.theirs.document
        return {"weight": self.weight, "mode": self.mode, "ours": self.ours.document, "theirs": theirs}


Parts = Sequence[Part]


def times(weight: float, parts: Parts) -> list[Part]:
    """The parts, each with a factor."""
    return [replace(part, weight=weight * part.weight) for part in parts]


def less(ours: Parts, theirs: Parts) -> list[Part]:
    """The difference of two numbers."""
    return [*ours, *times(-1.0, theirs)]


def estimate_parts(results: Results, parts: Parts) -> tuple[Estimate, int, int]:
    """Sums up parts, with the numbers of seeds and of episodes for each. KeyError where a cell lacks values."""
    rows = [part.ours.rows(results) for part in parts]
    seeds = (set[float].intersection(*(set(of[k][0].tolist()) for of in rows)) for k in range(len(rows[0])))
    common: list[Float64] = [np.array(sorted(each)) for each in seeds]
    length = min(map(len, common))
    if not length:
        raise KeyError("no common episodes")
    common = [each[:length] for each in common]
    terms: list[Term] = []
    for part, ours in zip(parts, rows, strict=True):
        theirs = None if part.theirs is None else _at(part.theirs.rows(results), common)
        terms.append(Term(part.weight, _at(ours, common), theirs, part.mode))
    crossed = len(common) > 1 and all(np.array_equal(common[0], each) for each in common)
    return estimate(terms, crossed), len(common), length


def _at(rows: Sequence[tuple[Float64, Float64]], episodes: Sequence[Float64]) -> Float64:
    """The values in the episodes wanted of each seed, [seeds, episodes]."""
    aligned: list[Float64] = []
    for (seeds, values), wanted in zip(rows, episodes, strict=True):
        places = np.searchsorted(seeds, wanted)
        if places.max() >= len(seeds) or not np.array_equal(seeds[places], wanted):
            raise KeyError("an expert's episodes are missing")
        aligned.append(values[places])
    return np.stack(aligned)


@dataclass(frozen=True)
class Number:
    """A number of the report, with what it is made of."""

    id: str
    parts: Parts
    estimate: Estimate
    seeds: int
    episodes: int  # of each seed

    @property
    def value(self) -> float:
        """The number itself."""
        return self.estimate.value

    @property
    def document(self) -> dict[str, Any]:
        """The number as plain data; None for what is not finite."""
        low, high = self.estimate.interval()
        numbers = {"value": self.value, "low": low, "high": high, "error": self.estimate.error}
        told = {name: float(value) if np.isfinite(value) else None for name, value in numbers.items()}
        counts = {"freedom": self.estimate.freedom, "seeds": self.seeds, "episodes": self.episodes}
        return {**told, **counts, "parts": [part.document for part in self.parts]}


class Book:
    """All numbers of a report, each under its id, so that somebody else can compute them again."""

    def __init__(self, results: Results) -> None:
        self.results = results
        self.finder = Finder(results)
        self.numbers: dict[str, Number] = {}

    def number(self, name: str, parts: Parts) -> Number:
        """The number under its name. KeyError where a cell lacks what it is made of."""
        if name not in self.numbers:
            self.numbers[name] = Number(name, parts, *estimate_parts(self.results, parts))
        return self.numbers[name]


# --- where a number is found


@dataclass(frozen=True)
class Place:
    """Cells of one comparison, up to algorithm and seed. `splits` "": those that most cells have."""

    game: str
    expert: str
    preset: str = "paper"
    depth: int = 4
    measure: str = ""
    splits: str = ""

    @property
    def team(self) -> str:
        """The team that the measure is of."""
        return self.measure.partition(" ")[0]

    @property
    def world(self) -> World:
        """The game."""
        return game_of(self.game)


class Finder:
    """Finds the cells of numbers in a table."""

    def __init__(self, results: Results) -> None:
        self.results = results
        self._alike: dict[tuple[str | int, ...], list[Row]] = {}
        for row in results.rows:
            algorithm = "" if row.kind == CROSSPLAY else row.algorithm
            key = row.kind, row.game, row.expert, row.preset, row.depth, algorithm
            self._alike.setdefault(key, []).append(row)

    def rows(self, place: Place, algorithm: str, kind: str = EXTRACTION) -> dict[int, Row]:
        """Seed -> cell."""
        algorithm = "" if kind == CROSSPLAY else algorithm
        key = kind, place.game, place.expert, place.preset, place.depth, algorithm
        rows = self._alike.get(key, [])
        every = [row.splits for row in rows]
        splits = place.splits or max(sorted(set(every)), key=every.count, default="")
        return {row.seed: row for row in rows if row.splits == splits}

    def seeds(self, place: Place, algorithms: Iterable[str], kind: str = EXTRACTION) -> list[int]:
        """The seeds that all of some algorithms have; KeyError where there is none."""
        common = set[int].intersection(*(set(self.rows(place, each, kind)) for each in algorithms))
        if not common:
            raise KeyError("no cells")
        return sorted(common)

    def expert(self, place: Place, seed: int) -> str:
        """The cell in which the expert plays the episodes of a seed. KeyError where there is none."""
        rows = self._alike.get((EXPERT, place.game, place.expert, "", 0, ""), [])
        cells = [row.cell for row in rows if row.seed <= seed < row.seed + BLOCKS]
        if not cells:
            raise KeyError("no cell of the expert")
        return cells[-1]  # in a comparison every seed has one

    def sources(
        self, place: Place, algorithm: str, lineup: str, seeds: Sequence[int], kind: str = EXTRACTION
    ) -> Source:
        """A line-up's values in each seed."""
        rows = self.rows(place, algorithm, kind)
        return Source(tuple((rows[seed].cell, lineup) for seed in seeds), place.measure)

    def experts(self, place: Place, seeds: Sequence[int]) -> Source:
        """The expert's values beside each seed's."""
        return Source(tuple((self.expert(place, seed), EXPERT) for seed in seeds), place.measure)

    def alone(self, place: Place) -> Source:
        """The expert's values in the episodes of the first ten seeds that there are, as one row."""
        rows = self._alike.get((EXPERT, place.game, place.expert, "", 0, ""), [])
        return self.experts(place, [min((row.seed for row in rows), default=0)])

    # --- statistics

    def absolute(self, place: Place, algorithm: str, lineups: Sequence[str], seeds: Sequence[int]) -> list[Part]:
        """The mean over line-ups of the measure itself."""
        return [Part(1 / len(lineups), self.sources(place, algorithm, lineup, seeds)) for lineup in lineups]

    def ratio(
        self, place: Place, algorithm: str, lineups: Sequence[str], seeds: Sequence[int], mode: str = ""
    ) -> list[Part]:
        """The mean over line-ups of the performance ratio to the expert."""
        mode = mode or self.mode(place.measure)
        theirs = self.experts(place, seeds)
        parts = self.absolute(place, algorithm, lineups, seeds)
        return [replace(part, theirs=theirs, mode=mode) for part in parts]

    def mode(self, measure: str) -> str:
        """Returns the way in which a measure is divided by the expert's."""
        if measure.endswith(f" {RETURN}"):
            return REWARD
        return RATIO if self.results.higher[measure] else INVERSE

    def lineups(self, place: Place, statistic: str) -> list[str]:
        """The line-ups of the individual or the joint performance of the measure's team."""
        if statistic == register.JOINT:
            return [f"joint:{place.team}"]
        return [f"individual:{agent}" for agent in place.world.teams[place.team]]

    def performance(self, place: Place, algorithm: str, statistic: str, seeds: Sequence[int]) -> list[Part]:
        """The individual or joint performance ratio, or the first less the second."""
        if statistic == register.LESS_JOINT:
            both = [self.performance(place, algorithm, each, seeds) for each in (register.INDIVIDUAL, register.JOINT)]
            return less(*both)
        return self.ratio(place, algorithm, self.lineups(place, statistic), seeds)

    def against(self, place: Place, algorithm: str, opponents: Sequence[str], seeds: Sequence[int]) -> list[Part]:
        """The mean over opponents of the measure itself."""
        lineups = [f"{place.team}:{algorithm}-vs-{other}" for other in opponents]
        sources = [self.sources(place, "", lineup, seeds, CROSSPLAY) for lineup in lineups]
        return [Part(1 / len(opponents), source) for source in sources]

    def robustness(self, place: Place, algorithm: str, opponents: Sequence[str], seeds: Sequence[int]) -> list[Part]:
        """Divides `against` by what the expert reaches against itself; negative where lower is better. Returns may be
        below 0, where a larger fraction would be a lower return: they are rewards as in `mode`.
        """
        sign, mode = self.sign(place.measure), self.mode(place.measure)
        theirs = self.experts(place, seeds)
        parts = self.against(place, algorithm, opponents, seeds)
        mode = mode if mode == REWARD else RATIO
        return [replace(part, weight=sign * part.weight, theirs=theirs, mode=mode) for part in parts]

    def exploitability(self, place: Place, algorithm: str, team: str, seeds: Sequence[int]) -> list[Part]:
        """Returns the chosen responder's gain over the team's own opponents, on the episodes that are reported."""
        cells = [row.cell for seed, row in self.rows(place, algorithm, EXPLOITABILITY).items() if seed in seeds]
        chosen = [self.responder(cell, team) for cell in cells]
        measure = self.worth(cells[0], team)
        theirs = tuple((cell, f"{team}:{OWN}") for cell in cells)
        ours = tuple((cell, f"{team}:{name}") for cell, name in zip(cells, chosen, strict=True))
        sign = self.sign(measure)
        return [Part(sign, Source(ours, measure)), Part(-sign, Source(theirs, measure))]

    def sign(self, measure: str) -> float:
        """1 where more is better."""
        return 1.0 if self.results.higher[measure] else -1.0

    def worth(self, cell: str, team: str) -> str:
        """Returns the measure by which responders to a team are judged: the one of its line-ups that is no return."""
        names = {measure for lineup, measure in self.results.values(cell) if lineup.startswith(f"{team}:")}
        names = {name for name in names if not name.endswith(RETURN)}
        if not names:
            raise KeyError("no responders")
        return min(names)

    def responder(self, cell: str, team: str) -> str:
        """The responder that is best on the episodes to choose on, of those that are also reported."""
        values, measure = self.results.values(cell), self.worth(cell, team)
        start = f"{team}:"
        tried: dict[str, float] = {}
        for lineup, of in values:
            name = lineup.removeprefix(start).removesuffix(CHOSEN_ON)
            if of == measure and lineup.startswith(start) and lineup.endswith(CHOSEN_ON):
                reported = (start + name, measure) in values
                tried |= {name: self.sign(measure) * float(values[lineup, measure][1].mean())} if reported else {}
        if not tried:
            raise KeyError("no responder")
        return max(sorted(tried), key=tried.__getitem__)

    def attention(self, place: Place, algorithm: str, statistic: str, seeds: Sequence[int]) -> list[Part]:
        """Where defenders look: how far apart their preferences between the targets are, from 0 to 1; or the share
        of their importance that the goal's features have.
        """
        rows = self.rows(place, algorithm)
        places = tuple((rows[seed].cell, "") for seed in seeds)
        told = self.results.facts(places[0][0])["importances"]
        defenders = [agent for agent in place.world.teams["defenders"] if agent in told]
        facts: list[tuple[float, Path_]] = []
        for number, agent in enumerate(defenders):
            for feature in told[agent][IMPURITY]:
                path, entity = ("importances", agent, IMPURITY, feature), feature.rpartition("_")[0]
                if statistic == register.TO_THE_GOAL and entity == "goal":
                    facts.append((1 / len(defenders), path))
                elif statistic == register.APART and entity in TARGETS and number < len(TARGETS):
                    facts.append((0.5 * TARGETS[entity] * (-1) ** number, path))
        if not facts:
            raise KeyError("no importances")
        return [Part(1.0, Source(places, facts=tuple(facts), absolute=statistic == register.APART))]


IMPURITY = "impurity"
TARGETS = {"landmark_0": 1, "landmark_1": -1}  # a defender's preference is its importance on the first less the second
