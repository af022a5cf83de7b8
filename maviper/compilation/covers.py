"""From the certificate of a claim about a stated system to the sets of states that its proof speaks of, as boxes.

Does: has the checker accept the certificate, and keeps the sets that it asks about on the way; sums that regions bound,
  with whole factors, as columns behind the variables of a state; narrows boxes to half spaces.
Assumes: a world file beside the certificate; files that anyone wrote; regions of half spaces.
Does not: trust a proof, find sets of its own, or add floats (codegen/lowering/model.py raises sums by more than
  rounding can hide).

Every state of such a set, a box, is one of which the proof holds: the claim, from this step on, as long as the system
moves as its file states. So a state in a set is vouched for, however it got there.
"""

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import chain
from math import gcd, lcm
from pathlib import Path

import numpy as np

from codegen.errors import InputError
from codegen.ir import Float64, PolicyProfile
from codegen.lowering.covering import MAX_GIVEN, Boxes, Cover, Variable
from codegen.lowering.model import RaisedSum
from codegen.numbers import nearest_double
from codegen.world import RegionSpec
from maviper.compilation.games import GameFile, ensure_anew, find_game, region_of
from maviper.worlds.stated.certified import ensure_accepted, read_certificate, sentence
from maviper.worlds.stated.observing import PLACE
from verify.checker.covers.boxes import BoxList, end_of
from verify.checker.covers.invariants import names_of
from verify.checker.covers.rounding import ceiling, floor
from verify.checker.flows.steps import SetList
from verify.checker.systems.proofs import Cover as CoverProof
from verify.checker.systems.proofs import FlowSets, Invariant, SystemCertificate, Walks
from verify.reports.systems import period
from verify.systems.claims import SystemClaim
from verify.systems.expressions import Number
from verify.systems.observing import as_played, list_roundings
from verify.systems.statement import Statement
from verify.systems.system import HalfSpace, Interval, Polytope

LARGEST_FACTOR = 1 << 500  # of a sum, so that its products overflow for no likely number
Terms = tuple[tuple[str, int], ...]  # of a sum: variables, and whole factors without a common divisor
Columns = Mapping[Terms, int]  # of boxes: of each variable, and of each sum
Parts = tuple[Boxes, ...]


def list_columns(statement: Statement, regions: Iterable[Polytope]) -> Columns:
    """The columns of boxes: all variables, then the sums."""
    variables: list[Terms] = [((one.name, 1),) for one in statement.system.variables]
    return {terms: at for at, terms in enumerate([*variables, *_list_sums(regions)])}


def ensure_wide(regions: Iterable[Polytope], where: str) -> None:
    """InputError for a region that is flat along a sum of variables, or that weighs them by far too unlike factors."""
    for region in regions:
        bounds = dict[Terms, Fraction]()
        for terms, bound in map(_scale, region):
            bounds[terms] = min(bound, bounds.get(terms, bound))
            opposite = tuple((name, -factor) for name, factor in terms)
            named = f"a condition of the regions compares {' and '.join(name for name, _ in terms)}"
            if len(terms) > 1 and bound + bounds.get(opposite, 1 - bound) <= 0:
                what = f"{named} with one number, and rounding hides whether a sum is that"
                raise InputError(what, where, "state a region that has some width")
            if any(abs(factor) > LARGEST_FACTOR for _, factor in terms):
                raise InputError(f"{named} by factors that are too unlike", where, "state them in other units")


def narrow(columns: Columns, region: Polytope, low: Float64, high: Float64) -> None:
    """Narrows bounds, [columns] or [columns, n], to half spaces; rounded inward."""
    for half in region:
        terms, bound = _scale(half)
        last = end_of(bound, half.strict).last
        if not terms and last < 0.0:  # 0 is not within the bound: no state is
            low[...], high[...] = np.inf, -np.inf
        elif terms in columns:
            high[columns[terms]] = np.minimum(high[columns[terms]], last)
        elif terms:  # minus one variable
            at = columns[((terms[0][0], 1),)]
            low[at] = np.maximum(low[at], -last)


