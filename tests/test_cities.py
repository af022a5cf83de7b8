"""generated/signals/ in SUMO: what signals observe, show and are measured by, told from the simulation itself."""

import sys
from importlib.util import find_spec

import numpy as np
import pytest

from tests.support.generated import FOLDER

PLACE = FOLDER.parent / "signals"
if find_spec("libsumo") is None or find_spec("sumo_rl") is None:
    pytest.skip("the extra maviper[signals]", allow_module_level=True)


@pytest.fixture(scope="module")
def signals():
    """The environment as its users import it."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(PLACE))
        import signals  # pyright: ignore[reportMissingImports]

        yield signals
        for name in ("signals", "junctions", "baselines"):
            sys.modules.pop(name, None)


@pytest.fixture
def env(signals):
    made = signals.make("cologne3", seconds=300)
    yield made
    made.close()


def play(env, seed, choose):
    """Actions, observations, rewards and infos of each step, and the seconds that it takes."""
    seen, _ = env.reset(seed)
    while env.agents:
        chosen, passed = {agent: choose(agent, seen[agent]) for agent in env.acting}, len(env.queues)
        seen, rewards, *_, infos = env.step(chosen)
        yield chosen, seen, rewards, infos, 5 * (len(env.queues) - passed)


def by_name(env, agent, seen):
    return dict(zip((each.name for each in env.features[agent]), seen.tolist(), strict=True))


def switching(env):
    draws = np.random.default_rng(0)
    return lambda agent, seen: int(draws.integers(env.action_space(agent).n))


@pytest.mark.slow
def test_clocks_say_which_phase_is_on_and_how_long_ago_each_was(env):
    on, now = dict.fromkeys(env.possible_agents, 0), 10
    began, ended = ({agent: {} for agent in on} for _ in range(2))  # of phases' last greens, in seconds
    for chosen, seen, *_, seconds in play(env, 1, switching(env)):
        for agent, each in seen.items():
            if chosen.get(agent, on[agent]) != on[agent]:
                ended[agent][on[agent]], began[agent][chosen[agent]] = now, now + 5
                on[agent] = chosen[agent]
            told = by_name(env, agent, each)
            assert env.observation_space(agent).contains(each)
            assert [told[f"on_{k}"] for k in range(env.action_space(agent).n)].index(1) == on[agent]
            assert told["green"] == now + seconds - began[agent].get(on[agent], 0)
            for k in range(env.action_space(agent).n):
                assert told[f"red_{k}"] == (0 if k == on[agent] else min(240, now + seconds - ended[agent].get(k, 0)))
        now += seconds
    assert now == 300


@pytest.mark.slow
def test_nobody_loses_green_without_yellow_and_all_red_or_before_ten_seconds(signals, env, monkeypatch):
    """Told from what SUMO shows, second by second."""
    import libsumo  # pyright: ignore[reportMissingImports]

    shown = {signal.place: [] for signal in env.signals.values()}
    step = libsumo.simulationStep

    def step_by_seconds(until):
        while libsumo.simulation.getTime() < until:
            step()
            for place, states in shown.items():
                states.append(libsumo.trafficlight.getRedYellowGreenState(place))

    monkeypatch.setattr(libsumo, "simulationStep", step_by_seconds)
    for _ in play(env, 2, switching(env)):
        pass
    for signal in env.signals.values():
        for link in zip(*shown[signal.place], strict=True):
            runs = "".join(link).replace("g", "G")
            assert "Gr" not in runs and "yG" not in runs
            assert all(len(part) == 3 for part in runs.replace("G", "r").split("r") if part)
            assert all(len(part) >= 10 for part in runs.replace("y", "r").strip("G").split("r") if part)
            assert "yrrG" in runs or "yrrr" in runs or "y" not in runs


@pytest.mark.slow
def test_the_same_seed_is_the_same_hour_and_measures_come_at_the_end(env):
    first, again, other = (list(play(env, seed, switching(env))) for seed in (3, 3, 4))
    assert [step[2:] for step in first] == [step[2:] for step in again] != [step[2:] for step in other]
    *before, last = [step[3]["signal_0"] for step in first]
    assert not any(before) and last.keys() == env.measures.keys() and last["delay"] > 0


@pytest.mark.slow
def test_greedy_is_better_than_what_sees_no_vehicle(signals):
    import baselines  # pyright: ignore[reportMissingImports]

    env = signals.make("ingolstadt1", seconds=1200)
    greedy, alternate = (baselines.play(env, baselines.RULES[name], 0)["delay"] for name in ("greedy", "alternate"))
    assert greedy < 0.8 * alternate


def test_a_network_that_is_none_is_refused(signals):
    with pytest.raises(ValueError, match="cologne1, cologne3"):
        signals.make("paris")
