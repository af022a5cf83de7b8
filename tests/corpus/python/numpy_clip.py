import numpy as np
from numpy import pi


def controller(obs: np.ndarray) -> int:
    """Bang-bang control of a satellite's attitude with a dead zone."""
    angle = np.clip(obs[0], -pi, pi)
    rate = obs[1]
    if angle > 0.05 and rate > -0.01:
        return 0
    if angle < -0.05 and rate < 0.01:
        return 2
    return 1
