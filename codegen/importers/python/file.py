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
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from codegen.errors import InputError, escape_text
from codegen.importers.python.machine import Machine, text_of, walk_nodes
from codegen.importers.python.values import Class, Function, Instance, Refused, Scope, Unread
from codegen.importers.symbolic.paths import STATE_ADVICE

MAGIC = frozenset(
    ("exec", "eval", "globals", "locals", "vars", "setattr", "delattr", "compile", "__import__", "__builtins__")
)
KNOWN = ("__name__", "__init__")
PLAYING = frozenset(("step", "reset", "render"))  # of an environment: whoever calls it plays
USUAL = ("__call__", "act", "decide", "predict", "select_action", "choose_action", "get_action", "policy", "control",
         "compute_action", "step", "forward", "action")  # fmt: skip
HELD = (list, dict, Function, Class, Instance)  # what a call may change
INNER = (ast.FunctionDef, ast.ClassDef, ast.Lambda)
STORING = (ast.Name, *INNER[:2], ast.alias, ast.MatchAs)
ALONE = "say --agents {}=FILE to take this function alone"
MAIN = 'put what only demonstrates the controller under if __name__ == "__main__":'


class Decider(NamedTuple):
    """A function that decides, and what stands before the observation: the object whose method it is."""

    name: str
    function: Function
    first: tuple[Any, ...] = ()


@dataclass(frozen=True)
class File:
    """The contents of a file."""

    scope: Scope
    nodes: Mapping[type[ast.AST], Sequence[Any]]  # by their kinds
    machine: Machine

    def inside(self, node: Any, *kinds: type[ast.AST]) -> list[Any]:
        """The nodes of these kinds within a function."""
        first, last = node.lineno, node.end_lineno
        return [each for kind in kinds for each in self.nodes.get(kind, ()) if first <= each.lineno <= last]

    @property
    def simple(self) -> bool:
        """True if no function changes a list or an object, or holds another one: a path may go on from any state."""
        kinds = (ast.FunctionDef, ast.Lambda, ast.Attribute, ast.Subscript)
        inside = ((each, node) for node in self.nodes[ast.FunctionDef] for each in self.inside(node, *kinds))
        changing = (_stores(each) or getattr(each, "attr", "") == "append" for each, node in inside if each is not node)
        return not any(changing)


def _stores(node: Any) -> bool:
    """Returns True if a node gives something to a name, an attribute or an element."""
    return not isinstance(getattr(node, "ctx", None), ast.Load)


def file_of(parsed: ast.Module, m: Machine) -> File:
    """A file, evaluated but for its functions. InputError for what may give names other meanings."""
    nodes = defaultdict[type[ast.AST], list[Any]](list)
    for node in walk_nodes(parsed):
        nodes[type(node)].append(node)
    _refuse_magic(m, nodes)
    m.stores = [each for kind in STORING for each in nodes[kind] if _stores(each)]
    m.sets = [each for each in nodes[ast.Attribute] if _stores(each)]
    m.pauses = [each for kind in (ast.Yield, ast.YieldFrom, ast.Await) for each in nodes[kind]]
    scope = Scope({"__name__": "policy"})
    for node in parsed.body:
        try:
            m.run(node, scope)
        except InputError as error:
            if m.hard or m.steps > 1 << 22:
                raise
            _skip(m, node, scope, error)
    for node in nodes[ast.Global]:
        for name in node.names:
            scope.names[name] = Unread(f"{escape_text(name)!r} may change between calls", STATE_ADVICE, node.lineno)
    return File(scope, nodes, m)


