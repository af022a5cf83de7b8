"""A file of Python: what it names, and which of its functions and classes decide.

Does: evaluates what stands outside functions; finds the functions, methods and lambdas that take an observation and
  return a decision, and are no parts of others.
Assumes: a syntax tree of the module ast.
Does not: follow a function (source.py).

What is not understood outside functions is skipped with a word: names that it sets are an error where a decision reads
them, and so is all that it might have changed.
"""

# pyright: basic
# the values of a program may be anything
import ast
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, NamedTuple

from codegen.errors import InputError, escape_text
from codegen.importers.python.attributes import CHANGING
from codegen.importers.python.machine import Machine, text_of
from codegen.importers.python.values import Class, Function, Instance, Module, Scope, Unread
from codegen.importers.symbolic.paths import STATE_ADVICE

MAGIC = frozenset(
    ("exec", "eval", "globals", "locals", "vars", "setattr", "delattr", "compile", "__import__", "__builtins__")
)
PLAYING = frozenset(("step", "reset", "render"))  # of an environment: whoever calls it plays
USUAL = ("__call__", "act", "decide", "predict", "select_action", "choose_action", "get_action", "policy", "control",
         "compute_action", "step", "forward", "action")  # fmt: skip
MUTABLE = (list, dict, set, Instance, Class)
CHANGES = (ast.Attribute, ast.Subscript)
ALONE = "say --agents {}=FILE to take this function alone"


class Decider(NamedTuple):
    """A function that decides, and what stands before the observation: the object whose method it is."""

    name: str
    function: Function
    first: tuple[Any, ...] = ()


@dataclass(frozen=True)
class File:
    """What a file holds."""

    scope: Scope
    nodes: list[ast.AST]  # in the order of the text
    machine: Machine
    simple: bool  # whether no function changes a list or an object, or holds another one


def file_of(parsed: ast.Module, machine: Machine) -> File:
    """A file, evaluated but for its functions. InputError for what may give names other meanings."""
    nodes = list(ast.walk(parsed))
    for node in nodes:
        if isinstance(node, ast.Name) and node.id in MAGIC:
            raise machine.make_error(node, f"{node.id!r} may change what names stand for", "remove it")
        annotation = getattr(node, "annotation", None) or getattr(node, "returns", None)
        for each in ast.walk(annotation) if isinstance(annotation, ast.AST) else ():
            if isinstance(each, ast.Call | ast.NamedExpr):
                raise machine.make_error(each, "an annotation calls or assigns something", "name types only")
    scope = Scope({"__name__": "policy"})
    for node in parsed.body:
        try:
            machine.run(node, scope)
        except InputError as error:
            if isinstance(node, ast.ImportFrom) or machine.steps > 1 << 22:
                raise
            _skip(machine, node, scope, error)
    for node in nodes:
        if isinstance(node, ast.Global):
            for name in node.names:
                scope.names[name] = Unread(f"{escape_text(name)!r} may change between calls", STATE_ADVICE, node.lineno)
    inner = [part for node in nodes if isinstance(node, ast.FunctionDef) for part in node.body]
    simple = not any(_is_changing(each) for part in inner for each in ast.walk(part))
    ordered = sorted(nodes, key=lambda node: (getattr(node, "lineno", 0), getattr(node, "col_offset", 0)))
    return File(scope, ordered, machine, simple)


def _is_changing(node: ast.AST) -> bool:
    """Whether a state that was marked might be changed by what follows: lists and objects, or functions that see it."""
    if isinstance(node, CHANGES) and not isinstance(node.ctx, ast.Load):
        return True
    if isinstance(node, ast.AugAssign | ast.Lambda | ast.FunctionDef | ast.GeneratorExp):
        return True
    return isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr in CHANGING


def _skip(m: Machine, node: ast.stmt, scope: Scope, error: InputError) -> None:
    """Goes on without a statement: what it sets, or might change, is not known any more."""
    unread = Unread(error.what, error.next_step, node.lineno)
    called = [each.func for each in ast.walk(node) if isinstance(each, ast.Call)]
    own = any(isinstance(scope.names.get(each.id), Function | Class) for each in called if isinstance(each, ast.Name))
    stores = any(isinstance(each, CHANGES) and not isinstance(each.ctx, ast.Load) for each in ast.walk(node))
    for each in ast.walk(node):
        if isinstance(each, ast.Name):
            held = scope.names.get(each.id)
            touched = ((called or stores) and isinstance(held, MUTABLE)) or (stores and isinstance(held, Module))
            if isinstance(each.ctx, ast.Store) or touched:
                scope.names[each.id] = unread
        if isinstance(each, ast.FunctionDef | ast.ClassDef):
            scope.names[each.name] = unread
    if own:
        mutable = [name for name, value in scope.names.items() if isinstance(value, MUTABLE)]
        scope.names |= {name: unread for name in mutable if not isinstance(scope.names[name], Class)}
    m.notes[f"line {node.lineno}: {text_of(node)} is skipped: {error.what}"] = None


