"""Acrobot-v1: torque against the speed of the second link, unless it hangs almost still."""
import numpy as np

COS1, SIN1, COS2, SIN2, OMEGA1, OMEGA2 = range(6)

NEGATIVE, ZERO, POSITIVE = 0, 1, 2


def act(observation: np.ndarray) -> int:
    omega2 = float(observation[OMEGA2])
    if np.abs(observation[OMEGA1]) < 0.05 and np.abs(omega2) < 0.05:
        return POSITIVE
    if observation[COS1] < -0.25 and omega2 >= 4 * np.pi / 3:
        return ZERO
    return NEGATIVE if omega2 > 0 else POSITIVE
