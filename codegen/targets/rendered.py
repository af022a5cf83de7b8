"""Targets that are one text: C, Python, JavaScript, Rust, JSON, SMT-LIB, JAX and PyTorch, and the monitors of three.

Does: emits the files of each from the lowered model; harnesses, by which they are replayed; facts that Z3 is to find
  true.
Assumes: C99 and IEEE binary32 `float` without fast-math (the header refuses it); Python 3.8; numbers that are
  doubles, as ECMAScript says; Rust 2018; a solver with the theory FloatingPoint; JAX 0.4 or PyTorch 2.2 with whoever
  runs the module.
Does not: use heap, libc, recursion or mutable globals in C; import anything of this project in Python, std or alloc
  in Rust; import JAX or PyTorch, or let them observe world states, for which JAX has no doubles unless it is told to.

The JSON is the profile itself, of which a reader walks `tree` from node 0: left iff x[feature] <= threshold. The
array modules nest `where` over the bits of float32 numbers, in their order: XLA on a CPU takes subnormal numbers for
zero, and a GPU may.
"""

from collections.abc import Callable, Iterable
from functools import lru_cache

import numpy as np

from codegen import ir
from codegen.ir import Floats, Int32
from codegen.lowering.lower import lower
from codegen.lowering.model import Agent, Model
from codegen.lowering.render import render
from codegen.lowering.watching import WORDS, Watch
from codegen.numbers import smt_literal
from codegen.policy_json import dumps

HARNESSES = {"c": "c/harness.c.j2", "javascript": "javascript/harness.mjs.j2", "rust": "rust/harness.rs.j2"}
LANGUAGES = {"c": "h", "python": "py", "javascript": "mjs"}  # of monitors: target -> the ending of its file


def emit_c(model: Model, profile: ir.PolicyProfile) -> dict[str, str]:
    """One header with every agent's policy, for one observation, many, or a world state."""
    template = "c/freestanding.h.j2" if model.bare else "c/header.h.j2"
    return {f"{model.prefix}.h": render(template, model=model)}


def emit_shared(model: Model, profile: ir.PolicyProfile) -> dict[str, str]:
    """The header, and C that exports its decisions: the text by which it is replayed, without what tests alone call."""
    return {**emit_c(model, profile), f"{model.prefix}_shared.c": harness(model, "c", whole=False)}


def one_text(template: str, ending: str, **values: str) -> Callable[[Model, ir.PolicyProfile], dict[str, str]]:
    """The emitter of PREFIX and `ending`, which is one template. `values`: what this takes beside the model."""

    def emit(model: Model, profile: ir.PolicyProfile) -> dict[str, str]:
        return {f"{model.prefix}{ending}": render(template, model=model, **values)}

    return emit


@lru_cache(maxsize=1)
def usual_c(profile: ir.PolicyProfile) -> tuple[Model, str, str]:
    """The model of a profile, and name and text of the header that it gets without options. It is kept, as a
    counterexample is replayed by it and its report quotes it.
    """
    model = lower(profile)
    ((name, header),) = emit_c(model, profile).items()
    return model, name, header


def emit_json(model: Model, profile: ir.PolicyProfile) -> dict[str, str]:
    """The profile and a reference reader to start from, the same for every profile of float32 agents."""
    return {
        f"{model.prefix}.json": dumps(profile),
        f"{model.prefix}_reader.py": render("json/reader.py.j2", model=model),
    }


def emit_monitors(watch: Watch, targets: Iterable[str]) -> dict[str, str]:
    """The monitors beside the code, name -> text; for C, PREFIX.h has to be there. Targets that have none get none."""
    return {
        f"{watch.model.prefix}_monitor.{ending}": render(
            f"monitor/monitor.{ending}.j2", watch=watch, check=watch.check, model=watch.model, words=WORDS
        )
        for target, ending in LANGUAGES.items()
        if target in targets
    }


def harness(model: Model, target: str, whole: bool = True) -> str:
    """A program in the language of a target that decides for the rows in files, for replaying what was emitted.
    `whole`: of C, whether it calls all functions, or `act` and the input checks alone.
    """
    return render(HARNESSES[target], model=model, whole=whole)


def facts(model: Model, agent: Agent, rows: Floats, wanted: Int32) -> list[str]:
    """Formulas without variables that all hold iff the SMT-LIB function of an agent takes the wanted actions."""
    bits = np.ascontiguousarray(rows, dtype=np.float32).view(np.uint32)
    name = agent.names.act
    return [
        f"(= ({name} {' '.join(smt_literal(int(value)) for value in row)}) {action})"
        for row, action in zip(bits, wanted, strict=True)
    ]
