"""Trees with small trees in the place of leaves.

Does: puts subtrees where leaves were, in preorder again.
Assumes: sound trees over the same features and actions.
Does not: choose subtrees; say what they change (passes.difference proves what stays).
"""

from collections.abc import Mapping

import numpy as np

from codegen.ir import NO_ACTION, NO_CHILD, NO_FEATURE, ROOT, Tree

LEFT, RIGHT = 2, 3  # columns of a row


def grafted(tree: Tree, parts: Mapping[int, Tree]) -> Tree:
    """`tree` with each leaf that `parts` names replaced by its part. KeyError for a node that is no leaf."""
    for node in parts:
        if not 0 <= node < len(tree.feature) or tree.feature[node] != NO_FEATURE:
            raise KeyError(node)
    rows: list[list[float]] = []
    stack: list[tuple[Tree, int, int, int]] = [(tree, ROOT, -1, 0)]
    while stack:
        source, node, parent, column = stack.pop()
        if source is tree and node in parts:
            source, node = parts[node], ROOT
        place = len(rows)
        if parent >= 0:
            rows[parent][column] = place
        if source.feature[node] == NO_FEATURE:
            rows.append([NO_FEATURE, 0.0, NO_CHILD, NO_CHILD, int(source.action[node])])
            continue
        rows.append([int(source.feature[node]), float(source.threshold[node]), NO_CHILD, NO_CHILD, NO_ACTION])
        stack += [(source, int(source.right[node]), place, RIGHT), (source, int(source.left[node]), place, LEFT)]
    return Tree(*np.array(rows).T)
