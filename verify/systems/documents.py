"""Stated systems as plain data with exact numbers, and their content hash.

Does: the document of a system, and the hash that certificates name.
Assumes: nothing.
Does not: read documents; users write files of another form.
"""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from fractions import Fraction
from typing import Any, cast

from codegen.floats import rational_literal
from verify.systems.system import Affine, Feature, Flow, FlowCase, HalfSpace, Piece, System

OPTIONAL = ("jumps", "jitter", "seen", "kept", "cases", "when", "choice")  # left out of all but cases where empty


def content_hash(system: System) -> str:
    """SHA-256 of the document of a system."""
    canonical = json.dumps(document(system), sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(canonical.encode()).hexdigest()


def document(system: System) -> dict[str, Any]:
    """All that a system states, as plain data; numbers are exact texts."""
    return {
        "variables": [
            [one.name, one.unit, *plain(one.range), *([list(one.modes)] if one.modes else [])]
            for one in system.variables
        ],
        **{
            name: plain(getattr(system, name)) for name in ("name", "features", "start", "pieces", "steps", "reference")
        },
        **({} if system.flow is None else {"flow": plain(system.flow)}),
    }


def plain(value: Any) -> Any:
    """A part of a system as plain data: an expression as a list, its kind first; all else by its members."""
    match value:
        case Fraction():
            return rational_literal(value)
        case Affine(terms, constant):
            return {"terms": plain(dict(terms)), "constant": plain(constant)}
        case HalfSpace(form, strict):
            return {"below" if strict else "most": plain(form)}
        case Piece() | Flow() | FlowCase() | Feature():
            members = {each.name: getattr(value, each.name) for each in fields(value)}
            stated = (name for name in members if name not in OPTIONAL or type(value) is FlowCase or any(members[name]))
            return {
                name: _choices(members[name]) if name in ("effect", "held") else plain(members[name]) for name in stated
            }
        case Mapping():
            return {name: plain(each) for name, each in cast("Mapping[str, Any]", value).items()}
        case tuple():
            return [plain(each) for each in cast("tuple[Any, ...]", value)]
        case Enum():
            return value.value
        case _ if is_dataclass(value):
            return [type(value).__name__, *(plain(getattr(value, each.name)) for each in fields(value))]
        case _:
            return value


def _choices(given: Mapping[tuple[str, str], Any]) -> list[list[Any]]:
    return [[agent, action, plain(each)] for (agent, action), each in sorted(given.items(), key=lambda one: one[0])]
