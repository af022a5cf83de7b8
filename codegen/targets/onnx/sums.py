"""Sums as nodes of ONNX: one multiplication and one addition for each place in a sum, for all sums at once.

Does: adds what a tree tests, and what the leaf that was reached gives; cuts and rounds the latter.
Assumes: a runtime whose elementwise operators round to their own type, one after the other, as onnxruntime's do.
Does not: choose the leaf (ensembles.py).

A constant is its value times 1, of a column of ones. Sums of unlike length have a -0.0 behind their last term: adding
it changes no number, not even a zero. No optimiser knows a term, so none leaves out one that is 0. `Where` gives 0.0
for a -0.0 in its second place under onnxruntime: only bounds stand there.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from codegen import ir
from codegen.errors import InputError
from codegen.sums import CONSTANT, choose_numbers


class Adding:
    """The nodes and constants of one model's sums."""

    def __init__(self, onnx: Any, arithmetic: str) -> None:
        self._onnx, self._numbers = onnx, choose_numbers(arithmetic)
        self.nodes: list[Any] = []
        self.constants: list[Any] = []

    def emit_sums(self, sums: Sequence[ir.Sum], seen: str) -> str:
        """The name of the values of sums, [N, n_sums], of the observations `seen`."""
        return self._add_terms(_places([list(sums)]), seen, None)

    def emit_outputs(self, policy: ir.AgentPolicy, seen: str, leaf: str, name: str) -> None:
        """Emits what the leaf numbered `leaf` [N] gives, cut and rounded, as `name` [N, n_outputs]."""
        tree = policy.tree
        if any(bound == 0 and np.signbit(bound) for each in policy.outputs for bound in (each.low, each.high)):
            what = f"a bound of {policy.agent} is -0.0, for which onnxruntime's Where gives 0.0"
            raise InputError(what, "--target onnx", "let the bound be 0.0, or leave the target out")
        value = self._add_terms(_places([list(vector) for vector in tree.vectors]), seen, leaf)
        low = [-np.inf if output.low is None else output.low for output in policy.outputs]
        high = [np.inf if output.high is None else output.high for output in policy.outputs]
        for bound, beyond in ((low, "Less"), (high, "Greater")):
            limit = self._constant(np.array(bound, self._numbers))
            value = self._node("Where", self._node(beyond, value, limit), limit, value)
        kind = self._onnx.helper.np_dtype_to_tensor_dtype(np.dtype(tree.gives))
        self.nodes.append(self._onnx.helper.make_node("Cast", [value], [name], to=kind))

    def cast(self, seen: str) -> str:
        """The observations in the numbers of sums."""
        kind = self._onnx.helper.np_dtype_to_tensor_dtype(np.dtype(self._numbers))
        return self._node("Cast", seen, to=kind)

    def concat_columns(self, *names: str) -> str:
        """Columns side by side."""
        return self._node("Concat", *names, axis=1)

    def _add_terms(self, places: "Sequence[_Place]", seen: str, leaf: str | None) -> str:
        one = self._constant(np.array(1, self._numbers))
        seen = self._node("Pad", seen, self._constant(np.array([0, 0, 0, 1], np.int64)), one)
        terms = [self._term(place, seen, leaf) for place in places]
        total = terms[0]
        for term in terms[1:]:
            total = self._node("Add", total, term)
        return total

    def _term(self, place: "_Place", seen: str, leaf: str | None) -> str:
        if leaf is None:
            feature = self._node("Gather", seen, self._constant(place.feature[0]), axis=1)
        else:
            feature = self._node("GatherElements", seen, self._look_up_row(place.feature, leaf), axis=1)
        return self._node("Mul", feature, self._look_up_row(place.weight.astype(self._numbers), leaf))

    def _look_up_row(self, table: Any, leaf: str | None) -> str:
        """A row of a table for each observation, by its leaf; or the only row."""
        return self._constant(table[0]) if leaf is None else self._node("Gather", self._constant(table), leaf, axis=0)

    def _constant(self, values: Any) -> str:
        name = f"constant_{len(self.constants)}"
        self.constants.append(self._onnx.numpy_helper.from_array(np.array(values, order="C"), name))
        return name

    def _node(self, operator: str, *inputs: str, **attributes: int) -> str:
        name = f"value_{len(self.nodes)}"
        self.nodes.append(self._onnx.helper.make_node(operator, list(inputs), [name], **attributes))
        return name


class _Place(NamedTuple):
    """The terms at one place in all sums, [rows, sums] each: a weight and its feature; -1: the last column, of ones."""

    weight: Any
    feature: Any


def _places(rows: Sequence[Sequence[ir.Sum]]) -> list[_Place]:
    longest = max(len(each.terms) for row in rows for each in row)
    return [_Place(*_tables([[_term(each, place) for each in row] for row in rows])) for place in range(longest)]


def _tables(terms: list[list[tuple[float, int]]]) -> tuple[Any, Any]:
    weights, features = ([[term[part] for term in row] for row in terms] for part in (0, 1))
    return np.array(weights, np.float64), np.array(features, np.int64)


def _term(each: ir.Sum, place: int) -> tuple[float, int]:
    return each.terms[place] if place < len(each.terms) else (-0.0, CONSTANT)
