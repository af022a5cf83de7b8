import numpy as np
W = np.array([0.0, 1.0, 0.0, 0.0])
LIMITS = np.linspace(-1, 1, 5)
def act(obs):
    k = sum(obs[1] > l for l in LIMITS)
    if k <= 1: return 0
    if k == 2: return 1
    return 2
