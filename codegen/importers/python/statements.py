"""Statements of Python: what each kind of node does.

Does: assignments, ifs, matches, loops that end, returns; a function's own statements with marks between them.
Assumes: a machine.
Does not: take try, with, global, nonlocal, del or raise on a path that may be taken.
"""

# pyright: basic
# the values of a program may be anything
import ast
import copy
from collections.abc import Sequence
from typing import Any

from codegen.errors import InputError, escape_text
from codegen.importers.python.arithmetic import binary, compare_values
from codegen.importers.python.expressions import assign, defaults_of, eval_condition, may_go_unread
from codegen.importers.python.library import MODULES
from codegen.importers.python.machine import STATEMENTS, STREAM_ADVICE, End, Machine, reads, text_of
from codegen.importers.python.values import Array, Function, Refused, Scope, Unread
from codegen.importers.symbolic.feature import Test

MAKERS = ("__init__", "__post_init__")  # methods that set attributes of what they make
MAX_TURNS = 100_000


def link_statements(nodes: Sequence[ast.stmt], rest: Any) -> Any:
    """Statements before what is still to be done, as pairs."""
    for node in reversed(nodes):
        rest = (node, rest)
    return rest


def follow(m: Machine, rest: Any, scope: Scope, *, marks: bool) -> End | None:
    """Runs statements, and long ladders of them without going deeper. `marks`: whether a path may go on in between."""
    while rest is not None:
        node, after = rest
        if marks and m.paths is not None:
            m.paths.mark((rest, dict(scope.names)))
        if isinstance(node, ast.If):
            m.line = node.lineno
            m.count()
            test = m.eval(node.test, scope) if isinstance(node.test, ast.Compare) else None
            holds = eval_condition(m, node.test, scope) if test is None else m.truth(test)
            rest = link_statements(node.body if holds else node.orelse, after)
            if marks and m.paths is not None and isinstance(test, Test):  # whose other answer is the other branch
                m.paths.branch((link_statements(node.orelse if holds else node.body, after), dict(scope.names)))
            continue
        end = m.run(node, scope)
        if end is not None:
            return end
        rest = after
    return None


@reads(STATEMENTS, ast.If)
def _if(m: Machine, node: ast.If, scope: Scope) -> End | None:
    return follow(m, (node, None), scope, marks=False)


@reads(STATEMENTS, ast.Return)
def _return(m: Machine, node: ast.Return, scope: Scope) -> End:
    value = None if node.value is None else m.eval(node.value, scope)
    m.line = node.lineno
    return End("return", value)


@reads(STATEMENTS, ast.Expr, ast.Pass)
def _expression(m: Machine, node: Any, scope: Scope) -> None:
    if isinstance(node, ast.Expr):
        m.eval(node.value, scope)


@reads(STATEMENTS, ast.Assert)
def _assert(m: Machine, node: ast.Assert, scope: Scope) -> None:
    """Taken to hold: it may say how many features there are."""
    value = None if may_go_unread(node.test) else m.eval(node.test, scope)
    if value is False:
        raise Refused(f"{text_of(node)} fails", "mend it")
    if value is not True:
        m.notes[f"line {node.lineno}: {text_of(node)} is taken to hold"] = None


# --- assignments


@reads(STATEMENTS, ast.Assign)
def _run_assign(m: Machine, node: ast.Assign, scope: Scope) -> None:
    value = m.eval(node.value, scope)
    for target in node.targets:
        assign(m, target, value, scope)


@reads(STATEMENTS, ast.AnnAssign)
def _run_annotation(m: Machine, node: ast.AnnAssign, scope: Scope) -> None:
    if node.value is not None:
        assign(m, node.target, m.eval(node.value, scope), scope)


@reads(STATEMENTS, ast.AugAssign)
def _run_augmented(m: Machine, node: ast.AugAssign, scope: Scope) -> None:
    load = copy.copy(node.target)
    load.ctx = ast.Load()
    left, right = m.eval(load, scope), m.eval(node.value, scope)
    m.line = node.lineno
    if isinstance(left, list):
        raise Refused(f"{text_of(node)} changes a list that may have other names", "write a = a + b")
    assign(m, node.target, binary(m, type(node.op), left, right), scope)


# --- loops


@reads(STATEMENTS, ast.For)
def _for(m: Machine, node: ast.For, scope: Scope) -> End | None:
    for each in m.items(m.eval_stream(node.iter, scope)):
        m.count()
        assign(m, node.target, each, scope)
        end = m.block(node.body, scope)
        if end is not None and end.kind != "continue":
            return end if end.kind == "return" else None
    return m.block(node.orelse, scope)


