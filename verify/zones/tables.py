"""A question as numbered difference bounds: what the zone engine searches through.

Does: turns region, sides of splits and denied claim into bounds `a - b <= most` and choices between them; numbers the
  bounds and the single-agent parts of the claim.
Assumes: a formula over the coordinates of the region and the actions of the profile's agents.
Does not: search; share more than checker/thresholds.py with the checker, which follows the same text
  (checker/README.md).
"""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import accumulate
from math import lcm
from typing import NamedTuple, TypeAlias

from codegen.errors import InputError
from codegen.ir import GOAL, NO_FEATURE, ROOT, AgentPolicy, PolicyProfile
from verify.checker.thresholds import AT_ONCE, NO_ERROR, sides
from verify.claims.formula import Acts, And, Formula, Linear, Not, Or, agents, negate
from verify.claims.region import Region
from verify.spending import BeyondError

EPSILON = 1 << 12  # a strict bound is one unit lower, all others are this many units apart: cycles are shorter
_OF_GOAL = f"{GOAL}."
ORIGIN = ""  # the node that stands for zero
Edges: TypeAlias = tuple[int, ...]


class BeyondZonesError(BeyondError):
    """The question holds a test or an inequality that bounds no single coordinate and no difference of two."""


class Bound(NamedTuple):
    """upper - lower <= over / under, or below it when strict; two integers are told apart faster than two fractions."""

    upper: str
    lower: str
    over: int
    under: int  # positive, without a common divisor
    strict: bool

    @property
    def most(self) -> Fraction:
        """The greatest value of the difference."""
        return Fraction(self.over, self.under)


class Flat(NamedTuple):
    """All `edges` (numbers of bounds) hold, and of each choice in `ors` some part."""

    edges: Edges
    ors: "tuple[tuple[Flat, ...], ...]"


TRUE, OPEN = Flat((), ()), Flat((-1,), ())  # OPEN: hangs on an action that is not known yet


class NodeKnown(NamedTuple):
    """The facts of an agent at a node of its tree: its action at a leaf, and the parts that hold below the node."""

    action: int | None
    holds: int  # bit k: part k of the agent holds


class _Edge(NamedTuple):
    flat: Flat | None  # None: false


class _Acts(NamedTuple):
    agent: int
    action: int
    wanted: bool


class _Group(NamedTuple):
    everyone: bool  # all of the parts, or some of them
    parts: "tuple[_Node, ...]"


class _Part(NamedTuple):
    agent: int
    bit: int
    denied: "_Node"


_Node: TypeAlias = _Edge | _Acts | _Group | _Part
_Terms: TypeAlias = tuple[tuple[Fraction, str], ...]
_Ends: TypeAlias = tuple[str, str, Fraction | None]  # upper, lower, what both are multiplied with