def widen(boxes: Boxes, columns: Columns) -> Boxes:
    """Boxes with columns for sums, which they do not bound."""
    more = (0, 0), (0, len(columns) - boxes.low.shape[1])
    return Boxes(np.pad(boxes.low, more, constant_values=-np.inf), np.pad(boxes.high, more, constant_values=np.inf))


def keep_sums(
    regions: Iterable[Polytope], names: Sequence[str], steps: Sequence[Parts]
) -> tuple[tuple[Parts, ...], tuple[RaisedSum, ...]]:
    """The boxes of the one list of a claim, without sums that are within their bounds all over a part; and the sums
    that are left. `names`: of the variables. InputError for sums of others.
    """
    columns = {name: at for at, name in enumerate(names)}
    listed = _list_sums(regions)
    if missing := [name for one in listed for name, _ in one if name not in columns]:
        what = f"a region compares {missing[0]} with other variables, and it is a rounding, which no state has"
        raise InputError(what, "--certificate", "leave it out of the regions; then verify again")
    sums = [RaisedSum(tuple((columns[name], float(factor)) for name, factor in one)) for one in listed]
    kept, parts = set[int](), list[Boxes]()
    for part in chain.from_iterable(steps):
        high = part.high.copy()
        for at, each in enumerate(sums, start=len(names)):
            corners = part.low[:, : len(names)].copy()  # in which the sum is largest
            for column, factor in each.terms:
                corners[:, column] = (part.high if factor > 0 else part.low)[:, column]
            if ((each.of(corners) <= high[:, at]) | (high[:, at] == np.inf)).all():
                high[:, at] = np.inf
            else:
                kept.add(at)
        parts.append(Boxes(part.low, high))
    left = [*range(len(names)), *sorted(kept)]
    narrowed = tuple(Boxes(part.low[:, left], part.high[:, left]) for part in parts)
    return (narrowed,), tuple(sums[at - len(names)] for at in sorted(kept))


def _list_sums(regions: Iterable[Polytope]) -> list[Terms]:
    """The sums of several variables that regions bound."""
    halves = chain.from_iterable(regions)
    return list(dict.fromkeys(terms for half in halves if len(terms := _scale(half)[0]) > 1))


def _scale(half: HalfSpace) -> tuple[Terms, Fraction]:
    """A half space as a sum with whole factors, and its bound."""
    terms, whole = half.form.terms, lcm(*(factor.denominator for _, factor in half.form.terms))
    scale = Fraction(whole, gcd(*(int(whole * factor) for _, factor in terms)) or 1)
    return tuple((name, int(scale * factor)) for name, factor in terms), -scale * half.form.constant


Sets = BoxList | SetList
Lists = dict[int, list[Sets]]  # by step, or by part of an invariant
Steps = Sequence[Sequence[Boxes]]


def load_cover(certificate: Path, profile: PolicyProfile) -> tuple[Cover | RegionSpec, str]:
    """Returns what a certificate proves of a profile in the world file beside it, and the claim in words. Where the
    file states what agents observe in their game, it is about states of the game: no state is without the roundings
    that the file names. Of a claim about single decisions in a game, it is a region.

    InputError for a certificate of another profile or system, and for one whose sets cannot be watched, with the
    reason; RefusedError where its proof does not hold.
    """
    proof, statement = read_certificate(certificate)
    game, where = find_game(profile, statement), str(certificate)
    if game is not None and game.place == PLACE and proof.claim.about_decisions:
        region = region_of(game, proof.claim, where)
        ensure_accepted(certificate, proof, statement, profile)
        return region, _say(proof.claim, *as_played(statement, profile))
    _ensure_watchable(proof, where)
    lists: Lists = defaultdict(list)

    def watch(at: int, sets: Sets) -> None:
        lists[at].append(sets)

    ensure_accepted(certificate, proof, statement, profile, watch)
    claim, rests = proof.claim, _rests(statement)
    dt = nearest_double(Fraction(period(statement) or (1 if game is None else profile.world.dt)))
    statement, profile = as_played(statement, profile)
    ranges = _ranges(statement)
    steps = [
        [split_modes(statement, part, where) for part in parts]
        for parts in _list_steps(proof, statement, ranges, lists)
    ]
    ever = claim.about_decisions or claim.says.ever
    if not claim.about_decisions:
        ranges = _reaching(ranges, steps)
    unmeasured = {name: _range_of(statement, name) for name in list_roundings(statement)}
    if game is not None and not game.errors and isinstance(proof.proof, CoverProof):
        unmeasured |= _list_roundings_of(game, statement, steps, where)
    measured, bounds = _drop_roundings(statement, ranges, steps, unmeasured)
    names = [one.name for one in measured]
    bounds, sums = keep_sums(_list_regions(proof), names, bounds) if ever else (bounds, ())
    measured, bounds = _shift_memory(profile, measured, bounds, sums, where)
    cover = Cover(measured, bounds, ever, not claim.about_decisions, dt, rests, sums)
    place = PLACE if game is None else game.place
    where = "" if place == PLACE else f", where the goal is at {place}"
    return cover, _say(claim, statement, profile) + where


