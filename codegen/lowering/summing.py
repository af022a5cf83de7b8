"""Lowering of trees whose tests or leaves have sums.

Does: turns terms, thresholds, bounds and leaves into exact literals; clips and rounds what leaves give in any case.
Assumes: a checked tree.
Does not: write text of any language.
"""

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from codegen import ir
from codegen.check import identifier
from codegen.floats import FLOAT32, short_hex
from codegen.lowering.parts import Action, Double, Feature, Node
from codegen.lowering.summed import Given, Output, SumLine, Summed, SumNode, Term
from codegen.numbers import decimal_literal
from codegen.sums import FLOAT32_STEPS
from codegen.wording import describe_sum, holds

SHOWN_DIGITS = 3  # of what leaves give, where people read it


def lower_sums(
    policy: ir.AgentPolicy, features: Sequence[Feature], actions: Sequence[Action], single: Callable[[int], Node]
) -> Summed | None:
    """The tree of an agent, ready to be written; None where it has no sums. `single`: the node of a plain test."""
    tree = policy.tree
    if not tree.arithmetic:
        return None
    outputs = tuple(_output(index, each) for index, each in enumerate(policy.outputs))
    nodes = tuple(_node(policy, node, features, actions, outputs, single) for node in range(len(tree.feature)))
    return Summed(tree.arithmetic, tree.gives, outputs, nodes, tuple(_lines(nodes)))


def _number(value: float, single: bool) -> Double:
    return Double(short_hex(value) + ("f" if single else ""), decimal_literal(value))


def _output(index: int, output: ir.OutputSpec) -> Output:
    low, high = (None if bound is None else _number(bound, single=False) for bound in (output.low, output.high))
    return Output(index, output.name, identifier(output.name).upper(), output.unit, low, high)


def _node(
    policy: ir.AgentPolicy,
    node: int,
    features: Sequence[Feature],
    actions: Sequence[Action],
    outputs: Sequence[Output],
    single: Callable[[int], Node],
) -> SumNode:
    tree, place = policy.tree, int(policy.tree.feature[node])
    children = int(tree.left[node]), int(tree.right[node])
    if place == ir.NO_FEATURE:
        chosen = int(tree.action[node])
        given = (
            tuple(
                _lower_given(policy, each, sum_, features)
                for each, sum_ in zip(outputs, tree.vectors[chosen], strict=True)
            )
            if outputs
            else ()
        )
        return SumNode(node, None, (), None, "", None if outputs else actions[chosen], given, *children)
    if place < len(features):
        plain = single(node)
        return SumNode(
            node, plain, (), None, f"{plain.feature.name if plain.feature else ''} {plain.test}", None, (), *children
        )
    terms = _terms(tree.sums[place - len(features)], features, tree.arithmetic)
    threshold = float(tree.threshold[node])
    shown = (
        f"{describe_sum(tree.sums[place - len(features)].terms, [each.name for each in features])} {holds(threshold)}"
    )
    return SumNode(node, None, terms, _number(threshold, tree.arithmetic == FLOAT32_STEPS), shown, None, (), *children)


def _terms(each: ir.Sum, features: Sequence[Feature], arithmetic: str) -> tuple[Term, ...]:
    return tuple(_term(weight, place, features, arithmetic == FLOAT32_STEPS) for weight, place in each.terms)


def _term(weight: float, place: int, features: Sequence[Feature], single: bool) -> Term:
    sign = "-" if np.signbit(weight) else "+"
    size = None if abs(weight) == 1 and place != ir.CONSTANT else _number(abs(weight), single)
    return Term(sign, size, None if place == ir.CONSTANT else features[place])


def _lower_given(policy: ir.AgentPolicy, output: Output, each: ir.Sum, features: Sequence[Feature]) -> Given:
    tree, spec = policy.tree, policy.outputs[output.index]
    if any(place != ir.CONSTANT for _, place in each.terms):
        shown = describe_sum(each.terms, [feature.name for feature in features], SHOWN_DIGITS)
        return Given(output, _terms(each, features, tree.arithmetic), None, shown)
    value = ir.clip_values(
        each.value(np.zeros((1, len(features)), policy.numbers), tree.arithmetic), spec.low, spec.high
    )
    number = float(value.astype(tree.gives)[0])
    return Given(output, (), _number(number, tree.gives == FLOAT32), f"{number:.{SHOWN_DIGITS}g}")


def _lines(nodes: Sequence[SumNode]) -> Iterator[SumLine]:
    stack = [_opening(nodes[ir.ROOT], 0)]
    while stack:
        line = stack.pop()
        yield line
        if line.kind == "if":
            node, inner = line.node, line.level + 1
            right = (
                SumLine("else", line.level, node),
                _opening(nodes[node.right], inner),
                SumLine("end", line.level, node),
            )
            stack += [*reversed(right), _opening(nodes[node.left], inner)]


def _opening(node: SumNode, level: int) -> SumLine:
    return SumLine("if" if node.split else "leaf", level, node)
