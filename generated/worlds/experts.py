"""Experts for the worlds of this folder: controllers in a few lines each, by what agents observe.

Does: one function for each world; `maviper extract experts:quadrotor` imports it.
Assumes: the current folder is this one.
Does not: learn. They are scripts, so that everybody sees what the trees are extracted from.
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


def quadrotor() -> Script:
    """Along each axis it pushes against where it will be in 1.5 s."""
    axes = (("to_x", 4), ("to_y", 2), ("to_z", 1))
    return _script("quadrotor", drone=lambda of: sum((of[name] <= 0) * weight for name, weight in axes))


def pendulum() -> Script:
    """It pushes to the side to which the pole will lean, and not at all where that is small."""
    return _script("pendulum", cart=lambda of: 1 + (of["lean"] > 0.01).astype(int) - (of["lean"] < -0.01))


def mountain_car() -> Script:
    """It accelerates the way it goes."""
    return _script("mountain_car", agent=lambda of: 2 * (of["velocity"] >= 0).astype(int))


def cart_pole() -> Script:
    """It pushes to the side to which the pole will lean in half a second."""
    return _script("cart_pole", agent=lambda of: (of["pole_angle"] + of["pole_angular_velocity"] / 2 > 0).astype(int))


def corridor() -> Script:
    """The left one always goes. The right one waits before the corridor until the other is through."""
    far, through = 1.5, 1.1
    return _script(
        "corridor",
        left=lambda of: np.ones(len(of["own"]), dtype=int),
        right=lambda of: ((of["own"] > far) | (of["other"] > through)).astype(int),
    )


def crossing() -> Script:
    """The longer queue has green."""
    return _script("crossing", light=lambda of: (of["longer"] <= 0).astype(int))


def tanks() -> Script:
    """It opens the valve where the lower tank will be low."""
    return _script("tanks", valve=lambda of: (of["lower"] + (of["upper"] - 0.5) / 2 < 0.6).astype(int))


def pendulum_v1() -> Script:
    """It pushes against where the pole will be in 0.3 s, and not at all where that is small."""
    return _script("pendulum_v1", agent=lambda of: 1 - (of["ahead"] > 0.02).astype(int) + (of["ahead"] < -0.02))


def pendulum_v1_environment() -> Any:
    """Gymnasium's Pendulum-v1 with one of three torques, which `pendulum_v1.toml` states."""
    import gymnasium

    torques = np.array([[-2.0], [0.0], [2.0]], dtype=np.float32)
    env = gymnasium.make("Pendulum-v1")
    return gymnasium.wrappers.TransformAction(env, lambda action: torques[action], gymnasium.spaces.Discrete(3))


def _script(name: str, **rules: Rule) -> Script:
    return Script(find(f"system:{name}.toml"), rules)
