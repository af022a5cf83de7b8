"""A file of Python: what it names, and which of its functions and classes decide.

Does: evaluates what stands outside functions; finds the functions, methods and lambdas that take an observation and
  return a decision, and are no parts of others.
Assumes: a syntax tree of the module ast.
Does not: follow a function (source.py).

What is not understood outside functions is skipped with a word, if it can change nothing of the file: names that it
sets are an error where a decision reads them.
"""

# pyright: basic
# the values of a program may be anything
import ast
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, NoReturn

from codegen.errors import InputError, escape_text
from codegen.importers.python.machine import Machine, text_of, walk_nodes
from codegen.importers.python.objects import MAKERS
from codegen.importers.python.values import Class, Function, Instance, Refused, Scope, Unread
from codegen.importers.symbolic.paths import STATE_ADVICE

MAGIC = frozenset(
    ("exec", "eval", "globals", "locals", "vars", "setattr", "delattr", "compile", "__import__", "__builtins__")
)
KNOWN = ("__name__", "__init__")
PLAYING = frozenset(("step", "reset", "render"))  # of an environment: whoever calls it plays
USUAL = ("__call__", "act", "decide", "predict", "select_action", "choose_action", "get_action", "policy", "control",
         "compute_action", "step", "forward", "action")  # fmt: skip
CHANGING = (ast.Attribute, ast.Subscript, ast.AugAssign, ast.Lambda, ast.GeneratorExp)
CHANGED = (list, dict, set, tuple, Function, Class, Instance)  # which a call may change
ALONE = "say --agents {}=FILE to take this function alone"
MAIN = 'put what only demonstrates the controller under if __name__ == "__main__":'


class Decider(NamedTuple):
    """A function that decides, and what stands before the observation: the object whose method it is."""

    name: str
    function: Function
    first: tuple[Any, ...] = ()


@dataclass(frozen=True)
class File:
    """What a file holds."""

    scope: Scope
    nodes: Mapping[type[ast.AST], Sequence[Any]]  # by their kinds
    machine: Machine
    simple: bool  # whether no function changes a list or an object, or holds another one

    def inside(self, node: Any, *kinds: type[ast.AST]) -> list[Any]:
        """The nodes of these kinds within a function."""
        first, last = node.lineno, node.end_lineno
        return [each for kind in kinds for each in self.nodes.get(kind, ()) if first <= each.lineno <= last]


def file_of(parsed: ast.Module, machine: Machine) -> File:
    """A file, evaluated but for its functions. InputError for what may give names other meanings."""
    nodes = defaultdict[type[ast.AST], list[Any]](list)
    for node in walk_nodes(parsed):
        nodes[type(node)].append(node)
    _ensure_plain(machine, nodes)
    machine.assigning = any(nodes[kind] for kind in (ast.NamedExpr, ast.Yield, ast.YieldFrom))
    functions = nodes[ast.FunctionDef]
    _collect_kept(machine, functions, nodes[ast.Attribute])
    scope = Scope({"__name__": "policy"})
    for node in parsed.body:
        try:
            machine.run(node, scope)
        except InputError as error:
            if isinstance(node, ast.ImportFrom) or machine.hard or machine.steps > 1 << 22:
                raise
            _skip(machine, node, scope, error)
    for node in nodes[ast.Global]:
        for name in node.names:
            scope.names[name] = Unread(f"{escape_text(name)!r} may change between calls", STATE_ADVICE, node.lineno)
    outer = {id(each) for node in (parsed, *nodes[ast.ClassDef]) for each in node.body}
    file = File(scope, nodes, machine, simple=False)
    changing = (each for function in functions for each in file.inside(function, *CHANGING))
    simple = all(id(each) in outer for each in functions) and not any(map(_is_changing, changing))
    return replace(file, simple=simple)


def _ensure_plain(m: Machine, nodes: Mapping[type[ast.AST], Sequence[Any]]) -> None:
    """Refuses what may give names other meanings."""
    for node in nodes[ast.Name]:
        if node.id in MAGIC:
            _refuse(m, node, f"{node.id!r} may change what names stand for", "remove it")
    for node in nodes[ast.Attribute]:
        if node.attr[:2] == "__" == node.attr[-2:] and node.attr not in KNOWN:
            _refuse(m, node, "this is a part of how Python works", "write the constant, or the call, itself")
    annotations = [each.annotation for each in (*nodes[ast.arg], *nodes[ast.AnnAssign])]
    for annotation in filter(None, (*annotations, *(each.returns for each in nodes[ast.FunctionDef]))):
        for each in ast.walk(annotation):
            if isinstance(each, ast.Call | ast.NamedExpr):
                _refuse(m, each, "an annotation calls or assigns something", "name types only")


def _refuse(m: Machine, node: ast.AST, what: str, advice: str) -> NoReturn:
    raise m.make_error(node, Refused(what, advice, hard=True))


def _collect_kept(m: Machine, functions: Iterable[ast.FunctionDef], attributes: Sequence[ast.Attribute]) -> None:
    """Which functions set which attributes, but of the object that they make."""
    for each in attributes:
        for function in functions if isinstance(each.ctx, ast.Store) else ():
            own = function.args.args[0].arg if function.name in MAKERS and function.args.args else ""
            inside = function.lineno <= each.lineno <= (function.end_lineno or 0)
            if inside and not (isinstance(each.value, ast.Name) and each.value.id == own):
                m.kept.setdefault(each.attr, set()).add(function)


def _is_changing(node: Any) -> bool:
    """Whether a state that was marked might be changed by what follows: lists and objects, or functions that see it."""
    if isinstance(node, ast.Attribute | ast.Subscript):
        return not isinstance(node.ctx, ast.Load) or getattr(node, "attr", "") == "append"
    return True


