"""If/else Python: what comes in acts as Python runs it, whatever else is refused with its line, and nothing is run."""

import math

import numpy as np
import pytest

from codegen import ir
from codegen.errors import InputError
from codegen.importers.reading import Said
from codegen.numbers import neighbour
from tests.support.python_source import called, imported, same

# --- what comes in


@pytest.mark.smoke
def test_every_form_of_an_observation():
    same("def act(obs):\n    if obs[0] > 0.1: return 1\n    return 0\n", label=int)
    profile = same(
        "def act(obs):\n    speed, gap = obs\n    if gap < 0.5 and speed > 0.1:\n        return 1\n    return 0\n",
        label=int,
    )
    assert [feature.name for feature in profile.agents[0].features] == ["speed", "gap"]
    text = "def act(speed, gap):\n    if speed <= gap_most:\n        return 1\n    return 0\ngap_most = 0.5\n"
    profile = same(text, label=int, spread=True)
    assert [feature.name for feature in profile.agents[0].features] == ["speed", "gap"]
    profile = same("def act(x):\n    return 1 if x > 0.5 else 0\n", label=int, spread=True)
    assert [feature.name for feature in profile.agents[0].features] == ["x"]
    text = "def act(obs):\n    v = obs['v']\n    if v > 0.1 or obs['gap'] == 0.5:\n        return 1\n    return 0\n"
    assert [feature.name for feature in imported(text).agents[0].features] == ["v", "gap"]


def test_numbers_may_have_several_signs():
    text = "A = -True\ndef act(x):\n    if x[0] <= --0.1 and x[1] < A:\n        return +True\n    return -(-2)\n"
    same(text, label=int)


def test_spellings_that_python_warns_of_are_read_without_a_word():
    imported("def act(x):\n    '\\d'\n    return 1 if x[0] < 1else 0\n")  # warnings are errors here


def test_variables_and_results_assigned_on_the_way():
    same(
        "def act(x):\n    limit = 0.5\n    v: float = x[1]\n    a = 0\n    if v > limit:\n        a = 1\n"
        "    if x[0]:\n        if not x[2] > 2:\n            a = 2\n    else:\n        pass\n    return a\n",
        label=int,
    )


@pytest.mark.parametrize(
    ("returned", "names"),
    [
        ("9 if {} else -2 if {} else 5", ["action_minus_2", "action_5", "action_9"]),
        ("0.5 if {} else -0.5 if {} else 1e2", ["action_minus_0_5", "action_0_5", "action_100_0"]),
        ("'wait' if {} else 'go left' if {} else 'b'", ["wait", "go_left", "b"]),
        ("True if {} else False if {} else True", ["False", "True"]),
    ],
)
def test_labels_keep_their_order_their_sign_and_their_text(returned, names):
    text = f"def act(x):\n    return {returned.format('x[0] > 0.1', 'x[1] <= 0.5')}\n"
    (policy,) = imported(text).agents
    assert [action.name for action in policy.actions] == names


def test_numbers_may_have_names():
    text = "STAY = 2\nGO = 1\nWAIT = 2\ndef act(x):\n    return STAY if x[0] > 0 else GO if x[1] > 0 else WAIT\n"
    (policy,) = imported(text).agents
    assert [action.name for action in policy.actions] == ["action_0", "GO", "STAY"]


@pytest.mark.parametrize(
    ("gain", "action", "name"),
    [
        ("2.0", "2", "action_2"),
        ("2", "2", "GAIN"),
        ("2.0", "GO", "GO"),
        ("2.0", "M.UP", "UP"),
        ("True", "1", "action_1"),
    ],
)
def test_a_gain_is_no_name_of_an_action(gain, action, name):
    text = f"from enum import Enum\nclass M(Enum):\n    UP = 2\nGAIN, GO = {gain}, 2\n"
    text += f"def act(x):\n    y = GAIN if x[0] > 1 else 1.5\n    return {action} if x[1] > y else 0\n"
    (policy,) = imported(text).agents
    assert policy.actions[-1].name == name


def test_a_local_of_the_same_name_names_no_action():
    text = "LIMIT = 0\ndef half():\n    LIMIT = 0.5\n    return LIMIT\n"
    (policy,) = imported(text + "def act(x):\n    return 0 if x[0] >= half() else 1\n").agents
    assert [action.name for action in policy.actions] == ["action_0", "action_1"]


