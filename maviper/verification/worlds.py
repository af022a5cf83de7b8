"""World files that questions about a profile are made of: observations, states of a game, episodes of a game.

Does: states them as data, which whoever proves reads, and as the text of the file that lies beside a certificate:
  variables, what agents observe with its roundings and errors, how a step moves a game, and each claim. Says where a
  region holds no start at rest, which no world file states.
Assumes: a checked profile; properties as data. Games: features that have meanings, agents that take actions.
Does not: decide, or play (games.py). Whoever checks a certificate has the file, and reads what
  it is about.

Observations: a variable for each feature, over the ranges that are asked about, and nothing moves. An agent of which
`robust` is claimed stands twice. Its copy acts by the same tree and observes each feature with an error, which is a
variable too: `cart_off.spin` is by how much the spin that `cart_off` observes is off.

Episodes: a step adds in float64, and a world file knows exact numbers. So each next value has an error, bounded by the
largest numbers that episodes can come to. A rounding of what is observed is anywhere within its bound, anew in each
step. The goal's place is that of its landmark.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import NamedTuple, cast

from codegen.deciding import list_decided
from codegen.dynamics import accelerations, partners
from codegen.errors import InputError
from codegen.ir import PolicyProfile
from maviper.verification.ask import Posed
from maviper.worlds.stated.certified import WORLD_FILE
from maviper.worlds.stated.observing import (
    GROWN,
    PLACE,
    UNIT,
    Observed,
    call_in_file,
    describe_agent,
    find_coordinate,
    list_noise,
    list_observed,
)
from verify.checker.episodes.reading import matchings
from verify.claims.catalogue import select_stated
from verify.claims.claim import verifiable
from verify.claims.decisions import DecisionClaim, formula
from verify.claims.episodes import EpisodeClaim
from verify.claims.files import properties
from verify.claims.formula import for_goal, names_goal
from verify.claims.observed import View, over, variable
from verify.claims.region import Interval, Region
from verify.claims.region_files import velocities_of
from verify.claims.wording import account_of
from verify.decimals import plain
from verify.decimals import text as number_text
from verify.language.units import unit_of
from verify.states.episodes import at_rest, playable
from verify.systems.files import state_world
from verify.systems.properties import ROBUST, copy_called, errors_of, spell_formula
from verify.systems.statement import Statement
from verify.systems.system import Affine, HalfSpace, Polytope, box_of, is_empty
from verify.systems.values import ADVICE, NAME, only, text
from verify.toml_places import Place, parse

OF_OBSERVATIONS = """\
# Observations: each variable is a feature. Every combination of numbers in these ranges is a state.
"""
OF_STATES = "# World states of a game: coordinates, and by how much what agents observe of them is off by rounding.\n"
OF_EPISODES = "# A game in exact numbers: each next value and each observation is off by what rounding may do to it.\n"
ZERO = Fraction(0)
ROOM = Fraction(1, 2**20)
Errors = Mapping[str, Mapping[str, Fraction]]  # agent -> feature -> the largest error that a claim speaks of
Table = dict[str, object]  # of numbers, texts, lists and tables


class World(NamedTuple):
    """A world file: its tables, and its text."""

    document: Table
    source: str

    @staticmethod
    def of(head: str, document: Table) -> World:
        """The file with a comment above it."""
        top = "".join(
            f"{key} = {_spell(value)}\n" for key, value in document.items() if not isinstance(value, dict | list)
        )
        tables = {key: cast("Table", value) for key, value in document.items() if isinstance(value, dict)}
        below = "".join(_spell_table(key, value) for key, value in tables.items())
        return World(document, head + top + below + spell_claims(cast("list[Table]", document.get("property", []))))

    @property
    def statement(self) -> Statement:
        """The statements of its tables, whose errors tell lines of the text. InputError for a fault."""
        return state_world(self.document, Place(WORLD_FILE, self.source))


def spell_claims(claims: Iterable[Table]) -> str:
    """The tables of claims as text."""
    return "".join(f"\n[[property]]\n{_spell_lines(each)}" for each in claims)


def _spell_table(key: str, table: Table) -> str:
    """A table of the file, with the tables of each agent or of the dynamics in it."""
    if key == "agents":
        return "".join(_spell_agent(name, cast("Table", each)) for name, each in table.items())
    if key == "dynamics":
        parts = ((name, _spell_lines(cast("Table", each), '"')) for name, each in table.items())
        return "".join(f"\n[{key}.{name}]\n{lines}" for name, lines in parts)
    mark = '"' if key == "variables" else ""
    return f"\n[{key}]\n{_spell_lines(table, mark)}"


def _spell_agent(name: str, table: Table) -> str:
    own = {key: value for key, value in table.items() if not isinstance(value, dict)}
    tables = {key: cast("Table", value) for key, value in table.items() if isinstance(value, dict)}
    below = "".join(f"[agents.{name}.{key}]\n{_spell_lines(value)}" for key, value in tables.items())
    return f"\n[agents.{name}]\n{_spell_lines(own)}{below}"


def _spell_lines(table: Table, mark: str = "") -> str:
    """A line for each value. `mark`: quotes around keys that are variables."""
    return "".join(f"{mark}{key}{mark} = {_spell(value, key)}\n" for key, value in table.items())


def _spell(value: object, key: str = "") -> str:
    """A value within a line, under its key."""
    if isinstance(value, dict):
        mark = '"' if key == "box" else ""
        inner = (f"{mark}{name}{mark} = {_spell(each, name)}" for name, each in cast("Table", value).items())
        return f"{{ {', '.join(inner)} }}" if value else "{}"
    if isinstance(value, list):
        return f"[{', '.join(map(_spell, cast('list[object]', value)))}]"
    if isinstance(value, Fraction):
        return number_text(value)
    if not isinstance(value, str):
        return str(value).lower()
    # as JSON but for two halves of a character, and one character that only TOML escapes
    return json.dumps(value.encode(errors="replace").decode(), ensure_ascii=False).replace("\x7f", "\\u007f")


def _bounds(ranges: Mapping[str, Interval]) -> Table:
    """Bounds of variables, as tables have them."""
    return {name: list(ends) for name, ends in ranges.items()}


def _variables(ranges: Mapping[str, Interval]) -> Table:
    return {name: {"range": list(ends)} for name, ends in ranges.items()}


# --- observations


def state_observations(profile: PolicyProfile, view: View, region: Region, errors: Errors) -> World:
    """The observations of agents that give numbers or test sums. `region`: of the view's variables; `errors`: of the
    agents that stand twice.

    InputError for names that formulas cannot hold, and for a region that is more than bounds of single variables.
    """
    if region.differences or region.apart:
        advice = 'write them into a property: region = { where = ["angle - spin <= 1/2"] }'
        raise InputError("claims about numbers and sums take bounds of single variables", "--region", advice)
    _ensure_named(profile)
    units = {one.name: _unit(one.unit) for one in over(profile, view).world.variables}
    ranges = dict(region.box)
    for agent, features in errors.items():
        for feature, most in features.items():
            name = f"{copy_called(agent)}.{feature}"
            ranges[name], units[name] = (-most, most), units[variable(profile, view, agent, feature)]
    agents: Table = {}
    for policy in profile.agents:
        observed: Table = {each.name: variable(profile, view, policy.agent, each.name) for each in policy.features}
        given: Table = {"actions": dict[str, object]((each.name, Table()) for each in policy.actions)}
        if not policy.actions:
            given = {"outputs": {each.name: _unit(each.unit) for each in policy.outputs}}
        agents[policy.agent] = {"team": policy.team, "features": observed, **given}
        if policy.agent in errors:
            copy, erring = copy_called(policy.agent), errors[policy.agent]
            off = {name: f"{read} + {copy}.{name}" if name in erring else read for name, read in observed.items()}
            agents[copy] = {"like": policy.agent, "features": off, **given}
    document: Table = {
        "name": "observations",
        "observed": True,
        "variables": {name: {"unit": units[name], "range": list(ends)} for name, ends in ranges.items()},
        "agents": agents,
        "start": {"box": _bounds(ranges)},
    }
    return World.of(OF_OBSERVATIONS, document)


def errors_in(source: str, profile: PolicyProfile, where: str) -> dict[str, dict[str, Fraction]]:
    """The largest errors that the claims `robust` of a property file allow, of each agent that they are about."""
    document, file = parse(source, where, "not a readable property file", ADVICE)
    agents = {policy.agent: policy for policy in profile.agents if not policy.actions}
    stated: dict[str, dict[str, Fraction]] = {}
    for described, place in properties(document, file):
        if described.get("name") != ROBUST:
            continue
        agent = text(described.get("agent", ""), place / "agent")
        only({agent: None}, agents, place / "agent", "agent that gives numbers")
        largest = stated.setdefault(agent, {})
        for name, most in errors_of(described, {each.name: each for each in agents[agent].features}, place).items():
            largest[name] = max(most, largest.get(name, most))
    return stated


def _unit(unit: str) -> str:
    """The unit as world files write it; a free text that is none counts as a pure number."""
    try:
        unit_of(unit, "")
    except InputError:
        return ""
    return unit


def _ensure_named(profile: PolicyProfile) -> None:
    """InputError for a name that formulas about numbers cannot hold."""
    for policy in profile.agents:
        names = (policy.agent, *(each.name for each in policy.features), *list_decided(policy))
        for name in names:
            if not NAME.fullmatch(name):
                advice = "rename it where the profile comes from: letters, digits and _, a letter first"
                raise InputError(f"formulas about numbers cannot name {name}", policy.agent, advice)


# --- states of a game


def state_decisions(profile: PolicyProfile, posed: Sequence[Posed]) -> tuple[World, tuple[str, ...]]:
    """States of a game in which nothing moves, with all claims, and where each of them speaks, in words.

    InputError for teams of which nothing is claimed, claims about episodes, pairs that are kept apart, and states that
    no region bounds.
    """
    claims = [_ensure_decided(one) for one in posed]
    for team in dict.fromkeys(claim.team for claim in claims):
        verifiable(profile, team)
    ranges = bound_coordinates(profile, [each.region for each in posed])
    errors: dict[str, Fraction] = {}
    for claim in claims:
        errors[claim.team] = max(claim.eps, errors.get(claim.team, claim.eps))
    roundings, off = list_noise(profile, ranges, errors)
    noise = {**roundings, **off}
    everything = {**ranges, **{name: (-most, most) for name, most in noise.items()}}
    asked = [
        each
        for one, claim in zip(posed, claims, strict=True)
        for each in _decision_claims(profile, claim, one.region, ranges, _bound_errors(profile, claim, off))
    ]
    document: Table = {
        "name": profile.world.name.partition(",")[0],
        "variables": _variables(everything),
        "agents": {
            policy.agent: describe_agent(policy, noise, {each.name: {} for each in policy.actions})
            for policy in profile.agents
        },
        "start": {"box": _bounds(everything)},
        "property": [table for table, _ in asked],
    }
    return World.of(OF_STATES, document), tuple(where for _, where in asked)


def _ensure_decided(posed: Posed) -> DecisionClaim:
    """The claim, as one about single decisions."""
    if not posed.claim.per_state:
        what = f"{posed.claim.name} is not about single states, so it is not decided of teams that test sums"
        raise InputError(what, "--claim", "ask one of distinct_targets, own_target, no_double, aligned, assignment")
    return cast("DecisionClaim", posed.claim)


def bound_coordinates(profile: PolicyProfile, regions: Sequence[Region]) -> dict[str, Interval]:
    """Bounds of all coordinates that are read or that a region bounds, wide enough for all regions."""
    read = {
        name
        for policy in profile.agents
        for each in policy.features
        for _, name in Observed(policy, each).meaning.terms
    }
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
    for name in sorted(call_in_file(each) for each in read):
        if name not in ranges:
            what, advice = f"no region bounds {find_coordinate(name)}, which an agent observes", find_coordinate(name)
            raise InputError(what, "--region", f'add "{advice}" = [LOW, HIGH] to the [box] of a region file')
    return ranges


def _bound_errors(profile: PolicyProfile, claim: DecisionClaim, off: Mapping[str, Fraction]) -> dict[str, Interval]:
    """The errors of which a claim speaks, where they are less than those of the file."""
    own = {
        each.error: claim.eps if policy.team == claim.team else Fraction(0)
        for policy in profile.agents
        for each in list_observed(policy)
    }
    return {name: (-own[name], own[name]) for name, most in off.items() if own[name] != most}


def _decision_claims(
    profile: PolicyProfile,
    claim: DecisionClaim,
    region: Region,
    ranges: Mapping[str, Interval],
    erring: Mapping[str, Interval],
) -> Iterator[tuple[Table, str]]:
    """The tables of a claim, one for each goal if its formula asks which one that is, with where each speaks.
    `erring`: bounds of errors that are less than those of the file.
    """
    stated = formula(profile, claim)
    apart = names_goal(stated)
    actions = {policy.agent: [each.name for each in policy.actions] for policy in profile.agents}
    box = {name: ends for name, ends in region.box.items() if ends != ranges[name]} | dict(erring)
    for goals in [(goal,) for goal in region.goal_cases] if apart else [region.goal_cases]:
        spelled = spell_formula(for_goal(stated, goals[0]) if apart else stated, actions)
        where = f"region {region.name or 'given'}" + (f", goal {goals[0]}" if apart and goals[0] else "")
        where += f", each feature of the {claim.team} off by up to {number_text(claim.eps)}" if claim.eps else ""
        called = f"{claim.name} of the {claim.team}" + (f": {claim.of}" if "of" in select_stated(claim) else "")
        label = f"{claim.label or called}, {where}"
        yield {"label": label, "formula": spelled, "region": [_region(region, goal, box) for goal in goals]}, where


def _region(region: Region, goal: str | None, box: Mapping[str, Interval]) -> Table:
    """The part of a region with a goal. `box`: bounds narrower than the ranges."""
    where = list_conditions(region, goal)
    return {**({"box": _bounds(box)} if box else {}), **({"where": where} if where else {})}


def list_conditions(region: Region, goal: str | None) -> list[str]:
    """Lists what a region says beyond bounds, and that the goal is at a landmark."""
    conditions: list[str] = []
    for a, b, (low, high) in region.differences:
        conditions += [
            f"{call_in_file(a)} - {call_in_file(b)} {sign} {number_text(end)}"
            for sign, end in ((">=", low), ("<=", high))
        ]
    for axis in "xy" if goal else "":
        conditions += [f"{PLACE}.{axis} - {goal}.{axis} {sign} 0" for sign in ("<=", ">=")]
    return conditions


# --- episodes of a game


class Moving(NamedTuple):
    """The reach of agents: bounds of all coordinates, and of what rounding does to each next value."""

    ranges: dict[str, Interval]
    errors: dict[str, Fraction]


class Started(NamedTuple):
    """From where all episodes start."""

    region: Region
    goal: str | None

    @property
    def where(self) -> str:
        """In words."""
        return f"from region {self.region.name or 'given'}, at rest"

    @property
    def states(self) -> Polytope:
        """The states of the region at rest, as half spaces."""
        region, halves = self.region, list[HalfSpace]()
        for a, b, (low, high) in region.differences:
            apart = Affine.of({a: Fraction(1)}).plus(Affine.of({b: Fraction(1)}), Fraction(-1))
            halves += [HalfSpace(Affine((), low).plus(apart, Fraction(-1))), HalfSpace(apart.plus(Affine((), -high)))]
        return (*box_of(region.box), *box_of(at_rest(region).box), *halves)

    @property
    def nowhere(self) -> bool:
        """True if the region holds no start at rest."""
        return is_empty(self.states) is True

    @property
    def widened(self) -> Started:
        """The same without all that could exclude every start at rest."""
        return Started(replace(at_rest(self.region), differences=()), self.goal)


def start_of(profile: PolicyProfile, posed: Sequence[Posed]) -> Started:
    """From where episodes start of which claims speak. InputError for motion that nobody stated, games whose step is no
    affine map, claims for ever, and starts of more than one region or with more than one goal.
    """
    playable(profile)
    limited = [each.name for each in profile.world.agents if each.max_speed is not None]
    for bent, has in (("contacts", partners(profile.world)), ("speed limits", limited)):
        if has:
            what = f"claims about episodes of teams that test sums are not decided in games with {bent}"
            raise InputError(what, profile.world.name, "ask about single decisions, or extract without --splits")
    for each in posed:
        _ensure_in_steps(each)
    region = posed[0].region
    if any(each.region != region for each in posed):
        what = "claims about episodes of teams that test sums start in one region"
        raise InputError(what, "--region", "ask about one region after the other")
    goal, *others = region.goal_cases
    if others:
        what = f"episodes of teams that test sums have one goal, and region {region.name or 'given'} has several"
        advice = f'write goals = ["{goal}"] into a region file, and ask about one goal after the other'
        raise InputError(what, "--region", advice)
    return Started(region, goal)


def state_episodes(profile: PolicyProfile, posed: Sequence[Posed], started: Started) -> World:
    """A game as it moves, with all claims. `started`: as `start_of` gives it. The file of one that holds no start at
    rest says so, and nobody reads it.
    """
    claims, (region, goal) = [_ensure_in_steps(each) for each in posed], started
    steps = max(claim.steps for claim in claims)
    starts = bound_coordinates(profile, [region])
    moving = _bound_motion(profile, starts, steps)
    roundings, _ = list_noise(profile, moving.ranges, {})
    places = {name: ends for name, ends in moving.ranges.items() if not name.startswith(f"{PLACE}.")}
    ranges = {**places, **{name: (-most, most) for name, most in roundings.items()}}
    still = dict.fromkeys(velocities_of(profile.world), (ZERO, ZERO))
    begun = {name: ends for name, ends in {**ranges, **starts, **still}.items() if name in ranges}
    speeds = {name: ends for name, ends in region.box.items() if name.endswith((".vx", ".vy"))}  # some exclude rest
    where = list_conditions(region, None)
    where += [f"{name} >= {number_text(low)}" for name, (low, _) in speeds.items() if low > 0]
    where += [f"{name} <= {number_text(high)}" for name, (_, high) in speeds.items() if high < 0]
    document: Table = {
        "name": profile.world.name.partition(",")[0],
        "steps": steps,
        "variables": _variables({name: _widen(ends) for name, ends in ranges.items()}),
        "agents": {
            policy.agent: describe_agent(policy, roundings, _push(profile, policy.agent), goal or PLACE)
            for policy in profile.agents
        },
        "start": {"box": _bounds(begun), **({"where": where} if where else {})},
        "dynamics": {
            "next": {name: _spell_next(profile, name) for name in ranges},
            "error": {**moving.errors, **roundings},
        },
        "property": [table for claim in claims for table in _episode_claims(profile, claim, started.where)],
    }
    return World.of(OF_EPISODES, document)


def counts_steps(posed: Posed) -> bool:
    """Returns True if a claim is about episodes."""
    return "steps" in posed.claim.parameters


def _ensure_in_steps(posed: Posed) -> EpisodeClaim:
    """The claim, as one about so many steps."""
    if not counts_steps(posed):
        what = f"{posed.claim.name} is about single decisions, and stands beside claims about episodes"
        raise InputError(what, "--claim", "ask about decisions and episodes one after the other")
    claim = cast("EpisodeClaim", posed.claim)
    if claim.ever:
        what = f"{claim.name} for ever is not decided of teams that test sums"
        raise InputError(what, "--steps", "name a number of steps")
    return claim


def _bound_motion(profile: PolicyProfile, starts: Mapping[str, Interval], steps: int) -> Moving:
    """Bounds how far agents get in so many steps from rest, with a little room, and the roundings of a step.

    A step of a position multiplies and adds, one of a velocity multiplies twice and adds: each rounds what is at most
    the largest number here.
    """
    world, ranges, errors = profile.world, dict(starts), dict[str, Fraction]()
    dt, kept = Fraction(world.dt), Fraction(1.0 - world.damping)
    for entity in world.agents:
        for number, axis in enumerate("xy"):
            pushes = _list_pushes(profile, entity.name)
            push = max((abs(each[number]) for each in pushes), default=ZERO)
            fastest, far = ZERO, ZERO
            for _ in range(steps):
                far += dt * fastest
                fastest = (kept * fastest + push) * GROWN
            low, high = starts[f"{entity.name}.{axis}"]
            fastest, far = fastest * (1 + ROOM), far * (1 + ROOM) + max(abs(low), abs(high), Fraction(1)) * ROOM
            ranges[f"{entity.name}.{axis}"] = low - far, high + far
            ranges[f"{entity.name}.v{axis}"] = -fastest, fastest
            place = max(abs(low - far), abs(high + far))
            errors[f"{entity.name}.{axis}"] = _round_up(UNIT * GROWN * (place + 2 * dt * fastest))
            errors[f"{entity.name}.v{axis}"] = _round_up(UNIT * GROWN * (2 * kept * fastest + 2 * push))
    return Moving(ranges, errors)


def _widen(ends: Interval) -> Interval:
    """A range with a little room: a box that is rounded outwards stays in it."""
    room = (max(map(abs, ends)) or Fraction(1)) * ROOM
    return ends[0] - room, ends[1] + room


def _round_up(number: Fraction) -> Fraction:
    """A little more, of few digits."""
    unit = Fraction(1, 2**80)
    return (number // unit + 1) * unit


def _list_pushes(profile: PolicyProfile, agent: str) -> list[tuple[Fraction, Fraction]]:
    """Lists what each action of an agent adds to its velocity along each axis, exactly as the game computes it."""
    world = profile.world
    entity = next(each for each in world.agents if each.name == agent)
    pushes = accelerations(entity, profile.policy(agent).actions) * world.dt
    return [(Fraction(float(x)), Fraction(float(y))) for x, y in pushes]


def _push(profile: PolicyProfile, agent: str) -> Table:
    """What each action of an agent sets."""
    actions = zip(profile.policy(agent).actions, _list_pushes(profile, agent), strict=True)
    return {action.name: {"push_x": x, "push_y": y} for action, (x, y) in actions}


def _spell_next(profile: PolicyProfile, name: str) -> str:
    """The rule of a variable: places move with the old velocity; what rounding does is anew in each step."""
    world = profile.world
    owner, _, axis = name.rpartition(".")
    if owner in {each.name for each in world.agents}:
        if axis in ("x", "y"):
            return f"{name} + {plain(Fraction(world.dt))}*{owner}.v{axis}"
        if axis in ("vx", "vy"):
            return f"{plain(Fraction(1.0 - world.damping))}*{name} + {owner}.push_{axis[1]}"
        return "0"
    return name


def _episode_claims(profile: PolicyProfile, claim: EpisodeClaim, where: str) -> Iterator[Table]:
    """The tables of a claim: one for each agent that is to reach its own landmark. `where`: from where, in words."""
    shown = claim.label or f"{claim.name} of the {claim.team}"
    team = [policy.agent for policy in profile.team(claim.team)]
    if claim.apart:
        (pairs,) = matchings(profile, claim)
        inside = [_near(*pair, claim.radius, strict=True) for pair in pairs]
        yield _property(f"{shown}, {where}", "avoids", claim.steps, inside)
    elif account_of(claim).farthest is not None:
        bounds = [f"{agent}.{axis} {side}" for agent in team for axis in "xy" for side in _sides(claim.radius)]
        yield _property(f"{shown}, {where}", "stays_in", claim.steps, [bounds])
    elif claim.always:
        for agent, mark in zip(team, claim.named, strict=True):
            near = _near(agent, mark, claim.radius)
            yield _property(f"{shown}: {agent} to {mark}, {where}", "reaches", claim.steps, [near])
    else:
        ways = [
            [bound for agent, mark in matching for bound in _near(agent, mark, claim.radius)]
            for matching in matchings(profile, claim)
        ]
        yield _property(f"{shown}, {where}", "reaches_and_stays", claim.steps, ways, claim.steps)


def _property(label: str, name: str, steps: int, regions: Sequence[Sequence[str]], by: int | None = None) -> Table:
    within = [{"where": list(each)} for each in regions]
    return {"label": label, "name": name, "steps": steps, **({} if by is None else {"by": by}), "region": within}


def _near(one: str, other: str, radius: Fraction, strict: bool = False) -> list[str]:
    """That two are within a distance on both axes, or nearer than it."""
    return [f"{one}.{axis} - {other}.{axis} {side}" for axis in "xy" for side in _sides(radius, strict)]


def _sides(radius: Fraction, strict: bool = False) -> list[str]:
    equal = "" if strict else "="
    return [f"<{equal} {plain(radius)}", f">{equal} {plain(-radius)}"]
