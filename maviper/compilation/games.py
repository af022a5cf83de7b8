"""World files that state what the agents of a game observe: what their proofs say of the game's own states.

Does: tells such a file from others; the region of a claim about single decisions, as regions of games are stated; how
  far a proof has to let roundings go.
Assumes: a proof that holds for all values of its variables, so also for those that no state of the game has.
Does not: trust a file: what agents observe by it is compared with their profile, and so is how far they round.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple

from codegen.deciding import only_acts
from codegen.errors import InputError
from codegen.ir import PolicyProfile
from codegen.world import RegionSpec
from maviper.worlds.stated.observing import PLACE, Observed, call_in_file, find_coordinate, find_goal, list_observed
from verify.claims.formula import And, Formula, Linear, Not, Or
from verify.claims.region import Interval
from verify.decimals import plain
from verify.systems.claims import SystemClaim
from verify.systems.statement import Statement
from verify.systems.system import Affine, Feature, HalfSpace, Measure, Polytope, System, narrow

MEASURES = {"": Measure.VALUE, "sign": Measure.SIGN, "positive": Measure.POSITIVE, "zero": Measure.EQUALS}
NONE: Interval = (Fraction(0), Fraction(0))
AGAIN = "verify the claim again, by its name and without --system"
ONE = "ask about one region after the other"


@dataclass(frozen=True)
class GameFile:
    """A world file whose variables are coordinates of a game, and by how much what agents observe of them is off."""

    observed: tuple[Observed, ...]  # what the trees test
    ranges: Mapping[str, Interval]  # of the variables
    place: str  # whose place the goal's is where agents observe it: a landmark, or PLACE

    @property
    def roundings(self) -> tuple[str, ...]:
        """The variables that roundings of what is observed are."""
        return tuple(each.rounding for each in self.observed if each.rounding in self.ranges)

    @property
    def errors(self) -> tuple[str, ...]:
        """The variables that errors of what is observed are."""
        return tuple(each.error for each in self.observed if each.error in self.ranges)

    def bound_roundings(self, ranges: Mapping[str, Interval]) -> dict[str, Fraction]:
        """By how much the game may round what is observed where variables are within `ranges`, by what the file calls,
        or would call, the rounding; 0 is left out.
        """
        known = dict(ranges)
        if self.place != PLACE:
            known |= {f"{PLACE}.{axis}": ranges[f"{self.place}.{axis}"] for axis in "xy"}
        errors = {each.error: max(map(abs, ranges.get(each.error, NONE))) for each in self.observed}
        bounds = {each.rounding: each.bound_rounding(known, errors[each.error]) for each in self.observed}
        return {name: most for name, most in bounds.items() if most}


def find_game(profile: PolicyProfile, statement: Statement) -> GameFile | None:
    """The file as one about the states of the profile's game; None for a file that states anything else, or that has
    no variable beside coordinates.
    """
    if not only_acts(profile) or any(each.meaning is None for policy in profile.agents for each in policy.features):
        return None
    if {each.name for each in statement.agents} != {policy.agent for policy in profile.agents}:
        return None
    observed = tuple(each for policy in profile.agents for each in list_observed(policy))
    ranges = {one.name: one.range for one in statement.system.variables}
    added = {name for each in observed for name in (each.rounding, each.error)}
    added |= {f"{PLACE}.{axis}" for axis in "xy"}
    if not ranges.keys() & added or ranges.keys() - added - set(map(call_in_file, profile.world.coordinates())):
        return None
    for place in (PLACE, *(each.name for each in profile.world.landmarks)):
        if all(_is_observed(each, statement.system, ranges, place) for each in observed):
            return GameFile(observed, ranges, place)
    return None


def _is_observed(one: Observed, system: System, ranges: Mapping[str, Interval], place: str) -> bool:
    """Returns True if the file states a feature as in the game, but for rounding and error; `place`: the goal's."""
    terms: dict[str, Fraction] = {}
    for weight, coordinate in one.meaning.terms:
        name = call_in_file(coordinate, place)
        terms[name] = terms.get(name, Fraction(0)) + Fraction(weight)
    off = {name: Fraction(1) for name in (one.error, one.rounding) if name in ranges}
    stated = system.features[one.policy.agent].get(one.feature.name)
    return terms.keys() <= ranges.keys() and stated == Feature(
        Affine.of({**terms, **off}), MEASURES[one.meaning.function]
    )


# --- claims about single decisions


def restate_formula(formula: Formula, profile: PolicyProfile, where: str) -> Formula:
    """A formula of the file as one over states of the game. InputError where it is about roundings or errors, which
    these do not have. `where` is named in errors.
    """
    known = frozenset(profile.world.coordinates())

    def restate(part: Formula) -> Formula:
        match part:
            case Linear(terms, bound, strict):
                named = tuple((weight, find_coordinate(name)) for weight, name in terms)
                if missing := sorted({name for _, name in named} - known):
                    what = f"the formula is about {missing[0]}, which no state of the game has"
                    raise InputError(what, where, "leave --certificate out; `maviper check` says what it proves")
                return Linear(named, bound, strict)
            case And(parts):
                return And(tuple(map(restate, parts)))
            case Or(parts):
                return Or(tuple(map(restate, parts)))
            case Not(negated):
                return Not(restate(negated))
            case _:
                return part

    return restate(formula)


