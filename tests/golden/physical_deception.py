"""Decision tree policies of 3 agents for the world physical-deception. Generated: do not edit.

profile     d7c7e9951b353c845e3729dfb7383e9f94192c6dfd621196d4fd4879d989808d
made by     tests, hand-made, preset none, seed 0

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


def act_adversary_0(x):
    """adversary_0, team adversaries: 1 leaves, at most 0 comparisons."""
    if (type(x) is not list and type(x) is not tuple) or len(x) != 8:
        x = _observation("adversary_0", 8, x)
    return 0  # stay, leaf 0


def act_adversary_0_batch(x):
    """As act_adversary_0, for the rows of an array."""
    import numpy as np

    x = _rows("adversary_0", 8, x)
    return np.full(len(x), 0)


def act_agent_0(x):
    """agent_0, team defenders: 5 leaves, at most 3 comparisons."""
    if (type(x) is not list and type(x) is not tuple) or len(x) != 10:
        x = _observation("agent_0", 10, x)
    if (v if type(v := x[0]) is float else _double(v)) <= 0.09999999776482582:  # node 0: goal_dx
        if (v if type(v := x[3]) is float else _double(v)) <= 7.006492321624085e-46:  # node 1: landmark_0_dy
            return 1  # left, leaf 2
        else:
            return 2  # right, leaf 3
    else:
        if (v if type(v := x[9]) is float else _double(v)) <= -0.33333332836627966:  # node 4: agent_1_dy
            return 4  # up, leaf 5
        else:
            if (v if type(v := x[2]) is float else _double(v)) <= 3.4028235677973362e+38:  # node 6: landmark_0_dx
                return 0  # stay, leaf 7
            else:
                return 0  # stay, leaf 8


def act_agent_0_batch(x):
    """As act_agent_0, for the rows of an array."""
    import numpy as np

    x = _rows("agent_0", 10, x)
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
    if (type(x) is not list and type(x) is not tuple) or len(x) != 10:
        x = _observation("agent_1", 10, x)
    if (v if type(v := x[4]) is float else _double(v)) <= -0.04999999888241292:  # node 0: landmark_1_dx
        return 1  # left, leaf 1
    else:
        if (v if type(v := x[4]) is float else _double(v)) <= 0.0500000026077032:  # node 2: landmark_1_dx
            if (v if type(v := x[5]) is float else _double(v)) <= 7.006492321624085e-46:  # node 3: landmark_1_dy
                return 3  # down, leaf 4
            else:
                return 4  # up, leaf 5
        else:
            return 2  # right, leaf 6


def act_agent_1_batch(x):
    """As act_agent_1, for the rows of an array."""
    import numpy as np

    x = _rows("agent_1", 10, x)
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
