"""Formulas and matchings by numbers: what a formula is worth at a point, and where one holds in many states at once.

Does: the quantitative value of a formula, a formula with slack, and evaluation over batches in float64; decides, for a
  batch of relations, whether the team can be matched one-to-one to the landmarks, and whether a batch of choices can
  prevent any matching.
Assumes: verify/claims/formula.py; at most about a dozen agents in a matching (the work doubles with each).
Does not: belong to what proofs rest on, which name every matching.
"""

import math
from collections.abc import Mapping, Sequence
from fractions import Fraction
from functools import reduce
from itertools import permutations

import numpy as np

from codegen.ir import GOAL, Bool, Float64, Int32
from verify.claims.formula import Acts, And, Formula, Goal, Linear, Not, Or

MAX_TRIED = 6  # three agents and three landmarks: fewer operations than sets of landmarks take


def has_matching(related: Bool) -> Bool:
    """Tests where each agent can have a landmark of its own. `related`: [..., n_agents, n_landmarks]. Returns [...].

    After each agent, the sets of landmarks (as bits) that the agents so far can hold; few matchings are tried one by
    one.
    """
    n_agents, n_landmarks = map(int, related.shape[-2:])
    if math.perm(n_landmarks, n_agents) <= MAX_TRIED:
        matched = np.zeros(related.shape[:-2], dtype=bool)
        for way in permutations(range(n_landmarks), n_agents):
            matched |= reduce(np.logical_and, (related[..., agent, own] for agent, own in enumerate(way)), np.True_)
        return matched
    holdable = np.zeros((*related.shape[:-2], 1 << n_landmarks), dtype=bool)
    holdable[..., 0] = True
    for agent in range(n_agents):
        following = np.zeros_like(holdable)
        for held in range(1 << n_landmarks):
            for landmark in range(n_landmarks):
                if not held >> landmark & 1:
                    following[..., held | 1 << landmark] |= holdable[..., held] & related[..., agent, landmark]
        holdable = following
    return np.asarray(holdable.any(axis=-1))


def preventable(choices: Sequence[Sequence[tuple[Bool, Bool]]], n_landmarks: int) -> Bool:
    """Where some joint choice, one allowed choice of every agent, leaves no matching, [batch].

    `choices`: for each agent its choices as pairs (allowed [batch], landmarks it can then hold [batch, n_landmarks]).
    By Hall's theorem that is so iff more agents can choose to hold only landmarks of some set than the set has.
    """
    outside = 1 << np.arange(n_landmarks)
    masks = [[(allowed, related @ outside) for allowed, related in agent] for agent in choices]
    choosing = np.logical_and.reduce([np.logical_or.reduce([allowed for allowed, _ in agent]) for agent in choices])
    prevented = np.zeros_like(choosing)
    for kept in range(1 << n_landmarks):
        confined = np.zeros(len(prevented), dtype=np.int64)
        for agent in masks:
            confined += np.logical_or.reduce([allowed & (mask & ~kept == 0) for allowed, mask in agent])
        prevented |= confined > kept.bit_count()
    return np.asarray(prevented & choosing)


def tighten_formula(formula: Formula, slack: Fraction) -> Formula:
    """A formula of `normal` form with every inequality met by `slack` more than it asks; unchanged for slack 0."""
    if not slack:
        return formula
    if isinstance(formula, Linear):
        return Linear(formula.terms, formula.bound - slack)
    if isinstance(formula, And):
        return And(tuple(tighten_formula(part, slack) for part in formula.parts))
    return Or(tuple(tighten_formula(part, slack) for part in formula.parts)) if isinstance(formula, Or) else formula


def worth(formula: Formula, at: Mapping[str, Fraction], actions: Mapping[str, int]) -> Fraction | float:
    """The quantitative value of a formula at an exact point, with the chosen actions; `for_goal` was applied before.

    An inequality is worth its bound less its sum, "and" the least of its parts, "or" the greatest, "not" the opposite,
    an action infinity where it is the one taken, else minus infinity; exact, or infinite. At least 0 where the formula
    holds, at most 0 where it does not; with every bound relaxed by r a formula without "not" is worth r more.
    Source: Fainekos and Pappas 2009, robustness of a formula, here without time.
    """
    if isinstance(formula, Linear):
        return formula.bound - sum((weight * at[name] for weight, name in formula.terms), Fraction(0))
    if isinstance(formula, Acts):
        return math.inf if actions[formula.agent] == formula.action else -math.inf
    if isinstance(formula, Not):
        return -worth(formula.part, at, actions)
    assert isinstance(formula, (And, Or)), formula
    parts = [worth(part, at, actions) for part in formula.parts]
    return min(parts, default=math.inf) if isinstance(formula, And) else max(parts, default=-math.inf)


class Batch:
    """Formulas over a batch of world states, in float64; atoms are evaluated once.

    `columns`: coordinate -> [batch]. States within a rounding of a boundary may be misjudged; the goal is taken to be
    the landmark at whose place it is. `doubting`: an inequality is true also where float64 cannot exclude it, so that a
    formula of `normal` form without goals that is false is so exactly.
    """

    def __init__(self, columns: Mapping[str, Float64], count: int, doubting: bool = False) -> None:
        self._columns = columns
        self._count = count
        self._doubting = doubting
        self._known: dict[Linear, Bool] = {}

    def holds(self, formula: Formula, actions: Mapping[str, Int32]) -> Bool:
        """Where the formula is true, [batch]. `actions`: agent -> [batch]."""
        if isinstance(formula, Linear):
            if formula not in self._known:
                self._known[formula] = self._atom(formula)
            return self._known[formula]
        if isinstance(formula, Acts):
            return np.asarray(actions[formula.agent] == formula.action)
        if isinstance(formula, Goal):
            pairs = ((self._columns[f"{GOAL}.{axis}"], self._columns[f"{formula.landmark}.{axis}"]) for axis in "xy")
            return np.logical_and.reduce([goal == mark for goal, mark in pairs])
        if isinstance(formula, Not):
            return ~self.holds(formula.part, actions)
        truth = np.full(self._count, isinstance(formula, And))
        for part in formula.parts:
            if isinstance(formula, And):
                truth &= self.holds(part, actions)
            else:
                truth |= self.holds(part, actions)
        return truth

    def _atom(self, atom: Linear) -> Bool:
        total = np.zeros(self._count)
        for weight, name in atom.terms:
            column = self._columns[name]
            if abs(weight) == 1:
                (np.add if weight == 1 else np.subtract)(total, column, out=total)
            else:
                total += float(weight) * column
        if self._doubting:
            # more than what the roundings of weights, bound, products, sum and difference can add up to
            size = np.full(self._count, abs(float(atom.bound)))
            for weight, name in atom.terms:
                size += abs(float(weight)) * np.abs(self._columns[name])
            error = (len(atom.terms) + 4) * np.finfo(np.float64).eps * size + np.finfo(np.float64).tiny
            return ~(total - float(atom.bound) > error)  # true of NaN
        return np.asarray(total < float(atom.bound) if atom.strict else total <= float(atom.bound))
