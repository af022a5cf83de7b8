"""What no tree can say is refused with line, reason and way out; a hostile file ends soon, and nothing is run."""

import contextlib

import numpy as np
import pytest

from codegen.errors import InputError
from codegen.importers.python import machine
from codegen.importers.reading import Said
from codegen.importers.symbolic import paths
from tests.support.python_source import imported, nested, same

ACT = "def act(x):\n"
NUMPY = f"import numpy as np\n{ACT}"
MOVES = """from enum import Enum, IntEnum
class M(Enum):
    GO, STAY = 0, 1
class N(Enum):
    UP = 0
class P(IntEnum):
    GO = 0
class T(str, Enum):
    GO = "go"
"""
REFUSED = [
    (ACT + "    if x[0] < max(x[1], 1):\n        return 1\n    return 0\n", 2, "two features are compared: x[0] < max"),
    (ACT + "    if x[0] + x[1] < 1:\n        return 1\n    return 0\n", 2, "sums of features are computed"),
    (ACT + "    if max(x[0], 1) + x[1] < 1:\n        return 1\n    return 0\n", 2, "what is added is no sum"),
    (ACT + "    return [(x[0] - x[1]) / 1e-310, 1]\n", 2, "no sum of weighted features"),
    (ACT + "    if x[0] * x[1] < 1:\n        return 1\n    return 0\n", 2, "the product of two features"),
    (ACT + "    e = x[0] - x[1]\n    if e < 1:\n        return 1\n    return 0\n", 2, "sums of features are computed"),
    (ACT + "    if 1 / x[0] < 1:\n        return 1\n    return 0\n", 2, "a number is divided by a feature"),
    (ACT + "    if x[0] % 2 < 1:\n        return 1\n    return 0\n", 2, "mod of a feature"),
    (ACT + "    if x[0] * 0 < 1:\n        return 1\n    return 0\n", 2, "combined with 0"),
    (f"{ACT}    if x[0] < 2 + 0x{'f' * 5000}:\n        return 1\n    return 0\n", 2, "a number is too large"),
    (ACT + "    if x[-1] < 1:\n        return 1\n    return 0\n", 2, "x[-1] counts from the end"),
    (ACT + "    if x[0:2] < 1:\n        return 1\n    return 0\n", 2, "tuple and a int are compared"),
    (ACT + "    if x[0] in (1, 2):\n        return 1\n", 2, "a path ends without a return"),
    (ACT + "    if x[0] == 'a':\n        return 1\n    return 0\n", 2, "a feature is compared with a text"),
    (ACT + "    while x[0] < 1:\n        pass\n    return 0\n", 2, "a loop does not end"),
    (ACT + "    k = 0\n    while x[0] > k:\n        k += 1\n    return k\n", 3, "a loop goes on until a feature"),
    (ACT + "    v = max(x[0], 1e10)\n    while v > 1:\n        v = v - 1\n    return 0\n", 3, "in more than 256 steps"),
    (ACT + "    a += 1\n    return 0\n", 2, "'a' holds nothing"),
    (ACT + "    x[0] = 1\n    return 0\n", 2, "x[0] is set"),
    (ACT + "    b = [v + (1 if v > 0 else -1) for v in x]\n    return int(b[0] > 1)\n", 2, "how many features there"),
    (ACT + "    return 1 if [1.0, 2.0] @ x > 0 else 0\n", 2, "a product of arrays is computed, which NumPy adds in"),
    (ACT + "    return 1 if x[0] / 1e-310 - 1 > 0.2 - x[0] * 0.25 else 0\n", 2, "that are computed of one feature"),
    (ACT + "    return 1 if int(x[0]) % 2 else 0\n", 2, "mod of a feature is asked"),
    (NUMPY + "    return 1 if np.abs(int(x[0])) + 1 > 5 else 0\n", 3, "a whole number, as int() or"),
    (NUMPY + "    return 1 if np.clip(round(x[0]), 0, 9) * 2 > 5 else 0\n", 3, "is given to NumPy"),
    (NUMPY + "    return 1 if np.minimum(int(x[0]), -3) < -5 else 0\n", 3, "is given to NumPy"),
    (ACT + "    return 1 if sum([max(x[0], 3), 1]) > 4.2 else 0\n", 2, "sum() adds floats"),
    (ACT + "    del x[0]\n    return 0\n", 2, "'delete' is not understood"),
    (ACT + "    try:\n        return 1\n    except E:\n        return 0\n", 2, "'try' is not understood"),
    (ACT + "    if x[0] < 1:\n        return undefined(x)\n    return 0\n", 3, "the name 'undefined' is not defined"),
    (ACT + "    return print(x)\n", 2, "a path ends without a return, or returns None"),
    (ACT + "    return 0.3 * x[0]\n", 2, "sums of features are computed"),
    (ACT + "    return x\n", 2, "a feature decides without being compared"),
    (ACT + "    return None\n", 2, "a path ends without a return, or returns None"),
    (ACT + "    return int(x[0])\n", 2, "too many values"),
    (ACT + "    return {'a': 1}\n", 2, "is no label: a dictionary"),
    (ACT + "    return\n", None, "no function that takes an observation and returns"),
    (ACT + "    if x[0] > 0:\n        return 1\n", None, "a path ends without a return"),
    (ACT + "    if x[0] > 0:\n        a = 1\n    return a\n", 4, "'a' holds nothing on some path"),
    (ACT + "    return 1 if x[0] > 0 else 'go'\n", None, "side by side"),
    (ACT + "    return [1, 0] if x[0] > 0 else [1]\n", None, "side by side"),
    (ACT + "    return UP if x[0] > 0 else 'UP'\n", 2, "the name 'UP' is not defined"),
    ("def act(*x):\n    return 0\n", 1, "act takes * or **"),
    ("def act():\n    return 0\n", None, "no function that takes an observation"),
    ("@jit\ndef act(x):\n    return 0\n", 2, "the decorator 'jit' may change the function"),
    ("class Act:\n    pass\n", None, "no function that takes an observation"),
    ("from moves import *\ndef act(x):\n    return UP\n", 1, "may change what names stand for"),
    ("A = 1\n", None, "no function: put the rule into one"),
    ("for k in range(3):\n    print(k)\n", None, "no function: put the rule into one"),
    (ACT + "    if x[0] <\n", 2, "not Python"),
    (ACT + "\treturn 0\0\n", None, "not Python"),
    ("LIMIT = 3\ndef act(x):\n    return LIMIT.x\n", 3, "'.x' of a int is not understood"),
    (f"{ACT}    return 1 if x[0] <= -{'9' * 400} else 0\n", 2, "a whole number that no double equals"),
    (f"{ACT}    return 0x{'f' * 5000}\n", 2, "a number is too long for a name"),
    ("A = 3\ndef act(a, A):\n    if a * A < 1:\n        return 1\n    return 0\n", 3, "the product of two features"),
    (ACT + "    if x:\n        return 0\n    return 1 if x[0] < 1 else 2\n", 4, "as a number and as a list of numbers"),
    (ACT + "    if x[0] <= 1 or x['a'] < 1:\n        return 1\n", 2, "by numbers and by names"),
    ("Y = 1\ndef act(x: (Y := 3)):\n    return 1 if x[0] < Y else 0\n", 2, "may change what names stand for"),
    ("Y = 1\ndef act(x) -> f().g():\n    return 1 if x[0] < Y else 0\n", 2, "may change what names stand for"),
    ("Y = 1\nZ: (Y := 3) = 2\ndef act(x):\n    return 1 if x[0] < Y else 0\n", 2, "may change what names stand for"),
    ("def act(x, x):\n    return 1 if x < 1 else 0\n", 1, "not Python: duplicate argument 'x'"),
    ("from __future__ import nothing\ndef act(x):\n    return 1 if x < 1 else 0\n", 1, "not Python: future feature"),
    ("Y = 1\nglobals()['Y'] = 2\ndef act(x):\n    return 1 if x[0] < Y else 0\n", 2, "'globals' may change"),
    ("Y = 1\ndef act(x):\n    global Y\n    Y += 1\n    return 1 if x[0] < 1 else 0\n", 3, "is kept between calls"),
    ("N = 0\ndef more():\n    global N\n    N += 1\ndef act(x):\n    return 1 if x[0] < N else 0\n", 3, "may change"),
    ("SEEN = []\ndef act(x):\n    SEEN.append(1)\n    return len(SEEN) if x[0] > 0 else 0\n", 3, "outlives"),
    ("def act(x, seen=[]):\n    seen.append(1)\n    return len(seen) if x[0] > 0 else 0\n", 2, "outlives"),
    ("import random\ndef act(x):\n    return random.choice([1, 2])\n", 3, "a random number is drawn"),
    ("class A:\n    def __init__(self):\n        self.n = 0\n    def act(self, x):\n        self.n += 1\n"
     "        return 1 if self.n > x[0] else 0\n", 6, "what is remembered is compared with a feature"),
    (ACT + "    raise ValueError\n    return 0\n", 2, "an error is raised"),
    (ACT + "    return [1, 2][5] if x[0] > 0 else 0\n", 2, "list index out of range"),
    (ACT + "    return f(*x)\ndef f(a, b):\n    return a > b\n", 2, "f(*x) is not understood"),
    (ACT + "    a, *b = x[0:3]\n    return len(b) if a > 1 else 3\n", 2, "3 values are given to 2 names"),
    (ACT + "    return f'a{x[0] > 0}'\n", 2, "'joinedstr' is not understood"),
    (ACT + "    a = [1]\n    a += [2]\n    return a[1] if x[0] > 0 else 0\n", 3, "may have other names"),
    (ACT + "    return 1 if x[0].real > 0.5 else 0\n", 2, "'.real' of the observation is not understood"),
    (ACT + "    return 1 if x.get('a', 1.0) > 0.5 else 0\n", 2, "'.get' of the observation is not understood"),
    (ACT + "    return 1 if x['a']['b'] > 0.5 else 0\n", 2, "looked up within"),
    (ACT + "    return 1 if round(x[0], 1) > 0.5 else 0\n", 2, "round of a feature, or with further arguments"),
    (ACT + "    return 1 if (x[0] > 0.5) is True else 0\n", 2, "'is' compares what is no constant"),
    ("import random\ndef act(x):\n    return x[0] > 0 and random.random() > 0.5\n", 3, "a random number is drawn"),
    ("import numpy as np\ndef act(x):\n    return np.isnan(x[0])\n", 3, "numpy.isnan is not known"),
    ("import numpy as np\ndef act(x):\n    return np.deg2rad(int(x[0])) > 3\n", 3, "is given to NumPy: np.deg2rad"),
    ("def act(x):\n    return 1 if int(x[0]) * 9 / 2 > 3 else 0\n", 2, "fails where the feature is large: int(x[0])"),
    ("from enum import Enum\nclass M(Enum):\n    def _generate_next_value_(*a):\n        return 7\n    A = 1\n"
     "def act(x):\n    return M.A if x[0] > 0 else 3\n", 2, "_generate_next_value_ of the Enum M"),
    (ACT + "    return 1 if int(x[0]) // 2 > 1 else 0\n", 2, "floordiv of a feature is asked"),
    (ACT + "    return 1 if len([1]) + int(x[0]) // -3 > 1 else 0\n", 2, "floordiv of a feature is asked"),
    *(
        (f"{MOVES}def act(x):\n    return {one} if x[0] > 0 else {other}\n", None, "a member of an Enum is returned")
        for one, other in [
            ("M.GO", "0"), ("-0.0", "M.GO"), ("False", "[M.GO]"), ("N.UP", "M.GO"), ("P.GO", "0"), ("x[0]", "M.GO"),
            ("M.STAY", "[x[0]]"), ("[x[0] + 1.0]", "P.GO"), ("T.GO", "'go'"),
        ]
    ),
    ("class A:\n    def act(self, x):\n        return 1 if x[0] > 0 else 2\nunit = A()\n_own = unit\n"
     "def unit(*given):\n    return _own(*given)\n", 6, "unit takes * or **"),
    ("def act(x):\n    return x[0] > 0\n_own = act\ndef act(**given):\n    return not _own(**given)\n", 4, "act takes"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "line", "what"), REFUSED, ids=lambda each: each[:30] if isinstance(each, str) else "")