def _shift_memory(
    profile: PolicyProfile,
    measured: tuple[Variable, ...],
    steps: Sequence[Parts],
    sums: Sequence[RaisedSum],
    where: str,
) -> tuple[tuple[Variable, ...], tuple[Parts, ...]]:
    """Variables and boxes with what is remembered as agents count it, in its own range: a system counts it from 0 on.

    InputError for a region that compares it with other variables.
    """
    own = {f"{p.agent}.{each.name}": (each.low, each.high) for p in profile.agents for each in p.memory}
    offset = np.array([own.get(one.name, (0.0, 0.0))[0] for one in measured])
    for shifting in (measured[column] for one in sums for column, _ in one.terms if offset[column]):
        what = f"a region compares {shifting.name} with other variables, and that is not counted from 0"
        raise InputError(what, where, "leave it out of the regions; then verify again")
    column = np.concatenate([offset, np.zeros(len(sums))])
    shifted = tuple(tuple(Boxes(part.low + column, part.high + column) for part in parts) for parts in steps)
    return tuple(Variable(one.name, *own.get(one.name, one[1:])) for one in measured), shifted


def _say(claim: SystemClaim, statement: Statement, profile: PolicyProfile) -> str:
    """A claim in words that are made from its data alone."""
    return sentence(replace(claim, label=""), statement, profile)


ADVICE = "a monitor needs a proof by boxes, by cells, or of a claim about decisions"
SYMBOLIC = "the certificate follows symbolic states, and to find out whether a state is in one takes a linear program"
TURNED = "the sets of the certificate are turned boxes, and a box around one holds states of which nothing is proved"
FORMS = "the sets of the certificate are affine forms, and to find out whether a state is in one takes a linear program"


def _ensure_watchable(certificate: SystemCertificate, where: str) -> None:
    """InputError for a certificate whose sets are no boxes, or say nothing of later states."""
    match certificate.proof:
        case Walks():
            if not certificate.claim.about_decisions:
                raise InputError(SYMBOLIC, where, f"{ADVICE}: verify with a larger --effort")
            ensure_wide(_list_regions(certificate), where)
        case CoverProof(sets="forms"):
            raise InputError(FORMS, where, ADVICE)
        case FlowSets(cells=cells, levels=levels):
            if not cells or levels:  # between two joins the sets of a level keep their frames
                raise InputError(
                    TURNED, where, "a monitor needs a proof by boxes: a formula, or a world that moves in steps"
                )
        case Invariant(parts):
            if any(part.regions and part.steps > 1 for part in parts):
                what = "the invariant is a region of which several states in a row were asked, and a monitor knows one"
                raise InputError(what, where, "a monitor needs a proof by cells: leave `invariant` out of the claim")
            ensure_wide(_list_regions(certificate), where)
        case CoverProof():
            pass
    if certificate.claim.says.once:
        what = "the claim is fulfilled once the region is reached, and nothing is proved of what comes then"
        raise InputError(what, where, "a monitor needs a claim about all states, such as reaches_and_stays")


def _list_regions(certificate: SystemCertificate) -> list[Polytope]:
    """The regions that name what boxes bound."""
    parts = certificate.proof.parts if isinstance(certificate.proof, Invariant) else ()
    own = [each.region for part in parts for each in part.regions]
    return [*certificate.claim.regions, *certificate.claim.assuming, *own]


