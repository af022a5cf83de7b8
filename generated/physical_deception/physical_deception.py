"""Decision tree policies of 3 agents for the world physical-deception. Generated: do not edit.

profile     1875a17576b3c92c392cd663069c6c74cf62b8a6aa1dc539166c886898fcb976
made by     maviper 0.1.0, maviper, preset default, seed 0

For each agent A: act_A(x) takes one observation (a sequence of numbers, or an array of one axis) and returns the
action's number; act_A_batch(x) takes an array [batch, n_features] and returns an array of actions (needs numpy).
An observation has a number for each name of FEATURES[A]; another length is a ValueError, a text or None where a number
is asked for a TypeError.

A split goes left iff x[feature] <= threshold. A number of any type is a double first, rounded where it must be (an int
beyond 2**53, a Fraction, numpy's longdouble), then a float32: each threshold is written as the largest double that
rounds to a float32 not above it, so doubles decide as if they had been rounded to float32. NaN compares false and so
goes right; infinities follow <=. numpy's numbers next to zero are decided otherwise in a thread that takes subnormal
numbers for zero, which a library can set; numpy then warns when it is imported.
"""

PROFILE = "1875a17576b3c92c392cd663069c6c74cf62b8a6aa1dc539166c886898fcb976"
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


_NUMBERS = {float, int, bool}  # types whose values are numbers; others join them when they are met


def _double(value):
    """A number of an observation as a double, rounded where it is none; TypeError for what is no number."""
    if type(value) not in _NUMBERS:
        kind = getattr(getattr(value, "dtype", None), "kind", "f")  # of numpy: texts, times, complex are no numbers
        number = hasattr(type(value), "__float__") or hasattr(type(value), "__index__")
        if not number or isinstance(value, (str, bytes, complex)) or kind in "cmMSU" or getattr(value, "ndim", 0):
            raise TypeError("an observation is of numbers, not of %s %.40r" % (type(value).__name__, value))
        if not hasattr(value, "__len__"):  # else it is an array, and another of its type may be no number
            _NUMBERS.add(type(value))
    return float(value)


def _observation(agent, n, x):
    """An observation as a list or tuple of n; ValueError for another length, TypeError for what is no sequence."""
    values = x.tolist() if hasattr(x, "tolist") else x
    if type(values) is list and len(values) == n and type(values[0]) is float:
        return values  # an array of one axis, as its first entry shows; asking for its shape would take longer
    shape, kind = getattr(x, "shape", None), getattr(getattr(x, "dtype", None), "kind", "f")
    if isinstance(x, (str, bytes, bytearray)) or kind in "cmMSU" or (shape is None and not hasattr(x, "__len__")):
        given = "an array of %s" % x.dtype if hasattr(x, "dtype") else type(x).__name__
        raise TypeError("%s observes %d numbers, given %s" % (agent, n, given))
    shape = (len(x),) if shape is None else tuple(shape)
    if shape != (n,):
        given = shape[0] if len(shape) == 1 else "an array of shape %s" % (shape,)
        raise ValueError("%s observes %d numbers, given %s" % (agent, n, given))
    return values if isinstance(values, (list, tuple)) else [x[index] for index in range(n)]


def _rows(agent, n, x):
    """Observations as an array of float32, [batch, n], each number a double first; errors as for one."""
    import numpy as np

    try:
        x = np.asarray(x)
    except ValueError as error:
        raise ValueError("%s observes rows of %d numbers: %s" % (agent, n, error)) from None
    x = x.reshape(0, n) if x.shape == (0,) else x
    if x.ndim != 2 or x.shape[1] != n:
        raise ValueError("%s observes rows of %d numbers, given an array of shape %s" % (agent, n, x.shape))
    if x.dtype == np.float32:
        return x
    if x.dtype.kind in "cmMSU":
        raise TypeError("%s observes rows of %d numbers, given an array of %s" % (agent, n, x.dtype))
    if x.dtype.kind in "OV":
        x = np.array([_double(value) for row in x.tolist() for value in row], dtype=np.float64).reshape(x.shape)
    with np.errstate(over="ignore", invalid="ignore"):  # beyond the largest float32 is infinity
        if x.dtype.kind != "f" or x.dtype.itemsize > 8:
            x = x.astype(np.float64)
        return x.astype(np.float32)


