"""The policy IR: what a team of tree policies is, and what it decides.

Does: frozen data for trees, features, actions, outputs and the profile; the reference semantics: `act` and `outputs`.
Assumes: coordinates are in the world's own length unit.
Does not: read files (policy_json.py), round thresholds (floats.py), make text (lowering/lower.py, targets/) or learn.

Semantics, the same in every artefact that is made from a profile:
- A split sends an observation x left iff `x[feature] <= threshold`, both float32 or both float64: `Tree.numbers`. NaN
  compares false, so it goes right; infinities follow `<=`. Numbers of other types are doubles first, then the tree's.
- An agent may observe whole numbers of one type alone. Its tree is one of floats that hold them all, with whole
  thresholds: a number between two whole ones would go with the one above.
- A sum is added left to right in the tree's arithmetic (sums.py), and compared like a feature.
- What is remembered is compared like a feature, of which it has the name; memory.py says how it changes.
- A node's id is its index in the tree's arrays, which are in preorder; leaves are named by that id everywhere.
"""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields
from types import MappingProxyType
from typing import Final

import numpy as np
import numpy.typing as npt

from codegen.errors import InputError
from codegen.floats import FLOAT32, factor, observations
from codegen.sums import CONSTANT as CONSTANT
from codegen.sums import Sum, among, choose_numbers, clip_values
from codegen.world import GOAL as GOAL
from codegen.world import EntitySpec as EntitySpec
from codegen.world import RegionSpec
from codegen.world import VariableSpec as VariableSpec
from codegen.world import WorldSpec as WorldSpec

Int32 = npt.NDArray[np.int32]
Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Floats = npt.NDArray[np.float32 | np.float64]  # of an agent's numbers
Int64 = npt.NDArray[np.int64]
Bool = npt.NDArray[np.bool_]
Seen = tuple[float, float, float, float]  # least, 1st and 99th percentile, most, in the feature's unit

ROOT: Final = 0
NO_FEATURE: Final = -1
NO_CHILD: Final = -1
NO_ACTION: Final = -1
MAX_DEPTH: Final = 64  # nested code beyond it meets the limits of compilers; a tree that deep explains nothing
MAX_NODES: Final = 1 << 20
MAX_LENGTH: Final = 1e9  # of ranges, start regions, sizes: beyond it float64 positions are coarser than any world
PHYSICS: Final = "physics"  # the option of a world that says by whose code it moves
COUNTED: Final = "counts actions from"  # after an agent, in a provenance: its environment's number of the first one
FORK: Final = "released"  # its value where that is the code of the paper's authors
WEIGHTS: Final = tuple(2.0**power for power in range(-6, 7))  # of terms, with either sign
FUNCTIONS: Final = ("sign", "positive", "zero")  # of a sum: -1, 0 or 1; 1 where it is above 0; 1 where it is 0
UNSCALED: Final = (1.0, 0.0)
NAME: Final = re.compile(r"[A-Za-z][A-Za-z0-9_-]{0,63}")
_INT32: Final = {"dtype": np.int32}
_FLOAT64: Final = {"dtype": np.float64}
_INT64: Final = {"dtype": np.int64}
_NUMBERS: Final = {"dtype": ""}  # which the tree says


class _Arrays:
    """Makes every array field of a frozen dataclass contiguous and read-only."""

    numbers: str = FLOAT32  # what observations are
    arithmetic: str = ""
    sums: tuple[Sum, ...] = ()

    @property
    def compared(self) -> str:
        """The type of thresholds: that of the observations' numbers or, if sums are tested, that of the sums."""
        return choose_numbers(self.arithmetic) if self.sums else self.numbers

    def __post_init__(self) -> None:
        for item in (each for each in fields(self) if each.metadata):  # type: ignore[arg-type]
            array = np.array(getattr(self, item.name), dtype=item.metadata["dtype"] or self.compared, ndmin=1)
            array.setflags(write=False)
            object.__setattr__(self, item.name, array)

    def __repr__(self) -> str:
        tested: Int32 = getattr(self, "feature")  # noqa: B009 - of the classes that have arrays
        return f"{type(self).__name__}({len(tested)} nodes, {int((tested == NO_FEATURE).sum())} leaves)"


