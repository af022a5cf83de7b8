"""Claims about single decisions of a team that tests sums, as a world file in which nothing moves.

Does: writes that file: coordinates, what agents observe of them with its roundings, and each claim as a formula; finds
  states of the game beside those in which a formula fails.
Assumes: a checked profile whose features have meanings, and whose agents take actions.
Does not: decide. Whoever checks a certificate has the file beside it, and reads what it is about.

A game adds the terms of a feature in float64, and a world file knows exact numbers. So a variable beside each feature
that is tested says by how much it is off: `agent_0.rounding_goal_dx`. What is proved is proved of all roundings.
"""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import TypeVar, cast

import numpy as np

from codegen.errors import InputError
from codegen.floats import FLOAT64, nearest_double, neighbour
from codegen.ir import GOAL, AgentPolicy, Bool, FeatureSpec, Float64, Meaning, PolicyProfile, act
from codegen.observe import observe
from maviper.verification.ask import Posed
from verify.claims.decisions import DecisionClaim, formula
from verify.claims.formula import for_goal, names_goal
from verify.claims.region import Interval, Region
from verify.claims.uncertified.values import Batch
from verify.exact import text as number_text
from verify.systems.claims import SystemClaim
from verify.systems.observing import observe_state
from verify.systems.statement import Statement
from verify.systems.system import Polytope, State, Variable
from verify.systems.words import spell_formula

Number = TypeVar("Number")
HEAD = "# World states of a game: coordinates, and by how much what agents observe of them is off by rounding.\n"
PLACE = f"{GOAL}_place"  # the goal's place: a world file has no goal
UNIT = Fraction(1, 2**53)  # of a rounding, of what is rounded
SCALES = (-2, -6, -10, -14, -18, -22, -26)  # powers of two: how far states are drawn from one where a claim may fail
DRAWN, TRIED, SEED = 1_024, 4, 0  # states of a scale; of these, that seem to break the claim, those that are replayed
ANYWHERE = 16_384  # states that are drawn in a whole region
GROWN = 1 + Fraction(1, 2**40)  # by which sums with roundings may be above those without, and more


def world_of(profile: PolicyProfile, posed: Sequence[Posed]) -> tuple[str, tuple[str, ...]]:
    """The world file with all claims, and where each of them speaks, in words.

    InputError for claims about episodes or errors, for pairs that are kept apart, and for states that no region bounds.
    """
    ranges = _ranges(profile, [each.region for each in posed])
    roundings = {
        _name_rounding(policy, feature): most
        for policy in profile.agents
        for feature in _list_tested(policy)
        if (most := _bound_rounding(_meaning(feature), ranges))
    }
    everything = {**ranges, **{name: (-most, most) for name, most in roundings.items()}}
    variables = "".join(f'"{name}" = {{ range = {_ends(ends)} }}\n' for name, ends in everything.items())
    agents = "".join(_agent(policy, roundings) for policy in profile.agents)
    starts = ", ".join(f'"{name}" = {_ends(ends)}' for name, ends in everything.items())
    properties = [each for one in posed for each in _properties(profile, one, ranges)]
    head = f'{HEAD}name = "{profile.world.name.partition(",")[0]}"\n\n[variables]\n{variables}{agents}'
    claims = "".join(table for table, _ in properties)
    return f"{head}\n[start]\nbox = {{ {starts} }}\n{claims}", tuple(words for _, words in properties)


def iterate_near(profile: PolicyProfile, statement: Statement, claim: SystemClaim, state: State) -> Iterator[State]:
    """States of the game beside another one: float64 coordinates, the goal at a landmark, and the roundings that the
    game makes there. First the nearest ones, then those of some farther away in which the claim seems to fail.
    """
    coordinates, goal = _list_coordinates(profile, statement), _find_goal(profile, state)
    for step in (0, 1, -1):
        moved = {one.name: _place_in(state[one.name], one.range, step) for one in coordinates}
        yield _with_roundings(profile, statement, {**moved, **_at_goal(goal, moved)})
    rng, near = np.random.default_rng(SEED), np.array([state[one.name] for one in coordinates], np.float64)
    ends = _find_ends(coordinates)
    for power in SCALES:
        drawn: Float64 = np.clip(near + 2.0**power * rng.uniform(-1.0, 1.0, (DRAWN, len(near))), *ends.T)
        yield from _iterate_broken(profile, statement, claim, goal, drawn)


