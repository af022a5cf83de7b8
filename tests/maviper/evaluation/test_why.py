"""Why a team falls behind: the terms of small games where they are known, and of ours by playing every branch."""

import json
from dataclasses import dataclass

import numpy as np
import pytest

from codegen.dynamics import motionless
from codegen.errors import InputError
from codegen.ir import ActionSpec, FeatureSpec
from maviper.cli import main
from maviper.episodes import measures
from maviper.episodes.play import Policies, choose_actions, play
from maviper.evaluation.crossplay import Uniform, cast
from maviper.evaluation.why import causes, ensure_branched
from maviper.experts.finding import find_expert
from maviper.experts.scripted import build_script
from maviper.worlds import find
from maviper.worlds.world import Measure, World

TENTHS = 10  # what both observe first is uniform over so many numbers
RELAY, EITHER = "relay", "either"


@dataclass(frozen=True)
class Bits:
    """Games: what was drawn, the bit, how many steps were taken, and what the last one was worth."""

    drawn: np.ndarray
    bit: np.ndarray
    taken: np.ndarray
    worth: np.ndarray

    def __len__(self):
        return len(self.drawn)

    def __getitem__(self, rows):
        return Bits(self.drawn[rows], self.bit[rows], self.taken[rows], self.worth[rows])


class TwoBits(World):
    """Two small games of two agents, in which every term of why a team falls behind is known. `relay`: agent 1 sets a
    bit, then agent 0 has to say it. `either`: one decision, worth 1 unless both are wrong. `measures`: the reward's
    sum, as `worth`, and as a cost.
    """

    def __init__(self, game):
        self.game, names = game, ("agent_0", "agent_1")
        self.spec = motionless(f"bits-{game}", "", names, 2 if game == RELAY else 1)
        self.teams = {"agents": names}
        seen = FeatureSpec("drawn", "none", 0.0, TENTHS - 1.0, None), FeatureSpec("bit", "none", 0.0, 1.0, None)
        self.features = (seen, seen)
        self.actions = ((ActionSpec("zero", None), ActionSpec("one", None)),) * 2
        self.measures = (Measure("agents", "worth"), Measure("agents", "cost", lower_is_better=True))

    def start(self, n, rng):
        return self._at(rng.integers(TENTHS, size=n))

    def start_from_seeds(self, seeds):
        return self._at(np.asarray(seeds) % TENTHS)

    @staticmethod
    def _at(drawn):
        zeros = np.zeros(len(drawn), dtype=np.int64)
        return Bits(drawn, zeros, zeros, zeros.astype(float))

    def step(self, state, actions):
        if self.game == EITHER:
            return Bits(state.drawn, state.bit, state.taken + 1, 1.0 - actions.all(axis=1))
        said = np.where(state.taken == 1, actions[:, 0] == state.bit, 0).astype(float)
        return Bits(state.drawn, np.where(state.taken == 0, actions[:, 1], state.bit), state.taken + 1, said)

    def observe(self, state):
        seen = np.stack([state.drawn, state.bit], axis=1).astype(np.float32)
        return seen, seen

    def rewards(self, state):
        return np.repeat(state.worth[:, None], 2, axis=1)

    def values(self, states):
        worth = np.sum([state.worth for state in states], axis=0)
        return np.stack([worth, -worth])

    def reference_env(self):
        raise NotImplementedError


SEEDS = range(200)  # each number ten by ten times
ALWAYS = lambda action: lambda obs: np.full(len(obs), action)  # noqa: E731
SAY_THE_BIT = lambda obs: obs[:, 1].astype(np.int64)  # noqa: E731


def errs(share):
    """Wrong, which is 1, where the number drawn is below so many tenths."""
    return lambda obs: (obs[:, 0] < share * TENTHS).astype(np.int64)


def terms(world, trees, expert):
    ours, theirs = Policies(trees), Policies(expert)
    found = causes(world, cast(world, "agents", [ours, ours], [theirs, theirs], theirs), SEEDS)
    return {row.measure.name: row for row in found}


@pytest.mark.parametrize("share", [0.1, 0.3, 1.0])
def test_a_mates_error_that_leads_where_nobody_was_is_shift(share):
    """Nobody loses alone, actions do not interact, and yet the team loses in as many episodes as the mate errs in."""
    found = terms(TwoBits(RELAY), [ALWAYS(0), errs(share)], [SAY_THE_BIT, ALWAYS(0)])
    for name in ("worth", "cost", "return"):
        row = found[name]
        assert (row.individual.value, row.interaction.value) == (0, 0)
        assert row.gap.value == row.shift.value == pytest.approx(share)
        assert {agent: own.value for agent, own in row.agents.items()} == {"agent_0": 0, "agent_1": 0}


@pytest.mark.parametrize(
    ("game", "trees", "experts", "individual", "shift", "interaction"),
    [
        (EITHER, [errs(0.5), errs(0.2)], [ALWAYS(0), ALWAYS(0)], 0, 0, pytest.approx(0.2)),
        (RELAY, [ALWAYS(1), ALWAYS(0)], [SAY_THE_BIT, ALWAYS(0)], 1, 0, 0),
        (RELAY, [ALWAYS(1), ALWAYS(1)], [SAY_THE_BIT, ALWAYS(0)], 1, -1, 0),
    ],
    ids=["errors that meet", "what a member loses alone", "terms cancel: the first says what the second has set"],
)
def test_terms_by_hand(game, trees, experts, individual, shift, interaction):
    found = terms(TwoBits(game), trees, experts)["worth"]
    told = found.individual.value, found.shift.value, found.interaction.value
    assert told == (individual, shift, interaction)
    assert found.gap.value == pytest.approx(individual + shift + found.interaction.value)


