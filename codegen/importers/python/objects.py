"""Objects: attributes of all kinds of values, methods of lists and dictionaries; classes of a file, what they make.

Does: what `value.name` is; evaluates a class's body; makes objects by `__init__` or by fields, and Enums as Python's.
Assumes: no base but those of enum, typing and object, and methods without a meaning of their own.
Does not: take classes that are built on one another, methods of Enums, or methods that Python calls by itself.
"""

# pyright: basic
# the values of a program may be anything
import ast
import enum
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from codegen.errors import escape_text
from codegen.importers.python.arithmetic import is_constant
from codegen.importers.python.expressions import key_of
from codegen.importers.python.machine import CALLS, EXPRESSIONS, STATED, STATEMENTS, Machine, reads, text_of
from codegen.importers.python.values import (
    Bound,
    Class,
    Factory,
    Function,
    Instance,
    Module,
    Part,
    Refused,
    Scope,
    Stream,
    words_of,
)
from codegen.importers.symbolic.paths import STATE_ADVICE

METHODS: Mapping[type, tuple[str, ...]] = {
    list: ("index", "append"), tuple: ("index",), dict: ("get", "keys", "values", "items"),
}  # fmt: skip
GIVEN = (np.float64, np.ndarray, dict)  # what an observation may be, whose own attributes are no features
PLAIN = ("object", "typing.Protocol", "typing.NamedTuple", "typing.TypedDict")
SETTINGS = ("frozen", "slots", "eq", "order", "repr", "unsafe_hash")  # of a dataclass, which decide nothing
KEPT = ("__init__", "__post_init__", "__call__")


# --- attributes


@reads(EXPRESSIONS, ast.Attribute)
def _attribute(m: Machine, node: ast.Attribute, scope: Scope) -> Any:
    value, name = m.eval(node.value, scope), node.attr
    if isinstance(value, Module) and name in value.members:
        m.numpy |= value.name == "numpy"
        return value.members[name]
    if isinstance(value, Module):
        raise Refused(f"{value.name}.{name} is not known", STATED)
    if isinstance(value, Part):
        if value.array or any(hasattr(each, name) for each in GIVEN):
            raise Refused(f"'.{name}' of the observation is not understood", "write x[0] for each number, and len(x)")
        return m.inputs.enter(value, name)
    if isinstance(value, Instance | Class):
        return _of_object(m, value, name, node)
    if isinstance(value, enum.Enum) and name in ("value", "name"):
        return value.value if name == "value" else value.name
    if isinstance(value, enum.EnumType) and name in value.__members__:
        return value[name]
    if name in METHODS.get(type(value), ()):
        return _method(value, name)
    raise Refused(f"'.{escape_text(name)}' of {words_of(value)} is not understood", STATED)


def _of_object(m: Machine, value: Instance | Class, name: str, node: ast.AST) -> Any:
    kind = value if isinstance(value, Class) else value.kind
    member = kind.members.get(name)
    lasting = m.paths is not None and isinstance(value, Instance) and id(value) not in m.fresh
    if lasting and not isinstance(member, Function) and m.kept.get(name, set()) - m.ran:
        raise Refused(f"'{escape_text(name)}' is remembered between calls: a function sets it", STATE_ADVICE)
    if isinstance(value, Instance) and name in value.attributes:
        return value.attributes[name]
    if member is None:
        raise Refused(f"'{escape_text(name)}' is not set on some path", "set it in __init__")
    if not isinstance(member, Function):
        return member
    first = {"classmethod": [kind], "staticmethod": []}.get(member.kind, [value] if isinstance(value, Instance) else [])
    if member.kind == "property" and first:
        return m.apply(member, first, {})
    return Bound(f"{name}()", lambda m, node, given, named: m.call(member, [*first, *given], named, node))


def _method(value: Any, name: str) -> Bound:
    """A method of a list or a dictionary."""

    def handle_call(m: Machine, node: ast.AST, given: list[Any], named: dict[str, Any]) -> Any:
        if name == "append":
            m.ensure_fresh(value, node).append(*given)
            return m.weigh(value)
        if name == "get":
            return value.get(key_of(m, given[0]), *given[1:])
        if name == "index":
            given = [m.whole(each) for each in given]
            if not is_constant([*value]) or not is_constant(given):
                raise Refused("'.index' looks for features or objects", "compare them one by one")
            return value.index(*given)
        return Stream(getattr(value, name)(*given))

    return Bound(name, handle_call)


# --- classes


