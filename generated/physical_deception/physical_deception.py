"""Decision tree policies of 3 agents for the world physical-deception. Generated: do not edit.

profile     a27715e718578d546237e99100a168586463d44b95b222d117df233b9ef66d68
made by     maviper 0.1.0, maviper, preset paper, seed 0

For each agent A: act_A(x) takes one observation (a sequence of floats) and returns the action's number;
act_A_batch(x) takes an array [batch, n_features] and returns an array of actions (needs numpy).

A split goes left iff x[feature] <= threshold. Observations are float32; each threshold is written as the largest
double that rounds to a float32 not above it, so doubles decide as if they had been rounded to float32 first.
NaN compares false and so goes right; infinities follow <=.
"""

PROFILE = "a27715e718578d546237e99100a168586463d44b95b222d117df233b9ef66d68"
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


def act_adversary_0(x):
    """adversary_0, team adversaries: 16 leaves, at most 4 comparisons."""
    if x[5] <= 0.347627505660057:  # node 0: agent_0_dy
        if x[2] <= -0.5418734848499299:  # node 1: landmark_1_dx
            if x[7] <= -0.7244364321231843:  # node 2: agent_1_dy
                if x[0] <= -0.24700094014406207:  # node 3: landmark_0_dx
                    return 1  # left, leaf 4
                else:
                    return 3  # down, leaf 5
            else:
                if x[3] <= 1.0911838412284849:  # node 6: landmark_1_dy
                    return 1  # left, leaf 7
                else:
                    return 4  # up, leaf 8
        else:
            if x[3] <= -0.3948282450437546:  # node 9: landmark_1_dy
                if x[1] <= -0.29657624661922455:  # node 10: landmark_0_dy
                    return 3  # down, leaf 11
                else:
                    return 3  # down, leaf 12
            else:
                if x[0] <= 0.6025269329547882:  # node 13: landmark_0_dx
                    return 3  # down, leaf 14
                else:
                    return 2  # right, leaf 15
    else:
        if x[2] <= 0.7066745460033416:  # node 16: landmark_1_dx
            if x[1] <= 0.6582659780979156:  # node 17: landmark_0_dy
                if x[4] <= -0.3384156674146652:  # node 18: agent_0_dx
                    return 1  # left, leaf 19
                else:
                    return 4  # up, leaf 20
            else:
                if x[0] <= -1.1415160298347475:  # node 21: landmark_0_dx
                    return 1  # left, leaf 22
                else:
                    return 4  # up, leaf 23
        else:
            if x[1] <= 0.9286297261714934:  # node 24: landmark_0_dy
                if x[5] <= 0.3548449128866195:  # node 25: agent_0_dy
                    return 4  # up, leaf 26
                else:
                    return 2  # right, leaf 27
            else:
                if x[6] <= 0.7097196280956267:  # node 28: agent_1_dx
                    return 4  # up, leaf 29
                else:
                    return 2  # right, leaf 30


def act_adversary_0_batch(x):
    """As act_adversary_0, for the rows of an array."""
    import numpy as np

    x = np.asarray(x, dtype=np.float32)
    n30 = 2
    n29 = 4
    n28 = np.where(x[:, 6] <= 0.7097196280956267, n29, n30)
    n27 = 2
    n26 = 4
    n25 = np.where(x[:, 5] <= 0.3548449128866195, n26, n27)
    n24 = np.where(x[:, 1] <= 0.9286297261714934, n25, n28)
    n23 = 4
    n22 = 1
    n21 = np.where(x[:, 0] <= -1.1415160298347475, n22, n23)
    n20 = 4
    n19 = 1
    n18 = np.where(x[:, 4] <= -0.3384156674146652, n19, n20)
    n17 = np.where(x[:, 1] <= 0.6582659780979156, n18, n21)
    n16 = np.where(x[:, 2] <= 0.7066745460033416, n17, n24)
    n15 = 2
    n14 = 3
    n13 = np.where(x[:, 0] <= 0.6025269329547882, n14, n15)
    n12 = 3
    n11 = 3
    n10 = np.where(x[:, 1] <= -0.29657624661922455, n11, n12)
    n9 = np.where(x[:, 3] <= -0.3948282450437546, n10, n13)
    n8 = 4
    n7 = 1
    n6 = np.where(x[:, 3] <= 1.0911838412284849, n7, n8)
    n5 = 3
    n4 = 1
    n3 = np.where(x[:, 0] <= -0.24700094014406207, n4, n5)
    n2 = np.where(x[:, 7] <= -0.7244364321231843, n3, n6)
    n1 = np.where(x[:, 2] <= -0.5418734848499299, n2, n9)
    n0 = np.where(x[:, 5] <= 0.347627505660057, n1, n16)
    return n0


