"""Controllers of the plants in this folder, in a few lines each, by what agents observe.

Does: one function for each plant; `maviper extract experts:pendulum` imports it.
Assumes: the current folder is this one.
Does not: learn. A rule's wish is rounded to the nearest action, so that everybody sees what the trees come from.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from maviper.worlds import World, find

Numbers = npt.NDArray[np.float32]  # [batch]
Ints = npt.NDArray[np.integer[Any]]
Rule = Callable[[Mapping[str, Numbers]], Ints]  # features by name -> the number of an action, [batch]


@dataclass(frozen=True)
class Script:
    """An expert of a rule for each agent."""

    world: World
    rules: Mapping[str, Rule]
    hash: str = ""

    @property
    def agents(self) -> tuple[str, ...]:
        """The world's agents."""
        return self.world.agents

    @property
    def card(self) -> Mapping[str, Any]:
        """What it is."""
        return {"algorithm": "scripted", "world": self.world.name}

    @property
    def centralized(self) -> bool:
        """Every agent acts by what it observes itself."""
        return False

    def act(self, agents: Sequence[int], observations: Sequence[Numbers], state: Any) -> Ints:
        """The actions of some agents, [batch, len(agents)]."""
        del state
        return np.stack([self._act(agent, observations[agent]) for agent in agents], axis=1)

    def _act(self, agent: int, seen: Numbers) -> Ints:
        names = [feature.name for feature in self.world.features[agent]]
        return self.rules[self.agents[agent]](dict(zip(names, seen.T, strict=True)))

    def q(self, agent: int, observations: Sequence[Numbers], state: Any, joint: Ints, given: Ints) -> Numbers:
        """A script has no critic."""
        raise NotImplementedError("extract with --critic none")


def _nearest(values: Sequence[float], wanted: Numbers) -> Ints:
    """The number of the value that is nearest to each wish."""
    return np.argmin(np.abs(np.asarray(values)[None] - wanted[:, None]), axis=1)


def pendulum() -> Script:
    """Cancels gravity, and draws the angle to 0.5 rad."""

    def rule(seen: Mapping[str, Numbers]) -> Ints:
        wish = (-2 * np.sin(seen["angle"]) - 12 * (seen["angle"] - 0.5) - 6 * seen["spin"]) / 8
        return _nearest([-1, -0.5, 0, 0.5, 1], wish)

    return Script(find("system:pendulum.toml"), {"motor": rule})


def nav() -> Script:
    """Backs to the left above the square, turns by a quarter beyond it, and backs down to the origin."""

    def rule(seen: Mapping[str, Numbers]) -> Ints:
        x, y, speed, heading = seen["x1"], seen["x2"], seen["x3"], seen["x4"]
        turning = (x <= 1.75) & (heading < 1.5)
        wish = np.where(heading < 1.2, -1.6, -np.sqrt(np.maximum(0, 1.6 * np.maximum(y - 0.1, 0))))
        pace = np.where(speed > wish + 0.11, 1, np.where(speed < wish - 0.11, 2, 0))
        return pace + 3 * turning

    return Script(find("system:nav.toml"), {"car": rule})


def acc() -> Script:
    """Brakes by how fast the gap closes and how little of it is left."""

    def rule(seen: Mapping[str, Numbers]) -> Ints:
        wish = -1.0 * np.maximum(seen["closing"], -2) + 0.2 * (seen["room"] - 14)
        return _nearest([-3, -1, 0, 1], wish)

    return Script(find("system:acc.toml"), {"driver": rule})


def docking() -> Script:
    """Brakes along each axis."""

    def along(seen: Mapping[str, Numbers]) -> Ints:
        return _nearest([-1, 0, 1], -12 * seen["x3"])

    def across(seen: Mapping[str, Numbers]) -> Ints:
        return _nearest([-1, 0, 1], -12 * seen["x4"])

    return Script(find("system:docking.toml"), {"along": along, "across": across})


def tora_reach() -> Script:
    """Sets the arm turning by 1 rad/s."""

    def arm(seen: Mapping[str, Numbers]) -> Ints:
        return np.where(seen["x4"] > -0.9, 0, 1)

    return Script(find("system:tora_reach.toml"), {"arm": arm})
