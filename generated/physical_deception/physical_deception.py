"""Decision tree policies of 3 agents for the world physical-deception. Generated: do not edit.

profile     492c3f7d7f8e3d05241ad5186d96513b2eca15b3543afe2d19b9bb9876d1fd2d
made by     maviper 0.1.0, maviper, preset paper, seed 0

For each agent A: act_A(x) takes one observation (a sequence of floats) and returns the action's number;
act_A_batch(x) takes an array [batch, n_features] and returns an array of actions (needs numpy).

A split goes left iff x[feature] <= threshold. Observations are float32; each threshold is written as the largest
double that rounds to a float32 not above it, so doubles decide as if they had been rounded to float32 first.
NaN compares false and so goes right; infinities follow <=.
"""

PROFILE = "492c3f7d7f8e3d05241ad5186d96513b2eca15b3543afe2d19b9bb9876d1fd2d"
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
    if x[0] <= -0.1577839627861977:  # node 0: landmark_0_dx
        if x[2] <= 0.12741117924451825:  # node 1: landmark_1_dx
            if x[1] <= -1.1944915652275085:  # node 2: landmark_0_dy
                if x[2] <= -0.6234430372714997:  # node 3: landmark_1_dx
                    return 1  # left, leaf 4
                else:
                    return 3  # down, leaf 5
            else:
                if x[3] <= 0.7945961058139801:  # node 6: landmark_1_dy
                    return 1  # left, leaf 7
                else:
                    return 4  # up, leaf 8
        else:
            if x[1] <= -0.48724605143070226:  # node 9: landmark_0_dy
                if x[3] <= 0.6199717819690704:  # node 10: landmark_1_dy
                    return 3  # down, leaf 11
                else:
                    return 2  # right, leaf 12
            else:
                if x[1] <= 0.7037765681743621:  # node 13: landmark_0_dy
                    return 1  # left, leaf 14
                else:
                    return 4  # up, leaf 15
    else:
        if x[2] <= -0.0330543015152216:  # node 16: landmark_1_dx
            if x[3] <= -0.2649009376764298:  # node 17: landmark_1_dy
                if x[5] <= 0.3254163116216659:  # node 18: agent_0_dy
                    return 3  # down, leaf 19
                else:
                    return 1  # left, leaf 20
            else:
                if x[1] <= 0.09012966975569724:  # node 21: landmark_0_dy
                    return 1  # left, leaf 22
                else:
                    return 4  # up, leaf 23
        else:
            if x[1] <= -0.38134546577930456:  # node 24: landmark_0_dy
                if x[0] <= 0.3493469804525375:  # node 25: landmark_0_dx
                    return 3  # down, leaf 26
                else:
                    return 2  # right, leaf 27
            else:
                if x[3] <= 0.8027574717998504:  # node 28: landmark_1_dy
                    return 2  # right, leaf 29
                else:
                    return 4  # up, leaf 30


def act_adversary_0_batch(x):
    """As act_adversary_0, for the rows of an array."""
    import numpy as np

    x = np.asarray(x, dtype=np.float32)
    n30 = 4
    n29 = 2
    n28 = np.where(x[:, 3] <= 0.8027574717998504, n29, n30)
    n27 = 2
    n26 = 3
    n25 = np.where(x[:, 0] <= 0.3493469804525375, n26, n27)
    n24 = np.where(x[:, 1] <= -0.38134546577930456, n25, n28)
    n23 = 4
    n22 = 1
    n21 = np.where(x[:, 1] <= 0.09012966975569724, n22, n23)
    n20 = 1
    n19 = 3
    n18 = np.where(x[:, 5] <= 0.3254163116216659, n19, n20)
    n17 = np.where(x[:, 3] <= -0.2649009376764298, n18, n21)
    n16 = np.where(x[:, 2] <= -0.0330543015152216, n17, n24)
    n15 = 4
    n14 = 1
    n13 = np.where(x[:, 1] <= 0.7037765681743621, n14, n15)
    n12 = 2
    n11 = 3
    n10 = np.where(x[:, 3] <= 0.6199717819690704, n11, n12)
    n9 = np.where(x[:, 1] <= -0.48724605143070226, n10, n13)
    n8 = 4
    n7 = 1
    n6 = np.where(x[:, 3] <= 0.7945961058139801, n7, n8)
    n5 = 3
    n4 = 1
    n3 = np.where(x[:, 2] <= -0.6234430372714997, n4, n5)
    n2 = np.where(x[:, 1] <= -1.1944915652275085, n3, n6)
    n1 = np.where(x[:, 2] <= 0.12741117924451825, n2, n9)
    n0 = np.where(x[:, 0] <= -0.1577839627861977, n1, n16)
    return n0


