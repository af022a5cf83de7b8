"""Rust: a module that needs neither std nor alloc.

Does: emits PREFIX.rs.
Assumes: Rust 2018 or newer.
Does not: make a crate; `mod PREFIX;` takes the file in.
"""

from codegen import ir
from codegen.lowering.model import Model
from codegen.lowering.render import render


def emit(model: Model, profile: ir.PolicyProfile) -> dict[str, str]:
    """The module."""
    return {f"{model.prefix}.rs": render("rust/module.rs.j2", model=model)}


def harness(model: Model) -> str:
    """A program that decides for the rows in files, for replaying the module."""
    return render("rust/harness.rs.j2", model=model)
