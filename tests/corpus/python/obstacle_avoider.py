"""Reactive obstacle avoidance for a differential-drive robot with three sonars."""
from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, auto


class Action(Enum):
    FORWARD = auto()
    TURN_LEFT = auto()
    TURN_RIGHT = auto()
    REVERSE = auto()


@dataclass(frozen=True)
class Thresholds:
    stop: float = 0.25
    caution: float = 0.6
    side: float = 0.35


LIMITS = Thresholds(side=0.4)


def decide(front: float, left: float, right: float) -> Action:
    """Return the next motion primitive.

    Args:
        front: distance ahead in metres.
        left: distance to the left in metres.
        right: distance to the right in metres.
    """
    if front < LIMITS.stop:
        return Action.REVERSE
    if front < LIMITS.caution:
        blocked_left = left < LIMITS.side
        return Action.TURN_RIGHT if blocked_left else Action.TURN_LEFT
    if left < LIMITS.side:
        return Action.TURN_RIGHT
    if right < LIMITS.side:
        return Action.TURN_LEFT
    return Action.FORWARD
