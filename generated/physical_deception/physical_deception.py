"""Decision tree policies of 3 agents for the world physical-deception. Generated: do not edit.

profile     883d3c4df60f96b6cb01ad91094f7a24fa39078550d2035691b80c4e5ca4e01f
made by     maviper 0.1.0, maviper, preset paper, seed 0

For each agent A: act_A(x) takes one observation (a sequence of floats) and returns the action's number;
act_A_batch(x) takes an array [batch, n_features] and returns an array of actions (needs numpy).

A split goes left iff x[feature] <= threshold. Observations are float32; each threshold is written as the largest
double that rounds to a float32 not above it, so doubles decide as if they had been rounded to float32 first.
NaN compares false and so goes right; infinities follow <=.
"""

PROFILE = "883d3c4df60f96b6cb01ad91094f7a24fa39078550d2035691b80c4e5ca4e01f"
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
    if x[0] <= -0.3261398226022721:  # node 0: landmark_0_dx
        if x[2] <= -0.04102909378707409:  # node 1: landmark_1_dx
            if x[3] <= -1.0789207816123962:  # node 2: landmark_1_dy
                if x[1] <= -0.27542699873447424:  # node 3: landmark_0_dy
                    return 3  # down, leaf 4
                else:
                    return 1  # left, leaf 5
            else:
                if x[1] <= 1.2780826687812805:  # node 6: landmark_0_dy
                    return 1  # left, leaf 7
                else:
                    return 4  # up, leaf 8
        else:
            if x[1] <= -0.38960100710392004:  # node 9: landmark_0_dy
                if x[3] <= 0.2698067873716354:  # node 10: landmark_1_dy
                    return 3  # down, leaf 11
                else:
                    return 3  # down, leaf 12
            else:
                if x[1] <= 0.8547556102275847:  # node 13: landmark_0_dy
                    return 1  # left, leaf 14
                else:
                    return 4  # up, leaf 15
    else:
        if x[1] <= -0.12066422030329704:  # node 16: landmark_0_dy
            if x[3] <= -0.16575472801923752:  # node 17: landmark_1_dy
                if x[0] <= 1.0812790989875793:  # node 18: landmark_0_dx
                    return 3  # down, leaf 19
                else:
                    return 2  # right, leaf 20
            else:
                if x[2] <= -0.1127176620066166:  # node 21: landmark_1_dx
                    return 1  # left, leaf 22
                else:
                    return 2  # right, leaf 23
        else:
            if x[3] <= 0.4017738252878189:  # node 24: landmark_1_dy
                if x[2] <= 0.17974988371133804:  # node 25: landmark_1_dx
                    return 4  # up, leaf 26
                else:
                    return 2  # right, leaf 27
            else:
                if x[0] <= 1.2963826060295103:  # node 28: landmark_0_dx
                    return 4  # up, leaf 29
                else:
                    return 2  # right, leaf 30


def act_adversary_0_batch(x):
    """As act_adversary_0, for the rows of an array."""
    import numpy as np

    x = np.asarray(x, dtype=np.float32)
    n30 = 2
    n29 = 4
    n28 = np.where(x[:, 0] <= 1.2963826060295103, n29, n30)
    n27 = 2
    n26 = 4
    n25 = np.where(x[:, 2] <= 0.17974988371133804, n26, n27)
    n24 = np.where(x[:, 3] <= 0.4017738252878189, n25, n28)
    n23 = 2
    n22 = 1
    n21 = np.where(x[:, 2] <= -0.1127176620066166, n22, n23)
    n20 = 2
    n19 = 3
    n18 = np.where(x[:, 0] <= 1.0812790989875793, n19, n20)
    n17 = np.where(x[:, 3] <= -0.16575472801923752, n18, n21)
    n16 = np.where(x[:, 1] <= -0.12066422030329704, n17, n24)
    n15 = 4
    n14 = 1
    n13 = np.where(x[:, 1] <= 0.8547556102275847, n14, n15)
    n12 = 3
    n11 = 3
    n10 = np.where(x[:, 3] <= 0.2698067873716354, n11, n12)
    n9 = np.where(x[:, 1] <= -0.38960100710392004, n10, n13)
    n8 = 4
    n7 = 1
    n6 = np.where(x[:, 1] <= 1.2780826687812805, n7, n8)
    n5 = 1
    n4 = 3
    n3 = np.where(x[:, 1] <= -0.27542699873447424, n4, n5)
    n2 = np.where(x[:, 3] <= -1.0789207816123962, n3, n6)
    n1 = np.where(x[:, 2] <= -0.04102909378707409, n2, n9)
    n0 = np.where(x[:, 0] <= -0.3261398226022721, n1, n16)
    return n0


