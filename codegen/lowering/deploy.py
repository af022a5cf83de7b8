"""From a tree as it was grown to the tree that is deployed.

Does: rounds float64 thresholds down to float32, renumbers the nodes in preorder.
Assumes: the grown tree is sound (the IR's checker looks at both).
Does not: change a decision for any float32 observation.
"""

import numpy as np

from codegen.floats import round_down
from codegen.ir import NO_CHILD, NO_FEATURE, ROOT, GrownTree, Tree


def deployed(grown: GrownTree) -> Tree:
    """The deployed form of a grown tree."""
    order: list[int] = []
    stack = [ROOT]
    while stack:
        node = stack.pop()
        order.append(node)
        if grown.feature[node] != NO_FEATURE:
            stack += [int(grown.right[node]), int(grown.left[node])]
    new_id = {node: place for place, node in enumerate(order)} | {NO_CHILD: NO_CHILD}
    split = grown.feature != NO_FEATURE
    threshold = np.where(split, round_down(grown.threshold), np.float32(0))
    return Tree(
        feature=grown.feature[order],
        # adding zero turns -0.0 into 0.0, which compares alike and has one spelling
        threshold=threshold[order] + np.float32(0),
        left=np.array([new_id[int(node)] for node in grown.left[order]]),
        right=np.array([new_id[int(node)] for node in grown.right[order]]),
        action=grown.action[order],
    )
