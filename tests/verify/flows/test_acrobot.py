"""Gymnasium's Acrobot as a flow: its derivatives are the environment's, and a claim about one second is proved."""

from pathlib import Path

import numpy as np
import pytest

from maviper.worlds.stated.systems import FlowRule
from tests.support.system_cases import policy, team
from verify.checker.accept import accept
from verify.claims.region import UNBOUNDED
from verify.flows.decide import decide
from verify.question import Question
from verify.result import Verdict
from verify.subjects import ClosedLoop
from verify.systems.files import statement_of
from verify.systems.properties import claims_of

FILE = Path(__file__).parents[3] / "generated" / "worlds" / "flows" / "acrobot.toml"
STATEMENT = statement_of(FILE.read_text(), FILE.name)
NAMES, ACTIONS = ("th1", "th2", "w1", "w2"), ("back", "none", "ahead")
SWING = team(policy("arm", NAMES, ACTIONS, ((3, 0.0), 0, 2)))  # with the speed of the second link


def test_derivatives_are_those_of_the_environment_and_its_step_is_near_the_flow():
    acrobot = pytest.importorskip("gymnasium.envs.classic_control.acrobot")
    env, rule, rng = acrobot.AcrobotEnv(), FlowRule(STATEMENT.system.flow), np.random.default_rng(0)
    for number in range(200):
        state = rng.uniform([-3, -3, -6, -9], [3, 3, 6, 9]) * (0.1 if number % 2 else 1.0)
        action = int(rng.integers(3))
        known, augmented = dict(zip(NAMES, state.tolist(), strict=True)), np.append(state, action - 1.0)
        found = list(rule.derivative(known, rule.hold_inputs({"arm": ACTIONS[action]})).values())
        assert np.abs(np.array(found) - np.array(env._dsdt(augmented))[:4]).max() < 1e-12
        if number % 20 == 1:
            step = acrobot.rk4(env._dsdt, augmented, [0, env.dt])[:4]
            exact = rule.integrate_states(known, {"arm": ACTIONS[action]}, np.array([env.dt]))[-1]
            assert np.abs(step - exact).max() < 2e-3
    assert (rule.period, STATEMENT.system.steps * rule.period) == (env.dt, 1.0)


@pytest.mark.slow
def test_one_second_is_too_short_to_swing_up():
    claim = claims_of(STATEMENT, SWING, FILE.name)[0]
    found = decide(Question(ClosedLoop(SWING, STATEMENT.system), claim, UNBOUNDED))
    assert found.verdict is Verdict.PROVED
    assert accept(found.certificate, SWING, STATEMENT.system) == found.branches
