# capture the flag bot, tick() is called by the engine with a dict of observations

ACTIONS = {
    "attack": 3,
    "defend": 2,
    "grab": 1,
    "idle": 0,
}


def near(d):
    return d < 4


def far(d):
    return d > 20.5


def tick(obs):
    enemy_dist = obs["enemy_dist"]
    flag_dist = obs["flag_dist"]
    if near(enemy_dist) and obs["hp"] >= 50:
        return ACTIONS["attack"]
    if near(flag_dist) and not near(enemy_dist):
        return ACTIONS["grab"]
    if far(enemy_dist) and far(flag_dist):
        return ACTIONS["idle"]
    return ACTIONS["defend"]
