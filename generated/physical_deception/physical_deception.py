"""Decision tree policies of 3 agents for the world physical-deception. Generated: do not edit.

profile     607fd658935566560c33a9469996b8dc45389ba5998aa41d704298d8cf8ce8ce
made by     maviper 0.1.0, maviper, preset default, seed 0

For each agent A: act_A(x) takes one observation (a sequence of floats) and returns the action's number;
act_A_batch(x) takes an array [batch, n_features] and returns an array of actions (needs numpy).

A split goes left iff x[feature] <= threshold. Observations are float32; each threshold is written as the largest
double that rounds to a float32 not above it, so doubles decide as if they had been rounded to float32 first.
NaN compares false and so goes right; infinities follow <=.
"""

PROFILE = "607fd658935566560c33a9469996b8dc45389ba5998aa41d704298d8cf8ce8ce"
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
    if x[2] <= -0.37682752311229706:  # node 0: landmark_1_dx
        if x[3] <= 0.5620309412479401:  # node 1: landmark_1_dy
            if x[7] <= -0.6752433478832245:  # node 2: agent_1_dy
                if x[0] <= -0.9941906630992889:  # node 3: landmark_0_dx
                    return 1  # left, leaf 4
                else:
                    return 3  # down, leaf 5
            else:
                if x[4] <= 0.5357297956943512:  # node 6: agent_0_dx
                    return 1  # left, leaf 7
                else:
                    return 2  # right, leaf 8
        else:
            if x[0] <= -0.7846968472003938:  # node 9: landmark_0_dx
                if x[3] <= 1.4691228270530698:  # node 10: landmark_1_dy
                    return 1  # left, leaf 11
                else:
                    return 4  # up, leaf 12
            else:
                if x[4] <= -0.5063048303127289:  # node 13: agent_0_dx
                    return 1  # left, leaf 14
                else:
                    return 4  # up, leaf 15
    else:
        if x[0] <= 0.6132849752902985:  # node 16: landmark_0_dx
            if x[7] <= -0.1796444728970528:  # node 17: agent_1_dy
                if x[5] <= 0.611995905637741:  # node 18: agent_0_dy
                    return 3  # down, leaf 19
                else:
                    return 4  # up, leaf 20
            else:
                if x[2] <= 0.7066760361194611:  # node 21: landmark_1_dx
                    return 4  # up, leaf 22
                else:
                    return 2  # right, leaf 23
        else:
            if x[1] <= 1.059776723384857:  # node 24: landmark_0_dy
                if x[1] <= -1.2552632689476013:  # node 25: landmark_0_dy
                    return 3  # down, leaf 26
                else:
                    return 2  # right, leaf 27
            else:
                if x[0] <= 1.161332905292511:  # node 28: landmark_0_dx
                    return 4  # up, leaf 29
                else:
                    return 2  # right, leaf 30


def act_adversary_0_batch(x):
    """As act_adversary_0, for the rows of an array."""
    import numpy as np

    x = np.asarray(x, dtype=np.float32)
    n30 = 2
    n29 = 4
    n28 = np.where(x[:, 0] <= 1.161332905292511, n29, n30)
    n27 = 2
    n26 = 3
    n25 = np.where(x[:, 1] <= -1.2552632689476013, n26, n27)
    n24 = np.where(x[:, 1] <= 1.059776723384857, n25, n28)
    n23 = 2
    n22 = 4
    n21 = np.where(x[:, 2] <= 0.7066760361194611, n22, n23)
    n20 = 4
    n19 = 3
    n18 = np.where(x[:, 5] <= 0.611995905637741, n19, n20)
    n17 = np.where(x[:, 7] <= -0.1796444728970528, n18, n21)
    n16 = np.where(x[:, 0] <= 0.6132849752902985, n17, n24)
    n15 = 4
    n14 = 1
    n13 = np.where(x[:, 4] <= -0.5063048303127289, n14, n15)
    n12 = 4
    n11 = 1
    n10 = np.where(x[:, 3] <= 1.4691228270530698, n11, n12)
    n9 = np.where(x[:, 0] <= -0.7846968472003938, n10, n13)
    n8 = 2
    n7 = 1
    n6 = np.where(x[:, 4] <= 0.5357297956943512, n7, n8)
    n5 = 3
    n4 = 1
    n3 = np.where(x[:, 0] <= -0.9941906630992889, n4, n5)
    n2 = np.where(x[:, 7] <= -0.6752433478832245, n3, n6)
    n1 = np.where(x[:, 3] <= 0.5620309412479401, n2, n9)
    n0 = np.where(x[:, 2] <= -0.37682752311229706, n1, n16)
    return n0


