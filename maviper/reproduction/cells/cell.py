"""The cell: the unit of a reproduction, with an identity that names its folder, and what it costs.

Does: says what a cell is, which settings it stands for, what makes two cells the same; the form of its files; estimates
  its CPU seconds by those of its kind, game, algorithm, preset and splits, linearly between depths; one that was not
  measured by the nearest that was, times a factor.
Assumes: what an identity holds decides every byte that a cell gives, on machines of one kind; costs.toml, which
  tests/benchmarks/reproduce.py measured on one core of one machine.
Does not: make cells (making.py), choose which there are (plan.py), or know how fast this machine is.
"""

import hashlib
import json
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, field, replace
from functools import cache, cached_property, lru_cache
from importlib import resources
from itertools import product
from typing import Any

import numpy as np

from maviper.episodes import measures
from maviper.experts import network
from maviper.experts.expert import Expert
from maviper.experts.finding import find_expert
from maviper.extraction.settings import (
    BUNDLES,
    EXACT,
    EXPLORING,
    FITTED_Q,
    HISTOGRAM,
    IMITATION,
    IVIPER,
    IVIPER_RESAMPLING,
    MAVIPER,
    NO_PREDICTION,
    PAPER,
    RELEASED,
    RGMDT,
    VARIANTS,
    VIPER,
    Settings,
)
from maviper.files.profiles import version
from maviper.worlds import World, find

FORMAT = "maviper-cell-1"
EXPERT, EXTRACTION, CROSSPLAY, EXPLOITABILITY = "expert", "extraction", "crossplay", "exploitability"
KINDS = (EXPERT, EXTRACTION, CROSSPLAY, EXPLOITABILITY)
ID_LETTERS = 16
EPISODES = 200  # of one seed, for every line-up
BLOCKS = 10  # seed k plays block k of the held-out episodes; a cell of an expert has ten blocks from its seed on
DONE, FAILED = "done", "failed"


@dataclass(frozen=True)
class Cell:
    """The subject of a cell, as the table of all cells shows it. Empty and 0: it does not matter here."""

    kind: str
    game: str
    expert: str  # its label
    preset: str = ""
    algorithm: str = ""  # a name of `maviper extract`, or of a rung
    depth: int = 0
    leaves: int = 0  # of each tree, at most; 0: no budget
    splits: str = ""
    seed: int = 0

    @property
    def said(self) -> str:
        """The cell in a few words."""
        words = [self.kind, self.game, self.expert, self.preset, self.algorithm]
        words += [f"depth {self.depth}"] * bool(self.depth) + [f"leaves {self.leaves}"] * bool(self.leaves)
        words += [f"{EXACT} splits"] * (self.splits == EXACT)
        seed = [f"seed {self.seed}"] * (self.kind != EXPERT or self.seed > 0)
        return " ".join([word for word in words if word] + seed)

    @property
    def episodes(self) -> range:
        """The held-out episode seeds that it plays; those of an expert hold those of ten seeds."""
        first = measures.MEASUREMENT_SEEDS + EPISODES * self.seed
        return range(first, first + EPISODES * (BLOCKS if self.kind == EXPERT else 1))


@dataclass(frozen=True, eq=False)
class Named:
    """An expert and its world as a user named them, by texts or as objects. Each is like itself alone."""

    expert: Any
    world: Any = None  # None: as the expert says


@dataclass(frozen=True)
class Source:
    """Where an expert comes from: a name, or the bytes of a file, so that it can be had on any machine; or what a user
    named.
    """

    text: str
    data: bytes = b""
    world: str = ""  # the name of the world that it plays
    named: Named | None = None

    def read(self) -> tuple[Expert, World]:
        """The expert and its world."""
        return _read(self)


@lru_cache(maxsize=16)
def _read(source: Source) -> tuple[Expert, World]:
    if source.named is not None:
        return find_expert(source.named.expert, world=source.named.world, giving=True)
    if not source.data:
        return find_expert(source.text)
    world = find(source.world)
    return network.decode(source.data, source.text, world), world


def settings_of(cell: Cell, world: World) -> Settings:
    """The settings of an extraction cell, resolved."""
    rung = VARIANTS[cell.algorithm] if cell.algorithm not in BUNDLES else {"algorithm": cell.algorithm}
    agent = {"agent": world.agents[0]} if cell.algorithm == "viper" else {}  # of the first; the others follow
    given = {"preset": cell.preset, "max_depth": cell.depth, "seed": cell.seed, "splits": cell.splits or None}
    budget = {"max_leaves": cell.leaves} if cell.algorithm == RGMDT else {}  # for others a depth does it
    return Settings.of({**given, **rung, **agent, **budget}, world).complete().deal_budget(world)