def test_what_is_not_understood_is_refused_with_its_line(text, line, what):
    with pytest.raises(InputError) as caught:
        imported(text)
    assert what in caught.value.what and caught.value.next_step
    assert line is None or caught.value.where.endswith(f"line {line}")


def test_a_null_byte_is_said_without_a_line():
    with pytest.raises(InputError) as caught:
        imported("def act(x):\n    return 0\0\n")
    assert "line" not in caught.value.where and "null" in caught.value.what


@pytest.mark.parametrize("test", ["x[0] < 1 and (x[0] < 2 or x[5] < 3)", f"x[0] < {'9' * 400}"])
def test_features_that_decide_nothing_and_long_numbers(test):
    same(f"def act(x):\n    if {test}:\n        return 1\n    return 0\n", said=Said(arrays="floats"))


DEEP = [
    "def act(x):\n    return " + "not " * 100_000 + "1\n",
    "def act(x):\n    return " + "-" * 100_000 + "1\n",
    "def act(x):\n    return " + "(" * 100_000 + "1" + ")" * 100_000 + "\n",
    "def act(x):\n    return " + "[" * 500 + "]" * 500 + "\n",
    "def act(x):\n    return a" + ".b" * 100_000 + "\n",
    "def act(x):\n    return 1" + " + 1" * 100_000 + "\n",
    "def act(x):\n    return " + "1 if x[0] > 0 else " * 20_000 + "1\n",
    "def act(x):\n    if x[0] < 0:\n        return 1\n" + "    elif x[0] < 0:\n        return 1\n" * 50_000,
    "def act(x):\n" + "".join(f"{' ' * (k + 1)}if x[0] > {k}:\n" for k in range(99)) + " " * 101 + "return 1\n",
]  # fmt: skip


