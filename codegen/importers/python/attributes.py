"""Attributes of values: of observations, modules, objects, members, texts and lists.

Does: what `value.name` is; the methods of lists, dictionaries and texts that are known.
Assumes: a value of values.py, or a constant.
Does not: set attributes (statements.py).
"""

# pyright: basic
# the values of a program may be anything
import ast
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from codegen.errors import escape_text
from codegen.importers.python.machine import EXPRESSIONS, Machine, reads, step_of
from codegen.importers.python.values import (
    Array,
    Bound,
    Class,
    Function,
    Instance,
    Length,
    Member,
    Module,
    Part,
    Scope,
    Symbol,
    Unread,
)
from codegen.importers.symbolic.feature import Feature, Step
from codegen.importers.symbolic.paths import STATE_ADVICE

SAME = ("flatten", "ravel", "copy", "squeeze", "item", "numpy", "cpu", "detach", "reshape", "view", "T", "values")
METHODS: Mapping[type, frozenset[str]] = {
    list: frozenset(("index", "count", "copy", "append", "extend", "insert", "pop", "remove", "reverse", "clear")),
    tuple: frozenset(("index", "count")),
    dict: frozenset(("get", "keys", "values", "items", "copy", "update", "pop", "setdefault")),
    set: frozenset(("add", "discard", "union", "intersection", "copy")),
    str: frozenset(
        """upper lower strip title capitalize startswith endswith split join replace isdigit index count find
        lstrip rstrip""".split()  # noqa: SIM905
    ),
}
MAX_TEXT = 1 << 10
CONSTANT = (int, float, str, bool, type(None), Member, tuple)
CHANGING = frozenset(("append", "extend", "insert", "pop", "remove", "reverse", "clear", "update", "setdefault", "add",
                      "discard", "sort"))  # fmt: skip


def attribute_of(m: Machine, value: Any, name: str, node: ast.AST) -> Any:
    """What `value.name` is."""
    if isinstance(value, Unread):
        return value
    if isinstance(value, Symbol):
        return Symbol(f"{value.name}.{name}")
    if isinstance(value, Module):
        member = value.members.get(name)
        if member is None and value.name in ("enum", "dataclasses", "typing", "functools"):
            return Symbol(name)
        advice = "write what it computes with comparisons and numbers"
        return m.unread(f"{value.name}.{name} is not known", advice) if member is None else member
    if isinstance(value, Part):
        return _of_part(m, value, name)
    if isinstance(value, Instance | Class):
        return _of_object(m, value, name, node)
    if isinstance(value, Member):
        return _of_member(m, value, name, node)
    if isinstance(value, int | float | Feature) and name in ("real", "item"):
        return value if name == "real" else Bound(name, lambda m, node, given, named: value)
    if isinstance(value, Feature) and name == "copy":
        return Bound(name, lambda m, node, given, named: value)
    if isinstance(value, Feature):
        return m.unread(f"'.{escape_text(name)}' of a feature is not understood", "compare the feature with a number")
    kind = next((kind for kind in METHODS if isinstance(value, kind)), None)
    if kind is not None and name in METHODS[kind]:
        return _method(value, name)
    if isinstance(value, Array) and name in ("tolist", *SAME):
        return Bound(name, lambda m, node, given, named: m.keep_value([*value]))
    if isinstance(value, Array) and name in ("any", "all"):
        join = any if name == "any" else all
        return Bound(name, lambda m, node, given, named: join(m.truth(each) for each in value))
    if isinstance(value, Array) and name in ("size", "shape"):
        return len(value) if name == "size" else (len(value),)
    unknown = f"'.{escape_text(name)}' is not understood"
    what = "a number has no attributes" if isinstance(value, int | float) else unknown
    return m.unread(what, "write the number or the text itself")


def _of_part(m: Machine, part: Part, name: str) -> Any:
    """An attribute of the observation: a method of arrays or dictionaries, or a field."""

    def convert_part(m: Machine, node: ast.AST, given: list[Any], named: dict[str, Any]) -> Any:
        kind = conversion(m, [*given, *named.values()][0] if given or named else "float64")
        return kind if isinstance(kind, Unread) else replace(part, steps=part.steps + kind, array=True)

    def get_key(m: Machine, node: ast.AST, given: list[Any], named: dict[str, Any]) -> Any:
        if given and isinstance(given[0], str):
            return m.inputs.enter(part, given[0], m.line)
        return m.unread("a key of the observation is not understood", 'write x["speed"]')

    if name in SAME:
        same = replace(part, array=part.array or name not in ("copy", "values"))
        return same if name == "T" else Bound(name, lambda m, node, given, named: same)
    if name == "tolist":
        step = Step("float", float)
        return Bound(name, lambda m, node, given, named: replace(part, steps=(*part.steps, step), array=False))
    if name in ("astype", "to"):
        return Bound(name, convert_part)
    if name == "get":
        return Bound(name, get_key)
    if name in ("shape", "size"):
        return (Length(part),) if name == "shape" else Length(part)
    if name in ("ndim", "dtype"):
        return 1 if name == "ndim" else m.unread("the type of the observation is asked", "say it by --arrays")
    return m.inputs.enter(part, name, m.line)