def iterate_anywhere(profile: PolicyProfile, statement: Statement, claim: SystemClaim) -> Iterator[State]:
    """Some states of the game, of those drawn in the claim's regions, in which it seems to fail."""
    coordinates, rng = _list_coordinates(profile, statement), np.random.default_rng(SEED)
    ends = _find_ends(coordinates)
    for region in claim.regions:
        bounds = _bound(region, coordinates, ends)
        drawn: Float64 = rng.uniform(bounds[:, 0], bounds[:, 1], (ANYWHERE, len(coordinates)))
        yield from _iterate_broken(profile, statement, claim, _find_goal_of(profile, region), drawn)


def _list_coordinates(profile: PolicyProfile, statement: Statement) -> list[Variable]:
    return [one for one in statement.system.variables if _coordinate(one.name) in profile.world.coordinates()]


def _find_ends(coordinates: Sequence[Variable]) -> Float64:
    """The float64 ranges of coordinates, [n_coordinates, 2]."""
    return np.array([[_place_in(end, one.range, 0) for end in one.range] for one in coordinates], np.float64)


def _iterate_broken(
    profile: PolicyProfile, statement: Statement, claim: SystemClaim, goal: str | None, drawn: Float64
) -> Iterator[State]:
    """The first of drawn coordinates, [n, n_coordinates], in which the claim seems to fail."""
    names = [one.name for one in _list_coordinates(profile, statement)]
    planes = dict(zip(names, drawn.T, strict=True))
    planes |= _at_goal(goal, planes)
    for row in np.flatnonzero(_seem_broken(profile, claim, planes, len(drawn)))[:TRIED]:
        moved = {name: Fraction(float(values[row])) for name, values in planes.items()}
        yield _with_roundings(profile, statement, moved)


def _bound(region: Polytope, coordinates: Sequence[Variable], ends: Float64) -> Float64:
    """The box of a region, [n_coordinates, 2]; `ends`: of the ranges."""
    bounds, columns = ends.copy(), {one.name: place for place, one in enumerate(coordinates)}
    for half in region:
        if len(half.form.terms) == 1:
            ((name, factor),) = half.form.terms
            bounds[columns[name], int(factor > 0)] = -half.form.constant / factor
    return bounds


def _find_goal_of(profile: PolicyProfile, region: Polytope) -> str | None:
    """The landmark at which the goal is in a region; None where there is none."""
    named = {name for half in region if len(half.form.terms) == 2 for name, _ in half.form.terms}
    marks = [each.name for each in profile.world.landmarks]
    return next((mark for mark in marks if {f"{PLACE}.x", f"{mark}.x"} <= named), None)


def _seem_broken(profile: PolicyProfile, claim: SystemClaim, planes: Mapping[str, Float64], count: int) -> Bool:
    """In which states the game's own agents seem to break a claim, but for roundings, [batch]."""
    at = {_coordinate(name): values for name, values in planes.items()}
    rows = np.zeros((count, len(profile.world.coordinates())))
    for place, name in enumerate(profile.world.coordinates()):
        rows[:, place] = at.get(name, 0.0)
    actions = {
        each.agent: act(each, observe(each.features, rows, profile.world, each.numbers)) for each in profile.agents
    }
    asked = Batch(planes, count)
    return asked.holds(claim.inside, actions) & ~asked.holds(claim.formula, actions)


def _with_roundings(profile: PolicyProfile, statement: Statement, state: State) -> State:
    """A state with the roundings that the game makes of its coordinates."""
    at = {_coordinate(name): value for name, value in state.items()}
    planes = _planes(profile, state)
    known = {one.name for one in statement.system.variables}
    extended = {**dict.fromkeys(known, Fraction(0)), **state}
    for policy in profile.agents:
        bare = tuple(replace(each, meaning=replace(_meaning(each), function="")) for each in policy.features)
        sums = observe(bare, planes, profile.world, FLOAT64)[0].tolist()
        for feature, value in zip(policy.features, sums, strict=True):
            name = _name_rounding(policy, feature)
            if name in known:
                exact = sum((Fraction(weight) * at[one] for weight, one in _meaning(feature).terms), Fraction(0))
                extended[name] = Fraction(value) - exact
    return extended


