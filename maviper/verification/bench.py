"""What questions about one profile are answered with: its build, its world, replays, the states of its own episodes.

Does: builds the profile once; finds what replays a decision of a team, and what replays episodes from one start: our
  simulator, the compiled C, the reference environment.
Assumes: the profile's world is one of ours; otherwise only the reference replays.
Does not: judge; the verifier compares every position, velocity and action bit by bit. Our simulator steps as the
  verifier's referee does (codegen/dynamics.py), so of the motion itself only the reference environment is a second
  reading; that our steps are its steps is also tested apart.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import TYPE_CHECKING

import numpy as np

from codegen import ir
from codegen.agreement.programs import find_compiler
from codegen.errors import escape_text
from codegen.ir import Float32, Int32, PolicyProfile
from maviper.episodes.play import Episodes
from maviper.episodes.trees import on_policy
from maviper.worlds import ParticleWorld, WorldState
from maviper.worlds.games.particle import place_entities
from maviper.worlds.matching import NO_WORLD, matching_places
from verify.claims.formula import Formula
from verify.claims.observed import MIRRORED, RAISED, View, over
from verify.claims.region import Region
from verify.states.episodes import Episode, EpisodeReplay, agree_on_course
from verify.states.state import Acted, Replay, State, confirm_actions, contains, observe_state
from verify.verdicts.decisions import Visited

if TYPE_CHECKING:
    from codegen.agreement.compiled import CompiledC

Decide = Callable[[str, Float32], Int32]  # an agent and its observations [batch, n_features] -> actions [batch]


class ReplayBuild:
    """The C of a profile, for a few decisions: written, compiled without optimising and loaded when the first one is
    asked for. Most claims are proved, and ask for none.
    """

    def __init__(self, profile: PolicyProfile) -> None:
        self.profile = profile

    @cached_property
    def compilable(self) -> bool:
        """True if there is a compiler. MissingToolError when $CC cannot be read as a command."""
        return find_compiler() is not None

    @cached_property
    def library(self) -> CompiledC:
        """The compiled header. Only where it is `compilable`."""
        from codegen.agreement.compiled import ReplayedC

        return ReplayedC.of(self.profile)

    def __enter__(self) -> ReplayBuild:
        return self

    def __exit__(self, *_: object) -> None:
        if "library" in self.__dict__:
            self.library.close()


def rollouts(made: ReplayBuild, world: ParticleWorld | None) -> Mapping[str, EpisodeReplay]:
    """Returns the functions that can replay episodes of a profile, by name."""
    if world is None:
        return {}
    profile = made.profile
    players: dict[str, EpisodeReplay] = {
        "simulator": partial(_simulate_episode, profile, world, partial(_by_tree, profile))
    }
    if made.compilable:
        compiled = partial(_simulate_episode, profile, world, lambda agent, obs: made.library.act(agent, obs))
        players["compiled C"] = compiled  # with the first replay
    players[escape_text(profile.world.reference)] = partial(_episode_in_reference, profile, world)
    return players


def _by_tree(profile: PolicyProfile, agent: str, obs: Float32) -> Int32:
    return ir.act(profile.policy(agent), obs)


def state_of(profile: PolicyProfile, state: State) -> WorldState:
    """A world state (batch 1) at a point; velocities that the point leaves out are zero."""
    return states_of(profile.world, [state])


def states_of(world: ir.WorldSpec, states: Sequence[State]) -> WorldState:
    """The world states at points, in their order; velocities that a point leaves out are zero."""
    entities = [entity.name for entity in world.agents + world.landmarks]
    marks = [entity.name for entity in world.landmarks]
    position = [[[state.position[f"{name}.{axis}"] for axis in "xy"] for name in entities] for state in states]
    goal = [marks.index(state.goal) if state.goal is not None else 0 for state in states]
    speed = [
        [[state.position.get(f"{agent.name}.v{axis}", 0.0) for axis in "xy"] for agent in world.agents]
        for state in states
    ]
    return WorldState(np.array(position), np.array(speed), np.array(goal))


def _simulate_episode(
    profile: PolicyProfile, world: ParticleWorld, decide: Decide, state: State, steps: int
) -> Episode:
    """In our simulator."""
    world_state = state_of(profile, state)
    episode = [world.coordinates(world_state)[0]]
    actions: list[list[int]] = []
    for _ in range(steps):
        seen = world.observe(world_state)
        chosen = [int(decide(agent, obs)[0]) for agent, obs in zip(world.agents, seen, strict=True)]
        world_state = world.step(world_state, np.array([chosen]), exact=True)
        episode.append(world.coordinates(world_state)[0])
        actions.append(chosen)
    return _course(world, episode, actions)


def _episode_in_reference(profile: PolicyProfile, world: ParticleWorld, state: State, steps: int) -> Episode:
    """In the reference environment, on what it shows; features that it does not have are observed by their meanings."""
    env = world.reference_env()
    env.reset(seed=0)
    world_state = state_of(profile, state)
    place_entities(env, world_state)
    inner = env.aec_env.unwrapped
    inner.max_cycles = steps + 1
    episode = [world.coordinates(world_state)[0]]
    actions: list[list[int]] = []
    for _ in range(steps):
        chosen: list[int] = []
        for number, (agent, obs) in enumerate(zip(world.agents, world.observe(world_state), strict=True)):
            seen = obs.copy()
            seen[0, : world.shown[number]] = inner.observe(agent)[: world.shown[number]]
            chosen.append(int(_by_tree(profile, agent, seen)[0]))
        env.step(dict(zip(world.agents, chosen, strict=True)))
        entities = inner.world.agents + inner.world.landmarks
        position = np.array([[entity.state.p_pos for entity in entities]])
        velocity = np.array([[agent.state.p_vel for agent in inner.world.agents]])
        world_state = WorldState(position, velocity, world_state.goal)
        episode.append(world.coordinates(world_state)[0])
        actions.append(chosen)
    return _course(world, episode, actions)


def _course(world: ParticleWorld, episode: list[ir.Float64], actions: list[list[int]]) -> Episode:
    return Episode(np.array(episode), np.array(actions, dtype=np.int64).reshape(len(actions), len(world.agents)))


NOT_SET = "claims over observations are replayed by observation; no state of the environment need show them"


@dataclass
class Bench:
    """All of it; to be entered, since the compiled code lies in a folder of its own."""

    profile: ir.PolicyProfile
    made: ReplayBuild
    world: ParticleWorld | None  # None: not one of ours, or claims are over observations
    skipped: tuple[str, ...]  # replays that cannot be had, with the reason

    @staticmethod
    def of(profile: ir.PolicyProfile, observing: bool) -> Bench:
        """For questions about a profile. `observing`: about its observations."""
        made, world = ReplayBuild(profile), None if observing else matching_places(profile)
        skipped = [] if made.compilable else ["compiled C: no compiler found"]
        if world is None:
            why = NOT_SET if observing else NO_WORLD
            skipped.append(f"{escape_text(profile.world.reference) or 'environment'}: {why}")
        return Bench(profile, made, world, tuple(skipped))

    def __enter__(self) -> Bench:
        self.made.__enter__()
        return self

    def __exit__(self, *_: object) -> None:
        self.made.__exit__()

    @cached_property
    def _episodes(self) -> Episodes | None:
        return None if self.world is None else on_policy(self.profile, self.world, keep=False)

    def count_visited(self, region: Region) -> Visited | None:
        """Counts the states of its own episodes inside a region, its goals included; None where nothing plays it."""
        if self.world is None or self._episodes is None:
            return None
        names, inside = np.array([landmark.name for landmark in self.world.spec.landmarks]), 0
        steps: Sequence[WorldState] = self._episodes.states[1:]
        for state in steps:  # of one step at a time
            within = contains(region, self.world.coordinates(state), self.world.spec)
            if region.goals:
                within &= np.isin(names[state.goal], region.goals)
            inside += int(within.sum())
        return Visited(inside, sum(map(len, steps)), len(self._episodes.states[0]))


def state_replays(
    made: ReplayBuild, profile: ir.PolicyProfile, team: str, world: ParticleWorld | None
) -> Mapping[str, Replay]:
    """Returns the functions that replay a team's decisions in one state. `profile`: the built one, or a view of it."""
    replays: dict[str, Replay] = {}
    if made.compilable:
        replays["compiled C"] = partial(_in_compiled, made, profile, team)
    if world is not None:
        replays[escape_text(profile.world.reference)] = partial(_in_reference, profile, profile.team(team), world)
    return replays


