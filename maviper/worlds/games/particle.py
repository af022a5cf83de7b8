"""Batched particle worlds: the dynamics and observations that all games share, thousands of episodes at once.

Does: starts, steps and observes a batch of games in numpy, with the arithmetic of mpe2 operation by operation: equal
  bit for bit without contacts, and with them if asked for, else within 1e-9 per step; a game adds its entities,
  features, rewards and measures.
Assumes: the features' meanings say how an observation is made from the world (the verifier assumes the same).
Does not: learn; render.

Arrays of states have the shapes that their comments give, but their memory is laid out in planes: all games' values of
one coordinate lie side by side, so that each operation runs over one contiguous row.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from codegen.dynamics import MPE2, Motion
from codegen.errors import InputError, UnknownNameError
from codegen.ir import FORK, PHYSICS, ActionSpec, Bool, EntitySpec, FeatureSpec, Float32, Float64, OutputSpec, WorldSpec
from codegen.observe import Observer
from maviper.worlds.games.features import COASTING, extend_features, groups_of
from maviper.worlds.seeds import generators
from maviper.worlds.world import CONTINUOUS, FEATURES, Int, Options, World
from verify.states.values import has_matching

# mpe2's discrete actions, in its order
ACTIONS = (
    ActionSpec("stay", (0.0, 0.0)),
    ActionSpec("left", (-1.0, 0.0)),
    ActionSpec("right", (1.0, 0.0)),
    ActionSpec("down", (0.0, -1.0)),
    ActionSpec("up", (0.0, 1.0)),
)
# mpe2's continuous actions: a number for each of them. It takes the differences of right and left, and of up and down.
OUTPUTS = tuple(OutputSpec(action.name, "none", 0.0, 1.0) for action in ACTIONS)
PHYSICS_NAMES = (MPE2, FORK)
FORKS = "the authors' fork of multiagent-particle-envs"
FORK_MOTION = "velocities change first and positions move with the new ones; stated accelerations count twice"
DT = 0.1
DAMPING = 0.25
FORCE = 5.0  # of an agent without an acceleration of its own
CONTACT_FORCE = 100.0
CONTACT_MARGIN = 1e-3
EPISODE_STEPS = 25
MAX_MATCHED = 6  # beyond it, matching a whole batch by sets of targets takes longer than one game after the other
# The released evaluation compares squared distances with 0.1, so the radius of the paper's tables is its root, 0.316.
SQUARED_RADII = (0.1, 0.1**2)
SUCCESS = tuple(f"success r={squared**0.5:.3g}" for squared in SQUARED_RADII)
# glibc gives arrays larger than any that was freed back to the system, which then clears each page of the next one
# again: a quarter of the time of steps of many games. So one of nearly 32 MiB, the most it heeds, is freed first.
np.empty(31 << 20, np.uint8)


@dataclass(frozen=True)
class WorldState:
    """A batch of world states; entities are the agents, then the landmarks."""

    position: Float64  # [batch, n_entities, 2], length units
    velocity: Float64  # [batch, n_agents, 2], length units / s
    goal: Int  # [batch] index of the goal landmark; 0 where the game has no goal

    def __len__(self) -> int:
        return len(self.position)

    def __getitem__(self, rows: Any) -> "WorldState":
        return WorldState(self.position[rows], self.velocity[rows], self.goal[rows])

    @staticmethod
    def concatenate(states: Sequence["WorldState"]) -> "WorldState":
        """Several batches as one, in their order."""
        position = np.concatenate([planes(state.position) for state in states], axis=2)
        velocity = np.concatenate([planes(state.velocity) for state in states], axis=2)
        return WorldState(games(position), games(velocity), np.concatenate([state.goal for state in states]))


def planes(array: Float64) -> Float64:
    """[batch, n, 2] as contiguous planes [n, 2, batch]; no copy where it is laid out so already."""
    return np.ascontiguousarray(array.transpose(1, 2, 0))


def games(array: Float64) -> Float64:
    """Planes [n, 2, batch] as [batch, n, 2], without a copy."""
    return array.transpose(2, 0, 1)


class ParticleWorld(World):
    """A game of mpe2. Subclasses state `spec`, `teams`, `features`, `actions`, `measures`, rewards and values."""

    shown: tuple[int, ...]  # per agent, how many of its features, the first ones, the reference environment shows
    _moving: WorldSpec | None = None  # by which the world moves, where its spec states no motion

    # --- starting

    def start(self, n: int, rng: np.random.Generator) -> WorldState:
        """`n` random start states from one generator: at rest, positions uniform in the start regions, goal uniform."""
        goal = rng.integers(max(1, len(self.spec.goals)), size=n)
        position = np.stack([rng.uniform(*self._start_bounds(entity), (2, n)) for entity in self._entities])
        return WorldState(games(position), games(np.zeros((len(self.spec.agents), 2, n))), goal)

    def start_from_seeds(self, seeds: Sequence[int] | Int) -> WorldState:
        """The start states of the reference environment after `reset(seed=...)`, one for each seed."""
        bounds = [self._start_bounds(entity) for entity in self._entities]
        of_each, n_goals = np.array(bounds), len(self.spec.goals)
        same = (of_each == of_each[0]).all()  # of numbers a generator draws the same as of arrays, in less time
        low, high = bounds[0] if same else (of_each[:, :1], of_each[:, 1:])
        position, goal = np.empty((len(seeds), len(bounds), 2)), np.zeros(len(seeds), dtype=np.int64)
        for row, rng in enumerate(generators(seeds)):
            if n_goals:
                goal[row] = rng.integers(n_goals)
            position[row] = rng.uniform(low, high, (len(bounds), 2))
        velocity = np.zeros((len(self.spec.agents), 2, len(seeds)))
        return WorldState(games(planes(position)), games(velocity), goal)

    @property
    def _entities(self) -> tuple[EntitySpec, ...]:
        return self.spec.agents + self.spec.landmarks

    def _start_bounds(self, entity: EntitySpec) -> tuple[float, float]:
        return entity.start or (self.spec.start_low, self.spec.start_high)

    # --- dynamics

    @cached_property
    def _quick(self) -> Motion:
        return Motion(self.moving, self.actions, quick=True, velocity_first=self._forked)

    @cached_property
    def _exact(self) -> Motion:
        return Motion(self.moving, self.actions, quick=False, velocity_first=self._forked)

    @property
    def moving(self) -> WorldSpec:
        """The spec by which the world moves, where its own states no motion."""
        return self._moving or self.spec

    @property
    def _forked(self) -> bool:
        return self.spec.options.get(PHYSICS) == FORK

    @property
    def rewards_lag(self) -> bool:
        """True where positions, of which rewards tell, move with the old velocity."""
        return not self._forked

    def choose_physics(self, physics: str, spec: WorldSpec) -> WorldSpec:
        """The spec of a world that moves by mpe2's `physics`, or by those of the authors' fork: velocities change
        first, and positions move with the new ones. What steps, proves or draws a world reads its spec, which can state
        mpe2's order alone. So the spec of the other one states no motion (a `dt` of 0): nothing can step it wrongly.
        """
        if physics not in PHYSICS_NAMES:
            raise UnknownNameError(PHYSICS, physics, PHYSICS_NAMES, spec.name)
        if physics == MPE2:
            return spec
        if COASTING in groups_of(str(spec.options.get(FEATURES, ""))):
            what = f"the features '{COASTING}' tell where an agent comes to rest by mpe2's physics"
            raise InputError(what, f"{spec.name}: {PHYSICS}={physics}", "leave one of the two out")
        self._moving = spec
        return replace(spec, dt=0.0, damping=0.0, reference=FORKS)

    def choose_acting(self, continuous: int, spec: WorldSpec) -> WorldSpec:
        """The spec of a world in which agents choose among mpe2's actions, or give its numbers (`continuous`). What
        steps, proves or draws a world by its spec takes numbered actions. So the spec of the other one states no motion
        either: nothing can step it wrongly.
        """
        if not continuous:
            return spec
        if self._forked:
            what = f"agents give numbers by mpe2's physics alone ({CONTINUOUS}=1)"
            raise InputError(what, f"{spec.name}: {PHYSICS}={FORK}", "leave one of the two out")
        self.actions, self.outputs = tuple(() for _ in spec.agents), tuple(OUTPUTS for _ in spec.agents)
        self._moving = spec
        return replace(spec, dt=0.0, damping=0.0)

    def ensure_reference(self) -> None:
        """InputError where no environment that can be installed moves as this world does."""
        if self._forked:
            what = f"no environment that can be installed moves as the authors' code ({PHYSICS}={FORK})"
            raise InputError(what, self.name, f"name the world without {PHYSICS}={FORK}")

    def step(self, state: WorldState, actions: Any, exact: bool = False) -> WorldState:
        """The next states. `actions`: [batch, n_agents] indices, or numbers [batch, n_agents, n_outputs] float32.
        Positions move first, with the old velocity, except by the physics of the authors' fork.

        `exact`: contacts that push by less than 1e-17 push too, so a step is mpe2's bit for bit.
        """
        motion = self._exact if exact else self._quick
        before = planes(state.position), planes(state.velocity)
        if self.continuous:
            left, right, down, up = np.moveaxis(actions[..., 1:], (2, 1), (0, 1))  # [n_agents, batch] each
            pushed = np.stack([right - left, up - down], axis=1).astype(np.float64)  # float32 differences, as in mpe2
            units = np.array([agent.force for agent in self.spec.agents])
            position, velocity = motion.step_pushed(*before, pushed * units[:, None, None])
        else:
            position, velocity = motion.step(*before, actions)
        return WorldState(games(position), games(velocity), state.goal)

    # --- observations

    def extend_features(
        self, base: Sequence[Sequence[FeatureSpec]], chosen: str
    ) -> tuple[tuple[FeatureSpec, ...], ...]:
        """Each agent's features with those of the groups that the option `features` names. InputError for a group that
        adds nothing to any agent's.
        """
        per_agent = list(base)
        for group in groups_of(chosen):
            more: list[tuple[FeatureSpec, ...]] = []
            for agent, features in zip(self.agents, per_agent, strict=True):
                mates = [name for name in self.teams[self.team_of(agent)] if name != agent]
                more.append(extend_features(features, group, agent, mates, self.spec))
            if more == [tuple(features) for features in per_agent]:
                raise InputError(f"the features '{group}' add nothing here", self.name, "leave them out")
            per_agent = more
        return tuple(tuple(features) for features in per_agent)

    def coordinates(self, state: WorldState) -> Float64:
        """All world coordinates, [batch, n_coordinates], in the order of `spec.coordinates()`."""
        parts = [planes(state.position)]
        if self.spec.goals:
            parts.append(planes(self.goal_position(state)[:, None]))
        parts.append(planes(state.velocity))
        return np.concatenate([part.reshape(2 * len(part), len(state)) for part in parts]).T

    def goal_position(self, state: WorldState) -> Float64:
        """Where each game's goal is, [batch, 2]."""
        landmarks = planes(state.position)[len(self.spec.agents) :]
        return landmarks.transpose(1, 0, 2)[:, state.goal, np.arange(len(state))].T

    @cached_property
    def _observer(self) -> Observer:
        return Observer([feature for features in self.features for feature in features], self.spec)

    def observe(self, state: WorldState) -> tuple[Float32, ...]:
        """Each agent's observation, [batch, n_features] float32: subtracted in float64, then rounded."""
        seen = self._observer(self.coordinates(state).T)
        ends = np.cumsum([len(features) for features in self.features])[:-1]
        return tuple(part.T for part in np.split(seen.astype(np.float32, copy=False), ends))


