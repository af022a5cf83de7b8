"""The checker's own reading of a question: regions and formulas as numbered bounds and choices between them.

Does: states a region as a formula, an inequality as a bound on a difference, a claim's denial as bounds and choices.
Assumes: nothing beyond claims/formula.py; belongs to what must be right for a certificate to mean something.
Does not: serve the zone engine, which has its own reading of the same specification (README.md).

A flat formula is a pair (numbers of bounds that all hold, choices of which some part holds each); None is false.
"""

from collections.abc import Sequence
from fractions import Fraction
from math import inf, lcm
from typing import Any, TypeAlias

from codegen.errors import InputError
from codegen.ir import GOAL, NO_FEATURE, ROOT, AgentPolicy
from verify.checker.thresholds import sides
from verify.claims.formula import Acts, And, Formula, Linear, Not, Or, agents
from verify.claims.region import Region
from verify.kinds import Semantics

Bounds: TypeAlias = "tuple[tuple[int, ...], tuple[Choice, ...]]"  # bounds that all hold, by number, and choices
Choice: TypeAlias = "tuple[Bounds, ...]"  # some of these hold
Flat: TypeAlias = "Bounds | None"  # None is false
Edge: TypeAlias = tuple[str, str, int]  # upper - lower <= weight
SearchTree: TypeAlias = "list[int | Sides]"  # of each node: a leaf's action, or two sides
Sides: TypeAlias = tuple[tuple[Flat, int], tuple[Flat, int]]  # (what a side says, child), left and right
Known: TypeAlias = tuple[int | None, int]  # of an agent: its action at a leaf, and the set of its parts that hold
NOTHING, OPEN = ((), ()), ((-1,), ())  # no bound; hangs on an action that is not known yet

WHOLE = (-inf, False), (inf, True)  # a line from one cut to another; (x, False) cuts below x, (x, True) above it
LONGEST = 1 << 12  # weights are this many units apart, so that strict bounds can be one less


class RejectedError(Exception):
    """The proof does not show the claim."""


class TooMuchError(RejectedError):
    """The checker looks through no more than this, whatever the proof shows."""


def region_formula(region: Region) -> And:
    """A region's inequalities, in the order of its fields: lower bound, then upper bound; apart as a choice of four."""
    one = Fraction(1)
    inequalities: list[Formula] = []
    for name, (low, high) in region.box.items():
        inequalities += [Linear(((-one, name),), -low), Linear(((one, name),), high)]
    for a, b, (low, high) in region.differences:
        inequalities += [Linear(((-one, a), (one, b)), -low), Linear(((one, a), (-one, b)), high)]
    for a, b, far in region.apart:
        pairs = [(f"{first}.{axis}", f"{second}.{axis}") for axis in "xy" for first, second in ((b, a), (a, b))]
        inequalities.append(Or(tuple(Linear(((one, first), (-one, second)), -far) for first, second in pairs)))
    return And(tuple(inequalities))