@pytest.mark.parametrize("text", DEEP, ids=range(len(DEEP)))
def test_deep_nesting_is_an_error_in_words(text):
    with pytest.raises(InputError):
        imported(text)


def test_paths_do_not_multiply_without_end(monkeypatch):
    text = (
        "def act(x):\n    a = 0\n"
        + "".join(f"    if x[{k}] > 0:\n        a = {k}\n" for k in range(40))
        + "    return a\n"
    )
    monkeypatch.setattr(paths, "MAX_NODES", 1 << 12)
    with pytest.raises(InputError, match="more than"):
        imported(text)
    monkeypatch.setattr(paths, "MAX_STEPS", 10_000)
    with pytest.raises(InputError, match="too many paths"):
        imported(text)


HOSTILE = [
    "    return 10**10**10\n",
    "    return 2 << 10**9\n",
    "    return len('a' * 10**9)\n",
    "    a = [1]\n    for _ in range(99):\n        a = a + a\n    return len(a)\n",
    "    a = (1,)\n    for _ in range(99):\n        a = a + a\n    return len(a)\n",
    "    a = [1]\n    while True:\n        a.extend(a)\n    return 1\n",
    "    t, u = (1,), (1,)\n    for _ in range(99):\n        t, u = (t, t), (u, u)\n    return 1 if t == u else 0\n",
    "    c = x[0] > 0\n    for _ in range(99):\n        c = (c or c) and (c or c)\n    return 1 if c else 0\n",
    "    a = 'a'\n    for _ in range(99):\n        a = a.replace('a', 'aa')\n    return a\n",
    "    a = 'a'\n    for _ in range(99):\n        a = f'{a}{a}'\n    return a\n",
    "    for _ in range(10**9):\n        pass\n    return 1\n",
    "    return act(x)\n",
    "    return (lambda f: f(f))(lambda f: f(f))\n",
    "    a = []\n    a.append(a)\n    return 1 if a == [a] else 0\n",
    "    a = [1] * 60000\n    while True:\n        a = a[:]\n    return 1\n",
]


