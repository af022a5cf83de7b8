"""Decision tree policies of 3 agents for the world physical-deception. Generated: do not edit.

profile     d7c7e9951b353c845e3729dfb7383e9f94192c6dfd621196d4fd4879d989808d
made by     tests, hand-made, preset none, seed 0

For each agent A: act_A(x) takes one observation (a sequence of floats, or of numpy's float64 or float32, not float16) and returns the action's number;
act_A_batch(x) takes an array [batch, n_features] and returns an array of actions (needs numpy).

A split goes left iff x[feature] <= threshold. Observations are float32; each threshold is written as the largest
double that rounds to a float32 not above it, so doubles decide as if they had been rounded to float32 first.
NaN compares false and so goes right; infinities follow <=.
"""

PROFILE = "d7c7e9951b353c845e3729dfb7383e9f94192c6dfd621196d4fd4879d989808d"
AGENTS = ("adversary_0", "agent_0", "agent_1",)
FEATURES = {
    "adversary_0": ("landmark_0_dx", "landmark_0_dy", "landmark_1_dx", "landmark_1_dy", "agent_0_dx", "agent_0_dy", "agent_1_dx", "agent_1_dy",),
    "agent_0": ("goal_dx", "goal_dy", "landmark_0_dx", "landmark_0_dy", "landmark_1_dx", "landmark_1_dy", "adversary_0_dx", "adversary_0_dy", "agent_1_dx", "agent_1_dy",),
    "agent_1": ("goal_dx", "goal_dy", "landmark_0_dx", "landmark_0_dy", "landmark_1_dx", "landmark_1_dy", "adversary_0_dx", "adversary_0_dy", "agent_0_dx", "agent_0_dy",),
}
ACTIONS = {
    "adversary_0": ("stay", "left", "right", "down", "up",),
    "agent_0": ("stay", "left", "right", "down", "up",),
    "agent_1": ("stay", "left", "right", "down", "up",),
}


def _choose(test, left, right):
    """`left` where the test holds, else `right`; both are actions or arrays of them."""
    actions = test.view("uint8")  # 1 or 0
    actions *= left ^ right  # the bits in which they differ
    actions ^= right
    return actions


def act_adversary_0(x):
    """adversary_0, team adversaries: 1 leaves, at most 0 comparisons."""
    return 0  # stay, leaf 0


def act_adversary_0_batch(x):
    """As act_adversary_0, for the rows of an array."""
    import numpy as np

    x = np.asarray(x, dtype=np.float32)
    return np.full(len(x), 0)


def act_agent_0(x):
    """agent_0, team defenders: 5 leaves, at most 3 comparisons."""
    if x[0] <= 0.09999999776482582:  # node 0: goal_dx
        if x[3] <= 7.006492321624085e-46:  # node 1: landmark_0_dy
            return 1  # left, leaf 2
        else:
            return 2  # right, leaf 3
    else:
        if x[9] <= -0.33333332836627966:  # node 4: agent_1_dy
            return 4  # up, leaf 5
        else:
            if x[2] <= 3.4028235677973362e+38:  # node 6: landmark_0_dx
                return 0  # stay, leaf 7
            else:
                return 0  # stay, leaf 8


def act_agent_0_batch(x):
    """As act_agent_0, for the rows of an array."""
    import numpy as np

    x = np.asarray(x, dtype=np.float32)
    actions = np.empty(len(x), dtype=np.int64)
    for start in range(0, len(x), 65536):  # so many that calls cost little, so few that caches hold them
        rows = x[start : start + 65536]
        x0 = rows[:, 0]
        x2 = rows[:, 2]
        x3 = rows[:, 3]
        x9 = rows[:, 9]
        actions[start : start + 65536] = _choose(
            x0 <= 0.09999999776482582,  # node 0: goal_dx
            _choose(
                x3 <= 7.006492321624085e-46,  # node 1: landmark_0_dy
                1,  # left, leaf 2
                2,  # right, leaf 3
            ),
            _choose(
                x9 <= -0.33333332836627966,  # node 4: agent_1_dy
                4,  # up, leaf 5
                _choose(
                    x2 <= 3.4028235677973362e+38,  # node 6: landmark_0_dx
                    0,  # stay, leaf 7
                    0,  # stay, leaf 8
                ),
            ),
        )
    return actions


def act_agent_1(x):
    """agent_1, team defenders: 4 leaves, at most 3 comparisons."""
    if x[4] <= -0.04999999888241292:  # node 0: landmark_1_dx
        return 1  # left, leaf 1
    else:
        if x[4] <= 0.0500000026077032:  # node 2: landmark_1_dx
            if x[5] <= 7.006492321624085e-46:  # node 3: landmark_1_dy
                return 3  # down, leaf 4
            else:
                return 4  # up, leaf 5
        else:
            return 2  # right, leaf 6


def act_agent_1_batch(x):
    """As act_agent_1, for the rows of an array."""
    import numpy as np

    x = np.asarray(x, dtype=np.float32)
    actions = np.empty(len(x), dtype=np.int64)
    for start in range(0, len(x), 65536):  # so many that calls cost little, so few that caches hold them
        rows = x[start : start + 65536]
        x4 = rows[:, 4].copy()
        x5 = rows[:, 5]
        actions[start : start + 65536] = _choose(
            x4 <= -0.04999999888241292,  # node 0: landmark_1_dx
            1,  # left, leaf 1
            _choose(
                x4 <= 0.0500000026077032,  # node 2: landmark_1_dx
                _choose(
                    x5 <= 7.006492321624085e-46,  # node 3: landmark_1_dy
                    3,  # down, leaf 4
                    4,  # up, leaf 5
                ),
                2,  # right, leaf 6
            ),
        )
    return actions


ACT = {
    "adversary_0": act_adversary_0,
    "agent_0": act_agent_0,
    "agent_1": act_agent_1,
}
