"""Scripted experts: controllers that read the whole world state, as bounds, teachers, opponents and stand-ins.

Does: one script a game, for any number of agents; landing on a point by short look-ahead, pursuit and flight; in
  coordination games, the convention that the agent's own readings demand.
Assumes: in games with places, the dynamics of `codegen/dynamics.py`, contacts left out of the look-ahead.
Does not: learn, or give a critic (expert.py measures one).
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from codegen.dynamics import accelerations, step_position, step_velocity
from codegen.errors import InputError
from codegen.ir import Bool, Float32, Float64
from maviper.worlds import CooperativeNavigation, Coordination, PhysicalDeception, PredatorPrey, World
from maviper.worlds.games.coordination import Decisions
from maviper.worlds.games.particle import WorldState, distances, planes
from maviper.worlds.games.predator_prey import PREDATORS, PREY, outside
from maviper.worlds.world import Int

PLANNED = 2  # actions that a look-ahead chooses; it coasts after them
HORIZON = 6  # steps whose distances it adds up
HELD = 4  # steps for which pursuit and flight imagine one action held
GAMES_AT_ONCE = 8_192  # bounds the memory of look-aheads
DIGITS = 9_973  # of a sum of coordinates, those behind the point are as if drawn
CACHED_GAMES = 1_024  # of which the distances of all steps ahead stay in a processor's cache
ROUGHLY = 1e-4  # costs in float32 that differ by more than this share, and by more than this, differ in float64 too
MIXING = np.uint64(0x9E3779B97F4A7C15)


@dataclass(frozen=True)
class Scripted:
    """The base of all scripts: an expert without networks. `q` is left to `measured.Measured`."""

    world: World
    hash: str = ""
    centralized: bool = field(default=True, init=False, repr=False)  # a script sees everything

    @property
    def agents(self) -> tuple[str, ...]:
        """The world's agents."""
        return self.world.agents

    @property
    def card(self) -> Mapping[str, Any]:
        """The card of a script: its algorithm and its world."""
        return {"algorithm": "scripted", "world": self.world.name}

    def q(self, agent: int, observations: Sequence[Float32], state: Any, joint: Int, given: Int) -> Float64:
        """InputError: a script has no critic."""
        raise InputError("a scripted expert has no critic", self.world.name, "measure Q: --critic measured")

    def act(self, agents: Sequence[int], observations: Sequence[Float32], state: Any) -> Int:
        """Returns the agents' actions, for GAMES_AT_ONCE games at a time; see `Controller.act`."""
        if len(state) <= GAMES_AT_ONCE:
            return self._act(agents, state)  # itself, of which the world knows what it has computed last
        parts = [self._act(agents, state[low : low + GAMES_AT_ONCE]) for low in range(0, len(state), GAMES_AT_ONCE)]
        return np.concatenate(parts)

    def _act(self, agents: Sequence[int], state: Any) -> Int:
        raise NotImplementedError

    def land(self, agents: Sequence[int], state: WorldState, landmarks: Int) -> Int:
        """The actions by which agents land on landmarks [len(agents), batch], [batch, len(agents)]."""
        position, velocity = planes(state.position), planes(state.velocity)
        targets = np.take_along_axis(position[len(self.agents) :], landmarks[:, None], axis=0)
        return self._landing(agents, targets - position[agents], velocity[agents])

    @cached_property
    def _landing(self) -> "Landing":
        return Landing(self.world)


