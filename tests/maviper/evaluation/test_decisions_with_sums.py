"""One decision of a tree with sums, and its picture, as a person asks for them."""

import re

import numpy as np

from codegen import ir
from codegen.policy_json import dumps
from maviper.cli.main import run
from maviper.evaluation import show
from tests.support import summed

KINDS = summed.every(1, levels=3)


def test_show_explains_what_is_given_and_each_sum(tmp_path, capsys):
    file = tmp_path / "profile.json"
    file.write_text(dumps(KINDS["outputs, double sums"]))
    assert run(["show", str(file), "--obs", "0.5,-1,0.25,1,0"]) == 0
    assert capsys.readouterr().out.splitlines() == [
        "agent_0, team team: u0 = 0.25 N, u1 = -1 N, u2 = -1 N (leaf 4)",
        "  x4 = 0 <= 0.345584, by 0.346",
        "  0 + x1 + x0 = -0.5 <= 0, by 0.5",
        "  x2 = 0.25 > 0.1, by 0.15",
        "  u0 = 0.25, cut to [-1, 1.5]",
        "  u1 = -1, cut to [-1, 1.5]",
        "  u2 = -3e+38 x3 - 3e+38 x2 - 0, cut to [-1, 1.5]",
    ]


def test_decisions_are_those_of_the_reference():
    for profile in KINDS.values():
        for policy in profile.agents:
            rows = np.random.default_rng(0).uniform(-3, 3, (20, len(policy.features))).astype(policy.numbers)
            for row, leaf in zip(rows, ir.apply(policy.tree, rows).tolist(), strict=True):
                first = next(show.lines(policy, row))
                assert first.endswith(f"(leaf {leaf})")
                if policy.outputs:
                    (given,) = ir.outputs(policy, row[None]).tolist()
                    said = [float(each) for each in re.findall(r"u\d = (\S+) N", first)]
                    assert said == [float(f"{value:.6g}") for value in given]
                else:
                    assert policy.actions[int(ir.act(policy, row[None])[0])].name in first


def test_a_profile_with_sums_has_a_picture(tmp_path):
    file, picture = tmp_path / "profile.json", tmp_path / "trees.svg"
    file.write_text(dumps(KINDS["agents of two kinds"]))
    assert run(["show", str(file), "--format", "svg", "-o", str(picture)]) == 0
    text = picture.read_text()
    assert "agent_0, team team" in text and "agent_1, team team" in text and 'class="bar"' in text