class _Part(NamedTuple):
    """A polytope as what regions of games say."""

    bounds: dict[str, Interval]  # of all variables
    differences: dict[tuple[str, str], Interval]  # of two variables, the first in alphabetical order minus the other
    goal: str | None  # the landmark at which the goal is; None: nothing says so


def region_of(game: GameFile, claim: SystemClaim, where: str) -> RegionSpec:
    """The states of the game of which a claim about single decisions is proved. `where` is named in errors.

    InputError where it does not speak of all roundings that the game may make, or of features without errors, for
    several regions that have more than their goals apart, and for conditions that regions of games do not have.
    """
    first, *others = [_read_part(game, polytope, where) for polytope in claim.regions or ((),)]
    for part in (first, *others):
        _ensure_free(game, part, where)
        if part[:2] != first[:2] or (part.goal is None) != (first.goal is None):
            raise InputError("the claim speaks of several regions, and a monitor compares one", where, ONE)
    goals = tuple(part.goal for part in (first, *others) if part.goal is not None)
    noise = {*game.roundings, *game.errors}
    return RegionSpec(
        goals,
        {
            find_coordinate(name): (plain(low), plain(high))
            for name, (low, high) in first.bounds.items()
            if name not in noise and not _is_implied(name, first.bounds, goals)
        },
        {
            " - ".join(map(find_coordinate, pair)): (plain(low), plain(high))
            for pair, (low, high) in first.differences.items()
        },
    )


def _read_part(game: GameFile, polytope: Polytope, where: str) -> _Part:
    """A polytope, taken apart. InputError as `_ensure_stated`."""
    bounds, differences = dict(game.ranges), dict[tuple[str, str], Interval]()
    for half in polytope:
        _ensure_stated(game, half, where)
        (name, factor), *others = half.form.terms
        end = -half.form.constant / factor
        if not others:
            bounds[name] = narrow(bounds[name], factor, end)
        for other, _ in others:
            first, second = game.ranges[name], game.ranges[other]
            widest = first[0] - second[1], first[1] - second[0]
            differences[name, other] = narrow(differences.get((name, other), widest), factor, end)
    goal = find_goal(polytope)
    same = [{f"{PLACE}.{axis}", f"{goal}.{axis}"} for axis in "xy"]
    return _Part(bounds, {pair: ends for pair, ends in differences.items() if set(pair) not in same}, goal)


def _ensure_stated(game: GameFile, half: HalfSpace, where: str) -> None:
    """InputError for a condition that is no bound, and no bound of a difference of coordinates."""
    names, factors = [name for name, _ in half.form.terms], [factor for _, factor in half.form.terms]
    alone = len(names) == 1 and names[0] in game.ranges
    noise = {*game.roundings, *game.errors}
    compared = len(names) == 2 and not sum(factors) and game.ranges.keys() - noise >= set(names)
    if half.strict or not (alone or compared):
        what = f"a condition of the claim's regions is about {' and '.join(names) or 'nothing'}, and is no bound"
        raise InputError(f"{what} of a coordinate or of a difference of two", where, "state the region as a box")


def _is_implied(name: str, bounds: Mapping[str, Interval], goals: tuple[str, ...]) -> bool:
    """Returns True if bounds of the goal's place follow from those of all landmarks at which it may be."""
    place, _, axis = name.rpartition(".")
    if place != PLACE or not goals:
        return False
    low, high = bounds[name]
    return all(low <= bounds[f"{goal}.{axis}"][0] and bounds[f"{goal}.{axis}"][1] <= high for goal in goals)


def _ensure_free(game: GameFile, part: _Part, where: str) -> None:
    """InputError where a part leaves out roundings that the game may make in it, or features without errors."""
    for name, most in game.bound_roundings(part.bounds).items():
        low, high = part.bounds.get(name, NONE)
        if low > -most or high < most:
            what = f"the claim is about some values of {name} only, and the game may round by others"
            raise InputError(what, where, AGAIN)
    for name in game.errors:
        low, high = part.bounds[name]
        if not low <= 0 <= high:
            raise InputError(f"the claim leaves out that {name} is 0", where, AGAIN)


# --- claims about episodes


def ensure_anew(system: System, roundings: Mapping[str, Fraction], where: str) -> None:
    """InputError for a file that lets a rounding of what is observed be anything else, at a later step, than any number
    up to its bound.
    """
    for piece in system.pieces:
        pushed = {name for effect in piece.effect.values() for name in effect}
        for name, most in roundings.items():
            low, high = piece.error.get(name, NONE)
            if piece.move.get(name, Affine()) != Affine() or name in pushed or low > -most or high < most:
                what = f"the world file lets {name} be other numbers than the game may round by"
                raise InputError(what, where, AGAIN)
