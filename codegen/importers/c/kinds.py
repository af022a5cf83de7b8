"""Types of C, and what an interpreter of it holds: numbers, features, conditions, and objects that pointers lead to.

Does: names the arithmetic types with their ranges; reads literals; rounds exact numbers to float and double; values
  with their types; objects and the parts of them; what a function is given, and which features that makes.
Assumes: IEEE binary32 `float`, binary64 `double`, `int` of 32 bits, `long long` of 64; each type evaluated as itself;
  a parameter that is written through is a result, and is not read before.
Does not: take long double. `char` may be signed or not, `long` may have 32 bits or 64: what depends on it is refused.

An array of numbers alone gives features without names. Else each member of a struct, each item of an array and each
other parameter is a feature, in the order of the declarations.
"""

import math
import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import lru_cache
from typing import Any, Final, NamedTuple, TypeAlias

import numpy as np

from codegen.errors import InputError
from codegen.floats import FLOAT32, FLOAT64
from codegen.importers.symbolic.feature import Feature, Step
from codegen.importers.symbolic.memory import RemembersError


@dataclass(frozen=True, eq=False)
class Kind:
    """An arithmetic type. Whole numbers: `low` to `high`; floats: of `bits`."""

    name: str
    bits: int
    rank: int  # of conversions; floats from 10 on
    low: int = 0
    high: int = 0

    @property
    def floating(self) -> bool:
        """True if it is float or double."""
        return self.rank >= 10

    @property
    def signed(self) -> bool:
        """True if it has negative numbers."""
        return self.floating or self.low < 0

    @property
    def float_type(self) -> Any:
        """The NumPy type of a float or double."""
        return np.float32 if self == FLOAT else np.float64

    @property
    def fits_float32(self) -> bool:
        """True if every number of it is a float32."""
        return self == FLOAT if self.floating else max(-self.low, self.high) <= 2**24

    def holds(self, value: Any) -> bool:
        """Returns True if a whole number is one of this type."""
        return self.low <= value <= self.high

    def __str__(self) -> str:
        return self.name


def _whole(name: str, bits: int, rank: int) -> Kind:
    low, high = (0, 2**bits - 1) if name.startswith("unsigned") else (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1)
    return Kind(name, bits, rank, low, high)


VOID, BOOL, CHAR = Kind("void", 8, -1), Kind("_Bool", 8, 0, 0, 1), Kind("char", 8, 1, 0, 127)
SCHAR, UCHAR = _whole("signed char", 8, 1), _whole("unsigned char", 8, 1)
SHORT, USHORT = _whole("short", 16, 2), _whole("unsigned short", 16, 2)
INT, UINT = _whole("int", 32, 3), _whole("unsigned int", 32, 3)
LONG = Kind("long", 64, 4, -(2**31), 2**31 - 1)  # what it holds everywhere
ULONG = Kind("unsigned long", 64, 4, 0, 2**32 - 1)
LLONG, ULLONG = _whole("long long", 64, 5), _whole("unsigned long long", 64, 5)
FLOAT, DOUBLE = Kind("float", 32, 10), Kind("double", 64, 11)
GIVEN = "given as a float"  # the first step of a float that is observed among doubles
ENUM = Kind("enum", 32, 3, 0, 2**31 - 1)  # int or unsigned int, as the compiler likes
UNSIGNED: Final = {INT: UINT, LONG: ULONG, LLONG: ULLONG}
STANDARD: Final[Mapping[str, Kind]] = {  # what headers name
    "bool": BOOL, "size_t": ULONG, "ptrdiff_t": LONG, "intptr_t": LONG, "uintptr_t": ULONG, "float_t": FLOAT,
    "double_t": DOUBLE, "int8_t": SCHAR, "uint8_t": UCHAR, "int16_t": SHORT, "uint16_t": USHORT, "int32_t": INT,
    "uint32_t": UINT, "int64_t": LLONG, "uint64_t": ULLONG, "int_least8_t": SCHAR, "uint_least8_t": UCHAR,
    "int_least16_t": SHORT, "uint_least16_t": USHORT, "int_least32_t": INT, "uint_least32_t": UINT,
    "intmax_t": LLONG, "uintmax_t": ULLONG, "time_t": LLONG, "FILE": CHAR,
}  # fmt: skip


