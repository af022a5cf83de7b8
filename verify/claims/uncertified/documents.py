"""Formulas as plain data, for files.

Does: writes what formula_json.py reads.
Assumes: nothing.
Does not: touch files.
"""

from typing import Any

from codegen.floats import rational_literal
from verify.claims.formula import Acts, And, Formula, Goal, Linear, Not


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