def conversion(m: Machine, kind: Any) -> tuple[Step, ...] | Unread:
    """The steps of a conversion to a type of NumPy, given as the type, or by its name."""
    name = kind if isinstance(kind, str) else getattr(kind, "name", "")
    numbers = {"float": "float64", "float64": "float64", "double": "float64", "float32": "float32", "single": "float32"}
    if name.rpartition(".")[2] in numbers:
        return step_of(numbers[name.rpartition(".")[2]])
    return m.unread("a conversion of the observation is not understood", "convert to float32 or float64")


def _of_object(m: Machine, value: Instance | Class, name: str, node: ast.AST) -> Any:
    kind = value if isinstance(value, Class) else value.kind
    if (id(value), name) in m.written:
        return m.written[id(value), name]
    if m.paths is not None and name in kind.kept and not isinstance(kind.find(name), Function):
        what = f"'{escape_text(name)}' is remembered between calls: a method sets it"
        return m.unread(what, STATE_ADVICE)
    if isinstance(value, Instance) and name in value.attributes:
        return value.attributes[name]
    member = kind.find(name)
    if name in ("__class__", "__name__"):
        return kind if name == "__class__" else kind.name
    if member is None:
        raise m.make_error(node, f"'{escape_text(name)}' is not set on some path", "set it in __init__")
    if not isinstance(member, Function):
        return member
    first = {"class": [kind], "static": []}.get(member.kind, [value] if isinstance(value, Instance) else [])
    return _bind_method(m, member, first, node)


def _bind_method(m: Machine, method: Function, first: list[Any], node: ast.AST) -> Any:
    """A method of what it is `first` given, or what a property is."""
    if method.kind == "property" and first:
        return m.apply(method, first, {}, node)
    return Bound(method.name, lambda m, node, given, named: m.apply(method, [*first, *given], named, node))


def _of_member(m: Machine, value: Member, name: str, node: ast.AST) -> Any:
    if name in ("value", "_value_", "name"):
        return value.name if name == "name" else value.value
    member = value.kind.find(name)
    if isinstance(member, Function):
        return _bind_method(m, member, [value], node)
    return m.unread(f"'.{escape_text(name)}' is not understood", "use .value or .name")


def _method(value: Any, name: str) -> Bound:
    """A method of a list, a dictionary or a text."""

    def handle_call(m: Machine, node: ast.AST, given: list[Any], named: dict[str, Any]) -> Any:
        if name in CHANGING:
            m.ensure_fresh(value, node)
        if name == "extend" or name == "update":
            given = [list(given[0]) if not isinstance(given[0], dict) else given[0]]
            m.count(len(given[0]))
        elif (isinstance(value, dict) and name in ("get", "pop")) or name in ("index", "count", "remove"):
            given = [m.whole(given[0]), *given[1:]]
            if not isinstance(value, dict | str) and not all(isinstance(each, CONSTANT) for each in value):
                return m.unread(f"'.{name}' looks for features or objects", "compare them one by one")
        elif name not in ("append", "insert", "setdefault", "add"):
            given = [m.require_value(each) for each in given]
        if any(isinstance(each, str) and len(each) > MAX_TEXT for each in (value, *given)):
            raise m.make_error(node, "a text is too long", "make it shorter")
        try:
            function: Callable[..., Any] = getattr(value, name)
            returned = function(*given, **named)
        except (ValueError, LookupError, TypeError, AttributeError):
            raise m.make_error(node, f"'.{name}' fails with what it is given here", "look it up before") from None
        if isinstance(value, dict) and name in ("keys", "values", "items"):
            return list(returned)
        if name in CHANGING:
            m.weigh(value)
        return m.keep_value(returned) if isinstance(returned, list | dict | set | str | tuple) else returned

    return Bound(name, handle_call)


@reads(EXPRESSIONS, ast.Attribute)
def _attribute(m: Machine, node: ast.Attribute, scope: Scope) -> Any:
    return attribute_of(m, m.eval(node.value, scope), node.attr, node)
