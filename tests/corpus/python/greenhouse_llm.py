#!/usr/bin/env python3
"""Rule-based greenhouse controller."""

from __future__ import annotations

import logging
from typing import Dict

logger = logging.getLogger(__name__)

TEMP_MIN = 18.0
TEMP_MAX = 28.0
HUMIDITY_MAX = 80.0
SOIL_DRY = 30.0


def greenhouse_policy(observation: Dict[str, float]) -> str:
    """Choose an actuator command from sensor readings.

    Parameters
    ----------
    observation : dict
        Keys ``temperature`` (deg C), ``humidity`` (%) and ``soil`` (%).

    Returns
    -------
    str
        ``"heat"``, ``"vent"``, ``"water"`` or ``"idle"``.
    """
    temperature = observation["temperature"]
    humidity = observation["humidity"]
    soil = observation["soil"]

    if temperature < TEMP_MIN:
        logger.debug("too cold: %s", temperature)
        return "heat"
    elif temperature > TEMP_MAX or humidity > HUMIDITY_MAX:
        logger.debug("too warm or too humid")
        return "vent"
    elif soil < SOIL_DRY:
        return "water"
    else:
        return "idle"


def main() -> None:
    """Run a short demonstration."""
    samples = [
        {"temperature": 15.0, "humidity": 60.0, "soil": 50.0},
        {"temperature": 30.0, "humidity": 60.0, "soil": 50.0},
        {"temperature": 22.0, "humidity": 60.0, "soil": 20.0},
    ]
    for sample in samples:
        print(sample, "->", greenhouse_policy(sample))


if __name__ == "__main__":
    main()
