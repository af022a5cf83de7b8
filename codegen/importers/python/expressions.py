"""Expressions of Python: what each kind of node is, and what is assigned to targets.

Does: names, literals, operators, conditions, choices, calls, lookups, comprehensions.
Assumes: a machine, which counts the work and asks its paths where a feature decides.
Does not: run statements, or know attributes and functions (objects.py, library.py).

Conditions are decided where they are needed: `fast = v > 1` is no test yet.
"""

# pyright: basic
# the values of a program may be anything
import ast
import enum
from typing import Any

from codegen.errors import InputError, escape_text
from codegen.importers.python.arithmetic import COMPARISONS, CONDITIONS, binary, compare_values, is_constant, unary
from codegen.importers.python.library import BUILTINS
from codegen.importers.python.machine import EXPRESSIONS, STATED, UNCOUNTED, Machine, reads, text_of
from codegen.importers.python.values import (
    Array,
    Bound,
    Condition,
    Function,
    Instance,
    Part,
    Refused,
    Scope,
    Stream,
    Unread,
    words_of,
)

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
                raise InputError(value.what, f"{m.where}, line {value.line or node.lineno}", value.advice)
            return value
        if node.id in each.local:
            raise Refused(f"{escape_text(node.id)!r} holds nothing on some path", "set it on every path")
    if node.id not in BUILTINS:
        raise Refused(f"the name {escape_text(node.id)!r} is not defined in the file, or not read", STATED)
    return BUILTINS[node.id]


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
    return Condition(True, (value,), False) if isinstance(value, CONDITIONS) else not m.truth(value)


# --- conditions


def eval_condition(m: Machine, node: ast.expr, scope: Scope) -> bool:
    """Returns True if a condition holds; no more of it is evaluated than decides it."""
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
    every = isinstance(node.op, ast.And)
    if all(map(_cannot_fail, node.values)):
        parts = tuple(m.eval(each, scope) for each in node.values)
        if all(isinstance(each, (*CONDITIONS, bool)) for each in parts):
            return Condition(every, parts)
    for each in node.values[:-1]:
        value = m.eval(each, scope)
        if m.truth(value) != every:
            return value
    return m.eval(node.values[-1], scope)


def _cannot_fail(node: ast.AST) -> bool:
    """Returns True if looking at an expression cannot fail, whatever precedes it: its subscripts are literals."""
    written = isinstance(node, ast.Subscript) and isinstance(node.slice, ast.Constant | ast.UnaryOp)
    return (written or isinstance(node, SAFE)) and all(map(_cannot_fail, ast.iter_child_nodes(node)))


@reads(EXPRESSIONS, ast.Compare)
def _eval_compare(m: Machine, node: ast.Compare, scope: Scope) -> Any:
    _count_features(m, node, scope)
    sides = [m.eval(node.left, scope), *[m.eval(each, scope) for each in node.comparators]]
    m.line = node.lineno
    tests = tuple([_pair(m, operator, sides[k], sides[k + 1]) for k, operator in enumerate(node.ops)])
    return tests[0] if len(tests) == 1 else Condition(True, tests)


def _count_features(m: Machine, node: ast.Compare, scope: Scope) -> None:
    """Takes what `len(x) == 4` and `len(x) != 4` compare the length of the observation with for its length."""
    call, number = node.left, getattr(node.comparators[0], "value", None)
    if not isinstance(call, ast.Call) or not isinstance(node.ops[0], ast.Eq | ast.NotEq) or not isinstance(number, int):
        return
    of = call.args
    if len(of) == 1 and isinstance(of[0], ast.Name) and m.eval(call.func, scope) is BUILTINS["len"]:
        of_part = isinstance(m.eval(of[0], scope), Part)
        if of_part and not m.inputs.width:
            m.inputs.width = number
            m.notes[f"line {node.lineno}: the observation is taken to have {number} numbers"] = None


