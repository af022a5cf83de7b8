"""The zone engine: decides claims over difference bounds exactly, with a certificate or a point, and with which margin.

Does: asks goal by goal, first leaf by leaf (lemmas), then over the product of the trees; exact rational points; answers
  whether a claim is proved with a larger margin, and remembers from which margin on an open branch stays open, so that
  most margins need no search.
Assumes: every inequality of the question bounds a coordinate or a difference of two, else BeyondZonesError; a margin
  only hardens a claim, on a grid of steps from its own one.
Does not: replay points, or use a solver; its proofs are checked by checker/decisions.py, which shares only
  checker/thresholds.py with it. It states no formulas for each margin: which bounds move with it is read off two
  margins that nothing else equals.
"""

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cache
from math import lcm
from typing import TypeAlias

from verify.claims.formula import Formula, agents
from verify.question import DecisionQuestion
from verify.result import Verdict
from verify.spending import tell_of_goal
from verify.zones.search import Branch, BudgetError, CompiledSearch, Resolve, ZoneSearch, affordable, price, search
from verify.zones.tables import (
    EPSILON,
    BeyondZonesError,
    Bound,
    Flat,
    NodeKnown,
    Problem,
    Table,
    find_barred_sides,
    infinite,
    problem,
    split_sides,
    zone_tree,
)
from verify.zones.volume import Disjoint, disjoint

__all__ = ["BeyondZonesError", "Outcome", "Tests", "ZoneQuery", "decide"]
ROOM = 8  # of what is left to a coordinate, a point leaves this part free at either end
Barred: TypeAlias = Mapping[str, frozenset[tuple[int, int]]]  # agent -> its barred sides (`find_barred_sides`)
Splits: TypeAlias = Mapping[str, Mapping[tuple[int, float], tuple[Formula, Formula]]]  # agent -> split_sides


@dataclass(frozen=True)
class Outcome:
    """The answer over all goals. PROVED comes with proofs, VIOLATED with a point at which the claim fails."""

    verdict: Verdict
    nodes: int  # search nodes over all goals
    goal: str | None = None
    state: Mapping[str, Fraction] | None = None  # coordinate of the region's box -> exact value
    proofs: Mapping[str | None, bytes] = field(default_factory=dict[str | None, bytes])  # goal -> proof stream
    # a point of the region, so that it is not empty
    inhabitant: Mapping[str, Fraction] = field(default_factory=dict[str, Fraction])
    reason: str = ""
    part: DecisionQuestion | None = field(default=None, compare=False)  # of the question, that fails at the point


@dataclass(frozen=True)
class Tests:
    """The splits and barred sides of the agents of whom a claim speaks, which are the same for every goal."""

    splits: Splits
    barred: Barred

    @classmethod
    def of(cls, question: DecisionQuestion) -> "Tests":
        """The tests of a question's agents, with the errors that its claim allows."""
        acting, eps = agents(question.formula), question.claim.eps
        team = [policy for policy in question.profile.agents if policy.agent in acting]
        splits = {policy.agent: split_sides(policy, question.semantics, eps) for policy in team}
        return cls(splits, {policy.agent: find_barred_sides(policy, splits[policy.agent]) for policy in team if eps})


def decide(question: DecisionQuestion) -> Outcome:
    """Decides whether the claim holds in every point of the region, for each goal, within `max_nodes` search nodes per
    goal: all parts together, where a claim is answered in parts (its proof is theirs, one after the other).

    Where the claim has an `eps`: though each measured feature of each agent is off by up to that much, each by an error
    of its own. BeyondZonesError when the question is not about difference bounds; InputError when a feature has no
    meaning or speaks of a coordinate that the region does not bound.
    """
    tests, budget = Tests.of(question), question.budgets.max_nodes
    spent, proofs, inhabitant, reasons = 0, dict[str | None, bytes](), dict[str, Fraction](), list[str]()
    left, alike = dict.fromkeys(question.goals, budget), dict[int, tuple[bytes, int]]()
    for goal, part in question.cases:
        if id(part) in alike:  # as for the goal before: proof, and search nodes
            proof, nodes = alike[id(part)]
            spent, proofs[goal] = spent + nodes, proofs.get(goal, b"") + proof
            continue
        query = ZoneQuery(part, goal, tests, budget=left[goal])
        try:
            inhabitant = inhabitant or query.inhabitant()
            if not inhabitant:
                return Outcome(Verdict.VACUOUS, spent + query.nodes, reason="the region holds no world state")
            before = query.nodes
            proof, state = query.answer()
        except BudgetError:
            spent, left[goal] = spent + query.limit, 0
            most = affordable(query.problem, budget)
            reasons.append(tell_of_goal(goal, f"not decided within {most:,} search nodes"))
            continue
        spent, left[goal] = spent + query.nodes, max(0, left[goal] - query.nodes * price(query.problem))
        if state is not None:
            return Outcome(Verdict.VIOLATED, spent, goal, state, part=part)
        proofs[goal] = proofs.get(goal, b"") + proof
        if not question.names_goal:
            alike[id(part)] = proof, query.nodes - before
    if reasons:
        told = "; ".join([*dict.fromkeys(reasons), question.budgets.hint()])
        return Outcome(Verdict.UNKNOWN, spent, reason=told)
    return Outcome(Verdict.PROVED, spent, proofs=proofs, inhabitant=inhabitant)


