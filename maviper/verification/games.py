"""What breaks a claim about a stated world outside of its proof: in the game, in the environment, by rules as written.

Does: finds states, and plays episodes in the game's own float64, that seem to break one, beside a known one or
  anywhere; says by how much each step and each observation was off of exact numbers; plays episodes by the rules;
  measures how far the statement is from the environment, and what that says of a counterexample.
Assumes: of a game a world file that states what agents observe, up to errors for their roundings, as worlds.py states
  it; features with meanings, agents that take actions. Else a statement and a profile that plays in it.
Does not: decide: whatever is found is judged in exact numbers, by whoever asked for it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import chain, pairwise
from typing import Any, TypeVar

import numpy as np

from codegen.errors import InputError
from codegen.floats import FLOAT64
from codegen.ir import GOAL, AgentPolicy, Bool, Float64, Floats, PolicyProfile, act
from codegen.observe import observe
from maviper.worlds.stated.deviation import Reference, deviation, is_known
from maviper.worlds.stated.observing import (
    PLACE,
    ensure_observed,
    find_coordinate,
    find_goal,
    list_observed,
    place_in,
    with_noise,
)
from maviper.worlds.stated.systems import box
from maviper.worlds.stated.systems import start as draw_start
from verify.claims.formula import holds
from verify.claims.region import Interval
from verify.reach.play import Starts, courses
from verify.reach.replay import Course, replay_course, within
from verify.reach.results import SystemCounterexample
from verify.reach.written import WrittenReplay
from verify.reports import systems
from verify.states.episodes import play
from verify.states.values import Batch
from verify.systems.claims import SystemClaim
from verify.systems.observing import choose_actions, list_roundings, observe_state, with_roundings
from verify.systems.statement import Statement
from verify.systems.system import State, Variable, bounds_of
from verify.verdicts.systems import SystemResult

Number = TypeVar("Number")
# powers of two: how far states are drawn from one where a claim may fail
STATE_SCALES = (-2, -6, -10, -14, -18, -22, -26)
DRAWN_STATES, TRIED, SEED = 1_024, 4, 0  # states of a scale; of these, those that are replayed
STATES = 16_384  # states that are drawn in a whole region
EXTREME = 0.5  # of drawn errors, those at an end of their bounds


def iterate_states_near(
    profile: PolicyProfile, statement: Statement, claim: SystemClaim, state: State
) -> Iterator[State]:
    """States of the game beside another one: float64 coordinates and errors, the goal at a landmark, and the roundings
    that the game makes there. First the nearest ones, then those of some farther away in which the claim seems to fail.
    """
    drawable, marks = _list_drawable(profile, statement), [mark.name for mark in profile.world.landmarks]
    at_goal = (mark for mark in marks if all(state.get(f"{PLACE}.{axis}") == state[f"{mark}.{axis}"] for axis in "xy"))
    goal = next(at_goal, None)  # None: the game has none, or it is at no landmark
    ranges = _list_ranges(drawable)
    boxes = [bounds_of(region, ranges) for region in claim.regions] or [ranges]
    bounds = {  # of the box around all regions of the claim, but for differences
        one.name: (min(each[one.name][0] for each in boxes), max(each[one.name][1] for each in boxes))
        for one in drawable
    }
    for step in (0, 1, -1):
        moved = {one.name: place_in(state[one.name], bounds[one.name], step) for one in drawable}
        yield with_noise(profile, statement, {**moved, **_at_goal(goal, moved)})
    rng, near = np.random.default_rng(SEED), np.array([state[one.name] for one in drawable], np.float64)
    ends = _find_ends(drawable, bounds)
    for power in STATE_SCALES:
        drawn: Float64 = np.clip(near + 2.0**power * rng.uniform(-1.0, 1.0, (DRAWN_STATES, len(near))), *ends.T)
        yield from _iterate_broken_states(profile, statement, claim, goal, drawn)


def iterate_states(profile: PolicyProfile, statement: Statement, claim: SystemClaim) -> Iterator[State]:
    """Some states of the game, of those drawn in the claim's regions, in which it seems to fail. Where none breaks it,
    others follow, with many coordinates at an end of their bounds, where sums are largest.
    """
    drawable, rng = _list_drawable(profile, statement), np.random.default_rng(SEED)
    erring = np.array([find_coordinate(one.name) not in profile.world.coordinates() for one in drawable])
    for pushed in (erring, np.ones_like(erring)):
        for region in claim.regions:
            ends = _find_ends(drawable, bounds_of(region, _list_ranges(drawable)))
            drawn: Float64 = rng.uniform(ends[:, 0], ends[:, 1], (STATES, len(drawable)))
            if pushed.any():
                extreme: Bool = pushed & (rng.random(drawn.shape) < EXTREME)
                at_ends: Float64 = np.where(rng.random(drawn.shape) < 1 / 2, ends[:, 0], ends[:, 1])
                drawn = np.where(extreme, at_ends, drawn)
            yield from _iterate_broken_states(profile, statement, claim, find_goal(region), drawn)


def _list_drawable(profile: PolicyProfile, statement: Statement) -> list[Variable]:
    """The variables that a state of the game chooses: coordinates but the goal's place, and errors."""
    names = set(profile.world.coordinates())
    names |= {each.error for policy in profile.agents for each in list_observed(policy)}
    return [one for one in statement.system.variables if one.name in names]


