"""The emission model: what templates receive, as plain data.

Does: names the parts of a profile that is ready to be written, and what follows from them at once.
Assumes: `lower` made it.
Does not: look anything up in a profile, or hold text of any language.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from codegen.floats import FLOAT32
from codegen.lowering.names import AgentNames, Names

SINGLE_BITS = 32
TILED = 5  # tested features from which on numpy copies columns faster in tiles than one by one
_BYTES = {"unsigned char": 1, "unsigned short": 2, "unsigned int": 4, "float": 4, "double": 8}
_KINDS = ("unsigned char", "unsigned short", "unsigned int")


def unsigned(count: int) -> str:
    """The smallest C type that holds so many numbers from 0 on."""
    return next(kind for kind in _KINDS if count <= 256 ** _BYTES[kind])


@dataclass(frozen=True)
class Feature:
    """A feature and its place in the observation."""

    index: int
    name: str
    upper: str
    unit: str
    low: str
    high: str
    low_hex: str  # the range in the agent's numbers, rounded outwards, as C literals
    high_hex: str
    low_seen: str  # the same as decimals, of the doubles that they are
    high_seen: str
    meaning: str
    function: str  # of the sum of `terms`; "" for the sum itself
    terms: tuple[tuple[str, str, str], ...] | None  # (sign, weight unless it is 1, coordinate); None: no meaning


@dataclass(frozen=True)
class Action:
    """An action and its number."""

    index: int
    name: str
    upper: str
    effect: tuple[str, str] | None  # the direction in which it pushes, where there is one
    legal_if: str  # the upper-case name of the feature that is 1 where it is legal; "": it always is


@dataclass(frozen=True)
class Labels:
    """What the imported source returns for each action, as languages write it, and the types of these."""

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
class Double:
    """A number, as languages write it."""

    hex: str
    decimal: str


@dataclass(frozen=True)
class Node:
    """A node of the tree. Splits compare feature `feature` with a threshold, leaves take `action`."""

    id: int
    feature: Feature | None
    action: Action | None
    literal: str  # the threshold, exact, as a C literal
    bits: int  # of it as an unsigned number
    width: int  # how many these are
    double: str  # the deciding double, shortest decimal
    shown: str  # the test's number as people read it, for comments only; "< 0" for what is below 0
    test: str  # for them, too: "<= 0.1", "< 0"
    left: int
    right: int

    @property
    def hex_bits(self) -> str:
        """`bits` in hexadecimal digits, all of them."""
        return f"0x{self.bits:0{self.width // 4}x}"

    @property
    def below_zero(self) -> bool:
        """Whether what is asked is x < 0. Code says so: compared with the last number below 0, a 0 would go left where
        a thread takes subnormal numbers for zero.
        """
        return self.bits == (1 << self.width - 1) + 1

    @property
    def in_c(self) -> str:
        """Sign and number of the test as C and C++ write it."""
        if self.below_zero:
            return "< 0x0p+0" + ("f" if self.width == SINGLE_BITS else "")
        return f"<= {self.literal}"

    @property
    def in_rust(self) -> str:
        """The same in Rust."""
        return "< 0.0" if self.below_zero else f"<= f{self.width}::from_bits({self.hex_bits})"

    @property
    def of_numbers(self) -> str:
        """The same where numbers are of the agent's type, in Python."""
        return "< 0.0" if self.below_zero else f"<= {self.double}"

    @property
    def of_doubles(self) -> str:
        """The same for doubles that are not rounded before, in Python and JavaScript."""
        return self.of_numbers if self.width > SINGLE_BITS else f"<= {self.double}"

    @property
    def negative(self) -> bool:
        """Whether the threshold's sign is set, -0.0 included."""
        return self.bits >= 1 << self.width - 1

    @property
    def ordered(self) -> int:
        """The threshold as an integer in the order of its numbers: -0.0 is -1 there, but as a threshold 0."""
        half = 1 << self.width - 1
        return half - 1 - self.bits if self.bits > half else self.bits % half


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

    @property
    def masked(self) -> bool:
        """Whether it observes which of its actions are legal, and takes no others."""
        return any(action.legal_if for action in self.actions)

    @property
    def splits(self) -> int:
        """How many nodes test something."""
        return len(self.nodes) - self.n_leaves

    @property
    def reads(self) -> tuple[str, ...]:
        """The coordinates that it observes, in upper case, each once."""
        return tuple(dict.fromkeys(term[2] for feature in self.features for term in feature.terms or ()))

    @property
    def single(self) -> bool:
        """Whether it compares float32."""
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
        """Whether a numpy batch first copies its columns, in tiles."""
        return len(self.used) >= TILED


@dataclass(frozen=True)
class Region:
    """The world states that the code is meant for, as its check compares them: coordinates are upper-case names."""

    bounds: tuple[tuple[str, str, Double, Double], ...]  # coordinate, the one subtracted or "", low, high
    apart: tuple[tuple[str, str, Double], ...]  # entity, entity, least distance
    goals: tuple[str, ...]


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
    def labelled(self) -> bool:
        """Whether any agent's actions have labels beside their numbers."""
        return any(agent.labels for agent in self.agents)

    @property
    def located(self) -> bool:
        """Whether every agent can decide from world coordinates."""
        return all(agent.located for agent in self.agents)

    @property
    def single(self) -> bool:
        """Whether all agents compare float32."""
        return all(agent.single for agent in self.agents)

    @property
    def kind(self) -> str:
        """The C type of all agents' observations; "" where agents compare unlike numbers."""
        kinds = {agent.kind for agent in self.agents}
        return kinds.pop() if len(kinds) == 1 else ""

    @property
    def doubled(self) -> str:
        """The agents that compare float64, in words."""
        return ", ".join(agent.name for agent in self.agents if not agent.single)

    @property
    def asks_below_zero(self) -> bool:
        """Whether any tree asks x < 0."""
        return any(node.feature and node.below_zero for agent in self.agents for node in agent.nodes)

    @property
    def signed(self) -> bool:
        """Whether any agent observes the sign of something."""
        return any(feature.function == "sign" for agent in self.agents for feature in agent.features)

    @property
    def chosen(self) -> bool:
        """Whether any agent has a choice."""
        return any(agent.comparisons for agent in self.agents)

    @property
    def tiled(self) -> bool:
        """Whether any agent's numpy batch copies its columns in tiles."""
        return any(agent.tiled for agent in self.agents)

    @property
    def numpy_type(self) -> str:
        """The numpy type that holds every agent's actions."""
        return f"uint{8 * max(_BYTES[agent.tables.action_type] for agent in self.agents)}"

    @property
    def side_by_side(self) -> bool:
        """Whether all trees are walked in step: complete tables with a test in each."""
        return all(agent.tables.complete and agent.tables.levels for agent in self.agents)

    @property
    def max_levels(self) -> int:
        """Tests on the longest path of any tree."""
        return max(agent.tables.levels for agent in self.agents)
