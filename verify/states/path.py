"""The path of one decision: the tests that lead to it.

Does: walks a tree for one observation, and puts each test into words.
Assumes: a checked profile.
Does not: say why the tree was grown so.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import isnan

from codegen import ir
from codegen.wording import describe_sum, fails, holds, is_zero, number
from verify.states.real import Value


@dataclass(frozen=True)
class Step:
    """One test on a decision path: `value` of `feature` against `threshold`."""

    node: int
    feature: str
    value: Value
    threshold: float
    left: bool

    def __str__(self) -> str:
        value, near = float(self.value), is_zero(float(self.value)) and self.value != 0
        told = holds(self.threshold) if self.left else fails(self.threshold)
        if isnan(value):
            return f"{self.feature} = nan, not {holds(self.threshold)}"
        if near or (f"{value:.6g}" == number(self.threshold) and self.value not in (self.threshold, 0)):
            return f"{self.feature} = {self.value} {'<=' if self.left else '>'} {self.threshold!r}"
        return f"{self.feature} = {value:.6g} {told}"


def path(policy: ir.AgentPolicy, seen: Sequence[Value]) -> tuple[Step, ...]:
    """The tests that lead to the decision for one observation, rounded or exact: [n_features], and then the sums that
    the tree tests.
    """
    tree, node, steps = policy.tree, ir.ROOT, list[Step]()
    names = [feature.name for feature in policy.features]
    names += [describe_sum(each.terms, names, digits=3) for each in tree.sums]
    while tree.feature[node] != ir.NO_FEATURE:
        feature, threshold = int(tree.feature[node]), float(tree.threshold[node])
        left = seen[feature] <= threshold
        steps.append(Step(node, names[feature], seen[feature], threshold, left))
        node = int(tree.left[node] if left else tree.right[node])
    return tuple(steps)
