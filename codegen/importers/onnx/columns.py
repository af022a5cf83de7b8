"""Operators of ONNX before a tree: columns that each follow from one number of the observation.

Does: follows columns through scalers, sums, products and comparisons with constants, casts, clipping and selections.
Assumes: arithmetic as ONNX says it: each operator rounds to its own type.
Does not: take an operator that mixes columns, or one that may both rise and fall; InputError names the node.

A column remembers whether it rises or falls with its number, and how it is computed. fitted.py needs no more.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final, NamedTuple, TypeAlias, cast

import numpy as np

from codegen.errors import InputError
from codegen.ir import Float32

FLOAT, DOUBLE, TRUTH = "FLOAT", "DOUBLE", "BOOL"
TYPES: Final = {FLOAT: np.float32, DOUBLE: np.float64}
MAX_COLUMNS = 1 << 16
MAX_STEPS = 256
ML, MAIN = "ai.onnx.ml", ""
ADVICE = "use operators that work on each feature by itself, such as scalers and selections, or give the tree alone"
Step: TypeAlias = Callable[[Any], Any]


class Column(NamedTuple):
    """A column that one number of the observation decides."""

    source: int  # that number's place
    rising: bool = True  # whether it never falls where that number rises; else it never rises
    kind: str = FLOAT
    steps: tuple[Step, ...] = ()
    nan: bool = True  # whether it is known what becomes of a NaN

    def values(self, numbers: Float32) -> Any:
        """The column where the observation has these numbers."""
        column: Any = numbers
        with np.errstate(all="ignore"):
            for step in self.steps:
                column = step(column)
        return column

    def after(self, step: Step, *, kind: str = "", turned: bool = False) -> "Column":
        """The column after one more step; `turned`: one that never rises."""
        return self._replace(steps=(*self.steps, step), kind=kind or self.kind, rising=self.rising != turned)


Columns: TypeAlias = tuple[Column, ...]
Value: TypeAlias = Columns | np.ndarray  # columns of the observation, or a constant


class Call(NamedTuple):
    """A node of the graph: its attributes, and what it is given."""

    node: str  # for a person
    attributes: Mapping[str, Any]
    given: Sequence[Value | None]  # None: an input that is left out

    def make_error(self, what: str) -> InputError:
        """Why the node is not understood."""
        return InputError(what, self.node, ADVICE)

    def columns(self, place: int = 0) -> Columns:
        """An input that is columns."""
        columns = self.given[place] if place < len(self.given) else None
        if not isinstance(columns, tuple):
            raise self.make_error("a node works on constants alone")
        return columns

    def constant(self, place: int) -> np.ndarray:
        """An input that is a constant."""
        constant = self.given[place] if place < len(self.given) else None
        if not isinstance(constant, np.ndarray):
            raise self.make_error("a node mixes columns of the observation")
        return constant

    def places(self, place: int) -> list[int]:
        """An input that is a list of whole numbers."""
        numbers = self.constant(place)
        if numbers.ndim != 1 or numbers.dtype.kind != "i":
            raise self.make_error("a node needs a list of whole numbers")
        return [int(each) for each in numbers.tolist()]

    def of_kind(self, *kinds: str) -> Columns:
        """The first input, of one of these types."""
        columns = self.columns()
        if any(each.kind not in kinds for each in columns):
            raise self.make_error(f"a node works on {columns[0].kind}")
        return columns

    def each(self, numbers: Any, kind: str, columns: Sequence[Column]) -> list[Any]:
        """A number of this type for each column. InputError for numbers that are not finite, or do not fit."""
        numbers = np.asarray(numbers)
        flat = numbers.reshape(-1)
        if numbers.size not in (1, len(columns)) or numbers.shape[-1:] not in ((), (1,), (numbers.size,)):
            raise self.make_error(f"a constant of the shape {list(numbers.shape)} is no number for each column")
        if kind not in TYPES or flat.dtype != TYPES[kind] or not np.isfinite(flat).all():
            raise self.make_error(f"a constant is not finite, or no {kind}")
        return [flat[place % len(flat)] for place in range(len(columns))]


# --- arithmetic


def _scaler(call: Call) -> Columns:
    columns = call.of_kind(FLOAT)
    offsets, factors = (np.array(call.attributes.get(name, ()), dtype=np.float32) for name in ("offset", "scale"))
    pairs = zip(call.each(offsets, FLOAT, columns), _factors(call, factors, FLOAT, columns), strict=True)
    return tuple(
        column.after(lambda x, o=offset, f=factor: (x - o) * f, turned=factor < 0)
        for column, (offset, factor) in zip(columns, pairs, strict=True)
    )


def _factors(call: Call, numbers: Any, kind: str, columns: Columns) -> list[Any]:
    found = call.each(numbers, kind, columns)
    if not all(found):
        raise call.make_error("a factor is 0")
    return found


def _make_operator(
    compute: Callable[[Any, Any], Any], falls: Callable[[Any, bool], bool], *, kind: str = "", factors: bool = False
) -> Callable[[Call], Columns]:
    """An operator of columns and a constant. `falls`: whether a column never rises, by its number and whether that
    stands first; `kind`: of what it makes, where that is another one; `factors`: whether no number may be 0.
    """

    def apply_to(call: Call) -> Columns:
        if len(call.given) != 2:
            raise call.make_error(f"a node has {len(call.given)} inputs, two are understood")
        first = isinstance(call.given[0], np.ndarray)
        columns, constant = call.columns(int(first)), call.constant(int(not first))
        if columns[0].kind not in TYPES:
            raise call.make_error(f"a node works on {columns[0].kind}")
        if constant.ndim > 2 or (constant.ndim == 2 and len(constant) != 1):
            raise call.make_error(f"a constant has the shape {list(constant.shape)}")
        numbers = (_factors if factors else Call.each)(call, constant, columns[0].kind, columns)
        return tuple(
            column.after(
                (lambda x, c=number: compute(c, x)) if first else (lambda x, c=number: compute(x, c)),
                kind=kind,
                turned=falls(number, first),
            )
            for column, number in zip(columns, numbers, strict=True)
        )

    return apply_to


def _div(call: Call) -> Columns:
    if isinstance(call.given[0], np.ndarray):
        raise call.make_error("a number is divided by a column, which neither rises nor falls throughout")
    return _make_operator(np.divide, lambda number, first: number < 0, factors=True)(call)


def _neg(call: Call) -> Columns:
    return tuple(column.after(lambda x: -x, turned=True) for column in call.of_kind(*TYPES))


def _clip(call: Call) -> Columns:
    columns = call.of_kind(*TYPES)
    kind, steps = columns[0].kind, list[Step]()
    cuts: list[tuple[int, str, Any]] = [(1, "min", np.maximum), (2, "max", np.minimum)]
    for place, name, cut in cuts:
        if name in call.attributes:
            bound: Any = np.array(call.attributes[name], dtype=TYPES[kind])
        elif place < len(call.given) and call.given[place] is not None:
            bound = call.constant(place)
        else:
            continue
        if bound.ndim:
            raise call.make_error(f"a bound has the shape {list(bound.shape)}")
        number = call.each(bound, kind, columns)[0]
        steps.append(lambda x, c=cut, n=number: c(x, n))
    # runtimes differ in what becomes of a NaN
    return tuple(each._replace(steps=(*each.steps, *steps), nan=False) for each in columns)


def _imputer(call: Call) -> Columns:
    columns = call.of_kind(FLOAT)
    if not np.isnan(call.attributes.get("replaced_value_float", 0.0)) or "imputed_value_int64s" in call.attributes:
        raise call.make_error("a node replaces a number that may be observed, not only NaN")
    values = np.array(call.attributes.get("imputed_value_floats", ()), dtype=np.float32)
    pairs = zip(columns, call.each(values, FLOAT, columns), strict=True)
    return tuple(column.after(lambda x, v=value: cast("Any", np.where(np.isnan(x), v, x))) for column, value in pairs)


# --- types and comparisons


def _cast(call: Call) -> Columns:
    to, columns = call.attributes["to"], call.columns()
    if to not in TYPES:
        raise call.make_error(f"a Cast makes {to} of the observation")
    return tuple(each.after(lambda x: x.astype(TYPES[to]), kind=to) for each in columns)


def _binarizer(call: Call) -> Columns:
    threshold = np.array(call.attributes.get("threshold", 0.0), dtype=np.float32)
    columns = call.of_kind(FLOAT)
    pairs = zip(columns, call.each(threshold, FLOAT, columns), strict=True)
    # onnxruntime takes no NaN here
    return tuple(
        column.after(lambda x, t=number: (x > t).astype(np.float32))._replace(nan=False) for column, number in pairs
    )


def _not(call: Call) -> Columns:
    return tuple(each.after(np.logical_not, turned=True) for each in call.of_kind(TRUTH))


# --- selections


def _same(call: Call) -> Columns:
    if len(call.given) != 1:
        raise call.make_error(f"a node has {len(call.given)} inputs, one is understood")
    return call.columns()


def _flatten(call: Call) -> Columns:
    if call.attributes.get("axis", 1) != 1:
        raise call.make_error("a node changes what is an observation")
    return call.columns()


def _reshape(call: Call) -> Columns:
    columns, shape = call.columns(), call.places(1)
    fits = len(shape) == 2 and shape[0] in (0, -1) and shape[1] in (len(columns), -1, 0)
    if not fits or shape == [-1, -1] or call.attributes.get("allowzero", 0):
        raise call.make_error("a node changes what is an observation")
    return columns


def _along_columns(call: Call, default: int | None = None) -> None:
    if call.attributes.get("axis", default) not in (1, -1):
        raise call.make_error("a node does not work along the columns")


def _pick_columns(call: Call, places: Sequence[int]) -> Columns:
    columns = call.columns()
    if any(not 0 <= each < len(columns) for each in places):
        raise call.make_error(f"a node picks columns that there are not, of {len(columns)}")
    return tuple(columns[each] for each in places)


def _extract_columns(call: Call) -> Columns:
    places = call.constant(1)
    if places.dtype.kind != "i":
        raise call.make_error("a node needs a list of whole numbers")
    return _pick_columns(call, [int(each) for each in places.reshape(-1).tolist()])


def _gather(call: Call) -> Columns:
    _along_columns(call, 0)
    return _pick_columns(call, [place + len(call.columns()) * (place < 0) for place in call.places(1)])


def _slice(call: Call) -> Columns:
    named: list[list[int] | None] = [call.attributes.get(name) for name in ("starts", "ends", "axes")]
    if not call.attributes:
        named = [call.places(place) if len(call.given) > place else None for place in (1, 2, 3)]
    steps = call.places(4) if len(call.given) > 4 else [1]
    if named[2] not in ([1], [-1]) or any(each is None or len(each) != 1 for each in (*named, steps)) or steps[0] < 1:
        raise call.make_error("a node does not select columns in their order")
    start, end = (int(each[0]) for each in named[:2] if each)
    return call.columns()[start : end : steps[0]]


def _concat(call: Call) -> Columns:
    _along_columns(call)
    parts = [call.columns(place) for place in range(len(call.given))]
    if len({column.kind for part in parts for column in part}) != 1:
        raise call.make_error("a node joins columns of several types")
    if sum(map(len, parts)) > MAX_COLUMNS:
        raise call.make_error(f"a node makes more than {MAX_COLUMNS} columns")
    return tuple(column for part in parts for column in part)


OPERATORS: dict[tuple[str, str], tuple[frozenset[str], Callable[[Call], Columns]]] = {  # with their attributes
    (ML, "Scaler"): (frozenset({"offset", "scale"}), _scaler),
    (ML, "Imputer"): (
        frozenset({"imputed_value_floats", "replaced_value_float", "imputed_value_int64s", "replaced_value_int64"}),
        _imputer,
    ),
    (ML, "Binarizer"): (frozenset({"threshold"}), _binarizer),
    (ML, "ArrayFeatureExtractor"): (frozenset(), _extract_columns),
    (MAIN, "Add"): (frozenset(), _make_operator(np.add, lambda number, first: False)),
    (MAIN, "Sub"): (frozenset(), _make_operator(np.subtract, lambda number, first: first)),
    (MAIN, "Mul"): (frozenset(), _make_operator(np.multiply, lambda number, first: number < 0, factors=True)),
    (MAIN, "Div"): (frozenset(), _div),
    (MAIN, "Neg"): (frozenset(), _neg),
    (MAIN, "Clip"): (frozenset({"min", "max"}), _clip),
    (MAIN, "Cast"): (frozenset({"to", "saturate", "round_mode"}), _cast),
    (MAIN, "Greater"): (frozenset(), _make_operator(np.greater, lambda number, first: first, kind=TRUTH)),
    (MAIN, "GreaterOrEqual"): (frozenset(), _make_operator(np.greater_equal, lambda number, first: first, kind=TRUTH)),
    (MAIN, "Less"): (frozenset(), _make_operator(np.less, lambda number, first: not first, kind=TRUTH)),
    (MAIN, "LessOrEqual"): (frozenset(), _make_operator(np.less_equal, lambda number, first: not first, kind=TRUTH)),
    (MAIN, "Not"): (frozenset(), _not),
    (MAIN, "Identity"): (frozenset(), _same),
    (MAIN, "Flatten"): (frozenset({"axis"}), _flatten),
    (MAIN, "Reshape"): (frozenset({"allowzero"}), _reshape),
    (MAIN, "Gather"): (frozenset({"axis"}), _gather),
    (MAIN, "Slice"): (frozenset({"starts", "ends", "axes"}), _slice),
    (MAIN, "Concat"): (frozenset({"axis"}), _concat),
}


def apply_operator(operator: tuple[str, str], call: Call) -> Columns:
    """The columns that an operator of OPERATORS makes. InputError for what it may not do here."""
    known, run = OPERATORS[operator]
    for name in sorted(call.attributes.keys() - known):
        raise call.make_error(f"a node has the attribute {name!r}, which is not understood")
    columns = run(call)
    if not columns:
        raise call.make_error("a node makes no columns")
    if len(columns) > MAX_COLUMNS or len(columns[0].steps) > MAX_STEPS:
        raise call.make_error(f"there are more than {MAX_COLUMNS} columns, or {MAX_STEPS} operators before the tree")
    return columns