def _find_goal(profile: PolicyProfile, state: State) -> str | None:
    """The landmark at which the goal is in a state; None in a game without goal, or where it is at none."""
    for landmark in profile.world.landmarks:
        if all(state.get(f"{PLACE}.{axis}") == state[f"{landmark.name}.{axis}"] for axis in "xy"):
            return landmark.name
    return None


def _at_goal(goal: str | None, at: Mapping[str, Number]) -> dict[str, Number]:
    """The goal's place, where a landmark is."""
    return {f"{PLACE}.{axis}": at[f"{goal}.{axis}"] for axis in "xy"} if goal else {}


def _place_in(exact: Fraction, ends: Interval, step: int) -> Fraction:
    """The float64 next to a number, `step` further, within a range."""
    near = nearest_double(exact)
    near = float(neighbour(near, step * float("inf"), FLOAT64)) if step else near
    for end, way in ((ends[1], -1.0), (ends[0], 1.0)):
        if (Fraction(near) - end) * way < 0:
            near = float(neighbour(near, way * float("inf"), FLOAT64))
    return Fraction(near)


def ensure_observed(profile: PolicyProfile, statement: Statement, state: State) -> None:
    """AssertionError where what agents observe by the file is not what the game shows them."""
    planes = _planes(profile, state)
    for policy in profile.agents:
        shown = observe(policy.features, planes, profile.world, policy.numbers)
        stated = observe_state(statement.system, policy, state)
        names = {each.name for each in _list_tested(policy)}
        tested = [place for place, each in enumerate(policy.features) if each.name in names]
        assert (shown[:, tested] == stated[:, tested]).all(), (
            f"{policy.agent} observes {shown}, and by the file {stated}"
        )


def _planes(profile: PolicyProfile, state: State) -> Float64:
    """The coordinates of a state, [1, n_coordinates]; what no region bounds and nobody reads is 0."""
    at = {_coordinate(name): value for name, value in state.items()}
    return np.array([[float(at.get(name, 0)) for name in profile.world.coordinates()]])


# --- the file


def _ranges(profile: PolicyProfile, regions: Sequence[Region]) -> dict[str, Interval]:
    """Bounds of all coordinates that are read or that a region bounds, wide enough for all regions."""
    read = {name for policy in profile.agents for each in policy.features for _, name in _meaning(each).terms}
    ranges: dict[str, Interval] = {}
    for region in regions:
        for name, (low, high) in region.box.items():
            least, most = ranges.get(name, (low, high))
            ranges[name] = min(least, low), max(most, high)
        if region.apart:
            what = "claims about sums take bounds of coordinates and of their differences, and the region keeps pairs"
            raise InputError(f"{what} apart", f"region {region.name}", "name a region without [apart]")
    goals = {goal for region in regions for goal in region.goals}
    for axis in "xy" if goals else "":
        ends = [ranges[f"{goal}.{axis}"] for goal in sorted(goals)]
        ranges[f"{PLACE}.{axis}"] = min(low for low, _ in ends), max(high for _, high in ends)
    for name in sorted(_call_in_file(each) for each in read):
        if name not in ranges:
            what = f"no region bounds {_coordinate(name)}, which an agent observes"
            raise InputError(what, "--region", f'add "{_coordinate(name)}" = [LOW, HIGH] to the [box] of a region file')
    return ranges


def _properties(profile: PolicyProfile, posed: Posed, ranges: Mapping[str, Interval]) -> Iterator[tuple[str, str]]:
    """The tables of a claim, one for each goal if its formula asks which one that is, with where each speaks."""
    region = posed.region
    if not posed.claim.per_state or "eps" in posed.claim.stated:
        why = "allows errors" if posed.claim.per_state else "is not about single states"
        what = f"{posed.claim.name} {why}, so it is not decided of teams that test sums"
        raise InputError(what, "--property", "ask one of distinct_targets, own_target, no_double, aligned, assignment")
    claim = cast("DecisionClaim", posed.claim)
    stated = formula(profile, claim)
    apart = names_goal(stated)
    actions = {policy.agent: [each.name for each in policy.actions] for policy in profile.agents}
    for goals in [(goal,) for goal in region.goal_cases] if apart else [region.goal_cases]:
        spelled = spell_formula(for_goal(stated, goals[0]) if apart else stated, actions)
        where = f"region {region.name or 'given'}" + (f", goal {goals[0]}" if apart and goals[0] else "")
        label = f"{claim.label or f'{claim.name} of the {claim.team}'}, {where}"
        regions = ", ".join(_region(region, goal, ranges) for goal in goals)
        yield f'\n[[property]]\nlabel = {json.dumps(label)}\nformula = "{spelled}"\nregion = [{regions}]\n', where


