"""Agents that compare float64: every target decides by the doubles themselves, alone and beside float32 agents."""

import subprocess
import sys
from dataclasses import replace
from itertools import product
from shutil import which

import numpy as np
import pytest

from codegen import ir
from codegen.agreement import probes, selfcheck, vectors
from codegen.agreement.compiled import build
from codegen.errors import InputError
from codegen.policy_json import dumps
from codegen.profiles import loads
from codegen.targets import SINGLE, TARGETS, emit
from tests.support.games import NAMES, doubled, random_profile
from tests.support.tiers import first_of

FEW = 500
TAKEN = [target for target in TARGETS if target not in SINGLE]
MIXED, ALL = "mixed", "all"


def profile_of(name, how):
    """A profile with float64 agents: all, or the first."""
    profile = random_profile(name)
    return doubled(profile, *([profile.agents[0].agent] if how == MIXED else []))


def walked(policy, row):
    """The action for one observation of doubles, by Python's own comparisons."""
    tree, node = policy.tree, 0
    while tree.feature[node] != ir.NO_FEATURE:
        left = row[tree.feature[node]] <= tree.threshold[node].item()
        node = int(tree.left[node] if left else tree.right[node])
    return int(tree.action[node])


@pytest.mark.parametrize("how", [ALL, MIXED])
def test_a_profile_comes_back_from_its_text(how):
    profile = profile_of(NAMES[1], how)
    text = dumps(profile)
    again = loads(text)
    assert dumps(again) == text
    for old, new in zip(profile.agents, again.agents, strict=True):
        assert old.numbers == new.numbers == new.tree.threshold.dtype
        assert old.tree.threshold.tobytes() == new.tree.threshold.tobytes()
    assert [policy.numbers for policy in again.agents].count("float32") == (0 if how == ALL else len(again.agents) - 1)


def test_the_reference_decides_doubles_beside_thresholds():
    policy = profile_of(NAMES[0], ALL).agents[1]
    rows = probes.boundary(policy.tree, policy.features, np.random.default_rng(0))
    assert rows.dtype == np.float64 and len(rows) > 100
    acted = ir.act(policy, rows)
    assert acted.tolist() == [walked(policy, row) for row in rows.tolist()]
    assert (acted != ir.act(policy, rows.astype(np.float32))).any()  # rounding first would decide otherwise


@pytest.mark.compile
@pytest.mark.parametrize(
    ("name", "style", "how"), first_of(3, product([NAMES[5], NAMES[3], NAMES[0]], ["nested", "walk"], [ALL, MIXED]))
)
def test_c_agrees(name, style, how, request):
    if name != NAMES[0]:  # one game is enough for an optimiser
        request.getfixturevalue("unoptimised")
        request.getfixturevalue("few_completions")
    profile = profile_of(name, how)
    files = emit(profile, ["c"], style=style)
    report = selfcheck.check_files(profile, files, random=FEW, style=style).ensure()
    assert {item.target for item in report.agreements} >= {"c", "c rows", "c columns", "c structure", selfcheck.TEAM}
    (header,) = files.values()
    assert "_act(const double *x)" in header


@pytest.mark.compile
@pytest.mark.parametrize(("name", "how"), first_of(1, [(NAMES[4], MIXED), (NAMES[0], ALL)]))
def test_every_target_that_takes_them_agrees(name, how, request):
    if (name, how) != (NAMES[0], ALL):
        request.getfixturevalue("unoptimised")
        request.getfixturevalue("few_completions")
    profile = profile_of(name, how)
    report = selfcheck.check_files(profile, emit(profile, TAKEN), random=FEW).ensure()
    found = {item.target for item in report.agreements}
    assert found >= {"c", "python", "python doubles", "python batch", "json", "json reader", "svg"}
    missing = {each.split(":")[0] for each in report.skipped}
    assert {"javascript", "rust", "onnx"} <= found or missing & {"mjs", "rs", "onnx"}


def test_nothing_speaks_of_float32_where_no_agent_compares_it():
    files = emit(profile_of(NAMES[0], ALL), [target for target in TAKEN if not target.startswith("onnx")])
    ended = {name.rpartition(".")[2]: text for name, text in files.items()}
    assert "both float64" in ended["svg"] and "`ordered`" not in ended["h"]
    assert not any("float32 of each feature" in ended[each] for each in ("py", "mjs"))


@pytest.mark.parametrize("threshold", [np.finfo(np.float64).max, -np.finfo(np.float64).max, 5e-324])
def test_thresholds_at_the_ends_of_the_doubles_agree(threshold):
    profile = profile_of(NAMES[2], ALL)
    policy = profile.agents[0]
    thresholds = np.where(policy.tree.threshold == 0, 0.0, threshold)  # warnings are errors here
    agents = (replace(policy, tree=replace(policy.tree, threshold=thresholds)), *profile.agents[1:])
    ended = replace(profile, agents=agents)
    selfcheck.check_files(ended, emit(ended, ["python", "json"]), random=FEW).ensure()


@pytest.mark.parametrize(
    ("target", "style"), [*((target, "auto") for target in ("smt", "st", "jax", "torch")), ("c", "ordered")]
)
def test_others_and_the_style_that_compares_bits_refuse_with_the_name_of_the_agent(target, style):
    profile = profile_of(NAMES[0], MIXED)
    with pytest.raises(InputError, match=f"{profile.agents[0].agent} compares float64"):
        emit(profile, [target], style=style)


@pytest.mark.compile
@pytest.mark.parametrize("how", first_of(1, [MIXED, ALL]))
@pytest.mark.parametrize(
    "target, command",
    [
        ("c", "gcc -std=c99 {}_test.c -o run && ./run"),
        ("python", f"{sys.executable} {{}}_test.py"),
        ("javascript", "node {}_test.mjs"),
        ("rust", "rustc --edition 2021 {}_test.rs -o run && ./run"),
    ],
)
def test_vectors_and_their_tests_run(target, command, how, tmp_path):
    if target != "python" and which(command.split()[0]) is None:
        pytest.skip(f"{command.split()[0]} is not installed")
    with build(profile_of(NAMES[0], how), [target]) as made:
        for name, text in {**made.files, **vectors.files(made, [target])}.items():
            (tmp_path / name).write_text(text)
        ran = subprocess.run(
            command.format(made.model.prefix), shell=True, cwd=tmp_path, capture_output=True, text=True, check=False
        )
    assert ran.returncode == 0 and ", 0 wrong" in ran.stdout, ran.stdout + ran.stderr
