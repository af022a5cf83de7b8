"""What an interpreter of C holds: numbers, features, conditions, and the objects that pointers lead to.

Does: values with their types; objects that are read, set and copied; inputs that become features once they are read.
Assumes: an object of a decision lives as long as its path.
Does not: compute (arithmetic.py), or read a syntax tree.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

from codegen.importers.c.kinds import Kind, Many, Number, Record, Type
from codegen.importers.symbolic.feature import Feature


class Outside(BaseException):
    """The path ends, no error: the program takes no such observation, as an assertion fails or a number overflows."""


@dataclass(frozen=True)
class Symbol:
    """A number that is computed of an input, and its type."""

    feature: Feature
    kind: Kind


@dataclass(frozen=True)
class Condition:
    """A truth value that is asked for where it decides."""

    holds: Callable[[], bool]


@dataclass(frozen=True)
class Text:
    """A text."""

    text: str


@dataclass(frozen=True)
class Function:
    """A function of the file."""

    node: Any


@dataclass(frozen=True)
class Reference:
    """A pointer to an item of an array, or to an object of its own (`at` 0)."""

    target: "Object"
    at: int = 0


@dataclass(frozen=True)
class Origin:
    """Where an object stands that the caller hands over: a parameter, and the way from it."""

    parameter: str
    way: tuple[str | int, ...] = ()

    def then(self, step: str | int) -> "Origin":
        """A member or an item of it."""
        return Origin(self.parameter, (*self.way, step))


@dataclass
class Cell:
    """An object that holds one value."""

    type: Type
    value: "Value" = None
    origin: Origin | None = None  # the caller's, until it is set
    fixed: str = ""  # why it must not be set


@dataclass
class Array:
    """Items of one type. `length` 0: as many as are asked for."""

    type: Many
    items: dict[int, "Object"] = field(default_factory=dict[int, "Object"])
    origin: Origin | None = None
    fixed: str = ""

    def item(self, at: int) -> "Object | None":
        """The item at a place; None: there is none."""
        if at < 0 or (self.type.length and at >= self.type.length):
            return None
        if at not in self.items:
            self.items[at] = make_object(self.type.of, self.origin.then(at) if self.origin else None, self.fixed)
        return self.items[at]


@dataclass
class Struct:
    """Members by name."""

    type: Record
    members: dict[str, "Object"]


Object: TypeAlias = Cell | Array | Struct
Value: TypeAlias = Number | Symbol | Condition | Text | Function | Reference | Struct | None


def make_object(type_: Type, origin: Origin | None = None, fixed: str = "") -> Object:
    """An object without a value; with an `origin`, one whose values come from the caller."""
    if isinstance(type_, Many):
        return Array(type_, {}, origin, fixed)
    if isinstance(type_, Record):
        each = type_.members.items()
        return Struct(type_, {name: make_object(of, origin.then(name) if origin else None, fixed) for name, of in each})
    return Cell(type_, None, origin, fixed)


def copy_objects(objects: Sequence[Any]) -> list[Any]:
    """Objects with all that they hold, so that setting the copies sets nothing else; other things stay themselves.
    Pointers from one of them to another lead to its copy.
    """
    copies, pointing = dict[int, Any](), list[Cell]()

    def copy_object(each: Any) -> Any:
        if isinstance(each, Cell):
            made: Any = Cell(each.type, each.value, each.origin, each.fixed)
            if isinstance(each.value, Reference):
                pointing.append(made)
        elif isinstance(each, Array):
            made = Array(each.type, {at: copy_object(item) for at, item in each.items.items()}, each.origin, each.fixed)
        elif isinstance(each, Struct):
            made = Struct(each.type, {name: copy_object(member) for name, member in each.members.items()})
        else:
            return each
        copies[id(each)] = made
        return made

    made = [copy_object(each) for each in objects]
    for cell in pointing:
        assert isinstance(cell.value, Reference)
        cell.value = Reference(copies.get(id(cell.value.target), cell.value.target), cell.value.at)
    return made


def cells(target: Object) -> Iterator[Cell]:
    """All cells of an object that were made, in order."""
    if isinstance(target, Cell):
        yield target
    else:
        parts = target.members if isinstance(target, Struct) else dict(sorted(target.items.items()))
        for part in parts.values():
            yield from cells(part)
