"""The emission model: what templates receive, as plain data.

Does: names the parts of a profile that is ready to be written, from numbers and nodes to whole agents, and what follows
  from them at once, such as a test as languages write it.
Assumes: `lower` made it.
Does not: look anything up in a profile, or hold text of any language.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar, Literal, NamedTuple

import numpy as np

from codegen.floats import FLOAT32, NUMBERS, WHOLE, below_zero, short_hex
from codegen.ir import MAX_LENGTH, Float64
from codegen.lowering.names import AgentNames, Names
from codegen.lowering.names import Labels as Labels
from codegen.numbers import decimal_literal
from codegen.sums import CONSTANT, DOUBLE_SUMS, FLOAT32_STEPS

SINGLE_BITS = 32
UNIT = 2.0**-53  # by what share of itself a number is off that is rounded to float64


@dataclass(frozen=True)
class Double:
    """A number, as languages write it."""

    hex: str
    decimal: str

    @classmethod
    def of(cls, value: float) -> "Double":
        """A number as languages write it, minus zero as zero."""
        return cls(short_hex(value + 0.0), decimal_literal(value + 0.0))


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
    bounded: tuple[bool, bool]  # whether each end may be exceeded: the type of whole numbers may end there, too
    low_seen: str  # the same as decimals, of the doubles that they are
    high_seen: str
    below_low: str  # the bits of the last number below the range, and of its end
    high_bits: str
    meaning: str
    scale: str  # its number in the unit, of which the whole number is made; "": it is that number
    function: str  # of the sum of `terms`; "" for the sum itself
    terms: tuple[tuple[str, str, str], ...] | None  # (sign, weight unless it is 1, coordinate); None: no meaning

    @property
    def ranged(self) -> bool:
        """True if anybody stated its range."""
        return (self.low, self.high) != (decimal_literal(-MAX_LENGTH), decimal_literal(MAX_LENGTH))


@dataclass(frozen=True)
class Action:
    """An action and its number."""

    index: int
    name: str
    upper: str
    effect: tuple[str, str] | None  # the direction in which it pushes, where there is one
    legal_if: str  # the upper-case name of the feature that is 1 where it is legal; "": it always is


@dataclass(frozen=True)
class Node:
    """A node of the tree. Splits compare feature `feature` with a threshold, leaves take `action`."""

    id: int
    feature: Feature | None
    action: Action | None
    literal: str  # the threshold, exact, as a C literal of a float
    whole: str  # the same of a whole number, where such are observed; else ""
    bits: int  # of it as an unsigned number
    width: int  # how many these are
    double: str  # the deciding double, shortest decimal
    shown: str  # the test's number as people read it, for comments only; "< 0" for what is below 0
    test: str  # for them, too: "<= 0.1", "< 0"
    left: int
    right: int
    given: ClassVar[tuple["Given", ...]] = ()

    @property
    def split(self) -> bool:
        """True if it tests anything."""
        return self.feature is not None

    @property
    def tested(self) -> str:
        """The feature that it tests."""
        return self.feature.name if self.feature else ""

    @property
    def hex_bits(self) -> str:
        """`bits` in hexadecimal digits, all of them."""
        return f"0x{self.bits:0{self.width // 4}x}"

    @property
    def below_zero(self) -> bool:
        """True if what is asked is x < 0. Code says so: compared with the last number below 0, a 0 would go left where
        a thread takes subnormal numbers for zero.
        """
        return self.bits == (1 << self.width - 1) + 1

    @property
    def in_c(self) -> str:
        """Sign and number of the test as C and C++ write it."""
        if self.below_zero:
            return "< 0x0p+0" + ("f" if self.width == SINGLE_BITS else "")
        return f"<= {self.in_table}"

    @property
    def in_table(self) -> str:
        """The threshold as a C literal of the observations' type."""
        return self.whole or self.literal

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
        """True if the threshold's sign is set, -0.0 included."""
        return self.bits >= 1 << self.width - 1

    @property
    def ordered(self) -> int:
        """The threshold as an integer in the order of its numbers: -0.0 is -1 there, but as a threshold 0."""
        half = 1 << self.width - 1
        return half - 1 - self.bits if self.bits > half else self.bits % half