class Landing:
    """Choosing the action that brings an agent onto a point and keeps it there.

    All sequences of PLANNED actions are tried, coasting after them; the first action of the one with the least sum of
    distances over HORIZON steps is taken (the first of equals). Exact while nothing pushes and no speed limit binds.
    """

    def __init__(self, world: World) -> None:
        spec = world.spec
        effects = np.array([action.effect or (0.0, 0.0) for action in world.actions[0]]).T
        self.force = [entity.force for entity in spec.agents]
        moved = speed = np.zeros((2, *[1] * PLANNED))
        moves: list[Float64] = []  # for a unit force, [2, ...]: an axis for each action that it depends on
        coasts: list[float] = []  # displacement for a unit velocity
        coasted, damped = 0.0, 1.0
        for step in range(HORIZON):
            shape = [effects.shape[1] if place == step else 1 for place in range(PLANNED)]
            push = effects.reshape(2, *shape) if step < PLANNED else np.zeros_like(speed)
            moved, speed = step_position(spec, moved, speed), step_velocity(spec, speed, push)
            moves.append(moved)
            coasted, damped = step_position(spec, coasted, damped), step_velocity(spec, damped, 0.0)
            coasts.append(coasted)
        plans = np.broadcast_shapes(*(moved.shape for moved in moves))
        self.moved = np.stack([np.broadcast_to(moved, plans).reshape(2, -1) for moved in moves], axis=1)
        self.coasted = np.array(coasts)[:, None]
        self.further = effects.shape[1] ** (PLANNED - 1)  # plans of one first action, which lie side by side

    def __call__(self, agents: Sequence[int], offset: Float64, velocity: Float64) -> Int:
        """The actions of some agents, [batch, len(agents)]; `offset` to their targets and `velocity`:
        [len(agents), 2, batch].

        Games are often the same to an agent: branches of a state by what another does. Each is looked at once.
        """
        actions = np.empty((offset.shape[2], len(agents)), dtype=np.int64)
        forces = np.array([self.force[agent] for agent in agents])
        for force in set(forces.tolist()):
            some = forces == force
            asked = np.concatenate([offset[some], velocity[some]], axis=1).transpose(1, 0, 2).reshape(4, -1)
            alike = _find_alike(asked)
            once = np.flatnonzero(alike == np.arange(len(alike)))
            first = np.empty(len(alike), dtype=np.int64)
            for low in range(0, len(once), CACHED_GAMES):
                rows = once[low : low + CACHED_GAMES]
                first[rows] = self._first(force, asked[:, rows])
            actions[:, some] = first[alike].reshape(int(some.sum()), -1).T
        return actions

    def _first(self, force: float, asked: Float64) -> Int:
        """The first actions of the best plans: by half the digits where they tell it, as they nearly always do."""
        rough = self._costs(force, asked, np.float32)
        least = rough.reshape(-1, self.further, rough.shape[1]).min(axis=1)
        near = least <= least.min(axis=0) * (1 + ROUGHLY) + ROUGHLY
        first = near.argmax(axis=0)
        unsure = np.flatnonzero(near.sum(axis=0) != 1)
        if len(unsure):
            first[unsure] = self._costs(force, asked[:, unsure], np.float64).argmin(axis=0) // self.further
        return first

    def _costs(self, force: float, asked: Float64, digits: type[np.floating[Any]]) -> Any:
        """The sums of the distances of all plans, [n_plans, batch], in so many digits."""
        left = (asked[:2, None] - self.coasted * asked[2:, None]).astype(digits)
        moved = (self.moved * force).astype(digits)
        first, second = _distances(left[:, :2], moved[:, :2, :: self.further])  # they depend on the first action alone
        costs = np.repeat(first + second, self.further, axis=0)
        for distance in _distances(left[:, 2:], moved[:, 2:]):
            costs += distance
        return costs


def _distances(left: Any, moved: Any) -> Any:
    """From the point, after each of some steps of some plans, [n_steps, n_plans, batch]."""
    squares = left[:, :, None] - moved[..., None]
    squares *= squares
    squares[0] += squares[1]
    return np.sqrt(squares[0], out=squares[0])


def _find_alike(columns: Float64) -> Int:
    """A column that is the same as each one, [n], bit for bit: the same for most that are alike. `columns`: [k, n]."""
    bits = np.ascontiguousarray(columns).view(np.uint64)
    mixed = np.zeros(columns.shape[1], dtype=np.uint64)
    for row in bits:
        mixed = (mixed ^ row) * MIXING
        mixed ^= mixed >> np.uint64(29)
    everybody, n_bits = np.arange(len(mixed)), len(mixed).bit_length() + 1
    slots, places = np.empty(2**n_bits, dtype=np.int64), (mixed >> np.uint64(64 - n_bits)).astype(np.int64)
    slots[places] = everybody
    found = slots[places]
    return np.where((bits == bits[:, found]).all(axis=0), found, everybody)


class SplitUp(Scripted):
    """Physical deception: defender k lands on landmark k, so that nothing it does depends on the goal; the adversary
    goes to the landmark that defenders are nearer to in sum.
    """

    def _act(self, agents: Sequence[int], state: WorldState) -> Int:
        position, n_agents = planes(state.position), len(self.agents)
        gaps = distances(position[1:n_agents, None], position[None, n_agents:])
        busiest = gaps.sum(axis=0).argmin(axis=0)
        landmarks = [busiest if agent == 0 else np.full(len(state), agent - 1) for agent in agents]
        return self.land(agents, state, np.array(landmarks))


class Assignment(Scripted):
    """Cooperative navigation: agents land on the landmarks of the assignment with the least sum of squared distances,
    in which no two straight paths cross.
    """

    def _act(self, agents: Sequence[int], state: WorldState) -> Int:
        from scipy.optimize import linear_sum_assignment

        assert isinstance(self.world, CooperativeNavigation)
        position = planes(state.position)
        moved = (position[..., 1:] != position[..., :-1]).any(axis=(0, 1))
        fresh = np.append(True, moved)[: len(state)]  # branches of one state lie side by side, all alike at first
        gaps = np.ascontiguousarray(self.world.gaps(state if moved.all() else state[fresh]).transpose(2, 0, 1))
        assigned = np.array([linear_sum_assignment(gap)[1] for gap in gaps], dtype=np.int64)
        landmarks = assigned.reshape(-1, len(self.agents)).T[agents][:, fresh.cumsum() - 1]
        return self.land(agents, state, landmarks)


class FixedRoles(Scripted):
    """Cooperative navigation: agent k lands on landmark k. Worse than `Assignment`, and far easier for a tree: no agent
    needs to see the others.
    """

    def _act(self, agents: Sequence[int], state: WorldState) -> Int:
        return self.land(agents, state, np.repeat(np.array(agents)[:, None], len(state), axis=1))


