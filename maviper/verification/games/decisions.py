"""Claims about single decisions of a team that tests sums, as a world file in which nothing moves.

Does: writes that file: coordinates, what agents observe of them with its roundings and errors, and each claim as a
  formula.
Assumes: a checked profile whose features have meanings, and whose agents take actions.
Does not: decide. Whoever checks a certificate has the file beside it, and reads what it is about.
"""

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from typing import cast

from codegen.errors import InputError
from codegen.ir import PolicyProfile
from maviper.verification.ask import Posed
from maviper.worlds.stated.observing import (
    PLACE,
    Observed,
    call_in_file,
    find_coordinate,
    list_noise,
    list_observed,
    spell_agent,
    spell_ends,
    spell_text,
)
from verify.claims.catalogue import select_stated
from verify.claims.decisions import DecisionClaim, formula
from verify.claims.formula import for_goal, names_goal
from verify.claims.region import Interval, Region
from verify.claims.verifiable import verifiable
from verify.decimals import text as number_text
from verify.systems.properties import spell_formula

HEAD = "# World states of a game: coordinates, and by how much what agents observe of them is off by rounding.\n"


def world_of(profile: PolicyProfile, posed: Sequence[Posed]) -> tuple[str, tuple[str, ...]]:
    """The world file with all claims, and where each of them speaks, in words.

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
    everything = {**ranges, **{name: (-most, most) for name, most in (*roundings.items(), *off.items())}}
    variables = "".join(f'"{name}" = {{ range = {spell_ends(ends)} }}\n' for name, ends in everything.items())
    agents = "".join(
        spell_agent(policy, {*roundings, *off}, "".join(f"{each.name} = {{}}\n" for each in policy.actions))
        for policy in profile.agents
    )
    starts = ", ".join(f'"{name}" = {spell_ends(ends)}' for name, ends in everything.items())
    properties = [
        each
        for one, claim in zip(posed, claims, strict=True)
        for each in _properties(profile, claim, one.region, ranges, _bound_errors(profile, claim, off))
    ]
    head = f"{HEAD}name = {spell_text(profile.world.name.partition(',')[0])}\n\n[variables]\n{variables}{agents}"
    return f"{head}\n[start]\nbox = {{ {starts} }}\n{''.join(each for each, _ in properties)}", tuple(
        where for _, where in properties
    )


def _ensure_decided(posed: Posed) -> DecisionClaim:
    """The claim, as one about single decisions."""
    if not posed.claim.per_state:
        what = f"{posed.claim.name} is not about single states, so it is not decided of teams that test sums"
        raise InputError(what, "--property", "ask one of distinct_targets, own_target, no_double, aligned, assignment")
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


def _properties(
    profile: PolicyProfile,
    claim: DecisionClaim,
    region: Region,
    ranges: Mapping[str, Interval],
    erring: Mapping[str, Interval],
) -> Iterator[tuple[str, str]]:
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
        regions = ", ".join(spell_region(region, goal, box) for goal in goals)
        yield f'\n[[property]]\nlabel = {spell_text(label)}\nformula = "{spelled}"\nregion = [{regions}]\n', where


def spell_region(region: Region, goal: str | None, box: Mapping[str, Interval]) -> str:
    """The part of a region with a goal, as world files write it. `box`: bounds narrower than the ranges."""
    bounds = ", ".join(f'"{name}" = {spell_ends(ends)}' for name, ends in box.items())
    where = ", ".join(f'"{each}"' for each in list_conditions(region, goal))
    parts = [*([f"box = {{ {bounds} }}"] if bounds else []), *([f"where = [{where}]"] if where else [])]
    return f"{{ {', '.join(parts)} }}"


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
