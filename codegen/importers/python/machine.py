"""A reader of Python's syntax trees whose values may be features: its state, and what all parts of it ask.

Does: evaluates nodes by the handlers that expressions.py and statements.py register; truth, numbers, calls.
Assumes: a syntax tree that Python accepts.
Does not: run Python code, import a module, or touch anything outside the syntax tree.

A feature is computed with only by steps that symbolic/feature.py can turn into a threshold. What cannot be said
exactly is an error where it is met. Everything is counted: a file that does not end is refused.
"""

# pyright: basic
# the values of a program may be anything
import ast
import enum
from collections.abc import Callable, Iterable, Mapping, Sequence
from inspect import Parameter, Signature
from typing import Any, NamedTuple

import numpy as np

from codegen.errors import InputError, escape_text
from codegen.floats import FLOAT64
from codegen.importers.python.values import (
    Array,
    Bound,
    Class,
    Condition,
    Function,
    Inputs,
    Instance,
    Part,
    Refused,
    Scope,
    Stream,
    words_of,
)
from codegen.importers.reading import FLOATS
from codegen.importers.symbolic.affine import Sums
from codegen.importers.symbolic.feature import Feature, Step, Test
from codegen.importers.symbolic.paths import MANY_PATHS, MAX_CALLS, MAX_STEPS, STATE_ADVICE, Growth

MAX_ITEMS = 1 << 16  # of a list, a text or a dictionary
MAX_SHOWN = 60
MAX_INDEX = 256  # values of a whole number that is used as an index
TEST_ADVICE = "compare one feature with a number; give a sum or a difference as a feature of its own"
ARRAYS_ADVICE = "say --arrays floats for Python's floats, --arrays float64 or --arrays float32 for arrays of NumPy"
UNCOUNTED = "the file does not say how many features there are", "name all: --features a,b,c"
STATED = "write what it computes with comparisons and numbers; importing.md lists what is read"
STREAM_ADVICE = "write a list; a generator or iterator may stand in a loop, or as the argument of any, all, sum, list"
Handler = Callable[["Machine", Any, Scope], Any]
EXPRESSIONS: dict[type[ast.AST], Handler] = {}
STATEMENTS: dict[type[ast.AST], Handler] = {}  # these give an `End`, or None
CALLS: dict[type, Callable[..., Any]] = {}  # what calling a value of a kind gives: machine, value, arguments, node
REASONS = {
    **dict.fromkeys((ast.Global, ast.Nonlocal), ("something is kept between calls", STATE_ADVICE)),
    ast.Raise: ("an error is raised on a path that may be taken", "return an action there"),
}
TAKING = ("any", "all", "sum", "min", "max", "list", "tuple", "enumerate", "zip")  # iterators apart
FAILURES = (Refused, TypeError, ValueError, LookupError, ArithmeticError, AttributeError)
LEAVES = (ast.Name, ast.Constant)


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


def walk_nodes(node: ast.AST, stop: tuple[type[ast.AST], ...] = ()) -> list[Any]:
    """A node and all below it, but operators and contexts. `stop`: below these kinds nothing is looked at."""
    nodes = [node]
    for each in nodes:
        if type(each) in LEAVES or isinstance(each, stop):
            continue
        for name in each._fields:
            value = getattr(each, name, None)
            if isinstance(value, list):
                nodes += [one for one in value if isinstance(one, ast.AST)]
            elif isinstance(value, ast.AST) and value._fields:
                nodes.append(value)
    return nodes


def _refuse_node(m: "Machine", node: ast.AST, scope: Scope) -> Any:
    what, advice = REASONS.get(type(node), (f"'{type(node).__name__.lower()}' is not understood", STATED))
    raise Refused(f"{what}: {text_of(node)}", advice)


class End(NamedTuple):
    """A `break`, `continue` or `return`; the value of a return."""

    kind: str
    value: Any = None