@reads(STATEMENTS, ast.ClassDef)
def _class(m: Machine, node: ast.ClassDef, scope: Scope) -> None:
    if m.paths is not None:
        raise Refused("a class is made by a decision", "write it outside the function")
    title, bases = f"the class {escape_text(node.name)}", [m.eval(each, scope) for each in node.bases]
    own = next((each.name for each in bases if isinstance(each, Class)), None)
    if own is not None:
        what = f"{title} is built on the class {escape_text(own)} of the file"
        raise Refused(what, "write one class with all its methods", hard=True)
    names = [getattr(each, "name", "") for each in bases if not isinstance(each, enum.EnumType)]
    decorators = [_decorator(m, each, scope) for each in node.decorator_list]
    members: dict[str, Any] = {}
    m.block(node.body, Scope(members, scope, of_class=True))
    if any(isinstance(each, enum.EnumType) for each in bases):
        scope.names[node.name] = _make_enum(node.name, bases, members)
        return
    odd = next((each for each in (*bases, *node.keywords) if getattr(each, "name", "") not in PLAIN), None)
    if odd is not None:
        raise Refused(f"{title} is built on what is not known", "write the function that decides on its own")
    magic = next((each for each in members if each.startswith("__") and each not in KEPT), None)
    if magic is not None:
        what = f"{title} has {escape_text(magic)}, which Python calls by itself"
        raise Refused(what, "give the method a name without underscores, and call it", hard=True)
    kind = Class(node.name, members, made="typing.TypedDict" not in names)
    if "dataclasses.dataclass" in decorators or {"typing.NamedTuple", "typing.TypedDict"} & {*names}:
        kind.fields = tuple(
            each.target.id
            for each in node.body
            if isinstance(each, ast.AnnAssign) and isinstance(each.target, ast.Name)
            and "ClassVar" not in ast.unparse(each.annotation)
        )  # fmt: skip
    scope.names[node.name] = kind


def _decorator(m: Machine, node: ast.expr, scope: Scope) -> str:
    """The name of a decorator of a class that changes nothing which is read. InputError for others."""
    settings = node.keywords if isinstance(node, ast.Call) else []
    called = m.eval(node.func if isinstance(node, ast.Call) else node, scope)
    name = called.name if isinstance(called, Bound) else ""
    known = name in ("dataclasses.dataclass", "enum.unique") and not getattr(node, "args", ())
    if not known or any(each.arg not in SETTINGS for each in settings):
        raise Refused(f"{text_of(node)} is not understood", "write @dataclass, or __init__")
    return name


def _make_enum(name: str, bases: Sequence[Any], members: Mapping[str, Any]) -> Any:
    """Python's own Enum of constants: which members are one, and equal to numbers and texts, it knows itself."""
    mixed = {"str": str, "int": int, "float": float}
    kinds = [mixed.get(getattr(each, "name", "")) for each in bases[:-1]]
    constant = (int, float, str, tuple) if kinds else (int, float, str, tuple, enum.auto)
    odd = [key for key, value in members.items() if key.startswith("_") or not isinstance(value, constant)]
    kinds += [None] if len({isinstance(each, enum.auto) for each in members.values()}) > 1 else []  # versions differ
    if odd or len(kinds) > 1 or None in kinds or bases[-1] not in (enum.Enum, enum.IntEnum):
        what = f"{odd[0]} of the Enum {name}" if odd else f"the Enum {name}"
        raise Refused(f"{escape_text(what)} is not understood", "write members and constants: GO = 1")
    return bases[-1](name, list(members.items()), type=kinds[0] if kinds else None)


def instance_of(m: Machine, kind: Class, given: Sequence[Any], named: Mapping[str, Any], node: ast.AST) -> Any:
    """The object that calling a class gives."""
    if not kind.made:
        raise Refused(f"{text_of(node)} makes a dictionary", "write it as a dictionary")
    made = Instance(kind)
    m.fresh[id(made)] = made
    if m.paths is None:
        m.made.add(kind)
    maker = kind.members.get("__init__")
    if isinstance(maker, Function):
        m.apply(maker, [made, *given], named)
        return made
    values = {**dict(zip(kind.fields, given, strict=False)), **named}
    for name in kind.fields:
        if name not in values and name not in kind.members:
            raise Refused(f"{text_of(node)} lacks {escape_text(name)}", "give it, or a default")
        value = values.pop(name, kind.members.get(name))
        made.attributes[name] = m.call(value.make, [], {}, node) if isinstance(value, Factory) else value
    if values or len(given) > len(kind.fields):
        raise Refused(f"{text_of(node)} does not fit the class {escape_text(kind.name)}", "mend it")
    after = kind.members.get("__post_init__")
    if isinstance(after, Function) and kind.fields:
        m.apply(after, [made], {})
    return made


CALLS[Class] = instance_of
