"""Greenhouse vent controller.

Deployed 2023-04; thresholds tuned by hand with the growers.
"""
from __future__ import annotations

import logging
from dataclasses import dataclass, field
from enum import IntEnum

log = logging.getLogger(__name__)


class Vent(IntEnum):
    CLOSED = 0
    CRACKED = 1
    HALF = 2
    OPEN = 3


@dataclass(frozen=True)
class Limits:
    too_hot: float = 31.5
    warm: float = 26.0
    cold: float = 12.0
    humid: float = 0.85
    storm: float = 14.0
    hysteresis: float = 0.5


@dataclass(frozen=True)
class Config:
    limits: Limits = field(default_factory=Limits)
    night_bias: float = -1.5

    def shifted(self, threshold: float, night: bool) -> float:
        return threshold + (self.night_bias if night else 0.0)


CONFIG = Config()


def vent(temp_c: float, humidity: float, wind_ms: float, is_night: float) -> Vent:
    """Choose the vent position."""
    lim = CONFIG.limits
    night = is_night > 0.5

    def hot() -> bool:
        return temp_c >= CONFIG.shifted(lim.too_hot, night)

    def warm() -> bool:
        return temp_c >= CONFIG.shifted(lim.warm, night) - lim.hysteresis

    if wind_ms > lim.storm:
        return Vent.CLOSED
    match (hot(), warm(), humidity > lim.humid):
        case (True, _, _):
            return Vent.OPEN
        case (False, True, True):
            return Vent.OPEN
        case (False, True, False):
            return Vent.HALF
        case (False, False, True) if temp_c > lim.cold:
            return Vent.CRACKED
        case _:
            return Vent.CLOSED
