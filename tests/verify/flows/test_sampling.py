"""Jitter and delays: trajectories by scipy with random periods and late observations stay in the sets of a proof."""

from dataclasses import replace
from fractions import Fraction as F

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from codegen.errors import InputError
from codegen.ir import act
from maviper.worlds.checking import check_integration
from maviper.worlds.stated.environment import StatedEnv
from maviper.worlds.stated.systems import FlowRule
from tests.support.flows import CASES, case, off_by, starts_of
from tests.support.stated_play import value
from tests.support.system_cases import box
from verify.checker.accept import accept
from verify.checker.flows import sweep
from verify.checker.flows.samples import LateTrees
from verify.checker.flows.sweep import FlowSweep, Plan
from verify.claims.region import UNBOUNDED
from verify.flows.decide import decide
from verify.flows.episodes import FlowCourse, replay_course
from verify.question import Question
from verify.reports.systems import flow_sentence
from verify.result import Verdict
from verify.subjects import ClosedLoop
from verify.systems import documents
from verify.systems.files import statement_of

JITTER, DELAY, EITHER = "jitter = [-0.004, 0.003]", "delay = 2", "delay = [0, 1]"
BOTH = f"{JITTER}, {EITHER}"


def late(said, name="pendulum", region=None):
    """A case with a period that says more, and a wide claim."""
    text, profile, claim = CASES[name]
    start = text.index('period = "') + len("period = ")
    end = text.index("\n", start)
    system, profile, claim = case(f"{text[:start]}{{ length = {text[start:end]}, {said} }}{text[end:]}", profile, claim)
    wide = box(**{one.name: (-9, 9) for one in system.variables if " ago" not in one.name})
    return system, profile, replace(claim, regions=(region or wide,), by=0)


def observing(system, profile, history, ways, random):
    """What is held, of states [n, variables] at samples so far; each agent's observations are late by one of `ways`."""
    names, held = list(system.flow.rates), {}
    for agent in profile.agents:
        delays = random.choice(ways, len(history[0]))
        states = np.stack([history[max(len(history) - 1 - d, 0)][k] for k, d in enumerate(delays)])
        seen = np.stack([states[:, names.index(feature.name)] for feature in agent.features], axis=1)
        chosen = act(agent, seen.astype(np.float32))
        values = [system.flow.held[agent.agent, each.name] for each in agent.actions]
        for name in values[0]:
            held[name] = np.array([float(each[name]) for each in values])[chosen]
    return held


def leaves(system, profile, claim, plan, count, seed=0, ways=(0,), jitter=None):
    """By how much trajectories leave the sets of a sweep at samples, or the tubes between them."""
    random, swept = np.random.default_rng(seed), FlowSweep(profile, system, claim)
    samples, tubes = {}, {}
    swept.sampled = lambda period, sets: samples.setdefault(period, []).append(
        (sets.box.low.copy(), sets.box.high.copy())
    )
    swept.watch = lambda told: tubes.setdefault(told.period, []).append((told.tube.low, told.tube.high))
    swept.run(plan)
    real = [name for name in system.flow.rates if name not in system.flow.kept]
    ends, period = [float(end) for end in jitter or system.flow.jitter], float(system.flow.period)
    bare = replace(system, start=tuple(half for half in system.start if len(half.form.terms) == 1))
    bare = replace(bare, variables=bare.variables[: len(real)])
    now, worst = starts_of(bare, count, random), 0.0
    history = []
    for sample in range(claim.steps):
        history.append(now)
        worst = max(worst, off_by(samples[sample], now))
        held = observing(system, profile, history, ways, random)
        last = period + np.where(random.random(count) < 0.5, random.choice(ends, count), random.uniform(*ends, count))

        def slope(_, flat, held=held, last=last):
            state = flat.reshape(count, len(real))
            known = held | {name: state[:, k] for k, name in enumerate(real)}
            rates = [np.broadcast_to(value(system.flow.rates[name], known), count) for name in real]
            return (np.stack(rates, axis=1) * last[:, None]).ravel()  # a period of each one's own length, as 1

        done = solve_ivp(slope, (0, 1), now.ravel(), "DOP853", t_eval=[0.37, 0.8, 1], rtol=1e-12, atol=1e-12)
        states = done.y.T.reshape(3, count, len(real))
        worst = max(worst, *(off_by(tubes[sample], each) for each in states))
        now = states[-1]
    return max(worst, off_by(samples[claim.steps], now))


SHORT = {JITTER: (0,), DELAY: (2,), BOTH: (0, 1)}
CELLS = {0: 0.0625, 1: 0.125}


@pytest.mark.parametrize("said", SHORT)
def test_trajectories_stay(said):
    system, profile, claim = late(said)
    plan = Plan((0,), 4, 1, CELLS | ({2: 0.0625, 3: 0.125} if said == BOTH else {}))
    assert leaves(system, profile, replace(claim, steps=6), plan, 40, ways=SHORT[said]) <= 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("name", ["pendulum", "turning"])
@pytest.mark.parametrize("said", SHORT)
def test_ten_thousand_trajectories_stay(said, name):
    system, profile, claim = late(said, name)
    plan = Plan((0,), 4, 1, dict.fromkeys(range(len(system.variables)), 0.125) if said == BOTH else {})
    for seed in range(5):
        assert leaves(system, profile, replace(claim, steps=8), plan, 2_000, seed, SHORT[said]) <= 1e-9


