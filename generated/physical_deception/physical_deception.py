"""Decision tree policies of 3 agents for the world physical-deception. Generated: do not edit.

profile     e211f345166706452eb3d8a90b6927f886f2b2421f373afddae9e3e0ed1c9b58
made by     maviper 0.1.0, maviper, preset default, seed 0

For each agent A: act_A(x) takes one observation (a sequence of floats) and returns the action's number;
act_A_batch(x) takes an array [batch, n_features] and returns an array of actions (needs numpy).

A split goes left iff x[feature] <= threshold. Observations are float32; each threshold is written as the largest
double that rounds to a float32 not above it, so doubles decide as if they had been rounded to float32 first.
NaN compares false and so goes right; infinities follow <=.
"""

PROFILE = "e211f345166706452eb3d8a90b6927f886f2b2421f373afddae9e3e0ed1c9b58"
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
    """adversary_0, team adversaries: 15 leaves, at most 4 comparisons."""
    if x[4] <= 0.43936417996883387:  # node 0: agent_0_dx
        if x[5] <= 0.7210101783275603:  # node 1: agent_0_dy
            if x[7] <= 0.4398830980062484:  # node 2: agent_1_dy
                if x[2] <= -0.3559058457612992:  # node 3: landmark_1_dx
                    return 1  # left, leaf 4
                else:
                    return 3  # down, leaf 5
            else:
                if x[6] <= -0.5726385414600373:  # node 6: agent_1_dx
                    return 1  # left, leaf 7
                else:
                    return 4  # up, leaf 8
        else:
            if x[2] <= 0.8516533672809601:  # node 9: landmark_1_dx
                if x[4] <= -1.2038316130638123:  # node 10: agent_0_dx
                    return 1  # left, leaf 11
                else:
                    return 4  # up, leaf 12
            else:
                if x[7] <= 0.15961984544992447:  # node 13: agent_1_dy
                    return 2  # right, leaf 14
                else:
                    return 4  # up, leaf 15
    else:
        if x[1] <= -0.6770766079425813:  # node 16: landmark_0_dy
            if x[6] <= 0.05437335558235645:  # node 17: agent_1_dx
                if x[2] <= -0.784643441438675:  # node 18: landmark_1_dx
                    return 1  # left, leaf 19
                else:
                    return 3  # down, leaf 20
            else:
                if x[3] <= 0.38169075548648834:  # node 21: landmark_1_dy
                    return 2  # right, leaf 22
                else:
                    return 4  # up, leaf 23
        else:
            if x[1] <= 0.6577193439006804:  # node 24: landmark_0_dy
                return 2  # right, leaf 25
            else:
                if x[2] <= 0.7374391257762908:  # node 26: landmark_1_dx
                    return 4  # up, leaf 27
                else:
                    return 2  # right, leaf 28


def act_adversary_0_batch(x):
    """As act_adversary_0, for the rows of an array."""
    import numpy as np

    x = np.asarray(x, dtype=np.float32)
    n28 = 2
    n27 = 4
    n26 = np.where(x[:, 2] <= 0.7374391257762908, n27, n28)
    n25 = 2
    n24 = np.where(x[:, 1] <= 0.6577193439006804, n25, n26)
    n23 = 4
    n22 = 2
    n21 = np.where(x[:, 3] <= 0.38169075548648834, n22, n23)
    n20 = 3
    n19 = 1
    n18 = np.where(x[:, 2] <= -0.784643441438675, n19, n20)
    n17 = np.where(x[:, 6] <= 0.05437335558235645, n18, n21)
    n16 = np.where(x[:, 1] <= -0.6770766079425813, n17, n24)
    n15 = 4
    n14 = 2
    n13 = np.where(x[:, 7] <= 0.15961984544992447, n14, n15)
    n12 = 4
    n11 = 1
    n10 = np.where(x[:, 4] <= -1.2038316130638123, n11, n12)
    n9 = np.where(x[:, 2] <= 0.8516533672809601, n10, n13)
    n8 = 4
    n7 = 1
    n6 = np.where(x[:, 6] <= -0.5726385414600373, n7, n8)
    n5 = 3
    n4 = 1
    n3 = np.where(x[:, 2] <= -0.3559058457612992, n4, n5)
    n2 = np.where(x[:, 7] <= 0.4398830980062484, n3, n6)
    n1 = np.where(x[:, 5] <= 0.7210101783275603, n2, n9)
    n0 = np.where(x[:, 4] <= 0.43936417996883387, n1, n16)
    return n0


def act_agent_0(x):
    """agent_0, team defenders: 12 leaves, at most 4 comparisons."""
    if x[3] <= -0.019181148149073127:  # node 0: landmark_0_dy
        if x[2] <= 0.2594590336084366:  # node 1: landmark_0_dx
            if x[2] <= -0.22562288492918015:  # node 2: landmark_0_dx
                if x[3] <= -0.42393915355205536:  # node 3: landmark_0_dy
                    return 3  # down, leaf 4
                else:
                    return 1  # left, leaf 5
            else:
                return 3  # down, leaf 6
        else:
            if x[3] <= -0.5947428047657014:  # node 7: landmark_0_dy
                if x[2] <= 0.949094384908676:  # node 8: landmark_0_dx
                    return 3  # down, leaf 9
                else:
                    return 2  # right, leaf 10
            else:
                return 2  # right, leaf 11
    else:
        if x[2] <= 0.21276348084211347:  # node 12: landmark_0_dx
            if x[2] <= -0.17060639709234238:  # node 13: landmark_0_dx
                if x[3] <= 0.705427974462509:  # node 14: landmark_0_dy
                    return 1  # left, leaf 15
                else:
                    return 4  # up, leaf 16
            else:
                return 4  # up, leaf 17
        else:
            if x[3] <= 0.4279236644506454:  # node 18: landmark_0_dy
                return 2  # right, leaf 19
            else:
                if x[2] <= 0.6907770931720734:  # node 20: landmark_0_dx
                    return 4  # up, leaf 21
                else:
                    return 2  # right, leaf 22


