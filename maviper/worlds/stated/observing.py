"""What the agents of a game observe, as a world file states it.

Does: names and bounds of coordinates, of roundings and of errors; the tables of agents; a state of the game as one of
  the file, with the roundings that the game makes there.
Assumes: a checked profile whose features have meanings, and whose agents take actions.
Does not: state claims.

A game adds the terms of a feature in float64, and a world file knows exact numbers. So a variable beside each feature
that is tested says by how much it is off: `agent_0.rounding_goal_dx`. What is proved is proved of all roundings. Where
features may err, another variable says by how much: `agent_0.error_goal_dx`. It is added before anything is rounded.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np

from codegen.deciding import read_by
from codegen.floats import FLOAT64
from codegen.ir import GOAL, NO_FEATURE, AgentPolicy, FeatureSpec, Float64, Meaning, PolicyProfile
from codegen.numbers import nearest_double, neighbour
from codegen.observe import observe
from verify.claims.region import Interval
from verify.decimals import text as number_text
from verify.states.state import State as GameState
from verify.states.state import error_name, meaning_of, measurable
from verify.states.state import observe_state as observe_game
from verify.systems.observing import observe_state
from verify.systems.statement import Statement
from verify.systems.system import Polytope, State

PLACE = f"{GOAL}_place"  # the goal's place: a world file has no goal
UNIT = Fraction(1, 2**53)  # of a rounding, of what is rounded
GROWN = 1 + Fraction(1, 2**40)  # by which sums with roundings may be above those without, and more


@dataclass(frozen=True)
class Observed:
    """A number that an agent's tree tests, with what the file calls its rounding and its error."""

    policy: AgentPolicy
    feature: FeatureSpec

    @property
    def meaning(self) -> Meaning:
        """The meaning of the feature: the quantity that it measures."""
        return meaning_of(self.feature)

    @property
    def rounding(self) -> str:
        """The variable that says by how much rounding moves it."""
        return f"{self.policy.agent}.rounding_{self.feature.name}"

    @property
    def error(self) -> str:
        """The variable that says by how much it is off before that."""
        return f"{self.policy.agent}.error_{self.feature.name}"

    def bound_rounding(self, ranges: Mapping[str, Interval], error: Fraction) -> Fraction:
        """By how much it may be rounded: each addition of float64 numbers rounds once, and so does a sum with an error.
        The sign of a difference, and that of a sum with an error, is that of what is rounded.
        """
        additions = len(self.meaning.terms) - 1
        additions = max(additions, 1) if error and measurable(self.meaning) else additions
        if additions < 1 or (additions == 1 and self.meaning.function):
            return Fraction(0)
        largest = error + sum(
            (abs(Fraction(weight)) * max(map(abs, ranges[call_in_file(name)])) for weight, name in self.meaning.terms),
            Fraction(0),
        )
        return additions * UNIT * GROWN * largest


def list_observed(policy: AgentPolicy) -> list[Observed]:
    """The features that an agent's tree tests, alone or in a sum."""
    tree, count = policy.tree, len(policy.features)
    tested = [int(each) for each in tree.feature if each != NO_FEATURE]
    places = {place for each in tested for _, place in read_by(tree, each, count)}
    return [Observed(policy, feature) for place, feature in enumerate(policy.features) if place in places]


def list_noise(
    profile: PolicyProfile, ranges: Mapping[str, Interval], errors: Mapping[str, Fraction]
) -> tuple[dict[str, Fraction], dict[str, Fraction]]:
    """The variables of roundings and of errors, each with its bound. `errors`: by team, the largest that is allowed."""
    roundings, off = dict[str, Fraction](), dict[str, Fraction]()
    for policy in profile.agents:
        error = errors.get(policy.team, Fraction(0))
        for each in list_observed(policy):
            if most := each.bound_rounding(ranges, error):
                roundings[each.rounding] = most
            if error and measurable(each.meaning):
                off[each.error] = error
    return roundings, off


def describe_agent(
    policy: AgentPolicy, noise: Collection[str], actions: Mapping[str, object], mark: str = PLACE
) -> dict[str, object]:
    """The tables of an agent. `noise`: the names of all roundings and errors; `actions`: what each of its actions sets;
    `mark`: whose place the goal's is.
    """
    features = {each.name: _spell_feature(Observed(policy, each), noise, mark) for each in policy.features}
    return {"team": policy.team, "features": features, "actions": dict(actions)}