def act_agent_0(x):
    """agent_0, team defenders: 16 leaves, at most 4 comparisons."""
    if x[2] <= 0.1441761925816536:  # node 0: landmark_0_dx
        if x[3] <= 0.12808439880609512:  # node 1: landmark_0_dy
            if x[2] <= -0.050705710425972945:  # node 2: landmark_0_dx
                if x[3] <= -0.536104291677475:  # node 3: landmark_0_dy
                    return 3  # down, leaf 4
                else:
                    return 1  # left, leaf 5
            else:
                if x[3] <= -0.020971248857676983:  # node 6: landmark_0_dy
                    return 3  # down, leaf 7
                else:
                    return 1  # left, leaf 8
        else:
            if x[2] <= -0.14417635649442673:  # node 9: landmark_0_dx
                if x[5] <= 0.9552025496959685:  # node 10: landmark_1_dy
                    return 1  # left, leaf 11
                else:
                    return 4  # up, leaf 12
            else:
                if x[1] <= -0.8983847796916962:  # node 13: goal_dy
                    return 4  # up, leaf 14
                else:
                    return 4  # up, leaf 15
    else:
        if x[3] <= -0.15442528575658798:  # node 16: landmark_0_dy
            if x[0] <= 0.6068759262561798:  # node 17: goal_dx
                if x[9] <= 0.5203783214092254:  # node 18: agent_1_dy
                    return 3  # down, leaf 19
                else:
                    return 2  # right, leaf 20
            else:
                if x[0] <= 1.1530240178108215:  # node 21: goal_dx
                    return 2  # right, leaf 22
                else:
                    return 3  # down, leaf 23
        else:
            if x[3] <= 0.3386256843805313:  # node 24: landmark_0_dy
                if x[6] <= -0.4222481697797775:  # node 25: adversary_0_dx
                    return 2  # right, leaf 26
                else:
                    return 2  # right, leaf 27
            else:
                if x[0] <= 0.38455562293529505:  # node 28: goal_dx
                    return 4  # up, leaf 29
                else:
                    return 2  # right, leaf 30


def act_agent_0_batch(x):
    """As act_agent_0, for the rows of an array."""
    import numpy as np

    x = np.asarray(x, dtype=np.float32)
    n30 = 2
    n29 = 4
    n28 = np.where(x[:, 0] <= 0.38455562293529505, n29, n30)
    n27 = 2
    n26 = 2
    n25 = np.where(x[:, 6] <= -0.4222481697797775, n26, n27)
    n24 = np.where(x[:, 3] <= 0.3386256843805313, n25, n28)
    n23 = 3
    n22 = 2
    n21 = np.where(x[:, 0] <= 1.1530240178108215, n22, n23)
    n20 = 2
    n19 = 3
    n18 = np.where(x[:, 9] <= 0.5203783214092254, n19, n20)
    n17 = np.where(x[:, 0] <= 0.6068759262561798, n18, n21)
    n16 = np.where(x[:, 3] <= -0.15442528575658798, n17, n24)
    n15 = 4
    n14 = 4
    n13 = np.where(x[:, 1] <= -0.8983847796916962, n14, n15)
    n12 = 4
    n11 = 1
    n10 = np.where(x[:, 5] <= 0.9552025496959685, n11, n12)
    n9 = np.where(x[:, 2] <= -0.14417635649442673, n10, n13)
    n8 = 1
    n7 = 3
    n6 = np.where(x[:, 3] <= -0.020971248857676983, n7, n8)
    n5 = 1
    n4 = 3
    n3 = np.where(x[:, 3] <= -0.536104291677475, n4, n5)
    n2 = np.where(x[:, 2] <= -0.050705710425972945, n3, n6)
    n1 = np.where(x[:, 3] <= 0.12808439880609512, n2, n9)
    n0 = np.where(x[:, 2] <= 0.1441761925816536, n1, n16)
    return n0


