"""How a report tells of each kind of claim: the one place that knows them all.

Does: for a claim the functions that collect its facts and limits; sorts results by them.
Assumes: a module for each kind, imported where a result is of it, as most reports are about decisions alone.
Does not: say anything itself.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from verify.kinds import Kind
from verify.reports.telling import Telling
from verify.result import AnyResult


def _decisions() -> Telling:
    from verify.reports.decisions import TELLING

    return TELLING


def _episodes() -> Telling:
    from verify.reports.episodes import TELLING

    return TELLING


def _systems() -> Telling:
    from verify.reports.systems import TELLING

    return TELLING


TELLINGS: Mapping[Kind, Callable[[], Telling]] = {
    Kind.DECISIONS: _decisions,
    Kind.LEAVES: _decisions,
    Kind.EPISODES: _episodes,
    Kind.SYSTEMS: _systems,
}


def telling(result: AnyResult) -> Telling:
    """Returns the way in which a report tells of a result."""
    return _get_teller(result)()


def by_telling(results: Sequence[AnyResult]) -> list[tuple[Telling, list[AnyResult]]]:
    """Results that are told of alike, together, in the order of the table."""
    groups = [(tell, [one for one in results if _get_teller(one) is tell]) for tell in dict.fromkeys(TELLINGS.values())]
    return [(tell(), group) for tell, group in groups if group]


def _get_teller(result: AnyResult) -> Callable[[], Telling]:
    return TELLINGS[result.claim.kind]