class RaisedSum(NamedTuple):
    """A sum of variables with whole factors, as float64, and by what share of its terms' sizes it is raised.

    So raised it is never below the exact sum. With u = UNIT and P all sizes together, products are off by 2 u P and a
    bit, since factors may be rounded too, n - 1 sums of them by u P each, and the last sum, with the share, by u P and
    a bit. That is less than (n + 3) u P, in any order, with or without fused operations, and the share is 2 (n + 4) u.
    Underflow takes nothing: whole multiples of float64 numbers are multiples of 2**-1074, so that they are added
    exactly where P is below 2**-1021, and beyond that the share of P is above 2**-1071. What overflows becomes infinite
    or no number, and is within no bound.
    """

    terms: tuple[tuple[int, float], ...]  # variable, factor

    @property
    def factors(self) -> tuple[tuple[int, Double], ...]:
        """The terms as languages write them."""
        return tuple((column, Double.of(factor)) for column, factor in self.terms)

    @property
    def share(self) -> Double:
        """Of the sizes of all terms together."""
        return Double.of(self._share)

    @property
    def _share(self) -> float:
        return 2.0 * (len(self.terms) + 4) * UNIT

    def of(self, states: Float64) -> Float64:
        """It in each state [batch, variables], as code adds it: from left to right."""
        total, size = np.zeros(len(states)), np.zeros(len(states))
        with np.errstate(all="ignore"):
            for column, factor in self.terms:
                product = factor * states[:, column]
                total, size = total + product, size + np.abs(product)
            return np.asarray(total + self._share * size, dtype=np.float64)


class Ends(NamedTuple):
    """The least and most of each variable of a box, in the order of its part."""

    low: tuple[Double, ...]
    high: tuple[Double, ...]


# of float (True), of double: the last number below 0, and 0
BELOW_ZERO = {numbers == FLOAT32: decimal_literal(below_zero(numbers)) for numbers in NUMBERS}
ZERO = {True: Double("0x0p+0f", "0.0"), False: Double("0x0p+0", "0.0")}


@dataclass(frozen=True)
class Term:
    """A term of a sum: the feature or the inner sum, times `size` or divided by it, added or subtracted."""

    sign: str  # "+" or "-"
    size: Double | None  # without its sign; None: 1
    feature: Feature | None  # None: the term is its size, or weighs a sum
    inner: tuple["Term", ...] = ()
    divided: bool = False

    def scale(self, seen: str, size: str) -> str:
        """The feature or inner sum, as a language writes it, times the size or divided by it."""
        return f"{seen} / {size}" if self.divided else f"{size} * {seen}"


@dataclass(frozen=True)
class Output:
    """A number that an agent gives, and its bounds in the numbers that it is rounded to."""

    index: int
    name: str
    upper: str
    unit: str
    low: Double | None
    high: Double | None


@dataclass(frozen=True)
class Given:
    """The value of a leaf for an output: a sum, or a number that is clipped and rounded already."""

    output: Output
    terms: tuple[Term, ...]
    number: Double | None
    shown: str  # as people read it

    @property
    def written(self) -> str:
        """The sum as attributes of pictures have it: `weight:place,...`, in the order in which it is added."""
        if self.number:
            return f"{self.number.hex.removesuffix('f')}:{CONSTANT}"
        return format_terms(self.terms)

    @property
    def share(self) -> float | None:
        """Where a number lies between its output's bounds, from 0 to 1; None where it is none, or has no bounds."""
        low, high = self.output.low, self.output.high
        if not self.number or not low or not high or float(low.decimal) == float(high.decimal):
            return None
        least, most = float(low.decimal), float(high.decimal)
        return float(self.number.decimal) / (most - least) - least / (most - least)


