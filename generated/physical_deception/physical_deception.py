"""Decision tree policies of 3 agents for the world physical-deception. Generated: do not edit.

profile     5d30e215800a19546299a607e3d5abdb7864ddeb9e9e5efbbf24f5d164b4cfc2
made by     maviper 0.3.0, maviper, preset default, seed 0

For each agent A: act_A(x) takes one observation (a sequence of numbers, or an array of one axis) and returns the
action's number, of which Action_A has the names; act_A_batch(x) takes an array [batch, n_features] and returns an array
of actions (needs numpy). finite_A(x) and in_range_A(x) check an observation, as float32.
An observation has a number for each name of FEATURES[A]; another length is a ValueError, a text or None where a number
is asked for a TypeError.

A world state w has a number for each name of COORDINATES. observe_A(w) is what A observes there, act_world_A(w) its
action, act_team(w) the actions of all AGENTS. An observation is made as the reference environment makes it: added in
double, then rounded to float32, to nearest.

A split goes left iff x[feature] <= threshold. A number of any type is a double first, rounded where it must be (an int
beyond 2**53, a Fraction, numpy's longdouble), then a float32: each threshold is written as the largest double that
rounds to a float32 not above it, so doubles decide as if they had been rounded to float32. NaN compares false and so
goes right; infinities follow <=. numpy's numbers next to zero are decided otherwise in a thread that takes subnormal
numbers for zero, which a library can set; numpy then warns when it is imported.
"""

from __future__ import annotations

from array import array
from enum import IntEnum
from math import isfinite
from typing import TYPE_CHECKING, Any, Callable, Dict, List, Optional, Sequence, Set, Tuple, Type, Union

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Numbers = Union[Sequence[Any], NDArray[Any]]