def slow(world, lineup, seeds):
    """The gap, the individual gaps and the shift of each measure, by playing whole branches, one state at a time."""

    def worth(states, returns):
        rows = dict(zip(world.measures, world.values(states[1:]), strict=True))
        own = {measure: measures.score(measure, row)[0] for measure, row in rows.items() if measure.team == lineup.team}
        return np.array([*own.values(), returns[world.members(lineup.team)].mean()])

    def finished(states, acted):
        states = [*states, world.step(states[-1], acted)]
        while len(states) <= world.spec.episode_steps:
            now = states[-1]
            states.append(world.step(now, choose_actions(lineup.expert, world.observe(now), now)))
        return worth(states, sum(world.rewards(state)[0] for state in states[1:]))

    members, found = world.members(lineup.team), []
    for seed in seeds:
        start = world.start_from_seeds([seed])
        everybody = [play(world, each, start) for each in (lineup.expert, lineup.ours, *lineup.alone.values())]
        best, team, *alone = (worth(each.states, each.returns[:, 0]) for each in everybody)
        own, ours = everybody[1], np.zeros((len(members), len(best)))
        for step in range(world.spec.episode_steps):
            now = own.states[step]
            wanted = choose_actions(lineup.expert, world.observe(now), now)
            base = finished(own.states[: step + 1], wanted)
            for place, member in enumerate(members):
                acted = wanted.copy()
                acted[0, member] = own.actions[step, 0, member]
                ours[place] += base - finished(own.states[: step + 1], acted)
        single = sum(best - each for each in alone)
        found.append((best - team, single, ours.sum(axis=0) - single))
    return np.mean(found, axis=0)


@pytest.mark.parametrize(("name", "episodes"), [("physical-deception@maddpg", 2), ("cooperative-navigation", 1)])
def test_terms_are_those_of_whole_branches(name, episodes):
    """Against scripts as the trees, of which the expert knows nothing."""
    expert, world = find_expert(name)
    script, seeds = build_script(world), range(7_000_000, 7_000_000 + episodes)
    team = list(world.teams)[-1]
    lineup = cast(world, team, [script] * len(world.agents), [expert] * len(world.agents), expert)
    found, wanted = causes(world, lineup, seeds), slow(world, lineup, seeds)
    for row, (gap, individual, shift) in zip(found, wanted.T, strict=True):
        values = row.gap.value, row.individual.value, row.shift.value
        assert values == pytest.approx((gap, individual, shift), abs=1e-9)
        assert sum((row.individual.value, row.shift.value, row.interaction.value)) == pytest.approx(gap, abs=1e-9)


def test_a_team_of_one_has_no_shift_and_no_interaction():
    expert, world = find_expert("physical-deception@maddpg")
    script = build_script(world)
    lineup = cast(world, "adversaries", [script] * 3, [expert] * 3, expert)
    for row in causes(world, lineup, range(20)):
        assert row.gap == row.individual and (row.shift.value, row.interaction.value) == (0, 0)


def test_what_cannot_be_branched_is_refused():
    world = find("physical-deception")
    script, chance = build_script(world), Uniform(world)
    with pytest.raises(InputError, match="at random"):
        ensure_branched(world, cast(world, "defenders", [script] * 3, [chance] * 3, script))
    with pytest.raises(InputError, match="compare a team with an expert"):
        ensure_branched(world, cast(world, "defenders", [script] * 3, [script] * 3, None))
    copies = find("physical-deception")
    copies.games = 1
    with pytest.raises(InputError, match="cannot be branched"):
        ensure_branched(copies, cast(copies, "defenders", [script] * 3, [script] * 3, script))


class Fickle:
    """Somebody who acts otherwise each time."""

    def __init__(self):
        self.rng = np.random.default_rng(0)

    def act(self, agents, observations, state):
        return self.rng.integers(5, size=(len(state), len(agents)))


def test_a_player_who_answers_otherwise_each_time_is_noticed():
    world = find("physical-deception")
    script, fickle = build_script(world), Fickle()
    with pytest.raises(InputError, match="always alike"):
        causes(world, cast(world, "defenders", [script] * 3, [fickle] * 3, fickle), range(30))


def test_evaluate_prints_the_terms_and_they_add_up(capsys):
    place = "generated/physical_deception/profile.json"
    assert main.run(["evaluate", place, "--why", "--episodes", "40"]) == 0
    said = capsys.readouterr().out
    assert "gap = individual + shift + interaction" in said and "agent_1 alone" in said
    assert main.run(["evaluate", place, "--why", "--episodes", "40", "--json"]) == 0
    (rows,) = json.loads(capsys.readouterr().out)["why"].values()
    for row in rows:
        parts = sum(row[name]["value"] for name in ("individual", "shift", "interaction"))
        assert parts == pytest.approx(row["gap"]["value"], abs=1e-9)
    assert main.run(["evaluate", place, "--why", "--against", "random"]) == 2
    assert "--why" in capsys.readouterr().err
