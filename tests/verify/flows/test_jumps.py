"""What jumps at samples beside a flow: a law whose gains a tree chooses, in play, in proofs and in counterexamples."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from codegen.errors import InputError
from maviper.worlds.stated.systems import FlowRule
from tests.support.system_cases import policy, team
from verify.checker.accept import accept
from verify.checker.flows.steps import FlowStep
from verify.checker.flows.sweep import FlowSweep, Plan
from verify.checker.reading import RejectedError
from verify.claims.region import UNBOUNDED
from verify.flows.decide import decide
from verify.question import Question
from verify.subjects import ClosedLoop
from verify.systems import documents
from verify.systems.files import statement_of
from verify.systems.properties import claims_of

TEXT = """
name = "held"
steps = 8
[variables]
x = { unit = "m", range = [-9, 9] }
v = { unit = "m/s", range = [-9, 9] }
u = { unit = "m/s^2", range = [-99, 99] }
[agents.a.features]
x = "x"
[agents.a.actions]
near = { k = "-4 1/s^2", d = "-3 1/s" }
far = { k = "-9 1/s^2", d = "-5 1/s" }
[start]
box = { x = [0.4, 0.6], v = [-0.1, 0.1], u = 0 }
[dynamics]
period = "0.1 s"
[dynamics.next]
u = "a.k*x + a.d*v"
[dynamics.flow]
x = "v"
v = "u + 0.1[1/s^2/m]*x**2"
u = "0[m/s^3]"
[[property]]
name = "reaches_and_stays"
by = 7
region = { box = { x = [-0.5, 0.5] } }
"""
TREE = team(policy("a", ["x"], ["near", "far"], ((0, 0.45), 0, 1)))


def asked(text=TEXT):
    statement = statement_of(text, "held.toml")
    return statement.system, claims_of(statement, TREE, "held.toml")[0]


def decided(text=TEXT):
    system, claim = asked(text)
    return decide(Question(ClosedLoop(TREE, system), claim, UNBOUNDED))


def test_a_claim_about_a_law_is_proved_and_a_false_one_is_broken():
    system, _ = asked()
    found = decided()
    assert found.verdict.value == "PROVED" and accept(found.certificate, TREE, system) == found.branches
    false = decided(TEXT.replace("[-0.5, 0.5]", "[0.5, 0.6]"))
    assert false.verdict.value == "VIOLATED" and not 0.5 <= false.counterexample.states[-1]["x"] <= 0.6


def test_what_jumps_is_part_of_the_hash_and_has_its_unit():
    hashes = {documents.content_hash(asked(text)[0]) for text in (TEXT, TEXT.replace("a.k*x +", "a.k*x -"))}
    assert len(hashes) == 2
    with pytest.raises(InputError, match="units do not fit"):
        asked(TEXT.replace("a.k*x +", "x +"))
    with pytest.raises(InputError, match="clip beside a flow cannot be enclosed"):
        asked(TEXT.replace('u = "a.k*x + a.d*v"', 'u = "clip(a.k*x, -1, 1)"'))


def moved(state, held):
    """One period by scipy: the jump, then the flow."""
    x, v, _ = state
    u = held[0] * x + held[1] * v
    done = solve_ivp(lambda _, s: [s[1], u + 0.1 * s[0] ** 2], (0, 0.1), [x, v], rtol=1e-12, atol=1e-12)
    return np.array([*done.y[:, -1], u])


def escapes():
    """Whether an episode by scipy leaves the sets of samples."""
    system, claim = asked()
    sweep, seen = FlowSweep(TREE, system, claim), {}
    sweep.sampled = lambda period, sets: seen.setdefault(period, []).append((sets.box.low.copy(), sets.box.high.copy()))
    try:
        sweep.run(Plan((0,), 4, 1))
    except RejectedError:
        return False
    for start in ([0.4, -0.1, 0.0], [0.6, 0.1, 0.0], [0.449, 0.03, 0.0], [0.47, 0.0, 0.0]):
        state = np.array(start)
        for period in range(system.steps + 1):
            within = [((low <= state + 1e-9) & (state - 1e-9 <= high)).all(axis=1).any() for low, high in seen[period]]
            if not any(within):
                return True
            state = moved(state, (-9, -5) if np.float32(state[0]) > np.float32(0.45) else (-4, -3))
    return False


def test_episodes_stay_in_the_sets_and_a_forgotten_jump_is_caught(monkeypatch):
    assert not escapes()
    jumped = FlowStep.jump_sets

    def without_law(self, box, frames, held):
        return jumped(
            self,
            box,
            frames,
            {name: held[name]._replace(low=0 * held[name].low, high=0 * held[name].high) for name in held},
        )

    monkeypatch.setattr(FlowStep, "jump_sets", without_law)
    system, claim = asked(TEXT.replace("[-0.5, 0.5]", "[-99, 99]"))
    monkeypatch.setattr(f"{__name__}.asked", lambda: (system, claim))
    assert escapes()


def test_play_and_the_referee_make_the_jump():
    system, _ = asked()
    rule, state = FlowRule(system.flow), {"x": 0.5, "v": 0.0, "u": 0.0}
    expected = moved([0.5, 0.0, 0.0], (-9, -5))
    assert np.abs(np.array(list(rule.move_state(state, {"a": "far"}).values())) - expected).max() < 1e-9
    assert np.abs(rule.integrate_states(state, {"a": "far"}, np.array([0.1]))[-1] - expected).max() < 1e-9


def test_a_flow_without_bounds_is_refused_by_the_referee():
    text = TEXT.replace("u + 0.1[1/s^2/m]*x**2", "u + 99[1/m]*v**2")
    system, _ = asked(text)
    with pytest.raises(ArithmeticError, match="grows beyond all bounds"):
        FlowRule(system.flow).integrate_states({"x": 0.0, "v": 9.0, "u": 0.0}, {"a": "far"}, np.array([0.1]))
