def agent_left(obs):
    return 0 if obs[0] <= 1e-3 else (1 if not obs[1] < -1e-3 else 2)
def agent_right(obs):
    return {True: 0, False: 1}[obs[0] > 0]
