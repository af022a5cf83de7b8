"""What is easily misread in Python means the same after the import: each function is compared with Python's own run."""

import numpy as np
import pytest

from codegen import ir
from codegen.importers.reading import Said
from tests.support.python_source import called, imported, same

NUMBERS = (0.1, 0.25, 0.5, -0.5, 1, 2, 3, -1, 0, 70, 80, 60)
BODIES = {
    "print assigns": "print(v := x[0])\n    return 1 if v > 0.5 else 0",
    "closures see the last value": "f = [lambda v: v > k for k in (1, 2)]\n    return 1 if f[0](x[0]) else 0",
    "a closure sees what follows": "def f():\n        return y\n    y = x[0]\n    if y > 1:\n        return 3\n"
    "    y = 7\n"
    "    return f() if x[1] > 0 else 1",
    "lists are shared": "a = []\n    b = a\n    if x[0] > 0:\n        b.append(1)\n    if x[1] > 0:\n"
    "        a.append(2)\n    return len(b)",
    "a loop's else and break": "for v in (x[0], x[1]):\n        if v < 0.25:\n            continue\n"
    "        if v > 2:\n"
    "            break\n    else:\n        return 9\n    return 1 if v > 3 else 2",
    "and gives its operand": "return (x[0] > 0.5 and 'left') or (x[1] > 1 and 'right') or 'stay'",
    "conditions are numbers": "return (x[0] > 0) + 2 * (x[1] > 1) - (x[2] <= 0.5)",
    "a condition that is kept is turned": "far = not x[0] > 0.5\n    return 1 if far and x[1] > 1 else 2",
    "conditions are compared": "return 1 if (x[0] > 0) == (x[1] > 0) else 2 if (x[0] > 1) ^ (x[2] > 1) else 3",
    "a chain asks only what it must": "return 1 if 0 < x[0] <= 2 < x[1] != 3 else 0",
    "whole numbers": "k = int(min(max(x[0], -1), 2))\n    return (5, 6, 7)[k] + (round(min(max(x[1], -5), 5)) == 2)",
    "floor and truncation": "import math\n    a, b, c = [min(max(v, -9), 9) for v in x]\n"
    "    return math.floor(a) == -1, int(b) == 0, round(c) <= 0",
    "the least and the largest": "return 1 if min(x[0], x[1]) > 0.1 else 2 if max(abs(x[1]), -x[2], 0.25) <= 1 "
    "else 3",
    "squares": "return 1 if x[0] * x[0] < 0.5 else 2 if (x[1] - 1) * (x[1] - 1) <= 0.25 else 3",
    "rounding on the way": "return 1 if (x[0] - 0.1) / 3 * 7 >= 0.3 else 2 if 1 - x[1] * -0.1 < 1.1 else 3",
    "match": "match (x[0] > 0.5, x[1] > 1):\n        case (True, True):\n            return 1\n"
    "        case (False, _):\n"
    "            return 2\n        case _ if x[2] > 0:\n            return 3\n    return 4",
    "generators stop early": "k = 0\n    while k < 3 and not any(x[0] < t for t in ((0.1,), (0.5,), (2,))[k]):\n"
    "        k += 1\n    return k + sum(v > 1 for v in (x[1], x[2]))",
    "names of a slice": "a, _, c = x[0:3]\n    return c > 0.25 if a > 1 else (1, 3)[x[1] > 0]",
    "is it NaN": "return 0 if x[0] != x[0] else 1 if x[1] > 0.1 else 2",
    "conditions are whole numbers": "return (x[0] > 0) | (x[1] > 1) << 1 | ((x[2] > 0.5) & 3) << 2",
    "or and and of conditions": "return 1 if (x[0] > 0) & (x[1] > 1) | (x[2] > 2) else 2 if (x[0] > 2) | 0 else 3",
    "a list within a list": "return [[4.0]] if x[0] > 0.5 else [[2.0]]",
    "a list grows": "s = [1]\n    if x[0] > 0:\n        s.append(2)\n    s.append(3)\n    return s[-1] * 10 + len(s)",
    "a name of the file": "return 1 if x[0] > LIMIT and [LIMIT for _ in range(2)][1] == 0.5 else 2",
    "sets and dictionaries": "d = {'a': 1, 'b': 2}\n"
    "    return d['a' if x[0] in {0.1, 0.5} else 'b'] + d.get(x[1] > 0, 4)",
    "numpy on a list": "import numpy as np\n    o = np.asarray(x)\n"
    "    return 1 if o[0] * 2 - 1 > 0 else int(np.clip(o[1], -1, 2)) + 3",
    "numpy in float32": "import numpy as np\n    o = np.array(x, dtype=np.float32)\n"
    "    return 1 if o[0] <= 0.1 else 2 if o[1] * 3 > 0.3 else 3",
}  # fmt: skip


