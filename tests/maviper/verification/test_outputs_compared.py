"""diff of agents that test sums or give numbers: the largest difference, beside samples and planted changes."""

import json
from dataclasses import replace

import numpy as np
import pytest

import maviper
from codegen import ir
from codegen.errors import InputError
from codegen.policy_json import dumps
from codegen.sums import Sum
from maviper.cli.main import run
from maviper.verification.compared import ranges
from tests.support import summed
from verify.result import Verdict

KINDS = [kind for kind in summed.every(1) if "two" not in kind and "no bounds" not in kind]


def pair(kind, seeds=(1, 7), levels=2):
    return tuple(summed.every(seed, levels=levels)[kind] for seed in seeds)


def sampled(policy, count=4_000):
    rng = np.random.default_rng(5)
    low, high = ranges(policy)
    rows = rng.uniform(low, high, (count, len(low)))
    return np.where(rng.random(rows.shape) < 0.3, np.where(rng.random(rows.shape) < 0.5, low, high), rows)


@pytest.mark.parametrize("kind", KINDS)
def test_no_sample_differs_more(kind):
    first, second = pair(kind)
    (one,), (other,) = first.agents, second.agents
    compared = maviper.diff(first, second)
    (agent,) = compared.agents
    assert compared.verdict is Verdict.VIOLATED and agent.searched.complete
    rows = sampled(one)
    if one.outputs:
        apart = np.abs(ir.outputs(one, rows).astype(float) - ir.outputs(other, rows).astype(float)).max(axis=0)
    else:
        apart = [float((ir.act(one, rows) != ir.act(other, rows)).any())]
    for each, most in zip(agent.searched.apart, apart, strict=True):
        assert each.found and each.most is not None
        assert most <= each.most * (1 + 1e-9) and most <= each.found.difference * (1 + 1e-2)
        seen = np.array([each.found.seen])
        said = ir.outputs if one.outputs else ir.act
        assert (said(one, seen) != said(other, seen)).any(), "what is told was replayed"


def changed(profile, *, by):
    """The profile with the first constant of a leaf another, and where."""
    (policy,) = profile.agents
    vectors = [list(vector) for vector in policy.tree.vectors]
    place, output = next(
        (row, column)
        for row, vector in enumerate(vectors)
        for column, each in enumerate(vector)
        if len(each.terms) == 1 and each.terms[0][1] == ir.CONSTANT and abs(each.terms[0][0]) < 0.9
    )
    value = vectors[place][output].terms[0][0]
    vectors[place][output] = Sum(((value + by, ir.CONSTANT),))
    tree = replace(policy.tree, vectors=tuple(map(tuple, vectors)))
    return summed.profile(replace(policy, tree=tree)), place, output


def test_a_planted_change_is_found_exactly():
    profile = summed.every(1, levels=3)["outputs, double sums"]
    other, place, output = changed(profile, by=0.03125)
    (agent,) = maviper.diff(profile, other).agents
    for column, each in enumerate(agent.searched.apart):
        assert (each.found is not None) == (column == output)
    found = agent.searched.apart[output].found
    assert found is not None and found.difference == 0.03125
    (policy,) = profile.agents
    assert int(policy.tree.action[found.leaves[0]]) == place


def test_the_same_trees_are_proved_alike_and_others_are_not_by_programs():
    profile = summed.every(1, levels=2)["outputs, double sums"]
    assert maviper.diff(profile, profile).verdict is Verdict.PROVED
    (policy,) = profile.agents
    wider = tuple(replace(output, high=1e30) for output in policy.outputs)
    narrow = tuple(replace(feature, low=0.0, high=0.0) for feature in policy.features)
    still = [summed.profile(replace(policy, features=narrow, outputs=each)) for each in (policy.outputs, wider)]
    assert maviper.diff(*still).verdict in (Verdict.UNKNOWN, Verdict.PROVED)


def test_boxes_alone_prove_constants_alike():
    arrays = ([0, -1, -1], [0.5, 0, 0], [1, -1, -1], [2, -1, -1], [-1, 0, 1])
    one = summed.policy(0, "float64", outputs=1, gives="float64")
    vectors = ((Sum(((0.25, ir.CONSTANT),)),), (Sum(((0.5, ir.CONSTANT),)),))
    tree = ir.Tree(*arrays, numbers="float64", arithmetic="float64", vectors=vectors, gives="float64")
    split = ([0, -1, 1, -1, -1], [0.5, 0, 0, 0, 0], [1, -1, 3, -1, -1], [2, -1, 4, -1, -1], [-1, 0, -1, 1, 1])
    longer = ir.Tree(*split, numbers="float64", arithmetic="float64", vectors=vectors, gives="float64")
    first, second = (summed.profile(replace(one, tree=each)) for each in (tree, longer))
    assert maviper.diff(first, second).verdict is Verdict.PROVED
    (ended,) = maviper.diff(first, second, max_cells=1).agents
    assert ended.verdict is Verdict.UNKNOWN and "a larger --effort" in ended.reason


def test_the_command_says_and_writes_it(tmp_path, capsys):
    profile = summed.every(1, levels=3)["outputs, double sums"]
    other, _, output = changed(profile, by=0.03125)
    for name, each in (("a.json", profile), ("b.json", other)):
        (tmp_path / name).write_text(dumps(each))
    out = tmp_path / "out"
    assert run(["diff", str(tmp_path / "a.json"), str(tmp_path / "b.json"), "-o", str(out)]) == 1
    said = capsys.readouterr().err
    assert f"u{output} by 0.03125 N, and by no more than 0.03125 by linear programs" in said
    document = json.loads((out / "difference.json").read_text())
    assert document["verdict"] == "VIOLATED" and document["agents"][0]["outputs"][output]["difference"] == 0.03125
    assert run(["diff", str(tmp_path / "a.json"), str(tmp_path / "a.json")]) == 0


def test_what_cannot_be_compared_is_said():
    acts, gives = (summed.every(1, levels=2)[f"{kind}, double sums"] for kind in ("actions", "outputs"))
    with pytest.raises(InputError, match="agent_0 has different actions in the two profiles"):
        maviper.diff(acts, gives)
    with pytest.raises(InputError, match="are compared over the ranges of their features"):
        maviper.diff(acts, acts, region="near.toml")
