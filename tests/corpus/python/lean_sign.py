import math
import random

DEADBAND = math.radians(1.5)
ACTIONS = ("left", "none", "right")
LEFT, NONE, RIGHT = range(len(ACTIONS))
GAINS = dict(angle=1.0)


def sign(v, eps=1e-3):
    return (v > eps) - (v < -eps)


def policy(state):
    x, x_dot, theta, theta_dot = state
    if abs(x) > 2.0:
        return LEFT if x > 0 else RIGHT
    lean = sign(GAINS["angle"] * theta, DEADBAND)
    if lean == 0:
        return (NONE, RIGHT, LEFT)[sign(theta_dot)]
    return {1: RIGHT, -1: LEFT}[lean]


if __name__ == "__main__":
    random.seed(0)
    print(policy([random.random() for _ in range(4)]))
