"""Trees with sums in every other language: the bits of the reference at ties, neighbours and numbers of every size."""

import re
from functools import cache

import pytest

from codegen.agreement import selfcheck
from codegen.agreement.compiled import Build
from codegen.errors import InputError
from codegen.lowering.lower import lower
from codegen.targets import emit
from tests.support import summed

RANDOM = 300


@cache
def team():
    return summed.together(1, levels=2, inner=0.3, over=0.3)


def replayed(profile, files):
    """The report about these files; skips where a tool is missing."""
    with Build(profile, lower(profile), files, optimised=False) as made:
        report = selfcheck.check(made, random=RANDOM)
    if report.skipped:
        pytest.skip(report.skipped[0])
    return report


@pytest.mark.compile
@pytest.mark.parametrize("target", ["javascript", "rust"])
def test_the_bits_of_the_reference(target):
    report = replayed(team(), emit(team(), [target])).ensure()
    assert {target, f"{target} rows", f"{target} constants"} <= {each.target for each in report.agreements}
    assert {each.agent for each in report.agreements} >= {policy.agent for policy in team().agents}


@pytest.mark.parametrize("target", ["jax", "torch", "onnx"])
def test_who_may_multiply_with_a_reciprocal_does_not_divide(target):
    profile = summed.every(1, levels=2, over=0.9)["outputs, float32 steps"]
    with pytest.raises(InputError, match="may round a quotient"):
        emit(profile, [target])
    assert replayed(profile, emit(profile, ["svg"])).ensure().agreements


def test_a_picture_shows_sums_bars_and_rules():
    text = emit(summed.every(1, levels=3)["outputs, double sums"], ["svg"])["sums_agent_0.svg"]
    assert ">x0 - x1</text>" in text and ">u0 = x0 - x4</text>" in text and ">u1 = 0.25</text>" in text
    assert "<title>node 12: left if" not in text and "<title>node 12: x3 &lt;= -1.55473</title>" in text
    bars = re.findall(r'width="([0-9.]+)" height="3" fill="#aa8844"', text)
    assert "66.0" in bars and "0.0" in bars, "0.25 is the middle of [-1, 1.5], and -1 its end"


FAULTS = [
    ("javascript", "outputs, float32 steps", "Math.fround(", "("),
    ("javascript", "double sums given as float32", "Math.fround(x[", "(x["),
    ("javascript", "outputs, double sums", "value > high ? high", "value > high ? low"),
    ("javascript", "outputs, float64", " - ", " + "),
    pytest.param("rust", "outputs, double sums", "f64::from(x[", "f64::from(2.0 * x[", marks=pytest.mark.slow),
    pytest.param("rust", "double sums given as float32", ") as f32", ") as f32 + 1.0", marks=pytest.mark.slow),
    ("rust", "outputs, float32 steps", "            low\n", "            high\n"),
    ("svg", "outputs, double sums", ':-1"', ':0"'),
]


@pytest.mark.compile
@pytest.mark.parametrize(("target", "kind", "right", "wrong"), FAULTS)
def test_planted_faults_are_found(target, kind, right, wrong):
    profile = summed.every(1)[kind]
    ((name, text),) = emit(profile, [target]).items()
    body = text.index({"rust": "pub fn act(", "javascript": "export function act_agent_0(", "svg": "<g"}[target])
    body = text.index("fn bounded(") if right.startswith("   ") else 0 if "value" in right else body
    assert right in text[body:]
    files = {name: text[:body] + text[body:].replace(right, wrong)}
    assert any(each.differences for each in replayed(profile, files).agreements)