def _spell(names: Iterable[str]) -> str:
    """One spelling of a type that has several, such as `long int` and `signed long`."""
    words = sorted(names)
    return " ".join(each for each in words if each != "int" and (each != "signed" or "char" in words))


KINDS: Final = {
    _spell(each.name.split()): each
    for each in (VOID, BOOL, CHAR, SCHAR, UCHAR, SHORT, USHORT, INT, UINT, LONG, ULONG, LLONG, ULLONG, FLOAT, DOUBLE)
}


def kind_of(names: Iterable[str]) -> Kind | None:
    """The type that words of the language name."""
    return KINDS.get(_spell(names))


@dataclass(frozen=True)
class Pointer:
    """The type of a pointer."""

    to: "Type"
    bits = 64


@dataclass(frozen=True)
class Many:
    """The type of an array; length 0: not known."""

    of: "Type"
    length: int


@dataclass(frozen=True, eq=False)
class Record:
    """The type of a struct: its members, which a later declaration may fill in."""

    tag: str
    members: dict[str, "Type"]


Type: TypeAlias = Kind | Pointer | Many | Record


def size_of(type_: Type) -> tuple[int, int]:
    """The bytes of an object, and what its address is a multiple of."""
    if isinstance(type_, Many):
        size, align = size_of(type_.of)
        return size * type_.length, align
    if isinstance(type_, Record):
        at, most = 0, 1
        for member in type_.members.values():
            size, align = size_of(member)
            at, most = -(-at // align) * align + size, max(most, align)
        return -(-at // most) * most, most
    return type_.bits // 8, type_.bits // 8


@dataclass(frozen=True)
class Number:
    """A number and its type. `name`: what the source calls it."""

    value: Any
    kind: Kind
    name: str = ""


WHOLE_NUMBER = re.compile(r"(0[xX][0-9a-fA-F]+|0[0-7]*|[1-9]\d*)([uU]?(?:l|L|ll|LL)?|(?:l|L|ll|LL)[uU])", re.ASCII)
DECIMAL = re.compile(r"((?:\d+\.\d*|\.\d+|\d+(?=[eE]))(?:[eE][+-]?\d{1,4})?)([fF]?)", re.ASCII)
HEXADECIMAL = re.compile(r"(0[xX][01](?:\.[0-9a-fA-F]{0,13})?[pP][+-]?\d{1,4})([fF]?)")  # so that a double holds it
CHARACTER = re.compile(r"'([ -&(-\[\]-~]|\\[0abfnrtv\\'\"])'")  # of ASCII
ESCAPES = {"0": 0, "a": 7, "b": 8, "t": 9, "n": 10, "v": 11, "f": 12, "r": 13, "\\": 92, "'": 39, '"': 34}
MAX_DIGITS = 1_000


@lru_cache(maxsize=1 << 16)
def literal(text: str) -> Number | None:
    """A literal without its sign; None: it is not understood, or not finite."""
    if len(text) > MAX_DIGITS:
        return None
    if match := CHARACTER.fullmatch(text):
        return Number(ESCAPES[match[1][1]] if len(match[1]) == 2 else ord(match[1]), INT)
    if match := WHOLE_NUMBER.fullmatch(text):
        digits, suffix = match[1], match[2].lower()
        decimal = digits[0] != "0"
        value = int(digits, 10 if decimal else 16 if digits[:2] in ("0x", "0X") else 8)
        kinds = [INT, UINT, LONG, ULONG, LLONG, ULLONG]  # the first that holds it
        if "u" in suffix or decimal:
            kinds = [each for each in kinds if each.signed != ("u" in suffix)]
        rank = INT.rank + suffix.count("l")
        return next((Number(value, kind) for kind in kinds if kind.rank >= rank and kind.holds(value)), None)
    match = DECIMAL.fullmatch(text) or HEXADECIMAL.fullmatch(text)
    if match is None:
        return None
    kind, hexadecimal = FLOAT if match[2] else DOUBLE, match[1][:2].lower() == "0x"
    try:
        near = np.float64(float.fromhex(match[1]) if hexadecimal else match[1])
        middle = int(near.view(np.uint64)) % 2**29 == 2**28  # of two floats: the digits say which is nearer
        if kind == DOUBLE or (not middle and 2.0**-126 <= near < 2.0**127):
            value = kind.float_type(near)
        else:
            value = round_number(Fraction(float(near) if hexadecimal else match[1]), kind)
    except OverflowError:
        return None
    return Number(value, kind) if np.isfinite(value) else None


def round_number(exact: Fraction | int, kind: Kind) -> Any:
    """The nearest number of a floating type, ties to even; infinite beyond the largest."""
    try:
        near = exact.numerator / exact.denominator
    except OverflowError:
        return kind.float_type(math.inf if exact > 0 else -math.inf)
    rest = exact - Fraction(near)
    if kind == FLOAT and rest and not int(np.float64(near).view(np.int64)) & 1:
        near = math.nextafter(near, math.inf if rest > 0 else -math.inf)  # odd, so that it is rounded once
    with np.errstate(over="ignore", under="ignore"):
        return kind.float_type(near)


def truncate_float(v: Any) -> Any:
    """A float without its part behind the point; an infinite one stays."""
    return math.trunc(float(v)) if np.isfinite(v) else float(v)


def quotient(a: Any, b: int) -> Any:
    """Whole numbers divided, towards 0; of what is infinite, or NaN, the sign."""
    if not isinstance(a, int):
        return a if b > 0 else -a
    return abs(a) // abs(b) * (1 if (a < 0) == (b < 0) else -1)


# --- values and objects


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


class Place(NamedTuple):
    """Where an object stands: a parameter, or a variable by its number, and the way from it."""

    base: str | int
    way: tuple[str | int, ...] = ()

    def then(self, step: str | int) -> "Place":
        """A member or an item of it."""
        return Place(self.base, (*self.way, step))


@dataclass(frozen=True)
class Object:
    """The contents of a place, by its type; a struct is its own value. `length`: of the array whose item it is (0: not
    known), None for no item.
    """

    place: Place
    type: Type
    length: int | None = None

    def item(self, at: int) -> "Object | None":
        """The item so many places behind this one; None: there is none."""
        if self.length is None:
            return None if at else self
        (*way, index) = self.place.way
        there = int(index) + at
        if there < 0 or (self.length and there >= self.length):
            return None
        return Object(Place(self.place.base, (*way, there)), self.type, self.length)

    def parts(self) -> "Iterator[Object]":
        """All in it that holds one value, in order."""
        if isinstance(self.type, Record):
            for name, member in self.type.members.items():
                yield from Object(self.place.then(name), member).parts()
        elif isinstance(self.type, Many):
            for at in range(self.type.length):
                yield from Object(self.place.then(at), self.type.of, self.type.length).parts()
        else:
            yield self


@dataclass(frozen=True)
class Reference:
    """A pointer."""

    target: Object


Value: TypeAlias = Number | Symbol | Condition | Text | Reference | Object | None


# --- what a function observes: its parameters, as the numbers of an observation


@dataclass
class Inputs:
    """The parameters of one function, and what was read of them on all paths."""

    parameters: Mapping[str, Type]
    make_error: Callable[[str, str], InputError]
    kept: Sequence[Place] = ()  # what is remembered: the first inputs
    read: dict[Place, int] = field(default_factory=dict[Place, int])  # what was read, by its number
    written: set[str] = field(default_factory=set[str])
    unseen: Collection[Place] = ()  # taken to be set only, until paths show it
    order: list[Place] = field(default_factory=list[Place])  # where each feature stands; afterwards

    def __post_init__(self) -> None:
        self.read = {place: at for at, place in enumerate(self.kept)}
        self.numbers = self.choose_numbers(self.unseen)  # of observations

    def choose_numbers(self, unseen: Collection[Place] = ()) -> str:
        """The numbers that observations are, as far as is known which parameters are set only."""
        return FLOAT32 if all(kind.fits_float32 for kind in self.kinds(unseen)) else FLOAT64

    def given(self, name: str) -> Object | Reference:
        """Returns what a parameter is: an object, or a pointer to one of the caller's."""
        type_ = self.parameters[name]
        to = type_.to if isinstance(type_, Pointer) else None
        if to is None or isinstance(to, Pointer) or to in (VOID, CHAR):
            return Object(Place(name), type_)  # such pointers are read by nobody
        length, of = (to.length, to.of) if isinstance(to, Many) else (0, to)
        return Reference(Object(Place(name, (0,)), of, length))

    def value(self, target: Object) -> Value:
        """Returns what an object of the caller's holds: a feature."""
        place, kind = target.place, target.type
        if not isinstance(kind, Kind):
            raise self.make_error(f"the parameter {place.base} is not a number", "give arrays and structs of numbers")
        if place in self.kept:
            return Symbol(Feature(self.read[place], self._first(kind)), kind)
        if place.base in self.written:
            raise RemembersError(str(place.base))
        if not kind.floating and kind.bits == 64:
            what = f"the feature {_full_name(place)} is of type {kind}, whose large numbers are no float64"
            raise self.make_error(what, "declare it int32_t or uint32_t")
        return Symbol(Feature(self.read.setdefault(place, len(self.read)), self._first(kind)), kind)

    def _first(self, kind: Kind) -> tuple[Step, ...]:
        """Returns the steps that turn the caller's number into one of the parameter's type."""
        if kind.floating:
            return (Step(GIVEN, np.float32),) if self.numbers == FLOAT64 and kind == FLOAT else ()
        low, high = kind.low, kind.high

        def whole(v: Any) -> Any:
            return v if v != v else high if v >= high else low if v <= low else math.ceil(v)

        return (Step(f"whole {kind}", whole),)

    def write(self, target: Place) -> None:
        """An object of the caller's is set, through a pointer."""
        name = str(target.base)
        if target in self.kept or not target.way or not isinstance(self.parameters[name], Pointer):
            return
        if any(place.base == name and place not in self.kept for place in self.read):
            raise RemembersError(name)
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
        read = {place: at for place, at in self.read.items() if place not in self.kept}
        numbers, self.read = read, {place: at for place, at in read.items() if at in used}
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
        parts = Object(Place(name), _behind(type_, max(read, default=-1) + 1)).parts()
        yield from (part.place for part in parts if not self._is_kept(part.place))

    def _is_kept(self, place: Place) -> bool:
        """Returns True if a part of a parameter, without the place in an array of one struct, is remembered."""
        return place in self.kept or Place(place.base, (0, *place.way)) in self.kept

    def whole(self) -> tuple[tuple[int, int], ...]:
        """The range of each feature, where all are whole numbers and not only truth values; else ()."""
        kinds = self.kinds()
        if any(kind.floating for kind in kinds) or all(kind == BOOL for kind in kinds):
            return ()
        return tuple((kind.low, kind.high) for kind in map(self._kind_at, self.order))

    def _kind_at(self, place: Place) -> Kind:
        type_ = _behind(self.parameters[str(place.base)], 1)
        for step in place.way:
            assert isinstance(type_, Record | Many), "a part of something"
            type_ = type_.members[str(step)] if isinstance(type_, Record) else type_.of
        assert isinstance(type_, Kind), "a number"
        return type_

    def kinds(self, unseen: Collection[Place] = ()) -> list[Kind]:
        """The types of all numbers that may be observed, but for those that are `unseen`."""
        given = {name: _behind(type_, 1) for name, type_ in self.parameters.items() if name not in self.written}
        parts = (part for name, each in given.items() for part in Object(Place(name), each).parts())
        types = [part.type for part in parts if not self._is_kept(part.place) and part.place not in unseen]
        return [each for each in types if isinstance(each, Kind) and each != VOID]


def _behind(type_: Type, count: int) -> Type:
    """The type of what a parameter holds, or points to. `count`: of items, where nothing else says it."""
    if isinstance(type_, Pointer):
        type_ = type_.to if isinstance(type_.to, Record | Many) else Many(type_.to, 0)
    return Many(type_.of, count) if isinstance(type_, Many) and not type_.length else type_


def _full_name(place: Place) -> str:
    return "_".join(map(str, (place.base, *place.way)))
