"""The path of one decision: the tests that lead to it.

Does: walks a tree for one observation, and puts each test into words.
Assumes: a checked profile.
Does not: say why the tree was grown so.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from codegen import ir
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
        value, threshold = f"{float(self.value):.6g}", f"{self.threshold:.6g}"
        if value == threshold and self.value != self.threshold:
            value, threshold = str(self.value), repr(self.threshold)
        return f"{self.feature} = {value} {'<=' if self.left else '>'} {threshold}"


def path(policy: ir.AgentPolicy, seen: Sequence[Value]) -> tuple[Step, ...]:
    """The tests that lead to the decision for one observation [n_features], rounded or exact."""
    tree, node, steps = policy.tree, ir.ROOT, list[Step]()
    while tree.feature[node] != ir.NO_FEATURE:
        feature, threshold = int(tree.feature[node]), float(tree.threshold[node])
        left = seen[feature] <= threshold
        steps.append(Step(node, policy.features[feature].name, seen[feature], threshold, left))
        node = int(tree.left[node] if left else tree.right[node])
    return tuple(steps)
