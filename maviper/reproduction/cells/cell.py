"""The cell: the unit of a reproduction, with an identity that names its folder, and what it costs.

Does: says what a cell is, which settings it stands for, what makes two cells the same; the form of its files; estimates
  its CPU seconds by those of its kind, game, algorithm, preset and splits, linearly between depths.
Assumes: what an identity holds decides every byte that a cell gives, on machines of one kind; costs.toml, which
  tests/benchmarks/reproduce.py measured on one core of one machine.
Does not: make cells (making.py), choose which there are (plan.py), or know how fast this machine is.
"""

import hashlib
import json
import tomllib
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from functools import cache, cached_property, lru_cache
from importlib import resources
from typing import Any

import numpy as np

from maviper.episodes import measures
from maviper.experts import network
from maviper.experts.expert import Expert
from maviper.experts.finding import find_expert
from maviper.extraction.settings import (
    EXACT,
    IVIPER,
    IVIPER_RESAMPLING,
    MAVIPER,
    NO_PREDICTION,
    PAPER,
    RELEASED,
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
    agent = {"agent": world.agents[0]} if cell.algorithm == VIPER else {}  # of the first; the others follow
    about = {"preset": cell.preset, "max_depth": cell.depth, "seed": cell.seed, "splits": cell.splits or None}
    rung = VARIANTS.get(cell.algorithm, {"algorithm": cell.algorithm})
    return Settings.of({**about, **rung, **agent}, world).complete().deal_budget(world)


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
UNIT = 1_000  # of steps or episodes spent on responders: the table's rows "effort ..." say what so many more cost ...
BEGUN = 0  # ... and what it costs to begin, once
Costs = Mapping[str, Mapping[str, float]]  # what -> depth, as text -> CPU seconds
LIKE: Mapping[str, tuple[str, float]] = {  # algorithm -> a measured one, and how much of its cost: the same loop
    NO_PREDICTION: (MAVIPER, 0.75),
    IVIPER_RESAMPLING: (MAVIPER, 0.7),
    VIPER: (IVIPER, 1.0),
}


def key_of(cell: Cell) -> str:
    """Returns the key that cells of the same cost have in common, their depths aside."""
    words = [cell.kind, cell.game.partition(",")[0], cell.algorithm]
    grown = cell.kind == EXTRACTION  # for all else it does not matter how trees were grown
    preset = cell.preset if grown or not cell.preset else PAPER
    words += [preset, "" if preset == RELEASED else cell.splits]
    return " ".join(word for word in words if word)


@cache
def load_costs() -> Costs:
    """The table."""
    return tomllib.loads((resources.files("maviper.reproduction.cells") / FILE).read_text(encoding="utf-8"))


def estimate(task: Task) -> float:
    """CPU seconds of a task, with what is spent on responders."""
    rates = ((load_costs().get(f"effort {name}", {}), count) for name, count in task.effort.items() if count)
    spent = sum(rows.get(str(BEGUN), 0.0) + rows.get(str(UNIT), 0.0) * count / UNIT for rows, count in rates)
    other, share = LIKE.get(task.cell.algorithm, (task.cell.algorithm, 1.0))
    same = replace(task.cell, algorithm=other)
    known = load_costs().get(key_of(task.cell)) or load_costs().get(key_of(same))
    if not known:
        return spent + UNKNOWN
    depths = sorted(map(int, known))
    cost = float(np.interp(task.cell.depth, depths, [known[str(depth)] for depth in depths]))
    return spent + (cost if key_of(task.cell) in load_costs() else share * cost)


def is_guessed(cell: Cell) -> bool:
    """Returns True if a cell's cost is derived from others'."""
    return key_of(cell) not in load_costs()
