"""Names and units of what the classic single-agent environments show and let one do.

Does: the names for Gymnasium's own environments, as their documentation has them.
Assumes: an environment's name without its version; other lengths than the table's mean another environment.
Does not: know environments of other packages.
"""

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple


class Described(NamedTuple):
    """An environment in words: feature -> unit, in their order; actions, by their numbers; output -> unit."""

    features: Mapping[str, str]
    actions: Sequence[str]
    outputs: Mapping[str, str] = MappingProxyType({})


FLAG = "0 or 1"
LANDER: Mapping[str, str] = {
    "x": "none",
    "y": "none",
    "velocity_x": "none",
    "velocity_y": "none",
    "angle": "rad",
    "angular_velocity": "none",
    "left_leg_contact": FLAG,
    "right_leg_contact": FLAG,
}
DESCRIBED: Mapping[str, Described] = {
    "CartPole": Described(
        {
            "cart_position": "m",
            "cart_velocity": "m/s",
            "pole_angle": "rad",
            "pole_angular_velocity": "rad/s",
        },
        ("push_left", "push_right"),
    ),
    "MountainCar": Described(
        {"position": "none", "velocity": "none"}, ("accelerate_left", "coast", "accelerate_right")
    ),
    "Acrobot": Described(
        {
            "cos_angle_1": "none",
            "sin_angle_1": "none",
            "cos_angle_2": "none",
            "sin_angle_2": "none",
            "angular_velocity_1": "rad/s",
            "angular_velocity_2": "rad/s",
        },
        ("torque_minus", "no_torque", "torque_plus"),
    ),
    "LunarLander": Described(LANDER, ("nothing", "left_engine", "main_engine", "right_engine")),
    "LunarLanderContinuous": Described(LANDER, (), {"main_engine": "none", "side_engine": "none"}),
    "Pendulum": Described(
        {"cos_angle": "none", "sin_angle": "none", "angular_velocity": "rad/s"}, (), {"torque": "N m"}
    ),
    "MountainCarContinuous": Described({"position": "none", "velocity": "none"}, (), {"force": "none"}),
    "Blackjack": Described({"player_sum": "none", "dealer_card": "none", "usable_ace": FLAG}, ("stick", "hit")),
    "FrozenLake": Described({}, ("left", "down", "right", "up")),
    "CliffWalking": Described({}, ("up", "right", "down", "left")),
    "Taxi": Described({}, ("south", "north", "east", "west", "pick_up", "drop_off")),
}