def _pair(m: Machine, operator: ast.cmpop, left: Any, right: Any) -> Any:
    sign = COMPARISONS.get(type(operator))
    if sign is not None:
        return compare_values(m, sign, left, right)
    if isinstance(operator, ast.Is | ast.IsNot):
        if left is not None and right is not None and not all(isinstance(each, enum.Enum) for each in (left, right)):
            raise Refused("'is' compares what is no constant", "write ==")
        return (left is right) == isinstance(operator, ast.Is)
    wanted = isinstance(operator, ast.In)
    if isinstance(right, frozenset):
        right = sorted(right, key=repr)  # what is equal to one of them does not depend on their order
    left, items = m.plain(left), m.items(right)
    if is_constant(left) and is_constant(right):
        return (left in right) == wanted
    return Condition(False, tuple(compare_values(m, "==", left, each) for each in items), wanted)


# --- calls and functions


@reads(EXPRESSIONS, ast.Call)
def _call(m: Machine, node: ast.Call, scope: Scope) -> Any:
    function = m.eval(node.func, scope)
    if isinstance(function, Bound) and (function.name == "print" or function.name.startswith("logging.")):
        m.notes[f"line {node.lineno}: {text_of(node)} is skipped"] = None
        if may_go_unread(node):
            return function.call(m, node, [], {})
    for each in (*node.args, *node.keywords):
        if isinstance(each, ast.Starred) or (isinstance(each, ast.keyword) and each.arg is None):
            raise Refused(f"{text_of(node)} is not understood", "write each argument by itself")
    given = [m.eval_stream(each, scope) for each in node.args]
    named = {each.arg or "": m.eval(each.value, scope) for each in node.keywords}
    m.line = node.lineno
    return m.call(function, given, named, node)


def may_go_unread(node: ast.AST) -> bool:
    """Returns True if looking at the parts of a node changes nothing, since it calls and assigns nothing."""
    below = list(ast.walk(node))
    return not any(isinstance(each, ast.Call | ast.NamedExpr) and each is not node for each in below)


@reads(EXPRESSIONS, ast.Lambda)
def _lambda(m: Machine, node: ast.Lambda, scope: Scope) -> Any:
    return Function("a lambda", node, scope.outer, defaults_of(m, node.args, scope))


def defaults_of(m: Machine, takes: ast.arguments, scope: Scope) -> dict[str, Any]:
    """Returns the values of parameters for which nothing is given."""
    places = [*takes.posonlyargs, *takes.args]
    pairs = zip(places[len(places) - len(takes.defaults) :], takes.defaults, strict=True)
    named = zip(takes.kwonlyargs, takes.kw_defaults, strict=True)
    return {each.arg: m.eval(value, scope) for each, value in (*pairs, *named) if value is not None}


# --- lists, dictionaries and observations


@reads(EXPRESSIONS, ast.List, ast.Tuple, ast.Set)
def _list(m: Machine, node: Any, scope: Scope) -> Any:
    items = m.keep_value([m.eval(each, scope) for each in node.elts])
    if isinstance(node, ast.Set):
        return frozenset(key_of(m, each) for each in items)
    return items if isinstance(node, ast.List) else tuple(items)


@reads(EXPRESSIONS, ast.Dict)
def _dict(m: Machine, node: ast.Dict, scope: Scope) -> Any:
    if None in node.keys:
        raise Refused(f"{text_of(node)} is not understood", "write each entry by itself")
    pairs = zip(node.keys, node.values, strict=True)
    return m.keep_value({key_of(m, m.eval(key, scope)): m.eval(value, scope) for key, value in pairs if key})


def key_of(m: Machine, value: Any) -> Any:
    """A key of a dictionary: a constant; of a condition, what it is on this path."""
    m.count()
    if isinstance(value, tuple):
        return tuple(key_of(m, each) for each in value)
    key = m.truth(value) if isinstance(value, CONDITIONS) else m.whole(value)
    if isinstance(key, list) or not is_constant(key):
        raise Refused(f"{words_of(value)} is a key", "use numbers, texts or members of an Enum")
    return key


