"""Objects of C on one path: which one an expression names, what it holds, and how it is set.

Does: finds variables, members and items; reads them, so that the caller's become features; sets and initializes them.
Assumes: nodes of pycparser; expressions.py evaluates what stands within them.
Does not: compute, or let anything be kept between decisions.
"""

# pyright: basic
# pycparser's nodes have no declared attributes
from collections.abc import Mapping
from typing import Any

from pycparser import c_ast

from codegen.errors import escape_text
from codegen.importers.c.arithmetic import TEST_ADVICE, Arithmetic
from codegen.importers.c.declarations import Declarations, text_of
from codegen.importers.c.inputs import Inputs
from codegen.importers.c.kinds import INT, Kind, Many, Pointer, Type, Void
from codegen.importers.c.library import CONSTANTS
from codegen.importers.c.values import (
    Array,
    Cell,
    Function,
    Number,
    Object,
    Reference,
    Struct,
    Text,
    Value,
    make_object,
)
from codegen.importers.symbolic.paths import STATE_ADVICE, Growth


def _points(value: Reference, to: Type) -> bool:
    """Whether what a pointer leads to is of a type, or nobody asks."""
    actual = value.target.type.of if isinstance(value.target, Array) else value.target.type
    return to in (actual, Void()) or (isinstance(to, Many) and to.of == actual)


