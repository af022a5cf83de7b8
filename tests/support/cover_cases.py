"""Questions about covers whose answers hang on a single number, and faults to plant."""

from dataclasses import replace
from fractions import Fraction as F

import numpy as np

from tests.support.system_cases import box, form, policy, team
from verify.systems.claims import Pattern, SystemClaim
from verify.systems.system import Feature, Measure, Piece, System, Variable

PLAIN = ((0,), {})


def line(start, threshold, measure=Measure.VALUE, bounds=None, numbers="float32", **piece):
    """A number that an agent pushes up by 1 where a feature of it is at most a threshold."""
    feature = Feature(piece.pop("of", form(x=1)), measure, bounds)
    stated = {"where": {}, "move": {"x": form(x=1)}, "effect": {("a", "go"): {"x": form(1)}}, "error": {}} | piece
    variable = Variable("x", "1", (F(-9), F(9)))
    system = System("line", (variable,), {"a": {"f": feature}}, box(x=start), (Piece(**stated),), 3)
    one = policy("a", ["f"], ["go", "rest"], ((0, threshold), 0, 1))
    if numbers == "float64":
        one = replace(one, tree=replace(one.tree, threshold=np.array(one.tree.threshold, np.float64), numbers=numbers))
    return system, team(one)


def claimed(kind, steps, by=0, **bounds):
    return SystemClaim(Pattern(kind), (box(**bounds),), steps, by)


def tie(threshold):
    """Up to where float32 numbers round to at most a threshold."""
    near = np.float32(threshold)
    return (F(float(near)) + F(float(np.nextafter(near, np.float32(np.inf))))) / 2


HALF, TENTH = F(1, 2), {"x": form(F(1, 10), x=1)}
END = tie(0.5)  # 0.5 is even, so the tie belongs to it
NEAR = {"x": (F(-1), HALF)}
CASES = [  # (name, system and profile, claim, whether it holds)
    ("reaches its end", line((0, 1), -5.0), claimed("stays_in", 0, x=(0, 1)), True),
    ("goes beyond its end", line((0, 1), -5.0), claimed("stays_in", 0, x=(0, F(2**53 - 1, 2**53))), False),
    ("goes right alone", line((1, 2), 0.5), claimed("stays_in", 2, x=(1, 2)), True),
    ("goes left at the tie", line((END, END), 0.5), claimed("avoids", 1, x=(1, 2)), False),
    ("goes right beyond it", line((END + F(1, 2**50),) * 2, 0.5), claimed("avoids", 1, x=(1, 2)), True),
    ("goes both ways", line((0, 1), 0.5), claimed("reaches_and_stays", 1, 1, x=(HALF, 1 + END)), True),
    ("goes left once", line((0, 0), 0.5), claimed("reaches", 1, x=(1, 1)), True),
    ("is late", line((0, 0), 0.5), claimed("reaches", 1, x=(2, 2)), False),
    ("is there by then", line((0, 0), 0.5), claimed("reaches_and_stays", 3, 1, x=(1, 1)), True),
    ("is not there at first", line((0, 0), 0.5), claimed("reaches_and_stays", 3, 0, x=(1, 1)), False),
    ("moves by a tenth", line((0, 0), -5.0, move=TENTH), claimed("stays_in", 3, x=(0, F(31, 100))), True),
    ("by no less", line((0, 0), -5.0, move=TENTH), claimed("stays_in", 3, x=(0, F(29, 100))), False),
    ("doubles", line((-1, 1), -5.0, move={"x": form(x=2)}), claimed("stays_in", 1, x=(-2, 2)), True),
    ("more than that", line((-1, 1), -5.0, move={"x": form(x=2)}), claimed("stays_in", 1, x=(-2, F(3, 2))), False),
    ("turns", line((1, 2), -5.0, move={"x": form(x=-1)}), claimed("stays_in", 1, x=(-2, 2)), True),
    ("turns beyond", line((1, 2), -5.0, move={"x": form(x=-1)}), claimed("stays_in", 1, x=(-1, 2)), False),
    ("errs down", line((0, 0), -5.0, error={"x": (F(-1), F(0))}), claimed("stays_in", 1, x=(F(-1, 2), 1)), False),
    ("errs up", line((0, 0), -5.0, error={"x": (F(0), F(1))}), claimed("stays_in", 1, x=(-1, F(1, 2))), False),
    ("sign", line((0, 0), -0.5, Measure.SIGN), claimed("stays_in", 1, x=(0, 0)), True),
    ("negative sign", line((F(-1, 9),) * 2, -0.5, Measure.SIGN), claimed("stays_in", 1, x=(-1, 0)), False),
    ("clipped", line((3, 3), 2.0, Measure.CLIP, (F(0), F(1))), claimed("stays_in", 1, x=(3, 3)), False),
    ("turned test", line((1, 1), -0.5, of=form(x=-1)), claimed("stays_in", 1, x=(1, 1)), False),
    ("turned test, other side", line((0, 0), -0.5, of=form(x=-1)), claimed("stays_in", 1, x=(0, 0)), True),
    ("leaves what is stated", line((0, 0), 0.5, where=NEAR), claimed("stays_in", 2, x=(-1, 3)), False),
    ("stays where it is stated", line((0, 0), -5.0, where=NEAR), claimed("stays_in", 2, x=(-1, 3)), True),
]  # fmt: skip


def after(change):
    """A fault: a function whose answer is changed."""
    return lambda f: lambda *given: change(f(*given))
