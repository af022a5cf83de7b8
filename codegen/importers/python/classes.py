"""Classes of a file: plain ones, Enums, dataclasses and named tuples; and their objects.

Does: evaluates a class's body; makes objects by `__init__` or by fields.
Assumes: no base but those of enum, typing and abc, and methods without a meaning of their own.
Does not: take classes that are built on one another, or methods that Python calls by itself.
"""

# pyright: basic
# the values of a program may be anything
import ast
from collections.abc import Mapping, Sequence
from typing import Any

from codegen.errors import escape_text
from codegen.importers.python.machine import CALLS, STATEMENTS, Machine, Refusal, reads, text_of
from codegen.importers.python.values import AUTO, Bound, Class, Factory, Function, Instance, Member, Scope, Symbol

MIXED = {"IntEnum": int, "StrEnum": str, "int": int, "str": str, "float": float}
PLAIN = ("object", "ABC", "Protocol", "NamedTuple", "TypedDict", "Enum", *MIXED)
DECORATORS = ("dataclass", "unique", "final", "runtime_checkable")
SETTINGS = ("frozen", "slots", "eq", "order", "repr", "unsafe_hash")  # of a dataclass, which decide nothing
MAKERS = ("__init__", "__post_init__")
METHODS = (*MAKERS, "__call__", "__doc__")


@reads(STATEMENTS, ast.ClassDef)
def _class(m: Machine, node: ast.ClassDef, scope: Scope) -> None:
    if m.paths is not None:
        raise m.make_error(node, "a class is made by a decision", "write it outside the function")
    bases = [m.eval(each, scope) for each in node.bases]
    own = next((each.name for each in bases if isinstance(each, Class)), None)
    if own is not None:
        what = f"the class {escape_text(node.name)} is built on the class {escape_text(own)} of the file"
        raise m.make_error(node, what, "write one class with all its methods", Refusal)
    names = [each.name.rpartition(".")[2] if isinstance(each, Symbol | Bound) else "" for each in bases]
    names += [_decorator(m, each, scope) for each in node.decorator_list]
    odd = next((each for each in names if each not in (*PLAIN, *DECORATORS)), None)
    if odd is not None or node.keywords:
        what = f"the class {escape_text(node.name)} is built on {escape_text(odd or 'what is not known')}"
        raise m.make_error(node, what, "write the function that decides on its own")
    members: dict[str, Any] = {}
    m.block(node.body, Scope(members, scope, of_class=True))
    magic = next((each for each in members if each.startswith("__") and each not in METHODS), None)
    if magic is not None:
        what = f"the class {escape_text(node.name)} has {escape_text(magic)}, which Python calls by itself"
        advice = "give the method a name without underscores, and call it"
        raise m.make_error(node, what, advice, Refusal)
    kind = Class(node.name, members, typed="TypedDict" in names)
    kind.fields = tuple(
        each.target.id
        for each in node.body
        if isinstance(each, ast.AnnAssign) and isinstance(each.target, ast.Name)
        and "ClassVar" not in ast.unparse(each.annotation)
    )  # fmt: skip
    kind.enum = "Enum" in names or any(each.endswith("Enum") for each in names)
    kind.mixed = next((MIXED[each] for each in names if each in MIXED), None)
    if kind.mixed and not kind.enum:
        raise m.make_error(node, f"the class {escape_text(node.name)} is a number or a text", "write a function")
    if kind.enum:
        _make_members(m, node, kind, text="StrEnum" in names)
    elif "dataclass" not in names and not {"NamedTuple", "TypedDict"} & {*names}:
        kind.fields = ()
    scope.names[node.name] = kind


def _decorator(m: Machine, node: ast.expr, scope: Scope) -> str:
    """The name of a decorator of a class that changes nothing which is read. InputError for settings that do."""
    settings = node.keywords if isinstance(node, ast.Call) else []
    if isinstance(node, ast.Call) and (node.args or any(each.arg not in SETTINGS for each in settings)):
        raise m.make_error(node, f"{text_of(node)} is not understood", "write @dataclass, or __init__")
    called = m.eval(node.func if isinstance(node, ast.Call) else node, scope)
    return called.name.rpartition(".")[2] if isinstance(called, Symbol) else ""


def _make_members(m: Machine, node: ast.ClassDef, kind: Class, *, text: bool) -> None:
    """Makes members of an Enum's constants; equal values are one member."""
    seen: list[Member] = []
    for name, value in list(kind.members.items()):
        if isinstance(value, Function):
            continue
        if name.startswith("_") or (value is AUTO and kind.mixed is str and not text):
            raise m.make_error(node, f"{escape_text(name)} of the Enum is not understood", "write its value")
        if value is AUTO:
            numbers = [each.value for each in seen if isinstance(each.value, int)]
            if numbers and numbers[-1] != max(numbers):
                raise m.make_error(node, "auto() follows a smaller value", "write the value")
            value = name.lower() if text else numbers[-1] + 1 if numbers else 1
        if kind.mixed is not None and not isinstance(value, kind.mixed):
            raise m.make_error(node, f"{escape_text(name)} is no {kind.mixed.__name__}", "write one")
        member = next((each for each in seen if each.value == value), None) or Member(kind, name, value)
        kind.members[name] = member
        seen.append(member)


def instance_of(m: Machine, kind: Class, given: Sequence[Any], named: Mapping[str, Any], node: ast.AST) -> Any:
    """What calling a class gives: an object, or a member of an Enum."""
    if kind.enum:
        value = m.whole(given[0]) if len(given) == 1 and not named else None
        members = [each for each in kind.constants if value is each or value == each.value]
        if not members:
            raise m.make_error(node, f"{text_of(node)} is no member", "look it up by a value that it has")
        return members[0]
    if kind.typed:
        raise m.make_error(node, f"{text_of(node)} makes a dictionary", "write it as a dictionary")
    made = Instance(kind)
    m.fresh[id(made)] = made
    if m.paths is None:
        m.made.add(kind)
    maker = kind.members.get("__init__")
    if isinstance(maker, Function):
        m.apply(maker, [made, *given], named, node)
    else:
        _fill_fields(m, made, given, named, node)
    return made


def _fill_fields(m: Machine, made: Instance, given: Sequence[Any], named: Mapping[str, Any], node: ast.AST) -> None:
    """Sets the fields of an object without an `__init__` of its own."""
    kind, values = made.kind, {**dict(zip(made.kind.fields, given, strict=False)), **named}
    for name in kind.fields:
        if name not in values and name not in kind.members:
            raise m.make_error(node, f"{text_of(node)} lacks {escape_text(name)}", "give it, or a default")
        value = values.pop(name, kind.members.get(name))
        made.attributes[name] = m.call(value.make, [], {}, node) if isinstance(value, Factory) else value
    if values or len(given) > len(kind.fields):
        raise m.make_error(node, f"{text_of(node)} does not fit the class {escape_text(kind.name)}", "mend it")
    after = kind.members.get("__post_init__")
    if isinstance(after, Function):
        m.apply(after, [made], {}, node)


CALLS[Class] = instance_of