PROFILE = "5d30e215800a19546299a607e3d5abdb7864ddeb9e9e5efbbf24f5d164b4cfc2"
AGENTS = ("adversary_0", "agent_0", "agent_1",)
FEATURES: Dict[str, Tuple[str, ...]] = {
    "adversary_0": ("landmark_0_dx", "landmark_0_dy", "landmark_1_dx", "landmark_1_dy", "agent_0_dx", "agent_0_dy", "agent_1_dx", "agent_1_dy",),
    "agent_0": ("goal_dx", "goal_dy", "landmark_0_dx", "landmark_0_dy", "landmark_1_dx", "landmark_1_dy", "adversary_0_dx", "adversary_0_dy", "agent_1_dx", "agent_1_dy",),
    "agent_1": ("goal_dx", "goal_dy", "landmark_0_dx", "landmark_0_dy", "landmark_1_dx", "landmark_1_dy", "adversary_0_dx", "adversary_0_dy", "agent_0_dx", "agent_0_dy",),
}
ACTIONS: Dict[str, Tuple[str, ...]] = {
    "adversary_0": ("stay", "left", "right", "down", "up",),
    "agent_0": ("stay", "left", "right", "down", "up",),
    "agent_1": ("stay", "left", "right", "down", "up",),
}
# what each feature measures, a sum of coordinates or a function of one; None: nobody said
MEANINGS: Dict[str, Tuple[Optional[str], ...]] = {
    "adversary_0": (
        "landmark_0.x - adversary_0.x",
        "landmark_0.y - adversary_0.y",
        "landmark_1.x - adversary_0.x",
        "landmark_1.y - adversary_0.y",
        "agent_0.x - adversary_0.x",
        "agent_0.y - adversary_0.y",
        "agent_1.x - adversary_0.x",
        "agent_1.y - adversary_0.y",
    ),
    "agent_0": (
        "goal.x - agent_0.x",
        "goal.y - agent_0.y",
        "landmark_0.x - agent_0.x",
        "landmark_0.y - agent_0.y",
        "landmark_1.x - agent_0.x",
        "landmark_1.y - agent_0.y",
        "adversary_0.x - agent_0.x",
        "adversary_0.y - agent_0.y",
        "agent_1.x - agent_0.x",
        "agent_1.y - agent_0.y",
    ),
    "agent_1": (
        "goal.x - agent_1.x",
        "goal.y - agent_1.y",
        "landmark_0.x - agent_1.x",
        "landmark_0.y - agent_1.y",
        "landmark_1.x - agent_1.x",
        "landmark_1.y - agent_1.y",
        "adversary_0.x - agent_1.x",
        "adversary_0.y - agent_1.y",
        "agent_0.x - agent_1.x",
        "agent_0.y - agent_1.y",
    ),
}
# the least and largest float32 of each feature
RANGES: Dict[str, Tuple[Tuple[float, float], ...]] = {
    "adversary_0": (
        (-6.300000190734863, 6.300000190734863),
        (-6.300000190734863, 6.300000190734863),
        (-6.300000190734863, 6.300000190734863),
        (-6.300000190734863, 6.300000190734863),
        (-10.600000381469727, 10.600000381469727),
        (-10.600000381469727, 10.600000381469727),
        (-10.600000381469727, 10.600000381469727),
        (-10.600000381469727, 10.600000381469727),
    ),
    "agent_0": (
        (-6.300000190734863, 6.300000190734863),
        (-6.300000190734863, 6.300000190734863),
        (-6.300000190734863, 6.300000190734863),
        (-6.300000190734863, 6.300000190734863),
        (-6.300000190734863, 6.300000190734863),
        (-6.300000190734863, 6.300000190734863),
        (-10.600000381469727, 10.600000381469727),
        (-10.600000381469727, 10.600000381469727),
        (-10.600000381469727, 10.600000381469727),
        (-10.600000381469727, 10.600000381469727),
    ),
    "agent_1": (
        (-6.300000190734863, 6.300000190734863),
        (-6.300000190734863, 6.300000190734863),
        (-6.300000190734863, 6.300000190734863),
        (-6.300000190734863, 6.300000190734863),
        (-6.300000190734863, 6.300000190734863),
        (-6.300000190734863, 6.300000190734863),
        (-10.600000381469727, 10.600000381469727),
        (-10.600000381469727, 10.600000381469727),
        (-10.600000381469727, 10.600000381469727),
        (-10.600000381469727, 10.600000381469727),
    ),
}
# the direction in which each action pushes; None: it has none
EFFECTS: Dict[str, Tuple[Optional[Tuple[float, float]], ...]] = {
    "adversary_0": ((0.0, 0.0), (-1.0, 0.0), (1.0, 0.0), (0.0, -1.0), (0.0, 1.0),),
    "agent_0": ((0.0, 0.0), (-1.0, 0.0), (1.0, 0.0), (0.0, -1.0), (0.0, 1.0),),
    "agent_1": ((0.0, 0.0), (-1.0, 0.0), (1.0, 0.0), (0.0, -1.0), (0.0, 1.0),),
}
# what a unit action adds to a velocity per unit of time
FORCE: Dict[str, float] = {"adversary_0": 5.0, "agent_0": 5.0, "agent_1": 5.0}
DT = 0.1  # time of a step
DAMPING = 0.25  # the share of its velocity that an agent loses in a step
COORDINATES = (
    "adversary_0.x",  # read by adversary_0, agent_0, agent_1
    "adversary_0.y",  # read by adversary_0, agent_0, agent_1
    "agent_0.x",  # read by adversary_0, agent_0, agent_1
    "agent_0.y",  # read by adversary_0, agent_0, agent_1
    "agent_1.x",  # read by adversary_0, agent_0, agent_1
    "agent_1.y",  # read by adversary_0, agent_0, agent_1
    "landmark_0.x",  # read by adversary_0, agent_0, agent_1
    "landmark_0.y",  # read by adversary_0, agent_0, agent_1
    "landmark_1.x",  # read by adversary_0, agent_0, agent_1
    "landmark_1.y",  # read by adversary_0, agent_0, agent_1
    "goal.x",  # read by agent_0, agent_1
    "goal.y",  # read by agent_0, agent_1
    "adversary_0.vx",  # not read
    "adversary_0.vy",  # not read
    "agent_0.vx",  # not read
    "agent_0.vy",  # not read
    "agent_1.vx",  # not read
    "agent_1.vy",  # not read
)


class Action_adversary_0(IntEnum):
    """The actions of adversary_0."""

    STAY = 0
    LEFT = 1
    RIGHT = 2
    DOWN = 3
    UP = 4


class Action_agent_0(IntEnum):
    """The actions of agent_0."""

    STAY = 0
    LEFT = 1
    RIGHT = 2
    DOWN = 3
    UP = 4


class Action_agent_1(IntEnum):
    """The actions of agent_1."""

    STAY = 0
    LEFT = 1
    RIGHT = 2
    DOWN = 3
    UP = 4


_KINDS: Set[Any] = {float, int, bool}  # types whose values are numbers; others join them when they are met
_kind: Callable[[object], Type[object]] = type


def _double(value: Any, what: str = "an observation") -> float:
    """A number of an observation as a double, rounded where it is none; TypeError for what is no number."""
    whose = _kind(value)
    if whose not in _KINDS:
        kind = getattr(getattr(value, "dtype", None), "kind", "f")  # of numpy: texts, times, complex are no numbers
        number = hasattr(whose, "__float__") or hasattr(whose, "__index__")
        if not number or issubclass(whose, (str, bytes, complex)) or kind in "cmMSU" or getattr(value, "ndim", None):
            raise TypeError("%s is of numbers, not of %s %.40r" % (what, whose.__name__, value))
        if not hasattr(value, "__len__"):  # else it is an array, and another of its type may be no number
            _KINDS.add(whose)
    return float(value)