def act_agent_1(x):
    """agent_1, team defenders: 16 leaves, at most 4 comparisons."""
    if x[4] <= -0.017141898162662986:  # node 0: landmark_1_dx
        if x[5] <= -0.22955181449651718:  # node 1: landmark_1_dy
            if x[4] <= -1.338127672672272:  # node 2: landmark_1_dx
                if x[3] <= 0.034315602853894234:  # node 3: landmark_0_dy
                    return 1  # left, leaf 4
                else:
                    return 4  # up, leaf 5
            else:
                if x[0] <= -0.45174644887447357:  # node 6: goal_dx
                    return 3  # down, leaf 7
                else:
                    return 3  # down, leaf 8
        else:
            if x[5] <= 0.389350488781929:  # node 9: landmark_1_dy
                if x[4] <= -0.13205290585756305:  # node 10: landmark_1_dx
                    return 1  # left, leaf 11
                else:
                    return 1  # left, leaf 12
            else:
                if x[4] <= -0.6586795151233674:  # node 13: landmark_1_dx
                    return 1  # left, leaf 14
                else:
                    return 4  # up, leaf 15
    else:
        if x[5] <= 0.2666712552309036:  # node 16: landmark_1_dy
            if x[1] <= -0.21131790429353717:  # node 17: goal_dy
                if x[2] <= 0.42330433428287506:  # node 18: landmark_0_dx
                    return 3  # down, leaf 19
                else:
                    return 2  # right, leaf 20
            else:
                if x[4] <= 0.28225730359554285:  # node 21: landmark_1_dx
                    return 2  # right, leaf 22
                else:
                    return 2  # right, leaf 23
        else:
            if x[4] <= 1.2374507784843443:  # node 24: landmark_1_dx
                if x[3] <= 0.09777050092816353:  # node 25: landmark_0_dy
                    return 4  # up, leaf 26
                else:
                    return 4  # up, leaf 27
            else:
                if x[0] <= 0.93136128783226:  # node 28: goal_dx
                    return 3  # down, leaf 29
                else:
                    return 2  # right, leaf 30


def act_agent_1_batch(x):
    """As act_agent_1, for the rows of an array."""
    import numpy as np

    x = np.asarray(x, dtype=np.float32)
    n30 = 2
    n29 = 3
    n28 = np.where(x[:, 0] <= 0.93136128783226, n29, n30)
    n27 = 4
    n26 = 4
    n25 = np.where(x[:, 3] <= 0.09777050092816353, n26, n27)
    n24 = np.where(x[:, 4] <= 1.2374507784843443, n25, n28)
    n23 = 2
    n22 = 2
    n21 = np.where(x[:, 4] <= 0.28225730359554285, n22, n23)
    n20 = 2
    n19 = 3
    n18 = np.where(x[:, 2] <= 0.42330433428287506, n19, n20)
    n17 = np.where(x[:, 1] <= -0.21131790429353717, n18, n21)
    n16 = np.where(x[:, 5] <= 0.2666712552309036, n17, n24)
    n15 = 4
    n14 = 1
    n13 = np.where(x[:, 4] <= -0.6586795151233674, n14, n15)
    n12 = 1
    n11 = 1
    n10 = np.where(x[:, 4] <= -0.13205290585756305, n11, n12)
    n9 = np.where(x[:, 5] <= 0.389350488781929, n10, n13)
    n8 = 3
    n7 = 3
    n6 = np.where(x[:, 0] <= -0.45174644887447357, n7, n8)
    n5 = 4
    n4 = 1
    n3 = np.where(x[:, 3] <= 0.034315602853894234, n4, n5)
    n2 = np.where(x[:, 4] <= -1.338127672672272, n3, n6)
    n1 = np.where(x[:, 5] <= -0.22955181449651718, n2, n9)
    n0 = np.where(x[:, 4] <= -0.017141898162662986, n1, n16)
    return n0


ACT = {
    "adversary_0": act_adversary_0,
    "agent_0": act_agent_0,
    "agent_1": act_agent_1,
}