def _list_steps(
    certificate: SystemCertificate, statement: Statement, ranges: Sequence[Variable], lists: Lists
) -> Steps:
    """The parts of each step, all of which a state has to lie in; `lists`: the sets that the checker asked about."""
    claim, proof = certificate.claim, certificate.proof
    match proof:
        case Walks():
            columns = list_columns(statement, _list_regions(certificate))
            return [[_within(columns, claim.regions or ((),), ranges)]]
        case CoverProof() | FlowSets():
            return [[_together(lists[step])] for step in range(claim.steps + 1)]
        case Invariant():
            columns = list_columns(statement, _list_regions(certificate))
            anywhere = [one._replace(low=-np.inf, high=np.inf) for one in ranges]
            found: list[Boxes] = []
            for at, part in enumerate(proof.parts):
                if part.regions:
                    regions = [_without_roundings(statement, each.region) for each in part.regions]
                    found.append(_within(columns, regions, anywhere))
                else:
                    found.append(_meeting(columns, claim, _together(lists[at]), set(part.widths)))
            if claim.assuming:  # of whatever it leaves out nothing is said, and from then on nothing
                found.append(_within(columns, claim.assuming, anywhere))
            return [found]


def split_modes(statement: Statement, boxes: Boxes, where: str) -> Boxes:
    """The boxes, one for each value of each mode that they bound. `where` is named in errors. InputError for too
    many.
    """
    low, high = boxes.low.copy(), boxes.high.copy()
    for at, one in enumerate(statement.system.variables):
        if one.modes:
            values = np.arange(float(len(one.modes)))
            met = (low[:, at, None] <= values) & (high[:, at, None] >= values)
            free = np.isinf(low[:, at]) & np.isinf(high[:, at])  # a proof that does not follow it holds of any number
            met[free] = values == 0.0
            rows, chosen = np.nonzero(met)
            if len(rows) > MAX_GIVEN:
                what = f"the proof's sets are more than {MAX_GIVEN:,} boxes, one for each value of its modes"
                raise InputError(what, where, "verify a claim about fewer of them")
            low, high = low[rows], high[rows]
            bound = ~free[rows]
            low[bound, at] = high[bound, at] = values[chosen][bound]
    return Boxes(low, high)


def _without_roundings(statement: Statement, region: Polytope) -> Polytope:
    """A region without the bounds that all roundings keep."""
    ranges = {name: _range_of(statement, name) for name in list_roundings(statement)}
    return tuple(
        half
        for half in region
        if len(half.form.terms) != 1
        or not (names_of(half) <= ranges.keys())
        or not all(half.holds({name: end}) for name in names_of(half) for end in ranges[name])
    )


def _rests(statement: Statement) -> dict[str, str]:
    """By agent the first action that sets nothing, so that all that others set is 0."""
    rests: dict[str, str] = {}
    for agent in statement.agents:
        for name, sets in agent.actions.items():
            if all(isinstance(value, Number) and not value.value for value in sets.values()):
                rests.setdefault(agent.name, name)
    return rests


def _together(lists: Sequence[Sets]) -> Boxes:
    boxes = [each.numbered if isinstance(each, SetList) else each for each in lists]
    return Boxes(np.concatenate([each.low for each in boxes]), np.concatenate([each.high for each in boxes]))


def _ranges(statement: Statement) -> tuple[Variable, ...]:
    """The ranges of the variables, rounded inward; of roundings, which no state is without, outward."""
    roundings, ranges = set(list_roundings(statement)), list[Variable]()
    for one in statement.system.variables:
        least, most = (floor, ceiling) if one.name in roundings else (ceiling, floor)
        ranges.append(Variable(one.name, least(one.range[0]) + 0.0, most(one.range[1]) + 0.0))
    return tuple(ranges)


def _reaching(ranges: Sequence[Variable], steps: Steps) -> tuple[Variable, ...]:
    """The ranges, wide enough for all boxes: a state that a proof leads to is no invalid one. What a proof does not
    follow may be any finite number.
    """
    most = float(np.finfo(np.float64).max)
    variables: list[Variable] = []
    for at, one in enumerate(ranges):
        low = min(float(part.low[:, at].min(initial=one.low)) for parts in steps for part in parts)
        high = max(float(part.high[:, at].max(initial=one.high)) for parts in steps for part in parts)
        variables.append(Variable(one.name, max(low, -most), min(high, most)))
    return tuple(variables)


