"""How a claim about a stated system is divided into parts that follow few variables each.

Does: the parts for each of which the variables that it speaks of are followed, and all that these depend on.
Assumes: a checked system and claim.
Does not: prove them. A part may fail although the claim holds, as it knows nothing of the variables not followed.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from verify.checker.systems.certificates import needs_stated
from verify.checker.systems.proofs import FollowedPart
from verify.checker.systems.walk import ways
from verify.claims.formula import FALSE, Or, coordinates
from verify.reach.covering import close_names
from verify.systems.claims import SystemClaim
from verify.systems.system import System


def whole(system: System, claim: SystemClaim) -> FollowedPart:
    """All in one part, which follows every variable."""
    shows = range(ways(claim) + needs_stated(claim, system))
    return FollowedPart(tuple(one.name for one in system.variables), tuple(shows), (), b"")


def iterate_divisions(system: System, claim: SystemClaim) -> Iterator[list[FollowedPart]]:
    """Divisions worth trying, the finest one first."""
    if claim.about_decisions:
        return
    everything, before = len(system.variables), list[FollowedPart]()
    for features in (False, True):
        parts = _parts(system, claim, features)
        if parts != before and all(len(part.followed) < everything for part in parts):
            yield parts
        before = parts


def _parts(system: System, claim: SystemClaim, features: bool) -> list[FollowedPart]:
    """The parts, by the variables that the ways to break the claim speak of. `features`: also by those that features
    join with them.
    """
    groups: dict[tuple[str, ...], list[int]] = {}
    broken = claim.violation_at(claim.steps)
    about = [coordinates(broken)] * ways(claim)
    if isinstance(broken, Or) and claim.fulfilment_at(0) == FALSE:
        about = [coordinates(part) for part in broken.parts]
    if needs_stated(claim, system):
        tested = {name for piece in system.pieces for half in piece.when for name, _ in half.form.terms}
        about.append(frozenset(name for piece in system.pieces for name in piece.where) | tested)
    for way, names in enumerate(about):
        groups.setdefault(_close_names(system, names, features), []).append(way)
    return [FollowedPart(followed, tuple(shows), (), b"") for followed, shows in groups.items()]


def _close_names(system: System, names: Iterable[str], features: bool) -> tuple[str, ...]:
    """Variables with all that they depend on, in the system's order."""
    joined = [
        {name for name, _ in feature.form.terms} for known in system.features.values() for feature in known.values()
    ]
    closed = close_names(system, names, joined if features else ())
    return tuple(one.name for one in system.variables if one.name in closed)