def _numbers(what: str, n: int, x: Any) -> Any:
    """What is given as a list or tuple of n; ValueError for another length, TypeError for what is no sequence."""
    try:
        values: Any = x.tolist()
    except AttributeError:
        values = x
    whose = _kind(values)
    if whose is list and len(values) == n and type(values[0]) is float:
        return values  # an array of one axis, as its first entry shows; asking for its shape would take longer
    shape, dtype = getattr(x, "shape", None), getattr(x, "dtype", None)
    texts = issubclass(type(x), (str, bytes, bytearray)) or getattr(dtype, "kind", "f") in "cmMSU"
    if texts or (shape is None and not hasattr(x, "__len__")):
        given = type(x).__name__ if dtype is None else "an array of %s" % dtype
        raise TypeError("%s %d numbers, given %s" % (what, n, given))
    shape = (len(x),) if shape is None else tuple(shape)
    if shape != (n,):
        given = shape[0] if len(shape) == 1 else "an array of shape %s" % (shape,)
        raise ValueError("%s %d numbers, given %s" % (what, n, given))
    return values if whose is list or whose is tuple else [x[index] for index in range(n)]


def _observed(what: str, n: int, x: Any) -> List[float]:
    """An observation as float32 numbers; errors as above."""
    return _singles([v if type(v) is float else _double(v) for v in _numbers(what, n, x)])


def _singles(values: Sequence[float]) -> List[float]:
    """Doubles rounded to float32, to nearest; beyond the largest float32 is infinity."""
    return array("f", values).tolist()


def _rows(agent: str, n: int, x: Any) -> NDArray[Any]:
    """Observations as an array of float32, [batch, n], each number a double first; errors as for one."""
    import numpy as np

    mask: Any = getattr(x, "mask", False)
    if not callable(mask) and np.any(mask):  # of a table, `mask` is a method
        raise TypeError("%s observes rows of %d numbers, and some of these are masked" % (agent, n))
    try:
        rows: NDArray[Any] = np.asarray(x)
    except ValueError as error:
        raise ValueError("%s observes rows of %d numbers: %s" % (agent, n, error)) from None
    rows = rows.reshape(0, n) if rows.shape == (0,) else rows
    if rows.ndim != 2 or rows.shape[1] != n:
        raise ValueError("%s observes rows of %d numbers, given an array of shape %s" % (agent, n, rows.shape))
    if rows.dtype == np.float32:
        return rows
    if rows.dtype.kind in "cmMSU":
        raise TypeError("%s observes rows of %d numbers, given an array of %s" % (agent, n, rows.dtype))
    if rows.dtype.kind in "OV":
        rows = np.array([_double(value) for row in rows.tolist() for value in row], dtype=np.float64).reshape(rows.shape)
    with np.errstate(over="ignore", invalid="ignore"):  # beyond the largest float32 is infinity
        if rows.dtype.kind != "f" or rows.dtype.itemsize > 8:
            rows = rows.astype(np.float64)
        return rows.astype(np.float32)


def _world(w: Numbers) -> List[float]:
    """The numbers of a world state as doubles; errors as for an observation."""
    numbers = _numbers("a world state has", 18, w)
    return [v if type(v) is float else _double(v, "a world state") for v in numbers]


def _choose(test: NDArray[Any], left: Any, right: Any) -> NDArray[Any]:
    """`left` where the test holds, else `right`; both are actions or arrays of them."""
    actions: NDArray[Any] = test.view("uint8")  # 1 or 0
    actions *= left ^ right  # the bits in which they differ
    actions ^= right
    return actions


def _act_adversary_0(x: List[float]) -> int:
    """As act_adversary_0, for what are floats, of which nothing is asked."""
    if x[2] <= -0.0064391575288027525:
        if x[3] <= 0.13947185128927228:
            if x[3] <= -0.23825404793024066:
                if x[2] <= -0.37345723807811737:
                    return 1
                else:
                    return 3
            else:
                if x[2] <= -0.19905591756105426:
                    return 1
                else:
                    return 3
        else:
            if x[0] <= 0.15405095368623734:
                return 1
            else:
                return 4
    else:
        if x[3] <= -0.48599298298358923:
            if x[2] <= 1.0840745568275452:
                return 3
            else:
                return 2
        else:
            if x[2] <= 0.38878388702869415:
                if x[3] <= 0.1654299423098564:
                    return 2
                else:
                    return 4
            else:
                if x[3] <= 0.8706751763820647:
                    return 2
                else:
                    return 4


