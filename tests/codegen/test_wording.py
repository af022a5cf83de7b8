"""Tests as people read them: what lies next to 0 is read as 0, with the sign that says on which side of it."""

import numpy as np
import pytest

from codegen import ir
from codegen.importers.origin import Names, profile_of
from codegen.importers.python.source import from_python
from codegen.lowering.lower import lower
from codegen.targets import TARGETS
from codegen.wording import TINY, fails, format_count, holds, number
from maviper.evaluation.show import rules
from verify.states.state import Step

CASES = [
    (0.1, "<= 0.1", "> 0.1"),
    (-0.5, "<= -0.5", "> -0.5"),
    (0.0, "<= 0", "> 0"),
    (-0.0, "<= 0", "> 0"),
    (-TINY, "< 0", ">= 0"),
    (-5e-324, "< 0", ">= 0"),
    (float(np.nextafter(np.float32(0), np.float32(-1))), "< 0", ">= 0"),
    (TINY, "<= 0", "> 0"),
    (float(np.nextafter(np.float32(19.5), np.float32(0))), "< 19.5", ">= 19.5"),
    (float(np.nextafter(np.float32(-19.5), np.float32(-20))), "< -19.5", ">= -19.5"),
    (float(np.nextafter(0.02, 0)), "< 0.02", ">= 0.02"),
    (float(np.float32(0.02)), "<= 0.02", "> 0.02"),
    (float(np.nextafter(0.123456, 0)), "<= 0.123456", "> 0.123456"),  # no number that people write
    (19.5, "<= 19.5", "> 19.5"),
    (1e300, "<= 1e+300", "> 1e+300"),
    (-2.4e-38, "<= -2.4e-38", "> -2.4e-38"),
]


@pytest.mark.parametrize(("threshold", "left", "right"), CASES)
def test_both_sides_of_a_test(threshold, left, right):
    assert (holds(threshold), fails(threshold)) == (left, right)


@pytest.mark.parametrize(
    ("threshold", "said"),
    [
        (23.25, "23.25"), (1400.0, "1400"), (1234.5678, "1235"), (0.030727, "0.030727"), (0.0307273124, "0.0307"),
        (float(np.float32(0.1)), "0.1"), (float(np.float32(12.345678)), "12.3"), (1e9, "1e+09"),
        (123456789.0, "1.23e+08"), (-2048.0, "-2048"),
    ],
)  # fmt: skip
def test_numbers_stay_as_people_write_them(threshold, said):
    assert number(threshold, digits=3) == said


@pytest.mark.parametrize(
    ("value", "threshold", "said"),
    [
        (-0.5, -TINY, "x = -0.5 < 0"),
        (0.5, -TINY, "x = 0.5 >= 0"),
        (0.0, -TINY, "x = 0 >= 0"),
        (-1e-40, -TINY, f"x = -1e-40 > {-TINY!r}"),
        (-TINY, -TINY, f"x = {-TINY!r} <= {-TINY!r}"),
        (0.0, 0.0, "x = 0 <= 0"),
        (0.1, 0.10000000149011612, "x = 0.1 <= 0.10000000149011612"),
        (0.5, 0.25, "x = 0.5 > 0.25"),
    ],
)
def test_a_step_of_a_decision_says_what_is_so(value, threshold, said):
    assert str(Step(0, "x", value, threshold, value <= threshold)) == said


def test_no_text_for_people_names_the_last_number_below_zero():
    text = b"def act(x):\n    if x[0] < 0: return 1\n    return 0 if x[1] < 0 else 2\n"
    for numbers in (None, "float32"):
        profile = profile_of(from_python(text, "act.py"), Names(), numbers)
        (policy,) = profile.agents
        assert [line.split("  ")[0] for line in rules(policy)] == [
            "if x0 < 0 -> action_1", "if x0 >= 0 and x1 < 0 -> action_0", "if x0 >= 0 and x1 >= 0 -> action_2",
        ]  # fmt: skip
        model = lower(profile)
        c, rust, svg = (next(iter(TARGETS[name](model, profile).values())) for name in ("c", "rust", "svg"))
        assert "node 0: < 0" in c and "node 0: < 0" in rust and "&lt; 0<" in svg
        assert "e-324" not in svg and "e-45" not in svg
        assert ir.act(policy, [[-1.0, 0], [0, -1], [0, 0]]).tolist() == [1, 0, 2]
    assert "below 0" in next(iter(TARGETS["c"](lower(profile, style="ordered"), profile).values()))


@pytest.mark.parametrize(
    ("count", "noun", "words"),
    [(1, "leaf", "1 leaf"), (2, "leaf", "2 leaves"), (0, "byte", "0 bytes"), (12_000, "branch", "12,000 branches")],
)
def test_a_count_agrees_with_its_noun(count, noun, words):
    assert format_count(count, noun) == words
