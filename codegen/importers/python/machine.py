"""A reader of Python's syntax trees whose values may be features: an interpreter with a method for each kind of node.

Does: evaluates expressions, statements, functions and classes; decides a condition where it is needed, so that
  `fast = v > 1` is no test yet.
Assumes: a syntax tree that Python accepts; the gate (running/gate.py) refuses what could do more than compute.
Does not: run Python code, import a module, or touch anything outside the syntax tree.

What depends on no feature is computed by Python itself (library.py). A feature is computed with only by
steps that symbolic/feature.py can turn into a threshold. What cannot be said exactly is an error where it is met.
Everything is counted: a file that does not end is refused.
"""

# pyright: basic
# the values of a program may be anything
import ast
import copy
import enum
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from inspect import Parameter, Signature
from typing import Any

import numpy as np

from codegen.errors import InputError, escape_text
from codegen.floats import FLOAT64
from codegen.importers.python.library import (
    BUILTINS,
    COMPARISONS,
    CONDITIONS,
    FACTORY,
    MAX_ITEMS,
    MODULES,
    STATED,
    STREAMS,
    TEST_ADVICE,
    Array,
    Bound,
    Class,
    Condition,
    Function,
    Inputs,
    Instance,
    Module,
    Part,
    Refused,
    Stream,
    binary,
    compare_values,
    is_constant,
    unary,
    words_of,
)
from codegen.importers.reading import FLOATS
from codegen.importers.symbolic.feature import Feature, Step, Sums, Test, is_whole
from codegen.importers.symbolic.memory import MAX_MEMBERS, RemembersError
from codegen.importers.symbolic.paths import IN_SUM, MANY_PATHS, MAX_CALLS, MAX_STEPS, STATE_ADVICE, ask_whole
from codegen.importers.symbolic.statements import End, Executor, Open, Scope, link_statements

MAX_SHOWN = 60
MAX_INDEX = 256  # values of a whole number that is used as an index
MAX_TURNS = 100_000
ARRAYS_ADVICE = "say --arrays floats for Python's floats, --arrays float64 or --arrays float32 for arrays of NumPy"
UNCOUNTED = "the file does not say how many features there are", "name all: --features a,b,c"
STREAM_ADVICE = "write a list; a generator or iterator may stand in a loop, or as the argument of any, all, sum, list"
ELSEWHERE = "write the numbers and functions that decide into the file"
FAILURES = (Refused, TypeError, ValueError, LookupError, ArithmeticError, AttributeError)
UNWALKED = frozenset(("ctx", "op", "ops", "id", "kind"))
SAFE = (ast.Compare, ast.BoolOp, ast.UnaryOp, ast.Name, ast.Constant, ast.Attribute,
        ast.cmpop, ast.boolop, ast.unaryop, ast.expr_context)  # fmt: skip
REASONS = {
    **dict.fromkeys((ast.Global, ast.Nonlocal), ("something is kept between calls", STATE_ADVICE)),
    ast.Raise: ("an error is raised on a path that may be taken", "return an action there"),
}
METHODS: Mapping[type, tuple[str, ...]] = {
    list: ("index", "append"), tuple: ("index",), dict: ("get", "keys", "values", "items"),
}  # fmt: skip
GIVEN = (np.float64, np.ndarray, dict)  # what an observation may be, whose own attributes are no features
PLAIN = ("object", "typing.Protocol", "typing.NamedTuple", "typing.TypedDict")
SETTINGS = ("frozen", "slots", "eq", "order", "repr", "unsafe_hash")  # of a dataclass, which decide nothing


COUNTED = Step("whole number", lambda v: int(v) if math.isfinite(v) else v)
UNSET: Any = object()


@dataclass
class Slot:
    """What an attribute remembers: the number of its input, and its values, in the order in which they were met; None:
    whole numbers.
    """

    at: int
    values: list[Any] | None

    def place(self, value: Any) -> int:
        """The place of a value, which may be new."""
        assert self.values is not None
        for place, each in enumerate(self.values):
            if type(each) is type(value) and each == value:
                return place
        if len(self.values) > MAX_MEMBERS:
            raise Refused("what is remembered takes too many values", STATE_ADVICE)
        self.values.append(value)
        return len(self.values) - 1


