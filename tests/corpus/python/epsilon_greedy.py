import random

EPSILON = 0.05


def agent(obs):
    if random.random() < EPSILON:
        return random.randrange(2)
    return 1 if obs[2] > 0 else 0