@dataclass(frozen=True, eq=False, repr=False)
class Tree(_Arrays):
    """A decision tree as arrays over its n nodes, in preorder, root first; `visits` is empty where nobody counted.

    Beyond the agent's features, `feature` counts on: n_features + k is the sum `sums[k]`. Where leaves give numbers,
    `action` counts in `vectors`, which have a sum for each output. Both are ordered as nodes first name them.
    """

    feature: Int32 = field(metadata=_INT32)  #: [n] index of the tested feature or sum; NO_FEATURE at a leaf
    threshold: Floats = field(metadata=_NUMBERS)  #: [n] in the feature's unit; 0 at a leaf
    left: Int32 = field(metadata=_INT32)  #: [n] node for `x <= threshold`; NO_CHILD at a leaf
    right: Int32 = field(metadata=_INT32)  #: [n] node for everything else; NO_CHILD at a leaf
    action: Int32 = field(metadata=_INT32)  #: [n] action at a leaf; NO_ACTION at a split
    numbers: str = field(default=FLOAT32, kw_only=True)  #: what observations and thresholds are, see floats.NUMBERS
    visits: Int64 = field(default_factory=lambda: np.zeros(0, np.int64), metadata=_INT64)  #: [n] a leaf's decisions
    arithmetic: str = field(default="", kw_only=True)  #: of sums, see sums.ARITHMETICS; "": there is none
    sums: tuple[Sum, ...] = field(default=(), kw_only=True)
    vectors: tuple[tuple[Sum, ...], ...] = field(default=(), kw_only=True)
    gives: str = field(default=FLOAT32, kw_only=True)  #: what outputs are rounded to

    @property
    def all_sums(self) -> tuple[Sum, ...]:
        """The sums that are tested, then those that leaves give."""
        return (*self.sums, *(each for vector in self.vectors for each in vector))


@dataclass(frozen=True, eq=False, repr=False)
class GrownTree(_Arrays):
    """A tree as the learner grew it, kept as evidence: float64 thresholds, the learner's own numbering, root first.

    A float32 observation goes left iff it is `<=` the float64 threshold, as in scikit-learn.
    """

    feature: Int32 = field(metadata=_INT32)
    threshold: Float64 = field(metadata=_FLOAT64)
    left: Int32 = field(metadata=_INT32)
    right: Int32 = field(metadata=_INT32)
    action: Int32 = field(metadata=_INT32)


@dataclass(frozen=True)
class Meaning:
    """The meaning of a feature: a weighted sum of world coordinates (none: 0), or a function of it (see FUNCTIONS).

    It is observed in float64, term after term, then rounded to float32 for an agent that compares float32. Weights are
    powers of two, so products are exact: of n terms, n - 1 additions round.
    """

    terms: tuple[tuple[float, str], ...]  #: (weight, coordinate such as "agent_0.x"); a function's weights are +1 or -1
    function: str = ""

    def __str__(self) -> str:
        text = " ".join(f"{'-' if weight < 0 else '+'} {factor(weight)}{name}" for weight, name in self.terms)
        text = text.removeprefix("+ ") or "0"
        return f"{self.function}({text})" if self.function else text


@dataclass(frozen=True)
class FeatureSpec:
    """One number of an observation. Actions alone keep it within `low` and `high` (in `unit`) over an episode."""

    name: str
    unit: str
    low: float
    high: float
    meaning: Meaning | None  #: None: the policy runs and compiles, but claims about world states are out of reach
    initial: int | None = None  #: of what the policy remembers (memory.py), after a reset; None: it is observed
    scale: tuple[float, float] = UNSCALED  #: of a whole number, which is factor * (number in the unit) + offset


