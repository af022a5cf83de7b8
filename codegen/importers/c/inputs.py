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
from codegen.floats import FLOAT32, FLOAT64
from codegen.importers.c import kinds
from codegen.importers.c.kinds import Kind, Many, Object, Place, Pointer, Record, Reference, Symbol, Type, Value
from codegen.importers.symbolic.feature import Feature, Step
from codegen.importers.symbolic.paths import STATE_ADVICE


@dataclass
class Inputs:
    """The parameters of one function, and what was read of them on all paths."""

    parameters: Mapping[str, Type]
    make_error: Callable[[str, str], InputError]
    read: dict[Place, int] = field(default_factory=dict[Place, int])  # what was read, by its number
    written: set[str] = field(default_factory=set[str])
    order: list[Place] = field(default_factory=list[Place])  # where each feature stands; afterwards

    def __post_init__(self) -> None:
        self.numbers = FLOAT32 if all(kind.fits_float32 for kind in self.kinds()) else FLOAT64  # of observations

    def given(self, name: str) -> Object | Reference:
        """Returns what a parameter is: an object, or a pointer to one of the caller's."""
        type_ = self.parameters[name]
        to = type_.to if isinstance(type_, Pointer) else None
        if to is None or isinstance(to, Pointer) or to in (kinds.VOID, kinds.CHAR):
            return Object(Place(name), type_)  # such pointers are read by nobody
        length, of = (to.length, to.of) if isinstance(to, Many) else (0, to)
        return Reference(Object(Place(name, (0,)), of, length))

    def value(self, target: Object) -> Value:
        """Returns what an object of the caller's holds: a feature."""
        place, kind = target.place, target.type
        if not isinstance(kind, Kind):
            raise self.make_error(f"the parameter {place.base} is not a number", "give arrays and structs of numbers")
        if place.base in self.written:
            raise self.make_error(f"{place.base} is read and written: what it held decides", STATE_ADVICE)
        if not kind.floating and kind.bits == 64:
            what = f"the feature {_full_name(place)} is of type {kind}, whose large numbers are no float64"
            raise self.make_error(what, "declare it int32_t or uint32_t")
        return Symbol(Feature(self.read.setdefault(place, len(self.read)), self._first(kind)), kind)

    def _first(self, kind: Kind) -> tuple[Step, ...]:
        """Returns the steps that turn the caller's number into one of the parameter's type."""
        if kind.floating:
            return (Step(kinds.GIVEN, np.float32),) if self.numbers == FLOAT64 and kind == kinds.FLOAT else ()
        low, high = kind.low, kind.high

        def whole(v: Any) -> Any:
            return v if v != v else high if v >= high else low if v <= low else math.ceil(v)

        return (Step(f"whole {kind}", whole),)

    def write(self, target: Place) -> None:
        """An object of the caller's is set, through a pointer."""
        name = str(target.base)
        if not target.way or not isinstance(self.parameters[name], Pointer):
            return
        if any(place.base == name for place in self.read):
            raise self.make_error(f"{name} is read and written: what it held decides", STATE_ADVICE)
        self.written.add(name)

    def results(self, memory: Mapping[Place, Value]) -> list[Object]:
        """Lists the objects of the one result that were written to on this path."""
        found = [place for place in memory if place.base in self.written]
        names = sorted({str(place.base) for place in found})
        if not names:
            return []
        if len(names) > 1:
            raise self.make_error(f"results are written to {' and '.join(names)}", "write to one of them")
        type_ = self.parameters[names[0]]
        assert isinstance(type_, Pointer)
        to = type_.to
        if not isinstance(to, Many):  # as many items as were set
            items = sorted({int(place.way[0]) for place in found})
            parts = [part for at in items for part in Object(Place(names[0], (at,)), to).parts()]
        else:
            parts = list(Object(Place(names[0]), to if to.length else Many(to.of, len(found))).parts())
        if any(part.place not in memory for part in parts):
            raise self.make_error(f"a part of {names[0]} is not set on some path", "set all of it on every path")
        return parts

    # --- afterwards

    def features(self, used: set[int]) -> tuple[list[int], tuple[str, ...], int]:
        """The place of each input that was read (-1: no test looks at it), the features' names, and how many there are
        (0: not known). `used`: the inputs that tests look at.
        """
        numbers, self.read = self.read, {place: at for place, at in self.read.items() if at in used}
        looked = {place.base for place in self.read}
        unwritten = [name for name in self.parameters if name not in self.written]
        whole = [
            name for name in unwritten
            if isinstance(self.parameters[name], Record)
            or (isinstance(self.parameters[name], Pointer) and name in looked)
        ]  # fmt: skip
        given = [
            name for name in unwritten
            if name in whole or name in looked or (not whole and isinstance(self.parameters[name], Kind))
        ]  # fmt: skip
        type_ = self.parameters[given[0]] if len(given) == 1 else None
        to = type_.to if isinstance(type_, Pointer) else None
        length = 0 if isinstance(to, Kind) else to.length if isinstance(to, Many) and isinstance(to.of, Kind) else None
        if length is not None:
            places = [int(each.way[0]) if each in self.read else -1 for each in numbers]
            self.order = [Place(given[0], (at,)) for at in range(length or max(places, default=-1) + 1)]
            return places, (), length
        self.order = [place for name in given for place in self._parts(name)]
        names = ["_".join(map(str, each.way)) or str(each.base) for each in self.order]
        shared = len(set(names)) < len(names)
        chosen = [
            _full_name(each) if shared or isinstance(each.way[0] if each.way else 0, int) else name
            for name, each in zip(names, self.order, strict=True)
        ]
        at = {place: at for at, place in enumerate(self.order)}
        return [at[self._strip_place(each)] if each in self.read else -1 for each in numbers], tuple(chosen), len(at)

    def _strip_place(self, place: Place) -> Place:
        """Where it stands, without the place in an array of one struct."""
        type_ = self.parameters[str(place.base)]
        single = isinstance(type_, Pointer) and isinstance(type_.to, Record)
        return Place(place.base, place.way[1:]) if single else place

    def _parts(self, name: str) -> Iterator[Place]:
        """All numbers of a parameter, in order."""
        type_ = self.parameters[name]
        read = [int(each.way[0]) for each in self.read if each.base == name] if isinstance(type_, Pointer) else []
        if isinstance(type_, Pointer) and isinstance(type_.to, Record) and any(read):
            raise self.make_error(f"{name} is read as an array of structs of no length", "declare its length")
        yield from (part.place for part in Object(Place(name), _behind(type_, max(read, default=-1) + 1)).parts())

    def kinds(self) -> list[Kind]:
        """The types of all numbers that may be observed."""
        given = [_behind(type_, 1) for name, type_ in self.parameters.items() if name not in self.written]
        parts = (part.type for each in given for part in Object(Place(""), each).parts())
        return [each for each in parts if isinstance(each, Kind) and each != kinds.VOID]


def _behind(type_: Type, count: int) -> Type:
    """The type of what a parameter holds, or points to. `count`: of items, where nothing else says it."""
    if isinstance(type_, Pointer):
        type_ = type_.to if isinstance(type_.to, Record | Many) else Many(type_.to, 0)
    return Many(type_.of, count) if isinstance(type_, Many) and not type_.length else type_


def _full_name(place: Place) -> str:
    return "_".join(map(str, (place.base, *place.way)))