FAULTS = {
    "a pace of 1": (JITTER, (0,), (sweep, "pace_of"), lambda flow: (F(1), F(1))),
    "no pace": (JITTER, (0,), (sweep, "pace_flow"), lambda flow: flow),
    "observed at once": (
        EITHER,
        (0, 1),
        (LateTrees, "split_at_tests"),
        lambda self, boxes: self.ways[0].split_at_tests(boxes),
    ),
}


@pytest.mark.parametrize("name", FAULTS)
def test_a_planted_fault_is_caught(name, monkeypatch):
    said, ways, place, fault = FAULTS[name]
    monkeypatch.setattr(*place, fault)
    system, profile, claim = late(said)
    assert leaves(system, profile, replace(claim, steps=12), Plan((0,), 4, 1), 60, ways=ways) > 1e-6


def test_what_a_file_says_of_samples_is_read_exactly():
    system, _, _ = late(BOTH)
    flow = system.flow
    assert flow.period == F(1, 20) and flow.jitter == (F(-4, 1000), F(3, 1000))
    assert flow.seen == ({}, {"angle": "angle 1 ago", "spin": "spin 1 ago"})
    assert late(DELAY)[0].flow.seen == ({"angle": "angle 2 ago", "spin": "spin 2 ago"},)
    assert flow_sentence(flow) == (
        "of the stated flow, with actions held for 0.046 to 0.053 s, observations late by 0 to 1 periods, exactly"
    )
    hashes = {documents.content_hash(late(said)[0]) for said in (JITTER, DELAY, EITHER, "jitter = 0", "delay = 1")}
    assert len(hashes) == 5
    plain = case(*CASES["pendulum"])[0]
    assert documents.content_hash(late("jitter = 0, delay = 0")[0]) == documents.content_hash(plain)


WRONG = {
    "jitter = 0.06": r"a period of 1/20 s may be -1/100 s long",
    "jitter = -0.01": "the error -1/100 is below 0",
    'jitter = "0.01 m"': "units do not fit",
    "delay = 1.5": "not a whole number from 1 to 32",
    "delay = -1": "not a whole number",
    "delay = true": "not a whole number",
    "delay = [2, 1]": "the least delay 2 is above the largest one 1",
    "late = 1": "unknown key 'late'",
}


@pytest.mark.parametrize("said", WRONG)
def test_what_is_wrong_is_told_with_its_line(said):
    with pytest.raises(InputError, match=WRONG[said]) as error:
        late(said)
    assert "line 17" in str(error.value)


def test_a_period_without_a_length_is_refused():
    text = CASES["pendulum"][0].replace('period = "0.05 s"', "period = { delay = 1 }")
    with pytest.raises(InputError, match="a period needs a length"):
        statement_of(text, "case.toml")


def asked(said, **bounds):
    system, profile, claim = late(said, region=box(**bounds))
    return Question(ClosedLoop(profile, system), replace(claim, steps=5), UNBOUNDED)


def test_a_claim_is_proved_or_broken_by_what_is_late():
    """An episode that breaks a claim says by how much its periods are longer, and is refused beyond the jitter."""
    kept = asked(JITTER, angle=(0, F(13, 10)))
    found = decide(kept)
    assert found.verdict is Verdict.PROVED
    assert accept(found.certificate, kept.profile, kept.subject.system) == found.branches
    broken = asked("jitter = 0.01", angle=(F(808, 1000), 2))
    found = decide(broken)
    again = found.counterexample
    assert found.verdict is Verdict.VIOLATED and any(again.longer)
    course = FlowCourse(again.start, [{}], again.longer, again.ways)
    assert replay_course(broken.profile, broken.subject.system, broken.claim, course) == again
    for beyond in (course._replace(longer=[F(1, 50)]), course._replace(ways=[1])):
        assert replay_course(broken.profile, broken.subject.system, broken.claim, beyond) is None


def test_play_and_the_referee_know_both():
    text, _, _ = CASES["pendulum"]
    said = text.replace('period = "0.05 s"', 'period = { length = "0.05 s", jitter = 0.01, delay = 1 }')
    statement = statement_of(said, "p.toml")
    assert check_integration(statement).mark.value == "ok"
    env = StatedEnv(statement, "p.toml")
    begun, _ = env.reset(seed=0)
    first = env.step({"motor": 0})[0]
    assert (first["motor"] == begun["motor"]).all()  # what was observed a period ago
    times = set()
    for seed in range(4):
        env.reset(seed=seed)
        env.state = {"angle": 1.0, "spin": 0.0, "angle 1 ago": 1.0, "spin 1 ago": 0.0}
        env.step({"motor": 1})
        times.add(round(env.state["angle"], 9))
    rule = FlowRule(statement.system.flow)
    assert len(times) == 4
    state = {"angle": 1.0, "spin": 0.0, "angle 1 ago": 1.0, "spin 1 ago": 0.0}
    ends = [rule.move_state(state, {"motor": "off"}, by)["angle"] for by in (-0.01, 0.01)]
    assert min(ends) < min(times) and max(times) < max(ends)
