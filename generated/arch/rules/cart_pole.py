"""Balances by gains of a linear-quadratic regulator, and where the pole leans far catches it first."""


def cart(obs):
    x1, x2, x3, x4 = obs
    if x3 > 0.4:
        return "catch"
    return "catch" if x3 <= -0.4 else "balance"
