"""Attributes of values: of observations, modules, objects, members, texts and lists.

Does: what `value.name` is; the methods of lists, dictionaries and texts that are known.
Assumes: a value of values.py, or a constant.
Does not: set attributes (containers.py).
"""

# pyright: basic
# the values of a program may be anything
import ast
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from codegen.errors import escape_text
from codegen.importers.python.arithmetic import is_constant
from codegen.importers.python.containers import key_of
from codegen.importers.python.machine import EXPRESSIONS, Machine, reads, words_of
from codegen.importers.python.numbers import conversion
from codegen.importers.python.values import (
    Array,
    Bound,
    Class,
    Function,
    Instance,
    Member,
    Module,
    Part,
    Scope,
    Stream,
    Symbol,
)
from codegen.importers.symbolic.feature import Step
from codegen.importers.symbolic.paths import STATE_ADVICE

METHODS: Mapping[type, tuple[str, ...]] = {
    Array: ("tolist", "copy"),
    list: ("index", "count", "copy", "append"),
    tuple: ("index", "count"),
    dict: ("get", "keys", "values", "items"),
    str: ("upper", "lower", "strip", "title", "capitalize", "replace", "startswith", "endswith"),
}
MAX_TEXT = 1 << 10
OF_ARRAYS = {  # attributes of arrays that are no names of features, and what to write instead
    **dict.fromkeys(("shape", "size", "ndim"), "write len(x)"),
    "dtype": "say the type by --arrays",
    **dict.fromkeys(("reshape", "squeeze", "T", "item", "view", "resize", "transpose"), "write x[0] for each number"),
    **dict.fromkeys(("mean", "sum", "min", "max", "any", "all", "dot", "clip", "round"), "write it for each number"),
}


def attribute_of(m: Machine, value: Any, name: str, node: ast.AST) -> Any:
    """What `value.name` is."""
    if isinstance(value, Symbol):
        return Symbol(f"{value.name}.{name}")
    if isinstance(value, Module):
        if name in value.members:
            return value.members[name]
        if value.name in ("enum", "dataclasses", "typing"):
            return Symbol(name)
        advice = "write what it computes with comparisons and numbers"
        raise m.make_error(node, f"{value.name}.{name} is not known", advice)
    if isinstance(value, Part):
        return _of_part(m, value, name, node)
    if isinstance(value, Instance | Class):
        return _of_object(m, value, name, node)
    if isinstance(value, Member):
        if name in ("value", "name"):
            return value.name if name == "name" else value.value
        if isinstance(value.kind.members.get(name), Function):
            return _bind_method(m, value.kind.members[name], [value], node)
    kind = next((kind for kind in METHODS if isinstance(value, kind)), None)
    if kind is not None and name in METHODS[kind]:
        return _method(value, name)
    what = f"'.{escape_text(name)}' of {words_of(value)} is not understood"
    if isinstance(value, int | float):
        what = "a number has no attributes"
    raise m.make_error(node, what, "write the number or the text itself")


def _of_part(m: Machine, part: Part, name: str, node: ast.AST) -> Any:
    """An attribute of the observation: a method of arrays or dictionaries, or a field."""

    def convert_part(m: Machine, node: ast.AST, given: list[Any], named: dict[str, Any]) -> Any:
        kind = [*given, *named.values()][0] if given or named else None
        return replace(part, steps=part.steps + conversion(m, kind), array=True)

    def get_key(m: Machine, node: ast.AST, given: list[Any], named: dict[str, Any]) -> Any:
        if given and isinstance(given[0], str):
            return m.inputs.enter(part, given[0], m.line)
        raise m.make_error(node, "a key of the observation is not understood", 'write x["speed"]')

    def copy_part(m: Machine, node: ast.AST, given: list[Any], named: dict[str, Any]) -> Any:
        if given or named:
            raise m.make_error(node, f"{name}() is given something", f"write {name}()")
        steps = (*part.steps, Step("float", float)) if name == "tolist" else part.steps
        return replace(part, steps=steps, array=name != "tolist" and (part.array or name != "copy"))

    if name in OF_ARRAYS:
        raise m.make_error(node, f"'.{name}' of the observation is not understood", OF_ARRAYS[name])
    if name in ("flatten", "ravel", "copy", "tolist"):
        return Bound(name, copy_part)
    if name in ("astype", "get"):
        return Bound(name, convert_part if name == "astype" else get_key)
    return m.inputs.enter(part, name, m.line)


def _of_object(m: Machine, value: Instance | Class, name: str, node: ast.AST) -> Any:
    kind, key = value if isinstance(value, Class) else value.kind, (id(value), name)
    if key in m.written:
        return m.written[key]
    member = kind.members.get(name)
    if (
        m.paths is not None
        and isinstance(value, Instance)
        and id(value) not in m.fresh
        and type(member) is not Function
    ):
        if m.kept.get(name, set()) - m.ran:
            what = f"'{escape_text(name)}' is remembered between calls: a function sets it"
            raise m.make_error(node, what, STATE_ADVICE)
        m.read.setdefault(key, m.line)
    if isinstance(value, Instance) and name in value.attributes:
        return value.attributes[name]
    if name == "__name__" and isinstance(value, Class):
        return kind.name
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
    return Bound(f"{method.name}()", lambda m, node, given, named: m.call(method, [*first, *given], named, node))


def _method(value: Any, name: str) -> Bound:
    """A method of a list, a dictionary or a text."""

    def handle_call(m: Machine, node: ast.AST, given: list[Any], named: dict[str, Any]) -> Any:
        if name == "append":
            m.ensure_fresh(value, node).append(*given)
            return m.weigh(value)
        if name in ("keys", "values", "items"):
            return Stream(list(getattr(value, name)()))
        if name == "get":
            return value.get(key_of(m, given[0]), *given[1:])
        if name in ("copy", "tolist"):
            return m.keep_value([*value])
        given = [m.whole(each) for each in given]
        if not is_constant([*value]) or not is_constant(given):
            raise m.make_error(node, f"'.{name}' looks for features or objects", "compare them one by one")
        if any(isinstance(each, str) and len(each) > MAX_TEXT for each in (value, *given)):
            raise m.make_error(node, "a text is too long", "make it shorter")
        try:
            returned = getattr(value, name)(*given, **named)
        except (ValueError, TypeError):
            raise m.make_error(node, f"'.{name}' fails with what it is given here", "look it up before") from None
        return m.keep_value(returned) if isinstance(returned, str) else returned

    return Bound(name, handle_call)


@reads(EXPRESSIONS, ast.Attribute)
def _attribute(m: Machine, node: ast.Attribute, scope: Scope) -> Any:
    return attribute_of(m, m.eval(node.value, scope), node.attr, node)
