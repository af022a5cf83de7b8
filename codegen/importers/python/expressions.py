"""Expressions of Python: what each kind of node is.

Does: names, literals, operators, conditions, choices, calls and f-strings.
Assumes: a machine, which counts the work and asks its paths where a feature decides.
Does not: run statements, or know containers, attributes and functions (containers.py, objects.py, library.py).

Conditions are decided where they are needed: `fast = v > 1` is no test yet.
"""

# pyright: basic
# the values of a program may be anything
import ast
from typing import Any

from codegen.errors import InputError, escape_text
from codegen.importers.python.arithmetic import COMPARISONS, CONDITIONS, binary, compare_values, is_constant, unary
from codegen.importers.python.library import BUILTINS
from codegen.importers.python.machine import EXPRESSIONS, STREAM_ADVICE, Machine, reads, text_of
from codegen.importers.python.values import (
    Bound,
    Class,
    Condition,
    Function,
    Member,
    Module,
    Part,
    Refused,
    Scope,
    Symbol,
    Unread,
    words_of,
)
from codegen.importers.symbolic.feature import Feature

LOGGERS = ("logging", "logger", "log", "LOG", "LOGGER", "warnings", "_logger")
SAFE = (ast.Compare, ast.BoolOp, ast.UnaryOp, ast.Name, ast.Constant, ast.Attribute,
        ast.cmpop, ast.boolop, ast.unaryop, ast.expr_context)  # fmt: skip


@reads(EXPRESSIONS, ast.Constant)
def _constant(m: Machine, node: ast.Constant, scope: Scope) -> Any:
    return node.value


@reads(EXPRESSIONS, ast.Name)
def _name(m: Machine, node: ast.Name, scope: Scope) -> Any:
    for each in scope:
        if node.id in each.names:
            value = each.names[node.id]
            if type(value) is Unread:
                raise InputError(value.what, f"{m.where}, line {value.line}", value.advice)
            return value
        if node.id in each.local:
            raise Refused(f"{escape_text(node.id)!r} holds nothing on some path", "set it on every path")
    return BUILTINS[node.id] if node.id in BUILTINS else Symbol(node.id)


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
    return binary(m, type(node.op), left, right)


@reads(EXPRESSIONS, ast.UnaryOp)
def _unary(m: Machine, node: ast.UnaryOp, scope: Scope) -> Any:
    value = m.eval(node.operand, scope)
    if not isinstance(node.op, ast.Not):
        return unary(m, type(node.op), value)
    if isinstance(value, CONDITIONS):
        return Condition(True, (value,), False, plain=True)
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
    """`a and b`: decided later, if nothing but truth can come of it and looking at `b` cannot fail."""
    every, later = isinstance(node.op, ast.And), list[Any]()
    safe = all(_cannot_fail(each) for each in node.values[1:])
    for place, each in enumerate(node.values):
        value = m.eval(each, scope)
        if safe and isinstance(value, (*CONDITIONS, bool)):
            later.append(value)
            if value is not every and isinstance(value, bool):
                break
            continue
        for one in later:
            if m.truth(one) != every:
                return one
        later, safe = [], False
        if place == len(node.values) - 1 or m.truth(value) != every:
            return value
    return Condition(every, tuple(later)) if any(isinstance(each, CONDITIONS) for each in later) else later[-1]


def _cannot_fail(node: ast.AST) -> bool:
    """Whether looking at an expression is no matter of what stands before it: it looks up places that are written."""
    written = isinstance(node, ast.Subscript) and isinstance(node.slice, ast.Constant | ast.UnaryOp)
    return (written or isinstance(node, SAFE)) and all(map(_cannot_fail, ast.iter_child_nodes(node)))


@reads(EXPRESSIONS, ast.Compare)
def _eval_compare(m: Machine, node: ast.Compare, scope: Scope) -> Any:
    sides = [m.eval(node.left, scope), *[m.eval(each, scope) for each in node.comparators]]
    m.line = node.lineno
    tests = tuple([_pair(m, operator, sides[k], sides[k + 1]) for k, operator in enumerate(node.ops)])
    return tests[0] if len(tests) == 1 else Condition(True, tests)


def _pair(m: Machine, operator: ast.cmpop, left: Any, right: Any) -> Any:
    sign = COMPARISONS.get(type(operator))
    if sign is not None:
        return compare_values(m, sign, left, right)
    if isinstance(operator, ast.Is | ast.IsNot):
        return _same(m, left, right, wanted=isinstance(operator, ast.Is))
    wanted = isinstance(operator, ast.In)
    if isinstance(right, Part) and isinstance(left, str):  # `"speed" in obs`
        return wanted
    if isinstance(right, set) and all(map(is_constant, right)):
        right = sorted(right, key=repr)  # what is equal to one of them does not depend on their order
    left, items = m.plain(left), m.items(right)
    if is_constant(left) and is_constant(right):
        return (left in (right if isinstance(right, str) else items)) == wanted
    tests = tuple(compare_values(m, "==", left, each) for each in items)
    return Condition(False, tests, wanted, plain=True)