def distances(a: Float64, b: Float64) -> Float64:
    """Distances between points given as planes: [..., 2, batch] and [..., 2, batch] -> [..., batch]."""
    return np.sqrt(squared_distances(a, b))


def squared_distances(a: Float64, b: Float64) -> Float64:
    """Squares of `distances`."""
    gap = a - b
    gap *= gap
    return gap[..., 0, :] + gap[..., 1, :]


def covers_targets(near: Bool) -> Bool:
    """Returns True if every target has an agent of its own, [batch]. `near`: [n_agents, n_landmarks, batch], square."""
    possible = np.asarray(near.any(axis=0).all(axis=0))
    rows = np.flatnonzero(possible)
    if len(near) <= MAX_MATCHED:
        possible[rows] = has_matching(near[..., rows].transpose(2, 0, 1))
    else:
        from scipy.optimize import linear_sum_assignment

        games_near = (near[..., row] for row in rows)
        possible[rows] = [one[linear_sum_assignment((~one).astype(np.float64))].all() for one in games_near]
    return possible


# --- specs that games share


def mpe2_spec(
    options: Options,
    name: str,
    reference: str,
    agents: Iterable[EntitySpec],
    landmarks: Iterable[EntitySpec],
    has_goal: bool = False,
) -> WorldSpec:
    """The spec of a game with mpe2's dynamics. `options`: those that differ from its defaults."""
    movers, fixed = tuple(agents), tuple(landmarks)
    contacts = any(entity.collides for entity in movers)
    return WorldSpec(
        name=name,
        reference=reference,
        agents=movers,
        landmarks=fixed,
        goals=tuple(entity.name for entity in fixed) if has_goal else (),
        dt=DT,
        damping=DAMPING,
        start_low=-1.0,
        start_high=1.0,
        episode_steps=EPISODE_STEPS,
        contact_force=CONTACT_FORCE if contacts else 0.0,
        contact_margin=CONTACT_MARGIN if contacts else 0.0,
        options=dict(options),
    )


def place_entities(env: Any, state: WorldState) -> Any:
    """Puts the reference environment into one world state (`state` has batch 1) and returns the environment."""
    world = env.aec_env.unwrapped.world
    for entity, position in zip(world.agents + world.landmarks, state.position[0], strict=True):
        entity.state.p_pos = position.copy()
        entity.state.p_vel = np.zeros(2)
    for agent, speed in zip(world.agents, state.velocity[0], strict=True):
        agent.state.p_vel = speed.copy()
        if world.landmarks:
            agent.goal_a = world.landmarks[int(state.goal[0])]
    return env