def _find_ends(drawable: Sequence[Variable], bounds: Mapping[str, Interval]) -> Float64:
    """The float64 numbers within bounds, [n_drawable, 2]."""
    return np.array([[place_in(end, bounds[one.name], 0) for end in bounds[one.name]] for one in drawable], np.float64)


def _iterate_broken_states(
    profile: PolicyProfile, statement: Statement, claim: SystemClaim, goal: str | None, drawn: Float64
) -> Iterator[State]:
    """The first of drawn numbers, [n, n_drawable], in which the claim seems to fail."""
    names = [one.name for one in _list_drawable(profile, statement)]
    planes = dict(zip(names, drawn.T, strict=True))
    planes |= _at_goal(goal, planes)
    for row in np.flatnonzero(_seem_broken_states(profile, claim, planes, len(drawn)))[:TRIED]:
        moved = {name: Fraction(float(values[row])) for name, values in planes.items()}
        yield with_noise(profile, statement, moved)


def _list_ranges(drawable: Sequence[Variable]) -> dict[str, Interval]:
    return {one.name: one.range for one in drawable}


def _at_goal(goal: str | None, at: Mapping[str, Number]) -> dict[str, Number]:
    """The goal's place, where a landmark is."""
    return {f"{PLACE}.{axis}": at[f"{goal}.{axis}"] for axis in "xy"} if goal else {}


def _seem_broken_states(profile: PolicyProfile, claim: SystemClaim, planes: Mapping[str, Float64], count: int) -> Bool:
    """In which states the game's own agents seem to break a claim, but for roundings, [batch]."""
    at = {find_coordinate(name): values for name, values in planes.items()}
    rows = np.zeros((count, len(profile.world.coordinates())))
    for place, name in enumerate(profile.world.coordinates()):
        rows[:, place] = at.get(name, 0.0)
    actions = {each.agent: act(each, _observe_off(profile, each, rows, planes)) for each in profile.agents}
    asked = Batch(planes, count)
    return asked.holds(claim.inside, actions) & ~asked.holds(claim.formula, actions)


def _observe_off(profile: PolicyProfile, policy: AgentPolicy, rows: Float64, planes: Mapping[str, Float64]) -> Floats:
    """Returns an agent's observations where some features are off, but for the last digit, [batch, n_features]."""
    seen = observe(policy.features, rows, profile.world, policy.numbers)
    for each in list_observed(policy):
        if each.error in planes:
            place = policy.features.index(each.feature)
            bare = (replace(each.feature, meaning=replace(each.meaning, function="")),)
            off = observe(bare, rows, profile.world, FLOAT64)[:, 0] + planes[each.error]
            function = each.meaning.function
            seen[:, place] = off > 0 if function == "positive" else np.sign(off) if function else off
    return seen


START_SCALES = (None, -4, -8, -12, -16, -20, -24)  # powers of two: how far starts are drawn; None: only the nearest one
DRAWN_STARTS, STARTS = 256, 4_096  # of a scale, and of the whole region


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


def iterate_courses_near(game: PlayedGame, claim: SystemClaim, start: State) -> Iterator[Course]:
    """Episodes of the game that seem to break a claim, from starts beside another one: the nearest first."""
    names, ends = _list_places(game)
    rng, near = np.random.default_rng(SEED), np.array([float(start[name]) for name in names])
    for power in START_SCALES:
        drawn = near[None] if power is None else near + 2.0**power * rng.uniform(-1.0, 1.0, (DRAWN_STARTS, len(names)))
        yield from _iterate_broken_courses(game, claim, np.clip(drawn, *ends.T))


