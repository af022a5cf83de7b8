"""How far trees act as the expert that they come from: over on-policy states, by action and by leaf.

Does: asks the expert about the states that the trees meet, and counts.
Assumes: episodes of the profile's own trees, with their states; an expert that is shipped, found by its hash.
Does not: say whether a difference matters; the measures of play do.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from codegen import ir
from maviper.episodes.play import Episodes, points
from maviper.evaluation.players import find_shipped
from maviper.experts.expert import labels
from maviper.worlds import World
from maviper.worlds.world import Int


@dataclass(frozen=True)
class Counted:
    """In how many of some states an agent's tree acts as the expert."""

    agreeing: int
    states: int

    @property
    def share(self) -> float:
        """The share of agreeing states; 0 where there are none."""
        return self.agreeing / self.states if self.states else 0.0

    def __add__(self, other: "Counted") -> "Counted":
        return Counted(self.agreeing + other.agreeing, self.states + other.states)


@dataclass(frozen=True)
class Fidelity:
    """One agent: in all states, by the action that the expert takes, and by the leaf that decides."""

    agent: str
    whole: Counted
    by_action: Mapping[str, Counted]
    by_leaf: Mapping[int, Counted]

    def __add__(self, other: "Fidelity") -> "Fidelity":
        """The same agent in more states."""
        by_action = {name: count + other.by_action[name] for name, count in self.by_action.items()}
        by_leaf = {leaf: count + other.by_leaf[leaf] for leaf, count in self.by_leaf.items()}
        return Fidelity(self.agent, self.whole + other.whole, by_action, by_leaf)

    def document(self) -> dict[str, object]:
        """Returns the counts as plain data."""
        return {
            "agent": self.agent,
            "states": self.whole.states,
            "agreement": round(self.whole.share, 6),  # the word of before, in files that are committed
            "by_action": {name: [item.agreeing, item.states] for name, item in self.by_action.items()},
            "by_leaf": {str(leaf): [item.agreeing, item.states] for leaf, item in self.by_leaf.items()},
        }


def fidelity(profile: ir.PolicyProfile, world: World, episodes: Episodes) -> tuple[Fidelity, ...]:
    """Each agent's fidelity to the expert in the states of `episodes`; () where the expert is not shipped."""
    expert = find_shipped(profile.provenance.expert, world)
    if expert is None:
        return ()
    observations, state = points(episodes)
    wanted = labels(expert.controller, observations, state)  # pyright: ignore[reportArgumentType]
    alive = episodes.alive.reshape(wanted.shape)
    by_agent: list[Fidelity] = []
    for agent, (policy, seen) in enumerate(zip(profile.agents, observations, strict=True)):
        mine, asked = alive[:, agent], wanted[alive[:, agent], agent]
        leaf = ir.apply(policy.tree, seen[mine])
        right = policy.tree.action[leaf] == asked
        by_action = _count_right(asked, right, np.arange(len(policy.actions)))
        names = [action.name for action in policy.actions]
        whole = Counted(int(right.sum()), len(right))
        by_name = dict(zip(names, by_action.values(), strict=True))
        by_agent.append(Fidelity(policy.agent, whole, by_name, _count_right(leaf, right, ir.leaves(policy.tree))))
    return tuple(by_agent)


def _count_right(kind: Int, right: ir.Bool, kinds: Int) -> dict[int, Counted]:
    return {int(each): Counted(int(right[kind == each].sum()), int((kind == each).sum())) for each in kinds}