def _in_compiled(made: ReplayBuild, profile: ir.PolicyProfile, team: str, state: State) -> list[int]:
    """The team's actions by the compiled header; a copy of an agent acts by that agent's function."""
    known = [policy.agent for policy in made.profile.agents]
    actions: list[int] = []
    for policy in profile.team(team):
        agent = policy.agent if policy.agent in known else policy.agent.removesuffix(RAISED).removesuffix(MIRRORED)
        actions.append(int(made.library.act(agent, observe_state(profile, policy, state))[0]))
    return actions


def _in_reference(
    profile: ir.PolicyProfile, team: Sequence[ir.AgentPolicy], world: ParticleWorld, state: State
) -> list[int]:
    """The team's actions on what the reference environment itself observes in the world state; features that it does
    not have, and those that a counterexample's errors change, are observed by their meanings.
    """
    env = world.reference_env()
    env.reset(seed=0)
    world_state = state_of(profile, state)
    place_entities(env, world_state)
    actions: list[int] = []
    for policy in team:
        agent = world.agents.index(policy.agent)
        obs = world.observe(world_state)[agent].copy()
        shown = env.aec_env.unwrapped.observe(policy.agent)
        obs[0, : world.shown[agent]] = shown[: world.shown[agent]]
        exact, wrong = observe_state(profile, policy, replace(state, errors={})), observe_state(profile, policy, state)
        obs = np.where(exact == wrong, obs, wrong)
        actions.append(int(ir.act(policy, obs)[0]))
    return actions


def replay_state(
    origin: ir.PolicyProfile, view: View | None, claim: Formula, team: str, state: State, semantics: str
) -> Acted:
    """A team's actions in a state, by everything that can replay it here: of a view by the compiled C alone."""
    profile, world = (origin, matching_places(origin)) if view is None else (over(origin, view), None)
    with ReplayBuild(origin) as made:
        return confirm_actions(profile, claim, team, state, state_replays(made, profile, team, world), semantics)


def replay_course(profile: ir.PolicyProfile, state: State, steps: int) -> tuple[Episode, tuple[str, ...]]:
    """The episode from a start, and the names of everything that can play it here and took the same course.

    DisagreementError when one of them takes another course.
    """
    with ReplayBuild(profile) as made:
        players = rollouts(made, matching_places(profile))
        return agree_on_course(profile, state, steps, players), tuple(players)
