"""What is done with each kind of claim: the one place of this package that knows them all.

Does: for a claim the functions that answer it, and that write down what belongs to the answer.
Assumes: a module for each kind, imported when a claim is of it, as most commands are about decisions alone.
Does not: do any of it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from maviper.verification.procedures.procedure import Procedure
from verify.kinds import Kind
from verify.question import AnyClaim


def _decisions() -> Procedure:
    from maviper.verification.procedures.decisions import PROCEDURE

    return PROCEDURE


def _episodes() -> Procedure:
    from maviper.verification.procedures.episodes import PROCEDURE

    return PROCEDURE


def _systems() -> Procedure:
    from maviper.verification.procedures.systems import PROCEDURE

    return PROCEDURE


PROCEDURES: Mapping[Kind, Callable[[], Procedure]] = {
    Kind.DECISIONS: _decisions,
    Kind.LEAVES: _decisions,
    Kind.EPISODES: _episodes,
    Kind.SYSTEMS: _systems,
}


def procedure(claim: AnyClaim) -> Procedure:
    """Returns the procedure for a claim."""
    return PROCEDURES[claim.kind]()