def act_agent_0(x):
    """agent_0, team defenders: 16 leaves, at most 4 comparisons."""
    if x[3] <= -0.07262463495135307:  # node 0: landmark_0_dy
        if x[2] <= 0.5513819158077239:  # node 1: landmark_0_dx
            if x[2] <= -0.09532130137085916:  # node 2: landmark_0_dx
                if x[1] <= -0.29153998196125036:  # node 3: goal_dy
                    return 3  # down, leaf 4
                else:
                    return 1  # left, leaf 5
            else:
                if x[1] <= -0.16092931479215622:  # node 6: goal_dy
                    return 3  # down, leaf 7
                else:
                    return 3  # down, leaf 8
        else:
            if x[0] <= -0.31594161689281464:  # node 9: goal_dx
                if x[6] <= -0.389759972691536:  # node 10: adversary_0_dx
                    return 3  # down, leaf 11
                else:
                    return 1  # left, leaf 12
            else:
                if x[3] <= -0.7726363837718964:  # node 13: landmark_0_dy
                    return 3  # down, leaf 14
                else:
                    return 2  # right, leaf 15
    else:
        if x[2] <= 0.16270679980516434:  # node 16: landmark_0_dx
            if x[3] <= 0.14625642448663712:  # node 17: landmark_0_dy
                if x[2] <= -0.01596744265407324:  # node 18: landmark_0_dx
                    return 1  # left, leaf 19
                else:
                    return 4  # up, leaf 20
            else:
                if x[2] <= -0.18193877488374713:  # node 21: landmark_0_dx
                    return 1  # left, leaf 22
                else:
                    return 4  # up, leaf 23
        else:
            if x[3] <= 0.3554082661867142:  # node 24: landmark_0_dy
                if x[5] <= 1.7773523926734924:  # node 25: landmark_1_dy
                    return 2  # right, leaf 26
                else:
                    return 4  # up, leaf 27
            else:
                if x[2] <= 0.4929414540529251:  # node 28: landmark_0_dx
                    return 4  # up, leaf 29
                else:
                    return 2  # right, leaf 30


def act_agent_0_batch(x):
    """As act_agent_0, for the rows of an array."""
    import numpy as np

    x = np.asarray(x, dtype=np.float32)
    n30 = 2
    n29 = 4
    n28 = np.where(x[:, 2] <= 0.4929414540529251, n29, n30)
    n27 = 4
    n26 = 2
    n25 = np.where(x[:, 5] <= 1.7773523926734924, n26, n27)
    n24 = np.where(x[:, 3] <= 0.3554082661867142, n25, n28)
    n23 = 4
    n22 = 1
    n21 = np.where(x[:, 2] <= -0.18193877488374713, n22, n23)
    n20 = 4
    n19 = 1
    n18 = np.where(x[:, 2] <= -0.01596744265407324, n19, n20)
    n17 = np.where(x[:, 3] <= 0.14625642448663712, n18, n21)
    n16 = np.where(x[:, 2] <= 0.16270679980516434, n17, n24)
    n15 = 2
    n14 = 3
    n13 = np.where(x[:, 3] <= -0.7726363837718964, n14, n15)
    n12 = 1
    n11 = 3
    n10 = np.where(x[:, 6] <= -0.389759972691536, n11, n12)
    n9 = np.where(x[:, 0] <= -0.31594161689281464, n10, n13)
    n8 = 3
    n7 = 3
    n6 = np.where(x[:, 1] <= -0.16092931479215622, n7, n8)
    n5 = 1
    n4 = 3
    n3 = np.where(x[:, 1] <= -0.29153998196125036, n4, n5)
    n2 = np.where(x[:, 2] <= -0.09532130137085916, n3, n6)
    n1 = np.where(x[:, 2] <= 0.5513819158077239, n2, n9)
    n0 = np.where(x[:, 3] <= -0.07262463495135307, n1, n16)
    return n0