def act_adversary_0(x: Numbers) -> int:
    """adversary_0, team adversaries: 12 leaves, at most 4 comparisons."""
    if (kind := type(x)) is not list and kind is not tuple:
        given: Any = x
        try:  # an array of one axis holds floats alone if the first is one
            if not given.dtype.hasobject and len(seen := given.tolist()) == 8 and type(seen[0]) is float:
                return _act_adversary_0(seen)
        except (AttributeError, TypeError):
            pass
        x = _numbers("adversary_0 observes", 8, x)
    elif len(x) != 8:
        x = _numbers("adversary_0 observes", 8, x)
    if (v if type(v := x[2]) is float else _double(v)) <= -0.0064391575288027525:  # node 0: landmark_1_dx
        if (v if type(v := x[3]) is float else _double(v)) <= 0.13947185128927228:  # node 1: landmark_1_dy
            if (v if type(v := x[3]) is float else _double(v)) <= -0.23825404793024066:  # node 2: landmark_1_dy
                if (v if type(v := x[2]) is float else _double(v)) <= -0.37345723807811737:  # node 3: landmark_1_dx
                    return 1  # left, leaf 4
                else:
                    return 3  # down, leaf 5
            else:
                if (v if type(v := x[2]) is float else _double(v)) <= -0.19905591756105426:  # node 6: landmark_1_dx
                    return 1  # left, leaf 7
                else:
                    return 3  # down, leaf 8
        else:
            if (v if type(v := x[0]) is float else _double(v)) <= 0.15405095368623734:  # node 9: landmark_0_dx
                return 1  # left, leaf 10
            else:
                return 4  # up, leaf 11
    else:
        if (v if type(v := x[3]) is float else _double(v)) <= -0.48599298298358923:  # node 12: landmark_1_dy
            if (v if type(v := x[2]) is float else _double(v)) <= 1.0840745568275452:  # node 13: landmark_1_dx
                return 3  # down, leaf 14
            else:
                return 2  # right, leaf 15
        else:
            if (v if type(v := x[2]) is float else _double(v)) <= 0.38878388702869415:  # node 16: landmark_1_dx
                if (v if type(v := x[3]) is float else _double(v)) <= 0.1654299423098564:  # node 17: landmark_1_dy
                    return 2  # right, leaf 18
                else:
                    return 4  # up, leaf 19
            else:
                if (v if type(v := x[3]) is float else _double(v)) <= 0.8706751763820647:  # node 20: landmark_1_dy
                    return 2  # right, leaf 21
                else:
                    return 4  # up, leaf 22


def act_adversary_0_batch(x: Numbers) -> NDArray[Any]:
    """As act_adversary_0, for the rows of an array."""
    import numpy as np

    x = _rows("adversary_0", 8, x)
    actions = np.empty(len(x), dtype=np.int64)
    for start in range(0, len(x), 65536):  # so many that calls cost little, so few that caches hold them
        rows = x[start : start + 65536]
        x0 = rows[:, 0]
        x2 = rows[:, 2].copy()
        x3 = rows[:, 3].copy()
        actions[start : start + 65536] = _choose(
            x2 <= -0.0064391575288027525,  # node 0: landmark_1_dx
            _choose(
                x3 <= 0.13947185128927228,  # node 1: landmark_1_dy
                _choose(
                    x3 <= -0.23825404793024066,  # node 2: landmark_1_dy
                    _choose(
                        x2 <= -0.37345723807811737,  # node 3: landmark_1_dx
                        1,  # left, leaf 4
                        3,  # down, leaf 5
                    ),
                    _choose(
                        x2 <= -0.19905591756105426,  # node 6: landmark_1_dx
                        1,  # left, leaf 7
                        3,  # down, leaf 8
                    ),
                ),
                _choose(
                    x0 <= 0.15405095368623734,  # node 9: landmark_0_dx
                    1,  # left, leaf 10
                    4,  # up, leaf 11
                ),
            ),
            _choose(
                x3 <= -0.48599298298358923,  # node 12: landmark_1_dy
                _choose(
                    x2 <= 1.0840745568275452,  # node 13: landmark_1_dx
                    3,  # down, leaf 14
                    2,  # right, leaf 15
                ),
                _choose(
                    x2 <= 0.38878388702869415,  # node 16: landmark_1_dx
                    _choose(
                        x3 <= 0.1654299423098564,  # node 17: landmark_1_dy
                        2,  # right, leaf 18
                        4,  # up, leaf 19
                    ),
                    _choose(
                        x3 <= 0.8706751763820647,  # node 20: landmark_1_dy
                        2,  # right, leaf 21
                        4,  # up, leaf 22
                    ),
                ),
            ),
        )
    return actions


def finite_adversary_0(x: Numbers) -> bool:
    """Whether every number of an observation is finite, as float32."""
    return all(isfinite(value) for value in _observed("adversary_0 observes", 8, x))


def in_range_adversary_0(x: Numbers) -> bool:
    """Whether every number of an observation is within its feature's range, as float32."""
    seen = _observed("adversary_0 observes", 8, x)
    return all(low <= value <= high for value, (low, high) in zip(seen, RANGES["adversary_0"]))