@dataclass(frozen=True)
class Budget:
    """The episodes that a cell of a comparison may play. Its trees are measured as teams among experts; beside that are
    told their sizes, how like the expert they act, and what they played.
    """

    extraction: int  # episodes
    held_out: int  # episodes of one seed, for every line-up
    settings: tuple[tuple[str, Any], ...] = ()  # further ones of all extractions

    def deal(self, cell: Cell, world: World) -> Settings:
        """The settings of an extraction cell, resolved. VIPER's, of each agent alone, share the episodes."""
        agent = {"agent": world.agents[0]} if cell.algorithm == VIPER else {}
        share = self.extraction // (len(world.agents) if agent else 1)
        about = {"algorithm": cell.algorithm, "max_depth": cell.depth, "seed": cell.seed, "budget": share}
        return Settings.of({**about, **agent, **dict(self.settings)}, world).complete().deal_budget(world)

    def episodes(self, cell: Cell) -> range:
        """The held-out episode seeds that it plays, which are the expert's of that seed, too."""
        first = measures.MEASUREMENT_SEEDS + self.held_out * cell.seed
        return range(first, first + self.held_out)


@dataclass(frozen=True)
class Task:
    """A cell with all that making it takes."""

    cell: Cell
    source: Source
    expert_hash: str
    register: str  # hash of the claims that were written before
    of: Mapping[str, str] = field(default_factory=dict[str, str])  # algorithm -> id of the cell whose profile it needs
    effort: Mapping[str, int] = field(default_factory=dict[str, int])  # what is spent on responders
    budget: Budget | None = None  # of a comparison; None: as the paper's protocol says

    @property
    def episodes(self) -> range:
        """The held-out episode seeds that it plays."""
        return self.budget.episodes(self.cell) if self.budget else self.cell.episodes

    def settings(self, world: World) -> Settings:
        """The settings of an extraction, resolved."""
        return self.budget.deal(self.cell, world) if self.budget else settings_of(self.cell, world)

    @cached_property
    def identity(self) -> dict[str, Any]:
        """The facts that decide its results."""
        settings = {}
        if self.cell.kind == EXTRACTION:
            world = self.source.read()[1] if self.budget else find(self.source.world)
            settings = asdict(self.settings(world))
        same = {"kind": self.cell.kind, "world": self.source.world, "expert": self.expert_hash}
        about = {"algorithm": self.cell.algorithm, "leaves": self.cell.leaves, "seed": self.cell.seed}
        episodes = [self.episodes.start, self.episodes.stop]
        made_by = {"tool": tool(), "register": self.register, "format": FORMAT}
        return {
            **same,
            **about,
            "settings": settings,
            "of": dict(self.of),
            **dict(self.effort),
            "episodes": episodes,
            **made_by,
        }

    @cached_property
    def id(self) -> str:
        """The name of its folder."""
        text = json.dumps(self.identity, sort_keys=True, default=list)
        return hashlib.sha256(text.encode()).hexdigest()[:ID_LETTERS]


def tool() -> str:
    """Returns the name and version of the tool that makes cells now."""
    return f"maviper {version()}"


@dataclass(frozen=True)
class Document:
    """cell.json, the last file of a cell that is written."""

    format: str
    cell: Cell
    identity: dict[str, Any]
    outcome: str  # DONE or FAILED
    message: str  # why it failed
    lower_is_better: list[str]  # measures
    cpu_seconds: float


@dataclass(frozen=True)
class Made:
    """The result of a task: its files by name, cell.json aside."""

    id: str
    document: Document
    files: Mapping[str, bytes]


FILE = "costs.toml"
UNKNOWN = 30.0  # CPU seconds of what nothing in the table is like
PLAYED = 2.0  # of a profile that is there already
UNIT = 1_000  # of steps or episodes spent on responders: the table's rows "effort ..." say what so many more cost ...
BEGUN = 0  # ... and what it costs to begin, once
Costs = Mapping[str, Mapping[str, float]]  # what -> depth, as text -> CPU seconds