class Machine(Executor):
    """The state of a reader: of the file itself while `paths` is None, then of one path of a function."""

    BRANCHES = ast.If
    line = depth = steps = 0
    finite = False  # whether something is computed that Python refuses for infinite numbers
    numpy = False  # whether the file uses functions of NumPy, whose conditions are no numbers
    stores: Sequence[Any] = ()  # nodes that give a name something
    sets: Sequence[Any] = ()  # attributes that are given something

    def __init__(self, where: str, arrays: str) -> None:
        self.where, self.arrays = where, arrays
        self.kind = "" if arrays == FLOATS else arrays  # the type of the arrays that are given, if any are
        self.inputs = Inputs(())
        self.sums = Sums(self.kind or FLOAT64)  # of several features
        self.fresh: dict[int, Any] = {}  # lists and objects that this path has made, and may change
        self.kept: dict[str, set[ast.AST]] = {}  # attributes, and functions that set them, but those of the object made
        self.ran: set[ast.AST] = set()  # functions that the file calls before any decision
        self.called: dict[Any, str] = {}  # what returned members are called
        self.notes: dict[str, None] = {}  # what was skipped, in words
        self.made: set[Class] = set()  # classes of which the file makes objects
        self.owner: Any = None  # the object whose method decides
        self.slots: dict[str, Slot] = {}  # what it remembers, by attribute
        self.held: dict[str, Any] = {}  # what this path has made of these

    # --- errors and limits

    def make_error(self, node: ast.AST | None, error: Exception) -> InputError:
        """Makes an error for a node from one of a method below, or of Python's own arithmetic and containers."""
        what, advice = f"this fails with {escape_text(error)[:80]}", TEST_ADVICE
        if isinstance(error, Refused):
            what, advice = error.what, error.next_step
        line = self.line
        if node is not None and not (hasattr(node, "body") or hasattr(node, "cases")):
            what = what if ": " in what else f"{what}: {text_of(node)}"
            line = getattr(node, "lineno", line)
        return InputError(what, f"{self.where}, line {line}", advice)

    def ask_arrays(self, what: str) -> None:
        """InputError unless the user says which numbers the file is given."""
        if not self.arrays:
            raise Refused(f"{what}, which Python's floats and arrays of NumPy do differently", ARRAYS_ADVICE)

    def ensure_plain(self) -> None:
        """InputError where a condition may be NumPy's: it neither adds nor counts as Python's does."""
        self.ask_arrays("a condition is used as a number or an object")
        if self.kind or self.numpy:
            what = "a condition that may be NumPy's is used as a number or an object"
            raise Refused(what, "write int(a > b)")

    def count(self, more: int = 1) -> None:
        """Counts the work. InputError beyond its limit."""
        if self.paths is not None:
            self.paths.step(more)
            return
        self.steps += more
        if self.steps > MAX_STEPS:
            raise Refused("the file does not end", MANY_PATHS)

    def keep_value(self, value: Any) -> Any:
        """A new list, dictionary or object, which this path may change. InputError for one of too many parts."""
        weight, open_ = len(value) if isinstance(value, str) else 0, [value]
        while open_ and weight <= MAX_ITEMS:
            each = open_.pop()
            if isinstance(each, list | tuple | dict):
                weight += len(each)
                open_ += [*each, *each.values()] if isinstance(each, dict) else each
        self.count(1 + (weight >> 4))
        if weight > MAX_ITEMS:
            raise Refused(f"a list or text has more than {MAX_ITEMS} parts", "make it shorter")
        if isinstance(value, list | dict | Instance):
            self.fresh[id(value)] = value
        return value

    def ensure_fresh(self, value: Any) -> Any:
        """The value, which is about to be changed. InputError where that outlives the decision."""
        if self.paths is not None and id(value) not in self.fresh:
            raise Refused("this changes something that outlives the decision", STATE_ADVICE)
        return value

    # --- truth and numbers

    def plain(self, value: Any) -> Any:
        """The value, of an observation as a feature."""
        if isinstance(value, Part):
            return Feature(self.inputs.number(value), value.steps)
        return value

    def decide(self, value: Any) -> Any:
        """The value as `plain` has it, where a condition is used as the bool that it is among floats."""
        if isinstance(value, CONDITIONS):
            self.ensure_plain()
            return self.truth(value)
        return self.plain(value)

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
        if not is_whole(value):
            what = "a feature decides without being compared"
            raise Refused(what, "answers must be finitely many: compare the feature with numbers")
        assert self.paths is not None
        low = self.paths.least(value)
        for number in range(int(low), int(low) + MAX_INDEX) if np.isfinite(low) else ():
            if self.holds(Test(value, "<=", number)):
                return number
        raise Refused("a whole number has too many values", "clip it first: min(max(i, 0), n - 1)")

    def forget_nan(self) -> None:
        """Something is asked of which a NaN is no matter of left and right."""
        if self.paths is not None:
            self.paths.nan = False

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

    def key_of(self, value: Any) -> Any:
        """A key of a dictionary: a constant; of a condition, what it is on this path."""
        self.count()
        if isinstance(value, tuple):
            return tuple(self.key_of(each) for each in value)
        key = self.truth(value) if isinstance(value, CONDITIONS) else self.whole(value)
        if isinstance(key, list) or not is_constant(key):
            raise Refused(f"{words_of(value)} is a key", "use numbers, texts or members of an Enum")
        return key

    # --- expressions

    def eval(self, node: ast.AST, scope: Scope) -> Any:
        """Returns the value of an expression."""
        if type(node) is ast.Constant:  # most are this
            return node.value
        value = self.eval_stream(node, scope)
        if type(value) is Stream:
            raise self.make_error(node, Refused("an iterator is kept", STREAM_ADVICE))
        return value

    def eval_stream(self, node: ast.AST, scope: Scope) -> Any:
        """Returns the value of an expression, which may be an iterator that is used at once, or a statement's end."""
        try:
            if type(node) not in READERS:
                what, advice = REASONS.get(type(node), (f"'{type(node).__name__.lower()}' is not understood", STATED))
                raise Refused(f"{what}: {text_of(node)}", advice)
            return READERS[type(node)](self, node, scope)
        except FAILURES as error:
            raise self.make_error(node, error) from None

    def _read_Constant(self, node: ast.Constant, scope: Scope) -> Any:
        return node.value

    def _read_Name(self, node: ast.Name, scope: Scope) -> Any:
        for each in scope:
            if node.id in each.names:
                value = each.names[node.id]
                if type(value) is Refused:
                    raise InputError(value.what, value.where or f"{self.where}, line {node.lineno}", value.next_step)
                return value
            if node.id in each.local:
                raise Refused(f"{escape_text(node.id)!r} holds nothing on some path", "set it on every path")
        if node.id not in BUILTINS:
            raise Refused(f"the name {escape_text(node.id)!r} is not defined in the file, or not read", STATED)
        return BUILTINS[node.id]

    def _read_NamedExpr(self, node: ast.NamedExpr, scope: Scope) -> Any:
        value = scope.names[node.target.id] = self.eval(node.value, scope)
        return value

    def _read_IfExp(self, node: ast.IfExp, scope: Scope) -> Any:
        return self.eval(node.body if self.eval_condition(node.test, scope) else node.orelse, scope)

    def _read_BinOp(self, node: ast.BinOp, scope: Scope) -> Any:
        left, right = self.eval(node.left, scope), self.eval(node.right, scope)
        self.line = node.lineno
        return binary(self, type(node.op), left, right)

    def _read_UnaryOp(self, node: ast.UnaryOp, scope: Scope) -> Any:
        value = self.eval(node.operand, scope)
        if not isinstance(node.op, ast.Not):
            return unary(self, type(node.op), value)
        return Condition(True, (value,), False) if isinstance(value, CONDITIONS) else not self.truth(value)

    def eval_condition(self, node: ast.expr, scope: Scope) -> bool:
        """Returns True if a condition holds; no more of it is evaluated than decides it."""
        if isinstance(node, ast.BoolOp):
            self.count()
            every = isinstance(node.op, ast.And)
            return (all if every else any)(self.eval_condition(each, scope) for each in node.values)
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
            self.count()
            return not self.eval_condition(node.operand, scope)
        value = self.eval(node, scope)
        self.line = getattr(node, "lineno", self.line)
        return self.truth(value)

    def _read_BoolOp(self, node: ast.BoolOp, scope: Scope) -> Any:
        """`a and b`: decided later, if nothing but truth can come of it and looking at `b` cannot fail."""
        every = isinstance(node.op, ast.And)
        if all(map(_cannot_fail, node.values)):
            parts = tuple(self.eval(each, scope) for each in node.values)
            if all(isinstance(each, (*CONDITIONS, bool)) for each in parts):
                return Condition(every, parts)
        for each in node.values[:-1]:
            value = self.eval(each, scope)
            if self.truth(value) != every:
                return value
        return self.eval(node.values[-1], scope)

    def _read_Compare(self, node: ast.Compare, scope: Scope) -> Any:
        # what `len(x) == 4` and `len(x) != 4` compare the length of the observation with is taken for its length
        call, number = node.left, getattr(node.comparators[0], "value", None)
        if isinstance(call, ast.Call) and isinstance(number, int) and len(call.args) == 1 and not self.inputs.width:
            equal = isinstance(node.ops[0], ast.Eq | ast.NotEq) and isinstance(call.args[0], ast.Name)
            of_length = equal and self.eval(call.func, scope) is BUILTINS["len"]
            if of_length and isinstance(self.eval(call.args[0], scope), Part):
                self.inputs.width = number
                self.notes[f"line {node.lineno}: the observation is taken to have {number} numbers"] = None
        sides = [self.eval(node.left, scope), *[self.eval(each, scope) for each in node.comparators]]
        self.line = node.lineno
        tests = tuple([self._compare_pair(sign, sides[k], sides[k + 1]) for k, sign in enumerate(node.ops)])
        return tests[0] if len(tests) == 1 else Condition(True, tests)

    def _compare_pair(self, operator: ast.cmpop, left: Any, right: Any) -> Any:
        sign = COMPARISONS.get(type(operator))
        if sign is not None:
            return compare_values(self, sign, left, right)
        if isinstance(operator, ast.Is | ast.IsNot):
            members = isinstance(left, enum.Enum) and isinstance(right, enum.Enum)
            if left is not None and right is not None and not members:
                raise Refused("'is' compares what is no constant", "write ==")
            return (left is right) == isinstance(operator, ast.Is)
        wanted = isinstance(operator, ast.In)
        if isinstance(right, frozenset):
            right = sorted(right, key=repr)  # what is equal to one of them does not depend on their order
        left, items = self.plain(left), self.items(right)
        if is_constant(left) and is_constant(right):
            return (left in right) == wanted
        return Condition(False, tuple(compare_values(self, "==", left, each) for each in items), wanted)

    # --- lists, dictionaries and observations

    def _read_List(self, node: Any, scope: Scope) -> Any:
        items = self.keep_value([self.eval(each, scope) for each in node.elts])
        if isinstance(node, ast.Set):
            return frozenset(self.key_of(each) for each in items)
        return items if isinstance(node, ast.List) else tuple(items)

    _read_Tuple = _read_Set = _read_List

    def _read_Dict(self, node: ast.Dict, scope: Scope) -> Any:
        if None in node.keys:
            raise Refused(f"{text_of(node)} is not understood", "write each entry by itself")
        pairs = zip(node.keys, node.values, strict=True)
        entries = {self.key_of(self.eval(key, scope)): self.eval(value, scope) for key, value in pairs if key}
        return self.keep_value(entries)

    def _read_Subscript(self, node: ast.Subscript, scope: Scope) -> Any:
        value = self.eval(node.value, scope)
        if isinstance(node.slice, ast.Slice):
            ends = (node.slice.lower, node.slice.upper, node.slice.step)
            key: Any = slice(*[None if each is None else self.whole(self.eval(each, scope)) for each in ends])
        else:
            key = self.eval(node.slice, scope)
        self.line = node.lineno
        if isinstance(value, Part):
            if isinstance(key, slice):
                n = self.inputs.width
                if not n and (key.stop is None or min(key.start or 0, key.stop, key.step or 1) < 0):
                    raise Refused(*UNCOUNTED)
                parts = [self.inputs.enter(value, place) for place in range(*key.indices(n or key.stop))]
                return self.keep_value(Array(parts)) if value.array else tuple(parts)
            key = key if type(key) is int else self.whole(key)
            if isinstance(key, bool) or not isinstance(key, int | str):
                raise Refused("the observation is looked up by what is no number or text", "write x[0], or x['speed']")
            return self.inputs.enter(value, key)
        if isinstance(key, slice):
            raise Refused(f"a part of {words_of(value)} is taken", "write the part itself")
        if not isinstance(value, list | tuple | dict | str | range):
            raise Refused(f"something is looked up in {words_of(value)}", "compute with each x[0] by itself")
        return value[self.key_of(key) if isinstance(value, dict) else self.whole(key)]

    def _read_ListComp(self, node: Any, scope: Scope) -> Any:
        if len(node.generators) > 1 or any(isinstance(each, ast.NamedExpr) for each in ast.walk(node)):
            raise Refused(f"{text_of(node)} has several loops, or assigns a name on its way", "write a loop")
        (turn,), inner, made = node.generators, Scope({}, scope.outer), []
        for each in self.items(self.eval_stream(turn.iter, scope)):
            self.count()
            self.assign(turn.target, each, inner)
            if all(self.eval_condition(test, inner) for test in turn.ifs):
                made.append(self.eval(node.elt, inner))
        return self.keep_value(made) if isinstance(node, ast.ListComp) else Stream(made)

    _read_GeneratorExp = _read_ListComp

    # --- calls

    def _read_Call(self, node: ast.Call, scope: Scope) -> Any:
        function = self.eval(node.func, scope)
        if isinstance(function, Bound) and (function.name == "print" or function.name.startswith("logging.")):
            self.notes[f"line {node.lineno}: {text_of(node)} is skipped"] = None
            if may_go_unread(node):
                return function.call(self, [], {})
        if any(
            isinstance(each, ast.Starred) or getattr(each, "arg", "") is None for each in (*node.args, *node.keywords)
        ):
            raise Refused(f"{text_of(node)} is not understood", "write each argument by itself")
        given = [self.eval_stream(each, scope) for each in node.args]
        named = {each.arg or "": self.eval(each.value, scope) for each in node.keywords}
        self.line = node.lineno
        return self.call(function, given, named)

    def call(self, called: Any, given: Sequence[Any], named: Mapping[str, Any]) -> Any:
        """Calls what is called, and returns its value."""
        if any(type(each) is Stream for each in given) and not (isinstance(called, Bound) and called.name in STREAMS):
            raise Refused("a call is given an iterator", STREAM_ADVICE)
        if isinstance(called, Bound):
            return called.call(self, list(given), dict(named))
        if isinstance(called, Function):
            return self.apply(called, given, named)
        if isinstance(called, Class):
            return self.make_object(called, given, named)
        if isinstance(called, Instance) and "__call__" in called.kind.members:
            return self.call(called.kind.members["__call__"], [called, *given], named)
        raise Refused(f"{words_of(called)} is called", "call functions of the file, of math or of numpy")

    def ensure_named(self, function: Function) -> None:
        """InputError for a function that takes any number of values."""
        if function.node.args.vararg or function.node.args.kwarg:
            where = f"{self.where}, line {function.node.lineno}"
            raise InputError(f"{escape_text(function.name)} takes * or **", where, "name each parameter")

    def apply(self, function: Function, given: Sequence[Any], named: Mapping[str, Any]) -> Any:
        """Calls a function of the file, and returns its value."""
        if self.depth >= MAX_CALLS:
            raise Refused(f"calls are nested more than {MAX_CALLS} deep", "write recursion as tests")
        self.ensure_named(function)
        scope = Scope(bind_arguments(function.signature, given, named), function.scope, function.local)
        self.depth, line = self.depth + 1, self.line
        self.ran |= {function.node} if self.paths is None else set()
        try:
            if isinstance(function.node, ast.Lambda):
                return self.eval(function.node.body, scope)
            end = self.block(function.node.body, scope)
            return end.value if end else None
        finally:
            self.depth, self.line = self.depth - 1, line

    def _read_Lambda(self, node: ast.Lambda, scope: Scope) -> Any:
        return Function("a lambda", node, scope.outer, self._signature_of(node.args, scope))

    def _signature_of(self, takes: ast.arguments, scope: Scope) -> Signature:
        """The parameters of a function, with their defaults."""
        places = [*takes.posonlyargs, *takes.args]
        pairs = zip(places[len(places) - len(takes.defaults) :], takes.defaults, strict=True)
        named = zip(takes.kwonlyargs, takes.kw_defaults, strict=True)
        defaults = {each.arg: self.eval(value, scope) for each, value in (*pairs, *named) if value is not None}
        kinds = {
            Parameter.POSITIONAL_ONLY: takes.posonlyargs,
            Parameter.POSITIONAL_OR_KEYWORD: takes.args,
            Parameter.KEYWORD_ONLY: takes.kwonlyargs,
        }
        return Signature([
            Parameter(each.arg, kind, default=defaults.get(each.arg, Parameter.empty))
            for kind, parameters in kinds.items()
            for each in parameters
        ])  # fmt: skip

    # --- attributes

    def _read_Attribute(self, node: ast.Attribute, scope: Scope) -> Any:
        value, name = self.eval(node.value, scope), node.attr
        if isinstance(value, Module) and name in value.members:
            self.numpy |= value.name == "numpy"
            return value.members[name]
        if isinstance(value, Module):
            raise Refused(f"{value.name}.{name} is not known", STATED)
        if isinstance(value, Part):
            if value.array or any(hasattr(each, name) for each in GIVEN):
                raise Refused(
                    f"'.{name}' of the observation is not understood", "write x[0] for each number, and len(x)"
                )
            return self.inputs.enter(value, name)
        if isinstance(value, Instance | Class):
            kind, made = (value, None) if isinstance(value, Class) else (value.kind, value)
            member = kind.members.get(name)
            if self.paths is not None and made is not None and made is self.owner and name in self.slots:
                return self.recall(name)
            lasting = self.paths is not None and made is not None and id(value) not in self.fresh
            if lasting and not isinstance(member, Function) and self.kept.get(name, set()) - self.ran:
                if made is self.owner:
                    raise RemembersError(name)
                raise Refused(f"'{escape_text(name)}' is remembered between calls: a function sets it", STATE_ADVICE)
            if made is not None and name in made.attributes:
                return made.attributes[name]
            if member is None:
                raise Refused(f"'{escape_text(name)}' is not set on some path", "set it in __init__")
            if not isinstance(member, Function):
                return member
            first = {"classmethod": [kind], "staticmethod": []}.get(member.kind, [made] if made is not None else [])
            if member.kind == "property" and first:
                return self.apply(member, first, {})
            return Bound(f"{name}()", lambda m, given, named: m.call(member, [*first, *given], named))
        if isinstance(value, enum.Enum) and name in ("value", "name"):
            return value.value if name == "value" else value.name
        if isinstance(value, enum.EnumType) and name in value.__members__:
            return value[name]
        if name in METHODS.get(type(value), ()):
            return Bound(name, lambda m, given, named: m._call_method(value, name, given, named))
        raise Refused(f"'.{escape_text(name)}' of {words_of(value)} is not understood", STATED)

    def recall(self, name: str) -> Any:
        """What an attribute that is remembered holds: one of the values that it may have, or a number to count with."""
        slot = self.slots[name]
        if name not in self.held:
            if slot.values is None:
                return Feature(slot.at, (COUNTED,))
            self.held[name] = slot.values[self._ask_slot(slot.at)]
        return self.held[name]

    def _ask_slot(self, at: int) -> int:
        """The number that a memory holds on this path, by its place."""
        assert self.paths is not None
        return ask_whole(*self.paths.whole_ends(at), lambda number: self.holds(Test(Feature(at), "<=", number)))

    def resolve_memory(self, value: Any) -> Any:
        """A number in place of what is computed of a memory, which is asked; anything else as it is."""
        if not isinstance(value, Feature) or value.place >= len(self.slots):
            return value
        assert self.paths is not None
        low, high = self.paths.whole_ends(value.place)
        if high - low > MAX_INDEX:
            raise Refused(*IN_SUM)
        return value.value(float(self._ask_slot(value.place)))

    def settle(self, name: str) -> Feature | int | None:
        """What this path has made of an attribute; None: it is kept."""
        slot, value = self.slots[name], self.held.get(name, UNSET)
        if value is UNSET:
            return None
        value = self.truth(value) if isinstance(value, CONDITIONS) else self.plain(value)
        if isinstance(value, Feature) and not (slot.values is None and value.place == slot.at):
            value = self.whole(value)
        if slot.values is None and (isinstance(value, Feature) or type(value) is int):
            return value
        if not isinstance(value, bool | int | str | enum.Enum | None) or slot.values is None:
            raise Refused(f"'{escape_text(name)}' is set to {words_of(value)}, and remembered", STATE_ADVICE)
        return slot.place(value)

    def _call_method(self, value: Any, name: str, given: list[Any], named: dict[str, Any]) -> Any:
        """Calls a method of a list or a dictionary."""
        if name == "append":
            self.ensure_fresh(value).append(*given)
            self.keep_value(value)
            return None
        if name == "get":
            return value.get(self.key_of(given[0]), *given[1:])
        if name == "index":
            given = [self.whole(each) for each in given]
            if not is_constant([*value]) or not is_constant(given):
                raise Refused("'.index' looks for features or objects", "compare them one by one")
            return value.index(*given)
        return Stream(getattr(value, name)(*given))

    # --- statements

    def run(self, node: ast.stmt, scope: Scope) -> End | None:
        """Runs a statement."""
        self.line = node.lineno
        self.count()
        return self.eval_stream(node, scope)

    def branch(self, node: ast.If, scope: Scope, rest: Open) -> tuple[Sequence[Open], bool]:
        """The side that an `if` goes to and the other one, and whether a single test decides that."""
        self.line = node.lineno
        self.count()
        test = self.eval(node.test, scope) if isinstance(node.test, ast.Compare) else None
        holds = self.eval_condition(node.test, scope) if test is None else self.truth(test)
        sides = [link_statements(each, scope, rest) for each in (node.body, node.orelse)]
        return sides if holds else sides[::-1], isinstance(test, Test)

    def keep(self, open_: Open) -> Any:
        """The state from which a path can go on: statements, and the names of their function."""
        return open_, open_ and dict(open_[1].names)

    def _read_If(self, node: ast.If, scope: Scope) -> End | None:
        return self.block([node], scope)

    def _read_Return(self, node: ast.Return, scope: Scope) -> End:
        value = None if node.value is None else self.eval(node.value, scope)
        self.line = node.lineno
        return End("return", value)

    def _read_Expr(self, node: ast.Expr, scope: Scope) -> None:
        self.eval(node.value, scope)

    def _read_Pass(self, node: ast.Pass, scope: Scope) -> None: ...

    def _read_Assert(self, node: ast.Assert, scope: Scope) -> None:
        """Taken to hold: it may say how many features there are."""
        value = None if may_go_unread(node.test) else self.eval(node.test, scope)
        if value is False:
            raise Refused(f"{text_of(node)} fails", "mend it")
        if value is not True:
            self.notes[f"line {node.lineno}: {text_of(node)} is taken to hold"] = None

    def _read_Assign(self, node: Any, scope: Scope) -> None:
        if node.value is not None:  # else an annotation alone
            value = self.eval(node.value, scope)
            for target in node.targets if isinstance(node, ast.Assign) else [node.target]:
                self.assign(target, value, scope)

    _read_AnnAssign = _read_Assign

    def _read_AugAssign(self, node: ast.AugAssign, scope: Scope) -> None:
        load = copy.copy(node.target)
        load.ctx = ast.Load()
        left, right = self.eval(load, scope), self.eval(node.value, scope)
        self.line = node.lineno
        if isinstance(left, list):
            raise Refused(f"{text_of(node)} changes a list that may have other names", "write a = a + b")
        self.assign(node.target, binary(self, type(node.op), left, right), scope)

    def assign(self, target: ast.expr, value: Any, scope: Scope) -> None:
        """Gives a value to a name, an attribute, an element, or names for its parts."""
        if isinstance(target, ast.Name):
            scope.names[target.id] = value
        elif isinstance(target, ast.Tuple | ast.List):
            if isinstance(value, Part):
                self.inputs.count_names([getattr(each, "id", "") for each in target.elts])
            items = list(self.items(value))
            if len(items) != len(target.elts):
                raise Refused(f"{len(items)} values are given to {len(target.elts)} names", "give each a name")
            for each, item in zip(target.elts, items, strict=True):
                self.assign(each, item, scope)
        elif isinstance(target, ast.Attribute):
            owner = self.eval(target.value, scope)
            if not isinstance(owner, Instance) or isinstance(owner.kind.members.get(target.attr), Function):
                what = f"{text_of(target)} is no plain attribute of an object"
                raise Refused(what, "set attributes of self in __init__")
            if self.paths is not None and owner is self.owner and id(owner) not in self.fresh:
                if target.attr not in self.slots:
                    raise RemembersError(target.attr)
                self.held[target.attr] = value
                return
            self.ensure_fresh(owner).attributes[target.attr] = value
        elif isinstance(target, ast.Subscript) and not isinstance(target.slice, ast.Slice):
            owner, key = self.eval(target.value, scope), self.eval(target.slice, scope)
            if isinstance(owner, Array) or not isinstance(owner, list | dict):
                raise Refused(f"{text_of(target)} is set", "give it another name instead")
            self.ensure_fresh(owner)[self.key_of(key) if isinstance(owner, dict) else self.whole(key)] = value
        else:
            raise Refused(f"{text_of(target)} is set", "give it a name")

    def _read_For(self, node: ast.For, scope: Scope) -> End | None:
        def turns() -> Iterator[None]:
            for each in self.items(self.eval_stream(node.iter, scope)):
                self.count()
                yield self.assign(node.target, each, scope)

        return self.repeat(turns(), node.body, scope, node.orelse)

    def _read_While(self, node: ast.While, scope: Scope) -> End | None:
        def turns() -> Iterator[None]:
            for _ in range(MAX_TURNS):
                self.line = node.lineno
                try:
                    more = self.eval_condition(node.test, scope)
                except InputError as error:
                    what = f"a loop goes on until a feature says otherwise: {error.what}"
                    raise Refused(what, "give the loop an end: for k in range(5)") from None
                if not more:
                    return
                yield
            self.line = node.lineno
            raise Refused("a loop does not end", "loop over literals")

        return self.repeat(turns(), node.body, scope, node.orelse)

    def _read_Break(self, node: ast.AST, scope: Scope) -> End:
        return End(type(node).__name__.lower())

    _read_Continue = _read_Break

    def _read_Match(self, node: ast.Match, scope: Scope) -> End | None:
        subject = self.eval(node.subject, scope)
        for case in node.cases:
            self.line = case.pattern.lineno
            guard = case.guard or ast.Constant(True)
            if self._matches(case.pattern, subject, scope) and self.eval_condition(guard, scope):
                return self.block(case.body, scope)
        return None

    def _matches(self, pattern: ast.pattern, value: Any, scope: Scope) -> bool:
        """Returns True if a value matches; names are set."""
        self.count()
        if isinstance(pattern, ast.MatchValue):
            return self.truth(compare_values(self, "==", value, self.eval(pattern.value, scope)))
        if isinstance(pattern, ast.MatchSingleton):
            return self.decide(value) is pattern.value
        if isinstance(pattern, ast.MatchOr):
            return any(self._matches(each, value, scope) for each in pattern.patterns)
        if isinstance(pattern, ast.MatchAs):
            if pattern.pattern is not None and not self._matches(pattern.pattern, value, scope):
                return False
            if pattern.name is not None:
                scope.names[pattern.name] = value
            return True
        stars = [each for each in getattr(pattern, "patterns", ()) if isinstance(each, ast.MatchStar)]
        if stars or not isinstance(pattern, ast.MatchSequence):
            advice = "match numbers, texts, members of an Enum and tuples of them"
            raise Refused("a pattern is not understood", advice)
        if isinstance(value, Array) or not isinstance(value, tuple | list):
            what = "a sequence pattern meets what is no tuple or list of the file"
            raise Refused(what, "unpack it first: a, b = x; then match (a, b), or test them")
        return len(value) == len(pattern.patterns) and all(
            self._matches(each, item, scope) for each, item in zip(pattern.patterns, value, strict=True)
        )

    # --- definitions and imports

    def _read_FunctionDef(self, node: ast.FunctionDef, scope: Scope) -> None:
        own = node.args.args[0].arg if node.name == "__init__" and node.args.args else ""
        for each in _within(node, self.sets):
            if getattr(each.value, "id", "") != own or not own:
                self.kept.setdefault(each.attr, set()).add(node)
        kinds = [each.id if isinstance(each, ast.Name) else "" for each in node.decorator_list]
        own_names = {name for each in scope for name, value in each.names.items() if isinstance(value, Function)}
        if own_names.intersection(kinds) or not {"staticmethod", "classmethod", "property"}.issuperset(kinds):
            what = f"the decorator {escape_text(text_of(node.decorator_list[0]))!r} may change the function"
            raise Refused(what, "remove it")
        stored = _within(node, self.stores)
        local = frozenset(getattr(each, "asname", None) or getattr(each, "id", None) or each.name for each in stored)
        signature = self._signature_of(node.args, scope)
        kind = kinds[0] if kinds else ""
        scope.names[node.name] = Function(node.name, node, scope.outer, signature, kind, local)

    def _read_Import(self, node: Any, scope: Scope) -> None:
        """Known modules; all other names are an error where a decision reads them."""
        for each in node.names:
            name = each.asname or each.name
            what = "a random number is drawn" if name == "random" else f"{escape_text(name)} comes from elsewhere"
            unread = Refused(what, ELSEWHERE)
            if isinstance(node, ast.Import):
                scope.names[name.split(".")[0]] = MODULES.get(each.name, unread)
            else:
                self.numpy |= node.module == "numpy"
                known = MODULES.get(node.module or "")
                scope.names[name] = known.members.get(each.name, unread) if known else unread

    _read_ImportFrom = _read_Import

    def _read_ClassDef(self, node: ast.ClassDef, scope: Scope) -> None:
        if self.paths is not None:
            raise Refused("a class is made by a decision", "write it outside the function")
        title, bases = f"the class {escape_text(node.name)}", [self.eval(each, scope) for each in node.bases]
        names = [getattr(each, "name", "") for each in bases]
        decorators = [self._decorator_of(each, scope) for each in node.decorator_list]
        members: dict[str, Any] = {}
        self.block(node.body, Scope(members, scope, of_class=True))
        if any(isinstance(each, enum.EnumType) for each in bases):
            # Python's own Enum of constants: which members are one, and equal to numbers and texts, it knows itself
            mixed = {"str": str, "int": int, "float": float}
            kinds = [mixed.get(getattr(each, "name", "")) for each in bases[:-1]]
            constant = (int, float, str, tuple) if kinds else (int, float, str, tuple, enum.auto)
            odd = [key for key, value in members.items() if key.startswith("_") or not isinstance(value, constant)]
            by_itself = {isinstance(each, enum.auto) for each in members.values()}
            kinds += [None] if len(by_itself) > 1 else []  # which versions number differently
            if odd or len(kinds) > 1 or None in kinds or bases[-1] not in (enum.Enum, enum.IntEnum):
                what = f"{odd[0]} of the Enum {node.name}" if odd else f"the Enum {node.name}"
                raise Refused(f"{escape_text(what)} is not understood", "write members and constants: GO = 1")
            scope.names[node.name] = bases[-1](node.name, list(members.items()), type=kinds[0] if kinds else None)
            return
        if node.keywords or not set(PLAIN).issuperset(names):
            raise Refused(f"{title} is built on another class", "write one class with all its methods")
        magic = [each for each in members if each.startswith("__") and each not in ("__init__", "__call__")]
        if magic:
            what = f"{title} has {escape_text(magic[0])}, which Python calls by itself"
            raise Refused(what, "give the method a name without underscores, and call it")
        kind = Class(node.name, members)
        if "dataclasses.dataclass" in decorators or {"typing.NamedTuple", "typing.TypedDict"} & {*names}:
            annotated = [each for each in node.body if isinstance(each, ast.AnnAssign)]
            annotated = [each for each in annotated if "ClassVar" not in ast.unparse(each.annotation)]
            kind.fields = tuple(each.target.id for each in annotated if isinstance(each.target, ast.Name))
        scope.names[node.name] = kind

    def _decorator_of(self, node: ast.expr, scope: Scope) -> str:
        """The name of a decorator of a class that changes nothing which is read. InputError for others."""
        settings = node.keywords if isinstance(node, ast.Call) else []
        called = self.eval(node.func if isinstance(node, ast.Call) else node, scope)
        name = called.name if isinstance(called, Bound) else ""
        known = name in ("dataclasses.dataclass", "enum.unique") and not getattr(node, "args", ())
        if not known or any(each.arg not in SETTINGS for each in settings):
            raise Refused(f"{text_of(node)} is not understood", "write @dataclass, or __init__")
        return name

    def make_object(self, kind: Class, given: Sequence[Any], named: Mapping[str, Any]) -> Any:
        """The object that calling a class gives."""
        made = self.keep_value(Instance(kind))
        if self.paths is None:
            self.made.add(kind)
        maker = kind.members.get("__init__")
        if isinstance(maker, Function):
            self.apply(maker, [made, *given], named)
            return made
        places = Parameter.POSITIONAL_OR_KEYWORD
        fields = [Parameter(each, places, default=kind.members.get(each, Parameter.empty)) for each in kind.fields]
        for name, value in bind_arguments(Signature(fields), given, named).items():
            new = isinstance(value, Bound) and value.name == FACTORY
            made.attributes[name] = self.call(value, [], {}) if new else value
        return made