def _spell_feature(observed: Observed, noise: Collection[str], mark: str) -> str:
    """Spells a feature as world files write it."""
    terms = [f"{number_text(Fraction(weight))}*{call_in_file(name, mark)}" for weight, name in observed.meaning.terms]
    off = [name for name in (observed.error, observed.rounding) if name in noise]
    added = " + ".join([*terms, *off]) or "0"
    if observed.meaning.function == "zero":
        return f"{added} == 0"
    return f"{observed.meaning.function}({added})" if observed.meaning.function else added


# --- states of the game


def with_noise(profile: PolicyProfile, statement: Statement, state: State) -> State:
    """A state with the roundings that the game makes of its coordinates and errors; errors that it lacks are 0."""
    at = {find_coordinate(name): value for name, value in state.items()}
    planes = planes_of(profile, state)
    known = {one.name for one in statement.system.variables}
    extended = {**dict.fromkeys(known, Fraction(0)), **state}
    for policy in profile.agents:
        bare = tuple(replace(each, meaning=replace(meaning_of(each), function="")) for each in policy.features)
        sums = observe(bare, planes, profile.world, FLOAT64)[0].tolist()
        for feature, value in zip(policy.features, sums, strict=True):
            one = Observed(policy, feature)
            if one.rounding in known:
                error = extended.get(one.error, Fraction(0))
                exact = sum((Fraction(weight) * at[name] for weight, name in one.meaning.terms), error)
                seen = Fraction(value) if not error else exact if one.meaning.function else Fraction(float(exact))
                extended[one.rounding] = seen - exact
    return extended


def ensure_observed(profile: PolicyProfile, statement: Statement, state: State) -> None:
    """AssertionError where what agents observe by the file is not what the game shows them."""
    known = {find_coordinate(name): float(value) for name, value in state.items()}
    at = {name: known.get(name, 0.0) for name in profile.world.coordinates()}
    for policy in profile.agents:
        observed = list_observed(policy)
        off = {error_name(policy.agent, each.feature.name): float(state.get(each.error, 0)) for each in observed}
        shown = observe_game(profile, policy, GameState(at, None, off))
        stated = observe_state(statement.system, policy, state)
        tested = [policy.features.index(each.feature) for each in observed]
        assert (shown[:, tested] == stated[:, tested]).all(), (
            f"{policy.agent} observes {shown}, and by the file {stated}"
        )


def planes_of(profile: PolicyProfile, state: State) -> Float64:
    """The coordinates of a state, [1, n_coordinates]; what no region bounds and nobody reads is 0."""
    at = {find_coordinate(name): value for name, value in state.items()}
    return np.array([[float(at.get(name, 0)) for name in profile.world.coordinates()]])


def find_goal(region: Polytope) -> str | None:
    """The landmark at which half spaces hold the goal's place along both axes; None where they do at none."""
    ordered = set[tuple[str, str]]()  # coordinates, the first at most the second
    for half in region:
        if len(half.form.terms) == 2 and not half.form.constant:
            (first, factor), (second, other) = half.form.terms
            if factor + other == 0:
                ordered.add((first, second) if factor > 0 else (second, first))
    equal = {(one, other) for one, other in ordered if (other, one) in ordered}
    marks = sorted({name.rpartition(".")[0] for pair in equal for name in pair} - {PLACE})
    return next((mark for mark in marks if all((f"{PLACE}.{axis}", f"{mark}.{axis}") in equal for axis in "xy")), None)


def place_in(exact: Fraction, ends: Interval, step: int) -> Fraction:
    """The float64 next to a number, `step` further, within a range."""
    near = nearest_double(exact)
    near = float(neighbour(near, step * float("inf"), FLOAT64)) if step else near
    for end, way in ((ends[1], -1.0), (ends[0], 1.0)):
        if (Fraction(near) - end) * way < 0:
            near = float(neighbour(near, way * float("inf"), FLOAT64))
    return Fraction(near)


# --- names


def call_in_file(coordinate: str, mark: str = PLACE) -> str:
    """Returns a coordinate's name in the file. `mark`: whose place the goal's is."""
    return coordinate.replace(GOAL, mark, 1) if coordinate.startswith(f"{GOAL}.") else coordinate


def find_coordinate(called: str) -> str:
    """The coordinate that the file calls so."""
    return called.replace(PLACE, GOAL, 1) if called.startswith(f"{PLACE}.") else called