def _same(m: Machine, left: Any, right: Any, *, wanted: bool) -> Any:
    """What `is` says: of None, of True and False, and of members and classes."""
    for one, other in ((left, right), (right, left)):
        if one is None:
            if isinstance(other, Symbol):
                raise Refused(f"{words_of(other)} is compared", "write the number or the text itself")
            return (other is None) == wanted
        if isinstance(one, bool) and isinstance(other, CONDITIONS):
            m.ensure_plain(other)
            return Condition(True, (other,), one == wanted, plain=True)
        if isinstance(one, bool) and isinstance(other, bool):
            return (one is other) == wanted
    if isinstance(left, Member | Class | Function) and isinstance(right, Member | Class | Function):
        return (left is right) == wanted
    raise Refused("'is' compares what is no constant", "write ==")


# --- calls and functions


@reads(EXPRESSIONS, ast.Call)
def _call(m: Machine, node: ast.Call, scope: Scope) -> Any:
    function = m.eval(node.func, scope)
    if isinstance(function, Bound | Symbol) and function.name.split(".")[0] in ("print", *LOGGERS):
        for each in [*node.args, *(one.value for one in node.keywords)]:
            if not is_pure(each, scope):
                m.eval(each, scope)
        m.notes[f"line {node.lineno}: {text_of(node)} is skipped"] = None
        return None if function.name == "print" else Symbol(LOGGERS[0])
    given: list[Any] = []
    if isinstance(function, Symbol):
        return m.call(function, given, {}, node)  # an error
    for each in node.args:
        if isinstance(each, ast.Starred):
            value = m.eval(each.value, scope)
            if isinstance(value, Part) and each is node.args[-1] and not node.keywords:
                _count_features(m, node, function, value, len(given))
            given += m.items(value)
        else:
            given.append(m.eval_stream(each, scope))
    named = dict[str, Any]()
    for each in node.keywords:
        value = m.eval(each.value, scope)
        if each.arg is None and not (isinstance(value, dict) and all(isinstance(key, str) for key in value)):
            raise Refused(f"{text_of(node)} is not understood", "write the arguments by name")
        named |= {each.arg: value} if each.arg else value
    m.line = node.lineno
    return m.call(function, given, named, node)


def is_pure(node: ast.AST, scope: Scope) -> bool:
    """Whether an expression that nothing is made of may go unread: it assigns nothing and calls only what is known."""
    for each in ast.walk(node):
        if isinstance(each, ast.NamedExpr):
            return False
        if isinstance(each, ast.Call):
            owner = each.func.value if isinstance(each.func, ast.Attribute) else each.func
            name = owner.id if isinstance(owner, ast.Name) else ""
            held = next((one.names[name] for one in scope if name in one.names), BUILTINS.get(name))
            texts = isinstance(owner, ast.Constant) and isinstance(owner.value, str)
            if not (texts or isinstance(held, Bound | Module)):
                return False
    return True


def _count_features(m: Machine, node: ast.Call, function: Any, part: Part, given: int) -> None:
    """What the names of a call's parameters say of an observation whose numbers they all are: `Reading(*x)`."""
    names = list(function.fields) if isinstance(function, Class) else []
    if isinstance(function, Function) and not function.kind and not function.node.args.defaults:
        names = [each.arg for each in (*function.node.args.posonlyargs, *function.node.args.args)]
    if names[given:] and not m.inputs.length(part.path):
        m.inputs.count_names(part.path, names[given:])


@reads(EXPRESSIONS, ast.Lambda)
def _lambda(m: Machine, node: ast.Lambda, scope: Scope) -> Any:
    return Function("a lambda", node, scope.outer, defaults_of(m, node.args, scope))


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
        value = m.eval(each.value if isinstance(each, ast.FormattedValue) else each, scope)
        value = m.whole(value) if isinstance(value, Feature) and m.counts(value) else value
        if isinstance(each, ast.FormattedValue) and (each.format_spec or each.conversion != -1):
            raise Refused("a number is formatted", "write the text itself")
        if not isinstance(value, str | int):
            raise Refused("a text is made of what is no constant", "write the text itself")
        parts.append(str(value))
    return m.keep_value("".join(parts))


@reads(EXPRESSIONS, ast.Await, ast.Yield, ast.YieldFrom)
def _refuse_pause(m: Machine, node: ast.AST, scope: Scope) -> Any:
    raise Refused(f"{text_of(node)} makes a generator", STREAM_ADVICE)