READERS: dict[type[ast.AST], Callable[[Machine, Any, Scope], Any]] = {
    getattr(ast, name.removeprefix("_read_")): reader
    for name, reader in vars(Machine).items()
    if name.startswith("_read_")
}


def bind_arguments(signature: Signature, given: Sequence[Any], named: Mapping[str, Any]) -> dict[str, Any]:
    """Returns the values of parameters in a call."""
    bound = signature.bind(*given, **named)
    bound.apply_defaults()
    return dict(bound.arguments)


# --- nodes


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
        for name in each._fields if type(each) not in stop else ():
            if name not in UNWALKED:
                value = getattr(each, name, None)
                if type(value) is list:
                    nodes += [one for one in value if isinstance(one, ast.AST)]
                elif isinstance(value, ast.AST):
                    nodes.append(value)
    return nodes


def may_go_unread(node: ast.AST) -> bool:
    """Returns True if looking at the parts of a node changes nothing, since it calls and assigns nothing."""
    below: Iterable[ast.AST] = ast.walk(node)
    return not any(isinstance(each, ast.Call | ast.NamedExpr) and each is not node for each in below)


def _cannot_fail(node: ast.AST) -> bool:
    """Returns True if looking at an expression cannot fail, whatever precedes it: its subscripts are literals."""
    written = isinstance(node, ast.Subscript) and isinstance(node.slice, ast.Constant | ast.UnaryOp)
    return (written or isinstance(node, SAFE)) and all(map(_cannot_fail, ast.iter_child_nodes(node)))


def _within(node: ast.FunctionDef, nodes: Sequence[Any]) -> list[Any]:
    """Those of the nodes that stand within a function."""
    last = node.end_lineno or node.lineno
    return [each for each in nodes if node.lineno <= each.lineno <= last and each is not node]
