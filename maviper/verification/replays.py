"""Episodes from one start, in our simulator, by the compiled C and in the reference environment.

Does: gives the verifier what replays a counterexample to a claim about episodes.
Assumes: the profile's world is one of ours.
Does not: judge; the verifier compares every position, velocity and action bit by bit. Our simulator steps as the
  verifier's referee does (codegen/dynamics.py), so of the motion itself only the reference environment is a second
  reading; that our steps are its steps is also tested apart.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import partial

import numpy as np

from codegen import ir
from codegen.agreement.compiled import Build
from codegen.errors import escape_text
from codegen.ir import Float32, Int32, PolicyProfile
from maviper.worlds import ParticleWorld, WorldState
from maviper.worlds.games.particle import place_entities
from verify.states.episodes import Episode, EpisodeReplay
from verify.states.state import State

Decide = Callable[[str, Float32], Int32]  # an agent and its observations [batch, n_features] -> actions [batch]


def rollouts(made: Build, world: ParticleWorld | None) -> Mapping[str, EpisodeReplay]:
    """Returns the functions that can replay episodes of a profile, by name."""
    if world is None:
        return {}
    profile = made.profile
    players: dict[str, EpisodeReplay] = {
        "simulator": partial(_simulate_episode, profile, world, partial(_by_tree, profile))
    }
    if made.compilable:
        players["compiled C"] = partial(_simulate_episode, profile, world, partial(_by_library, made))
    players[escape_text(profile.world.reference)] = partial(_in_reference, profile, world)
    return players


def _by_tree(profile: PolicyProfile, agent: str, obs: Float32) -> Int32:
    return ir.act(profile.policy(agent), obs)


def _by_library(made: Build, agent: str, obs: Float32) -> Int32:
    return made.library.act(agent, obs)  # compiled for the first replay


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


def _in_reference(profile: PolicyProfile, world: ParticleWorld, state: State, steps: int) -> Episode:
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
