"""The emission model: what templates receive, as plain data.

Does: names the parts of a profile that is ready to be written, and what follows from them at once.
Assumes: `lower` made it.
Does not: look anything up in a profile, or hold text of any language.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from codegen.floats import FLOAT32
from codegen.ir import MAX_LENGTH
from codegen.lowering.names import AgentNames, Names
from codegen.lowering.parts import Action as Action
from codegen.lowering.parts import Double as Double
from codegen.lowering.parts import Feature as Feature
from codegen.lowering.parts import Node as Node
from codegen.lowering.summed import Summed
from codegen.numbers import decimal_literal

TILED = 5  # tested features from which on numpy copies columns faster in tiles than one by one
_BYTES = {"unsigned char": 1, "unsigned short": 2, "unsigned int": 4, "float": 4, "double": 8}
_KINDS = ("unsigned char", "unsigned short", "unsigned int")


def choose_unsigned(count: int) -> str:
    """The smallest C type that holds so many numbers from 0 on."""
    return next(kind for kind in _KINDS if count <= 256 ** _BYTES[kind])


@dataclass(frozen=True)
class Labels:
    """The labels that the imported source returns for each action, as languages write them, and the types of these."""

    c: tuple[str, ...]
    c_type: str
    python: tuple[str, ...]
    python_type: str
    javascript: tuple[str, ...]
    rust: tuple[str, ...]
    rust_type: str
    json: str


@dataclass(frozen=True)
class Place:
    """A coordinate of a world state."""

    index: int
    name: str
    upper: str
    constant: str  # of C
    readers: tuple[str, ...]  # the agents that observe it


@dataclass(frozen=True)
class Line:
    """A line of nested-if code: `if` opens a split, `else` turns to its right side, `end` closes it, `leaf` decides."""

    kind: Literal["if", "else", "end", "leaf"]
    level: int
    node: Node

    def pad(self, width: int = 4, outer: int = 1) -> str:
        """The space before it, within `outer` levels of other code."""
        return " " * width * (self.level + outer)


@dataclass(frozen=True)
class Tables:
    """A tree as arrays. `complete`: the children of node i are 2 i + 1 and 2 i + 2, and `actions` has an entry for each
    path of `levels` tests; else `children` has two entries per node, a leaf being its own child.
    """

    complete: bool
    levels: int
    features: tuple[int, ...]
    thresholds: tuple[str, ...]  # hexadecimal floats
    children: tuple[int, ...]
    actions: tuple[int, ...]  # per path, or per node
    threshold_type: str
    feature_type: str
    child_type: str
    action_type: str

    @property
    def size(self) -> int:
        """Bytes of all arrays."""
        widths = [
            (self.thresholds, self.threshold_type),
            (self.features, self.feature_type),
            (self.children, self.child_type),
            (self.actions, self.action_type),
        ]
        return sum(len(array) * _BYTES[kind] for array, kind in widths)


@dataclass(frozen=True)
class Agent:
    """One agent's policy, ready to be written."""

    name: str
    lower: str
    names: AgentNames
    team: str
    numbers: str  # that it observes and compares: float32 or float64
    features: tuple[Feature, ...]
    actions: tuple[Action, ...]
    nodes: tuple[Node, ...]
    lines: tuple[Line, ...]
    tables: Tables
    used: tuple[Feature, ...]  # features that the tree tests
    repeated: frozenset[int]  # indices of those that it tests more than once
    comparisons: int  # in the worst case
    n_leaves: int
    selects: bool  # whether a batch over columns evaluates every split (else it walks)
    located: bool  # whether every feature has a meaning
    force: str  # the acceleration of a unit action, length / s^2
    labels: Labels | None = None  # where an action's number or name does not say what the source returns
    twin: AgentNames | None = None  # of the first agent that has the same tree, where this is not the first
    summed: Summed | None = None  # the tree where sums are tested or given; `nodes` and `tables` are empty then

    @property
    def masked(self) -> bool:
        """True if it observes which of its actions are legal, and takes no others."""
        return any(action.legal_if for action in self.actions)

    @property
    def splits(self) -> int:
        """The number of splits."""
        return self.summed.splits if self.summed else len(self.nodes) - self.n_leaves

    @property
    def reads(self) -> tuple[str, ...]:
        """The coordinates that it observes, in upper case, each once."""
        return tuple(dict.fromkeys(term[2] for feature in self.features for term in feature.terms or ()))

    @property
    def unranged(self) -> int:
        """The number of features without a stated range."""
        widest = decimal_literal(-MAX_LENGTH), decimal_literal(MAX_LENGTH)
        return sum((each.low, each.high) == widest for each in self.features)

    @property
    def single(self) -> bool:
        """True if it compares float32."""
        return self.numbers == FLOAT32

    @property
    def kind(self) -> str:
        """The C type of its observations."""
        return self.tables.threshold_type

    @property
    def observation_bytes(self) -> int:
        """Bytes of an observation."""
        return _BYTES[self.kind] * len(self.features)

    @property
    def tiled(self) -> bool:
        """True if a numpy batch first copies its columns, in tiles."""
        return len(self.used) >= TILED


