"""Firmware of C that reads sensors and moves motors by calls: which functions these are, and which one decides.

Does: finds the declarations of functions that are read as features, or stand for actions, and takes their own code
  away; says which functions call them.
Assumes: a syntax tree that nobody else reads yet.
Does not: follow a decision (source.py), or write what stands for these functions where a compiler is asked
  (compiled.py).
"""

# pyright: basic
# pycparser's nodes have no declared attributes
from collections.abc import Iterable, Mapping
from typing import Any

from pycparser import c_ast

from codegen.errors import InputError, escape_text
from codegen.importers.c.machine import parameters_of, walk
from codegen.importers.c.memory import collect_called

ENTRIES = frozenset(("main", "setup", "loop"))


def find_calls(parsed: Any, names: Iterable[str], where: str, *, acting: bool) -> dict[str, Any]:
    """The declarations of functions, by their names; what the file says that they do is taken away. `acting`: they
    give nothing. InputError for a function that the file does not declare, or that is given something.
    """
    found = dict[str, Any]()
    for name in names:
        what, form = (
            f"the file declares no function {escape_text(name)}",
            f"{'void' if acting else 'float'} {name}(void);",
        )
        for place, each in enumerate(parsed.ext):
            decl = each.decl if isinstance(each, c_ast.FuncDef) else each
            if not isinstance(decl, c_ast.Decl) or decl.name != name or not isinstance(decl.type, c_ast.FuncDecl):
                continue
            parsed.ext[place] = decl
            result = getattr(decl.type.type.type, "names", None)
            if parameters_of(c_ast.FuncDef(decl, None, None)):
                what = f"{escape_text(name)} is given something"
            elif acting and result != ["void"]:
                what = f"{escape_text(name)} is an action, and gives a value"
            else:
                found[name] = decl
        if name not in found:
            raise InputError(what, where, f"declare a function of its own: {form}")
    walk.cache_clear()
    return found


def list_callers(functions: Mapping[str, Any], acts: Iterable[str]) -> list[str]:
    """The functions that call one of `acts`, directly or not, and that no other of these calls; `loop` only where it
    is the only one, `main` never.
    """
    wanted = {*acts}

    def reaches(name: str) -> bool:
        called = collect_called(name, functions)
        return any(
            isinstance(part, c_ast.ID) and part.name in wanted for one in called for part in walk(functions[one])
        )

    acting = [name for name in functions if name not in ("main", "setup") and reaches(name)]
    inner = {part for name in acting if name not in ENTRIES for part in collect_called(name, functions) - {name}}
    roots = [name for name in acting if name not in inner]
    return [name for name in roots if name not in ENTRIES] or roots
