"""
Traffic Light Controller
========================

This module implements a simple rule-based traffic light controller.
The controller decides whether to keep the current phase, switch it or
extend it, based on the queue lengths of both roads and the phase timer.
"""

from typing import Final

# Configuration constants
MIN_GREEN_TIME: Final[float] = 10.0  # seconds
MAX_GREEN_TIME: Final[float] = 60.0  # seconds
QUEUE_THRESHOLD: Final[int] = 5      # vehicles

# Actions
KEEP: Final[str] = "keep"
SWITCH: Final[str] = "switch"
EXTEND: Final[str] = "extend"


def traffic_light_controller(
    time_in_phase: float,
    queue_main: int,
    queue_side: int,
) -> str:
    """
    Decide what the traffic light should do next.

    Args:
        time_in_phase (float): Seconds since the last phase change.
        queue_main (int): Number of vehicles waiting on the main road.
        queue_side (int): Number of vehicles waiting on the side road.

    Returns:
        str: One of "keep", "switch" or "extend".

    Example:
        >>> traffic_light_controller(5.0, 3, 10)
        'keep'
    """
    # Never switch before the minimum green time has elapsed
    if time_in_phase < MIN_GREEN_TIME:
        return KEEP

    # Always switch once the maximum green time is reached
    if time_in_phase >= MAX_GREEN_TIME:
        return SWITCH

    # Switch if the side road is busy while the main road is quiet
    if queue_side > QUEUE_THRESHOLD and queue_main <= QUEUE_THRESHOLD:
        return SWITCH

    # Extend green if the main road is still busy
    if queue_main > QUEUE_THRESHOLD:
        return EXTEND

    return KEEP


if __name__ == "__main__":
    test_cases = [(5.0, 3, 10), (30.0, 2, 8), (70.0, 9, 1)]
    for case in test_cases:
        print(f"{case} -> {traffic_light_controller(*case)}")
