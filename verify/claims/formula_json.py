"""Formulas, read from the plain data of files.

Does: reads them without trusting them.
Assumes: a reader that turns ValueError, TypeError and LookupError into words about its file.
Does not: touch files.
"""

from collections.abc import Mapping
from typing import Any

from verify.claims.formula import Acts, And, Formula, Goal, Linear, Not, Or
from verify.exact import read_number

DEEPEST = 100  # levels of a formula


def read_formula(document: Mapping[str, Any], depth: int = 0) -> Formula:
    """The formula in plain data. ValueError for anything else."""
    if depth > DEEPEST:
        raise ValueError(f"$.formula: nested deeper than {DEEPEST}")
    match document:
        case {"sum": [*terms], **bound} if len(bound) == 1 and set(bound) <= {"most", "below"}:
            kept = tuple((read_number(weight), str(name)) for weight, name in terms)
            ((kind, value),) = bound.items()
            return Linear(kept, read_number(value), kind == "below")
        case {"agent": str(agent), "takes": int(action)} if len(document) == 2:
            return Acts(agent, action)
        case {"goal": str(landmark)} if len(document) == 1:
            return Goal(landmark)
        case {"not": part} if len(document) == 1:
            return Not(read_formula(part, depth + 1))
        case {"all": [*parts]} if len(document) == 1:
            return And(tuple(read_formula(part, depth + 1) for part in parts))
        case {"any": [*parts]} if len(document) == 1:
            return Or(tuple(read_formula(part, depth + 1) for part in parts))
        case _:
            raise ValueError(f"$.formula: {str(document)[:80]}")
