"""Built-in claims as objects: `maviper.verify(team, claims.Reaches(steps=25))`.

Does: hands on the class of each built-in claim, whose fields are the parameters that it reads; name and options of one.
Assumes: `verify.claims.built_in` declares the claims.
Does not: check values, or know a profile: whoever verifies does.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from codegen.errors import InputError
from verify.claims.built_in import Agree as Agree
from verify.claims.built_in import Aligned as Aligned
from verify.claims.built_in import AliveLeaves as AliveLeaves
from verify.claims.built_in import Assignment as Assignment
from verify.claims.built_in import Claim as Claim
from verify.claims.built_in import Covers as Covers
from verify.claims.built_in import Differ as Differ
from verify.claims.built_in import DistinctTargets as DistinctTargets
from verify.claims.built_in import Ignores as Ignores
from verify.claims.built_in import KeepsApart as KeepsApart
from verify.claims.built_in import Monotone as Monotone
from verify.claims.built_in import NoDouble as NoDouble
from verify.claims.built_in import OwnTarget as OwnTarget
from verify.claims.built_in import Reaches as Reaches
from verify.claims.built_in import StaysIn as StaysIn
from verify.claims.built_in import Steady as Steady
from verify.claims.built_in import Symmetric as Symmetric
from verify.claims.parameters import PARAMETER_NAMES


def name_of(claim: str | Claim) -> str:
    """The name of a claim, given as an object or by its name."""
    return claim.name if isinstance(claim, Claim) else claim


def parameters_of(claim: str | Claim) -> dict[str, Any]:
    """What an object says itself; a name says nothing."""
    return claim.options if isinstance(claim, Claim) else {}


def complete_parameters(claim: str | Claim, given: Mapping[str, Any]) -> dict[str, Any]:
    """The options that were given, with what an object says itself. InputError for what it says and an option too."""
    said = {name: value for name, value in given.items() if value is not None}
    if not isinstance(claim, Claim):
        return said
    twice = [name for name in said if name in (*PARAMETER_NAMES, "team")]
    if twice:
        what = f"the claim is an object, which has {', '.join(twice)} itself"
        raise InputError(what, twice[0], f"write it among the parameters of {type(claim).__name__}")
    return said | claim.options