# --- which functions decide


def deciders(file: File, wanted: str = "") -> list[Decider]:
    """The functions that decide; `wanted`: the only one that is asked for, if there is one of that name."""
    names = {name: value for name, value in file.scope.names.items() if isinstance(value, Function | Class | Instance)}
    chosen = names.get(wanted)
    if isinstance(chosen, Function):
        return [Decider(wanted, chosen)]
    made = {id(each.kind) for each in names.values() if isinstance(each, Instance)}
    made |= {id(base) for each in names.values() if isinstance(each, Class) for base in each.bases}
    by_name: dict[str, Decider] = {}
    for name, value in names.items():
        if isinstance(value, Class) and id(value) in made:
            continue
        decider = Decider(name, value) if isinstance(value, Function) else _method(file, name, value)
        if decider is None:
            continue
        why = _idle(file.machine, decider)
        if why:
            file.machine.notes[f"{escape_text(name)} is skipped: it {why}"] = None
        elif not any(decider.function is each.function and decider.first == each.first for each in by_name.values()):
            by_name[name] = decider
    if isinstance(names.get(wanted), Class | Instance) and wanted in by_name:
        return [by_name[wanted]]
    used = {inner for name, each in by_name.items() for inner in _names(file, each) if inner != name}
    roots = [each for name, each in by_name.items() if name not in used]
    whole = [
        each for each in roots if not any(isinstance(one, Class) and one in file.machine.made for one in each.first)
    ]
    roots = whole or roots  # a class whose objects the file makes is a part of something, if anything else decides
    if not (roots or by_name):
        unread = next((each for each in file.scope.names.values() if isinstance(each, Unread)), None)
        known = ", ".join(file.machine.notes)[:200]
        where = f"{file.machine.where}, line {unread.line}" if unread else file.machine.where
        what = unread.what if unread else "the file has no function that takes an observation and returns a decision"
        advice = unread.advice if unread else "write one function per agent: def agent(x): ..."
        raise InputError(what, where, f"{advice}{known and '; ' + known}")
    return roots or list(by_name.values())


def _method(file: File, name: str, value: Class | Instance) -> Decider | None:
    """The method of a class that decides."""
    kind = value if isinstance(value, Class) else value.kind
    if kind.enum:
        return None
    methods = dict[str, Any]()
    for base in reversed(kind.lineage):
        methods |= base.members
    public = [each for each in methods.values() if isinstance(each, Function) and each.kind != "property"]
    public = [each for each in public if each.name == "__call__" or not each.name.startswith("_")]
    given = [Decider(name, each, () if each.kind == "static" else (value,)) for each in public]
    taking = [each for each in given if not _idle(file.machine, each)]
    nodes = (inner for each in taking for inner in ast.walk(each.function.node))
    used = {inner.attr for inner in nodes if isinstance(inner, ast.Attribute)}
    roots = [each for each in taking if each.function.name not in used] or taking
    usual = [each for wanted in USUAL for each in roots if each.function.name == wanted]
    if len(roots) > 1 and not usual:
        several = ", ".join(each.function.name for each in roots)
        what = f"the class {escape_text(kind.name)} has several methods that may decide: {several}"
        raise file.machine.make_error(roots[1].function.node, what, "name the one that decides act")
    return next(iter(usual or roots), None)


def _idle(m: Machine, decider: Decider) -> str:
    """Why a function decides nothing; "": it may."""
    node, function = decider.function.node, decider.function
    takes = node.args
    required = [
        each.arg for each in (*takes.posonlyargs, *takes.args, *takes.kwonlyargs) if each.arg not in function.defaults
    ]
    if len(required) <= len(decider.first):
        return "takes no observation"
    if function in m.makers:
        return "makes functions or objects"
    if isinstance(node, ast.Lambda):
        return ""
    inner = [each for part in node.body for each in ast.walk(part)]
    if not any(isinstance(each, ast.Return) and each.value is not None for each in inner):
        return "returns nothing"
    if any(
        isinstance(each, ast.Call) and isinstance(each.func, ast.Attribute) and each.func.attr in PLAYING
        for each in inner
    ):
        return "plays an environment"
    return ""


def _names(file: File, decider: Decider) -> Iterable[str]:
    """The names that a function, or the class whose method it is, mentions."""
    nodes: list[ast.AST] = [decider.function.node]
    for each in decider.first:
        kind = each if isinstance(each, Class) else each.kind
        nodes += [one.node for base in kind.lineage for one in base.members.values() if isinstance(one, Function)]
    return {inner.id for node in nodes for inner in ast.walk(node) if isinstance(inner, ast.Name)}
