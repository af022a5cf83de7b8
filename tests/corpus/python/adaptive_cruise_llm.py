"""Simple adaptive cruise control decision logic.

Author: generated with an assistant, reviewed by hand.
"""
from dataclasses import dataclass
from typing import List


@dataclass
class ACCConfig:
    """Tunable parameters of the controller."""

    set_speed_kmh: float = 100.0
    tolerance_kmh: float = 2.0
    min_gap_m: float = 20.0
    emergency_gap_m: float = 8.0


class AdaptiveCruiseControl:
    """Decides between braking, coasting and accelerating."""

    ACTIONS: List[str] = ["emergency_brake", "brake", "coast", "accelerate"]

    def __init__(self, config: ACCConfig = ACCConfig()) -> None:
        self.config = config

    def get_action(self, speed_mps: float, gap_m: float) -> int:
        """Return the index of the chosen action in ``ACTIONS``."""
        speed_kmh = speed_mps * 3.6

        if gap_m < self.config.emergency_gap_m:
            return self.ACTIONS.index("emergency_brake")
        if gap_m < self.config.min_gap_m:
            return self.ACTIONS.index("brake")

        if speed_kmh > self.config.set_speed_kmh + self.config.tolerance_kmh:
            return self.ACTIONS.index("coast")
        if speed_kmh < self.config.set_speed_kmh - self.config.tolerance_kmh:
            return self.ACTIONS.index("accelerate")
        return self.ACTIONS.index("coast")


if __name__ == "__main__":
    acc = AdaptiveCruiseControl()
    print(acc.ACTIONS[acc.get_action(25.0, 50.0)])