def act_agent_0(x):
    """agent_0, team defenders: 16 leaves, at most 4 comparisons."""
    if x[3] <= -0.041270280256867416:  # node 0: landmark_0_dy
        if x[2] <= 0.23354706913232803:  # node 1: landmark_0_dx
            if x[2] <= -0.2377249971032143:  # node 2: landmark_0_dx
                if x[3] <= -0.4284727722406388:  # node 3: landmark_0_dy
                    return 3  # down, leaf 4
                else:
                    return 1  # left, leaf 5
            else:
                if x[3] <= -0.14365974813699725:  # node 6: landmark_0_dy
                    return 3  # down, leaf 7
                else:
                    return 3  # down, leaf 8
        else:
            if x[2] <= 0.6058479249477385:  # node 9: landmark_0_dx
                if x[3] <= -0.29289428889751434:  # node 10: landmark_0_dy
                    return 3  # down, leaf 11
                else:
                    return 2  # right, leaf 12
            else:
                if x[1] <= -1.2115059494972231:  # node 13: goal_dy
                    return 3  # down, leaf 14
                else:
                    return 2  # right, leaf 15
    else:
        if x[2] <= 0.19715517014265058:  # node 16: landmark_0_dx
            if x[2] <= -0.1920713409781456:  # node 17: landmark_0_dx
                if x[3] <= 0.673727422952652:  # node 18: landmark_0_dy
                    return 1  # left, leaf 19
                else:
                    return 4  # up, leaf 20
            else:
                if x[3] <= 0.08864563331007956:  # node 21: landmark_0_dy
                    return 4  # up, leaf 22
                else:
                    return 4  # up, leaf 23
        else:
            if x[3] <= 0.24619989842176435:  # node 24: landmark_0_dy
                if x[2] <= 0.28336818516254425:  # node 25: landmark_0_dx
                    return 2  # right, leaf 26
                else:
                    return 2  # right, leaf 27
            else:
                if x[2] <= 0.6324959695339202:  # node 28: landmark_0_dx
                    return 4  # up, leaf 29
                else:
                    return 2  # right, leaf 30


def act_agent_0_batch(x):
    """As act_agent_0, for the rows of an array."""
    import numpy as np

    x = np.asarray(x, dtype=np.float32)
    n30 = 2
    n29 = 4
    n28 = np.where(x[:, 2] <= 0.6324959695339202, n29, n30)
    n27 = 2
    n26 = 2
    n25 = np.where(x[:, 2] <= 0.28336818516254425, n26, n27)
    n24 = np.where(x[:, 3] <= 0.24619989842176435, n25, n28)
    n23 = 4
    n22 = 4
    n21 = np.where(x[:, 3] <= 0.08864563331007956, n22, n23)
    n20 = 4
    n19 = 1
    n18 = np.where(x[:, 3] <= 0.673727422952652, n19, n20)
    n17 = np.where(x[:, 2] <= -0.1920713409781456, n18, n21)
    n16 = np.where(x[:, 2] <= 0.19715517014265058, n17, n24)
    n15 = 2
    n14 = 3
    n13 = np.where(x[:, 1] <= -1.2115059494972231, n14, n15)
    n12 = 2
    n11 = 3
    n10 = np.where(x[:, 3] <= -0.29289428889751434, n11, n12)
    n9 = np.where(x[:, 2] <= 0.6058479249477385, n10, n13)
    n8 = 3
    n7 = 3
    n6 = np.where(x[:, 3] <= -0.14365974813699725, n7, n8)
    n5 = 1
    n4 = 3
    n3 = np.where(x[:, 3] <= -0.4284727722406388, n4, n5)
    n2 = np.where(x[:, 2] <= -0.2377249971032143, n3, n6)
    n1 = np.where(x[:, 2] <= 0.23354706913232803, n2, n9)
    n0 = np.where(x[:, 3] <= -0.041270280256867416, n1, n16)
    return n0