@dataclass(frozen=True)
class Update:
    """What becomes of one thing that is remembered: it is set to a whole number, or that is added."""

    memory: str  #: the feature
    adds: bool
    value: int


@dataclass(frozen=True)
class ActionSpec:
    """One discrete action and the direction (unit vector per axis) in which it pushes, where there is one."""

    name: str
    effect: tuple[float, float] | None
    legal_if: str = ""  #: the feature that is 1 where the action is legal, else 0; "": it always is
    label: int | float | str | None = None  #: that an imported source returns for it, unless its place or name says so
    acts: str = ""  #: the action that is taken, where this one changes what is remembered, too
    updates: tuple[Update, ...] = ()  #: what is remembered then; what they do not name is kept

    def known_as(self, place: int) -> int | float | str:
        """Returns what its environment, or the source that it was imported from, calls it: its label, or its place."""
        return place if self.label is None else self.label


@dataclass(frozen=True)
class OutputSpec:
    """A number that an agent gives, clipped to its bounds (in `unit`); None: no bound."""

    name: str
    unit: str
    low: float | None
    high: float | None


@dataclass(frozen=True, eq=False, repr=False)
class AgentPolicy:
    """One agent's policy: what it observes, what it may do, and its tree. It has actions, or outputs."""

    agent: str
    team: str
    features: tuple[FeatureSpec, ...]
    actions: tuple[ActionSpec, ...]
    tree: Tree
    grown: GrownTree | None = None
    seen: tuple[Seen, ...] = ()  #: of each feature, in episodes; (): nobody looked
    outputs: tuple[OutputSpec, ...] = ()
    whole: str = ""  #: the type of whole numbers that it observes, see floats.WHOLE; "": it observes floats

    @property
    def numbers(self) -> str:
        """The numbers that it observes and compares: `float32` or `float64`."""
        return self.tree.numbers

    @property
    def memory(self) -> tuple[FeatureSpec, ...]:
        """What it remembers: the last of its features."""
        return tuple(feature for feature in self.features if feature.initial is not None)

    @property
    def taken(self) -> tuple[int, ...]:
        """The place of the action that is taken with each action: its own, unless that changes memory."""
        places = {action.name: place for place, action in enumerate(self.actions)}
        return tuple(places[action.acts or action.name] for action in self.actions)

    def act(self, rows: npt.ArrayLike) -> Int64 | Float64:
        """Decides for each row of features: actions [n] int64, by their labels where these are whole numbers, else by
        their places; or the numbers that it gives, [n, n_outputs] float64.

        Args:
            rows: Observations, [n, n_features], each feature in its unit.

        Raises:
            InputError: Rows have another length.
        """
        if self.outputs:
            return outputs(self, rows).astype(np.float64)
        numbers = [self.actions[place].known_as(place) for place in self.taken]
        counted = numbers if all(isinstance(each, int) for each in numbers) else range(len(numbers))
        return np.array(counted, dtype=np.int64)[act(self, rows)]

    def __repr__(self) -> str:
        decided = len(self.outputs or self.actions)
        size = f"{len(leaves(self.tree))} leaves, depth {int(depth(self.tree).max())}"
        return f"AgentPolicy('{self.agent}': {len(self.features)} features, {decided} decisions, {size})"


@dataclass(frozen=True)
class Provenance:
    """Where a profile comes from; `training` and `evaluation` are the extractor's named numbers and texts."""

    algorithm: str
    preset: str
    seed: int
    expert: str  # content hash of the expert, `module:function` of one without, or "" when there was none
    tool: str  # name and version of the program that made the profile
    training: Mapping[str, float | int | str] = field(default_factory=lambda: MappingProxyType({}))
    evaluation: Mapping[str, float | int | str] = field(default_factory=lambda: MappingProxyType({}))


