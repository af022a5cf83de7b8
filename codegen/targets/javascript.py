"""JavaScript: an ES module for pages and Node.js.

Does: emits PREFIX.mjs.
Assumes: numbers are doubles, as ECMAScript says.
Does not: import anything.
"""

from codegen import ir
from codegen.lowering.model import Model
from codegen.lowering.render import render


def emit(model: Model, profile: ir.PolicyProfile) -> dict[str, str]:
    """The module."""
    return {f"{model.prefix}.mjs": render("javascript/module.js.j2", model=model)}


def harness(model: Model) -> str:
    """A script that decides for the rows in files, for replaying the module."""
    return render("javascript/harness.mjs.j2", model=model)
