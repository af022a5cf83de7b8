from dataclasses import dataclass
from enum import IntEnum


class Cmd(IntEnum):
    OPEN = 0
    CLOSE = 1
    HOLD = 2


@dataclass
class GripperState:
    force: float
    width: float
    slip: float


MAX_FORCE_N = 12.5
MIN_WIDTH_MM = 4.0


def command(state: GripperState) -> Cmd:
    if state.force >= MAX_FORCE_N:
        return Cmd.OPEN
    if state.slip > 0.02 and state.width > MIN_WIDTH_MM:
        return Cmd.CLOSE
    return Cmd.HOLD
