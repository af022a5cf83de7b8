"""Lunar-lander-like fuel saver. Written by a hobbyist."""
import numpy as np
from enum import IntEnum

class Act(IntEnum):
    COAST = 0
    BURN = 1

SAFE_SPEED = -0.5
class Pilot:
    SAFE_ALT = 10

    def __init__(self, margin=1.5):
        self.margin = margin

    @property
    def limit(self):
        return self.SAFE_ALT * self.margin

    def decide(self, obs):
        alt, speed = obs[0], obs[1]
        if alt > self.limit:
            return Act.COAST
        return Act.BURN if speed < SAFE_SPEED else Act.COAST