class ZoneQuery:
    """One goal's question: its tables, and a search through them. `apart`: its branches have no point in common.

    `budget`: search nodes, if not those of the question.
    """

    def __init__(
        self, question: DecisionQuestion, goal: str | None, tests: Tests, apart: bool = False, budget: int | None = None
    ) -> None:
        self._table = Table(question.profile, question.formula_for(goal), question.region, goal)
        self._trees = [
            zone_tree(self._table, policy, tests.splits[policy.agent], tests.barred.get(policy.agent, ()))
            for policy in self._table.policies
        ]
        self._disjoint: Disjoint = disjoint(self._table) if apart else lambda flat: flat
        self.problem = problem(self._table)
        self._box = tuple(question.region.box)
        self.limit = affordable(self.problem, question.budgets.max_nodes if budget is None else budget)
        self._search = self._searching()

    def _searching(self) -> "ZoneSearch | CompiledSearch":
        # a region that is plainly false has no point, and the search is not asked
        return search(self.problem, self._disjoint(self._table.region) or Flat((), ()), self.limit)

    def replace_problem(self, problem: Problem) -> "ZoneQuery":
        """The same question with other numbers for its bounds."""
        other = copy(self)
        other.problem = problem
        other._search = other._searching()
        return other

    @property
    def bounds(self) -> list[Bound]:
        """The bounds in the order of their numbers."""
        return list(self._table.numbers)

    @property
    def open(self) -> list[int]:
        """The numbers of the bounds on the branch that the search left open."""
        return self._search.open

    @property
    def nodes(self) -> int:
        """Search nodes so far."""
        return self._search.nodes

    def inhabitant(self) -> dict[str, Fraction]:
        """A point of the region; empty when there is none."""
        if self._table.region is None or not self._search.is_inhabited():
            return {}
        return state(self.problem, self._search.open, self._box)

    def answer(self) -> tuple[bytes, dict[str, Fraction] | None]:
        """The proof and None, or a point at which the claim fails."""
        streams, masks = self._lemmas()
        roots = [NodeKnown(None, mask[0]) for mask in masks]
        if self._table.denial(roots) is not None:
            for place, mask in enumerate(masks):
                if not any(mask):
                    streams[place] = b"\0"
            walked, closed = self._search.refutation(self._trees, *self._resolving(masks))
            return b"".join(streams) + walked, None if closed else state(self.problem, self._search.open, self._box)

        # parts prove it that hold at all leaves: as few of these as suffice
        for agent, known in enumerate(roots):
            for bit in range(known.holds.bit_length()):
                fewer = NodeKnown(None, roots[agent].holds & ~(1 << bit))
                if self._table.denial([*roots[:agent], fewer, *roots[agent + 1 :]]) is None:
                    roots[agent] = fewer
        proof = b""
        for agent, (tree, known) in enumerate(zip(self._trees, roots, strict=True)):
            if known.holds:
                allowed = [known.holds] * len(tree.left)
                proof += b"\1" + self._search.lemmas(tree, self._denials(agent), allowed)[0]
            else:
                proof += b"\0"
        return proof, None

    def violations(self, most: int) -> tuple[list[Branch], bool]:
        """The zones in which the claim fails, `most` at most, and whether these are all."""
        if self._table.region is None:
            return [], True
        try:
            masks = self._lemmas()[1]
        except BudgetError:
            return [], False
        return self._search.violations(self._trees, *self._resolving(masks), most)

    @property
    def agents(self) -> list[str]:
        """The agents whose trees the search goes through, in its order."""
        return [policy.agent for policy in self._table.policies]

    def _lemmas(self) -> tuple[list[bytes], list[list[int]]]:
        """Each agent's walk, and what holds below each node of its tree."""
        streams, masks = list[bytes](), list[list[int]]()
        for agent, tree in enumerate(self._trees):
            if self._table.parts[agent]:
                walked, proved = self._search.lemmas(tree, self._denials(agent), None)
            else:
                walked, proved = b"", [0] * len(tree.left)
            full = (1 << len(self._table.parts[agent])) - 1
            held = [mask & full for mask in proved]
            for node in reversed(range(len(held))):  # children follow parents: what holds at all leaves below each
                if tree.left[node] >= 0:
                    held[node] = held[tree.left[node]] & held[tree.right[node]]
            masks.append(held)
            streams.append(b"\1" + walked)
        return streams, masks

    def _denials(self, agent: int) -> list[list[Flat | None]]:
        tree, parts = self._trees[agent], len(self._table.parts[agent])
        return [
            [self._table.deny_part(agent, bit, action) for bit in range(parts)]
            for action in range(max(tree.action) + 1)
        ]

    def _resolving(self, masks: list[list[int]]) -> tuple[list[list[int]], Resolve]:
        """The classes of each agent's nodes, of which all have the same known, and the claim's denial for them."""
        kinds: list[list[NodeKnown]] = []
        classes: list[list[int]] = []
        for tree, mask in zip(self._trees, masks, strict=True):
            numbers: dict[NodeKnown, int] = {}
            known = [
                NodeKnown(None if left >= 0 else action, holds)
                for left, action, holds in zip(tree.left, tree.action, mask, strict=True)
            ]
            classes.append([numbers.setdefault(item, len(numbers)) for item in known])
            kinds.append(list(numbers))

        @cache
        def resolve(numbers: tuple[int, ...]) -> Flat | None:
            known = [kinds[agent][number] for agent, number in enumerate(numbers)]
            denial = self._table.denial(known)
            return denial if any(one.action is None for one in known) else self._disjoint(denial)

        return classes, resolve