class Reading:
    """The bounds of one question in the order in which they are met, and the claim's parts that speak of one agent."""

    def __init__(self, order: Sequence[str], goal: str | None) -> None:
        self.goal = goal
        self.order = {agent: place for place, agent in enumerate(order)}
        # upper - lower <= most, or below it when strict: (upper, lower, most as a ratio, strict)
        self.bounds: dict[tuple[str, str, tuple[int, int], bool], int] = {}
        self.parts: list[dict[tuple[Formula, bool], int]] = [{} for _ in order]
        # what was read before, by identity, which is quick to compare; a formula is kept so that its id stays its own
        self._atoms: dict[tuple[int, bool], tuple[Linear, Flat]] = {}
        self._speaking: dict[tuple[int, bool], tuple[Formula, tuple[int, int] | None]] = {}
        self._denied: dict[tuple[int, int, int | None], Flat] = {}

    def flat(self, f: Formula, wanted: bool, known: Sequence[Known] = (), inner: bool = False) -> Flat:
        """The formula, or its denial unless `wanted`, given what is known; `inner`: inside a part."""
        if isinstance(f, Linear):
            if (id(f), wanted) not in self._atoms:
                self._atoms[id(f), wanted] = f, self._read_bound(f, wanted)
            return self._atoms[id(f), wanted][1]
        if isinstance(f, Not):
            return self.flat(f.part, not wanted, known, inner)
        part = None if inner else self._part(f, wanted)
        if part is not None:
            place, bit = part
            action, holds = known[place]
            if holds >> bit & 1:
                return None
            if (place, bit, action) not in self._denied:
                self._denied[place, bit, action] = self.flat(f, wanted, known, True)
            return self._denied[place, bit, action]
        if isinstance(f, Acts):
            action = known[self.order[f.agent]][0]
            return OPEN if action is None else NOTHING if (action == f.action) == wanted else None
        assert isinstance(f, (And, Or)), f
        parts = [self.flat(part, wanted, known, inner) for part in f.parts]
        held = [part for part in parts if part is not None]
        if isinstance(f, And) == wanted:
            all_of = tuple(n for part in held for n in part[0]), tuple(choice for part in held for choice in part[1])
            return all_of if len(held) == len(parts) else None
        if NOTHING in held or not held:
            return NOTHING if held else None
        return held[0] if len(held) == 1 else ((), (tuple(held),))

    def _part(self, f: Formula, wanted: bool) -> tuple[int, int] | None:
        """(place, bit) of a part that speaks of one agent, which is numbered when it is first met; else None."""
        if (id(f), wanted) not in self._speaking:
            acting, part = agents(f), None
            if len(acting) == 1:
                place = self.order[min(acting)]
                part = place, self.parts[place].setdefault((f, wanted), len(self.parts[place]))
            self._speaking[id(f), wanted] = f, part
        return self._speaking[id(f), wanted][1]

    def deny_parts(self, place: int, action: int, mask: int) -> list[Flat]:
        """The denials of an agent's parts in the set `mask`, given its action."""
        known = [(action, 0)] * len(self.order)
        return [self.flat(f, wanted, known) for (f, wanted), bit in self.parts[place].items() if mask >> bit & 1]

    def tree(self, policy: AgentPolicy, semantics: Semantics) -> SearchTree:
        """Reads what each node of an agent's tree says.

        Under errors a side that no measured value reaches, given the tests of its feature above it, is false.
        """
        tree, nodes = policy.tree, policy.tree.action.tolist()
        seen: dict[tuple[int, float], tuple[Flat, Flat, tuple[Any, bool] | None]] = {}
        lines: dict[int, dict[int, Any]] = {ROOT: {}}  # node -> feature -> the cuts between which it is measured there
        for node, split in enumerate(zip(tree.feature.tolist(), tree.threshold.tolist(), strict=True)):
            between = lines.pop(node, {})
            if split[0] == NO_FEATURE:
                continue
            if split not in seen:
                try:
                    left, right = sides(policy.features[int(split[0])], split[1], policy.numbers, *semantics)
                except InputError as error:
                    raise RejectedError(error.what) from None
                cut = (left.bound, not left.strict) if semantics.eps and isinstance(left, Linear) else None
                seen[split] = self.flat(right, True), self.flat(left, True), cut
            over, under, cut = seen[split]
            above, below = int(tree.right[node]), int(tree.left[node])
            if cut is not None:
                low, high = between.get(split[0], WHOLE)
                over, under = over if cut < high else None, under if low < cut else None
                lines[above] = {**between, split[0]: (max(low, cut), high)}
                lines[below] = {**between, split[0]: (low, min(high, cut))}
            elif semantics.eps:
                lines[above] = lines[below] = between
            nodes[node] = (under, below), (over, above)
        return nodes

    def edges(self) -> list[Edge]:
        """The bounds by number, as (upper, lower, LONGEST times the bound in a common unit, less 1 if strict)."""
        scale = lcm(*{under for _, _, (_, under), _ in self.bounds}) * LONGEST
        return [(upper, lower, over * (scale // under) - strict) for upper, lower, (over, under), strict in self.bounds]

    def _read_bound(self, atom: Linear, wanted: bool) -> Flat:
        most, strict = (atom.bound, atom.strict) if wanted else (-atom.bound, not atom.strict)
        weights: dict[str, Fraction] = {}
        for weight, name in atom.terms:
            of_goal = self.goal is not None and name.startswith(f"{GOAL}.")
            real = f"{self.goal}{name[len(GOAL) :]}" if of_goal else name
            weights[real] = weights[real] + weight if real in weights else weight
        ends: dict[bool, str] = {}  # by the weight's sign
        sizes: set[tuple[int, int]] = set()
        kept = [(name, weight.numerator, weight.denominator) for name, weight in weights.items() if weight.numerator]
        for name, over, under in kept:
            ends[(over > 0) == wanted] = name
            sizes.add((abs(over), under))
        if not kept:
            return NOTHING if most > 0 or (most == 0 and not strict) else None
        if len(ends) < len(kept) or len(sizes) > 1:
            raise RejectedError(
                f"an inequality of {', '.join(weights)} bounds neither a coordinate nor a difference of two"
            )
        size = sizes.pop()
        most = most if size == (1, 1) else most / Fraction(*size)
        key = ends.get(True, ""), ends.get(False, ""), most.as_integer_ratio(), strict
        return (self.bounds.setdefault(key, len(self.bounds)),), ()