def observe_adversary_0(w: Numbers) -> List[float]:
    """What adversary_0 observes in a world state, float32 numbers."""
    w = _world(w)
    return _singles(
        (
            w[6] - w[0],  # landmark_0_dx
            w[7] - w[1],  # landmark_0_dy
            w[8] - w[0],  # landmark_1_dx
            w[9] - w[1],  # landmark_1_dy
            w[2] - w[0],  # agent_0_dx
            w[3] - w[1],  # agent_0_dy
            w[4] - w[0],  # agent_1_dx
            w[5] - w[1],  # agent_1_dy
        )
    )


def act_world_adversary_0(w: Numbers) -> int:
    """The action of adversary_0 in a world state."""
    return _act_adversary_0(observe_adversary_0(w))


def _act_agent_0(x: List[float]) -> int:
    """As act_agent_0, for what are floats, of which nothing is asked."""
    if x[3] <= -0.10019447281956674:
        if x[2] <= 0.2692345529794693:
            if x[2] <= -0.22723164409399033:
                if x[3] <= -0.6494716107845306:
                    return 3
                else:
                    return 1
            else:
                return 3
        else:
            if x[1] <= -0.5651094019412995:
                if x[0] <= 0.9510159194469451:
                    return 3
                else:
                    return 2
            else:
                return 2
    else:
        if x[2] <= 0.14005155116319656:
            if x[3] <= 0.13442102819681168:
                if x[2] <= -0.09999998286366464:
                    return 1
                else:
                    if x[2] <= 7.006492321624085e-46:
                        if x[3] <= -1.1754942807573643e-38:
                            return 3
                        else:
                            return 4
                    else:
                        return 2
            else:
                if x[2] <= -0.23842572420835495:
                    return 1
                else:
                    return 4
        else:
            if x[3] <= 0.40211997926235193:
                return 2
            else:
                if x[2] <= 0.7699067890644073:
                    return 4
                else:
                    return 2


def act_agent_0(x: Numbers) -> int:
    """agent_0, team defenders: 15 leaves, at most 6 comparisons."""
    if (kind := type(x)) is not list and kind is not tuple:
        given: Any = x
        try:  # an array of one axis holds floats alone if the first is one
            if not given.dtype.hasobject and len(seen := given.tolist()) == 10 and type(seen[0]) is float:
                return _act_agent_0(seen)
        except (AttributeError, TypeError):
            pass
        x = _numbers("agent_0 observes", 10, x)
    elif len(x) != 10:
        x = _numbers("agent_0 observes", 10, x)
    if (v if type(v := x[3]) is float else _double(v)) <= -0.10019447281956674:  # node 0: landmark_0_dy
        if (v if type(v := x[2]) is float else _double(v)) <= 0.2692345529794693:  # node 1: landmark_0_dx
            if (v if type(v := x[2]) is float else _double(v)) <= -0.22723164409399033:  # node 2: landmark_0_dx
                if (v if type(v := x[3]) is float else _double(v)) <= -0.6494716107845306:  # node 3: landmark_0_dy
                    return 3  # down, leaf 4
                else:
                    return 1  # left, leaf 5
            else:
                return 3  # down, leaf 6
        else:
            if (v if type(v := x[1]) is float else _double(v)) <= -0.5651094019412995:  # node 7: goal_dy
                if (v if type(v := x[0]) is float else _double(v)) <= 0.9510159194469451:  # node 8: goal_dx
                    return 3  # down, leaf 9
                else:
                    return 2  # right, leaf 10
            else:
                return 2  # right, leaf 11
    else:
        if (v if type(v := x[2]) is float else _double(v)) <= 0.14005155116319656:  # node 12: landmark_0_dx
            if (v if type(v := x[3]) is float else _double(v)) <= 0.13442102819681168:  # node 13: landmark_0_dy
                if (v if type(v := x[2]) is float else _double(v)) <= -0.09999998286366464:  # node 14: landmark_0_dx
                    return 1  # left, leaf 15
                else:
                    if (v if type(v := x[2]) is float else _double(v)) <= 7.006492321624085e-46:  # node 16: landmark_0_dx
                        if (v if type(v := x[3]) is float else _double(v)) <= -1.1754942807573643e-38:  # node 17: landmark_0_dy
                            return 3  # down, leaf 18
                        else:
                            return 4  # up, leaf 19
                    else:
                        return 2  # right, leaf 20
            else:
                if (v if type(v := x[2]) is float else _double(v)) <= -0.23842572420835495:  # node 21: landmark_0_dx
                    return 1  # left, leaf 22
                else:
                    return 4  # up, leaf 23
        else:
            if (v if type(v := x[3]) is float else _double(v)) <= 0.40211997926235193:  # node 24: landmark_0_dy
                return 2  # right, leaf 25
            else:
                if (v if type(v := x[2]) is float else _double(v)) <= 0.7699067890644073:  # node 26: landmark_0_dx
                    return 4  # up, leaf 27
                else:
                    return 2  # right, leaf 28