@dataclass(frozen=True)
class Region:
    """The world states that the code is meant for, as its check compares them: coordinates are upper-case names."""

    bounds: tuple[tuple[str, str, Double, Double], ...]  # coordinate, the one subtracted or "", low, high
    apart: tuple[tuple[str, str, Double], ...]  # entity, entity, least distance
    goals: tuple[str, ...]

    @property
    def comparisons(self) -> int:
        """The number of comparisons, at most, that find out whether a state is in it."""
        return 2 * len(self.bounds) + 4 * len(self.apart) + 4 * len(self.goals)


@dataclass(frozen=True)
class Model:
    """A whole profile, ready to be written."""

    prefix: str
    names: Names
    world: str
    content_hash: str
    tool: str
    algorithm: str
    preset: str
    seed: int
    style: str  # one of STYLES but `auto`
    agents: tuple[Agent, ...]
    region: Region | None
    places: Mapping[str, Place]  # the coordinates of a world state in their order, by upper-case name
    dt: str  # seconds of a step
    damping: str  # the share of its velocity that an agent loses in a step

    @property
    def summed(self) -> tuple[Summed, ...]:
        """The trees of the agents that test or give sums."""
        return tuple(agent.summed for agent in self.agents if agent.summed)

    @property
    def acting(self) -> bool:
        """True if all agents have actions, so that one call has all of them."""
        return not any(each.outputs for each in self.summed)

    @property
    def labelled(self) -> bool:
        """True if any agent's actions have labels beside their numbers."""
        return any(agent.labels for agent in self.agents)

    @property
    def located(self) -> bool:
        """True if every agent can decide from world coordinates."""
        return all(agent.located for agent in self.agents)

    @property
    def single(self) -> bool:
        """True if all agents compare float32."""
        return all(agent.single for agent in self.agents)

    @property
    def kind(self) -> str:
        """The C type of all agents' observations; "" where agents compare unlike numbers."""
        kinds = {agent.kind for agent in self.agents}
        return kinds.pop() if len(kinds) == 1 else ""

    @property
    def moves(self) -> bool:
        """True if the world has a step, in which its agents move."""
        return float(self.dt) > 0

    @property
    def writes_doubles(self) -> bool:
        """True if the code has constants of type double that decide."""
        weighted = any(size for agent in self.agents for each in agent.features for _, size, _ in each.terms or ())
        return not self.single or self.region is not None or bool(self.summed) or (self.located and weighted)

    @property
    def doubled(self) -> str:
        """The agents that compare float64, in words."""
        return ", ".join(agent.name for agent in self.agents if not agent.single)

    @property
    def asks_below_zero(self) -> bool:
        """True if any tree asks x < 0."""
        return any(node.feature and node.below_zero for agent in self.agents for node in agent.nodes)

    @property
    def signed(self) -> bool:
        """True if any agent observes the sign of something."""
        return any(feature.function == "sign" for agent in self.agents for feature in agent.features)

    @property
    def chosen(self) -> bool:
        """True if any agent has a choice."""
        return any(agent.comparisons for agent in self.agents)

    @property
    def tiled(self) -> bool:
        """True if any agent's numpy batch copies its columns in tiles."""
        return any(agent.tiled for agent in self.agents)

    @property
    def numpy_type(self) -> str:
        """The numpy type that holds every agent's actions."""
        return f"uint{8 * max(_BYTES[agent.tables.action_type] for agent in self.agents)}"

    @property
    def side_by_side(self) -> bool:
        """True if all trees are walked in step: complete tables with a test in each."""
        return all(agent.tables.complete and agent.tables.levels for agent in self.agents)

    @property
    def max_levels(self) -> int:
        """Tests on the longest path of any tree."""
        return max(agent.tables.levels for agent in self.agents)
