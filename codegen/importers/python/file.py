"""A file of if/else Python: its functions, the numbers that it names for all of them, and what else may stand there.

Does: reads what stands outside functions; skips literals, and remembers their names; reads numbers and names.
Assumes: a syntax tree of the module ast.
Does not: read a function's statements (source.py), run, import or evaluate anything of the file.
"""

import ast
import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from codegen.errors import InputError, shown
from codegen.importers.rules import Number

MAX_SHOWN = 60


def refused(node: ast.AST, where: str, what: str, advice: str) -> InputError:
    """What is wrong at a node's line."""
    return InputError(what, f"{where}, line {getattr(node, 'lineno', 1)}", advice)


@dataclass(frozen=True)
class File:
    """What a file holds."""

    functions: tuple[ast.FunctionDef, ...]
    constants: Mapping[str, Number]  # numbers with names
    skipped: frozenset[str]  # names of other literals, which no decision may read


def file_of(parsed: ast.Module, where: str) -> File:
    """The functions of a file, and what it names for all of them. InputError for whatever else does something."""
    functions: list[ast.FunctionDef] = []
    constants: dict[str, Number] = {}
    skipped: set[str] = set()
    bound: Counter[str] = Counter()
    _ensure_idle(parsed, where)
    for node in parsed.body:
        names: list[str] = []
        if isinstance(node, ast.FunctionDef):
            functions.append(node)
            names = [node.name]
        elif isinstance(node, ast.Import | ast.ImportFrom):
            names = [(each.asname or each.name).split(".")[0] for each in node.names]
        elif (pair := named_value(node)) is not None and (value := number_of(pair[1])) is not None:
            constants[pair[0]] = value
            names = [pair[0]]
        elif isinstance(node, ast.Assign | ast.AnnAssign) and _is_idle(node):
            names = assigned(node)
            skipped.update(names)
        elif not isinstance(node, ast.Pass) and not (isinstance(node, ast.Expr) and _is_literal(node.value)):
            what = f"{words_of(node)} stands outside a function"
            raise refused(node, where, what, "keep functions, literals, and numbers with names, only")
        bound.update(names)
    for name in [name for name, count in bound.items() if count > 1 or name == "*"]:
        raise InputError(f"the name {shown(name)!r} may mean several things", where, "give each name once")
    if not functions:
        raise InputError("the file has no function", where, "write one function an agent: def agent(x): ...")
    return File(tuple(functions), constants, frozenset(skipped))


def _is_idle(node: ast.Assign | ast.AnnAssign) -> bool:
    """Whether an assignment gives names to a literal, or declares a name, and does nothing else."""
    targets = node.targets if isinstance(node, ast.Assign) else [node.target]
    parts = [each for target in targets for each in ast.walk(target)]
    plain = all(isinstance(each, ast.Name | ast.Tuple | ast.List | ast.Store) for each in parts)
    return plain and (node.value is None or _is_literal(node.value))


def _is_literal(node: ast.expr) -> bool:
    """Whether an expression is a literal: constants, and lists, tuples, sets and dictionaries of literals."""
    inner = (ast.Constant, ast.List, ast.Tuple, ast.Set, ast.Dict, ast.Load, ast.UnaryOp, ast.USub, ast.UAdd)
    return all(isinstance(each, inner) for each in ast.walk(node))


def _ensure_idle(parsed: ast.Module, where: str) -> None:
    """InputError for annotations that do something: Python evaluates them, and they may give names other values."""
    for given in ast.walk(parsed):
        annotation = getattr(given, "annotation", None) or getattr(given, "returns", None)
        for node in ast.walk(annotation) if isinstance(annotation, ast.AST) else ():
            if isinstance(node, ast.Call | ast.NamedExpr):
                raise refused(node, where, "an annotation calls or assigns something", "name types only")


def words_of(node: ast.AST) -> str:
    """The kind of a node, in quotes."""
    return f"{type(node).__name__!r}"


def text_of(node: ast.expr) -> str:
    """An expression as Python, short enough for a line."""
    try:
        return shown(ast.unparse(node))[:MAX_SHOWN]
    except ValueError:  # of integers with thousands of digits
        return words_of(node)


def named_value(node: ast.stmt) -> tuple[str, ast.expr] | None:
    """The name and the value of `name = value` or `name: type = value`."""
    if isinstance(node, ast.Assign) and len(node.targets) == 1 and isinstance(node.targets[0], ast.Name):
        return node.targets[0].id, node.value
    if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name) and node.value is not None:
        return node.target.id, node.value
    return None


def number_of(node: ast.expr) -> Number | None:
    """A finite number with its signs; None: it is none."""
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub | ast.UAdd):
        inner = number_of(node.operand)
        return None if inner is None else -inner if isinstance(node.op, ast.USub) else +inner
    value = node.value if isinstance(node, ast.Constant) else None
    return value if isinstance(value, int | float) and (isinstance(value, int) or math.isfinite(value)) else None


def dotted(node: ast.expr) -> str:
    """A name with dots, such as Action.LEFT; "": it is none."""
    parts: list[str] = []
    while isinstance(node, ast.Attribute):
        parts.append(node.attr)
        node = node.value
    return ".".join([node.id, *reversed(parts)]) if isinstance(node, ast.Name) else ""


def assigned(node: ast.stmt) -> list[str]:
    """The names that a statement assigns to, itself; of ways to assign, no others are understood."""
    targets = node.targets if isinstance(node, ast.Assign) else [node.target] if isinstance(node, ast.AnnAssign) else []
    return [each.id for target in targets for each in ast.walk(target) if isinstance(each, ast.Name)]


def assigned_below(nodes: Sequence[ast.stmt]) -> Counter[str]:
    """How often names are assigned to in statements and below them."""
    found: Counter[str] = Counter()
    open_ = list(nodes)
    while open_:
        node = open_.pop()
        found.update(assigned(node))
        if isinstance(node, ast.If):
            open_ += [*node.body, *node.orelse]
    return found
