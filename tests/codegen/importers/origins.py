"""What several tests of importers share: observations at which an origin is asked, and data to train on."""

import numpy as np

from codegen import ir
from codegen.importers import replay
from codegen.importers.origin import Names, profile_of


def data(seed, width=4, classes=3):
    """Observations and classes to learn, [600, width] float32 and [600]."""
    rng = np.random.default_rng(seed)
    x = rng.normal(size=(600, width)).astype(np.float32)
    return x, (x[:, 0] > x[:, 1]).astype(int) + (x[:, 2] > 0.3) * (classes - 1)


def asked(origins, finite=True):
    """The imported policy of one origin, and the observations of its replay."""
    (policy,) = profile_of(origins, Names()).agents
    return policy, replay.observations(policy, nan=False, finite=finite)


def decided(origins, policy, rows):
    """The labels that the imported policy gives: each action's own, or else its number or name."""
    (origin,) = origins.values()
    return [label_of(policy, origin, action) for action in ir.act(policy, rows).tolist()]


def answered(origin, rows):
    """The labels that a source itself answers."""
    with origin.second() as running:
        return [origin.labels[each] for each in running.ask(rows).told]


def label_of(policy, origin, action):
    """What a source returns, as the profile says it."""
    given = policy.actions[action]
    return given.label if given.label is not None else given.name if isinstance(origin.labels[0], str) else action