def _list_roundings_of(game: GameFile, statement: Statement, steps: Steps, where: str) -> dict[str, Interval]:
    """Bounds the roundings of a game where agents observe it, anywhere in the sets of a proof, by variable. InputError
    where its file lets a later rounding be another number.
    """
    parts = [part for each in steps for part in each]
    low = np.min([part.low.min(axis=0) for part in parts], axis=0)
    high = np.max([part.high.max(axis=0) for part in parts], axis=0)
    ends = zip(statement.system.variables, low.tolist(), high.tolist(), strict=True)
    most = game.bound_roundings({one.name: (Fraction(least), Fraction(largest)) for one, least, largest in ends})
    ensure_anew(statement.system, most, where)
    return {name: (-most.get(name, Fraction(0)), most.get(name, Fraction(0))) for name in game.roundings}


def _range_of(statement: Statement, name: str) -> Interval:
    """The range of a variable."""
    return next(one.range for one in statement.system.variables if one.name == name)


def _drop_roundings(
    statement: Statement, ranges: Sequence[Variable], steps: Steps, roundings: Mapping[str, Interval]
) -> tuple[tuple[Variable, ...], tuple[tuple[Boxes, ...], ...]]:
    """The variables that can be measured, and of each part the boxes that hold all roundings: what is proved of those
    is proved of any that the agents make. InputError where that is nothing.
    """
    if not roundings:
        return tuple(ranges), tuple(map(tuple, steps))
    variables = statement.system.variables
    kept = [at for at, one in enumerate(variables) if one.name not in roundings]
    sums = range(len(variables), steps[0][0].low.shape[1])
    added = [at for at, one in enumerate(variables) if one.name in roundings]
    least = np.array([floor(roundings[variables[at].name][0]) for at in added])
    most = np.array([ceiling(roundings[variables[at].name][1]) for at in added])

    def project(part: Boxes) -> Boxes:
        held = (part.low[:, added] <= least) & (part.high[:, added] >= most)
        whole = held.all(axis=1)
        if len(held) and not whole.any():
            named = next(variables[at].name for at, holds in zip(added, held.T, strict=True) if not holds.all())
            what = f"the sets of the proof hold some values of {named} only, and agents may round by others"
            raise InputError(what, "--certificate", "verify the claim again")
        columns = [*kept, *sums]
        return Boxes(part.low[whole][:, columns], part.high[whole][:, columns])

    return tuple(ranges[at] for at in kept), tuple(tuple(map(project, parts)) for parts in steps)


def _within(columns: Columns, regions: Sequence[Polytope], ranges: Sequence[Variable]) -> Boxes:
    """The regions within the ranges, as boxes, rounded inward."""
    low, high = np.array([one.low for one in ranges]), np.array([one.high for one in ranges])
    whole = widen(Boxes(np.tile(low, (len(regions), 1)), np.tile(high, (len(regions), 1))), columns)
    for row, region in enumerate(regions):
        narrow(columns, region, whole.low[row], whole.high[row])
    return _drop_empty(whole)


def _meeting(columns: Columns, claim: SystemClaim, part: Boxes, followed: set[str]) -> Boxes:
    """Returns the part of an invariant's boxes that meets the claim on followed variables; rounded inward."""
    pieces, part = list[Boxes](), widen(part, columns)
    for region in claim.regions:
        halves = tuple(half for half in region if names_of(half) <= followed)
        if len(claim.regions) > 1 and len(halves) < len(region):
            halves = ()  # of a union of regions a part shows all or nothing
        low, high = part.low.copy(), part.high.copy()
        narrow(columns, halves, low.T, high.T)
        pieces.append(_drop_empty(Boxes(low, high)))
    return Boxes(np.concatenate([each.low for each in pieces]), np.concatenate([each.high for each in pieces]))


def _drop_empty(boxes: Boxes) -> Boxes:
    """Those that hold a state."""
    return boxes.take(np.asarray((boxes.low <= boxes.high).all(axis=1), dtype=np.bool_))