def act_agent_0_batch(x: Numbers) -> NDArray[Any]:
    """As act_agent_0, for the rows of an array."""
    import numpy as np

    x = _rows("agent_0", 10, x)
    actions = np.empty(len(x), dtype=np.int64)
    for start in range(0, len(x), 65536):  # so many that calls cost little, so few that caches hold them
        rows = x[start : start + 65536]
        x0 = rows[:, 0]
        x1 = rows[:, 1]
        x2 = rows[:, 2].copy()
        x3 = rows[:, 3].copy()
        actions[start : start + 65536] = _choose(
            x3 <= -0.10019447281956674,  # node 0: landmark_0_dy
            _choose(
                x2 <= 0.2692345529794693,  # node 1: landmark_0_dx
                _choose(
                    x2 <= -0.22723164409399033,  # node 2: landmark_0_dx
                    _choose(
                        x3 <= -0.6494716107845306,  # node 3: landmark_0_dy
                        3,  # down, leaf 4
                        1,  # left, leaf 5
                    ),
                    3,  # down, leaf 6
                ),
                _choose(
                    x1 <= -0.5651094019412995,  # node 7: goal_dy
                    _choose(
                        x0 <= 0.9510159194469451,  # node 8: goal_dx
                        3,  # down, leaf 9
                        2,  # right, leaf 10
                    ),
                    2,  # right, leaf 11
                ),
            ),
            _choose(
                x2 <= 0.14005155116319656,  # node 12: landmark_0_dx
                _choose(
                    x3 <= 0.13442102819681168,  # node 13: landmark_0_dy
                    _choose(
                        x2 <= -0.09999998286366464,  # node 14: landmark_0_dx
                        1,  # left, leaf 15
                        _choose(
                            x2 <= 7.006492321624085e-46,  # node 16: landmark_0_dx
                            _choose(
                                x3 <= -1.1754942807573643e-38,  # node 17: landmark_0_dy
                                3,  # down, leaf 18
                                4,  # up, leaf 19
                            ),
                            2,  # right, leaf 20
                        ),
                    ),
                    _choose(
                        x2 <= -0.23842572420835495,  # node 21: landmark_0_dx
                        1,  # left, leaf 22
                        4,  # up, leaf 23
                    ),
                ),
                _choose(
                    x3 <= 0.40211997926235193,  # node 24: landmark_0_dy
                    2,  # right, leaf 25
                    _choose(
                        x2 <= 0.7699067890644073,  # node 26: landmark_0_dx
                        4,  # up, leaf 27
                        2,  # right, leaf 28
                    ),
                ),
            ),
        )
    return actions


def finite_agent_0(x: Numbers) -> bool:
    """Whether every number of an observation is finite, as float32."""
    return all(isfinite(value) for value in _observed("agent_0 observes", 10, x))


def in_range_agent_0(x: Numbers) -> bool:
    """Whether every number of an observation is within its feature's range, as float32."""
    seen = _observed("agent_0 observes", 10, x)
    return all(low <= value <= high for value, (low, high) in zip(seen, RANGES["agent_0"]))


def observe_agent_0(w: Numbers) -> List[float]:
    """What agent_0 observes in a world state, float32 numbers."""
    w = _world(w)
    return _singles(
        (
            w[10] - w[2],  # goal_dx
            w[11] - w[3],  # goal_dy
            w[6] - w[2],  # landmark_0_dx
            w[7] - w[3],  # landmark_0_dy
            w[8] - w[2],  # landmark_1_dx
            w[9] - w[3],  # landmark_1_dy
            w[0] - w[2],  # adversary_0_dx
            w[1] - w[3],  # adversary_0_dy
            w[4] - w[2],  # agent_1_dx
            w[5] - w[3],  # agent_1_dy
        )
    )


def act_world_agent_0(w: Numbers) -> int:
    """The action of agent_0 in a world state."""
    return _act_agent_0(observe_agent_0(w))


def _act_agent_1(x: List[float]) -> int:
    """As act_agent_1, for what are floats, of which nothing is asked."""
    if x[4] <= 0.1652436926960945:
        if x[5] <= 0.19361948221921918:
            if x[4] <= -0.15348248928785324:
                if x[5] <= -0.4349673241376877:
                    return 3
                else:
                    return 1
            else:
                if x[5] <= -1.1754942807573643e-38:
                    return 3
                else:
                    if x[5] <= 0.09999999031424521:
                        if x[4] <= -1.1754942807573643e-38:
                            return 1
                        else:
                            return 2
                    else:
                        return 4
        else:
            if x[4] <= -0.31747297942638397:
                if x[5] <= 0.8244285285472869:
                    return 1
                else:
                    return 4
            else:
                return 4
    else:
        if x[5] <= 0.3676908463239669:
            if x[5] <= -0.6246292293071747:
                if x[4] <= 0.8667692244052887:
                    return 3
                else:
                    return 2
            else:
                if x[9] <= -1.4629243016242983:
                    if x[5] <= -1.1754942807573643e-38:
                        return 3
                    else:
                        return 2
                else:
                    return 2
        else:
            if x[4] <= 0.8280337750911712:
                if x[6] <= 0.6615903079509734:
                    return 4
                else:
                    return 2
            else:
                if x[5] <= 1.0113837122917173:
                    return 2
                else:
                    return 4