@reads(STATEMENTS, ast.While)
def _while(m: Machine, node: ast.While, scope: Scope) -> End | None:
    for _ in range(MAX_TURNS):
        m.line = node.lineno
        try:
            more = eval_condition(m, node.test, scope)
        except InputError as error:
            what = f"a loop goes on until a feature says otherwise: {error.what}"
            raise Refused(what, "give the loop an end: for k in range(5)") from None
        if not more:
            return m.block(node.orelse, scope)
        end = m.block(node.body, scope)
        if end is not None and end.kind != "continue":
            return end if end.kind == "return" else None
    m.line = node.lineno
    raise Refused("a loop does not end", "loop over literals")


@reads(STATEMENTS, ast.Break, ast.Continue)
def _leave(m: Machine, node: ast.AST, scope: Scope) -> End:
    return End(type(node).__name__.lower())


# --- match


@reads(STATEMENTS, ast.Match)
def _match(m: Machine, node: ast.Match, scope: Scope) -> End | None:
    subject = m.eval(node.subject, scope)
    for case in node.cases:
        m.line = case.pattern.lineno
        if _matches(m, case.pattern, subject, scope) and (case.guard is None or eval_condition(m, case.guard, scope)):
            return m.block(case.body, scope)
    return None


def _matches(m: Machine, pattern: ast.pattern, value: Any, scope: Scope) -> bool:
    """Returns True if a value matches; names are set."""
    m.count()
    if isinstance(pattern, ast.MatchValue):
        return m.truth(compare_values(m, "==", value, m.eval(pattern.value, scope)))
    if isinstance(pattern, ast.MatchSingleton):
        return m.decide(value) is pattern.value
    if isinstance(pattern, ast.MatchOr):
        return any(_matches(m, each, value, scope) for each in pattern.patterns)
    if isinstance(pattern, ast.MatchAs):
        if pattern.pattern is not None and not _matches(m, pattern.pattern, value, scope):
            return False
        if pattern.name is not None:
            scope.names[pattern.name] = value
        return True
    if isinstance(pattern, ast.MatchSequence) and not any(isinstance(each, ast.MatchStar) for each in pattern.patterns):
        if isinstance(value, Array) or not isinstance(value, tuple | list):
            what = "a sequence pattern meets what is no tuple or list of the file"
            raise Refused(what, "unpack it first: a, b = x; then match (a, b), or test them")
        return len(value) == len(pattern.patterns) and all(
            _matches(m, each, item, scope) for each, item in zip(pattern.patterns, value, strict=True)
        )
    raise Refused("a pattern is not understood", "match numbers, texts, members of an Enum and tuples of them")


# --- definitions and imports


@reads(STATEMENTS, ast.FunctionDef)
def _function(m: Machine, node: ast.FunctionDef, scope: Scope) -> None:
    own = node.args.args[0].arg if node.name in MAKERS and node.args.args else ""
    for each in _within(node, m.sets):
        if getattr(each.value, "id", "") != own or not own:
            m.kept.setdefault(each.attr, set()).add(node)
    if _within(node, m.pauses):
        raise Refused("the function is a generator", STREAM_ADVICE)
    kinds = [_kind_of(m, each, scope) for each in node.decorator_list]
    local = set[str]()
    for each in _within(node, m.stores):
        local |= {getattr(each, "asname", None) or getattr(each, "id", None) or each.name}
    defaults = defaults_of(m, node.args, scope)
    kind = kinds[0] if kinds else ""
    scope.names[node.name] = Function(node.name, node, scope.outer, defaults, kind, frozenset(local))


def _within(node: ast.FunctionDef, nodes: Sequence[Any]) -> list[Any]:
    """Those of the nodes that stand within a function."""
    last = node.end_lineno or node.lineno
    return [each for each in nodes if node.lineno <= each.lineno <= last and each is not node]


def _kind_of(m: Machine, node: ast.expr, scope: Scope) -> str:
    """Returns the kind of method that a decorator makes. InputError for one that may change a function otherwise."""
    name = node.id if isinstance(node, ast.Name) else ""
    own = any(isinstance(each.names.get(name), Function) for each in scope)
    if own or name not in ("staticmethod", "classmethod", "property"):
        what = f"the decorator {escape_text(text_of(node))!r} may change the function"
        raise Refused(what, "remove it", hard=own)
    return name


@reads(STATEMENTS, ast.Import, ast.ImportFrom)
def _import(m: Machine, node: Any, scope: Scope) -> None:
    """Known modules; all other names are an error where a decision reads them."""
    for each in node.names:
        name = each.asname or each.name
        if each.name == "*":
            raise Refused(f"{text_of(node)} may give names other meanings", "import names one by one", hard=True)
        what = "a random number is drawn" if name == "random" else f"{escape_text(name)} comes from elsewhere"
        unread = Unread(what, "write the numbers and functions that decide into the file")
        if isinstance(node, ast.Import):
            scope.names[name.split(".")[0]] = MODULES.get(each.name, unread)
        else:
            m.numpy |= node.module == "numpy"
            known = MODULES.get(node.module or "")
            scope.names[name] = known.members.get(each.name, unread) if known else unread