# Factors of what was not measured. Every threshold costs so many times as much as histograms do, in deception at depth
# 4; games are set apart by their agents, steps and contacts.
MEASURED_GAME = "physical-deception"
GAME_FACTORS = {"cooperative-navigation": 0.8, "predator-prey": 1.3}
EXACT_FACTORS = {IVIPER: 2.5, IMITATION: 4.7, MAVIPER: 4.8}
LIKE: Mapping[str, tuple[str, float]] = {  # algorithm -> another one, and how much of its cost: the same loop
    "joint-rollouts": (MAVIPER, 1.0),
    "joint-selection": (MAVIPER, 1.0),
    "vote-N": (MAVIPER, 1.0),
    NO_PREDICTION: (MAVIPER, 0.8),
    IVIPER_RESAMPLING: (MAVIPER, 0.5),
    VIPER: (IVIPER, 1.0),
    RGMDT: (IMITATION, 2.0),
    EXPLORING: (FITTED_Q, 1.0),
}


def key_of(cell: Cell) -> str:
    """Returns the key that cells of the same cost have in common, their depths aside."""
    words = [cell.kind, cell.game.partition(",")[0], cell.algorithm]
    words += [cell.preset, "" if cell.preset == RELEASED else cell.splits, "leaves" if cell.leaves else ""]
    return " ".join(word for word in words if word)


@cache
def load_costs() -> Costs:
    """The table."""
    return tomllib.loads((resources.files("maviper.reproduction.cells") / FILE).read_text(encoding="utf-8"))


def estimate(task: Task) -> float:
    """CPU seconds of a task, with what is spent on responders."""
    rates = ((load_costs().get(f"effort {name}", {}), count) for name, count in task.effort.items() if count)
    spent = sum(rows.get(str(BEGUN), 0.0) + rows.get(str(UNIT), 0.0) * count / UNIT for rows, count in rates)
    return spent + (PLAYED if _is_played(task.cell) else _nearest(task.cell))


def is_guessed(cell: Cell) -> bool:
    """Returns True if a cell's cost is derived from others'."""
    return not _is_played(cell) and key_of(cell) not in load_costs()


def _is_played(cell: Cell) -> bool:
    return cell.leaves > 0 and cell.algorithm != RGMDT and key_of(cell) not in load_costs()


def _nearest(cell: Cell) -> float:
    """CPU seconds of a cell, or of the nearest one that was measured, times a factor."""
    known = ((factor, other) for factor, other in _alike(cell) if key_of(other) in load_costs())
    factor, other = next(known, (1.0, None))
    return UNKNOWN if other is None else factor * _at(other)


def _alike(cell: Cell) -> Iterator[tuple[float, Cell]]:
    """The cell itself, then those like it, the nearest first, each with the factor of its cost."""
    games = [(1.0, cell.game), (GAME_FACTORS.get(cell.game.partition(",")[0], 1.0), MEASURED_GAME)]
    algorithms = [(1.0, cell.algorithm)]
    if cell.algorithm in LIKE:
        other, share = LIKE[cell.algorithm]
        algorithms.append((share, other))
    exact = cell.splits == EXACT or cell.preset == RELEASED
    slow = EXACT_FACTORS.get(cell.algorithm, max(EXACT_FACTORS.values())) if exact else 1.0
    styles = [(1.0, cell.preset, cell.splits), (slow, PAPER, HISTOGRAM)]
    for (one, game), (two, algorithm), (three, preset, splits) in product(games, algorithms, styles):
        for leaves in dict.fromkeys((cell.leaves, 0)):
            similar = replace(cell, game=game, algorithm=algorithm, preset=preset, splits=splits, leaves=leaves)
            yield one * two * three, similar


def _at(cell: Cell) -> float:
    """The cost at the cell's depth; where one depth was measured, others have the proportions of deception's."""
    known = load_costs()[key_of(cell)]
    if len(known) > 1 or str(cell.depth) in known:
        return _interpolate_depth(known, cell.depth)
    (depth,) = known
    rows = (
        load_costs().get(key_of(replace(cell, game=MEASURED_GAME, algorithm=name))) for name in (cell.algorithm, IVIPER)
    )
    shape = next((row for row in rows if row and len(row) > 1 and cell.kind == EXTRACTION), {"0": 1.0})
    return known[depth] * _interpolate_depth(shape, cell.depth) / _interpolate_depth(shape, int(depth))


def _interpolate_depth(known: Mapping[str, float], depth: int) -> float:
    depths = sorted(map(int, known))
    return float(np.interp(depth, depths, [known[str(each)] for each in depths]))
