"""Decision tree policies of 3 agents for the world physical-deception. Generated: do not edit.

profile     dd6f8b466f85695a93d56909d565a85d0a442eae1365b3dd223025d02bd4458a
made by     maviper 0.1.0, maviper, preset default, seed 0

For each agent A: act_A(x) takes one observation (a sequence of floats) and returns the action's number;
act_A_batch(x) takes an array [batch, n_features] and returns an array of actions (needs numpy).

A split goes left iff x[feature] <= threshold. Observations are float32; each threshold is written as the largest
double that rounds to a float32 not above it, so doubles decide as if they had been rounded to float32 first.
NaN compares false and so goes right; infinities follow <=.
"""

PROFILE = "dd6f8b466f85695a93d56909d565a85d0a442eae1365b3dd223025d02bd4458a"
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
    if x[5] <= 0.4195723682641983:  # node 0: agent_0_dy
        if x[0] <= 0.48664639890193934:  # node 1: landmark_0_dx
            if x[2] <= -0.5525252521038055:  # node 2: landmark_1_dx
                if x[3] <= -0.9669307172298431:  # node 3: landmark_1_dy
                    return 3  # down, leaf 4
                else:
                    return 1  # left, leaf 5
            else:
                if x[7] <= 0.41337321698665613:  # node 6: agent_1_dy
                    return 3  # down, leaf 7
                else:
                    return 4  # up, leaf 8
        else:
            if x[3] <= -0.39489622414112097:  # node 9: landmark_1_dy
                if x[5] <= -0.193731464445591:  # node 10: agent_0_dy
                    return 3  # down, leaf 11
                else:
                    return 2  # right, leaf 12
            else:
                if x[6] <= -0.4544419795274735:  # node 13: agent_1_dx
                    return 1  # left, leaf 14
                else:
                    return 2  # right, leaf 15
    else:
        if x[0] <= 1.2236253619194029:  # node 16: landmark_0_dx
            if x[4] <= -0.8227663338184358:  # node 17: agent_0_dx
                if x[1] <= 0.9494496285915374:  # node 18: landmark_0_dy
                    return 1  # left, leaf 19
                else:
                    return 4  # up, leaf 20
            else:
                if x[2] <= 0.3745683580636978:  # node 21: landmark_1_dx
                    return 4  # up, leaf 22
                else:
                    return 2  # right, leaf 23
        else:
            if x[7] <= 0.9935198724269866:  # node 24: agent_1_dy
                return 2  # right, leaf 25
            else:
                if x[0] <= 1.5755468010902405:  # node 26: landmark_0_dx
                    return 4  # up, leaf 27
                else:
                    return 2  # right, leaf 28


def act_adversary_0_batch(x):
    """As act_adversary_0, for the rows of an array."""
    import numpy as np

    x = np.asarray(x, dtype=np.float32)
    actions = np.empty(len(x), dtype=np.int64)
    for start in range(0, len(x), 16384):  # as much as stays in the cache
        part = x[start : start + 16384]
        x0 = part[:, 0].copy()
        x2 = part[:, 2].copy()
        x3 = part[:, 3].copy()
        x5 = part[:, 5].copy()
        x7 = part[:, 7].copy()
        # each node's actions: those of the right child, with the bits that differ flipped where the test holds
        n26 = -(x0 <= 1.5755468010902405).view(np.uint8)
        n26 &= 4 ^ 2
        n26 ^= 2
        n24 = -(x7 <= 0.9935198724269866).view(np.uint8)
        n24 &= 2 ^ n26
        n24 ^= n26
        n21 = -(x2 <= 0.3745683580636978).view(np.uint8)
        n21 &= 4 ^ 2
        n21 ^= 2
        n18 = -(part[:, 1] <= 0.9494496285915374).view(np.uint8)
        n18 &= 1 ^ 4
        n18 ^= 4
        n17 = -(part[:, 4] <= -0.8227663338184358).view(np.uint8)
        n17 &= n18 ^ n21
        n17 ^= n21
        n16 = -(x0 <= 1.2236253619194029).view(np.uint8)
        n16 &= n17 ^ n24
        n16 ^= n24
        n13 = -(part[:, 6] <= -0.4544419795274735).view(np.uint8)
        n13 &= 1 ^ 2
        n13 ^= 2
        n10 = -(x5 <= -0.193731464445591).view(np.uint8)
        n10 &= 3 ^ 2
        n10 ^= 2
        n9 = -(x3 <= -0.39489622414112097).view(np.uint8)
        n9 &= n10 ^ n13
        n9 ^= n13
        n6 = -(x7 <= 0.41337321698665613).view(np.uint8)
        n6 &= 3 ^ 4
        n6 ^= 4
        n3 = -(x3 <= -0.9669307172298431).view(np.uint8)
        n3 &= 3 ^ 1
        n3 ^= 1
        n2 = -(x2 <= -0.5525252521038055).view(np.uint8)
        n2 &= n3 ^ n6
        n2 ^= n6
        n1 = -(x0 <= 0.48664639890193934).view(np.uint8)
        n1 &= n2 ^ n9
        n1 ^= n9
        n0 = -(x5 <= 0.4195723682641983).view(np.uint8)
        n0 &= n1 ^ n16
        n0 ^= n16
        actions[start : start + 16384] = n0
    return actions