def act_agent_0_batch(x):
    """As act_agent_0, for the rows of an array."""
    import numpy as np

    x = np.asarray(x, dtype=np.float32)
    n22 = 2
    n21 = 4
    n20 = np.where(x[:, 2] <= 0.6907770931720734, n21, n22)
    n19 = 2
    n18 = np.where(x[:, 3] <= 0.4279236644506454, n19, n20)
    n17 = 4
    n16 = 4
    n15 = 1
    n14 = np.where(x[:, 3] <= 0.705427974462509, n15, n16)
    n13 = np.where(x[:, 2] <= -0.17060639709234238, n14, n17)
    n12 = np.where(x[:, 2] <= 0.21276348084211347, n13, n18)
    n11 = 2
    n10 = 2
    n9 = 3
    n8 = np.where(x[:, 2] <= 0.949094384908676, n9, n10)
    n7 = np.where(x[:, 3] <= -0.5947428047657014, n8, n11)
    n6 = 3
    n5 = 1
    n4 = 3
    n3 = np.where(x[:, 3] <= -0.42393915355205536, n4, n5)
    n2 = np.where(x[:, 2] <= -0.22562288492918015, n3, n6)
    n1 = np.where(x[:, 2] <= 0.2594590336084366, n2, n7)
    n0 = np.where(x[:, 3] <= -0.019181148149073127, n1, n12)
    return n0


def act_agent_1(x):
    """agent_1, team defenders: 13 leaves, at most 4 comparisons."""
    if x[4] <= 0.17798655480146405:  # node 0: landmark_1_dx
        if x[5] <= -0.07031730189919473:  # node 1: landmark_1_dy
            if x[4] <= -0.2575884312391281:  # node 2: landmark_1_dx
                if x[5] <= -0.7288946211338044:  # node 3: landmark_1_dy
                    return 3  # down, leaf 4
                else:
                    return 1  # left, leaf 5
            else:
                return 3  # down, leaf 6
        else:
            if x[4] <= -0.13324155658483505:  # node 7: landmark_1_dx
                if x[5] <= 0.5304444730281829:  # node 8: landmark_1_dy
                    return 1  # left, leaf 9
                else:
                    return 4  # up, leaf 10
            else:
                if x[5] <= 0.075681883841753:  # node 11: landmark_1_dy
                    return 0  # stay, leaf 12
                else:
                    return 4  # up, leaf 13
    else:
        if x[5] <= 0.9964181482791901:  # node 14: landmark_1_dy
            if x[4] <= 0.2698250561952591:  # node 15: landmark_1_dx
                if x[5] <= -0.23646572977304461:  # node 16: landmark_1_dy
                    return 3  # down, leaf 17
                else:
                    return 2  # right, leaf 18
            else:
                if x[3] <= 1.6769688725471497:  # node 19: landmark_0_dy
                    return 2  # right, leaf 20
                else:
                    return 4  # up, leaf 21
        else:
            if x[0] <= 1.0369299054145813:  # node 22: goal_dx
                return 4  # up, leaf 23
            else:
                return 2  # right, leaf 24


def act_agent_1_batch(x):
    """As act_agent_1, for the rows of an array."""
    import numpy as np

    x = np.asarray(x, dtype=np.float32)
    n24 = 2
    n23 = 4
    n22 = np.where(x[:, 0] <= 1.0369299054145813, n23, n24)
    n21 = 4
    n20 = 2
    n19 = np.where(x[:, 3] <= 1.6769688725471497, n20, n21)
    n18 = 2
    n17 = 3
    n16 = np.where(x[:, 5] <= -0.23646572977304461, n17, n18)
    n15 = np.where(x[:, 4] <= 0.2698250561952591, n16, n19)
    n14 = np.where(x[:, 5] <= 0.9964181482791901, n15, n22)
    n13 = 4
    n12 = 0
    n11 = np.where(x[:, 5] <= 0.075681883841753, n12, n13)
    n10 = 4
    n9 = 1
    n8 = np.where(x[:, 5] <= 0.5304444730281829, n9, n10)
    n7 = np.where(x[:, 4] <= -0.13324155658483505, n8, n11)
    n6 = 3
    n5 = 1
    n4 = 3
    n3 = np.where(x[:, 5] <= -0.7288946211338044, n4, n5)
    n2 = np.where(x[:, 4] <= -0.2575884312391281, n3, n6)
    n1 = np.where(x[:, 5] <= -0.07031730189919473, n2, n7)
    n0 = np.where(x[:, 4] <= 0.17798655480146405, n1, n14)
    return n0


ACT = {
    "adversary_0": act_adversary_0,
    "agent_0": act_agent_0,
    "agent_1": act_agent_1,
}