@pytest.mark.parametrize("text", HOSTILE, ids=range(len(HOSTILE)))
def test_a_hostile_file_ends_soon(text, monkeypatch):
    monkeypatch.setattr(paths, "MAX_STEPS", 50_000)
    monkeypatch.setattr(machine, "MAX_STEPS", 50_000)
    with pytest.raises(InputError):
        imported("def act(x):\n" + text)


def test_nothing_of_a_file_is_run(tmp_path):
    mark = tmp_path / "mark"
    for text in (
        f"import pathlib\npathlib.Path({str(mark)!r}).touch()\ndef act(x):\n    return 0\n",
        f"def act(x, y=open({str(mark)!r}, 'w')):\n    return 0\n",
        f"def act(x: open({str(mark)!r}, 'w')):\n    return 0\n",
        f"def act(x):\n    return open({str(mark)!r}, 'w')\n",
        f"A = open({str(mark)!r}, 'w')\ndef act(x):\n    return 0\n",
        f"import os\nif os.mkdir({str(mark)!r}):\n    pass\ndef act(x):\n    return 0\n",
    ):
        with contextlib.suppress(InputError):
            imported(text)
        assert not mark.exists()


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_a_large_file_is_read():
    bounds = dict.fromkeys(range(8), (-100.0, 100.0))
    text = "def act(x):\n" + "".join(nested(17, bounds, " ", np.random.default_rng(0)))
    profile = imported(text)
    assert text.count("\n") > 300_000 and len(profile.agents[0].tree.feature) > 200_000


def test_a_number_that_is_cut_before_it_is_added_is_told_how_to_be_written():
    cut = "    y = {}\n    return 1 if x[0] - 0.5 * y < 1 else 0\n"
    for each in ("min(x[1], 0.5)", "np.clip(x[1], -0.5, 0.5)"):
        with pytest.raises(InputError) as caught:
            imported(f"import numpy as np\n{ACT}{cut.format(each)}", Said(arrays="float64"))
        assert "y = low if x < low else high if x > high else x" in caught.value.next_step
    written = "-0.5 if x[1] < -0.5 else 0.5 if x[1] > 0.5 else x[1]"
    assert imported(ACT + cut.format(written), Said(arrays="float64")).agents[0].tree.sums
