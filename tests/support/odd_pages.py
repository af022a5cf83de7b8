"""What several tests use of `maviper.page.test_odd_pages`."""

import dataclasses

import numpy as np

from codegen import ir


def complete_tree(depth, n_features, n_actions):
    """A tree with a split at every place: thresholds in order, so that all leaves are reached."""
    rng = np.random.default_rng(depth)
    parts = {name: [] for name in ("feature", "threshold", "left", "right", "action")}

    def add(level, low, high):
        node = len(parts["feature"])
        middle = (low + high) / 2
        split = level < depth
        values = (0 if split else -1, middle if split else 0.0, -1, -1, -1 if split else int(rng.integers(n_actions)))
        for name, value in zip(parts, values, strict=True):
            parts[name].append(value)
        if split:
            parts["left"][node] = add(level + 1, low, middle)
            parts["right"][node] = add(level + 1, middle, high)
        return node

    add(0, -1.0, 1.0)
    kinds = {"threshold": np.float32}
    return ir.Tree(**{name: np.array(values, kinds.get(name, np.int32)) for name, values in parts.items()})


def with_trees(profile, depth):
    policies = tuple(
        dataclasses.replace(one, tree=complete_tree(depth, len(one.features), len(one.actions)), grown=None)
        for one in profile.agents
    )
    return dataclasses.replace(profile, agents=policies)