def chosen(given):
    """The place of the largest of a tuple of scores, and the number of a list of one."""
    while isinstance(given, list):
        (given,) = given
    return given.index(max(given)) if isinstance(given, tuple) else given


@pytest.mark.parametrize("name", BODIES)
def test_a_function_decides_as_python(name, capsys):
    text = f"LIMIT = 0.5\ndef act(x):\n    x[0:3]\n    {BODIES[name]}\n"
    said = Said(features=("a", "b", "c"), scores=True, arrays="floats")
    same(text, NUMBERS, label=chosen, said=said)


@pytest.mark.parametrize("numbers", ["float32", "float64"])
def test_arithmetic_on_arrays_is_that_of_numpy(numbers):
    text = (
        "def act(x):\n    if x[0] * 3 > 0.3:\n        return 1\n    if float(x[1]) * 3 > 0.3:\n        return 2\n"
        "    if abs(x[2] - 0.1) < 0.2:\n        return 3\n    return 4 if x[0] / 3 + 1 <= 0.9 else 5\n"
    )
    (policy,) = imported(text, Said(arrays=numbers)).agents
    at = np.array([0.1, 0.3, -0.1, -0.3], dtype=numbers)
    near = np.concatenate([at, np.nextafter(at, at.dtype.type(9)), np.nextafter(at, at.dtype.type(-9))])
    rows = np.random.default_rng(0).choice(near, (3_000, 3)).astype(numbers)
    wanted = [called(text, "act")(row) for row in rows]
    assert ir.act(policy, rows).tolist() == wanted and len(set(wanted)) > 3


ENUM = """
from enum import Enum
class Mode(str, Enum):
    A = "a"
    B = "b"
def act(x):
    m = Mode.A if x[0] > 0.1 else Mode.B
    return 1 if m == "a" else 2
"""
OBJECTS = """
from dataclasses import dataclass, field
@dataclass
class Rule:
    place: int
    test: object
    action: str
@dataclass
class Rules:
    rules: list = field(default_factory=list)
    def act(self, x):
        for r in self.rules:
            if r.test(x[r.place]):
                return r.action
        return "stay"
act = Rules([Rule(0, lambda v: 0.5 < v, "up"), Rule(1, lambda v: v <= -0.5, "down")]).act
def other(x):
    return act(x)
"""


def test_members_of_a_text_enum_are_texts():
    same(ENUM, NUMBERS, label=int)


def test_numbers_are_called_as_in_the_class():
    text = (
        "class Cart:\n    LEFT = 0\n    RIGHT = 2\n    def act(self, x):\n        if x[0] > 0: return self.RIGHT\n"
        "        return Cart.LEFT\n"
    )
    (policy,) = imported(text).agents
    assert [each.name for each in policy.actions] == ["LEFT", "action_1", "RIGHT"]


def test_rules_as_objects():
    profile = imported(OBJECTS)
    assert [each.agent for each in profile.agents] == ["other"]
    rows = np.random.default_rng(0).choice([0.5, np.nextafter(0.5, 1), -0.5, np.nextafter(-0.5, 0)], (200, 2))
    (policy,) = profile.agents
    wanted = [called(OBJECTS, "other")(row) for row in rows.tolist()]
    assert [policy.actions[k].name for k in ir.act(policy, rows)] == wanted


def test_a_set_is_asked_what_it_holds():
    text = "DAYS = {5, 6}\ndef act(x):\n    return 1 if x[0] in DAYS else 2 if x[1] not in {0, 4} else 0\n"
    same(text, (5, 6, 0, 4), label=int)