def act_agent_1(x: Numbers) -> int:
    """agent_1, team defenders: 18 leaves, at most 6 comparisons."""
    if (kind := type(x)) is not list and kind is not tuple:
        given: Any = x
        try:  # an array of one axis holds floats alone if the first is one
            if not given.dtype.hasobject and len(seen := given.tolist()) == 10 and type(seen[0]) is float:
                return _act_agent_1(seen)
        except (AttributeError, TypeError):
            pass
        x = _numbers("agent_1 observes", 10, x)
    elif len(x) != 10:
        x = _numbers("agent_1 observes", 10, x)
    if (v if type(v := x[4]) is float else _double(v)) <= 0.1652436926960945:  # node 0: landmark_1_dx
        if (v if type(v := x[5]) is float else _double(v)) <= 0.19361948221921918:  # node 1: landmark_1_dy
            if (v if type(v := x[4]) is float else _double(v)) <= -0.15348248928785324:  # node 2: landmark_1_dx
                if (v if type(v := x[5]) is float else _double(v)) <= -0.4349673241376877:  # node 3: landmark_1_dy
                    return 3  # down, leaf 4
                else:
                    return 1  # left, leaf 5
            else:
                if (v if type(v := x[5]) is float else _double(v)) <= -1.1754942807573643e-38:  # node 6: landmark_1_dy
                    return 3  # down, leaf 7
                else:
                    if (v if type(v := x[5]) is float else _double(v)) <= 0.09999999031424521:  # node 8: landmark_1_dy
                        if (v if type(v := x[4]) is float else _double(v)) <= -1.1754942807573643e-38:  # node 9: landmark_1_dx
                            return 1  # left, leaf 10
                        else:
                            return 2  # right, leaf 11
                    else:
                        return 4  # up, leaf 12
        else:
            if (v if type(v := x[4]) is float else _double(v)) <= -0.31747297942638397:  # node 13: landmark_1_dx
                if (v if type(v := x[5]) is float else _double(v)) <= 0.8244285285472869:  # node 14: landmark_1_dy
                    return 1  # left, leaf 15
                else:
                    return 4  # up, leaf 16
            else:
                return 4  # up, leaf 17
    else:
        if (v if type(v := x[5]) is float else _double(v)) <= 0.3676908463239669:  # node 18: landmark_1_dy
            if (v if type(v := x[5]) is float else _double(v)) <= -0.6246292293071747:  # node 19: landmark_1_dy
                if (v if type(v := x[4]) is float else _double(v)) <= 0.8667692244052887:  # node 20: landmark_1_dx
                    return 3  # down, leaf 21
                else:
                    return 2  # right, leaf 22
            else:
                if (v if type(v := x[9]) is float else _double(v)) <= -1.4629243016242983:  # node 23: agent_0_dy
                    if (v if type(v := x[5]) is float else _double(v)) <= -1.1754942807573643e-38:  # node 24: landmark_1_dy
                        return 3  # down, leaf 25
                    else:
                        return 2  # right, leaf 26
                else:
                    return 2  # right, leaf 27
        else:
            if (v if type(v := x[4]) is float else _double(v)) <= 0.8280337750911712:  # node 28: landmark_1_dx
                if (v if type(v := x[6]) is float else _double(v)) <= 0.6615903079509734:  # node 29: adversary_0_dx
                    return 4  # up, leaf 30
                else:
                    return 2  # right, leaf 31
            else:
                if (v if type(v := x[5]) is float else _double(v)) <= 1.0113837122917173:  # node 32: landmark_1_dy
                    return 2  # right, leaf 33
                else:
                    return 4  # up, leaf 34