def test_an_attribute_names_an_action_only_where_it_is_returned():
    text = "from dataclasses import dataclass\n@dataclass\nclass Policy:\n    gain: int = 0\n    stop: int = 1\n"
    text += "    def act(self, x):\n        y = x[1] if x[0] > 1 else self.gain\n"
    (policy,) = imported(text + "        return self.stop if y > 3 else 0\n").agents
    assert [action.name for action in policy.actions] == ["action_0", "action_1"]
    (policy,) = imported(text + "        if y > 3:\n            return self.stop\n        return 0\n").agents
    assert [action.name for action in policy.actions] == ["action_0", "stop"]


AROUND = """'A policy.'
'and a second text'
__all__ = ["drone"]
metadata: dict = {"algorithm": "PPO", "layers": (64, -64), "seeds": [1, +2], "tags": {"a", None}}
VERSION = NAME = "1"
LEFT, (RIGHT, up) = 0, (1, b"2")
limit: float
UNBOUNDED = 1e999
...
pass

def drone(x):
    "Decides."
    VERSION = 3
    if x[0] > 0.1:
        return VERSION
    return LEFT if x[0] < UNBOUNDED else RIGHT
"""


def test_what_stands_around_functions_is_computed():
    profile = same(AROUND, label=int)
    assert [policy.agent for policy in profile.agents] == ["drone"]


@pytest.mark.parametrize("odd", ["a = open('x')", "a = socket.socket()", "a = [f()]", "import b\na = b.c(1)[2]"])
def test_what_is_not_understood_around_functions_is_skipped_unless_a_decision_reads_it(odd):
    imported(f"{odd}\n{AROUND}")
    with pytest.raises(InputError) as caught:
        imported(f"{odd}\ndef act(x):\n    if x[0] > a:\n        return 1\n    return 0\n")
    assert "line" in caught.value.where and caught.value.next_step


def test_what_a_skipped_line_may_have_changed_is_not_read():
    for line in ("shuffle(TABLE)", "TABLE[:] = load()", "change()"):
        text = f"TABLE = [1, 2]\ndef change():\n    TABLE.append(3)\n    load()\n{line}\n"
        with pytest.raises(InputError):
            imported(text + "def act(x):\n    return TABLE[0] if x[0] > 0 else 0\n")


def test_a_list_of_scores_stands_for_the_place_of_its_largest():
    text = "def act(x):\n  if x[0] <= 0.5:\n    v = [0.25, 0.5, 0.25]\n  else:\n    v = [0.5, 0, 0.5]\n  return v\n"
    label, said = (lambda each: int(np.argmax(each)) if isinstance(each, list) else each), Said(scores=True)
    same(text, label=label, said=said)
    with pytest.raises(InputError, match="lists of 2 and 3 numbers"):
        imported("def act(x):\n    return [1, 0] if x[0] > 0 else [1, 0, 0]\n", said)


@pytest.mark.parametrize("action", ["[-0.87, 0.12]", "(1, 0)"])
def test_a_list_of_numbers_is_no_list_of_scores_by_itself(action):
    with pytest.raises(InputError, match=r"a list of \d numbers? is returned, which may be an action") as caught:
        imported(f"def act(x):\n    return {action} if x[0] > 0 else {action}\n")
    assert "--scores" in caught.value.next_step


@pytest.mark.smoke
def test_functions_are_agents():
    text = "def left(x):\n    return 0 if x[0] > 0 else 1\n\ndef right(a, b):\n    return 'go' if b > 2 else 'wait'\n"
    profile = imported(text)
    assert [policy.agent for policy in profile.agents] == ["left", "right"]
    assert [[f.name for f in policy.features] for policy in profile.agents] == [["x0"], ["a", "b"]]


@pytest.mark.parametrize(
    ("test", "kept"),
    [("x[0] <= 0.5", True), ("x[0] < 0.5", True), ("x[0] == 0.5", True), ("x[0] != 0.5", True), ("not x[0] <= 1", True),
     ("x[0] > 0.5", False), ("not x[0] >= 1", False), ("x[0] <= 0.5 or x[0] > 0.5", False),
     ("x[0] <= 2 and x[0] > 1", True), ("x[0]", True)],
)  # fmt: skip
def test_what_is_said_of_nan_is_so(test, kept):
    text = f"def act(x):\n    if {test}:\n        return 1\n    return 0\n"
    profile = imported(text)
    assert profile.provenance.training["act NaN"].startswith("decided as" if kept else "goes right")
    row = np.array([[np.nan]])
    said = profile.agents[0].actions[ir.act(profile.agents[0], row)[0]].name
    assert (said == f"action_{called(text, 'act')([math.nan])}") or not kept


# --- arrays of NumPy

MET = (0.1, 0.3, -0.1, 2, 0, 1e-3, 16777217, 1e-46, 2**60 + 2**36 + 1, 9007199254740993, -7.7e30, 1.1754944e-38)


