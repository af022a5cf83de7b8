"""Stated systems as plain data with exact numbers, and their content hash.

Does: the document of a system, and the hash that certificates name.
Assumes: nothing.
Does not: read documents; users write files of another form.
"""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from fractions import Fraction
from typing import Any, cast

from codegen.floats import rational_literal
from verify.systems.system import Affine, Feature, Flow, FlowCase, HalfSpace, Interval, Piece, System, Variable


def content_hash(system: System) -> str:
    """SHA-256 of the document of a system."""
    canonical = json.dumps(document(system), sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(canonical.encode()).hexdigest()


def document(system: System) -> dict[str, Any]:
    """All that a system states, as plain data; numbers are exact texts."""
    return {
        "name": system.name,
        "variables": [[one.name, one.unit, *_interval(one.range), *_modes(one)] for one in system.variables],
        "features": {
            agent: {name: _feature(feature) for name, feature in features.items()}
            for agent, features in system.features.items()
        },
        "start": [_half(half) for half in system.start],
        "pieces": [_piece(piece) for piece in system.pieces],
        "steps": system.steps,
        "reference": system.reference,
        **({} if system.flow is None else {"flow": _flow(system.flow)}),
    }


def _modes(variable: Variable) -> list[list[str]]:
    return [list(variable.modes)] if variable.modes else []


def _flow(flow: Flow) -> dict[str, Any]:
    return {
        "period": rational_literal(flow.period),
        "rates": {name: _expression(rate) for name, rate in flow.rates.items()},
        "held": [
            [agent, action, {name: rational_literal(value) for name, value in values.items()}]
            for (agent, action), values in sorted(flow.held.items())
        ],
        "error": {name: _interval(bounds) for name, bounds in flow.error.items()},
        **({"jumps": {name: _expression(value) for name, value in flow.jumps.items()}} if flow.jumps else {}),
        **({"jitter": _interval(flow.jitter)} if any(flow.jitter) else {}),
        **({"seen": [dict(each) for each in flow.seen], "kept": dict(flow.kept)} if flow.kept else {}),
        **({"cases": [_case(each) for each in flow.cases]} if flow.cases else {}),
    }


def _case(case: FlowCase) -> dict[str, Any]:
    return {
        "where": {name: _interval(bounds) for name, bounds in case.where.items()},
        "when": [_half(half) for half in case.when],
        "rates": {name: _expression(rate) for name, rate in case.rates.items()},
        "error": {name: _interval(bounds) for name, bounds in case.error.items()},
        "jumps": {name: _expression(value) for name, value in case.jumps.items()},
        "choice": dict(case.choice),
    }


def _expression(part: Any) -> Any:
    """An expression as nested lists, each with its kind first; the members of its data classes are all that it says."""
    if is_dataclass(part):
        return [type(part).__name__, *(_expression(getattr(part, each.name)) for each in fields(part))]
    if isinstance(part, tuple):
        return [_expression(each) for each in cast("tuple[Any, ...]", part)]
    return rational_literal(part) if isinstance(part, Fraction) else part


def _interval(bounds: Interval) -> list[str]:
    return [rational_literal(bound) for bound in bounds]


def _affine(form: Affine) -> dict[str, Any]:
    return {
        "terms": {name: rational_literal(factor) for name, factor in form.terms},
        "constant": rational_literal(form.constant),
    }


def _half(half: HalfSpace) -> dict[str, Any]:
    return {"below" if half.strict else "most": _affine(half.form)}


def _feature(feature: Feature) -> dict[str, Any]:
    bounds = None if feature.bounds is None else _interval(feature.bounds)
    return {"form": _affine(feature.form), "measure": feature.measure.value, "bounds": bounds}


def _forms(forms: Mapping[str, Affine]) -> dict[str, Any]:
    return {name: _affine(form) for name, form in forms.items()}


def _piece(piece: Piece) -> dict[str, Any]:
    entry = {
        "where": {name: _interval(bounds) for name, bounds in piece.where.items()},
        "move": _forms(piece.move),
        "effect": [[agent, action, _forms(forms)] for (agent, action), forms in sorted(piece.effect.items())],
        "error": {name: _interval(bounds) for name, bounds in piece.error.items()},
    }
    entry |= {"when": [_half(half) for half in piece.when]} if piece.when else {}
    return entry | ({"choice": dict(piece.choice)} if piece.choice else {})
