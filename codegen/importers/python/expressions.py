"""Expressions of Python: what each kind of node is.

Does: names, literals, arithmetic, comparisons, calls, subscripts, choices and comprehensions.
Assumes: a machine, which counts the work and asks its paths where a feature decides.
Does not: run statements.

Conditions are decided where they are needed: `fast = v > 1` is no test yet.
"""

# pyright: basic
# the values of a program may be anything
import ast
import math
from dataclasses import replace
from typing import Any

from codegen.errors import escape_text
from codegen.importers.python.arithmetic import COMPARISONS, binary, compare_values, unary
from codegen.importers.python.library import BUILTINS
from codegen.importers.python.machine import EXPRESSIONS, Machine, reads, text_of
from codegen.importers.python.sequences import count_features, items_of
from codegen.importers.python.values import Bound, Class, Condition, Function, Member, Part, Scope, Symbol, Unread
from codegen.importers.symbolic.feature import Feature, Test
from codegen.importers.symbolic.paths import STATE_ADVICE

LOGGERS = ("logging", "logger", "log", "LOG", "LOGGER", "warnings", "_logger")


@reads(EXPRESSIONS, ast.Constant)
def _constant(m: Machine, node: ast.Constant, scope: Scope) -> Any:
    if isinstance(node.value, bytes | complex):
        return m.unread(f"{text_of(node)} is no number or text", "write a number or a text")
    return node.value


@reads(EXPRESSIONS, ast.Name)
def _name(m: Machine, node: ast.Name, scope: Scope) -> Any:
    for each in scope:
        if node.id in each.names:
            return each.names[node.id]
        if node.id in each.local:
            raise m.make_error(node, f"{escape_text(node.id)!r} holds nothing on some path", "set it on every path")
    if node.id in BUILTINS:
        return BUILTINS[node.id]
    return Symbol(node.id)


@reads(EXPRESSIONS, ast.NamedExpr)
def _walrus(m: Machine, node: ast.NamedExpr, scope: Scope) -> Any:
    value = scope.names[node.target.id] = m.eval(node.value, scope)
    return value


@reads(EXPRESSIONS, ast.IfExp)
def _choice(m: Machine, node: ast.IfExp, scope: Scope) -> Any:
    return m.eval(node.body if eval_condition(m, node.test, scope) else node.orelse, scope)


@reads(EXPRESSIONS, ast.BinOp)
def _binary(m: Machine, node: ast.BinOp, scope: Scope) -> Any:
    left, right = m.eval(node.left, scope), m.eval(node.right, scope)
    m.line = node.lineno
    return _add_text(node, binary(m, type(node.op), left, right), left, right)


def _add_text(node: ast.AST, value: Any, *given: Any) -> Any:
    """What cannot be said of a node, with its text."""
    if isinstance(value, Unread) and not any(value is each for each in given) and ": " not in value.what:
        return replace(value, what=f"{value.what}: {text_of(node)}")
    return value


@reads(EXPRESSIONS, ast.UnaryOp)
def _unary(m: Machine, node: ast.UnaryOp, scope: Scope) -> Any:
    value = m.eval(node.operand, scope)
    if not isinstance(node.op, ast.Not):
        return unary(m, type(node.op), value)
    if isinstance(value, Test | Condition):
        return Condition(lambda: not m.truth(value))
    return not m.truth(value)


# --- conditions


def eval_condition(m: Machine, node: ast.expr, scope: Scope) -> bool:
    """Whether a condition holds, of which no more is evaluated than decides it."""
    if isinstance(node, ast.BoolOp):
        m.count()
        every = isinstance(node.op, ast.And)
        return (all if every else any)(eval_condition(m, each, scope) for each in node.values)
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
        m.count()
        return not eval_condition(m, node.operand, scope)
    value = m.eval(node, scope)
    m.line = node.lineno
    return m.truth(value)