class Table:
    """The bounds of one question, numbered in the order in which they are met, and the claim's denial."""

    def __init__(self, profile: PolicyProfile, claim: Formula, region: Region, goal: str | None) -> None:
        self._goal, self._box = goal, region.box
        self.numbers: dict[Bound, int] = {}
        # what sums bound, by identity, which is quick to compare; a sum is kept so that its id stays its own
        self._sums: dict[int, tuple[_Terms, _Ends]] = {}
        self.region = self._region(region)
        speaking = agents(claim)
        self.policies = [policy for policy in profile.agents if policy.agent in speaking]
        self._order = {policy.agent: place for place, policy in enumerate(self.policies)}
        self._parts: dict[tuple[Formula, bool], _Part] = {}
        self._denied: dict[tuple[int, int, int | None], Flat | None] = {}  # agent, bit, action
        self._denial = self._number_parts(claim, False)
        self.parts: list[list[_Node]] = [[] for _ in self.policies]  # per agent, denied
        for part in self._parts.values():
            self.parts[part.agent].append(part.denied)

    def atom(self, atom: Linear, wanted: bool = True) -> Flat | None:
        """The bound that an inequality is, or its denial unless `wanted`; None when that is false. BeyondZonesError
        when it is none.
        """
        known = self._sums.get(id(atom.terms))
        if known is None:
            known = self._sums[id(atom.terms)] = atom.terms, self._ends(atom, wanted)
        upper, lower, size = known[1]
        over, under = atom.bound.as_integer_ratio()
        strict = atom.strict
        if not wanted:
            upper, lower, over, strict = lower, upper, -over, not strict
        if size is None:
            return TRUE if over > 0 or (over == 0 and not strict) else None
        if size != 1:
            over, under = (Fraction(over, under) / size).as_integer_ratio()
        return self._add_bound(upper, lower, over, under, strict)

    def _add_bound(self, upper: str, lower: str, over: int, under: int, strict: bool) -> Flat:
        return Flat((self.numbers.setdefault(Bound(upper, lower, over, under, strict), len(self.numbers)),), ())

    def _ends(self, atom: Linear, wanted: bool) -> "_Ends":
        """The coordinates that a sum subtracts from one another, and the weight of both; None where none is left."""
        weights: dict[str, Fraction] = {}  # the goal's coordinates by the name of the landmark that it is
        for weight, name in atom.terms:
            real = f"{self._goal}.{name[len(_OF_GOAL) :]}" if self._goal and name.startswith(_OF_GOAL) else name
            weights[real] = weights[real] + weight if real in weights else weight
        upper = lower = ORIGIN
        size = (0, 1)  # numerator and denominator, which compare much faster than fractions
        for name, weight in weights.items():
            over, under = weight.numerator, weight.denominator
            if not over:
                continue
            if name not in self._box:
                raise InputError(f"the claim is about {name}, which regions cannot bound yet", "", "see --region")
            if (upper if over > 0 else lower) or (size[0] and (abs(over), under) != size):
                raise BeyondZonesError(str(atom if wanted else negate(atom)))
            size = abs(over), under
            upper, lower = (name, lower) if over > 0 else (upper, name)
        return upper, lower, Fraction(*size) if size[0] else None

    def side(self, formula: Formula) -> Flat | None:
        """A formula without actions, flat."""
        if isinstance(formula, Linear):
            return self.atom(formula)
        assert isinstance(formula, (And, Or)), formula
        return _join_flats(isinstance(formula, And), [self.side(part) for part in formula.parts])

    def denial(self, known: Sequence[NodeKnown]) -> Flat | None:
        """The claim's denial given what is known of each agent: None when it cannot hold."""
        return self._flat(self._denial, known)

    def deny_part(self, agent: int, bit: int, action: int | None) -> Flat | None:
        """That the agent's part does not hold, though it takes the action."""
        key = agent, bit, action
        if key not in self._denied:
            self._denied[key] = self._flat(self.parts[agent][bit], [NodeKnown(action, 0)] * len(self.policies))
        return self._denied[key]

    def _flat(self, node: _Node, known: Sequence[NodeKnown]) -> Flat | None:
        if isinstance(node, _Edge):
            return node.flat
        if isinstance(node, _Part):
            action, holds = known[node.agent]
            return None if holds >> node.bit & 1 else self.deny_part(node.agent, node.bit, action)
        if isinstance(node, _Acts):
            action = known[node.agent].action
            return OPEN if action is None else TRUE if (action == node.action) == node.wanted else None
        parts = (part.flat if isinstance(part, _Edge) else self._flat(part, known) for part in node.parts)
        return _join_flats(node.everyone, parts)

    def _region(self, region: Region) -> Flat | None:
        one = Fraction(1)
        flats: list[Flat | None] = []
        for name, (low, high) in region.box.items():
            over, under = low.as_integer_ratio()
            flats.append(self._add_bound(ORIGIN, name, -over, under, strict=False))
            flats.append(self._add_bound(name, ORIGIN, *high.as_integer_ratio(), strict=False))
        for a, b, (low, high) in region.differences:
            terms = (one, a), (-one, b)
            flats += [self.atom(_opposite(terms, -low)), self.atom(Linear(terms, high))]
        for a, b, least in region.apart:
            gaps = [((one, f"{a}.{axis}"), (-one, f"{b}.{axis}")) for axis in "xy"]
            ways = [way for gap in gaps for way in (_opposite(gap, -least), Linear(gap, -least))]
            flats.append(_join_flats(False, [self.atom(way) for way in ways]))
        return _join_flats(True, flats)

    def _number_parts(self, formula: Formula, wanted: bool) -> _Node:
        """The formula, or its denial unless `wanted`, with its largest single-agent parts numbered."""
        if isinstance(formula, Not):
            return self._number_parts(formula.part, not wanted)
        acting = agents(formula)
        if len(acting) == 1:
            agent = self._order[next(iter(acting))]
            bit = sum(part.agent == agent for part in self._parts.values())
            return self._parts.setdefault((formula, wanted), _Part(agent, bit, self._plain(formula, wanted)))
        if not isinstance(formula, (And, Or)):
            return self._plain(formula, wanted)
        parts = tuple(self._number_parts(part, wanted) for part in formula.parts)
        return _Group(isinstance(formula, And) == wanted, parts)

    def _plain(self, formula: Formula, wanted: bool) -> _Node:
        if isinstance(formula, Linear):
            return _Edge(self.atom(formula, wanted))
        if isinstance(formula, Acts):
            return _Acts(self._order[formula.agent], formula.action, wanted)
        if isinstance(formula, Not):
            return self._plain(formula.part, not wanted)
        assert isinstance(formula, (And, Or)), formula
        everyone, parts = isinstance(formula, And) == wanted, tuple(self._plain(part, wanted) for part in formula.parts)
        if all(isinstance(part, _Edge) for part in parts):  # it hangs on nobody's action
            return _Edge(_join_flats(everyone, [part.flat for part in parts if isinstance(part, _Edge)]))
        return _Group(everyone, parts)


