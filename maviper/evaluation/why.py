"""Why a team falls behind its expert: individual gaps, shift and interaction, measured without a critic.

Does: plays the team, and from each of its states lets the expert finish, once as it is and once after one member acted
  alone; gives the three terms of each measure, whose sum is the gap, with intervals over episodes.
Assumes: controllers that answer a state always alike, and a world whose states can be stepped more than once.
Does not: use anybody's Q; explain single decisions (show.py). The manual's page `measuring` has the terms.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from codegen.errors import InputError
from codegen.ir import Float64
from maviper.episodes import measures
from maviper.episodes.play import Episodes, choose_actions, play
from maviper.evaluation.crossplay import Cast, Interval, Lineup, Uniform, interval
from maviper.worlds import Measure, World
from maviper.worlds.world import RETURN, Int

AT_ONCE = 2_048  # episodes; bounds the memory
ROUNDING = 1e-9


@dataclass(frozen=True)
class Causes:
    """Why a team is worse than the expert in a measure, in its unit: `individual`, `shift` and `interaction` add up to
    `gap`. Positive: the trees are worse.
    """

    measure: Measure
    gap: Interval
    individual: Interval  # the sum of `agents`
    shift: Interval
    interaction: Interval
    agents: Mapping[str, Interval]  # agent -> the gap when it alone is the subject, among experts


def causes(world: World, cast: Cast, seeds: range) -> tuple[Causes, ...]:
    """The terms of every measure of the cast's team, where play can be branched (`ensure_branched`)."""
    expert = cast.expert
    assert expert is not None
    parts: list[tuple[Float64, Float64, Float64]] = []
    for low in range(0, len(seeds), AT_ONCE):
        parts.append(_Branches(world, cast, expert, seeds[low : low + AT_ONCE]).terms())
    gap, advantages, alone = (np.concatenate(each, axis=-1) for each in zip(*parts, strict=True))
    shift, interaction = (advantages - alone).sum(axis=0), gap - advantages.sum(axis=0)
    per_measure: list[Causes] = []
    for row, measure in enumerate(_measures(world, cast.team)):
        agents = {agent: _mean(own[row]) for agent, own in zip(cast.alone, alone, strict=True)}
        whole, individual = _mean(gap[row]), _mean(alone.sum(axis=0)[row])
        per_measure.append(Causes(measure, whole, individual, _mean(shift[row]), _mean(interaction[row]), agents))
    return tuple(per_measure)


def _mean(values: Float64) -> Interval:
    """The mean over episodes; sums of rewards in another order differ by less than ROUNDING, which is nothing."""
    return interval(measures.estimate(Measure("", ""), np.where(np.abs(values) < ROUNDING, 0.0, values)))


def _measures(world: World, team: str) -> list[Measure]:
    return [measure for measure in measures.list_measures(world) if measure.team == team]


def ensure_branched(world: World, cast: Cast) -> None:
    """InputError where there is no expert, or where play from a state cannot go on in more than one way."""
    if cast.expert is None:
        raise InputError("the terms compare a team with an expert", "--why", "name it with --expert")
    if world.games is not None:
        advice = "leave --why out; our own games can be branched"
        raise InputError("play cannot be branched from this world's states", f"--why: {world.name}", advice)
    if any(isinstance(each, Uniform) for each in (*cast.ours, *cast.expert)):
        what = "whoever plays at random does not answer a state always alike"
        raise InputError(what, "--why", "choose other players and opponents")


class _Branches:
    """Some episodes of the team, and what would have become of them."""

    def __init__(self, world: World, cast: Cast, expert: Lineup, seeds: Sequence[int]) -> None:
        self.world, self.cast, self.expert = world, cast, expert
        self.members = world.members(cast.team)
        start = world.start_from_seeds(seeds)
        self.episodes, experts = play(world, cast.ours, start), play(world, expert, start)
        self._ensure_alike(self.episodes, play(world, cast.ours, start))
        self._ensure_alike(experts, play(world, expert, start))
        self.states = self.episodes.states
        rewards = [world.rewards(state).T for state in self.states[1:]]
        self.banked = np.cumsum([np.zeros_like(rewards[0]), *rewards], axis=0)  # [steps + 1, n_agents, batch]
        self.worth = self._scores(experts)  # where experts finish; higher is better
        self.alone = [self.worth - self._scores(play(world, lineup, start)) for lineup in cast.alone.values()]

    @staticmethod
    def _ensure_alike(once: Episodes, again: Episodes) -> None:
        if once.actions.shape != again.actions.shape or (once.actions != again.actions).any():
            raise InputError("a player does not answer the same state always alike", "--why", "choose other players")

    def terms(self) -> tuple[Float64, Float64, Float64]:
        """Of each episode: the gap [n_measures, batch]; what each member's actions alone lose in the team's states,
        and each one's gap among experts, [n_members, n_measures, batch].
        """
        worth = self.worth
        advantages = np.zeros((len(self.members), *worth.shape))
        for step, acted in enumerate(self.episodes.actions):
            seen = tuple(each[step] for each in self.episodes.observations)
            wanted = choose_actions(self.expert, seen, self.states[step])[:, self.members]
            unlike = (acted[:, self.members] != wanted) & self.episodes.alive[step][:, self.members]
            following = worth.copy()
            rows = np.flatnonzero(unlike.any(axis=1))
            following[:, rows] = self._finish_episodes(step, rows, acted[rows])
            several = unlike.sum(axis=1) > 1
            for place, member in enumerate(self.members):
                lost = advantages[place]
                single = np.flatnonzero(unlike[:, place] & ~several)
                lost[:, single] += (worth - following)[:, single]
                rows = np.flatnonzero(unlike[:, place] & several)
                joint = acted[rows]
                joint[:, self.members] = wanted[rows]
                joint[:, member] = acted[rows, member]
                lost[:, rows] += worth[:, rows] - self._finish_episodes(step, rows, joint)
            worth = following
        return self.worth - self._scores(self.episodes), advantages, np.stack(self.alone)

    def _finish_episodes(self, step: int, rows: Int, acted: Int) -> Float64:
        """The scores of episodes `rows` in which everybody acts so in a step, then experts, [n_measures, rows]."""
        if not len(rows):
            return np.empty((len(self.worth), 0))
        world = self.world
        states = [state[rows] for state in self.states[: step + 1]]
        states.append(world.step(states[-1], acted))
        returns = self.banked[step][:, rows] + world.rewards(states[-1]).T
        while len(states) <= world.spec.episode_steps and world.playing(states[-1]).any():
            now = states[-1]
            states.append(world.step(now, choose_actions(self.expert, world.observe(now), now)))
            returns += world.rewards(states[-1]).T
        return self._score_values(world.values(states[1:]), returns)

    def _scores(self, episodes: Episodes) -> Float64:
        return self._score_values(episodes.values, episodes.returns)

    def _score_values(self, values: Float64, returns: Float64) -> Float64:
        """[n_measures of the team, batch], with the sign that makes higher better."""
        known: dict[Measure, Any] = {Measure(self.cast.team, RETURN): returns[self.members].mean(axis=0)}
        known |= dict(zip(self.world.measures, values, strict=True))
        return np.stack([measures.score(each, known[each]) for each in _measures(self.world, self.cast.team)])