@reads(EXPRESSIONS, ast.BoolOp)
def _eval_boolean(m: Machine, node: ast.BoolOp, scope: Scope) -> Any:
    """`a and b`: decided later, if nothing but truth can come of it."""
    if all(_is_condition(each, scope) for each in node.values):
        then = Scope(dict(scope.names), scope.parent, scope.local)
        return Condition(lambda: eval_condition(m, node, then))
    for each in node.values[:-1]:
        value = m.eval(each, scope)
        truth = m.truth(value)
        if truth == isinstance(node.op, ast.Or):
            return truth if isinstance(value, Test | Condition) else value
    return m.eval(node.values[-1], scope)


def _is_condition(node: ast.expr, scope: Scope) -> bool:
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
        return _is_condition(node.operand, scope)
    if isinstance(node, ast.BoolOp):
        return all(_is_condition(each, scope) for each in node.values)
    if isinstance(node, ast.Name):
        return isinstance(scope.names.get(node.id), Test | Condition | bool)
    return isinstance(node, ast.Compare) and not any(
        isinstance(each, ast.NamedExpr | ast.Call) for each in ast.walk(node)
    )


@reads(EXPRESSIONS, ast.Compare)
def _eval_compare(m: Machine, node: ast.Compare, scope: Scope) -> Any:
    sides = [m.eval(each, scope) for each in (node.left, *node.comparators)]
    m.line = node.lineno
    tests = [
        _add_text(node, _pair(m, operator, *pair), *pair)
        for operator, *pair in zip(node.ops, sides, sides[1:], strict=False)
    ]
    if len(tests) == 1:
        return tests[0]
    unread = next((each for each in tests if isinstance(each, Unread)), None)
    return unread or Condition(lambda: all(m.truth(each) for each in tests))


def _pair(m: Machine, operator: ast.cmpop, left: Any, right: Any) -> Any:
    sign = COMPARISONS.get(type(operator))
    if sign is not None:
        return compare_values(m, sign, left, right)
    if isinstance(operator, ast.In | ast.NotIn):
        if isinstance(right, Part) and isinstance(left, str):  # `"speed" in obs`
            return isinstance(operator, ast.In)
        items = right if isinstance(right, str | set | frozenset) else items_of(m, right)
        if isinstance(items, Unread):
            return items
        if isinstance(items, str):
            return (m.require_value(left) in items) == isinstance(operator, ast.In)
        tests = [compare_values(m, "==", left, each) for each in items]
        return Condition(lambda: any(m.truth(each) for each in tests) == isinstance(operator, ast.In))
    same = _same(m, left, right)
    return same if isinstance(operator, ast.Is) or not isinstance(same, bool) else not same


def _same(m: Machine, left: Any, right: Any) -> Any:
    """What `is` says."""
    for one, other in ((left, right), (right, left)):
        if one is None:
            return other is None if not isinstance(other, Unread) else other
        if isinstance(one, bool):
            if isinstance(other, Test | Condition):
                return Condition(lambda one=one, other=other: m.truth(other) == one)
            return one is other
    if isinstance(left, Class | Function | Member | Unread | Symbol):
        return left == right if not isinstance(left, Unread) else left
    return m.unread("'is' compares what is no constant", "write ==")


# --- calls, functions, comprehensions


@reads(EXPRESSIONS, ast.Call)
def _call(m: Machine, node: ast.Call, scope: Scope) -> Any:
    function = m.eval(node.func, scope)
    if isinstance(node.func, ast.Name) and node.func.id == "super" and isinstance(function, Symbol):
        return _super(m, node, scope)
    given: list[Any] = []
    for each in node.args:
        if isinstance(each, ast.Starred):
            value = m.eval(each.value, scope)
            if isinstance(value, Part) and each is node.args[-1] and not node.keywords:
                _count_features(m, node, function, value, len(given))
            more = items_of(m, value)
            given += [m.require_value(more)] if isinstance(more, Unread) else list(more)
        else:
            given.append(m.eval(each, scope))
    named = {}
    for each in node.keywords:
        value = m.eval(each.value, scope)
        named |= {each.arg: value} if each.arg else m.require_value(value) if isinstance(value, dict) else {}
    m.line = node.lineno
    if _is_told(function):
        m.notes[f"line {node.lineno}: {text_of(node)} is skipped"] = None
        return None if function.name == "print" else Symbol(LOGGERS[0])
    return m.call(function, given, named, node)