def act_agent_0(x):
    """agent_0, team defenders: 14 leaves, at most 4 comparisons."""
    if x[3] <= 0.03540378250181675:  # node 0: landmark_0_dy
        if x[2] <= 0.18323151022195816:  # node 1: landmark_0_dx
            if x[2] <= -0.12809280306100848:  # node 2: landmark_0_dx
                if x[3] <= -0.3726151734590531:  # node 3: landmark_0_dy
                    return 3  # down, leaf 4
                else:
                    return 1  # left, leaf 5
            else:
                if x[3] <= -0.07367200031876565:  # node 6: landmark_0_dy
                    return 3  # down, leaf 7
                else:
                    return 2  # right, leaf 8
        else:
            if x[4] <= 0.34498657286167145:  # node 9: landmark_1_dx
                if x[3] <= -0.22133601456880572:  # node 10: landmark_0_dy
                    return 3  # down, leaf 11
                else:
                    return 2  # right, leaf 12
            else:
                if x[5] <= -1.6050081849098208:  # node 13: landmark_1_dy
                    return 3  # down, leaf 14
                else:
                    return 2  # right, leaf 15
    else:
        if x[2] <= 0.17827212065458295:  # node 16: landmark_0_dx
            if x[2] <= -0.19378846138715744:  # node 17: landmark_0_dx
                if x[3] <= 0.71113720536232:  # node 18: landmark_0_dy
                    return 1  # left, leaf 19
                else:
                    return 4  # up, leaf 20
            else:
                return 4  # up, leaf 21
        else:
            if x[3] <= 0.34428112208843226:  # node 22: landmark_0_dy
                return 2  # right, leaf 23
            else:
                if x[0] <= 0.8313309848308562:  # node 24: goal_dx
                    return 4  # up, leaf 25
                else:
                    return 2  # right, leaf 26


def act_agent_0_batch(x):
    """As act_agent_0, for the rows of an array."""
    import numpy as np

    x = np.asarray(x, dtype=np.float32)
    actions = np.empty(len(x), dtype=np.int64)
    for start in range(0, len(x), 16384):  # as much as stays in the cache
        part = x[start : start + 16384]
        x2 = part[:, 2].copy()
        x3 = part[:, 3].copy()
        # each node's actions: those of the right child, with the bits that differ flipped where the test holds
        n24 = -(part[:, 0] <= 0.8313309848308562).view(np.uint8)
        n24 &= 4 ^ 2
        n24 ^= 2
        n22 = -(x3 <= 0.34428112208843226).view(np.uint8)
        n22 &= 2 ^ n24
        n22 ^= n24
        n18 = -(x3 <= 0.71113720536232).view(np.uint8)
        n18 &= 1 ^ 4
        n18 ^= 4
        n17 = -(x2 <= -0.19378846138715744).view(np.uint8)
        n17 &= n18 ^ 4
        n17 ^= 4
        n16 = -(x2 <= 0.17827212065458295).view(np.uint8)
        n16 &= n17 ^ n22
        n16 ^= n22
        n13 = -(part[:, 5] <= -1.6050081849098208).view(np.uint8)
        n13 &= 3 ^ 2
        n13 ^= 2
        n10 = -(x3 <= -0.22133601456880572).view(np.uint8)
        n10 &= 3 ^ 2
        n10 ^= 2
        n9 = -(part[:, 4] <= 0.34498657286167145).view(np.uint8)
        n9 &= n10 ^ n13
        n9 ^= n13
        n6 = -(x3 <= -0.07367200031876565).view(np.uint8)
        n6 &= 3 ^ 2
        n6 ^= 2
        n3 = -(x3 <= -0.3726151734590531).view(np.uint8)
        n3 &= 3 ^ 1
        n3 ^= 1
        n2 = -(x2 <= -0.12809280306100848).view(np.uint8)
        n2 &= n3 ^ n6
        n2 ^= n6
        n1 = -(x2 <= 0.18323151022195816).view(np.uint8)
        n1 &= n2 ^ n9
        n1 ^= n9
        n0 = -(x3 <= 0.03540378250181675).view(np.uint8)
        n0 &= n1 ^ n16
        n0 ^= n16
        actions[start : start + 16384] = n0
    return actions


