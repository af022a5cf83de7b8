"""Episodes of a game that break a claim about episodes.

Does: plays the game itself, in its own float64, from starts beside one that breaks the claim by its world file, or
  anywhere in its start region; says by how much each step and each observation was off of exact numbers.
Assumes: a world file of episodes, as verification/worlds.py states it, with the profile that it was written for.
Does not: decide: the episode is played again in exact numbers, which judge the claim.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from typing import TypeVar

import numpy as np

from codegen.ir import GOAL, Bool, Float64, PolicyProfile
from maviper.worlds.stated.observing import bound_region, ensure_observed, list_observed, place_in, with_noise
from verify.claims.values import Batch
from verify.reach.replay import Course
from verify.states.episodes import play
from verify.systems.claims import SystemClaim
from verify.systems.observing import choose_actions, list_roundings, with_roundings
from verify.systems.statement import Statement
from verify.systems.system import State

Number = TypeVar("Number")
SCALES = (None, -4, -8, -12, -16, -20, -24)  # powers of two: how far starts are drawn; None: only the nearest one
DRAWN, ANYWHERE, TRIED, SEED = 256, 4_096, 4, 0  # starts of a scale; of the whole region; of these, those replayed


@dataclass(frozen=True)
class PlayedGame:
    """A game and the world file about it."""

    origin: PolicyProfile  # as it was given
    profile: PolicyProfile  # as proofs read it
    statement: Statement
    goal: str | None  # the landmark at which it is in all starts; None in a game without goals

    def with_goal(self, at: Mapping[str, Number]) -> dict[str, Number]:
        """Coordinates with the goal's place, where its landmark is."""
        return {**at, **({f"{GOAL}.{axis}": at[f"{self.goal}.{axis}"] for axis in "xy"} if self.goal else {})}


def iterate_near(game: PlayedGame, claim: SystemClaim, start: State) -> Iterator[Course]:
    """Episodes of the game that seem to break a claim, from starts beside another one: the nearest first."""
    names, ends = _list_places(game)
    rng, near = np.random.default_rng(SEED), np.array([float(start[name]) for name in names])
    for power in SCALES:
        drawn = near[None] if power is None else near + 2.0**power * rng.uniform(-1.0, 1.0, (DRAWN, len(names)))
        yield from _iterate_broken(game, claim, np.clip(drawn, *ends.T))


def iterate_anywhere(game: PlayedGame, claim: SystemClaim) -> Iterator[Course]:
    """Episodes of the game that seem to break a claim, of some from anywhere in its start region."""
    names, ends = _list_places(game)
    drawn: Float64 = np.random.default_rng(SEED).uniform(ends[:, 0], ends[:, 1], (ANYWHERE, len(names)))
    yield from _iterate_broken(game, claim, drawn)


def _list_places(game: PlayedGame) -> tuple[list[str], Float64]:
    """The coordinates that a start chooses, and their float64 bounds [n, 2]: places of agents and landmarks."""
    world = game.origin.world
    entities = (*world.agents, *world.landmarks)
    known = {one.name for one in game.statement.system.variables}
    names = [f"{each.name}.{axis}" for each in entities for axis in "xy" if f"{each.name}.{axis}" in known]
    bounds = bound_region(game.statement.system.start, {one.name: one.range for one in game.statement.system.variables})
    ends = [[float(place_in(end, bounds[name], 0)) for end in bounds[name]] for name in names]
    return names, np.array(ends, np.float64)


def _iterate_broken(game: PlayedGame, claim: SystemClaim, drawn: Float64) -> Iterator[Course]:
    """The episodes from starts, [n, n_places], that seem to break a claim: the first few of them."""
    names, _ = _list_places(game)
    episodes = _play(game, claim, dict(zip(names, drawn.T, strict=True)), len(drawn))
    for row in np.flatnonzero(_seem_broken(claim, episodes, len(drawn)))[:TRIED]:
        states = [{name: Fraction(float(values[row])) for name, values in planes.items()} for planes in episodes]
        yield _course(game, states)


def _play(game: PlayedGame, claim: SystemClaim, places: Mapping[str, Float64], count: int) -> list[dict[str, Float64]]:
    """The game's variables after each step, by the names of the file, [batch] each."""
    names, at = game.origin.world.coordinates(), game.with_goal(places)
    start = np.stack([at.get(name, np.zeros(count)) for name in names], axis=1)
    known = {one.name for one in game.statement.system.variables}
    episodes, _ = play(game.origin, start, claim.steps)
    return [{name: rows[:, n] for n, name in enumerate(names) if name in known} for rows in episodes]


def _seem_broken(claim: SystemClaim, episodes: Sequence[Mapping[str, Float64]], count: int) -> Bool:
    """Returns True for episodes that seem to break a claim, but for roundings, [batch]."""
    broken, going = np.zeros(count, np.bool_), np.ones(count, np.bool_)
    for step, planes in enumerate(episodes):
        asked = Batch(planes, count)
        broken |= going & asked.holds(claim.violation_at(step), {})
        going &= ~broken & ~asked.holds(claim.fulfilment_at(step), {})
    return broken


def _course(game: PlayedGame, states: Sequence[State]) -> Course:
    """An episode of the game as one of the file: by how much each step, and each observation, was off. AssertionError
    where that is more than the file allows: a replay would cut it to its bounds, and play another episode.
    """
    origin, profile, statement = game.origin, game.profile, game.statement
    system = statement.system
    extended: list[State] = []
    for state in states:
        ensure_observed(origin, statement, noisy := with_noise(origin, statement, game.with_goal(state)))
        kept = {one.name: noisy[one.name] for one in system.variables}
        extended.append(with_roundings(statement, kept))
    anew = {each.rounding for policy in origin.agents for each in list_observed(policy)}
    anew |= set(list_roundings(statement))
    errors: list[dict[str, Fraction]] = []
    for before, after in pairwise(extended):
        (piece,) = system.pieces
        chosen = choose_actions(system, profile, before)
        joint = {each.agent: each.actions[chosen[each.agent]].name for each in profile.agents}
        exact = piece.step(before, joint, {})
        off = {name: after[name] - (0 if name in anew else exact[name]) for name in piece.error}
        beyond = [name for name, (low, high) in piece.error.items() if not low <= off[name] <= high]
        assert not beyond, f"the game moves {beyond[0]} otherwise than its world file allows"
        errors.append(off)
    return Course(extended[0], errors)