@dataclass(frozen=True, eq=False, repr=False)
class PolicyProfile:
    """The policies of all agents of a world (the paper's term), with the world's spec and their provenance."""

    world: WorldSpec
    agents: tuple[AgentPolicy, ...]
    provenance: Provenance
    region: RegionSpec | None = None  #: the world states that the trees are meant for; None: all

    def __repr__(self) -> str:
        return f"PolicyProfile('{self.world.name}': {len(self.agents)} agents)"

    def policy(self, agent: str) -> AgentPolicy:
        """The policy of the named agent; KeyError when there is none."""
        return {policy.agent: policy for policy in self.agents}[agent]

    def team(self, team: str) -> tuple[AgentPolicy, ...]:
        """The policies of a team, in the order of the profile."""
        return tuple(policy for policy in self.agents if policy.team == team)


def apply(tree: Tree | GrownTree, obs: npt.ArrayLike) -> Int32:
    """Leaf id of each observation. `obs`: [batch, n_features], made the tree's numbers. Returns [batch] int32."""
    x = among(observations(obs, numbers=tree.numbers), tree.sums, tree.arithmetic)
    if tree.feature.max() >= x.shape[1]:
        raise IndexError(f"the tree tests feature {tree.feature.max()} of {x.shape[1]}")
    leaf = here = np.full(len(x), ROOT, dtype=np.int32)
    splits, children = tree.feature != NO_FEATURE, np.stack([tree.right, tree.left], axis=1).reshape(-1)
    # each element is looked up by one index, which takes half the time of a row and a column
    values, row = x.reshape(-1), np.arange(len(x) if splits[ROOT] else 0)
    while row.size:
        goes_left: Bool = values.take(row * x.shape[1] + tree.feature.take(here)) <= tree.threshold.take(here)
        here: Int32 = children.take(2 * here + goes_left)
        inner: Bool = splits.take(here)
        if not inner.all():
            leaf[row] = here
            on = np.flatnonzero(inner)
            row, here = row.take(on), here.take(on)
    return leaf


def act(policy: AgentPolicy, obs: npt.ArrayLike) -> Int32:
    """The reference: the action that `policy` takes for each observation of a batch.

    `obs`: [batch, n_features] (else InputError), made its numbers. Returns [batch] int32, indices into `actions`.
    """
    if policy.outputs:
        raise InputError(f"{policy.agent} gives numbers and takes no action", "", "ask for its outputs")
    return policy.tree.action[apply(policy.tree, observations(obs, len(policy.features), policy.agent, policy.numbers))]


def outputs(policy: AgentPolicy, obs: npt.ArrayLike) -> Floats:
    """The reference of an agent that gives numbers: [batch, n_outputs] in `gives`; the rest as for `act`.

    A leaf's sums are computed in the tree's arithmetic, clipped to the outputs' bounds, then rounded once.
    """
    tree, x = policy.tree, observations(obs, len(policy.features), policy.agent, policy.numbers)
    given, chosen = np.empty((len(x), len(policy.outputs)), tree.gives), tree.action[apply(tree, x)]
    for place, vector in enumerate(tree.vectors):
        rows = np.flatnonzero(chosen == place)
        for column, (each, output) in enumerate(zip(vector, policy.outputs, strict=True)):
            given[rows, column] = clip_values(each.value(x[rows], tree.arithmetic), output.low, output.high)
    return given


def leaves(tree: Tree) -> Int32:
    """Ids of the leaves, ascending, which is left to right."""
    return np.flatnonzero(tree.feature == NO_FEATURE).astype(np.int32)


def depth(tree: Tree | GrownTree) -> Int32:
    """Depth of each node in splits from the root, [n] int32. Assumes a checked tree (children after parents)."""
    level = np.zeros(len(tree.feature), dtype=np.int32)
    for node in np.flatnonzero(tree.feature != NO_FEATURE):
        level[tree.left[node]] = level[tree.right[node]] = level[node] + 1
    return level


def splits(tree: Tree) -> Iterator[int]:
    """Ids of the splits in preorder."""
    yield from (int(node) for node in np.flatnonzero(tree.feature != NO_FEATURE))
