"""Agents that test sums or give numbers, as proofs read them: with the roundings that they make, the plain agent
decides as the reference does, number by number, and the roundings are within their bounds.
"""

from fractions import Fraction

import numpy as np
import pytest

from codegen import ir
from codegen.errors import InputError
from codegen.sums import DOUBLE_SUMS, FLOAT32_STEPS, FLOAT64_SUMS
from tests.support import summed
from tests.support.giving import VARIABLES, tree, world
from verify.systems import lowered as giving
from verify.systems.expressions import affine
from verify.systems.files import statement_of
from verify.systems.observing import as_played, choose_actions, observe_state, with_roundings

FEW, MANY = 2, 120  # trees a kind
STATES = 40


def states(statement, policy, rng):
    """Exact states within the ranges: random ones of few and of many digits, and some where a sum is a threshold."""
    found = []
    for digits in (1, 3, 60):
        found += [
            {
                name: Fraction(int(rng.integers(-(3 * 2**20), 3 * 2**20 + 1)), 2**20)
                if digits < 60
                else Fraction(float(rng.uniform(-3, 3)))
                for name in VARIABLES
            }
            for _ in range(STATES // 4)
        ]
    forms = [feature.form for feature in statement.system.features["agent_0"].values()]
    thresholds = [Fraction(float(each)) for each in policy.tree.threshold[policy.tree.feature >= 0]]
    for form in forms:
        name, factor = next(((name, factor) for name, factor in form.terms if name in VARIABLES), (None, None))
        if name is None:
            continue
        for threshold in thresholds[:4]:
            state = {other: Fraction(int(rng.integers(-48, 49)), 16) for other in VARIABLES}
            rest = form.constant + sum(
                weight * state[other] for other, weight in form.terms if other in VARIABLES and other != name
            )
            state[name] = (threshold - rest) / factor
            if abs(state[name]) <= 3:
                found.append(state)
    return found


def alike(policy, seed):
    """How many states of an agent were compared."""
    profile = summed.profile(policy)
    statement = statement_of(world(len(policy.outputs)), "w.toml")
    read, plain = as_played(statement, profile)
    (agent,) = read.agents
    asked = states(read, policy, np.random.default_rng(seed))
    for state in asked:
        full = with_roundings(read, state)
        row = observe_state(read.system, policy, full)
        action = plain.agents[0].actions[choose_actions(read.system, plain, full)["agent_0"]]
        if not policy.outputs:
            assert action.name == policy.actions[int(ir.act(policy, row)[0])].name
            continue
        real = ir.outputs(policy, row)[0].tolist()
        given = [affine(agent.actions[action.name][f"agent_0.{each.name}"]).at(full) for each in policy.outputs]
        assert given == [Fraction(value) for value in real]
    return len(asked)


KINDS = [
    (arithmetic, outputs, gives, bounded)
    for arithmetic in (DOUBLE_SUMS, FLOAT32_STEPS, FLOAT64_SUMS)
    for outputs, gives, bounded in ((0, None, True), (2, None, True), (1, None, False))
] + [(DOUBLE_SUMS, 2, "float32", True)]


@pytest.mark.parametrize("trees", [FEW, pytest.param(MANY, marks=pytest.mark.slow)])
@pytest.mark.parametrize(("arithmetic", "outputs", "gives", "bounded"), KINDS)
def test_with_its_roundings_the_plain_agent_is_the_real_one(arithmetic, outputs, gives, bounded, trees):
    found = sum(alike(tree(seed, arithmetic, outputs, gives, bounded), seed) for seed in range(trees))
    assert found > trees * STATES // 2


@pytest.mark.parametrize("part", ["of", "bound_feature", "bound_output"])
def test_bounds_that_forget_a_rounding_are_found_out(part, monkeypatch):
    """A bound of nothing for sums, for observations or for the last rounding is too small in some state."""
    forgotten = {
        "of": lambda errors, each: Fraction(0),
        "bound_feature": lambda errors, place: Fraction(0),
        "bound_output": lambda errors, largest: Fraction(0),
    }
    monkeypatch.setattr(giving.Errors, part, forgotten[part])
    monkeypatch.setattr(giving, "_short", lambda bound: bound)
    with pytest.raises(AssertionError, match="beyond"):
        for seed in range(FEW):
            alike(tree(seed, FLOAT32_STEPS if part == "bound_feature" else DOUBLE_SUMS, 2, "float32"), seed)


@pytest.mark.parametrize("arithmetic", [DOUBLE_SUMS, FLOAT32_STEPS, FLOAT64_SUMS])
def test_a_bound_holds_what_inner_sums_round(arithmetic):
    policy = tree(1, arithmetic, 1)
    errors = giving.Errors(policy, {place: Fraction(3) for place in range(len(policy.features))})
    inner = ir.Sum(((0.5, 0), (-2.0, 1), (1.0, ir.CONSTANT)))
    for weight in (1.0, -1.0) if arithmetic == DOUBLE_SUMS else (1.0, -1.0, 1024.0, 0.25):
        whole = errors.of(ir.Sum(((weight, inner), (3.0, 2))))
        assert whole > abs(Fraction(weight)) * errors.of(inner) + errors.of(ir.Sum(((3.0, 2),)))


def test_sums_that_cannot_be_bounded_are_refused():
    policy = tree(1, FLOAT64_SUMS, 1)
    text = world(1).replace('x0 = "p - 2*q"', 'x0 = "sign(p)"').replace('x1 = "0.1*r + 0.3"', 'x1 = "sign(q)"')
    with pytest.raises(InputError, match="stands in a sum"):
        as_played(statement_of(text, "w.toml"), summed.profile(policy))
    huge = summed.policy(3, DOUBLE_SUMS, outputs=3)
    with pytest.raises(InputError, match="too large to bound"):
        for seed in range(20):
            huge = summed.policy(seed, DOUBLE_SUMS, outputs=3)
            as_played(statement_of(world(3), "w.toml"), summed.profile(huge))


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (world(1, more="") + "[agents.agent_0.actions]\ngo = { push = 1 }\n", "actions or outputs, not both"),
        (world(1).replace('u0 = "N"', 'u0 = "N*"'), "unit"),
    ],
)
def test_files_with_outputs_are_read_or_refused(text, says):
    with pytest.raises(InputError, match=says):
        statement_of(text, "w.toml")
