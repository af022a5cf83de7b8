"""Episodes from one start, in our simulator, by the compiled C and in the reference environment.

Does: gives the verifier what replays a counterexample to a claim about episodes.
Assumes: the profile's world is one of ours.
Does not: judge; the verifier compares every position, velocity and action bit by bit.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import partial

import numpy as np

from codegen import ir
from codegen.compiled import CompiledC
from codegen.ir import Float32, Int32, PolicyProfile
from maviper.worlds import ParticleWorld, WorldState
from maviper.worlds.particle import placed
from verify.rollout import Course, Rollout
from verify.world import Point

Decide = Callable[[str, Float32], Int32]  # an agent and its observations [batch, n_features] -> actions [batch]


def rollouts(profile: PolicyProfile, world: ParticleWorld | None, compiled: CompiledC | None) -> Mapping[str, Rollout]:
    """What can replay episodes of a profile, by name."""
    if world is None:
        return {}
    found: dict[str, Rollout] = {"simulator": partial(_simulated, profile, world, partial(_by_tree, profile))}
    if compiled is not None:
        found["compiled C"] = partial(_simulated, profile, world, compiled.act)
    found[profile.world.reference] = partial(_in_reference, profile, world)
    return found


def _by_tree(profile: PolicyProfile, agent: str, obs: Float32) -> Int32:
    return ir.act(profile.policy(agent), obs)


def state_of(profile: PolicyProfile, point: Point) -> WorldState:
    """A world state (batch 1) at a point; velocities that the point leaves out are zero."""
    return states_of(profile.world, [point])


def states_of(world: ir.WorldSpec, points: Sequence[Point]) -> WorldState:
    """The world states at points, in their order; velocities that a point leaves out are zero."""
    entities = [entity.name for entity in world.agents + world.landmarks]
    marks = [entity.name for entity in world.landmarks]
    position = [[[point.position[f"{name}.{axis}"] for axis in "xy"] for name in entities] for point in points]
    goal = [marks.index(point.goal) if point.goal else 0 for point in points]
    speed = [
        [[point.position.get(f"{agent.name}.v{axis}", 0.0) for axis in "xy"] for agent in world.agents]
        for point in points
    ]
    return WorldState(np.array(position), np.array(speed), np.array(goal))


def _simulated(profile: PolicyProfile, world: ParticleWorld, decide: Decide, point: Point, steps: int) -> Course:
    """In our simulator."""
    state = state_of(profile, point)
    course, actions = [world.coordinates(state)[0]], []
    for _ in range(steps):
        seen = world.observe(state)
        chosen = [int(decide(agent, obs)[0]) for agent, obs in zip(world.agents, seen, strict=True)]
        state = world.step(state, np.array([chosen]))
        course.append(world.coordinates(state)[0])
        actions.append(chosen)
    return _course(world, course, actions)


def _in_reference(profile: PolicyProfile, world: ParticleWorld, point: Point, steps: int) -> Course:
    """In the reference environment, on what it shows; features that it does not have are observed by their meanings."""
    env = world.reference_env()
    env.reset(seed=0)
    state = state_of(profile, point)
    placed(env, state)
    inner = env.aec_env.unwrapped
    inner.max_cycles = steps + 1
    course, actions = [world.coordinates(state)[0]], []
    for _ in range(steps):
        chosen = []
        for number, (agent, obs) in enumerate(zip(world.agents, world.observe(state), strict=True)):
            seen = obs.copy()
            seen[0, : world.shown[number]] = inner.observe(agent)[: world.shown[number]]
            chosen.append(int(_by_tree(profile, agent, seen)[0]))
        env.step(dict(zip(world.agents, chosen, strict=True)))
        entities = inner.world.agents + inner.world.landmarks
        position = np.array([[entity.state.p_pos for entity in entities]])
        velocity = np.array([[agent.state.p_vel for agent in inner.world.agents]])
        state = WorldState(position, velocity, state.goal)
        course.append(world.coordinates(state)[0])
        actions.append(chosen)
    return _course(world, course, actions)


def _course(world: ParticleWorld, course: list[ir.Float64], actions: list[list[int]]) -> Course:
    return Course(np.array(course), np.array(actions, dtype=np.int64).reshape(len(actions), len(world.agents)))