def act_agent_0(x):
    """agent_0, team defenders: 16 leaves, at most 4 comparisons."""
    if x[3] <= -0.009251977782696486:  # node 0: landmark_0_dy
        if x[2] <= 0.21981332451105118:  # node 1: landmark_0_dx
            if x[2] <= -0.17137212306261065:  # node 2: landmark_0_dx
                if x[3] <= -0.2865562587976456:  # node 3: landmark_0_dy
                    return 3  # down, leaf 4
                else:
                    return 1  # left, leaf 5
            else:
                if x[3] <= -0.08082212135195732:  # node 6: landmark_0_dy
                    return 3  # down, leaf 7
                else:
                    return 3  # down, leaf 8
        else:
            if x[3] <= -0.34070657193660736:  # node 9: landmark_0_dy
                if x[2] <= 0.9672703444957732:  # node 10: landmark_0_dx
                    return 3  # down, leaf 11
                else:
                    return 2  # right, leaf 12
            else:
                if x[8] <= -1.2054448723793032:  # node 13: agent_1_dx
                    return 3  # down, leaf 14
                else:
                    return 2  # right, leaf 15
    else:
        if x[2] <= 0.20335019379854202:  # node 16: landmark_0_dx
            if x[2] <= -0.1551302894949913:  # node 17: landmark_0_dx
                if x[3] <= 0.1773836389183998:  # node 18: landmark_0_dy
                    return 1  # left, leaf 19
                else:
                    return 4  # up, leaf 20
            else:
                if x[3] <= 0.057488327845931046:  # node 21: landmark_0_dy
                    return 4  # up, leaf 22
                else:
                    return 4  # up, leaf 23
        else:
            if x[3] <= 0.31669448316097254:  # node 24: landmark_0_dy
                if x[2] <= 0.25566630065441126:  # node 25: landmark_0_dx
                    return 2  # right, leaf 26
                else:
                    return 2  # right, leaf 27
            else:
                if x[2] <= 0.8844521939754485:  # node 28: landmark_0_dx
                    return 4  # up, leaf 29
                else:
                    return 2  # right, leaf 30


def act_agent_0_batch(x):
    """As act_agent_0, for the rows of an array."""
    import numpy as np

    x = np.asarray(x, dtype=np.float32)
    n30 = 2
    n29 = 4
    n28 = np.where(x[:, 2] <= 0.8844521939754485, n29, n30)
    n27 = 2
    n26 = 2
    n25 = np.where(x[:, 2] <= 0.25566630065441126, n26, n27)
    n24 = np.where(x[:, 3] <= 0.31669448316097254, n25, n28)
    n23 = 4
    n22 = 4
    n21 = np.where(x[:, 3] <= 0.057488327845931046, n22, n23)
    n20 = 4
    n19 = 1
    n18 = np.where(x[:, 3] <= 0.1773836389183998, n19, n20)
    n17 = np.where(x[:, 2] <= -0.1551302894949913, n18, n21)
    n16 = np.where(x[:, 2] <= 0.20335019379854202, n17, n24)
    n15 = 2
    n14 = 3
    n13 = np.where(x[:, 8] <= -1.2054448723793032, n14, n15)
    n12 = 2
    n11 = 3
    n10 = np.where(x[:, 2] <= 0.9672703444957732, n11, n12)
    n9 = np.where(x[:, 3] <= -0.34070657193660736, n10, n13)
    n8 = 3
    n7 = 3
    n6 = np.where(x[:, 3] <= -0.08082212135195732, n7, n8)
    n5 = 1
    n4 = 3
    n3 = np.where(x[:, 3] <= -0.2865562587976456, n4, n5)
    n2 = np.where(x[:, 2] <= -0.17137212306261065, n3, n6)
    n1 = np.where(x[:, 2] <= 0.21981332451105118, n2, n9)
    n0 = np.where(x[:, 3] <= -0.009251977782696486, n1, n16)
    return n0