def format_terms(terms: Sequence[Term]) -> str:
    """A sum in one word: `0x1p-1:3,-0x1p+0:0`; the place of a constant is -1, that of an inner sum the sum in
    parentheses; `/0x1.8p+1:0` is divided.
    """

    def weighed(term: Term) -> str:
        if term.inner:
            return f"({format_terms(term.inner)})"
        return str(term.feature.index if term.feature else CONSTANT)

    parts = ((term, term.size.hex.removesuffix("f") if term.size else "0x1p+0") for term in terms)
    signs = ("/" * term.divided + term.sign.strip("+") for term in terms)
    return ",".join(f"{sign}{size}:{weighed(term)}" for sign, (term, size) in zip(signs, parts, strict=True))


@dataclass(frozen=True)
class SumNode:
    """A node of a tree with sums: `single` where it tests one feature, else the terms of the sum that it tests."""

    id: int
    single: Node | None
    terms: tuple[Term, ...]
    threshold: Double | None  # of the sum
    shown: str  # the test as people read it, for comments
    action: Action | None
    given: tuple[Given, ...]
    left: int
    right: int

    @property
    def sign(self) -> str:
        """The comparison of the sum. What asks for a sum below 0 is written so: compared with the last number below 0,
        a sum of 0 would go left where a thread takes subnormal numbers for zero.
        """
        last = self.threshold and BELOW_ZERO[self.threshold.hex.endswith("f")]
        return "<" if self.threshold and self.threshold.decimal == last else "<="

    @property
    def limit(self) -> Double | None:
        """The number that the sum is compared with."""
        return ZERO[self.threshold.hex.endswith("f")] if self.threshold and self.sign == "<" else self.threshold

    @property
    def split(self) -> bool:
        """True if it tests anything."""
        return self.action is None and not self.given

    @property
    def tested(self) -> str:
        """The sum or feature that it tests, as people read it."""
        return " ".join(self.shown.split(" ")[:-2])

    @property
    def test(self) -> str:
        """The comparison with its threshold, as people read it."""
        return " ".join(self.shown.split(" ")[-2:])

    @property
    def written(self) -> str:
        """The sum in one word, see `format_terms`."""
        return format_terms(self.terms)


@dataclass(frozen=True)
class Line:
    """A line of nested-if code: `if` opens a split, `else` turns to its right side, `end` closes it, `leaf` decides."""

    kind: Literal["if", "else", "end", "leaf"]
    level: int
    node: Node | SumNode

    def pad(self, width: int = 4, outer: int = 1) -> str:
        """The space before it, within `outer` levels of other code."""
        return " " * width * (self.level + outer)


@dataclass(frozen=True)
class Summed:
    """A tree whose tests or leaves have sums."""

    arithmetic: str
    gives: str
    outputs: tuple[Output, ...]  # (): leaves take actions
    nodes: tuple[SumNode, ...]
    lines: tuple[Line, ...]

    @property
    def doubled(self) -> bool:
        """True if float32 observations are added as doubles."""
        return self.arithmetic == DOUBLE_SUMS

    @property
    def stepwise(self) -> bool:
        """True if each operation is rounded to float32."""
        return self.arithmetic == FLOAT32_STEPS

    @property
    def gives_single(self) -> bool:
        """True if outputs are float32."""
        return self.gives == FLOAT32

    @property
    def kind(self) -> str:
        """The C type of outputs."""
        return "float" if self.gives_single else "double"

    @property
    def splits(self) -> int:
        """The number of nodes that test something."""
        return sum(node.split for node in self.nodes)

    @property
    def blank(self) -> bool:
        """True if no node reads the observation."""
        return not self.splits and not any(each.terms for node in self.nodes for each in node.given)