def _opposite(terms: tuple[tuple[Fraction, str], ...], bound: Fraction) -> Linear:
    return Linear(tuple((-weight, name) for weight, name in terms), bound)


def _join_flats(everyone: bool, parts: Iterable[Flat | None]) -> Flat | None:
    """All of the parts (edges and choices in their order), or a choice between those that are not false."""
    if everyone:
        edges, ors = list[int](), list[tuple[Flat, ...]]()
        for part in parts:
            if part is None:
                return None
            edges += part.edges
            ors += part.ors
        return Flat(tuple(edges), tuple(ors))
    possible: list[Flat] = []
    for part in parts:
        if part == TRUE:
            return TRUE
        if part is not None:
            possible.append(part)
    if len(possible) < 2:
        return possible[0] if possible else None
    return Flat((), (tuple(possible),))


@dataclass(frozen=True)
class ZoneTree:
    """A decision tree over its n nodes: children (-1 at a leaf), the sides' bounds (None: nothing goes there)."""

    left: list[int]
    right: list[int]
    sides: list[tuple[Flat | None, Flat | None]]
    action: list[int]


def split_sides(
    policy: AgentPolicy, semantics: str, eps: Fraction = NO_ERROR
) -> dict[tuple[int, float], tuple[Formula, Formula]]:
    """(feature, threshold) of an agent's splits -> goes left, goes right; the same for every goal. `eps`: some error of
    at most that much leads there. BeyondZonesError for a sum of more than two coordinates.
    """
    tree = policy.tree
    pairs: Iterator[tuple[int, float]] = zip(tree.feature.tolist(), tree.threshold.tolist(), strict=True)
    splits = [(feature, threshold) for feature, threshold in dict.fromkeys(pairs) if feature != NO_FEATURE]
    for feature in (policy.features[place] for place, _ in splits):
        if feature.meaning and len(feature.meaning.terms) > AT_ONCE:
            raise BeyondZonesError(f"{feature.name} of {policy.agent} adds more than two coordinates")
    return {
        (feature, threshold): sides(policy.features[feature], threshold, policy.numbers, semantics, eps)
        for feature, threshold in splits
    }


def find_barred_sides(
    policy: AgentPolicy, splits: Mapping[tuple[int, float], tuple[Formula, Formula]]
) -> frozenset[tuple[int, int]]:
    """The sides, as (node, 0 for left or 1 for right), that no value of their feature reaches, given its tests above.

    All tests of a path share the feature's error, so such a side is empty though, each with an error of its own, the
    tests could pass together. Linear sides alone have errors; a threshold's place among those of its feature decides.
    """
    tree, places = policy.tree, _places(splits)
    barred: set[tuple[int, int]] = set()
    waiting: list[tuple[int, dict[int, tuple[int, int]]]] = [(ROOT, {})]
    while waiting:
        node, lines = waiting.pop()
        feature = int(tree.feature[node])
        if feature == NO_FEATURE:
            continue
        left, right = int(tree.left[node]), int(tree.right[node])
        place = places.get((feature, float(tree.threshold[node])))
        if place is None:
            waiting += [(left, lines), (right, lines)]
            continue
        low, high = lines.get(feature, (-1, len(places)))  # below all places, above all places
        ways = ((left, low, min(high, place)), (right, max(low, place), high))
        for side, (child, first, last) in enumerate(ways):
            if first < last:
                waiting.append((child, {**lines, feature: (first, last)}))
            else:
                barred.add((node, side))
    return frozenset(barred)


