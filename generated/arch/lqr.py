"""The gains of cart_pole.toml: a linear-quadratic regulator of the upright pole, sampled with the period.

Does: linearises by hand, discretises by a matrix exponential, solves the Riccati equation, prints four gains.
Assumes: scipy.
Does not: prove.
"""

import numpy as np
from scipy.linalg import expm, solve_discrete_are

PERIOD, WEIGHTS = 0.02, (10.0, 1.0, 10.0, 1.0)


def gains() -> np.ndarray:
    """k1 to k4 of u = k1 x1 + .. + k4 x4."""
    whole = np.zeros((5, 5))
    whole[0, 1] = whole[2, 3] = 1.0
    whole[1, 4] = 2.0
    whole[3, 2:] = 0.08 * 0.41 * 9.8 / 0.0105, -0.0021 / 0.0105, -0.08 * 0.41 * 2 / 0.0105
    moved = expm(PERIOD * whole)
    a, b, cost = moved[:4, :4], moved[:4, 4:], np.eye(1)
    found = solve_discrete_are(a, b, np.diag(WEIGHTS), cost)
    return -np.linalg.solve(cost + b.T @ found @ b, b.T @ found @ a)[0]


if __name__ == "__main__":
    print(" ".join(f"{gain:.2f}" for gain in gains()))
