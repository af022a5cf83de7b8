"""A double integrator's explicit model predictive controller: imported as a tree of sums, it is the solution of its
quadratic programs; it is proved to come near the origin and to stay there.
"""

import json
from fractions import Fraction

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from codegen import ir
from codegen.policy_json import dumps
from maviper.cli import main
from maviper.verification.files.certificates import check_file
from tests.support.explicit_mpc import WORLD, Problem, controller, prove_lasting

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


def test_the_forms_are_those_of_the_quadratic_program():
    """The gradient of the whole cost, by differences of exact costs."""
    problem = Problem(3)
    h, f = problem.quadratic()

    def cost(state, controls):
        (x, v), total = state, Fraction(0)
        for step, push in enumerate(controls, 1):
            x, v = x + problem.dt * v + problem.dt**2 / 2 * push, v + problem.dt * push
            weight = problem.last if step == problem.horizon else 1
            total += problem.effort * push**2 + weight * (x**2 + problem.speed * v**2)
        return total

    state, controls = (Fraction(3, 7), Fraction(-2, 5)), [Fraction(1, 3), Fraction(-1, 4), Fraction(2, 9)]
    for at in range(3):
        ends = [cost(state, [push + sign * (other == at) for other, push in enumerate(controls)]) for sign in (1, -1)]
        slope = (ends[0] - ends[1]) / 2  # exact, of a quadratic function
        rows = sum(h[at][other] * push for other, push in enumerate(controls))
        assert slope == rows + sum(f[part][at] * state[part] for part in range(2))


@pytest.mark.parametrize(("horizon", "leaves"), [(2, 10), (3, 27)])
def test_the_tree_is_the_controller(horizon, leaves):
    """What the tree gives is the first control of the quadratic program, by a solver that shares nothing with it."""
    problem, profile = controller(horizon)
    (policy,) = profile.agents
    assert len(ir.leaves(policy.tree)) == leaves
    h, f = (np.array(each, float) for each in problem.quadratic())
    root = np.linalg.cholesky(h)
    rows = np.random.default_rng(0).uniform((-4, -3), (4, 3), (200, 2))
    for row, push in zip(rows, ir.outputs(policy, rows)[:, 0].tolist(), strict=True):
        found = lsq_linear(root.T, -np.linalg.solve(root, row @ f), (-1, 1), method="bvls", tol=1e-14)
        assert push == pytest.approx(found.x[0], abs=1e-9)


@pytest.mark.slow
def test_it_is_proved_to_come_near_and_stay(tmp_path):
    profile = controller(2)[1]
    (tmp_path / "cart.json").write_text(dumps(profile))
    (tmp_path / "world.toml").write_text(WORLD + CLAIMS)
    asked = ["verify", str(tmp_path / "cart.json"), "--world", str(tmp_path / "world.toml")]
    assert main.run([*asked, "--max-boxes", "300000", "-o", str(tmp_path / "out")]) == 1
    report = json.loads((tmp_path / "out" / "report.json").read_text())
    assert [result["verdict"] for result in report["results"]] == ["PROVED", "PROVED", "VIOLATED"]
    for path in (tmp_path / "out").glob("certificate-*.json"):
        assert check_file(path).closed > 0


def test_it_is_proved_to_stay_for_ever(tmp_path):
    """The region that is proposed bounds the roundings too, which nobody has to name."""
    assert check_file(prove_lasting(tmp_path)).closed > 0
