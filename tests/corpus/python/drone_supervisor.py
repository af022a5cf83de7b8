import numpy as np
from enum import Enum, auto


class Mode(Enum):
    HOVER = auto()
    CLIMB = auto()
    DESCEND = auto()
    LAND = auto()


STATES = {m.name.lower(): m for m in Mode}
ALT_BANDS = [(0.0, 0.3, Mode.LAND), (0.3, 1.5, Mode.CLIMB), (1.5, 3.0, Mode.HOVER)]
BATTERY_LOW = 0.18


class Supervisor:
    """Picks the flight mode from altitude [m], vertical speed [m/s], battery [0..1]."""

    MAX_SINK = -1.2

    def __init__(self, bands=None):
        self.bands = ALT_BANDS if bands is None else bands

    @staticmethod
    def _inside(value, low, high):
        return low <= value < high

    def _band(self, altitude):
        for low, high, mode in self.bands:
            if self._inside(altitude, low, high):
                return mode
        return Mode.DESCEND

    def act(self, obs):
        obs = np.asarray(obs, dtype=np.float64)
        altitude, climb, battery = obs
        if np.isnan(battery) or battery < BATTERY_LOW:
            return Mode.LAND.name
        if climb < self.MAX_SINK:
            return Mode.CLIMB.name
        mode = self._band(altitude)
        return mode.name