@reads(EXPRESSIONS, ast.Subscript)
def _subscript(m: Machine, node: ast.Subscript, scope: Scope) -> Any:
    value = m.eval(node.value, scope)
    if isinstance(node.slice, ast.Slice):
        ends = (node.slice.lower, node.slice.upper, node.slice.step)
        key: Any = slice(*[None if each is None else m.whole(m.eval(each, scope)) for each in ends])
    else:
        key = m.eval(node.slice, scope)
    m.line = node.lineno
    if isinstance(value, Part):
        return _part_of(m, value, key, node)
    if isinstance(value, Bound):  # an alias of a type, such as dict[str, int]
        raise Refused(f"{text_of(node)} is a type", "write it as an annotation only")
    if isinstance(value, enum.EnumType):
        return value[m.whole(key)]
    if not isinstance(value, list | tuple | dict | str | range) or (
        isinstance(key, slice) and isinstance(value, Array)
    ):
        raise Refused(f"something is looked up in {words_of(value)}", "compute with each x[0] by itself")
    if isinstance(key, slice):
        part: Any = value[key]
        return part if isinstance(part, range) else m.keep_value(part)
    return value[key_of(m, key) if isinstance(value, dict) else m.whole(key)]


def _part_of(m: Machine, part: Part, key: Any, node: ast.AST) -> Any:
    """A number of the observation, or a part of it."""
    if isinstance(key, slice):
        n = m.inputs.width
        if not n and (key.stop is None or min(key.start or 0, key.stop, key.step or 1) < 0):
            raise Refused(*UNCOUNTED)
        parts = [m.inputs.enter(part, place) for place in range(*key.indices(n or key.stop))]
        return m.keep_value(Array(parts)) if part.array else tuple(parts)
    key = m.whole(key)
    if isinstance(key, bool) or not isinstance(key, int | str):
        raise Refused(f"{text_of(node)} is not understood", "write x[0], or x['speed']")
    return m.inputs.enter(part, key)


@reads(EXPRESSIONS, ast.ListComp, ast.GeneratorExp)
def _comprehension(m: Machine, node: Any, scope: Scope) -> Any:
    if len(node.generators) > 1 or any(isinstance(each, ast.NamedExpr) for each in ast.walk(node)):
        raise Refused(f"{text_of(node)} has several loops, or assigns a name on its way", "write a loop")
    (turn,), inner, made = node.generators, Scope({}, scope.outer), []
    for each in m.items(m.eval_stream(turn.iter, scope)):
        m.count()
        assign(m, turn.target, each, inner)
        if all(eval_condition(m, test, inner) for test in turn.ifs):
            made.append(m.eval(node.elt, inner))
    return m.keep_value(made) if isinstance(node, ast.ListComp) else Stream(made)


# --- assignments


def assign(m: Machine, target: ast.expr, value: Any, scope: Scope) -> None:
    """Gives a value to a name, an attribute, an element, or names for its parts."""
    if isinstance(target, ast.Name):
        scope.names[target.id] = value
    elif isinstance(target, ast.Tuple | ast.List):
        _unpack_value(m, target, value, scope)
    elif isinstance(target, ast.Attribute):
        owner = m.eval(target.value, scope)
        if not isinstance(owner, Instance) or isinstance(owner.kind.members.get(target.attr), Function):
            raise Refused(f"{text_of(target)} is no plain attribute of an object", "set attributes of self in __init__")
        m.ensure_fresh(owner, target).attributes[target.attr] = value
    elif isinstance(target, ast.Subscript) and not isinstance(target.slice, ast.Slice):
        owner, key = m.eval(target.value, scope), m.eval(target.slice, scope)
        if isinstance(owner, Array) or not isinstance(owner, list | dict):
            raise Refused(f"{text_of(target)} is set", "give it another name instead")
        m.ensure_fresh(owner, target)[key_of(m, key) if isinstance(owner, dict) else m.whole(key)] = value
    else:
        raise Refused(f"{text_of(target)} is set", "give it a name")


def _unpack_value(m: Machine, target: ast.Tuple | ast.List, value: Any, scope: Scope) -> None:
    names = target.elts
    if isinstance(value, Part):
        m.inputs.count_names([each.id if isinstance(each, ast.Name) else "" for each in names])
    items = m.items(value)
    if len(items) != len(names):
        raise Refused(f"{len(items)} values are given to {len(names)} names", "give each a name")
    for each, item in zip(names, list(items), strict=True):
        assign(m, each, item, scope)
