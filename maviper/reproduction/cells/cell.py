"""The cell: the unit of a reproduction, with an identity that names its folder.

Does: says what a cell is, which settings it stands for, what makes two cells the same; the form of its files.
Assumes: what an identity holds decides every byte that a cell gives, on machines of one kind.
Does not: make cells (making.py), or choose which there are (plan.py).
"""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from functools import cached_property, lru_cache
from typing import Any

from maviper.episodes import measures
from maviper.experts import network
from maviper.experts.expert import Expert
from maviper.experts.finding import find_expert
from maviper.extraction.settings import BUNDLES, EXACT, RGMDT, VARIANTS, Settings
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


@dataclass(frozen=True)
class Source:
    """Where an expert comes from: a name, or the bytes of a file, so that it can be had on any machine."""

    text: str
    data: bytes = b""
    world: str = ""  # the name of the world that it plays

    def read(self) -> tuple[Expert, World]:
        """The expert and its world."""
        return _read(self)


@lru_cache(maxsize=16)
def _read(source: Source) -> tuple[Expert, World]:
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
class Task:
    """A cell with all that making it takes."""

    cell: Cell
    source: Source
    expert_hash: str
    register: str  # hash of the claims that were written before
    of: Mapping[str, str] = field(default_factory=dict[str, str])  # algorithm -> id of the cell whose profile it needs
    effort: Mapping[str, int] = field(default_factory=dict[str, int])  # what is spent on responders

    @cached_property
    def identity(self) -> dict[str, Any]:
        """The facts that decide its results."""
        settings = {}
        if self.cell.kind == EXTRACTION:
            world = find(self.source.world)
            settings = asdict(settings_of(self.cell, world))
        same = {"kind": self.cell.kind, "world": self.source.world, "expert": self.expert_hash}
        about = {"algorithm": self.cell.algorithm, "leaves": self.cell.leaves, "seed": self.cell.seed}
        episodes = [self.cell.episodes.start, self.cell.episodes.stop]
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
