"""Failsafe arbitration in the spirit of a flight controller: the most severe action wins."""

from enum import IntEnum
from typing import NamedTuple


class FailsafeAction(IntEnum):
    NONE = 0
    WARN = 1
    HOLD = 2
    RTL = 3
    LAND = 4
    TERMINATE = 5


class Params(NamedTuple):
    COM_LOW_BAT_ACT: float = 0.20
    COM_CRIT_BAT: float = 0.10
    COM_EMERG_BAT: float = 0.05
    GF_MAX_HOR_DIST: float = 500.0
    FD_FAIL_R: float = 60.0


PARAMS = Params()


def failsafe(battery, rc_loss_s, home_distance, roll_deg, gps_ok):
    action = FailsafeAction.NONE

    if battery < PARAMS.COM_EMERG_BAT:
        action = max(action, FailsafeAction.LAND)
    elif battery < PARAMS.COM_CRIT_BAT:
        action = max(action, FailsafeAction.RTL)
    elif battery < PARAMS.COM_LOW_BAT_ACT:
        action = max(action, FailsafeAction.WARN)

    if rc_loss_s > 0.5:
        action = max(action, FailsafeAction.RTL if gps_ok else FailsafeAction.LAND)

    if home_distance > PARAMS.GF_MAX_HOR_DIST:
        action = max(action, FailsafeAction.HOLD)

    if abs(roll_deg) > PARAMS.FD_FAIL_R:
        action = FailsafeAction.TERMINATE

    return action
