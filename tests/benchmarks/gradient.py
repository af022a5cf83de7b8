"""Trees of a team without an expert: actors that are trees, trained by MAPPO's own gradient, for registered.py.

Does: hard, axis-aligned trees of one depth as actors in torch, whose gradient goes straight through their tests (the
  idea of SYMPOL, Marton et al., arXiv 2408.08761, for one agent), and the profile that they are, test by test.
Assumes: the extra `maviper[train]`; numbered actions.
Does not: choose among checkpoints, since no expert plays: the last one counts.

What differs from SYMPOL: teams, centralized values, a softmax in place of entmax, and no growing batches.
"""

from dataclasses import replace

import numpy as np
import torch
from torch.nn.functional import one_hot

from codegen import ir
from codegen.profiles import ensure
from maviper.episodes.trees import agent_policies
from maviper.experts.cards import Request, settings
from maviper.experts.training import mappo
from maviper.experts.training.nets import FORBIDDEN, Adam, Stacked
from maviper.files.profiles import version

SHARPNESS = 4.0  # of a test's sigmoid, in units of the feature: only its gradient counts
NAME = "direct"


class Trees(Stacked):
    """One full tree per agent, as stacked weights: which feature each test reads and its threshold for every feature,
    each [n_agents, tests, inputs]; what leaves say, [n_agents, leaves, actions].
    """

    def __init__(self, depth, widths, n_actions, generator):
        self.depth, self.widths = depth, widths
        tests, widest, n_agents = 2**depth - 1, max(widths), len(widths)
        shapes = [(n_agents, tests, widest), (n_agents, tests, widest), (n_agents, tests + 1, n_actions)]
        drawn = [torch.rand(*shape, generator=generator) * 2 - 1 for shape in shapes]
        super().__init__([part * size for part, size in zip(drawn, (0.1, 1.0, 0.1), strict=True)])
        self.parameters = [part.requires_grad_() for part in self.parameters]
        own = torch.arange(widest)[None, :] < torch.tensor(widths)[:, None]
        self.padding = torch.where(own, 0.0, FORBIDDEN)[:, None, :]

    def read(self):
        """Which feature each test reads, one-hot [n_agents, tests, inputs], and its threshold, [n_agents, tests]."""
        features, thresholds, _ = self.parameters
        likely = (features + self.padding).softmax(dim=2)
        chosen = straight_through(likely, one_hot(likely.argmax(dim=2), likely.shape[2]).float())
        return chosen, (chosen * thresholds).sum(dim=2)

    def __call__(self, x):
        """x: [n_agents, batch, inputs] -> logits [n_agents, batch, actions]."""
        chosen, thresholds = self.read()
        beyond = thresholds[:, None, :] - x @ chosen.transpose(1, 2)
        left = straight_through((SHARPNESS * beyond).sigmoid(), (beyond >= 0).float())
        reached = torch.ones_like(left[:, :, :1])
        for level in range(self.depth):
            here = left[:, :, 2**level - 1 : 2 ** (level + 1) - 1]
            reached = torch.stack([reached * here, reached * (1 - here)], dim=3).flatten(2)
        return reached @ self.parameters[2]

    def grown(self, choices):
        """Each agent's tree. `choices`: how many actions it has."""
        chosen, thresholds = (part.detach() for part in self.read())
        features, thresholds, said = chosen.argmax(dim=2).numpy(), thresholds.numpy(), self.parameters[2].detach()
        return [
            tree_of(features[agent], thresholds[agent], said[agent, :, :own].argmax(dim=1).numpy())
            for agent, own in enumerate(choices)
        ]


def straight_through(soft, hard):
    """The hard values, with the gradient of the soft ones."""
    return hard.detach() + soft - soft.detach()


def tree_of(features, thresholds, actions):
    """A full tree, from tests level by level and leaves from left to right. Tests of two equal leaves are left out."""
    rows = []

    def add(test):
        place = len(rows)
        if test >= len(features):
            rows.append([ir.NO_FEATURE, 0.0, ir.NO_CHILD, ir.NO_CHILD, actions[test - len(features)]])
            return place
        rows.append([features[test], thresholds[test], place + 1, None, ir.NO_ACTION])
        add(2 * test + 1)
        rows[place][3] = add(2 * test + 2)
        two_leaves = len(rows) == place + 3
        if two_leaves and rows[place + 1][4] == rows[place + 2][4]:
            rows[place:] = [rows[place + 1]]
        return place

    add(0)
    kinds = (np.int32, np.float64, np.int32, np.int32, np.int32)
    columns = [np.array(column, kind) for column, kind in zip(zip(*rows, strict=True), kinds, strict=True)]
    return ir.GrownTree(*columns)


class Direct(mappo.Mappo):
    """MAPPO whose actors are trees."""

    def __init__(self, world, chosen, depth):
        super().__init__(world, chosen, "cpu")
        joint = self.joint
        self.actor = Trees(depth, joint.widths, joint.n_actions, self.generator)
        self.nets["actor"] = self.actor
        self.optimisers["actor"] = Adam((self.actor,), chosen.learning_rate, chosen.gradient_norm)


def trained(world, depth, seed, given):
    """The profile of a team that learned by reward. `given`: settings of MAPPO beside the game's own."""
    torch.set_num_threads(1)
    chosen = settings(world, Request("mappo", overrides={**given, "seed": seed}), mappo.Settings)
    trainer, updates = Direct(world, replace(chosen, shared=0, past=0.0), depth), 0
    while trainer.steps < chosen.steps:
        trainer.advance()
        updates += 1
    trees = trainer.actor.grown(trainer.joint.choices)
    facts = {"stopped_after": updates, "steps": trainer.steps, "shaping": chosen.shaping}
    about = ir.Provenance(NAME, "none", seed, "", f"maviper {version()}", facts)
    return ensure(ir.PolicyProfile(world.spec, agent_policies(world, trees), about))