class Objects(Declarations):
    """The objects of one path."""

    paths: Growth | None = None
    inputs: Inputs | None = None

    def __init__(self, where: str, names: Mapping[str, int], numbers: str, *, contracts: bool) -> None:
        super().__init__(where, names)
        self.arithmetic = Arithmetic(self.make_error, numbers, contracts=contracts)
        self.changing: set[str] = set()  # variables of the file that some function sets

    def value(self, node: Any) -> Value:
        """What an expression is."""
        raise NotImplementedError

    def place(self, node: Any) -> Object | Number | Function | Value:
        """The object that an expression names; for what is none, its value."""
        if isinstance(node, c_ast.ID):
            return self._find_object(node)
        if isinstance(node, c_ast.StructRef):
            holder = self.place(node.name) if node.type == "." else self._target(self.value(node.name), 0, node)
            if not isinstance(holder, Struct) or node.field.name not in holder.members:
                raise self.make_error(f"there is no such member: {text_of(node)}")
            return holder.members[node.field.name]
        if isinstance(node, c_ast.ArrayRef):
            base = self.value(node.name)
            subscript = self.arithmetic.resolve_number(self.value(node.subscript))
            if not isinstance(subscript, Number) or subscript.kind.floating:
                what = f"an item is chosen by a feature: {text_of(node)}"
                raise self.make_error(what, "test its range first, or choose by if or switch")
            return self._target(base, int(subscript.value), node)
        if isinstance(node, c_ast.UnaryOp) and node.op == "*":
            return self._target(self.value(node.expr), 0, node)
        return self.value(node)

    def _find_object(self, node: Any) -> Object | Number | Function:
        target = self.find_name(node.name)
        if target is None and node.name in self.functions:
            return Function(self.functions[node.name])
        if target is None and node.name in CONSTANTS:
            return CONSTANTS[node.name]
        if target is None:
            raise self.make_error(f"the name {escape_text(node.name)} is not known", "define it in the file")
        if node.name in self.changing and self.scopes[0].get(node.name) is target:
            self.at(node)
            what = f"the variable {escape_text(node.name)} keeps what earlier decisions set"
            raise self.make_error(what, STATE_ADVICE)
        return target

    def _target(self, base: Any, at: int, node: Any) -> Object:
        """The item that a pointer and an index lead to."""
        target = base.target if isinstance(base, Reference) else None
        if isinstance(target, Array):
            target = target.item(base.at + at)
        elif target is not None and (base.at or at):
            target = None
        if target is None:
            raise self.make_error(f"there is no such item: {text_of(node)}", "stay within the declared length")
        return target

    def load(self, target: Any) -> Value:
        """What an object holds."""
        if isinstance(target, Array):
            return Reference(target)
        if isinstance(target, Cell):
            if target.value is None and target.origin is not None and self.inputs is not None:
                return self.inputs.value(target)
            if target.value is None:
                what = "a variable is read that holds nothing on some path"
                raise self.make_error(what, "set it where it is declared")
            return target.value
        return target

    def store(self, target: Any, value: Any) -> None:
        """Sets an object."""
        if isinstance(target, Struct) and isinstance(value, Struct):
            for name, member in target.members.items():
                other = value.members[name]
                if not isinstance(other, Cell) or other.value is not None or other.origin is not None:
                    self.store(member, self.load(other) if isinstance(other, Cell) else other)
            return
        if isinstance(target, Array) and isinstance(value, Array):
            for at in range(target.type.length):
                self.store(target.item(at), self.load(value.item(at)))
            return
        if not isinstance(target, Cell):
            raise self.make_error("what is assigned to is not a variable")
        if target.fixed:
            raise self.make_error(target.fixed, STATE_ADVICE)
        if self.inputs is not None:
            self.inputs.write(target)
        target.value = self.cast(value, target.type)

    def cast(self, value: Value, type_: Type) -> Value:
        """A value as one of a type."""
        if isinstance(type_, Kind) and not isinstance(value, Reference | Text | Function | Struct):
            return self.arithmetic.convert_value(value, type_)
        if isinstance(type_, Kind) and type_.name == "_Bool":
            return Number(1, type_)
        if isinstance(type_, Kind):
            raise self.make_error("a pointer or a text becomes a number", TEST_ADVICE)
        if isinstance(type_, Pointer) and isinstance(value, Reference) and not _points(value, type_.to):
            raise self.make_error("a pointer becomes one to another type", "read each object as its own type")
        return value

    # --- initializers

    def initialize_object(self, type_: Type, node: Any, fixed: str = "") -> Object:
        """A new object with an initializer."""
        if isinstance(type_, Many) and not type_.length and isinstance(node, c_ast.InitList):
            places = [at for at, _ in self._places(type_, node)]
            type_ = Many(type_.of, max(places, default=-1) + 1)
        target = make_object(type_)
        self._fill(target, node)
        self._fix(target, fixed)
        return target

    def _places(self, type_: Type, node: Any) -> list[tuple[Any, Any]]:
        """The member or item of each part of a list."""
        names = list(type_.members) if not isinstance(type_, Many) else []  # type: ignore[union-attr]
        parts, at = list[tuple[Any, Any]](), 0
        for each in node.exprs or []:
            if isinstance(each, c_ast.NamedInitializer):
                if len(each.name) != 1:
                    raise self.make_error(f"an initializer is not read: {text_of(each)}")
                at = self.constant(each.name[0]) if not names else names.index(each.name[0].name)
                each = each.expr
            if names and at >= len(names):
                raise self.make_error("an initializer has too many parts")
            parts.append((names[at] if names else at, each))
            at += 1
        return parts

    def _fill(self, target: Object, node: Any) -> None:
        if isinstance(target, Cell):
            only = node.exprs[0] if isinstance(node, c_ast.InitList) and len(node.exprs) == 1 else node
            self.store(target, self.value(only))
            return
        if not isinstance(node, c_ast.InitList):
            value = self.value(node)
            self.store(target, value.target if isinstance(value, Reference) and isinstance(target, Array) else value)
            return
        for key, each in self._places(target.type, node):
            part = target.members[key] if isinstance(target, Struct) else target.item(key)
            if part is None:
                raise self.make_error("an initializer has too many parts")
            self._fill(part, each)
        self.zero_object(target)

    def zero_object(self, target: Object) -> None:
        """What nothing has set becomes 0."""
        if isinstance(target, Cell) and target.value is None and isinstance(target.type, Kind):
            target.value = self.arithmetic.convert_value(Number(0, INT), target.type)
        elif isinstance(target, Struct):
            for each in target.members.values():
                self.zero_object(each)
        elif isinstance(target, Array):
            for at in range(target.type.length):
                self.zero_object(target.item(at))  # type: ignore[arg-type]

    def _fix(self, target: Object, fixed: str) -> None:
        """Nothing may be set from here on."""
        if isinstance(target, Cell | Array):
            target.fixed = fixed
        parts = target.members if isinstance(target, Struct) else target.items if isinstance(target, Array) else {}
        for each in parts.values():
            self._fix(each, fixed)
