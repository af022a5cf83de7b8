"""The best team of trees of a given depth in a coordination game, exactly, and what any team of trees is worth there.

Does: expectations over hidden states and readings without sampling; every distinct tree; the best joint choice.
Assumes: a game of `worlds/games/coordination.py`, small enough that a kind's trees can be listed.
Does not: extract trees, or play.

What a tree does is a *rule*: the convention for each reading. A rule's *chances* are how likely each role is in each
hidden state. Readings are independent given the hidden state, so chances are all that a team's worth depends on.

Why one rule a kind is enough in matching games. With all other agents fixed, the m agents of one kind are worth
sum_i f(p_i) + sum_c w_c prod_i p_i[c] with w >= 0. A product of m numbers is at most the mean of their m-th powers, so
this is at most the mean over i of m f(p_i) + sum_c w_c p_i[c]^m: some agent's rule, given to all, is no worse.
Games of pairs have negative payoffs, so there the agents are searched one by one: branch and bound.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import reduce
from itertools import combinations

import numpy as np

from codegen import ir
from codegen.errors import InputError
from codegen.ir import Bool, Float64
from maviper.worlds.games.coordination import Coordination
from maviper.worlds.payoffs import PAIRS
from maviper.worlds.world import Int

MAX_RULES = 20_000  # that an agent may have, equal ones among them; bounds the memory
AT_ONCE = 2**22  # numbers in a part of a table of pairs
ROUNDING = 1e-12


@dataclass(frozen=True)
class Optimum:
    """The worth of the best team, and its rules, [n_agents, n_cells]."""

    worth: float
    rules: Int


# --- what rules are worth


def rules_of(world: Coordination, policies: Sequence[ir.AgentPolicy]) -> Int:
    """The rules of trees, [n_agents, n_cells]."""
    return np.stack([ir.act(policy, world.cells.astype(np.float32)) for policy in policies]).astype(np.int64)


def worth(world: Coordination, rules: Int) -> float:
    """The expected payoff of a team, exactly but for rounding. `rules`: [n_agents, n_cells]."""
    chances = [_chances(world, world.kind(agent), rule[None])[0] for agent, rule in enumerate(rules)]
    if world.rule in PAIRS:
        paid = PAIRS[world.rule]
        worths = [float(np.einsum("sa,ab,sb->", a, paid, b)) for a, b in combinations(chances, 2)]
        return float(np.mean(worths) / len(world.cells))
    right: Float64 = np.mean([each[:, 0] for each in chances], axis=0)
    product: Float64 = reduce(np.multiply, chances)
    together = product @ _shares(world)
    return float(np.mean((1 - world.all_or_nothing) * right + world.all_or_nothing * together))


def _chances(world: Coordination, kind: int, rules: Int) -> Float64:
    """How likely an agent with a rule takes each role in each hidden state, [n_rules, n_hidden, n_roles]."""
    likelihood = world.likelihood(kind).T
    chosen = np.stack([(rules == each) @ likelihood for each in range(world.conventions)], axis=-1)
    roles = (np.arange(world.conventions) + world.demanded[:, None]) % world.conventions
    return np.take_along_axis(chosen, roles[None], axis=2)


def _shares(world: Coordination) -> Float64:
    """What it is worth that all agents take a role, [n_roles]."""
    return np.array([1.0] + [world.agree] * (world.conventions - 1))


# --- which rules there are


def rules_of_depth(world: Coordination, depth: int) -> Int:
    """Every rule that a tree of at most this depth can follow, once each, [n_rules, n_cells].

    InputError where there are more than MAX_RULES.
    """
    masks = [world.cells[:, k] <= level for k in range(world.signals) for level in range(world.levels - 1)]
    return _grow_rules(world, masks, np.ones(len(world.cells), dtype=bool), depth)


def _grow_rules(world: Coordination, masks: Sequence[Bool], inside: Bool, depth: int) -> Int:
    """The rules for the cells inside, -1 elsewhere."""
    constants = np.where(inside, np.arange(world.conventions, dtype=np.int8)[:, None], np.int8(-1))
    if depth == 0 or inside.sum() == 1:
        return constants
    parts = [constants]
    for mask in masks:
        left, right = inside & mask, inside & ~mask
        if left.any() and right.any():
            low, high = _grow_rules(world, masks, left, depth - 1), _grow_rules(world, masks, right, depth - 1)
            if sum(map(len, parts)) + len(low) * len(high) > MAX_RULES:
                raise InputError(f"more than {MAX_RULES} trees for an agent", world.name, "fewer signals or levels")
            parts.append(np.where(left, low[:, None], high[None]).reshape(-1, len(inside)))
    return np.unique(np.concatenate(parts), axis=0)


# --- the best team


def optimum(world: Coordination, depth: int) -> Optimum:
    """The best team of trees of at most this depth. InputError where an agent has more than MAX_RULES."""
    rules = rules_of_depth(world, depth)
    chances = [_chances(world, kind, rules) for kind in range(world.kinds)]
    best = _maximise_products(world, chances) if world.rule not in PAIRS else _maximise_pairs(world, chances)
    team = rules[best].astype(np.int64)
    return Optimum(worth(world, team), team)


def _maximise_products(world: Coordination, chances: Sequence[Float64]) -> list[int]:
    """The best rule of each agent where payoffs are products: of each kind one."""
    members = [sum(world.kind(agent) == kind for agent in range(len(world.agents))) for kind in range(world.kinds)]
    shares = world.all_or_nothing * _shares(world) / len(world.cells)
    own = [
        (1 - world.all_or_nothing) * count / len(world.agents) * each[:, :, 0].mean(axis=1)
        for count, each in zip(members, chances, strict=True)
    ]
    paid = np.array([0, *np.flatnonzero(shares[1:]) + 1])  # roles that are worth anything
    used = [each[:, :, paid].reshape(len(each), -1) for each in chances]
    kept = [_find_undominated(each) for each in used]
    kinds = [
        _Kind(own[kind][rows], used[kind][rows] ** members[kind]) for kind, rows in enumerate(kept) if members[kind]
    ]
    weights = np.tile(shares[paid], len(world.cells))
    best = [int(kept[kind][row]) for kind, row in enumerate(_product(kinds, weights))]
    return [best[world.kind(agent)] for agent in range(len(world.agents))]


@dataclass(frozen=True)
class _Kind:
    """What the rules of a kind add: by themselves, and by their chances to the power of how many agents there are."""

    own: Float64  # [n_rules]
    power: Float64  # [n_rules, n_hidden * n_roles]


def _find_undominated(chances: Float64) -> Int:
    """Rows that no other row is at least as good as everywhere; of equal rows the first."""
    rounded = chances.round(12)
    first = np.sort(np.unique(rounded, axis=0, return_index=True)[1])
    every = rounded[first]
    beaten = [bool(((every >= row).all(axis=1) & (every > row).any(axis=1)).any()) for row in every]
    return first[~np.array(beaten)]


def _product(kinds: Sequence[_Kind], weights: Float64) -> list[int]:
    """The rows that maximise the sum of `own` and of weights times the product of powers."""
    if len(kinds) == 1:
        return [int(np.argmax(kinds[0].own + kinds[0].power @ weights))]
    if len(kinds) == 2:
        return _pair(kinds[0], kinds[1], weights)[1]
    first, *rest = kinds
    # with one kind's rule known, each other kind alone bounds what the rest can add, chances being at most 1
    bounds = first.own + sum(each.own.max() for each in rest)
    bounds = bounds + np.min([(first.power * weights @ each.power.T).max(axis=1) for each in rest], axis=0)
    best, best_rows = -np.inf, [0] * len(kinds)
    for row in np.argsort(-bounds, kind="stable"):
        if bounds[row] <= best + ROUNDING:
            break
        value, rows = _pair(rest[0], rest[1], weights * first.power[row])
        if value + first.own[row] > best:
            best, best_rows = value + first.own[row], [int(row), *rows]
    return best_rows


def _pair(a: _Kind, b: _Kind, weights: Float64) -> tuple[float, list[int]]:
    """The best rows of two kinds, and what they reach."""
    best, best_rows = -np.inf, [0, 0]
    scaled = (b.power * weights).T
    for rows in _parts(len(a.own), len(b.own)):
        table = a.own[rows, None] + b.own + a.power[rows] @ scaled
        place = int(table.argmax())
        if table.flat[place] > best:
            row, column = divmod(place, len(b.own))
            best, best_rows = float(table.flat[place]), [rows.start + row, column]
    return best, best_rows


def _parts(rows: int, columns: int) -> Iterator[slice]:
    at_once = max(1, AT_ONCE // columns)
    return (slice(low, low + at_once) for low in range(0, rows, at_once))


# --- games of pairs


def _maximise_pairs(world: Coordination, chances: Sequence[Float64]) -> list[int]:
    """The best rule of each agent where payoffs are sums over pairs."""
    n_agents, flat = len(world.agents), [each.reshape(len(each), -1) for each in chances]
    met = [(each @ PAIRS[world.rule]).reshape(len(each), -1) for each in chances]
    tables = {(k, m): met[k] @ flat[m].T for k in range(world.kinds) for m in range(world.kinds)}
    pairs = {(a, b): tables[world.kind(a), world.kind(b)] for a, b in combinations(range(n_agents), 2)}
    search = Search(pairs, n_agents)
    search.run()
    return search.best


class Search:
    """Branch and bound over agents, the first ones first. `pairs`: (a, b), a < b -> [n_rules of a, n_rules of b]."""

    def __init__(self, pairs: dict[tuple[int, int], Float64], n_agents: int) -> None:
        self.pairs, self.n_agents = pairs, n_agents
        self.nodes = 0
        self.sizes = [len(self.table(agent, 0 if agent else 1)) for agent in range(n_agents)]
        self.reached, self.best = max(map(self._climb_from, self._starts()))

    def table(self, a: int, b: int) -> Float64:
        """What rules of a and b reach together, a's in rows."""
        return self.pairs[a, b] if a < b else self.pairs[b, a].T

    def value(self, team: Sequence[int]) -> float:
        """What a team reaches."""
        return float(sum(self.pairs[a, b][team[a], team[b]] for a, b in combinations(range(self.n_agents), 2)))

    def _starts(self) -> Iterator[list[int]]:
        """Teams of one rule, a hundred of them at most."""
        least = min(self.sizes)
        for rule in range(0, least, max(1, least // 100)):
            yield [rule] * self.n_agents

    def _climb_from(self, team: list[int]) -> tuple[float, list[int]]:
        """A team after each agent's best answer to the others, until none gains."""
        value = self.value(team)
        while True:
            for agent in range(self.n_agents):
                mates = [other for other in range(self.n_agents) if other != agent]
                gains = sum(self.table(agent, other)[:, team[other]] for other in mates)
                team = [*team[:agent], int(np.argmax(gains)), *team[agent + 1 :]]
            if self.value(team) <= value + ROUNDING:
                return value, team
            value = self.value(team)

    def run(self) -> None:
        """Searches all teams."""
        self._extend([], 0.0, [np.zeros(size) for size in self.sizes])

    def _extend(self, team: list[int], value: float, given: Sequence[Float64]) -> None:
        """Tries every rule of the next agent. `given`: for each agent, what each of its rules adds with `team`."""
        self.nodes += 1
        agent = len(team)
        rest = range(agent + 1, self.n_agents)
        if not rest:
            row = int(np.argmax(given[agent]))
            if value + given[agent][row] > self.reached + ROUNDING:
                self.reached, self.best = value + float(given[agent][row]), [*team, row]
            return
        bounds = value + given[agent] + self._bound_rest(agent, given)
        for row in np.argsort(-bounds, kind="stable"):
            if bounds[row] <= self.reached + ROUNDING:
                return
            more = [*given]
            for other in rest:
                more[other] = given[other] + self.table(agent, other)[row]
            self._extend([*team, int(row)], value + float(given[agent][row]), more)

    def _bound_rest(self, agent: int, given: Sequence[Float64]) -> Float64:
        """For each rule of an agent, at most what the later ones can add."""
        rest = list(range(agent + 1, self.n_agents))
        if len(rest) == 1:
            return (self.table(agent, rest[0]) + given[rest[0]]).max(axis=1)
        total = np.zeros(len(given[agent]))
        share = len(rest) - 1
        for a, b in combinations(rest, 2):
            one = (self.table(agent, a) + given[a]) / share
            two = (self.table(agent, b) + given[b]) / share
            # max over both rules of one + two + table <= max over a of one + max over b of (two + table)
            among = self.pairs[a, b]
            total += np.minimum(
                (one + among.max(axis=1)).max(axis=1) + two.max(axis=1),
                one.max(axis=1) + (two + among.max(axis=0)).max(axis=1),
            )
        return total