def _choose(test, left, right):
    """`left` where the test holds, else `right`; both are actions or arrays of them."""
    actions = test.view("uint8")  # 1 or 0
    actions *= left ^ right  # the bits in which they differ
    actions ^= right
    return actions


def _columns(rows, features):
    """Some columns of an array, each in one piece; 256 rows at a time, which stay in the nearest cache."""
    import numpy as np

    tiles = len(rows) // 256
    whole = 256 * tiles
    found = np.empty((len(features), len(rows)), dtype=np.float32)
    tiled = rows[:whole].reshape(tiles, 256, rows.shape[1]).transpose(0, 2, 1)[np.arange(tiles)[:, None], features]
    found[:, :whole].reshape(len(features), tiles, 256)[:] = tiled.transpose(1, 0, 2)
    found[:, whole:] = rows[whole:, features].T
    return found


def act_adversary_0(x):
    """adversary_0, team adversaries: 14 leaves, at most 4 comparisons."""
    if (type(x) is not list and type(x) is not tuple) or len(x) != 8:
        x = _observation("adversary_0", 8, x)
    if (v if type(v := x[5]) is float else _double(v)) <= 0.5906582176685333:  # node 0: agent_0_dy
        if (v if type(v := x[4]) is float else _double(v)) <= 0.1821293905377388:  # node 1: agent_0_dx
            if (v if type(v := x[2]) is float else _double(v)) <= -0.3744440227746964:  # node 2: landmark_1_dx
                if (v if type(v := x[3]) is float else _double(v)) <= -0.9669307172298431:  # node 3: landmark_1_dy
                    return 3  # down, leaf 4
                else:
                    return 1  # left, leaf 5
            else:
                if (v if type(v := x[7]) is float else _double(v)) <= 0.4176633507013321:  # node 6: agent_1_dy
                    return 3  # down, leaf 7
                else:
                    return 4  # up, leaf 8
        else:
            if (v if type(v := x[0]) is float else _double(v)) <= 0.4460940212011337:  # node 9: landmark_0_dx
                if (v if type(v := x[5]) is float else _double(v)) <= -0.3393974453210831:  # node 10: agent_0_dy
                    return 3  # down, leaf 11
                else:
                    return 2  # right, leaf 12
            else:
                if (v if type(v := x[1]) is float else _double(v)) <= -0.9289903342723846:  # node 13: landmark_0_dy
                    return 3  # down, leaf 14
                else:
                    return 2  # right, leaf 15
    else:
        if (v if type(v := x[0]) is float else _double(v)) <= 1.1644417643547056:  # node 16: landmark_0_dx
            if (v if type(v := x[0]) is float else _double(v)) <= -0.5838115513324739:  # node 17: landmark_0_dx
                if (v if type(v := x[1]) is float else _double(v)) <= 0.9494496285915374:  # node 18: landmark_0_dy
                    return 1  # left, leaf 19
                else:
                    return 4  # up, leaf 20
            else:
                if (v if type(v := x[2]) is float else _double(v)) <= 0.7867685854434967:  # node 21: landmark_1_dx
                    return 4  # up, leaf 22
                else:
                    return 2  # right, leaf 23
        else:
            if (v if type(v := x[1]) is float else _double(v)) <= -0.40675909817218786:  # node 24: landmark_0_dy
                return 4  # up, leaf 25
            else:
                return 2  # right, leaf 26


