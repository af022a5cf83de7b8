"""What a function of C is given, and which features that makes.

Does: makes an object of each parameter; numbers what is read of them in the order of its reading; afterwards says the
  place and the name of each feature.
Assumes: a parameter that is written through is a result, and is not read before.
Does not: read a syntax tree.

An array of numbers alone gives features without names. Else each member of a struct, each item of an array and each
other parameter is a feature, in the order of the declarations.
"""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from codegen.errors import InputError
from codegen.importers.c.kinds import CHAR, FLOAT, GIVEN, Kind, Many, Pointer, Record, Type, Void
from codegen.importers.c.values import Array, Cell, Object, Origin, Reference, Symbol, Value, cells, make_object
from codegen.importers.symbolic.feature import Feature, Step
from codegen.importers.symbolic.paths import STATE_ADVICE


@dataclass
class Inputs:
    """The parameters of one function, and what was read of them on all paths."""

    parameters: Mapping[str, Type]
    wide: bool  # whether observations are doubles
    make_error: Callable[[str, str], InputError]
    read: dict[Origin, int] = field(default_factory=dict[Origin, int])  # what was read, by its number
    written: set[str] = field(default_factory=set[str])
    objects: dict[str, Object] = field(default_factory=dict[str, Object])  # of the present path
    order: list[Origin] = field(default_factory=list[Origin])  # where each feature stands; afterwards

    def bind_parameters(self) -> dict[str, Object]:
        """A variable for each parameter, fresh for each path."""
        self.objects = {}
        variables: dict[str, Object] = {}
        for name, type_ in self.parameters.items():
            origin = Origin(name)
            if not isinstance(type_, Pointer):
                variables[name] = make_object(type_, origin)
                continue
            to = type_.to
            if isinstance(to, Void | Pointer) or to == CHAR:
                variables[name] = Cell(type_, None, origin)  # read by nobody
                continue
            length = to.length if isinstance(to, Many) else 0
            of = to.of if isinstance(to, Many) else to
            self.objects[name] = Array(Many(of, length), {}, origin)
            variables[name] = Cell(type_, Reference(self.objects[name]))
        return variables

    def value(self, cell: Cell) -> Value:
        """What a cell of the caller's holds: a feature."""
        origin, kind = cell.origin, cell.type
        assert origin is not None
        if not isinstance(kind, Kind):
            what = f"the parameter {origin.parameter} is not a number"
            raise self.make_error(what, "give arrays and structs of numbers")
        if origin.parameter in self.written:
            raise self.make_error(f"{origin.parameter} is read and written: what it held decides", STATE_ADVICE)
        if not kind.floating and kind.bits == 64:
            what = f"the feature {'_'.join(map(str, (origin.parameter, *origin.way)))} is of type {kind}"
            raise self.make_error(f"{what}, whose large numbers are no float64", "declare it int32_t or uint32_t")
        at = self.read.setdefault(origin, len(self.read))
        return Symbol(Feature(at, self._first(kind)), kind)

    def _first(self, kind: Kind) -> tuple[Step, ...]:
        """How the caller's number becomes one of the parameter's type."""
        if kind.floating:
            return (Step(GIVEN, np.float32),) if self.wide and kind == FLOAT else ()
        low, high = kind.low, kind.high

        def whole(v: Any) -> Any:
            return v if v != v else high if v >= high else low if v <= low else math.ceil(v)

        return (Step(f"whole {kind}", whole),)

    def write(self, cell: Cell) -> None:
        """A cell of the caller's is set, through a pointer."""
        if cell.origin is None or not isinstance(self.parameters[cell.origin.parameter], Pointer):
            return
        name = cell.origin.parameter
        if any(origin.parameter == name for origin in self.read):
            raise self.make_error(f"{name} is read and written: what it held decides", STATE_ADVICE)
        self.written.add(name)

    def results(self) -> list[Cell]:
        """What was written to on this path, of one result."""
        held = {name: list(cells(self.objects[name])) for name in self.objects if name in self.written}
        if len(held) > 1:
            raise self.make_error(f"results are written to {' and '.join(held)}", "write to one of them")
        for name, each in held.items():
            to = self.parameters[name].to  # type: ignore[union-attr]
            if any(cell.value is None for cell in each) or (isinstance(to, Many) and to.length != len(each)):
                raise self.make_error(f"a part of {name} is not set on some path", "set all of it on every path")
        return [cell for each in held.values() for cell in each]

    # --- afterwards

    def features(self, used: set[int]) -> tuple[list[int], tuple[str, ...], int]:
        """The place of each input that was read (-1: no test looks at it), the features' names, and how many there are
        (0: not known). `used`: the inputs that tests look at.
        """
        numbers, self.read = self.read, {origin: at for origin, at in self.read.items() if at in used}
        whole = [name for name in self.parameters if self._is_whole(name)]
        looked = [origin.parameter for origin in self.read]
        given = [name for name in self.parameters if name in whole or (not whole or name in looked)]
        given = [name for name in given if name not in self.written and name in looked + whole + self._scalars()]
        alone = self._numbers(given[0]) if len(given) == 1 else None
        if alone is not None:
            places = [int(each.way[0]) if each in self.read else -1 for each in numbers]
            self.order = [Origin(given[0], (at,)) for at in range(alone or max(places, default=-1) + 1)]
            return places, (), alone
        self.order = order = [origin for name in given for origin in self._parts(name)]
        place = {origin: at for at, origin in enumerate(order)}
        names = ["_".join(map(str, each.way)) or each.parameter for each in order]
        shared = len(set(names)) < len(names)
        full = ["_".join(map(str, (each.parameter, *each.way))) for each in order]
        numbered = [not each.way or isinstance(each.way[0], int) for each in order]
        chosen = [long if shared or at else short for short, long, at in zip(names, full, numbered, strict=True)]
        places = [place[self._strip_place(each)] if each in self.read else -1 for each in numbers]
        return places, tuple(chosen), len(order)

    def _scalars(self) -> list[str]:
        return [name for name, type_ in self.parameters.items() if isinstance(type_, Kind)]

    def _is_whole(self, name: str) -> bool:
        """Whether a parameter is an observation of several numbers."""
        type_ = self.parameters[name]
        used = any(origin.parameter == name for origin in self.read)
        return isinstance(type_, Pointer | Record) and name not in self.written and (used or isinstance(type_, Record))

    def _numbers(self, name: str) -> int | None:
        """The length of an array of numbers, 0 where it is not declared; None: it is none."""
        type_ = self.parameters[name]
        to = type_.to if isinstance(type_, Pointer) else None
        if isinstance(to, Kind):
            return 0
        return to.length if isinstance(to, Many) and isinstance(to.of, Kind) else None

    def _strip_place(self, origin: Origin) -> Origin:
        """Where it stands, without the place in an array of one struct."""
        type_ = self.parameters[origin.parameter]
        single = isinstance(type_, Pointer) and isinstance(type_.to, Record)
        return Origin(origin.parameter, origin.way[1:]) if single else origin

    def _parts(self, name: str) -> Iterator[Origin]:
        """All numbers of a parameter, in order."""
        type_ = self.parameters[name]
        if not isinstance(type_, Pointer):
            yield from parts_of(type_, Origin(name))
            return
        to = type_.to
        if isinstance(to, Record):
            if any(origin.parameter == name and origin.way[0] != 0 for origin in self.read):
                raise self.make_error(f"{name} is read as an array of structs of no length", "declare its length")
            yield from parts_of(to, Origin(name))
            return
        length = to.length if isinstance(to, Many) else 0
        read = [int(origin.way[0]) for origin in self.read if origin.parameter == name]
        for at in range(length or max(read, default=-1) + 1):
            yield from parts_of(to.of if isinstance(to, Many) else to, Origin(name, (at,)))

    def kinds(self) -> list[Kind]:
        """The types of all numbers that may be observed."""
        return [kind for name in self.parameters if name not in self.written for kind in _kinds(self.parameters[name])]


def _kinds(type_: Type) -> Iterator[Kind]:
    if isinstance(type_, Kind):
        yield type_
    elif isinstance(type_, Pointer):
        yield from _kinds(type_.to)
    elif isinstance(type_, Many):
        yield from _kinds(type_.of)
    elif isinstance(type_, Record):
        for member in type_.members.values():
            yield from _kinds(member)


def parts_of(type_: Type, origin: Origin) -> Iterator[Origin]:
    """Where each number of an object stands, in order."""
    if isinstance(type_, Record):
        for name, member in type_.members.items():
            yield from parts_of(member, origin.then(name))
    elif isinstance(type_, Many):
        for at in range(type_.length):
            yield from parts_of(type_.of, origin.then(at))
    else:
        yield origin
