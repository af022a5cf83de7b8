"""Classes of a file: plain ones, Enums, dataclasses, named tuples; and their objects.

Does: evaluates a class's body; makes objects by `__init__` or by fields; looks up members.
Assumes: bases of the file, or of enum, dataclasses, typing and abc.
Does not: take metaclasses, `__getattr__` or decorators that change a class.
"""

# pyright: basic
# the values of a program may be anything
import ast
from collections.abc import Mapping, Sequence
from typing import Any

from codegen.errors import escape_text
from codegen.importers.python.machine import CALLS, STATEMENTS, Machine, reads, text_of
from codegen.importers.python.statements import decorator_of
from codegen.importers.python.values import AUTO, Class, Factory, Function, Instance, Member, Scope, Symbol, Unread

ENUMS = ("Enum", "IntEnum", "StrEnum", "IntFlag", "Flag")
MIXED = ("IntEnum", "IntFlag", "StrEnum", "int", "str", "float")
PLAIN = ("object", "ABC", "Protocol", "Generic", "NamedTuple", "TypedDict", *ENUMS, *MIXED)
DECORATORS = ("dataclass", "unique", "final", "runtime_checkable")
MAKERS = ("__init__", "__post_init__", "__new__")
MAGIC = ("__getattr__", "__getattribute__", "__setattr__", "__new__", "__class_getitem__")


@reads(STATEMENTS, ast.ClassDef)
def _class(m: Machine, node: ast.ClassDef, scope: Scope) -> None:
    scope.names[node.name] = _class_of(m, node, scope)


def _class_of(m: Machine, node: ast.ClassDef, scope: Scope) -> Class | Unread:
    """The class that a statement defines."""
    bases = [m.eval(each, scope) for each in node.bases]
    names = [each.name.rpartition(".")[2] for each in bases if isinstance(each, Symbol)]
    names += [each.name for each in bases if hasattr(each, "name") and not isinstance(each, Symbol | Class)]
    own = tuple(each for each in bases if isinstance(each, Class))
    odd = [each for each in names if each not in PLAIN]
    odd += [each for each in map(decorator_of, node.decorator_list) if each not in DECORATORS]
    unread = [each for each in bases if isinstance(each, Unread)]
    if odd or unread or node.keywords:
        what = f"the class {escape_text(node.name)} is built on {escape_text(odd[0]) if odd else 'what is not known'}"
        return m.unread(what, "write the function that decides on its own")
    members: dict[str, Any] = {}
    m.block(node.body, Scope(members, scope, of_class=True))
    if any(each in members for each in MAGIC):
        return m.unread(f"the class {escape_text(node.name)} changes how attributes are found", "use plain attributes")
    fields = tuple(name for each in own for name in each.fields)
    fields += tuple(
        each.target.id for each in node.body if isinstance(each, ast.AnnAssign) and isinstance(each.target, ast.Name)
    )
    kind = Class(node.name, own, members, fields=fields, kept=_collect_state(node).union(*(each.kept for each in own)))
    kind.enum = any(each in ENUMS for each in names) or any(each.enum for each in own)
    kind.mixed = any(each in MIXED for each in names) or any(each.mixed for each in own)
    if kind.enum:
        _ensure_members(kind, text="StrEnum" in names)
    return kind


def _ensure_members(kind: Class, *, text: bool) -> None:
    """Makes members of an Enum's constants; equal values are one member."""
    seen: dict[Any, Member] = {}
    last = 0
    for name, value in list(kind.members.items()):
        if name.startswith("_") or isinstance(value, Function):
            continue
        if value is AUTO:
            value = name.lower() if text else last + 1
        last = value if isinstance(value, int) else last
        kind.members[name] = seen.setdefault(repr(value), Member(kind, name, value))


def _collect_state(node: ast.ClassDef) -> frozenset[str]:
    """Attributes of `self` that methods set, other than those that make the object."""
    attributes: set[str] = set()
    for each in node.body:
        if isinstance(each, ast.FunctionDef) and each.name not in MAKERS and each.args.args:
            own = each.args.args[0].arg
            attributes |= {
                inner.attr for inner in ast.walk(each)
                if isinstance(inner, ast.Attribute) and isinstance(inner.ctx, ast.Store)
                and isinstance(inner.value, ast.Name) and inner.value.id == own
            }  # fmt: skip
    return frozenset(attributes)


def instance_of(m: Machine, kind: Class, given: Sequence[Any], named: Mapping[str, Any], node: ast.AST) -> Any:
    """What calling a class gives: an object, or a member of an Enum."""
    if kind.enum:
        value = m.whole(given[0])
        members = [each for each in kind.members.values() if isinstance(each, Member) and value in (each, each.value)]
        if not members:
            raise m.make_error(node, f"{text_of(node)} is no member", "look it up by a value that it has")
        return members[0]
    made = Instance(kind)
    m.fresh[id(made)] = made
    if m.paths is None:
        m.made.add(kind)
    maker = kind.find("__init__")
    if isinstance(maker, Function):
        m.apply(maker, [made, *given], named, node)
        return made
    values = dict(zip(kind.fields, given, strict=False)) | dict(named)
    for name in kind.fields:
        if name not in values and kind.find(name) is None:
            raise m.make_error(node, f"{text_of(node)} lacks {escape_text(name)}", "give it, or a default")
        value = values.pop(name, kind.find(name))
        made.attributes[name] = m.call(value.make, [], {}, node) if isinstance(value, Factory) else value
    if values or len(given) > len(kind.fields):
        raise m.make_error(node, f"{text_of(node)} does not fit the class {escape_text(kind.name)}", "mend it")
    after = kind.find("__post_init__")
    if isinstance(after, Function):
        m.apply(after, [made], {}, node)
    return made


CALLS[Class] = instance_of