def _skip(m: Machine, node: ast.stmt, scope: Scope, error: InputError) -> None:
    """Goes on without a statement: what it sets, or might change, is not known any more."""
    inner = walk_nodes(node, (ast.FunctionDef, ast.ClassDef, ast.Lambda))
    held = [scope.names.get(each.id) for each in inner if isinstance(each, ast.Name)]
    calls = any(isinstance(each, ast.Call) for each in inner)
    stores = any(
        isinstance(each, ast.Attribute | ast.Subscript) and not isinstance(each.ctx, ast.Load) for each in inner
    )
    if stores or (calls and any(isinstance(each, CHANGED) for each in held)):
        raise InputError(error.what, error.where, f"{error.next_step}; or {MAIN}")  # what changes may have other names
    unread = Unread(error.what, error.next_step, node.lineno)
    for each in inner:
        if isinstance(each, ast.Name) and isinstance(each.ctx, ast.Store):
            scope.names[each.id] = unread
        if isinstance(each, ast.FunctionDef | ast.ClassDef):
            scope.names[each.name] = unread
    m.notes[f"line {node.lineno}: {text_of(node)} is skipped: {error.what}"] = None


# --- which functions decide


def deciders(file: File, wanted: str = "") -> list[Decider]:
    """The functions that decide; `wanted`: the only one that is asked for, if there is one of that name."""
    names = {name: value for name, value in file.scope.names.items() if isinstance(value, Function | Class | Instance)}
    chosen = names.get(wanted)
    if isinstance(chosen, Function):
        return [Decider(wanted, chosen)]
    made = {id(each.kind) for each in names.values() if isinstance(each, Instance)}
    by_name: dict[str, Decider] = {}
    for name, value in names.items():
        if isinstance(value, Class) and id(value) in made:
            continue
        decider = Decider(name, value) if isinstance(value, Function) else _choose_method(file, name, value)
        if decider is None:
            continue
        why = _idle(file, decider)
        if why:
            file.machine.notes[f"{escape_text(name)} is skipped: it {why}"] = None
        elif not any(decider.function is each.function and decider.first == each.first for each in by_name.values()):
            by_name[name] = decider
    if isinstance(names.get(wanted), Class | Instance) and wanted in by_name:
        return [by_name[wanted]]
    if not by_name:
        raise _refuse_file(file)
    if len(by_name) == 1:
        return list(by_name.values())
    used = {inner for name, each in by_name.items() for inner in _names(file, each) if inner != name}
    roots = [each for name, each in by_name.items() if name not in used]
    whole = [
        each for each in roots if not any(isinstance(one, Class) and one in file.machine.made for one in each.first)
    ]
    # a class whose objects the file makes is a part of something, if anything else decides
    return whole or roots or list(by_name.values())


def _refuse_file(file: File) -> InputError:
    """Why no function decides."""
    unread = next((each for each in file.scope.names.values() if isinstance(each, Unread)), None)
    known = ", ".join(file.machine.notes)[:200]
    where = f"{file.machine.where}, line {unread.line}" if unread else file.machine.where
    what = unread.what if unread else "the file has no function that takes an observation and returns a decision"
    advice = unread.advice if unread else "write one function per agent: def agent(x): ..."
    if not (file.nodes[ast.FunctionDef] or file.nodes[ast.Lambda] or file.nodes[ast.ClassDef]):
        what, advice = "no function: put the rule into one", "write def agent(x): ... and return the action"
    return InputError(what, where, f"{advice}{known and '; ' + known}")


def _choose_method(file: File, name: str, value: Class | Instance) -> Decider | None:
    """The method of a class that decides."""
    kind = value if isinstance(value, Class) else value.kind
    if kind.enum:
        return None
    public = [each for each in kind.members.values() if isinstance(each, Function) and each.kind != "property"]
    public = [each for each in public if each.name == "__call__" or not each.name.startswith("_")]
    given = [Decider(name, each, () if each.kind == "static" else (value,)) for each in public]
    taking = [each for each in given if not _idle(file, each)]
    used = {inner.attr for each in taking for inner in file.inside(each.function.node, ast.Attribute)}
    roots = [each for each in taking if each.function.name not in used] or taking
    usual = [each for wanted in USUAL for each in roots if each.function.name == wanted]
    if len(roots) > 1 and not usual:
        several = ", ".join(each.function.name for each in roots)
        what = f"the class {escape_text(kind.name)} has several methods that may decide: {several}"
        raise file.machine.make_error(roots[1].function.node, Refused(what, "name the one that decides act"))
    return next(iter(usual or roots), None)


def _idle(file: File, decider: Decider) -> str:
    """Why a function decides nothing; "": it may."""
    node, function = decider.function.node, decider.function
    takes = node.args
    required = [
        each.arg for each in (*takes.posonlyargs, *takes.args, *takes.kwonlyargs) if each.arg not in function.defaults
    ]
    if len(required) <= len(decider.first):
        return "takes no observation"
    if function in file.machine.makers:
        return "makes functions or objects"
    if isinstance(node, ast.Lambda):
        return ""
    if all(each.value is None for each in file.inside(node, ast.Return)):
        return "returns nothing"
    called = [each.func for each in file.inside(node, ast.Call)]
    if any(isinstance(each, ast.Attribute) and each.attr in PLAYING for each in called):
        return "plays an environment"
    return ""


def _names(file: File, decider: Decider) -> Iterable[str]:
    """The names that a function, or the class whose method it is, mentions."""
    nodes: list[ast.AST] = [decider.function.node]
    for each in decider.first:
        kind = each if isinstance(each, Class) else each.kind
        nodes += [one.node for one in kind.members.values() if isinstance(one, Function)]
    return {inner.id for node in nodes for inner in file.inside(node, ast.Name)}
