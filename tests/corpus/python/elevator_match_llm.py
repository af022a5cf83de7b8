"""Elevator dispatch with structural pattern matching (Python 3.10+)."""
from enum import Enum


class Direction(Enum):
    UP = "up"
    DOWN = "down"
    STOP = "stop"


DOOR_OPEN = 1


def elevator(door: int, calls_above: int, calls_below: int, load_kg: float) -> Direction:
    """Returns the direction of travel."""
    match door:
        case 1 | 2:
            return Direction.STOP
        case 0:
            pass
        case _:
            return Direction.STOP
    if load_kg > 8 * 75:
        return Direction.STOP
    if calls_above > 0:
        return Direction.UP
    if calls_below > 0:
        return Direction.DOWN
    return Direction.STOP
