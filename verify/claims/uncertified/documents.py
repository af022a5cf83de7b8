"""Formulas, regions and views as plain data, for files and reports.

Does: writes what the checker reads of them.
Assumes: nothing.
Does not: touch files.
"""

from typing import Any

from codegen.floats import rational_literal
from verify.claims.formula import Acts, And, Formula, Goal, Linear, Not
from verify.claims.observed import View
from verify.claims.region import Region
from verify.decimals import text


def formula_document(node: Formula) -> dict[str, Any]:
    """The formula as plain data; numbers are exact texts."""
    if isinstance(node, Linear):
        terms = [[rational_literal(weight), name] for weight, name in node.terms]
        return {"sum": terms, "below" if node.strict else "most": rational_literal(node.bound)}
    if isinstance(node, Acts):
        return {"agent": node.agent, "takes": node.action}
    if isinstance(node, Goal):
        return {"goal": node.landmark}
    if isinstance(node, Not):
        return {"not": formula_document(node.part)}
    return {"all" if isinstance(node, And) else "any": [formula_document(part) for part in node.parts]}


def region_document(region: Region) -> dict[str, Any]:
    """The region as plain data, numbers as exact text."""
    return {
        "goals": list(region.goals),
        "box": {name: [text(bound) for bound in bounds] for name, bounds in region.box.items()},
        "difference": {f"{a} - {b}": [text(bound) for bound in bounds] for a, b, bounds in region.differences},
        "apart": {f"{a} - {b}": text(least) for a, b, least in region.apart},
    }


def view_document(view: View) -> dict[str, list[str]]:
    """The view as plain data, which `view_from` reads."""
    mirrored = {} if view.mirrored is None else {"mirrored": [view.mirrored.agent, *view.mirrored.features]}
    return {"shared": list(view.shared), "raised": list(view.raised or ()), **mirrored}