def act_agent_1(x):
    """agent_1, team defenders: 16 leaves, at most 4 comparisons."""
    if x[4] <= -0.10519966855645181:  # node 0: landmark_1_dx
        if x[5] <= 0.2063420936465263:  # node 1: landmark_1_dy
            if x[5] <= -0.2398081794381142:  # node 2: landmark_1_dy
                if x[4] <= -0.38395117223262787:  # node 3: landmark_1_dx
                    return 1  # left, leaf 4
                else:
                    return 3  # down, leaf 5
            else:
                if x[4] <= -0.16504899412393573:  # node 6: landmark_1_dx
                    return 1  # left, leaf 7
                else:
                    return 1  # left, leaf 8
        else:
            if x[4] <= -0.9429961144924164:  # node 9: landmark_1_dx
                if x[7] <= 1.4575472474098206:  # node 10: adversary_0_dy
                    return 1  # left, leaf 11
                else:
                    return 4  # up, leaf 12
            else:
                if x[5] <= 0.6897331178188323:  # node 13: landmark_1_dy
                    return 4  # up, leaf 14
                else:
                    return 4  # up, leaf 15
    else:
        if x[5] <= 0.0287479804828763:  # node 16: landmark_1_dy
            if x[4] <= 0.13584185391664505:  # node 17: landmark_1_dx
                if x[5] <= -0.07173165306448936:  # node 18: landmark_1_dy
                    return 3  # down, leaf 19
                else:
                    return 2  # right, leaf 20
            else:
                if x[5] <= -0.22423613816499713:  # node 21: landmark_1_dy
                    return 2  # right, leaf 22
                else:
                    return 2  # right, leaf 23
        else:
            if x[4] <= 0.18232687562704084:  # node 24: landmark_1_dx
                if x[5] <= 0.07625227794051169:  # node 25: landmark_1_dy
                    return 4  # up, leaf 26
                else:
                    return 4  # up, leaf 27
            else:
                if x[5] <= 0.27349622547626495:  # node 28: landmark_1_dy
                    return 2  # right, leaf 29
                else:
                    return 4  # up, leaf 30


def act_agent_1_batch(x):
    """As act_agent_1, for the rows of an array."""
    import numpy as np

    x = np.asarray(x, dtype=np.float32)
    n30 = 4
    n29 = 2
    n28 = np.where(x[:, 5] <= 0.27349622547626495, n29, n30)
    n27 = 4
    n26 = 4
    n25 = np.where(x[:, 5] <= 0.07625227794051169, n26, n27)
    n24 = np.where(x[:, 4] <= 0.18232687562704084, n25, n28)
    n23 = 2
    n22 = 2
    n21 = np.where(x[:, 5] <= -0.22423613816499713, n22, n23)
    n20 = 2
    n19 = 3
    n18 = np.where(x[:, 5] <= -0.07173165306448936, n19, n20)
    n17 = np.where(x[:, 4] <= 0.13584185391664505, n18, n21)
    n16 = np.where(x[:, 5] <= 0.0287479804828763, n17, n24)
    n15 = 4
    n14 = 4
    n13 = np.where(x[:, 5] <= 0.6897331178188323, n14, n15)
    n12 = 4
    n11 = 1
    n10 = np.where(x[:, 7] <= 1.4575472474098206, n11, n12)
    n9 = np.where(x[:, 4] <= -0.9429961144924164, n10, n13)
    n8 = 1
    n7 = 1
    n6 = np.where(x[:, 4] <= -0.16504899412393573, n7, n8)
    n5 = 3
    n4 = 1
    n3 = np.where(x[:, 4] <= -0.38395117223262787, n4, n5)
    n2 = np.where(x[:, 5] <= -0.2398081794381142, n3, n6)
    n1 = np.where(x[:, 5] <= 0.2063420936465263, n2, n9)
    n0 = np.where(x[:, 4] <= -0.10519966855645181, n1, n16)
    return n0


ACT = {
    "adversary_0": act_adversary_0,
    "agent_0": act_agent_0,
    "agent_1": act_agent_1,
}
