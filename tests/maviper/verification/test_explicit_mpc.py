"""A double integrator's explicit model predictive controller: imported as a tree of sums, it is the solution of its
quadratic programs; it is proved to come near the origin and to stay there.
"""

import json

import numpy as np
import pytest

from codegen import ir
from codegen.policy_json import dumps
from maviper.cli import main
from maviper.verification.files.certificates import check_file
from tests.support.explicit_mpc import WORLD, controller, prove_lasting, solved

CLAIMS = """[[property]]
label = "within its bounds"
formula = "out(cart).push <= 1.000001 and out(cart).push >= -1.000001"
[[property]]
label = "comes near, and stays"
name = "reaches_and_stays"
by = 8
region = { box = { x = [-0.1, 0.1], v = [-0.2, 0.2] } }
[[property]]
label = "nearer by then"
name = "reaches_and_stays"
by = 8
region = { box = { x = [-0.001, 0.001], v = [-0.002, 0.002] } }
"""


def test_the_tree_is_the_controller():
    """What the tree gives is the first control of the quadratic program, by a solver that shares nothing with it."""
    (policy,) = controller().agents
    assert len(ir.leaves(policy.tree)) == 10
    rows = np.random.default_rng(0).uniform((-4, -3), (4, 3), (200, 2))
    for row, push in zip(rows, ir.outputs(policy, rows)[:, 0].tolist(), strict=True):
        assert push == pytest.approx(solved(row), abs=1e-9)


@pytest.mark.slow
def test_it_is_proved_to_come_near_and_stay(tmp_path):
    profile = controller()
    (tmp_path / "cart.json").write_text(dumps(profile))
    (tmp_path / "world.toml").write_text(WORLD + CLAIMS)
    asked = ["verify", str(tmp_path / "cart.json"), "--system", str(tmp_path / "world.toml")]
    assert main.run([*asked, "--set", "max_boxes=300000", "-o", str(tmp_path / "out")]) == 1
    report = json.loads((tmp_path / "out" / "report.json").read_text())
    assert [result["verdict"] for result in report["results"]] == ["PROVED", "PROVED", "VIOLATED"]
    for path in (tmp_path / "out").glob("certificate-*.json"):
        assert check_file(path).closed > 0


def test_it_is_proved_to_stay_for_ever(tmp_path):
    """The region that is proposed bounds the roundings too, which nobody has to name."""
    assert check_file(prove_lasting(tmp_path)).closed > 0
