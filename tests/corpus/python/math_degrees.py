import math
def act(obs):
    a = math.degrees(obs[2])
    if abs(a) < 3: return 1
    return 0 if a < 0 else 2
