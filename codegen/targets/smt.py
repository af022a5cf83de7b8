"""SMT-LIB: every tree as a function over Float32, for solvers.

Does: emits PREFIX.smt2.
Assumes: a solver with the theory FloatingPoint.
Does not: ask anything.
"""

import numpy as np

from codegen import ir
from codegen.ir import Floats, Int32
from codegen.lowering.model import Agent, Model
from codegen.lowering.render import render
from codegen.numbers import smt_literal


def emit(model: Model, profile: ir.PolicyProfile) -> dict[str, str]:
    """The definitions."""
    return {f"{model.prefix}.smt2": render("smt/trees.smt2.j2", model=model)}


def facts(model: Model, agent: Agent, rows: Floats, wanted: Int32) -> list[str]:
    """Formulas without variables that all hold iff the agent's function takes the wanted actions."""
    bits = np.ascontiguousarray(rows, dtype=np.float32).view(np.uint32)
    name = agent.names.act
    return [
        f"(= ({name} {' '.join(smt_literal(int(value)) for value in row)}) {action})"
        for row, action in zip(bits, wanted, strict=True)
    ]
