"""Claims about whole episodes of a team that tests sums, as a world file that moves as the game does.

Does: writes that file: coordinates and velocities, how a step moves them and by how much float64 may be off, what
  agents observe, and each claim as regions that episodes reach or avoid. The goal's place is that of its landmark. Says
  where a region holds no start at rest, which no world file states.
Assumes: a checked profile whose features have meanings, and whose agents take actions.
Does not: decide, or play (playing.py).

A step adds in float64, and a world file knows exact numbers. So each next value has an error, bounded by the largest
numbers that episodes can come to. A rounding of what is observed is anywhere within its bound, anew in each step.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import NamedTuple, cast

from codegen.dynamics import accelerations, partners
from codegen.errors import InputError
from codegen.ir import PolicyProfile
from maviper.verification.ask import Posed
from maviper.verification.games.decisions import bound_coordinates, list_conditions
from maviper.worlds.stated.observing import (
    GROWN,
    PLACE,
    UNIT,
    list_noise,
    spell_agent,
    spell_ends,
    spell_text,
)
from verify.checker.episodes.reading import matchings
from verify.claims.episodes import EpisodeClaim
from verify.claims.region import Interval, Region
from verify.claims.uncertified.episodes import account_of
from verify.decimals import plain
from verify.decimals import text as number_text
from verify.states.episodes import at_rest, playable
from verify.systems.system import Affine, HalfSpace, Polytope, box_of, is_empty

HEAD = "# A game in exact numbers: each next value and each observation is off by what rounding may do to it.\n"
ZERO = Fraction(0)
ROOM = Fraction(1, 2**20)


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
    _ensure_affine(profile)
    for each in posed:
        _ensure_in_steps(each)
    return _ensure_one_start(posed)


def world_of(profile: PolicyProfile, posed: Sequence[Posed], started: Started) -> str:
    """The world file with all claims. `started`: as `start_of` gives it. The file of one that holds no start at rest
    says so, and nobody reads it.
    """
    claims, (region, goal) = [_ensure_in_steps(each) for each in posed], started
    steps = max(claim.steps for claim in claims)
    starts = bound_coordinates(profile, [region])
    moving = _bound_motion(profile, starts, steps)
    roundings, _ = list_noise(profile, moving.ranges, {})
    places = {name: ends for name, ends in moving.ranges.items() if not name.startswith(f"{PLACE}.")}
    ranges = {**places, **{name: (-most, most) for name, most in roundings.items()}}
    variables = "".join(f'"{name}" = {{ range = {spell_ends(_widen(ends))} }}\n' for name, ends in ranges.items())
    agents = "".join(
        spell_agent(policy, roundings, _spell_actions(profile, policy.agent), goal or PLACE)
        for policy in profile.agents
    )
    still = dict.fromkeys(_list_velocities(profile), (ZERO, ZERO))
    box = ", ".join(
        f'"{name}" = {spell_ends(ends)}' for name, ends in {**ranges, **starts, **still}.items() if name in ranges
    )
    where = ", ".join(f'"{each}"' for each in (*list_conditions(region, None), *_list_speeds(region)))
    rules = "".join(f'"{name}" = "{_spell_next(profile, name)}"\n' for name in ranges)
    errors = "".join(f'"{name}" = {number_text(most)}\n' for name, most in {**moving.errors, **roundings}.items())
    properties = "".join(table for claim in claims for table in _properties(profile, claim, started.where))
    name = spell_text(profile.world.name.partition(",")[0])
    head = f"{HEAD}name = {name}\nsteps = {steps}\n\n[variables]\n{variables}{agents}"
    start = f"\n[start]\nbox = {{ {box} }}\n" + (f"where = [{where}]\n" if where else "")
    motion = f"\n[dynamics.next]\n{rules}\n[dynamics.error]\n{errors}"
    return f"{head}{start}{motion}{properties}"


def counts_steps(posed: Posed) -> bool:
    """Returns True if a claim is about episodes."""
    return "steps" in posed.claim.parameters


def _ensure_in_steps(posed: Posed) -> EpisodeClaim:
    """The claim, as one about so many steps."""
    if not counts_steps(posed):
        what = f"{posed.claim.name} is about single decisions, and stands beside claims about episodes"
        raise InputError(what, "--property", "ask about decisions and episodes one after the other")
    claim = cast("EpisodeClaim", posed.claim)
    if claim.ever:
        what = f"{claim.name} for ever is not decided of teams that test sums"
        raise InputError(what, "--steps", "name a number of steps")
    return claim


def _ensure_one_start(posed: Sequence[Posed]) -> Started:
    """The region in which all episodes start, and the goal there."""
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


def _ensure_affine(profile: PolicyProfile) -> None:
    """InputError for a game with contacts or speed limits."""
    limited = [each.name for each in profile.world.agents if each.max_speed is not None]
    for what, has in (("contacts", partners(profile.world)), ("speed limits", limited)):
        if has:
            said = f"claims about episodes of teams that test sums are not decided in games with {what}"
            raise InputError(said, profile.world.name, "ask about single decisions, or extract without --splits")


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


def _list_speeds(region: Region) -> list[str]:
    """The bounds of velocities that exclude rest."""
    bounds = {name: ends for name, ends in region.box.items() if name.endswith((".vx", ".vy"))}
    lows = [f"{name} >= {number_text(low)}" for name, (low, _) in bounds.items() if low > 0]
    return lows + [f"{name} <= {number_text(high)}" for name, (_, high) in bounds.items() if high < 0]


def _list_velocities(profile: PolicyProfile) -> list[str]:
    return [f"{entity.name}.v{axis}" for entity in profile.world.agents for axis in "xy"]


def _spell_actions(profile: PolicyProfile, agent: str) -> str:
    """Writes what each action sets, a line for each."""
    actions = zip(profile.policy(agent).actions, _list_pushes(profile, agent), strict=True)
    return "".join(
        f"{action.name} = {{ push_x = {number_text(x)}, push_y = {number_text(y)} }}\n" for action, (x, y) in actions
    )


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


# --- claims


def _properties(profile: PolicyProfile, claim: EpisodeClaim, where: str) -> Iterator[str]:
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


def _property(label: str, name: str, steps: int, regions: Sequence[Sequence[str]], by: int | None = None) -> str:
    spelled = ", ".join(f"{{ where = [{', '.join(map(spell_text, each))}] }}" for each in regions)
    late = "" if by is None else f"by = {by}\n"
    return (
        f'\n[[property]]\nlabel = {spell_text(label)}\nname = "{name}"\nsteps = {steps}\n{late}region = [{spelled}]\n'
    )


def _near(one: str, other: str, radius: Fraction, strict: bool = False) -> list[str]:
    """That two are within a distance on both axes, or nearer than it."""
    return [f"{one}.{axis} - {other}.{axis} {side}" for axis in "xy" for side in _sides(radius, strict)]


def _sides(radius: Fraction, strict: bool = False) -> list[str]:
    equal = "" if strict else "="
    return [f"<{equal} {plain(radius)}", f">{equal} {plain(-radius)}"]