class Machine:
    """The state of a reader: of the file itself while `paths` is None, then of one path of a function."""

    def __init__(self, where: str, arrays: str) -> None:
        self.where, self.arrays = where, arrays
        self.paths: Growth | None = None
        self.inputs = Inputs(())
        self.sums = Sums(self.kind or FLOAT64)  # of several features
        self.line, self.depth, self.steps = 0, 0, 0
        self.fresh: dict[int, Any] = {}  # lists and objects that this path has made, and may change
        self.kept: dict[str, set[ast.AST]] = {}  # attributes, and functions that set them, but those of the object made
        self.hard = False  # whether the last error is about something that no line may be skipped for
        self.stores: list[Any] = []  # nodes that give a name something
        self.sets: list[Any] = []  # attributes that are given something
        self.pauses: list[Any] = []  # nodes that make a generator of the function around them
        self.ran: set[ast.AST] = set()  # functions that the file calls before any decision
        self.called: dict[Any, str] = {}  # what returned members are called
        self.notes: dict[str, None] = {}  # what was skipped, in words
        self.made: set[Class] = set()  # classes of which the file makes objects
        self.finite = False  # whether something is computed that Python refuses for infinite numbers
        self.numpy = False  # whether the file uses functions of NumPy, whose conditions are no numbers

    @property
    def kind(self) -> str:
        """The type of the arrays that are given; "": floats are, or nobody says."""
        return "" if self.arrays == FLOATS else self.arrays

    # --- errors

    def make_error(self, node: ast.AST | None, error: Exception) -> InputError:
        """Makes an error for a node from an error of a handler, or of Python's own arithmetic and containers."""
        what, advice = f"this fails with {escape_text(error)[:80]}", TEST_ADVICE
        if isinstance(error, Refused):
            what, advice, self.hard = error.what, error.next_step, error.hard
        line = self.line
        if node is not None and not (hasattr(node, "body") or hasattr(node, "cases")):
            what = what if ": " in what else f"{what}: {text_of(node)}"
            line = getattr(node, "lineno", line)
        where = f"{self.where}, line {line}"
        return InputError(what, where, advice)

    def ask_arrays(self, what: str) -> None:
        """InputError unless the user says which numbers the file is given."""
        if not self.arrays:
            raise Refused(f"{what}, which Python's floats and arrays of NumPy do differently", ARRAYS_ADVICE)

    # --- evaluation

    def eval(self, node: ast.AST, scope: Scope) -> Any:
        """Returns the value of an expression."""
        value = self.eval_stream(node, scope)
        if type(value) is Stream:
            raise self.make_error(node, Refused("an iterator is kept", STREAM_ADVICE))
        return value

    def eval_stream(self, node: ast.AST, scope: Scope) -> Any:
        """Returns the value of an expression, which may be an iterator that is used at once."""
        try:
            return EXPRESSIONS.get(type(node), _refuse_node)(self, node, scope)
        except FAILURES as error:
            raise self.make_error(node, error) from None

    def count(self, more: int = 1) -> None:
        """Counts the work. InputError beyond its limit."""
        if self.paths is not None:
            self.paths.step(more)
            return
        self.steps += more
        if self.steps > MAX_STEPS:
            raise Refused("the file does not end", MANY_PATHS)

    def keep_value(self, value: Any) -> Any:
        """A new list, dictionary or object, which this path may change."""
        self.weigh(value)
        if isinstance(value, list | dict):
            self.fresh[id(value)] = value
        return value

    def weigh(self, value: Any) -> None:
        """InputError for a container of too many parts, with those of its parts."""
        weight = len(value) if isinstance(value, str) else 0
        open_ = [value]
        while open_ and weight <= MAX_ITEMS:
            each = open_.pop()
            if isinstance(each, list | tuple):
                weight += len(each)
                open_ += each
            elif isinstance(each, dict):
                weight += len(each)
                open_ += [*each, *each.values()]
        self.count(1 + (weight >> 4))
        if weight > MAX_ITEMS:
            raise Refused(f"a list or text has more than {MAX_ITEMS} parts", "make it shorter")

    def ensure_fresh(self, value: Any, node: ast.AST) -> Any:
        """The value, which is about to be changed. InputError where that outlives the decision."""
        if self.paths is not None and id(value) not in self.fresh:
            raise Refused(f"{text_of(node)} changes something that outlives the decision", STATE_ADVICE)
        return value

    # --- numbers and truth

    def plain(self, value: Any) -> Any:
        """The value, of an observation as a feature."""
        if isinstance(value, Part):
            return Feature(self.inputs.number(value), value.steps)
        return value

    def decide(self, value: Any) -> Any:
        """The value as `plain` has it, where a condition is used as the bool that it is among floats."""
        value = self.plain(value)
        if isinstance(value, Test | Condition):
            self.ensure_plain()
            return self.truth(value)
        return value

    def ensure_plain(self) -> None:
        """InputError where a condition may be NumPy's: it neither adds nor counts as Python's does."""
        self.ask_arrays("a condition is used as a number or an object")
        if self.kind or self.numpy:
            what = "a condition that may be NumPy's is used as a number or an object"
            raise Refused(what, "write int(a > b)")

    def holds(self, test: Test) -> bool:
        """Returns True if a test holds on this path."""
        assert self.paths is not None  # outside functions there are no features
        self.paths.line = self.line
        return self.paths.holds(test)

    def truth(self, value: Any) -> bool:
        """Returns True if a value counts as true."""
        self.count()
        if isinstance(value, Test):
            return self.holds(value)
        if isinstance(value, Condition):
            holds = (all if value.every else any)(self.truth(each) for each in value.parts)
            return holds == value.wanted
        value = self.plain(value)
        if isinstance(value, Feature):
            return self.holds(Test(value, "!=", 0))
        if isinstance(value, Array):
            raise Refused("an array is no condition", "use any() or all() of its tests")
        if value is None or isinstance(value, int | float | np.number | str | list | tuple | dict | range | enum.Enum):
            return bool(value)
        raise Refused(f"{words_of(value)} is no condition", TEST_ADVICE)

    def whole(self, value: Any) -> Any:
        """A constant: of a feature that is a whole number, one for each value that it may have."""
        value = self.decide(value)
        if not isinstance(value, Feature):
            return value
        if not self.counts(value):
            what = "a feature decides without being compared"
            raise Refused(what, "answers must be finitely many: compare the feature with numbers")
        assert self.paths is not None
        low = self.paths.least(value)
        for number in range(int(low), int(low) + MAX_INDEX) if np.isfinite(low) else ():
            if self.holds(Test(value, "<=", number)):
                return number
        raise Refused("a whole number has too many values", "clip it first: min(max(i, 0), n - 1)")

    def counts(self, feature: Feature) -> bool:
        """Returns True if a feature is a whole number, which may be asked for its value."""
        return isinstance(feature.value(1.0), int)

    def forget_nan(self) -> None:
        """Something is asked of which a NaN is no matter of left and right."""
        if self.paths is not None:
            self.paths.nan = False

    # --- parts

    def items(self, value: Any) -> Any:
        """The parts of a list, a text, a dictionary, an Enum or an observation of known length."""
        if isinstance(value, Part):
            if not self.inputs.width:
                raise Refused(*UNCOUNTED)
            return [self.inputs.enter(value, k) for k in range(self.inputs.width)]
        if isinstance(value, enum.EnumType | dict):
            return list(value)
        if isinstance(value, list | tuple | str | range):
            return value
        if isinstance(value, frozenset):
            raise Refused("a loop goes over a set, whose order nobody knows", "write a list")
        raise Refused(f"a loop goes over {words_of(value)}", "loop over literals")

    # --- calls

    def call(self, called: Any, given: Sequence[Any], named: Mapping[str, Any], node: ast.AST) -> Any:
        """Calls what is called, and returns its value."""
        if any(type(each) is Stream for each in given) and not (isinstance(called, Bound) and called.name in TAKING):
            raise Refused(f"{text_of(node)} is given an iterator", STREAM_ADVICE)
        if isinstance(called, Bound):
            return called.call(self, node, list(given), dict(named))
        if isinstance(called, Function):
            return self.apply(called, given, named)
        if isinstance(called, enum.EnumType) and len(given) == 1 and not named:
            return called(self.whole(given[0]))
        if isinstance(called, Instance) and "__call__" in called.kind.members:
            return self.call(called.kind.members["__call__"], [called, *given], named, node)
        if type(called) in CALLS:
            return CALLS[type(called)](self, called, given, named, node)
        raise Refused(f"{text_of(node)} is not understood", "call functions of the file, of math or of numpy")

    def apply(self, function: Function, given: Sequence[Any], named: Mapping[str, Any]) -> Any:
        """Calls a function of the file, and returns its value."""
        if self.depth >= MAX_CALLS:
            raise Refused(f"calls are nested more than {MAX_CALLS} deep", "write recursion as tests")
        scope = Scope(self.bind_arguments(function, given, named), function.scope, function.local)
        self.depth, line = self.depth + 1, self.line
        self.ran |= {function.node} if self.paths is None else set()
        try:
            if isinstance(function.node, ast.Lambda):
                return self.eval(function.node.body, scope)
            end = self.block(function.node.body, scope)
            return end.value if end else None
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
        try:
            return STATEMENTS.get(type(node), _refuse_node)(self, node, scope)
        except FAILURES as error:
            raise self.make_error(node, error) from None

    def bind_arguments(self, function: Function, given: Sequence[Any], named: Mapping[str, Any]) -> dict[str, Any]:
        """Returns the values of a function's parameters in a call."""
        takes = function.node.args
        if takes.vararg or takes.kwarg:
            raise Refused(f"{escape_text(function.name)} takes * or **", "name each parameter")
        kinds = {
            Parameter.POSITIONAL_ONLY: takes.posonlyargs,
            Parameter.POSITIONAL_OR_KEYWORD: takes.args,
            Parameter.KEYWORD_ONLY: takes.kwonlyargs,
        }
        bound = Signature([
            Parameter(each.arg, kind, default=function.defaults.get(each.arg, Parameter.empty))
            for kind, places in kinds.items()
            for each in places
        ]).bind(*given, **named)  # fmt: skip
        bound.apply_defaults()
        return bound.arguments


def step_of(kind: str) -> tuple[Step, ...]:
    """The conversion that an array of NumPy has done, if it is one."""
    return (Step(kind, np.dtype(kind).type),) if kind else ()