@dataclass(frozen=True)
class MixedRoles(Scripted):
    """Cooperative navigation: `Assignment` in a share of the episodes, and `FixedRoles` in the others. Which it is
    follows from where the landmarks lie, as if drawn, and stays so for the whole episode.
    """

    share: float = 0.5

    def _act(self, agents: Sequence[int], state: WorldState) -> Int:
        by_state = self.by_state(state)
        rows = np.flatnonzero(by_state)
        chosen = FixedRoles(self.world).act(agents, (), state)
        if len(rows):
            chosen[rows] = Assignment(self.world).act(agents, (), state[rows])
        return chosen

    def by_state(self, state: WorldState) -> Bool:
        """In which games roles follow from the state, [batch]."""
        landmarks = planes(state.position)[len(self.agents) :]
        return np.abs(landmarks.sum(axis=(0, 1)) * DIGITS) % 1 < self.share


class Chase(Scripted):
    """Predator-prey. A pursuer imagines each action held for HELD steps and takes the one after which it is nearest to
    the prey that is nearest now, all others keeping their velocities. A fleer takes the one after which its nearest
    predator is farthest, less the price of being outside the arena. Obstacles and contacts are not foreseen.
    """

    def _act(self, agents: Sequence[int], state: WorldState) -> Int:
        position, velocity = planes(state.position), planes(state.velocity)
        spec = self.world.spec
        hunters, prey = self.world.members(PREDATORS), self.world.members(PREY)
        ahead = position[: len(self.agents)] + HELD * spec.dt * velocity
        chosen: list[Int] = []
        for agent in agents:
            reached = self._hold_actions(agent, position[agent], velocity[agent])  # [n_actions, 2, batch]
            if agent in hunters:
                nearest = distances(position[agent], position[prey]).argmin(axis=0)
                target = np.take_along_axis(ahead[prey], nearest[None, None], axis=0)
                score = -distances(reached, target)
            else:
                score = distances(reached[:, None], ahead[hunters]).min(axis=1) - outside(np.abs(reached)).sum(axis=1)
            chosen.append(score.argmax(axis=0))
        return np.stack(chosen, axis=1)

    def _hold_actions(self, agent: int, position: Float64, velocity: Float64) -> Float64:
        """Where an agent is after holding each action, [n_actions, 2, batch]."""
        spec = self.world.spec
        entity = spec.agents[agent]
        push = accelerations(entity, self.world.actions[agent])[:, :, None]
        limit = entity.max_speed or np.inf
        place, speed = np.broadcast_to(position, (len(push), *position.shape)), velocity
        for _ in range(HELD):
            place, speed = step_position(spec, place, speed), step_velocity(spec, speed, push)
            size = np.sqrt(np.square(speed).sum(axis=1, keepdims=True))
            speed = speed * np.minimum(1.0, limit / np.maximum(size, 1e-12))
        return place


class AsRead(Scripted):
    """Coordination: each agent takes what it reads for what is hidden, and the convention that this demands. Without
    noise no team does better; with noise the agents' errors are independent, so a larger team errs more often.
    """

    def _act(self, agents: Sequence[int], state: Decisions) -> Int:
        assert isinstance(self.world, Coordination)
        return self.world.demanded[self.world.cell(state.readings[:, list(agents)])]


SCRIPTED, FIXED_ROLES = "scripted", "fixed-roles"
MIXED = re.compile(r"mixed-roles-(0?\.\d{1,3}|[01])")  # with the share of episodes in which roles follow from the state
_SCRIPTS: dict[str, tuple[tuple[type[World], type[Scripted]], ...]] = {
    SCRIPTED: (
        (PhysicalDeception, SplitUp),
        (CooperativeNavigation, Assignment),
        (PredatorPrey, Chase),
        (Coordination, AsRead),
    ),
    FIXED_ROLES: ((PhysicalDeception, SplitUp), (CooperativeNavigation, FixedRoles)),
}


def is_script(name: str) -> bool:
    """Returns True if a name stands for a script of some game."""
    return name in _SCRIPTS or MIXED.fullmatch(name) is not None


def build_script(world: World, script: str = SCRIPTED) -> Scripted:
    """A script of a game; InputError when there is none."""
    if world.continuous:
        advice = "train one, or bring your own"
        raise InputError("scripts choose among numbered actions, and here agents give numbers", world.name, advice)
    mixed = MIXED.fullmatch(script)
    if mixed and isinstance(world, CooperativeNavigation):
        return MixedRoles(world, share=float(mixed[1]))
    if mixed:
        raise InputError("roles are mixed in cooperative navigation alone", world.name, f"choose {FIXED_ROLES}")
    for game, made in _SCRIPTS[script]:
        if isinstance(world, game):
            return made(world)
    what = "scripted expert" if script == SCRIPTED else f"script with {script}"
    raise InputError(f"there is no {what} for this world", world.name, "train one, or bring your own")