def act_agent_1(x):
    """agent_1, team defenders: 16 leaves, at most 4 comparisons."""
    if x[4] <= -0.04791293852031231:  # node 0: landmark_1_dx
        if x[5] <= -0.12941441684961322:  # node 1: landmark_1_dy
            if x[4] <= -0.41916219890117645:  # node 2: landmark_1_dx
                if x[1] <= 0.4023166447877884:  # node 3: goal_dy
                    return 1  # left, leaf 4
                else:
                    return 4  # up, leaf 5
            else:
                if x[5] <= -0.2965695410966874:  # node 6: landmark_1_dy
                    return 3  # down, leaf 7
                else:
                    return 3  # down, leaf 8
        else:
            if x[5] <= 0.694657415151596:  # node 9: landmark_1_dy
                if x[4] <= -0.1471678838133812:  # node 10: landmark_1_dx
                    return 1  # left, leaf 11
                else:
                    return 1  # left, leaf 12
            else:
                if x[1] <= 0.20840900391340253:  # node 13: goal_dy
                    return 1  # left, leaf 14
                else:
                    return 4  # up, leaf 15
    else:
        if x[5] <= 0.1468965634703636:  # node 16: landmark_1_dy
            if x[4] <= 0.3626327365636825:  # node 17: landmark_1_dx
                if x[5] <= -0.19326610118150714:  # node 18: landmark_1_dy
                    return 3  # down, leaf 19
                else:
                    return 2  # right, leaf 20
            else:
                if x[1] <= -0.88029345870018:  # node 21: goal_dy
                    return 3  # down, leaf 22
                else:
                    return 2  # right, leaf 23
        else:
            if x[4] <= 0.7734169065952301:  # node 24: landmark_1_dx
                if x[7] <= -0.7529555261135101:  # node 25: adversary_0_dy
                    return 2  # right, leaf 26
                else:
                    return 4  # up, leaf 27
            else:
                if x[3] <= 0.4315086156129837:  # node 28: landmark_0_dy
                    return 2  # right, leaf 29
                else:
                    return 4  # up, leaf 30


def act_agent_1_batch(x):
    """As act_agent_1, for the rows of an array."""
    import numpy as np

    x = np.asarray(x, dtype=np.float32)
    n30 = 4
    n29 = 2
    n28 = np.where(x[:, 3] <= 0.4315086156129837, n29, n30)
    n27 = 4
    n26 = 2
    n25 = np.where(x[:, 7] <= -0.7529555261135101, n26, n27)
    n24 = np.where(x[:, 4] <= 0.7734169065952301, n25, n28)
    n23 = 2
    n22 = 3
    n21 = np.where(x[:, 1] <= -0.88029345870018, n22, n23)
    n20 = 2
    n19 = 3
    n18 = np.where(x[:, 5] <= -0.19326610118150714, n19, n20)
    n17 = np.where(x[:, 4] <= 0.3626327365636825, n18, n21)
    n16 = np.where(x[:, 5] <= 0.1468965634703636, n17, n24)
    n15 = 4
    n14 = 1
    n13 = np.where(x[:, 1] <= 0.20840900391340253, n14, n15)
    n12 = 1
    n11 = 1
    n10 = np.where(x[:, 4] <= -0.1471678838133812, n11, n12)
    n9 = np.where(x[:, 5] <= 0.694657415151596, n10, n13)
    n8 = 3
    n7 = 3
    n6 = np.where(x[:, 5] <= -0.2965695410966874, n7, n8)
    n5 = 4
    n4 = 1
    n3 = np.where(x[:, 1] <= 0.4023166447877884, n4, n5)
    n2 = np.where(x[:, 4] <= -0.41916219890117645, n3, n6)
    n1 = np.where(x[:, 5] <= -0.12941441684961322, n2, n9)
    n0 = np.where(x[:, 4] <= -0.04791293852031231, n1, n16)
    return n0


ACT = {
    "adversary_0": act_adversary_0,
    "agent_0": act_agent_0,
    "agent_1": act_agent_1,
}
