"""C99: one header with every agent's policy, for one observation, many, or a world state.

Does: emits PREFIX.h.
Assumes: IEEE binary32 `float`; a compiler without fast-math (the header refuses it).
Does not: use heap, libc, recursion or mutable globals.
"""

from codegen import ir
from codegen.lowering.model import Model
from codegen.lowering.render import render


def emit(model: Model, profile: ir.PolicyProfile) -> dict[str, str]:
    """The header."""
    return {f"{model.prefix}.h": render("c/header.h.j2", model=model)}


def harness(model: Model) -> str:
    """A C file that exports every agent's decision over rows, for replaying the header."""
    return render("c/harness.c.j2", model=model)