def iterate_courses(game: PlayedGame, claim: SystemClaim) -> Iterator[Course]:
    """Episodes of the game that seem to break a claim, of some from anywhere in its start region."""
    names, ends = _list_places(game)
    drawn: Float64 = np.random.default_rng(SEED).uniform(ends[:, 0], ends[:, 1], (STARTS, len(names)))
    yield from _iterate_broken_courses(game, claim, drawn)


def _list_places(game: PlayedGame) -> tuple[list[str], Float64]:
    """The coordinates that a start chooses, and their float64 bounds [n, 2]: places of agents and landmarks."""
    world = game.origin.world
    entities = (*world.agents, *world.landmarks)
    known = {one.name for one in game.statement.system.variables}
    names = [f"{each.name}.{axis}" for each in entities for axis in "xy" if f"{each.name}.{axis}" in known]
    bounds = bounds_of(game.statement.system.start, {one.name: one.range for one in game.statement.system.variables})
    ends = [[float(place_in(end, bounds[name], 0)) for end in bounds[name]] for name in names]
    return names, np.array(ends, np.float64)


def _iterate_broken_courses(game: PlayedGame, claim: SystemClaim, drawn: Float64) -> Iterator[Course]:
    """The episodes from starts, [n, n_places], that seem to break a claim: the first few of them."""
    names, _ = _list_places(game)
    episodes = _play(game, claim, dict(zip(names, drawn.T, strict=True)), len(drawn))
    for row in np.flatnonzero(_seem_broken_courses(claim, episodes, len(drawn)))[:TRIED]:
        states = [{name: Fraction(float(values[row])) for name, values in planes.items()} for planes in episodes]
        yield _tell_errors(game, states)


def _play(game: PlayedGame, claim: SystemClaim, places: Mapping[str, Float64], count: int) -> list[dict[str, Float64]]:
    """The game's variables after each step, by the names of the file, [batch] each."""
    names, at = game.origin.world.coordinates(), game.with_goal(places)
    start = np.stack([at.get(name, np.zeros(count)) for name in names], axis=1)
    known = {one.name for one in game.statement.system.variables}
    episodes, _ = play(game.origin, start, claim.steps)
    return [{name: rows[:, n] for n, name in enumerate(names) if name in known} for rows in episodes]


def _seem_broken_courses(claim: SystemClaim, episodes: Sequence[Mapping[str, Float64]], count: int) -> Bool:
    """Returns True for episodes that seem to break a claim, but for roundings, [batch]."""
    broken, going = np.zeros(count, np.bool_), np.ones(count, np.bool_)
    for step, planes in enumerate(episodes):
        asked = Batch(planes, count)
        broken |= going & asked.holds(claim.violation_at(step), {})
        going &= ~broken & ~asked.holds(claim.fulfilment_at(step), {})
    return broken


def _tell_errors(game: PlayedGame, states: Sequence[State]) -> Course:
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


def measure_reference(statement: Statement, run: bool) -> dict[str, Any]:
    """Measures how far the statement is from its reference in 100,000 steps. InputError if farther than it says."""
    name = statement.system.reference
    if not name or not statement.rules:
        return {}
    if not (run or is_known(name)):
        said = f"{name} is code that the file names; it was not run, so nothing was measured (--run-reference runs it)"
        return {"name": name, "said": [said]}
    measurement = deviation(statement)
    if measurement.beyond:
        beyond = f"{measurement.beyond} of {measurement.steps} steps are beyond its error"
        what = f"the statement is not that of {name}: {beyond}"
        raise InputError(what, measurement.worst, "widen the error of the variable, narrow its range, or mend the rule")
    off = {variable: list(bounds) for variable, bounds in measurement.off.items()}
    reach = ", ".join(f"{variable} {systems.upwards(max(map(abs, bounds)), 2)}" for variable, bounds in off.items())
    said = f"{name}: {measurement.steps} steps were measured, off by at most {reach}"
    return {"name": name, "steps": measurement.steps, "anywhere": measurement.placed, "off": off, "said": [said]}


def replay_words(statement: Statement, profile: PolicyProfile, result: SystemResult) -> str:
    """Describes what the environment says of a counterexample."""
    if result.counterexample is None or result.claim.about_decisions:
        return ""
    name = statement.system.reference
    broken = breaks_in_reference(statement, profile, result.claim, result.counterexample.start_as_doubles)
    if broken is None:
        return f"{name} cannot be put into this start, so this is a counterexample of the statement only"
    if broken:
        return f"{name} breaks the claim from there too"
    return f"{name} does not break the claim from there: this is a counterexample of the statement only"