def _places(splits: Mapping[tuple[int, float], tuple[Formula, Formula]]) -> dict[tuple[int, float], int]:
    """(feature, threshold) of each split with linear sides -> its place among the feature's; equal sides share."""
    ends: dict[int, dict[tuple[Fraction, bool], list[float]]] = {}
    for (feature, threshold), (left, _) in splits.items():
        if isinstance(left, Linear):
            ends.setdefault(feature, {}).setdefault((left.bound, not left.strict), []).append(threshold)
    return {
        (feature, threshold): place
        for feature, of_feature in ends.items()
        for place, end in enumerate(sorted(of_feature))
        for threshold in of_feature[end]
    }


def zone_tree(
    table: Table,
    policy: AgentPolicy,
    splits: Mapping[tuple[int, float], tuple[Formula, Formula]],
    barred: Collection[tuple[int, int]] = (),
) -> ZoneTree:
    """The tree of one agent, with the sides of its splits; nothing goes to the `barred` ones."""
    tree = policy.tree
    nothing = (None, None)
    seen = {split: (table.side(left), table.side(right)) for split, (left, right) in splits.items()}
    ways = [seen.get(split, nothing) for split in zip(tree.feature.tolist(), tree.threshold.tolist(), strict=True)]
    for node, side in barred:
        left, right = ways[node]
        ways[node] = (left, None) if side else (None, right)
    return ZoneTree(tree.left.tolist(), tree.right.tolist(), ways, tree.action.tolist())


@dataclass(frozen=True)
class Problem:
    """The bounds as edges over numbered nodes, in integers: coordinates that never meet are in different components.

    A bound `a - b <= most` is the edge from a to b with weight most * scale * EPSILON, one unit less when strict.
    """

    sizes: list[int]  # nodes of each component; node 0 is the origin
    edges: list[tuple[int, int, int]]  # (component, upper, lower)
    weights: list[int]
    infinite: int  # larger than every sum of weights along a path
    scale: int  # units of a weight in one unit of length
    places: dict[str, tuple[int, int]]  # coordinate -> (component, node)

    @cached_property
    def names(self) -> list[list[str]]:
        """The coordinates of each component's nodes; the origin is ""."""
        names = [[ORIGIN] * size for size in self.sizes]
        for name, (component, node) in self.places.items():
            names[component][node] = name
        return names

    def are_joined(self, a: str, b: str) -> bool:
        """Returns True if one matrix bounds a - b."""
        return not a or not b or self.places[a][0] == self.places[b][0]

    def cell(self, a: str, b: str, own: int = 0) -> int:
        """The place of a - b among the cells of all matrices. `own`: the component, where both are the origin."""
        component = self.places[a or b][0] if a or b else own
        row, column = (self.places[name][1] if name else 0 for name in (a, b))
        return self._starts[component] + row * self.sizes[component] + column

    @cached_property
    def _starts(self) -> list[int]:
        return [0, *accumulate(size * size for size in self.sizes)]


def problem(table: Table) -> Problem:
    """The numbers of a table's bounds; later bounds are not in it."""
    roots: dict[str, str] = {}

    def root(name: str) -> str:
        while roots.setdefault(name, name) != name:
            name = roots[name]
        return name

    for upper, lower in dict.fromkeys((bound.upper, bound.lower) for bound in table.numbers):
        if upper and lower:
            roots[root(upper)] = root(lower)
        else:
            root(upper or lower)
    components = {name: place for place, name in enumerate(dict.fromkeys(root(name) for name in roots))}
    sizes = [1] * max(1, len(components))
    places: dict[str, tuple[int, int]] = {}
    for name in list(roots):
        component = components[root(name)]
        places[name] = component, sizes[component]
        sizes[component] += 1
    denominator = lcm(*{bound.under for bound in table.numbers})
    scale = denominator * EPSILON
    edges, weights = list[tuple[int, int, int]](), list[int]()
    for upper, lower, over, under, strict in table.numbers:
        component = places[upper or lower][0]
        edges.append((component, places[upper][1] if upper else 0, places[lower][1] if lower else 0))
        weights.append(over * (scale // under) - strict)
    return Problem(sizes, edges, weights, infinite(sizes, weights), scale, places)


def infinite(sizes: Sequence[int], weights: Sequence[int]) -> int:
    """A number that is larger than every sum of such weights along a path."""
    return 4 * (max(sizes) + 2) * (max(map(abs, weights), default=0) + 1)