def _region(region: Region, goal: str | None, ranges: Mapping[str, Interval]) -> str:
    box = ", ".join(f'"{name}" = {_ends(ends)}' for name, ends in region.box.items() if ends != ranges[name])
    conditions: list[str] = []
    for a, b, (low, high) in region.differences:
        conditions += [
            f"{_call_in_file(a)} - {_call_in_file(b)} {sign} {number_text(end)}"
            for sign, end in ((">=", low), ("<=", high))
        ]
    for axis in "xy" if goal else "":
        conditions += [f"{PLACE}.{axis} - {goal}.{axis} {sign} 0" for sign in ("<=", ">=")]
    where = ", ".join(f'"{each}"' for each in conditions)
    return (
        "{ " + ", ".join([*([f"box = {{ {box} }}"] if box else []), *([f"where = [{where}]"] if where else [])]) + " }"
    )


def _agent(policy: AgentPolicy, roundings: Mapping[str, Fraction]) -> str:
    features = "".join(f'{each.name} = "{_spell_feature(policy, each, roundings)}"\n' for each in policy.features)
    actions = "".join(f"{each.name} = {{}}\n" for each in policy.actions)
    head = f'\n[agents.{policy.agent}]\nteam = "{policy.team}"\n'
    return f"{head}[agents.{policy.agent}.features]\n{features}[agents.{policy.agent}.actions]\n{actions}"


def _spell_feature(policy: AgentPolicy, feature: FeatureSpec, roundings: Mapping[str, Fraction]) -> str:
    """What a feature is, as world files write it."""
    meaning, rounding = _meaning(feature), _name_rounding(policy, feature)
    terms = [f"{number_text(Fraction(weight))}*{_call_in_file(name)}" for weight, name in meaning.terms]
    added = " + ".join([*terms, *([rounding] if rounding in roundings else [])]) or "0"
    if meaning.function == "zero":
        return f"{added} == 0"
    return f"{meaning.function}({added})" if meaning.function else added


def _list_tested(policy: AgentPolicy) -> list[FeatureSpec]:
    """The features that its tree tests, alone or in a sum."""
    count, places = len(policy.features), set[int]()
    for tested in map(int, policy.tree.feature):
        if tested >= count:
            chosen = policy.tree.sums[tested - count]
            places.update(place for _, place in chosen.terms)
        else:
            places.add(tested)
    return [feature for place, feature in enumerate(policy.features) if place in places]


def _bound_rounding(meaning: Meaning, ranges: Mapping[str, Interval]) -> Fraction:
    """By how much a sum of float64 numbers may be off: each of its additions rounds once. The sign of a difference is
    that of what is rounded.
    """
    additions = len(meaning.terms) - 1
    if additions < 1 or (additions == 1 and meaning.function):
        return Fraction(0)
    largest = sum(
        (abs(Fraction(weight)) * max(map(abs, ranges[_call_in_file(name)])) for weight, name in meaning.terms),
        Fraction(0),
    )
    return additions * UNIT * GROWN * largest


def _meaning(feature: FeatureSpec) -> Meaning:
    assert feature.meaning is not None, feature
    return feature.meaning


def _name_rounding(policy: AgentPolicy, feature: FeatureSpec) -> str:
    return f"{policy.agent}.rounding_{feature.name}"


def _call_in_file(coordinate: str) -> str:
    """What the file calls a coordinate."""
    return coordinate.replace(GOAL, PLACE, 1) if coordinate.startswith(f"{GOAL}.") else coordinate


def _coordinate(called: str) -> str:
    """The coordinate that the file calls so."""
    return called.replace(PLACE, GOAL, 1) if called.startswith(f"{PLACE}.") else called


def _ends(ends: Interval) -> str:
    return f"[{', '.join(map(number_text, ends))}]"
