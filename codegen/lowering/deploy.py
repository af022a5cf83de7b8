"""From a tree as it was grown to the tree that is deployed.

Does: rounds float64 thresholds down to float32, unless float64 is compared; renumbers the nodes in preorder.
Assumes: the grown tree is sound (the IR's checker looks at both).
Does not: change a decision for any observation of the numbers that are compared.
"""

import numpy as np

from codegen.floats import FLOAT32, at_most
from codegen.ir import NO_CHILD, NO_FEATURE, ROOT, GrownTree, Tree


def deployed(grown: GrownTree, numbers: str = FLOAT32) -> Tree:
    """The deployed form of a grown tree. `numbers`: what it compares."""
    order: list[int] = []
    stack = [ROOT]
    while stack:
        node = stack.pop()
        order.append(node)
        if grown.feature[node] != NO_FEATURE:
            stack += [int(grown.right[node]), int(grown.left[node])]
    new_id = {node: place for place, node in enumerate(order)} | {NO_CHILD: NO_CHILD}
    split = grown.feature != NO_FEATURE
    threshold = np.where(split, at_most(grown.threshold, numbers), np.zeros(1, numbers))
    return Tree(
        feature=grown.feature[order],
        # adding zero turns -0.0 into 0.0, which compares alike and has one spelling
        threshold=threshold[order] + threshold.dtype.type(0),
        left=np.array([new_id[int(node)] for node in grown.left[order]]),
        right=np.array([new_id[int(node)] for node in grown.right[order]]),
        action=grown.action[order],
        numbers=numbers,
    )