@dataclass(frozen=True)
class Memory:
    """A whole number that an agent remembers. `name`: in code; `index`: of the feature that it is read as."""

    index: int
    name: str
    initial: int
    low: int
    high: int


@dataclass(frozen=True)
class Change:
    """An action that changes what is remembered: the action that is taken, and an assignment to each memory."""

    action: Action
    taken: Action
    updates: tuple[tuple[str, str, int], ...]  # (name in code, `=` or `+=`, number)


@dataclass(frozen=True)
class Machine:
    """The memory of an agent, behind its `observed` features, and what changes it."""

    memory: tuple[Memory, ...]
    changes: tuple[Change, ...]
    observed: int

    @property
    def kind(self) -> str:
        """The C type that holds all of it: an int may have 16 bits."""
        return "long" if any(max(-each.low, each.high) >= 1 << 15 for each in self.memory) else "int"


TILED = 5  # tested features from which on numpy copies columns faster in tiles than one by one
_BYTES = {
    "unsigned char": 1,
    "unsigned short": 2,
    "unsigned int": 4,
    "int": 4,
    "float": 4,
    "double": 8,
    **{f"{each}_t": int(each.strip("uint")) // 8 for each in WHOLE},
}
_KINDS = ("unsigned char", "unsigned short", "unsigned int")


def choose_unsigned(count: int) -> str:
    """The smallest C type that holds so many numbers from 0 on."""
    return next(kind for kind in _KINDS if count <= 256 ** _BYTES[kind])


@dataclass(frozen=True)
class Place:
    """A coordinate of a world state."""

    index: int
    name: str
    upper: str
    constant: str  # of C
    readers: tuple[str, ...]  # the agents that observe it


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
    def arrays(self) -> tuple[tuple[str, str, Sequence[str | int]], ...]:
        """Name, C type and entries of each array."""
        return (
            ("threshold", self.threshold_type, self.thresholds),
            ("feature", self.feature_type, self.features),
            ("child", self.child_type, self.children),
            ("action", self.action_type, self.actions),
        )

    @property
    def size(self) -> int:
        """Bytes of all arrays."""
        return sum(len(entries) * _BYTES[kind] for _, kind, entries in self.arrays)


@dataclass(frozen=True)
class Agent:
    """One agent's policy, ready to be written."""

    name: str
    lower: str
    names: AgentNames
    team: str
    numbers: str  # that it observes and compares: float32 or float64
    whole: str  # the type of whole numbers that it observes; "": floats
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
    vast: bool  # whether nested code is written without names, comments, indentation and tables: most of a large text
    walks: bool  # whether a numpy batch walks; a walk asks no x < 0
    located: bool  # whether every feature has a meaning
    force: str  # the acceleration of a unit action, length / s^2
    labels: Labels | None = None  # where an action's number or name does not say what the source returns
    twin: AgentNames | None = None  # of the first agent that has the same tree, where this is not the first
    summed: Summed | None = None  # the tree where sums are tested or given; `nodes` and `tables` are empty then
    machine: Machine | None = None  # where it remembers something

    @property
    def tree(self) -> tuple[Node, ...] | tuple[SumNode, ...]:
        """All nodes, whatever they test and give."""
        return self.summed.nodes if self.summed else self.nodes

    @property
    def outputs(self) -> tuple[Output, ...]:
        """The numbers that it gives; (): it takes actions."""
        return self.summed.outputs if self.summed else ()

    @property
    def asks(self) -> bool:
        """True if a decision may read the observation."""
        return self.comparisons > 0 or self.summed is not None

    @property
    def answer_shape(self) -> tuple[int, ...]:
        """The shape of one answer: () for an action, (n_outputs,) for numbers."""
        return (len(self.outputs),) if self.outputs else ()

    @property
    def answer_type(self) -> str:
        """The numpy type of its answers: int32 for actions."""
        return self.summed.gives if self.summed and self.summed.outputs else "int32"

    @property
    def batch_type(self) -> str:
        """The numpy type of answers in a batch, where actions take as few bytes as they can."""
        return f"uint{8 * _BYTES[self.tables.action_type]}" if not self.outputs else self.answer_type

    @property
    def masked(self) -> bool:
        """True if it observes which of its actions are legal, and takes no others."""
        return any(action.legal_if for action in self.actions)

    @property
    def splits(self) -> int:
        """The number of splits."""
        return sum(node.split for node in self.tree)

    @property
    def reads(self) -> tuple[str, ...]:
        """The coordinates that it observes, in upper case, each once."""
        return tuple(dict.fromkeys(term[2] for feature in self.features for term in feature.terms or ()))

    @property
    def unranged(self) -> int:
        """The number of features without a stated range."""
        return sum(not each.ranged for each in self.features)

    @property
    def single(self) -> bool:
        """True if it compares float32."""
        return self.numbers == FLOAT32

    @property
    def bounded(self) -> bool:
        """True if any of its features may be out of its range."""
        return any(end for each in self.features for end in each.bounded)

    @property
    def compared(self) -> str:
        """The numbers that it observes, as profiles name them."""
        return self.whole or self.numbers

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
        return len(self.used) >= TILED and not self.walks


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
    def nests(self) -> bool:
        """True if a sum weighs another one."""
        return any(term.inner for term in self._terms)

    @property
    def divides(self) -> bool:
        """True if a sum divides a term."""
        return any(term.divided for term in self._terms)

    @property
    def _terms(self) -> list[Term]:
        """The terms of all sums, those in one another too."""
        nodes = [node for each in self.summed for node in each.nodes]
        sums = [terms for node in nodes for terms in (node.terms, *(each.terms for each in node.given))]
        found = [term for terms in sums for term in terms]
        for term in found:
            found += term.inner
        return found

    @property
    def acting(self) -> bool:
        """True if all agents have actions, so that one call has all of them."""
        return not any(agent.outputs for agent in self.agents)

    @property
    def remembers(self) -> bool:
        """True if any agent remembers something."""
        return any(agent.machine for agent in self.agents)

    @property
    def labelled(self) -> bool:
        """True if any agent's actions have labels beside their numbers."""
        return any(agent.labels for agent in self.agents)

    @property
    def located(self) -> bool:
        """True if every agent can decide from world coordinates."""
        return all(agent.located for agent in self.agents)

    @property
    def bare(self) -> bool:
        """True if the C has no floats: it takes the bits of observations, and neither world states nor batches."""
        return self.style == "freestanding"

    @property
    def by_bits(self) -> bool:
        """True if the C compares the bits of floats, of which none may be NaN."""
        return self.bare or self.style == "ordered"

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
        doubles = any(not agent.single and not agent.whole for agent in self.agents)
        return doubles or self.region is not None or bool(self.summed) or (self.located and weighted)

    @property
    def whole(self) -> bool:
        """True if any agent observes whole numbers."""
        return any(agent.whole for agent in self.agents)

    @property
    def floats(self) -> bool:
        """True if any agent observes floats."""
        return not all(agent.whole for agent in self.agents)

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
        """True if any agent's numpy batch evaluates every split."""
        return any(agent.comparisons and not agent.walks for agent in self.agents)

    @property
    def walks(self) -> bool:
        """True if any agent's numpy batch walks its tree."""
        return any(agent.walks for agent in self.agents)

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
    def tabled(self) -> tuple[Agent, ...]:
        """The agents whose tables stand in the C: the first of those with the same tree, and no vast one that nothing
        walks.
        """
        walked = self.style == "walk" or self.side_by_side
        return tuple(each for each in self.agents if not each.summed and not each.twin and (walked or not each.vast))

    @property
    def max_levels(self) -> int:
        """Tests on the longest path of any tree."""
        return max(agent.tables.levels for agent in self.agents)