def breaks_in_reference(
    statement: Statement, profile: PolicyProfile, claim: SystemClaim, start: Mapping[str, float]
) -> bool | None:
    """Returns True if an episode of the reference from a start breaks a claim; None where it cannot be put there."""
    reference = Reference(statement)
    reference.reset(0)
    if not reference.placeable or not reference.place(dict(start)):
        return None
    for step in range(claim.steps + 1):
        state = {name: Fraction(number) for name, number in reference.state().items()}
        if holds(claim.violation_at(step), state, {}):
            return True
        if step == claim.steps or holds(claim.fulfilment_at(step), state, {}) or not reference.playing:
            return False
        seen = {policy.agent: observe_state(statement.system, policy, state) for policy in profile.agents}
        reference.step(
            {policy.agent: policy.actions[int(act(policy, seen[policy.agent])[0])].name for policy in profile.agents}
        )
    return False


ANYWHERE, BESIDE = 4_096, 256  # starts that are played: of the whole region, and of each box around a known one
NEAR = tuple(2.0**-power for power in (4, 8, 12, 16))  # half a box's width, as a share of what starts range over


def find_by_rules(
    statement: Statement, profile: PolicyProfile, claim: SystemClaim, counterexample: SystemCounterexample
) -> SystemCounterexample | None:
    """An episode by the rules as they are written, with errors that the file states, that surely breaks the claim."""
    replay = WrittenReplay(statement, profile, claim)
    drawn = map(replay.follow, _courses(statement, profile, claim, counterexample.start))
    for states in chain([replay.keep_near(counterexample.states)], drawn):
        if states is not None:
            again = replay_course(profile, statement.system, claim, _follow_pieces(statement, profile, states))
            if again is not None:
                return again
    return None


def _courses(statement: Statement, profile: PolicyProfile, claim: SystemClaim, start: State) -> Iterator[Course]:
    """Courses of the rules that seem to break the claim: from anywhere, then from ever nearer to a start."""
    bounds = box(statement)
    lowest, highest = (np.array([float(end) for end in ends]) for ends in zip(*bounds.values(), strict=True))
    near = np.array([float(start[name]) for name in bounds])
    offs = [part * (highest - lowest) for part in NEAR]
    boxes = [(np.maximum(near - off, lowest), np.minimum(near + off, highest)) for off in offs]
    beside = [Starts(BESIDE, (low[None], high[None])) for low, high in boxes]
    for each in (Starts(ANYWHERE), *_thin(statement), *beside):
        for course in courses(profile, statement.system, claim, each, statement.rules):
            exact = {name: min(max(course.start[name], low), high) for name, (low, high) in bounds.items()}
            yield replace(course, start=exact)  # a bound that is no float64 is met exactly


def _thin(statement: Statement) -> Iterator[Starts]:
    """Some starts that meet all conditions where some are about several variables: of numbers drawn at once most may
    fail these, and those that pass may all lie at bounds.
    """
    if any(len(half.form.terms) > 1 for half in statement.system.start):
        random = np.random.default_rng(0)
        with suppress(InputError):  # no start was found
            drawn = [list(draw_start(statement, random).values()) for _ in range(BESIDE)]
            yield Starts(BESIDE, (np.array(drawn), np.array(drawn)))


def _follow_pieces(statement: Statement, profile: PolicyProfile, states: Sequence[State]) -> Course:
    """Returns the course of an episode of the pieces through given states, as far as their errors allow: of several
    pieces that hold a state, as where there is a choice, by the one that comes nearest to the next.
    """
    errors, pieces = list[Mapping[str, Fraction]](), list[int]()
    for state, after in pairwise(states):
        holding = [number for number, piece in enumerate(statement.system.pieces) if piece.holds(state)]
        if not holding:
            break
        actions = choose_actions(statement.system, profile, state)
        joint = {policy.agent: policy.actions[actions[policy.agent]].name for policy in profile.agents}
        ways: list[tuple[Fraction, int, Mapping[str, Fraction]]] = []
        for number in holding:
            piece = statement.system.pieces[number]
            exact = piece.step(state, joint, {})
            asked = {name: after[name] - exact[name] for name in exact}
            cut = {name: asked[name] - error for name, error in within(piece, asked).items()}
            ways.append((sum(map(abs, ({**asked, **cut}).values()), Fraction(0)), number, asked))
        _, number, asked = min(ways, key=lambda way: way[:2])
        errors.append({name: asked[name] for name in statement.system.pieces[number].error})
        pieces.append(number)
    return Course(states[0], errors, pieces)