def act_adversary_0_batch(x):
    """As act_adversary_0, for the rows of an array."""
    import numpy as np

    x = _rows("adversary_0", 8, x)
    actions = np.empty(len(x), dtype=np.int64)
    for start in range(0, len(x), 65536):  # so many that calls cost little, so few that caches hold them
        rows = x[start : start + 65536]
        x0, x1, x2, x3, x4, x5, x7 = _columns(rows, [0, 1, 2, 3, 4, 5, 7])
        actions[start : start + 65536] = _choose(
            x5 <= 0.5906582176685333,  # node 0: agent_0_dy
            _choose(
                x4 <= 0.1821293905377388,  # node 1: agent_0_dx
                _choose(
                    x2 <= -0.3744440227746964,  # node 2: landmark_1_dx
                    _choose(
                        x3 <= -0.9669307172298431,  # node 3: landmark_1_dy
                        3,  # down, leaf 4
                        1,  # left, leaf 5
                    ),
                    _choose(
                        x7 <= 0.4176633507013321,  # node 6: agent_1_dy
                        3,  # down, leaf 7
                        4,  # up, leaf 8
                    ),
                ),
                _choose(
                    x0 <= 0.4460940212011337,  # node 9: landmark_0_dx
                    _choose(
                        x5 <= -0.3393974453210831,  # node 10: agent_0_dy
                        3,  # down, leaf 11
                        2,  # right, leaf 12
                    ),
                    _choose(
                        x1 <= -0.9289903342723846,  # node 13: landmark_0_dy
                        3,  # down, leaf 14
                        2,  # right, leaf 15
                    ),
                ),
            ),
            _choose(
                x0 <= 1.1644417643547056,  # node 16: landmark_0_dx
                _choose(
                    x0 <= -0.5838115513324739,  # node 17: landmark_0_dx
                    _choose(
                        x1 <= 0.9494496285915374,  # node 18: landmark_0_dy
                        1,  # left, leaf 19
                        4,  # up, leaf 20
                    ),
                    _choose(
                        x2 <= 0.7867685854434967,  # node 21: landmark_1_dx
                        4,  # up, leaf 22
                        2,  # right, leaf 23
                    ),
                ),
                _choose(
                    x1 <= -0.40675909817218786,  # node 24: landmark_0_dy
                    4,  # up, leaf 25
                    2,  # right, leaf 26
                ),
            ),
        )
    return actions


def act_agent_0(x):
    """agent_0, team defenders: 14 leaves, at most 4 comparisons."""
    if (type(x) is not list and type(x) is not tuple) or len(x) != 10:
        x = _observation("agent_0", 10, x)
    if (v if type(v := x[3]) is float else _double(v)) <= 0.03540378250181675:  # node 0: landmark_0_dy
        if (v if type(v := x[2]) is float else _double(v)) <= 0.18323151022195816:  # node 1: landmark_0_dx
            if (v if type(v := x[2]) is float else _double(v)) <= -0.12809280306100848:  # node 2: landmark_0_dx
                if (v if type(v := x[3]) is float else _double(v)) <= -0.3726151734590531:  # node 3: landmark_0_dy
                    return 3  # down, leaf 4
                else:
                    return 1  # left, leaf 5
            else:
                if (v if type(v := x[3]) is float else _double(v)) <= -0.07367200031876565:  # node 6: landmark_0_dy
                    return 3  # down, leaf 7
                else:
                    return 2  # right, leaf 8
        else:
            if (v if type(v := x[4]) is float else _double(v)) <= 0.34498657286167145:  # node 9: landmark_1_dx
                if (v if type(v := x[3]) is float else _double(v)) <= -0.22133601456880572:  # node 10: landmark_0_dy
                    return 3  # down, leaf 11
                else:
                    return 2  # right, leaf 12
            else:
                if (v if type(v := x[5]) is float else _double(v)) <= -1.6050081849098208:  # node 13: landmark_1_dy
                    return 3  # down, leaf 14
                else:
                    return 2  # right, leaf 15
    else:
        if (v if type(v := x[2]) is float else _double(v)) <= 0.17827212065458295:  # node 16: landmark_0_dx
            if (v if type(v := x[2]) is float else _double(v)) <= -0.19378846138715744:  # node 17: landmark_0_dx
                if (v if type(v := x[3]) is float else _double(v)) <= 0.71113720536232:  # node 18: landmark_0_dy
                    return 1  # left, leaf 19
                else:
                    return 4  # up, leaf 20
            else:
                return 4  # up, leaf 21
        else:
            if (v if type(v := x[3]) is float else _double(v)) <= 0.34428112208843226:  # node 22: landmark_0_dy
                return 2  # right, leaf 23
            else:
                if (v if type(v := x[0]) is float else _double(v)) <= 0.8313309848308562:  # node 24: goal_dx
                    return 4  # up, leaf 25
                else:
                    return 2  # right, leaf 26