def state(asked: Problem, numbers: Sequence[int], names: Sequence[str]) -> dict[str, Fraction]:
    """Exact values of coordinates that meet the numbered bounds: see `middle`."""
    zones: list[list[int]] = []
    for component, size in enumerate(asked.sizes):
        bounds = [0 if i == j else asked.infinite for i in range(size) for j in range(size)]
        for number in numbers:
            where, a, b = asked.edges[number]
            if where == component:
                bounds[a * size + b] = min(bounds[a * size + b], asked.weights[number])
        # the least bounds that follow: lengths of shortest paths (Floyd 1962); no cycle is negative
        rows = [bounds[start : start + size] for start in range(0, size * size, size)]
        for through, after in enumerate(rows):
            for place, row in enumerate(rows):
                to = row[through]
                rows[place] = [to + gap if to + gap < most else most for most, gap in zip(row, after, strict=True)]
        zones.append([most for row in rows for most in row])
    return middle(asked, zones, names)


def middle(
    asked: Problem, zones: Sequence[Sequence[int]], names: Sequence[str], wanted: Mapping[str, Fraction] | None = None
) -> dict[str, Fraction]:
    """A point of a zone, given as the closed matrix of each component: one coordinate after the other, in the middle of
    what is left to it, or as near to the value that is wanted as ROOM allows, and no more than 1 inside.
    """
    highest = [bounds[:: asked.sizes[component]] for component, bounds in enumerate(zones)]
    lowest = [bounds[: asked.sizes[component]] for component, bounds in enumerate(zones)]  # with the opposite sign
    point: dict[str, Fraction] = {}
    for name in names:
        component, node = asked.places[name]
        bounds, size, high, low = zones[component], asked.sizes[component], highest[component], lowest[component]
        value = (high[node] - low[node]) // 2
        if wanted is not None:
            room = min((high[node] + low[node]) // ROOM, asked.scale)
            value = min(max(int(wanted[name] * asked.scale), room - low[node]), high[node] - room)
        to, past = bounds[node::size], bounds[node * size : node * size + size]
        highest[component] = [min(most, gap + value) for most, gap in zip(high, to, strict=True)]
        lowest[component] = [min(most, gap - value) for most, gap in zip(low, past, strict=True)]
        point[name] = Fraction(value, asked.scale)
    return point


LONE = Fraction(1, 2**61 - 1), Fraction(2, 2**61 - 1)  # added to a margin, they make bounds that no other one equals


class Room:
    """The margins of a question in `step`s from its own: which are proved, as far as that is known."""

    def __init__(self, question: DecisionQuestion, step: Fraction, steps: int) -> None:
        """BeyondZonesError when the question is not about difference bounds, or a margin does not only harden it."""
        tests = Tests.of(question)
        self._start, self._step, self._ends = question.claim.margin, step, steps
        self._goals = [_Goal(question, goal, tests, step, steps) for goal in question.goals]
        self._proved, self._failed = 0, steps + 1  # steps: proved up to here, not proved from here on

    def is_proved_at(self, margin: Fraction) -> bool:
        """Returns True if the claim is proved with a margin of the grid; not where the budget of nodes ended first."""
        wanted = int((margin - self._start) / self._step)
        while self._proved < wanted < self._failed:
            # just below what fails: if that is proved, so is everything below it
            for steps in dict.fromkeys((self._failed - 1, wanted)):
                if not self._proved < steps < self._failed:
                    continue
                try:
                    failed = [first for each in self._goals if (first := each.fails_from(steps)) is not None]
                except BudgetError:
                    if steps == wanted:
                        return False
                    continue
                if failed:
                    self._failed = min(failed)
                else:
                    self._proved = steps
        return wanted <= self._proved


class _Goal:
    """One goal's question, for all margins: the same bounds, some of which move with the margin."""

    def __init__(self, question: DecisionQuestion, goal: str | None, tests: Tests, step: Fraction, steps: int) -> None:
        first, second = (question.with_margin(question.claim.margin + extra) for extra in LONE)
        self._query = ZoneQuery(first, goal, tests)
        bounds = self._query.bounds
        others = Table(second.profile, second.formula_for(goal), second.region, goal).numbers
        rates = [_rate(bound, other) for bound, other in zip(bounds, others, strict=False)]
        rates += [Fraction(0)] * (len(bounds) - len(rates))  # sides of splits, which no margin moves
        own = [bound.most - rate * LONE[0] for bound, rate in zip(bounds, rates, strict=True)]
        scale = EPSILON * lcm(*(most.denominator for most in own), *((rate * step).denominator for rate in rates))
        self._weights = [int(most * scale) - bound.strict for bound, most in zip(bounds, own, strict=True)]
        self._moves = [int(rate * step * scale) for rate in rates]
        sizes = self._query.problem.sizes
        self._problem = replace(
            self._query.problem, scale=scale, infinite=infinite(sizes, [*self._weights, *self._move_weights(steps)])
        )

    def fails_from(self, steps: int) -> int | None:
        """None where the claim is proved at a margin; else at how many steps the branch found first is open."""
        query = self._query.replace_problem(self._at(steps))
        if query.answer()[1] is None:
            return None
        low, high = 0, steps  # the claim is proved at 0
        while high - low > 1:
            middle = (low + high) // 2
            low, high = (low, middle) if _consistent(self._at(middle), query.open) else (middle, high)
        return high

    def _at(self, steps: int) -> Problem:
        return replace(self._problem, weights=self._move_weights(steps))

    def _move_weights(self, steps: int) -> list[int]:
        return [weight + steps * move for weight, move in zip(self._weights, self._moves, strict=True)]


def _rate(bound: Bound, other: Bound) -> Fraction:
    """By how much a bound moves with the margin."""
    rate = (other.most - bound.most) / (LONE[1] - LONE[0])
    if (bound.upper, bound.lower, bound.strict) != (other.upper, other.lower, other.strict) or rate < 0:
        raise BeyondZonesError("the margin does more than loosen the denied claim's bounds")
    return rate


def _consistent(asked: Problem, numbers: Sequence[int]) -> bool:
    """Returns True if the numbered bounds can hold together: no cycle of them has a negative sum."""
    edges = [(asked.edges[number], asked.weights[number]) for number in set(numbers)]
    least: dict[tuple[int, int], int] = {}  # an upper bound of each node, from a start where all are 0
    for _ in range(sum(asked.sizes) + 1):
        settled = True
        for (component, upper, lower), weight in edges:
            reached = least.get((component, lower), 0) + weight
            if reached < least.get((component, upper), 0):
                least[component, upper], settled = reached, False
        if settled:
            return True
    return False
