"""An interpreter of Python's syntax trees whose values may be features: its state, and what all parts of it ask.

Does: evaluates nodes by the handlers that expressions.py and statements.py register; truth, numbers, calls.
Assumes: a syntax tree that Python accepts.
Does not: run Python code, import a module, or touch anything outside the syntax tree.

A feature is computed with only by steps that symbolic/feature.py can turn into a threshold. What cannot be said
exactly is `Unread`, and an error only where a decision needs it. Everything is counted: a file that does not end is
refused.
"""

# pyright: basic
# the values of a program may be anything
import ast
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from codegen.errors import InputError, escape_text
from codegen.floats import FLOAT64
from codegen.importers.python.inputs import Inputs
from codegen.importers.python.values import (
    Array,
    Bound,
    Class,
    Condition,
    Extreme,
    Function,
    Instance,
    Length,
    Member,
    Module,
    Part,
    Scope,
    Symbol,
    Unread,
)
from codegen.importers.symbolic.affine import Sums
from codegen.importers.symbolic.feature import Feature, Step, Test
from codegen.importers.symbolic.paths import MANY_PATHS, MAX_CALLS, MAX_STEPS, STATE_ADVICE, Paths

MAX_ITEMS = 1 << 16  # of a list, a text or a dictionary
MAX_SHOWN = 60
MAX_INDEX = 256  # values of a whole number that is used as an index
TEST_ADVICE = "compare one feature with a number; give a sum or a difference as a feature of its own"
RETURN_ADVICE = "return a number, a text, a name or a list of numbers"
UNCOUNTED = "the file does not say how many features there are", "name all: --features a,b,c"
Handler = Callable[["Machine", Any, Scope], Any]
EXPRESSIONS: dict[type[ast.AST], Handler] = {}
STATEMENTS: dict[type[ast.AST], Handler] = {}  # these give an `End`, or None
CALLS: dict[type, Callable[..., Any]] = {}  # what calling a value of a kind gives: machine, value, arguments, node


def reads(table: dict[type[ast.AST], Handler], *kinds: type[ast.AST]) -> Callable[[Handler], Handler]:
    """Registers the handler of kinds of nodes."""

    def register_handler(handler: Handler) -> Handler:
        table.update(dict.fromkeys(kinds, handler))
        return handler

    return register_handler


def text_of(node: ast.AST) -> str:
    """A node as Python, short enough for a line."""
    try:
        text = escape_text(" ".join(ast.unparse(node).split()))
    except ValueError:  # of integers with thousands of digits
        return repr(type(node).__name__)
    return text if len(text) <= MAX_SHOWN else f"{text[: MAX_SHOWN - 3]}..."


class End(NamedTuple):
    """A `break`, `continue` or `return`; the value of a return."""

    kind: str
    value: Any = None