def act_agent_0_batch(x):
    """As act_agent_0, for the rows of an array."""
    import numpy as np

    x = _rows("agent_0", 10, x)
    actions = np.empty(len(x), dtype=np.int64)
    for start in range(0, len(x), 65536):  # so many that calls cost little, so few that caches hold them
        rows = x[start : start + 65536]
        x0, x2, x3, x4, x5 = _columns(rows, [0, 2, 3, 4, 5])
        actions[start : start + 65536] = _choose(
            x3 <= 0.03540378250181675,  # node 0: landmark_0_dy
            _choose(
                x2 <= 0.18323151022195816,  # node 1: landmark_0_dx
                _choose(
                    x2 <= -0.12809280306100848,  # node 2: landmark_0_dx
                    _choose(
                        x3 <= -0.3726151734590531,  # node 3: landmark_0_dy
                        3,  # down, leaf 4
                        1,  # left, leaf 5
                    ),
                    _choose(
                        x3 <= -0.07367200031876565,  # node 6: landmark_0_dy
                        3,  # down, leaf 7
                        2,  # right, leaf 8
                    ),
                ),
                _choose(
                    x4 <= 0.34498657286167145,  # node 9: landmark_1_dx
                    _choose(
                        x3 <= -0.22133601456880572,  # node 10: landmark_0_dy
                        3,  # down, leaf 11
                        2,  # right, leaf 12
                    ),
                    _choose(
                        x5 <= -1.6050081849098208,  # node 13: landmark_1_dy
                        3,  # down, leaf 14
                        2,  # right, leaf 15
                    ),
                ),
            ),
            _choose(
                x2 <= 0.17827212065458295,  # node 16: landmark_0_dx
                _choose(
                    x2 <= -0.19378846138715744,  # node 17: landmark_0_dx
                    _choose(
                        x3 <= 0.71113720536232,  # node 18: landmark_0_dy
                        1,  # left, leaf 19
                        4,  # up, leaf 20
                    ),
                    4,  # up, leaf 21
                ),
                _choose(
                    x3 <= 0.34428112208843226,  # node 22: landmark_0_dy
                    2,  # right, leaf 23
                    _choose(
                        x0 <= 0.8313309848308562,  # node 24: goal_dx
                        4,  # up, leaf 25
                        2,  # right, leaf 26
                    ),
                ),
            ),
        )
    return actions


