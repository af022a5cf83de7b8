from functools import reduce


def clampi(v):
    return min(max(int(v), -2), 2)


def cell(obs):
    a, b = clampi(obs[0]), clampi(obs[1])
    if a * b > 2:
        return f"corner-{a - b}"
    if a == b:
        return "diagonal"
    bits = reduce(lambda code, odd: code * 2 + odd, (a % 2, b % 2), 0)
    return f"cell-{bits}-{b // 2}"