def act_agent_1_batch(x: Numbers) -> NDArray[Any]:
    """As act_agent_1, for the rows of an array."""
    import numpy as np

    x = _rows("agent_1", 10, x)
    actions = np.empty(len(x), dtype=np.int64)
    for start in range(0, len(x), 65536):  # so many that calls cost little, so few that caches hold them
        rows = x[start : start + 65536]
        x4 = rows[:, 4].copy()
        x5 = rows[:, 5].copy()
        x6 = rows[:, 6]
        x9 = rows[:, 9]
        actions[start : start + 65536] = _choose(
            x4 <= 0.1652436926960945,  # node 0: landmark_1_dx
            _choose(
                x5 <= 0.19361948221921918,  # node 1: landmark_1_dy
                _choose(
                    x4 <= -0.15348248928785324,  # node 2: landmark_1_dx
                    _choose(
                        x5 <= -0.4349673241376877,  # node 3: landmark_1_dy
                        3,  # down, leaf 4
                        1,  # left, leaf 5
                    ),
                    _choose(
                        x5 <= -1.1754942807573643e-38,  # node 6: landmark_1_dy
                        3,  # down, leaf 7
                        _choose(
                            x5 <= 0.09999999031424521,  # node 8: landmark_1_dy
                            _choose(
                                x4 <= -1.1754942807573643e-38,  # node 9: landmark_1_dx
                                1,  # left, leaf 10
                                2,  # right, leaf 11
                            ),
                            4,  # up, leaf 12
                        ),
                    ),
                ),
                _choose(
                    x4 <= -0.31747297942638397,  # node 13: landmark_1_dx
                    _choose(
                        x5 <= 0.8244285285472869,  # node 14: landmark_1_dy
                        1,  # left, leaf 15
                        4,  # up, leaf 16
                    ),
                    4,  # up, leaf 17
                ),
            ),
            _choose(
                x5 <= 0.3676908463239669,  # node 18: landmark_1_dy
                _choose(
                    x5 <= -0.6246292293071747,  # node 19: landmark_1_dy
                    _choose(
                        x4 <= 0.8667692244052887,  # node 20: landmark_1_dx
                        3,  # down, leaf 21
                        2,  # right, leaf 22
                    ),
                    _choose(
                        x9 <= -1.4629243016242983,  # node 23: agent_0_dy
                        _choose(
                            x5 <= -1.1754942807573643e-38,  # node 24: landmark_1_dy
                            3,  # down, leaf 25
                            2,  # right, leaf 26
                        ),
                        2,  # right, leaf 27
                    ),
                ),
                _choose(
                    x4 <= 0.8280337750911712,  # node 28: landmark_1_dx
                    _choose(
                        x6 <= 0.6615903079509734,  # node 29: adversary_0_dx
                        4,  # up, leaf 30
                        2,  # right, leaf 31
                    ),
                    _choose(
                        x5 <= 1.0113837122917173,  # node 32: landmark_1_dy
                        2,  # right, leaf 33
                        4,  # up, leaf 34
                    ),
                ),
            ),
        )
    return actions


def finite_agent_1(x: Numbers) -> bool:
    """Whether every number of an observation is finite, as float32."""
    return all(isfinite(value) for value in _observed("agent_1 observes", 10, x))


def in_range_agent_1(x: Numbers) -> bool:
    """Whether every number of an observation is within its feature's range, as float32."""
    seen = _observed("agent_1 observes", 10, x)
    return all(low <= value <= high for value, (low, high) in zip(seen, RANGES["agent_1"]))


def observe_agent_1(w: Numbers) -> List[float]:
    """What agent_1 observes in a world state, float32 numbers."""
    w = _world(w)
    return _singles(
        (
            w[10] - w[4],  # goal_dx
            w[11] - w[5],  # goal_dy
            w[6] - w[4],  # landmark_0_dx
            w[7] - w[5],  # landmark_0_dy
            w[8] - w[4],  # landmark_1_dx
            w[9] - w[5],  # landmark_1_dy
            w[0] - w[4],  # adversary_0_dx
            w[1] - w[5],  # adversary_0_dy
            w[2] - w[4],  # agent_0_dx
            w[3] - w[5],  # agent_0_dy
        )
    )


def act_world_agent_1(w: Numbers) -> int:
    """The action of agent_1 in a world state."""
    return _act_agent_1(observe_agent_1(w))


def act_team(w: Numbers) -> List[int]:
    """The actions of all AGENTS in a world state."""
    return [act_world_adversary_0(w), act_world_agent_0(w), act_world_agent_1(w)]


# by agent: each function, the numbers of actions by their names
ACT: Dict[str, Callable[[Numbers], int]] = {
    "adversary_0": act_adversary_0,
    "agent_0": act_agent_0,
    "agent_1": act_agent_1,
}
ACT_BATCH: Dict[str, Callable[[Numbers], NDArray[Any]]] = {
    "adversary_0": act_adversary_0_batch,
    "agent_0": act_agent_0_batch,
    "agent_1": act_agent_1_batch,
}
FINITE: Dict[str, Callable[[Numbers], bool]] = {
    "adversary_0": finite_adversary_0,
    "agent_0": finite_agent_0,
    "agent_1": finite_agent_1,
}
IN_RANGE: Dict[str, Callable[[Numbers], bool]] = {
    "adversary_0": in_range_adversary_0,
    "agent_0": in_range_agent_0,
    "agent_1": in_range_agent_1,
}
OBSERVE: Dict[str, Callable[[Numbers], List[float]]] = {
    "adversary_0": observe_adversary_0,
    "agent_0": observe_agent_0,
    "agent_1": observe_agent_1,
}
ACT_WORLD: Dict[str, Callable[[Numbers], int]] = {
    "adversary_0": act_world_adversary_0,
    "agent_0": act_world_agent_0,
    "agent_1": act_world_agent_1,
}