def _refuse_magic(m: Machine, nodes: Mapping[type[ast.AST], Sequence[Any]]) -> None:
    """InputError for what may give names other meanings."""
    odd = [each for each in nodes[ast.Name] if each.id in MAGIC]
    odd += [each for each in nodes[ast.Attribute] if each.attr[:2] == "__" == each.attr[-2:] and each.attr not in KNOWN]
    annotations = [each.annotation for each in (*nodes[ast.arg], *nodes[ast.AnnAssign])]
    for annotation in filter(None, (*annotations, *(each.returns for each in nodes[ast.FunctionDef]))):
        odd += [each for each in ast.walk(annotation) if isinstance(each, ast.Call | ast.NamedExpr)]
    if odd:
        what = f"{text_of(odd[0])!r} may change what names stand for"
        raise m.make_error(odd[0], Refused(what, "remove it, or name types only", hard=True))


def _skip(m: Machine, node: ast.stmt, scope: Scope, error: InputError) -> None:
    """Goes on without a statement that can change nothing of the file: names that it sets are not known any more."""
    inner = walk_nodes(node, INNER)
    held = [scope.names.get(each.id) for each in inner if isinstance(each, ast.Name)]
    changes = any(isinstance(each, ast.Attribute | ast.Subscript) and _stores(each) for each in inner)
    if changes or any(isinstance(each, HELD) for each in held):  # what changes may have other names
        raise InputError(error.what, error.where, f"{error.next_step}; or {MAIN}")
    for each in inner:
        if isinstance(each, STORING) and _stores(each):
            name = each.id if isinstance(each, ast.Name) else each.name
            scope.names[name or ""] = Unread(error.what, error.next_step, node.lineno)
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
        why = _idle(file, decider) if decider else ""
        if why:
            file.machine.notes[f"{escape_text(name)} is skipped: it {why}"] = None
        elif decider and decider[1:] not in [each[1:] for each in by_name.values()]:
            by_name[name] = decider
    if chosen is not None and wanted in by_name:
        return [by_name[wanted]]
    if not by_name:
        raise _refuse_file(file)
    used = {inner for name, each in by_name.items() for inner in _names(file, each) if inner != name}
    roots = [each for name, each in by_name.items() if name not in used]
    # a class whose objects the file makes is a part of something, if anything else decides
    whole = [each for each in roots if not file.machine.made.intersection(each.first)]
    return whole or roots or list(by_name.values())


def _refuse_file(file: File) -> InputError:
    """Why no function decides."""
    if not any(file.nodes[kind] for kind in INNER):
        advice = "write def agent(x): ... and return the action"
        return InputError("no function: put the rule into one", file.machine.where, advice)
    for each in file.scope.names.values():
        if isinstance(each, Unread) and each.line:
            return InputError(each.what, f"{file.machine.where}, line {each.line}", each.advice)
    what = "the file has no function that takes an observation and returns a decision"
    advice = "; ".join(("write one function per agent: def agent(x): ...", *file.machine.notes))
    return InputError(what, file.machine.where, advice[:300])


def _choose_method(file: File, name: str, value: Class | Instance) -> Decider | None:
    """The method of a class that decides."""
    kind = value if isinstance(value, Class) else value.kind
    public = [each for each in kind.members.values() if isinstance(each, Function) and each.kind != "property"]
    public = [each for each in public if each.name == "__call__" or not each.name.startswith("_")]
    given = [Decider(name, each, () if each.kind == "staticmethod" else (value,)) for each in public]
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
    takes = (*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs)
    if len([each for each in takes if each.arg not in function.defaults]) <= len(decider.first):
        return "takes no observation"
    if isinstance(node, ast.FunctionDef) and all(each.value is None for each in file.inside(node, ast.Return)):
        return "returns nothing"
    called = [each.func for each in file.inside(node, ast.Call)]
    if any(isinstance(each, ast.Attribute) and each.attr in PLAYING for each in called):
        return "plays an environment"
    return ""


def _names(file: File, decider: Decider) -> set[str]:
    """The names that a function, or the class whose method it is, mentions."""
    nodes: list[ast.AST] = [decider.function.node]
    for each in decider.first:
        kind = each if isinstance(each, Class) else each.kind
        nodes += [one.node for one in kind.members.values() if isinstance(one, Function)]
    return {inner.id for node in nodes for inner in file.inside(node, ast.Name)}
