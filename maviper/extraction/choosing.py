"""Which further features would help trees to act as an expert does.

Does: grows trees with and without each group on the expert's own episodes and keeps what predicts held-out ones better.
Assumes: groups that are derived from what agents observe already; a further sensor is a user's decision.
Does not: play trees.
"""

import numpy as np

from codegen import ir
from codegen.errors import InputError
from codegen.ir import Float32
from maviper.episodes import measures
from maviper.episodes.play import points, rollout
from maviper.experts.expert import Expert, labels
from maviper.extraction.dataset import Dataset
from maviper.extraction.growth.growing import Growth
from maviper.extraction.settings import Settings
from maviper.worlds import ParticleWorld, World, find_built_in
from maviper.worlds.games.features import DERIVED, SEPARATOR
from maviper.worlds.world import Int

EPISODES, HELD_OUT = 200, 50
LEAST_GAIN = 0.01  # of the share of held-out actions that are predicted right, all agents together


def helpful_features(world: ParticleWorld, expert: Expert, settings: Settings) -> str:
    """Groups of features, best first, joined as an option says them; "" when none helps."""
    seeds = settings.episodes(measures.ROLLOUT_SEEDS)[:EPISODES]
    (played,) = rollout(world, [expert] * len(world.agents), seeds)
    observations, state = points(played)
    wanted = labels(expert, observations, state)
    held = np.arange(len(wanted)) % EPISODES < HELD_OUT
    chosen: list[str] = []
    reached = _right(world, world.observe(state), wanted, held, settings)
    while True:
        accuracy: dict[str, float] = {}
        for group in DERIVED:
            try:
                wide = find_built_in(f"{world.name},features={SEPARATOR.join([*chosen, group])}")
            except InputError:  # it is there already, or adds nothing
                continue
            accuracy[group] = _right(wide, wide.observe(state), wanted, held, settings)
        best = max(accuracy, key=lambda group: accuracy[group], default="")
        if not best or accuracy[best] < reached + LEAST_GAIN:
            return SEPARATOR.join(chosen)
        chosen.append(best)
        reached = accuracy[best]


def _right(world: World, observations: tuple[Float32, ...], wanted: Int, held: ir.Bool, settings: Settings) -> float:
    """The share of held-out actions that trees grown on the others predict."""
    growth = Growth(world, settings)
    shape = wanted[~held].shape
    known = Dataset(tuple(seen[~held] for seen in observations), wanted[~held], np.ones(shape), np.ones(shape, bool))
    ones = [np.ones(len(known), dtype=np.int64)] * len(observations)
    shares = list[float]()
    for agent, seen in enumerate(observations):
        (tree,) = growth.team([agent], known, ones, [settings.seed] * len(observations), 0)
        shares.append(float((tree.action[ir.apply(tree, seen[held])] == wanted[held, agent]).mean()))
    return float(np.mean(shares))