def _count_features(m: Machine, node: ast.Call, function: Any, part: Part, given: int) -> None:
    """What the names of a call's parameters say of an observation whose numbers they all are: `Reading(*x)`."""
    names = list(function.fields) if isinstance(function, Class) else []
    if isinstance(function, Function) and not function.kind and isinstance(takes := function.node.args, ast.arguments):
        names = [] if takes.vararg or takes.defaults else [each.arg for each in (*takes.posonlyargs, *takes.args)]
    if names[given:] and not part.offset and not m.inputs.length(part.path):
        count_features(m, node, part, names[given:])


def _is_told(function: Any) -> bool:
    """Whether a function only tells somebody something: print, or a logger's."""
    name = function.name if isinstance(function, Bound | Symbol) else ""
    return name == "print" or name.split(".")[0] in LOGGERS


def _super(m: Machine, node: ast.Call, scope: Scope) -> Any:
    """The bases of the object whose method this is."""
    first = next(iter(scope.names.values()), None)
    return _Above(m, first, getattr(getattr(first, "kind", None), "bases", ()))


class _Above(Class):
    """What `super()` is: methods of the bases, for the object; `__init__` also where no base of the file has one."""

    def __init__(self, m: Machine, value: Any, bases: tuple[Class, ...]) -> None:
        super().__init__("super", bases, {})
        self.m, self.value = m, value

    def find(self, name: str) -> Any:
        found = super().find(name)
        if isinstance(found, Function):
            return Bound(name, lambda m, node, given, named: m.apply(found, [self.value, *given], named, node))
        return Bound(name, lambda m, node, given, named: None) if found is None and name == "__init__" else found


@reads(EXPRESSIONS, ast.Lambda)
def _lambda(m: Machine, node: ast.Lambda, scope: Scope) -> Any:
    return Function("a lambda", node, scope, defaults_of(m, node.args, scope))


def defaults_of(m: Machine, takes: ast.arguments, scope: Scope) -> dict[str, Any]:
    """What parameters stand for where nothing is given."""
    places = [*takes.posonlyargs, *takes.args]
    defaults = {
        each.arg: m.eval(value, scope)
        for each, value in zip(places[len(places) - len(takes.defaults) :], takes.defaults, strict=True)
    }
    pairs = zip(takes.kwonlyargs, takes.kw_defaults, strict=True)
    return defaults | {each.arg: m.eval(value, scope) for each, value in pairs if value is not None}


@reads(EXPRESSIONS, ast.JoinedStr)
def _text(m: Machine, node: ast.JoinedStr, scope: Scope) -> Any:
    parts: list[str] = []
    for each in node.values:
        value = m.plain(m.eval(each.value if isinstance(each, ast.FormattedValue) else each, scope))
        value = m.whole(value) if isinstance(value, Feature) and m.counts(value) else value
        if isinstance(each, ast.FormattedValue) and (each.format_spec or each.conversion != -1):
            return m.unread("a number is formatted", "write the text itself")
        if not isinstance(value, str | int) or (isinstance(value, float) and not math.isfinite(value)):
            return m.unread("a text is made of what is no constant", "write the text itself")
        parts.append(str(value))
    return m.keep_value("".join(parts))


@reads(EXPRESSIONS, ast.Await, ast.Yield, ast.YieldFrom)
def _refuse_pause(m: Machine, node: ast.AST, scope: Scope) -> Any:
    raise m.make_error(node, f"{text_of(node)} waits for something", STATE_ADVICE)
