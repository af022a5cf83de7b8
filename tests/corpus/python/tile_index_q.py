"""Greedy policy of a tabular agent: two features are binned, the bins are one index."""
Q_GREEDY = [0, 0, 1, 1, 1, 2, 2, 2]


def to_bin(value, low, high, n):
    value = max(low, min(high, value))
    return min(int((value - low) / (high - low) * n), n - 1)


def act(obs):
    position = to_bin(obs[0], -1.2, 0.6, 4)
    velocity = to_bin(obs[1], -0.07, 0.07, 2)
    return Q_GREEDY[position * 2 + velocity]