class Machine:
    """The state of an interpreter: of the file itself while `paths` is None, then of one path of a function."""

    def __init__(self, where: str, arrays: str) -> None:
        self.where, self.arrays = where, arrays
        self.paths: Paths | None = None
        self.inputs = Inputs(where, ())
        self.sums = Sums(arrays or FLOAT64)  # of several features
        self.line, self.depth, self.steps = 0, 0, 0
        self.fresh: dict[int, Any] = {}  # lists and objects that this path has made, and may change
        self.written: dict[tuple[int, str], Any] = {}  # attributes that this path has set
        self.called: dict[Any, str] = {}  # what returned members are called
        self.symbols: set[str] = set()  # names that are returned without being defined
        self.texts: set[str] = set()  # texts that are returned
        self.notes: dict[str, None] = {}  # what was skipped, in words
        self.streams = False  # whether this path has made an iterator, which no state may hold
        self.made: set[Class] = set()  # classes of which the file makes objects
        self.finite = False  # whether something is computed that Python refuses for infinite numbers
        self.long = False  # whether a feature is compared with a whole number that no double equals
        self.makers: set[Function] = set()  # functions that the file calls to make functions or objects

    # --- errors

    def make_error(self, node: ast.AST | None, what: str, advice: str) -> InputError:
        """What is wrong at a node's line."""
        return InputError(what, f"{self.where}, line {getattr(node, 'lineno', self.line) or self.line}", advice)

    def unread(self, what: str, advice: str) -> Unread:
        """What cannot be said of the present line."""
        return Unread(what, advice, self.line)

    def require_value(self, value: Any) -> Any:
        """The value. InputError where it cannot be said."""
        if isinstance(value, Unread):
            raise InputError(value.what, f"{self.where}, line {value.line}", value.advice)
        if isinstance(value, Symbol):
            what = f"the name {escape_text(value.name)!r} is not defined in the file"
            raise self.make_error(None, what, "write the number or the text itself")
        return value

    # --- evaluation

    def eval(self, node: ast.AST, scope: Scope) -> Any:
        """What an expression is."""
        self.count()
        handler = EXPRESSIONS.get(type(node))
        if handler is None:
            raise self.make_error(node, f"{text_of(node)} is not understood", TEST_ADVICE)
        return handler(self, node, scope)

    def count(self, more: int = 1) -> None:
        """Counts the work. InputError beyond its limit."""
        if self.paths is not None:
            self.paths.step(more)
            return
        self.steps += more
        if self.steps > MAX_STEPS:
            raise self.make_error(None, "the file does not end", MANY_PATHS)

    def keep_value(self, value: Any) -> Any:
        """A new list, dictionary or object, which this path may change."""
        self.weigh(value)
        if not isinstance(value, str | tuple):
            self.fresh[id(value)] = value
        return value

    def weigh(self, value: Any) -> None:
        """InputError for a container of too many parts, with those of its parts."""
        weight = len(value) if isinstance(value, str) else 0
        open_ = [value]
        while open_ and weight <= MAX_ITEMS:
            each = open_.pop()
            if isinstance(each, list | tuple | set | frozenset):
                weight += len(each)
                open_ += each
            elif isinstance(each, dict):
                weight += len(each)
                open_ += [*each, *each.values()]
        self.count(1 + (weight >> 4))
        if weight > MAX_ITEMS:
            raise self.make_error(None, f"a list or text has more than {MAX_ITEMS} parts", "make it shorter")

    def ensure_fresh(self, value: Any, node: ast.AST) -> Any:
        """The value, which is about to be changed. InputError where that outlives the decision."""
        if self.paths is not None and id(value) not in self.fresh:
            what = f"{text_of(node)} changes something that outlives the decision"
            raise self.make_error(node, what, STATE_ADVICE)
        return value

    # --- numbers and truth

    def plain(self, value: Any) -> Any:
        """The value with observations as features, members of an IntEnum as numbers, conditions decided."""
        if isinstance(value, Part):
            if value.offset:
                return self.unread("a part of the observation is used as a number", TEST_ADVICE)
            return Feature(self.inputs.number(value.path, self.line), value.steps)
        if isinstance(value, Member) and value.kind.mixed:
            return value.value
        if isinstance(value, Test | Condition):
            return self.truth(value)
        return value

    def holds(self, test: Test) -> bool:
        """Whether a test holds on this path."""
        assert self.paths is not None  # outside functions there are no features
        if test.feature.place < 0:  # of every number of an observation at once
            raise self.make_error(None, *UNCOUNTED)
        self.paths.line = self.line
        return self.paths.holds(test)

    def truth(self, value: Any) -> bool:
        """Whether a value counts as true."""
        self.count()
        value = self.require_value(value)
        if isinstance(value, Test):
            return self.holds(value)
        if isinstance(value, Condition):
            return value.ask()
        if isinstance(value, Part):
            value = self.require_value(self.plain(value))
        if isinstance(value, Feature):
            return self.holds(Test(value, "!=", 0))
        if isinstance(value, Member):
            return bool(value.value) if value.kind.mixed else True
        if isinstance(value, Extreme):
            raise self.make_error(None, "the least or the largest of several features is no condition", TEST_ADVICE)
        if isinstance(value, Function | Class | Instance | Module | Bound | Length):
            return True
        if isinstance(value, Array) and len(value) != 1:
            raise self.make_error(None, "an array is no condition", "use np.any or np.all")
        return self.truth(value[0]) if isinstance(value, Array) else bool(value)

    def whole(self, value: Any) -> Any:
        """A concrete number: of a feature that is a whole number, one for each value that it may have."""
        value = self.require_value(self.plain(value))
        if not isinstance(value, Feature):
            return value
        if not self.counts(value):
            what = "a feature decides without being compared"
            raise self.make_error(None, what, "answers must be finitely many: compare the feature with numbers")
        assert self.paths is not None
        low = self.paths.least(value)
        for number in range(int(low), int(low) + MAX_INDEX) if np.isfinite(low) else ():
            if self.holds(Test(value, "<=", number)):
                return number
        raise self.make_error(None, "a whole number has too many values", "clip it first: min(max(i, 0), n - 1)")

    def counts(self, feature: Feature) -> bool:
        """Whether a feature is a whole number, which may be asked for its value."""
        return isinstance(feature.value(1.0), int | np.integer)

    # --- calls

    def call(self, called: Any, given: Sequence[Any], named: Mapping[str, Any], node: ast.AST) -> Any:
        """What a call gives."""
        if isinstance(called, Bound):
            return called.call(self, node, list(given), dict(named))
        if isinstance(called, Function):
            return self.apply(called, given, named, node)
        if isinstance(called, Instance):
            method = called.kind.find("__call__")
            return self.call(method, [called, *given], named, node)
        if type(called) in CALLS:
            return CALLS[type(called)](self, called, given, named, node)
        if isinstance(called, Unread):
            return called
        if isinstance(called, Symbol):
            if "random" in called.name.split("."):
                return self.unread("a random number is drawn", "a tree decides alike each time: write the limits")
            what = f"{escape_text(called.name)} is called, which the file does not define"
            return self.unread(what, "write what it computes into the file; math and numpy are known in part")
        return self.unread(f"{text_of(node)} is not understood", "call functions of the file, of math or of numpy")

    def apply(self, function: Function, given: Sequence[Any], named: Mapping[str, Any], node: ast.AST) -> Any:
        """What a function of the file returns."""
        if self.depth >= MAX_CALLS:
            raise self.make_error(node, f"calls are nested more than {MAX_CALLS} deep", "write recursion as tests")
        scope = Scope(self.bind_arguments(function, given, named, node), function.scope, function.local)
        self.depth, line = self.depth + 1, self.line
        try:
            if isinstance(function.node, ast.Lambda):
                return self.eval(function.node.body, scope)
            end = self.block(function.node.body, scope)
            returned = end.value if end else None
            if self.paths is None and isinstance(returned, Function | Instance):
                self.makers.add(function)
            return returned
        finally:
            self.depth, self.line = self.depth - 1, line

    def block(self, nodes: Iterable[ast.stmt], scope: Scope) -> End | None:
        """Runs statements; how they end, if not by going on."""
        for node in nodes:
            end = self.run(node, scope)
            if end is not None:
                return end
        return None

    def run(self, node: ast.stmt, scope: Scope) -> End | None:
        """Runs a statement."""
        self.line = node.lineno
        self.count()
        handler = STATEMENTS.get(type(node))
        if handler is None:
            what = f"'{type(node).__name__.lower()}' is not understood"
            raise self.make_error(node, what, "use if, elif, else, match, for over a list, return and name = value")
        try:
            return handler(self, node, scope)
        except (TypeError, LookupError, ArithmeticError, AttributeError, StopIteration) as error:
            what = f"{text_of(node)} fails in a way that is not understood: {escape_text(error)[:80]}"
            raise self.make_error(node, what, TEST_ADVICE) from None

    def bind_arguments(
        self, function: Function, given: Sequence[Any], named: Mapping[str, Any], node: ast.AST
    ) -> dict[str, Any]:
        """What the parameters of a function stand for in a call."""
        takes, bindings = function.node.args, dict(function.defaults)
        places = [each.arg for each in (*takes.posonlyargs, *takes.args)]
        names = [*places, *(each.arg for each in takes.kwonlyargs)]
        bindings |= dict(zip(places, given, strict=False))
        rest, others = list(given[len(places) :]), dict(named)
        bindings |= {name: others.pop(name) for name in list(others) if name in names}
        if takes.vararg:
            bindings[takes.vararg.arg], rest = tuple(rest), []
        if takes.kwarg:
            bindings[takes.kwarg.arg], others = others, {}
        missing = [name for name in names if name not in bindings]
        if rest or others or missing:
            what = f"{text_of(node)} does not fit the parameters of {escape_text(function.name)}"
            raise self.make_error(node, what, "mend it")
        return bindings


def step_of(kind: str) -> tuple[Step, ...]:
    """The conversion that an array of NumPy has done, if it is one."""
    return (Step(kind, np.dtype(kind).type),) if kind else ()