def act_agent_1(x):
    """agent_1, team defenders: 16 leaves, at most 4 comparisons."""
    if x[4] <= -0.11662099137902261:  # node 0: landmark_1_dx
        if x[5] <= 0.15174195915460587:  # node 1: landmark_1_dy
            if x[5] <= -0.2054029032588005:  # node 2: landmark_1_dy
                if x[4] <= -0.3611528128385544:  # node 3: landmark_1_dx
                    return 1  # left, leaf 4
                else:
                    return 3  # down, leaf 5
            else:
                if x[6] <= 0.09102208539843558:  # node 6: adversary_0_dx
                    return 1  # left, leaf 7
                else:
                    return 1  # left, leaf 8
        else:
            if x[4] <= -0.3809807151556015:  # node 9: landmark_1_dx
                if x[5] <= 0.5454911291599274:  # node 10: landmark_1_dy
                    return 1  # left, leaf 11
                else:
                    return 4  # up, leaf 12
            else:
                if x[5] <= 0.2700473219156265:  # node 13: landmark_1_dy
                    return 4  # up, leaf 14
                else:
                    return 4  # up, leaf 15
    else:
        if x[5] <= 0.07712522521615028:  # node 16: landmark_1_dy
            if x[4] <= 0.1282873675227165:  # node 17: landmark_1_dx
                if x[5] <= -0.10013530775904655:  # node 18: landmark_1_dy
                    return 3  # down, leaf 19
                else:
                    return 2  # right, leaf 20
            else:
                if x[5] <= -0.22547515481710434:  # node 21: landmark_1_dy
                    return 2  # right, leaf 22
                else:
                    return 2  # right, leaf 23
        else:
            if x[4] <= 0.1790565326809883:  # node 24: landmark_1_dx
                if x[0] <= -1.5052064061164858:  # node 25: goal_dx
                    return 2  # right, leaf 26
                else:
                    return 4  # up, leaf 27
            else:
                if x[5] <= 0.6316647827625275:  # node 28: landmark_1_dy
                    return 2  # right, leaf 29
                else:
                    return 4  # up, leaf 30


def act_agent_1_batch(x):
    """As act_agent_1, for the rows of an array."""
    import numpy as np

    x = np.asarray(x, dtype=np.float32)
    n30 = 4
    n29 = 2
    n28 = np.where(x[:, 5] <= 0.6316647827625275, n29, n30)
    n27 = 4
    n26 = 2
    n25 = np.where(x[:, 0] <= -1.5052064061164858, n26, n27)
    n24 = np.where(x[:, 4] <= 0.1790565326809883, n25, n28)
    n23 = 2
    n22 = 2
    n21 = np.where(x[:, 5] <= -0.22547515481710434, n22, n23)
    n20 = 2
    n19 = 3
    n18 = np.where(x[:, 5] <= -0.10013530775904655, n19, n20)
    n17 = np.where(x[:, 4] <= 0.1282873675227165, n18, n21)
    n16 = np.where(x[:, 5] <= 0.07712522521615028, n17, n24)
    n15 = 4
    n14 = 4
    n13 = np.where(x[:, 5] <= 0.2700473219156265, n14, n15)
    n12 = 4
    n11 = 1
    n10 = np.where(x[:, 5] <= 0.5454911291599274, n11, n12)
    n9 = np.where(x[:, 4] <= -0.3809807151556015, n10, n13)
    n8 = 1
    n7 = 1
    n6 = np.where(x[:, 6] <= 0.09102208539843558, n7, n8)
    n5 = 3
    n4 = 1
    n3 = np.where(x[:, 4] <= -0.3611528128385544, n4, n5)
    n2 = np.where(x[:, 5] <= -0.2054029032588005, n3, n6)
    n1 = np.where(x[:, 5] <= 0.15174195915460587, n2, n9)
    n0 = np.where(x[:, 4] <= -0.11662099137902261, n1, n16)
    return n0


ACT = {
    "adversary_0": act_adversary_0,
    "agent_0": act_agent_0,
    "agent_1": act_agent_1,
}
