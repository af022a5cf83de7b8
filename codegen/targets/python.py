"""Python: one module that needs the standard library only (numpy inside the batch functions).

Does: emits PREFIX.py.
Assumes: Python 3.8 or newer.
Does not: import anything of this project.
"""

from codegen import ir
from codegen.lowering.model import Model
from codegen.lowering.render import render


def emit(model: Model, profile: ir.PolicyProfile) -> dict[str, str]:
    """The module."""
    return {f"{model.prefix}.py": render("python/module.py.j2", model=model)}
