"""Objects: attributes of all kinds of values, methods of lists and texts; classes of a file, and what they make.

Does: what `value.name` is; evaluates a class's body; makes objects by `__init__` or by fields.
Assumes: no base but those of enum, typing and abc, and methods without a meaning of their own.
Does not: take classes that are built on one another, or methods that Python calls by itself.
"""

# pyright: basic
# the values of a program may be anything
import ast
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from codegen.errors import escape_text
from codegen.importers.python.arithmetic import is_constant
from codegen.importers.python.containers import key_of
from codegen.importers.python.library import conversion
from codegen.importers.python.machine import CALLS, EXPRESSIONS, STATEMENTS, Machine, reads, text_of
from codegen.importers.python.values import (
    AUTO,
    Array,
    Bound,
    Class,
    Factory,
    Function,
    Instance,
    Member,
    Module,
    Part,
    Refused,
    Scope,
    Stream,
    Symbol,
    words_of,
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
OF_PARTS = ("flatten", "ravel", "copy", "tolist", "astype", "get")
OF_ARRAYS = ("shape", "size", "ndim", "dtype", "reshape", "squeeze", "T", "item", "view", "resize", "transpose", "mean",
             "sum", "min", "max", "any", "all", "dot", "clip", "round")  # fmt: skip
MIXED = {"IntEnum": int, "StrEnum": str, "int": int, "str": str, "float": float}
PLAIN = ("object", "ABC", "Protocol", "NamedTuple", "TypedDict", "Enum", *MIXED)
DECORATORS = ("dataclass", "unique", "final", "runtime_checkable")
SETTINGS = ("frozen", "slots", "eq", "order", "repr", "unsafe_hash")  # of a dataclass, which decide nothing
MAKERS = ("__init__", "__post_init__")
METHODS_KEPT = (*MAKERS, "__call__", "__doc__")


# --- attributes


def attribute_of(m: Machine, value: Any, name: str, node: ast.AST) -> Any:
    """What `value.name` is."""
    if isinstance(value, Symbol):
        return Symbol(f"{value.name}.{name}")
    if isinstance(value, Module):
        if name in value.members:
            return value.members[name]
        if value.name in ("enum", "dataclasses", "typing"):
            return Symbol(name)
        raise Refused(f"{value.name}.{name} is not known", "write what it computes with comparisons and numbers")
    if isinstance(value, Part):
        return _of_part(m, value, name)
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
    raise Refused(what, "write the number or the text itself")


def _of_part(m: Machine, part: Part, name: str) -> Any:
    """An attribute of the observation: a method of arrays or dictionaries, or a field."""

    def handle_call(m: Machine, node: ast.AST, given: list[Any], named: dict[str, Any]) -> Any:
        if name == "get":
            return m.inputs.enter(part, m.whole(given[0]))
        if name == "astype":
            return replace(part, steps=part.steps + conversion(*given, **named), array=True)
        steps = (*part.steps, Step("float", float)) if name == "tolist" else part.steps
        return replace(part, steps=steps, array=name in ("flatten", "ravel") or (part.array and name == "copy"))

    if name in OF_ARRAYS:
        raise Refused(f"'.{name}' of the observation is not understood", "write x[0] for each number, and len(x)")
    return Bound(name, handle_call) if name in OF_PARTS else m.inputs.enter(part, name)


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
            raise Refused(f"'.{name}' looks for features or objects", "compare them one by one")
        if any(isinstance(each, str) and len(each) > MAX_TEXT for each in (value, *given)):
            raise Refused("a text is too long", "make it shorter")
        returned = getattr(value, name)(*given, **named)
        return m.keep_value(returned) if isinstance(returned, str) else returned

    return Bound(name, handle_call)


@reads(EXPRESSIONS, ast.Attribute)
def _attribute(m: Machine, node: ast.Attribute, scope: Scope) -> Any:
    return attribute_of(m, m.eval(node.value, scope), node.attr, node)


# --- classes


@reads(STATEMENTS, ast.ClassDef)
def _class(m: Machine, node: ast.ClassDef, scope: Scope) -> None:
    if m.paths is not None:
        raise Refused("a class is made by a decision", "write it outside the function")
    bases = [m.eval(each, scope) for each in node.bases]
    own = next((each.name for each in bases if isinstance(each, Class)), None)
    if own is not None:
        what = f"the class {escape_text(node.name)} is built on the class {escape_text(own)} of the file"
        raise Refused(what, "write one class with all its methods", hard=True)
    names = [each.name.rpartition(".")[2] if isinstance(each, Symbol | Bound) else "" for each in bases]
    names += [_decorator(m, each, scope) for each in node.decorator_list]
    odd = next((each for each in names if each not in (*PLAIN, *DECORATORS)), None)
    if odd is not None or node.keywords:
        what = f"the class {escape_text(node.name)} is built on {escape_text(odd or 'what is not known')}"
        raise Refused(what, "write the function that decides on its own")
    members: dict[str, Any] = {}
    m.block(node.body, Scope(members, scope, of_class=True))
    magic = next((each for each in members if each.startswith("__") and each not in METHODS_KEPT), None)
    if magic is not None:
        what = f"the class {escape_text(node.name)} has {escape_text(magic)}, which Python calls by itself"
        raise Refused(what, "give the method a name without underscores, and call it", hard=True)
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
        raise Refused(f"the class {escape_text(node.name)} is a number or a text", "write a function")
    if kind.enum:
        _make_members(m, node, kind, text="StrEnum" in names)
    elif "dataclass" not in names and not {"NamedTuple", "TypedDict"} & {*names}:
        kind.fields = ()
    scope.names[node.name] = kind


def _decorator(m: Machine, node: ast.expr, scope: Scope) -> str:
    """The name of a decorator of a class that changes nothing which is read. InputError for settings that do."""
    settings = node.keywords if isinstance(node, ast.Call) else []
    if isinstance(node, ast.Call) and (node.args or any(each.arg not in SETTINGS for each in settings)):
        raise Refused(f"{text_of(node)} is not understood", "write @dataclass, or __init__")
    called = m.eval(node.func if isinstance(node, ast.Call) else node, scope)
    return called.name.rpartition(".")[2] if isinstance(called, Symbol) else ""


def _make_members(m: Machine, node: ast.ClassDef, kind: Class, *, text: bool) -> None:
    """Makes members of an Enum's constants; equal values are one member."""
    seen: list[Member] = []
    for name, value in list(kind.members.items()):
        if isinstance(value, Function):
            continue
        if name.startswith("_") or (value is AUTO and kind.mixed is str and not text):
            raise Refused(f"{escape_text(name)} of the Enum is not understood", "write its value")
        if value is AUTO:
            numbers = [each.value for each in seen if isinstance(each.value, int)]
            if numbers and numbers[-1] != max(numbers):
                raise Refused("auto() follows a smaller value", "write the value")
            value = name.lower() if text else numbers[-1] + 1 if numbers else 1
        if kind.mixed is not None and not isinstance(value, kind.mixed):
            raise Refused(f"{escape_text(name)} is no {kind.mixed.__name__}", "write one")
        member = next((each for each in seen if each.value == value), None) or Member(kind, name, value)
        kind.members[name] = member
        seen.append(member)


def instance_of(m: Machine, kind: Class, given: Sequence[Any], named: Mapping[str, Any], node: ast.AST) -> Any:
    """What calling a class gives: an object, or a member of an Enum."""
    if kind.enum:
        value = m.whole(given[0]) if len(given) == 1 and not named else None
        members = [each for each in kind.constants if value is each or value == each.value]
        if not members:
            raise Refused(f"{text_of(node)} is no member", "look it up by a value that it has")
        return members[0]
    if kind.typed:
        raise Refused(f"{text_of(node)} makes a dictionary", "write it as a dictionary")
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
            raise Refused(f"{text_of(node)} lacks {escape_text(name)}", "give it, or a default")
        value = values.pop(name, kind.members.get(name))
        made.attributes[name] = m.call(value.make, [], {}, node) if isinstance(value, Factory) else value
    if values or len(given) > len(kind.fields):
        raise Refused(f"{text_of(node)} does not fit the class {escape_text(kind.name)}", "mend it")
    after = kind.members.get("__post_init__")
    if isinstance(after, Function):
        m.apply(after, [made], {}, node)


CALLS[Class] = instance_of