def act_agent_1(x):
    """agent_1, team defenders: 14 leaves, at most 4 comparisons."""
    if (type(x) is not list and type(x) is not tuple) or len(x) != 10:
        x = _observation("agent_1", 10, x)
    if (v if type(v := x[4]) is float else _double(v)) <= 0.16405732184648514:  # node 0: landmark_1_dx
        if (v if type(v := x[5]) is float else _double(v)) <= -0.07031730189919473:  # node 1: landmark_1_dy
            if (v if type(v := x[4]) is float else _double(v)) <= -0.2575884312391281:  # node 2: landmark_1_dx
                if (v if type(v := x[5]) is float else _double(v)) <= -0.7288946211338044:  # node 3: landmark_1_dy
                    return 3  # down, leaf 4
                else:
                    return 1  # left, leaf 5
            else:
                if (v if type(v := x[5]) is float else _double(v)) <= -0.11643354222178459:  # node 6: landmark_1_dy
                    return 3  # down, leaf 7
                else:
                    return 4  # up, leaf 8
        else:
            if (v if type(v := x[4]) is float else _double(v)) <= -0.13324155658483505:  # node 9: landmark_1_dx
                if (v if type(v := x[5]) is float else _double(v)) <= 0.5304444730281829:  # node 10: landmark_1_dy
                    return 1  # left, leaf 11
                else:
                    return 4  # up, leaf 12
            else:
                if (v if type(v := x[5]) is float else _double(v)) <= 0.075681883841753:  # node 13: landmark_1_dy
                    return 0  # stay, leaf 14
                else:
                    return 4  # up, leaf 15
    else:
        if (v if type(v := x[5]) is float else _double(v)) <= 0.9964181482791901:  # node 16: landmark_1_dy
            if (v if type(v := x[4]) is float else _double(v)) <= 0.2698250561952591:  # node 17: landmark_1_dx
                if (v if type(v := x[5]) is float else _double(v)) <= -0.23646572977304461:  # node 18: landmark_1_dy
                    return 3  # down, leaf 19
                else:
                    return 2  # right, leaf 20
            else:
                if (v if type(v := x[3]) is float else _double(v)) <= 1.6769688725471497:  # node 21: landmark_0_dy
                    return 2  # right, leaf 22
                else:
                    return 4  # up, leaf 23
        else:
            if (v if type(v := x[0]) is float else _double(v)) <= 1.0369299054145813:  # node 24: goal_dx
                return 4  # up, leaf 25
            else:
                return 2  # right, leaf 26


def act_agent_1_batch(x):
    """As act_agent_1, for the rows of an array."""
    import numpy as np

    x = _rows("agent_1", 10, x)
    actions = np.empty(len(x), dtype=np.int64)
    for start in range(0, len(x), 65536):  # so many that calls cost little, so few that caches hold them
        rows = x[start : start + 65536]
        x0 = rows[:, 0]
        x3 = rows[:, 3]
        x4 = rows[:, 4].copy()
        x5 = rows[:, 5].copy()
        actions[start : start + 65536] = _choose(
            x4 <= 0.16405732184648514,  # node 0: landmark_1_dx
            _choose(
                x5 <= -0.07031730189919473,  # node 1: landmark_1_dy
                _choose(
                    x4 <= -0.2575884312391281,  # node 2: landmark_1_dx
                    _choose(
                        x5 <= -0.7288946211338044,  # node 3: landmark_1_dy
                        3,  # down, leaf 4
                        1,  # left, leaf 5
                    ),
                    _choose(
                        x5 <= -0.11643354222178459,  # node 6: landmark_1_dy
                        3,  # down, leaf 7
                        4,  # up, leaf 8
                    ),
                ),
                _choose(
                    x4 <= -0.13324155658483505,  # node 9: landmark_1_dx
                    _choose(
                        x5 <= 0.5304444730281829,  # node 10: landmark_1_dy
                        1,  # left, leaf 11
                        4,  # up, leaf 12
                    ),
                    _choose(
                        x5 <= 0.075681883841753,  # node 13: landmark_1_dy
                        0,  # stay, leaf 14
                        4,  # up, leaf 15
                    ),
                ),
            ),
            _choose(
                x5 <= 0.9964181482791901,  # node 16: landmark_1_dy
                _choose(
                    x4 <= 0.2698250561952591,  # node 17: landmark_1_dx
                    _choose(
                        x5 <= -0.23646572977304461,  # node 18: landmark_1_dy
                        3,  # down, leaf 19
                        2,  # right, leaf 20
                    ),
                    _choose(
                        x3 <= 1.6769688725471497,  # node 21: landmark_0_dy
                        2,  # right, leaf 22
                        4,  # up, leaf 23
                    ),
                ),
                _choose(
                    x0 <= 1.0369299054145813,  # node 24: goal_dx
                    4,  # up, leaf 25
                    2,  # right, leaf 26
                ),
            ),
        )
    return actions


ACT = {
    "adversary_0": act_adversary_0,
    "agent_0": act_agent_0,
    "agent_1": act_agent_1,
}