def act_agent_1(x):
    """agent_1, team defenders: 14 leaves, at most 4 comparisons."""
    if x[4] <= 0.16405732184648514:  # node 0: landmark_1_dx
        if x[5] <= -0.07031730189919473:  # node 1: landmark_1_dy
            if x[4] <= -0.2575884312391281:  # node 2: landmark_1_dx
                if x[5] <= -0.7288946211338044:  # node 3: landmark_1_dy
                    return 3  # down, leaf 4
                else:
                    return 1  # left, leaf 5
            else:
                if x[5] <= -0.11643354222178459:  # node 6: landmark_1_dy
                    return 3  # down, leaf 7
                else:
                    return 4  # up, leaf 8
        else:
            if x[4] <= -0.13324155658483505:  # node 9: landmark_1_dx
                if x[5] <= 0.5304444730281829:  # node 10: landmark_1_dy
                    return 1  # left, leaf 11
                else:
                    return 4  # up, leaf 12
            else:
                if x[5] <= 0.075681883841753:  # node 13: landmark_1_dy
                    return 0  # stay, leaf 14
                else:
                    return 4  # up, leaf 15
    else:
        if x[5] <= 0.9964181482791901:  # node 16: landmark_1_dy
            if x[4] <= 0.2698250561952591:  # node 17: landmark_1_dx
                if x[5] <= -0.23646572977304461:  # node 18: landmark_1_dy
                    return 3  # down, leaf 19
                else:
                    return 2  # right, leaf 20
            else:
                if x[3] <= 1.6769688725471497:  # node 21: landmark_0_dy
                    return 2  # right, leaf 22
                else:
                    return 4  # up, leaf 23
        else:
            if x[0] <= 1.0369299054145813:  # node 24: goal_dx
                return 4  # up, leaf 25
            else:
                return 2  # right, leaf 26


def act_agent_1_batch(x):
    """As act_agent_1, for the rows of an array."""
    import numpy as np

    x = np.asarray(x, dtype=np.float32)
    actions = np.empty(len(x), dtype=np.int64)
    for start in range(0, len(x), 16384):  # as much as stays in the cache
        part = x[start : start + 16384]
        x4 = part[:, 4].copy()
        x5 = part[:, 5].copy()
        # each node's actions: those of the right child, with the bits that differ flipped where the test holds
        n24 = -(part[:, 0] <= 1.0369299054145813).view(np.uint8)
        n24 &= 4 ^ 2
        n24 ^= 2
        n21 = -(part[:, 3] <= 1.6769688725471497).view(np.uint8)
        n21 &= 2 ^ 4
        n21 ^= 4
        n18 = -(x5 <= -0.23646572977304461).view(np.uint8)
        n18 &= 3 ^ 2
        n18 ^= 2
        n17 = -(x4 <= 0.2698250561952591).view(np.uint8)
        n17 &= n18 ^ n21
        n17 ^= n21
        n16 = -(x5 <= 0.9964181482791901).view(np.uint8)
        n16 &= n17 ^ n24
        n16 ^= n24
        n13 = -(x5 <= 0.075681883841753).view(np.uint8)
        n13 &= 0 ^ 4
        n13 ^= 4
        n10 = -(x5 <= 0.5304444730281829).view(np.uint8)
        n10 &= 1 ^ 4
        n10 ^= 4
        n9 = -(x4 <= -0.13324155658483505).view(np.uint8)
        n9 &= n10 ^ n13
        n9 ^= n13
        n6 = -(x5 <= -0.11643354222178459).view(np.uint8)
        n6 &= 3 ^ 4
        n6 ^= 4
        n3 = -(x5 <= -0.7288946211338044).view(np.uint8)
        n3 &= 3 ^ 1
        n3 ^= 1
        n2 = -(x4 <= -0.2575884312391281).view(np.uint8)
        n2 &= n3 ^ n6
        n2 ^= n6
        n1 = -(x5 <= -0.07031730189919473).view(np.uint8)
        n1 &= n2 ^ n9
        n1 ^= n9
        n0 = -(x4 <= 0.16405732184648514).view(np.uint8)
        n0 &= n1 ^ n16
        n0 ^= n16
        actions[start : start + 16384] = n0
    return actions


ACT = {
    "adversary_0": act_adversary_0,
    "agent_0": act_agent_0,
    "agent_1": act_agent_1,
}
