"""Affine forms cut by regions, and by what agents decide in them.

Does: forms within and outside of a polytope; sends forms down the trees of all agents, cut at tests that they meet on
  both sides.
Assumes: the exact sides of tests, as systems/trees.py has them.
Does not: move forms.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import inf

import numpy as np

from codegen.ir import NO_FEATURE, AgentPolicy, Bool, Float64, Int64, splits
from verify.checker.covers.cuts import end_of, opposite
from verify.checker.covers.forms.arrays import FormCut, FormList, narrow_forms, sides, sums, together, weight
from verify.checker.reading import RejectedError
from verify.checker.systems.trees import goes_left
from verify.claims.formula import FALSE, TRUE, Formula, Linear, Or
from verify.systems.system import System


def weights(inequality: Linear, columns: Mapping[str, int]) -> Float64:
    """The factors of an inequality, by column."""
    factors = np.zeros(len(columns))
    for factor, name in inequality.terms:
        factors[columns[name]] = weight(factor)
    return factors


def half(inequality: Linear, columns: Mapping[str, int]) -> FormCut:
    """An inequality as a cut of forms."""
    end = end_of(inequality.bound, inequality.strict)
    return FormCut(weights(inequality, columns), end.last, end.up)


class FormRegion:
    """A polytope, by the cuts of its half spaces and of their opposites."""

    def __init__(self, inequalities: Sequence[Linear], columns: Mapping[str, int]) -> None:
        self._sides = [(half(each, columns), half(opposite(each), columns)) for each in inequalities]

    def within(self, forms: FormList) -> FormList:
        """Forms around the states that may lie in it."""
        for inside, _ in self._sides:
            forms = inside.within(forms)
        return forms

    def outside(self, forms: FormList) -> FormList:
        """Forms around the states that may lie outside of it."""
        outer_parts = [forms.take(np.zeros(forms.size, dtype=np.bool_))]
        for inside, outside in self._sides:
            outer_parts.append(outside.within(forms))
            forms = inside.within(forms)
        return together(outer_parts)


class FormTree:
    """One agent's tree: of each test the factors, and the ends of the two half lines as of `sides`. A test for equality
    goes left on both sides of a number: it is two nodes, the second of them behind the whole tree.
    """

    def __init__(self, system: System, policy: AgentPolicy, columns: Mapping[str, int]) -> None:
        tree, features, self.actions = policy.tree, system.features[policy.agent], len(policy.actions)
        tests: dict[int, Formula] = {
            node: goes_left(
                features[policy.features[int(tree.feature[node])].name], float(tree.threshold[node]), policy.numbers
            )
            for node in splits(tree)
        }
        twice = [node for node, test in tests.items() if isinstance(test, Or) and test.parts]
        own, count = len(tree.feature), len(tree.feature) + len(twice)
        self._action = np.append(tree.action, np.zeros(len(twice))).astype(np.int64)
        self._leaf: Bool = np.append(np.array(tree.feature) == NO_FEATURE, np.zeros(len(twice), dtype=np.bool_))
        self._left = np.append(tree.left, [tree.left[node] for node in twice]).astype(np.int64)
        self._right = np.append(tree.right, [tree.right[node] for node in twice]).astype(np.int64)
        self._weights = np.zeros((count, len(columns)))
        self._ends = np.zeros((count, 2, 2))  # [node, side, last and up]
        for node, test in tests.items():
            if node not in twice:
                self._test(node, test, columns)
        for behind, node in enumerate(twice, own):
            self._right[node] = behind
            for at, part in zip((node, behind), _two(tests[node]), strict=True):
                self._test(at, part, columns)

    def _test(self, node: int, test: Formula, columns: Mapping[str, int]) -> None:
        if isinstance(test, Linear):
            self._weights[node] = weights(test, columns)
            for place, each in enumerate((test, opposite(test))):
                self._ends[node, place] = end_of(each.bound, each.strict)
        elif test in (TRUE, FALSE):
            self._ends[node] = ((inf, inf), (-inf, -inf)) if test == TRUE else ((-inf, -inf), (inf, inf))
        else:
            raise RejectedError("a test that forms do not know")

    def split_at_tests(self, forms: FormList) -> FormList:
        """The forms, cut at the tests, each with this agent's action as one more digit of its joint action."""
        at_leaves, node = [forms.take(np.zeros(forms.size, dtype=np.bool_))], np.zeros(forms.size, dtype=np.int64)
        while len(node):
            done = self._leaf[node]
            leaves = forms.take(done)
            at_leaves.append(leaves._replace(joint=leaves.joint * self.actions + self._action[node[done]]))
            forms, node = self._below(forms.take(~done), node[~done])
        return together(at_leaves)

    def _below(self, forms: FormList, node: Int64) -> tuple[FormList, Int64]:
        """One level further down."""
        of = sums(forms, self._weights[node])
        below: list[FormList] = []
        nodes: list[Int64] = []
        for place, (to, each) in enumerate(((self._left, of), (self._right, of.negative()))):
            last, up = self._ends[node, place].T
            whole, crossing = sides(each, last, up)
            below += [forms.take(whole), narrow_forms(forms.take(crossing), each.take(crossing), up[crossing])]
            nodes += [to[node[whole]], to[node[crossing]]]
        return together(below), np.concatenate(nodes)


def _two(test: Formula) -> tuple[Formula, Formula]:
    """The two parts of a test for equality."""
    if not isinstance(test, Or) or len(test.parts) != 2:
        raise RejectedError("a test that forms do not know")
    return test.parts[0], test.parts[1]