@pytest.mark.parametrize("numbers", ["float32", "float64"])
@pytest.mark.parametrize("sign", ["<", "<=", ">", ">=", "==", "!="])
def test_arrays_decide_as_numpy_compares_them(numbers, sign):
    tests = "".join(f"    if x[0] {sign} {each!r}: return {place}\n" for place, each in enumerate(MET, 1))
    turned = "".join(
        f"    if {each!r} {sign} x[1] and not x[2]: return {place}\n" for place, each in enumerate(MET, 14)
    )
    text = f"def act(x):\n{tests}{turned}    return 0\n"
    profile = imported(text, Said(arrays=numbers))
    (policy,) = profile.agents
    assert policy.numbers == numbers and profile.provenance.training["act given"].startswith(f"{numbers} arrays")
    with np.errstate(over="ignore", under="ignore"):
        at = np.array([float(each) for each in MET]).astype(numbers)
        near = np.concatenate([at, neighbour(at, -np.inf, numbers), neighbour(at, np.inf, numbers), [np.inf, -np.inf]])
        rows = np.random.default_rng(0).choice(near, (2_000, 3)).astype(numbers)
        rows[:, 2] = np.where(np.arange(len(rows)) % 3, 0, rows[:, 2])
        act = called(text, "act")
        said = [act(row) for row in rows]
    assert [policy.actions[place].name for place in ir.act(policy, rows)] == [f"action_{each}" for each in said]


def test_the_same_test_decides_otherwise_for_floats_and_for_arrays():
    text = "def act(x):\n    return 1 if x[0] <= 0.1 else 0\n"
    row = np.array([[0.1]], dtype=np.float32)
    act = called(text, "act")
    assert (act(row[0]), act(row[0].tolist())) == (1, 0)
    floats, arrays = imported(text), imported(text, Said(arrays="float32"))
    assert [int(ir.act(each.agents[0], row)[0]) for each in (floats, arrays)] == [0, 1]
    assert floats.provenance.training["act given"] == "Python's floats, or float64 arrays"
    long = "def act(x):\n    return 1 if x[0] <= 9007199254740993 else 0\n"
    with pytest.raises(InputError, match="that no double equals"):
        imported(long)
    said = imported(long, Said(arrays="floats"))
    assert said.provenance.training["act given"] == "Python's floats"


CUT = ["max(x[0], 0.5)", "min(0.5, x[0])", "np.minimum(min(max(x[0], -9.81), -1.5), 3)", "abs(min(max(x[0], 1e-6), 2))",
       "np.clip(max(x[0], -4.35), -3, -2)", "max(x[0], 2)", "min(max(x[0], 0), 1.5) * 2"]  # fmt: skip


@pytest.mark.parametrize("cut", CUT)
@pytest.mark.parametrize("sign", ["==", "<", ">="])
@pytest.mark.parametrize("arrays", ["float32", "float64"])
def test_the_number_of_a_minimum_or_maximum_is_pythons_beside_numbers_of_arrays(cut, sign, arrays):
    """`max(x, 0.5)` gives Python's 0.5 where x is less, the array's number elsewhere: they meet 0.49999999999999994, or
    1e-6, as two types of numbers do.
    """
    kind = np.dtype(arrays).type
    at = np.array([0.5, -9.81, -1.5, -4.35, -3, -2, 1e-6, 0, 1, 1.5, 2, 2.5, 3, 1e10], kind)
    rows = np.concatenate([at, np.nextafter(at, kind(-np.inf)), np.nextafter(at, kind(np.inf))])[:, None]
    numbers = ("0.49999999999999994", "-4.35", "1e-6", "-3", "2", "0.30000000000000004")
    tests = "".join(f"    if {cut} {sign} {number}: n += {1 << k}\n" for k, number in enumerate(numbers))
    text = f"import numpy as np\n\ndef act(x):\n    n = 0\n{tests}    return n\n"
    policy, act = imported(text, Said(arrays=arrays)).agents[0], called(text, "act")
    decided = [policy.actions[place].name for place in ir.act(policy, rows)]
    assert decided == [f"action_{act(row)}" for row in rows]


@pytest.mark.parametrize("number", ["1e39", "-1e39", str(2**130), str(-(10**400))])
def test_a_number_beyond_the_type_of_the_arrays_is_refused(number):
    with pytest.raises(InputError, match="beyond float32") as caught:
        imported(f"def act(x):\n    return 1 if x[0] <= {number} else 0\n", Said(arrays="float32"))
    assert caught.value.where.endswith("line 2")
