"""Python that decides, as decision trees: one for each function or class of a file that takes an observation.

Does: follows functions along all of their paths (machine.py), with the numbers of the observation as features; makes
  labels of what they return.
Assumes: Python's own grammar (the module ast); a caller that hands over observations as numbers.
Does not: run or import anything of the file. What has no meaning as a tree is refused with its line.

Python compares doubles, so that each test can be kept exactly. An element of a NumPy array is no Python float: NumPy 2
first makes the other number one of the array's type, so that float32 arrays meet float32(0.1), not 0.1. Only the caller
knows which it is: `Said.arrays`.
"""

# pyright: basic
# the values of a program may be anything
import ast
import copy
import enum
import math
from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from codegen.errors import InputError, escape_text
from codegen.floats import FLOAT32, FLOAT64
from codegen.importers.origin import NOTHING, Origin, Said
from codegen.importers.python.file import ALONE, Decider, File, deciders, file_of
from codegen.importers.python.machine import ARRAYS_ADVICE, FAILURES, Machine
from codegen.importers.python.objects import instance_of
from codegen.importers.python.statements import follow, link_statements
from codegen.importers.python.values import (
    Class,
    Condition,
    Extreme,
    Function,
    Inputs,
    Instance,
    Part,
    Refused,
    Scope,
    words_of,
)
from codegen.importers.reading import FLOATS, MAX_FEATURES
from codegen.importers.running.asking import PYTHON, Called, run_source
from codegen.importers.symbolic.affine import IN_ORDER, NO_SUM, Affine, Given, Sums
from codegen.importers.symbolic.feature import Feature, Test
from codegen.importers.symbolic.paths import Growth
from codegen.importers.symbolic.program import Described, Value, origin_of, rounds
from codegen.process import silence_warnings

KIND = "if/else Python"
MAX_BITS = 1 << 12  # of a returned integer; Python writes out no more than some thousand digits
RETURN_ADVICE = "return a number, a text, a name or a list of numbers"
GIVEN = {
    "": "Python's floats, or float64 arrays", FLOATS: "Python's floats",
    FLOAT32: "float32 arrays of NumPy 2", FLOAT64: "float64 arrays",
}  # fmt: skip
FORMS = {"": [FLOATS, FLOAT64], FLOATS: [FLOATS], FLOAT64: [FLOAT64], FLOAT32: [FLOAT32]}  # in which a source is asked


def from_python(text: bytes, where: str, said: Said = NOTHING) -> dict[str, Origin]:
    """The tree of each function that decides in a file of Python, by its name. InputError with the line for everything
    that is no such file.
    """
    try:
        with silence_warnings():  # about spellings, which would stand on the screen
            parsed = ast.parse(text)
            compile(parsed, "file", "exec", dont_inherit=True)  # refuses what the grammar allows: a parameter twice
            with np.errstate(all="ignore"):
                file = file_of(parsed, Machine(where, said.arrays))
            chosen = deciders(file, said.wanted)
            source = text.decode("latin-1") if said.run else ""
            return {each.name: _origin(file, each, said, len(chosen), source) for each in chosen}
    except (RecursionError, MemoryError):
        raise InputError("the file is nested too deeply", where, "simplify it first") from None
    except (SyntaxError, ValueError) as error:  # the latter for a null byte
        line = getattr(error, "lineno", None)
        what = f"not Python: {escape_text(getattr(error, 'msg', error))}"
        raise InputError(what, f"{where}, line {line}" if line else where, "Python must be able to read it") from None


def _origin(file: File, decider: Decider, said: Said, count: int, source: str) -> Origin:
    """The origin of a function. InputError also for sums whose arithmetic nobody states."""
    width = len(said.features)
    while True:  # again, where a later line says how many features there are
        follower = _Follower(file, decider, said)
        m = follower.machine
        m.inputs.width = width
        try:
            origin = origin_of(follower.run, m.where, follower.describe_program, m.kind or FLOAT64, m.sums)
            if not said.arrays and rounds(origin):
                what = "sums of features are computed, and their roundings depend on the numbers that are given"
                raise InputError(what, f"{m.where}, line {m.sums.line}", ARRAYS_ADVICE)
            return follower.ask_python(origin, decider, source)
        except InputError as error:
            if m.inputs.width != width:
                width = m.inputs.width
                continue
            more = f"; or {ALONE.format(escape_text(decider.name))}" if count > 1 else ""
            raise InputError(error.what, error.where, f"{error.next_step}{more}") from None


class _Follower:
    """Follows one function along the paths that it is handed."""

    def __init__(self, file: File, decider: Decider, said: Said) -> None:
        self.file, self.function, self.said, self.simple = file, decider.function, said, file.simple
        self.machine = m = copy.copy(file.machine)
        m.where = f"{m.where}, function {escape_text(decider.name)}"
        self.first = [self._object(m, each) for each in decider.first]
        takes = self.function.node.args
        places = [each.arg for each in (*takes.posonlyargs, *takes.args)][len(self.first) :]
        self.defaults = {name for name in self.function.defaults if name not in said.features}
        self.names = [name for name in places if name not in self.defaults]
        self.keywords = [each.arg for each in takes.kwonlyargs if each.arg not in self.defaults]
        m.sums = Sums(m.kind or FLOAT64)
        m.inputs = Inputs((*self.names, *self.keywords))
        m.notes, m.called, m.finite = dict(m.notes), {}, False
        for each in (*takes.posonlyargs, *takes.args, *takes.kwonlyargs):
            kind = file.scope.names.get(each.annotation.id) if isinstance(each.annotation, ast.Name) else None
            if isinstance(kind, Class) and kind.fields:
                m.inputs.names = kind.fields
        for each in file.inside(self.function.node, ast.Subscript):  # also in a test that decides nothing
            place = each.slice.value if isinstance(each.slice, ast.Constant) else None
            if type(place) is int and (getattr(each.value, "id", ""),) == m.inputs.parameters:
                m.inputs.n_read = max(m.inputs.n_read, place + 1 if place < MAX_FEATURES else 0)

    def _object(self, m: Machine, given: Any) -> Any:
        """The object whose method decides."""
        if not isinstance(given, Class) or self.function.kind == "classmethod":
            return given
        try:
            return instance_of(m, given, [], {}, self.function.node)
        except InputError as error:
            advice = f"give defaults, or make one in the file: agent = {given.name}(...)"
            raise InputError(error.what, error.where, advice) from None

    def run(self, paths: Growth, state: Any) -> Value:
        """Runs the function on the present path, and returns its value."""
        m, function = self.machine, self.function
        m.paths, m.fresh, m.depth = paths, {}, 0
        if state is None:
            named = {each: Part((each,)) for each in self.keywords}
            named |= {each: Part((each,)) for each in self.names}
            names = m.bind_arguments(function, self.first, named)
            body = function.node.body
            if isinstance(body, ast.expr):  # of a lambda
                body = [ast.copy_location(ast.Return(body), body)]
            state = link_statements(body, None), names
        rest, names = state
        try:
            end = follow(m, rest, Scope(dict(names), function.scope, function.local), marks=self.simple)
            return self._label(end.value if end else None)
        except FAILURES as error:
            raise m.make_error(None, error) from None

    def _label(self, value: Any) -> Value:
        """Turns what is returned into a label."""
        m = self.machine
        if type(value) is int and not self.said.outputs and value.bit_length() <= MAX_BITS:
            return value  # most are this
        while isinstance(value, list | tuple) and len(value) == 1 and not isinstance(value[0], str):
            value = value[0]  # a list of one number is that number
        if isinstance(value, enum.Enum):
            plain = value.value if isinstance(value.value, int | float | str) else value.name
            if plain != value.name:
                m.called.setdefault(plain, value.name)
            return self._label(plain)
        if isinstance(value, Test | Condition):
            return m.truth(value)
        if self._gives(value):
            return self._build_given(list(value) if isinstance(value, list | tuple) else [value])
        if isinstance(value, list | tuple) and value:
            return tuple(self._number(each) for each in value)
        return value if isinstance(value, str) else self._number(value)

    def _gives(self, value: Any) -> bool:
        """Returns True if numbers are given: the user says so, or they depend on features."""
        parts = [*value] if isinstance(value, list | tuple) else [value]
        if isinstance(value, Part) and len(value.path) == 1 == len(self.names) + len(self.keywords):
            return False  # the observation itself
        if self.said.scores or not parts or any(isinstance(each, str | list | tuple) for each in parts):
            return False
        numbers = [self.machine.plain(each) for each in parts if isinstance(each, Feature | Part)]
        fractional = [each for each in numbers if not (isinstance(each, Feature) and self.machine.counts(each))]
        return bool(fractional or self.said.outputs)

    def _build_given(self, parts: list[Any]) -> Any:
        """Returns what is given, as a form for each output."""
        m, forms = self.machine, list[Affine]()
        for each in parts:
            value = m.plain(each)
            if isinstance(value, Extreme):
                raise Refused(NO_SUM, IN_ORDER)
            given = value if isinstance(value, Feature) else self._number(value)
            forms.append(m.sums.represent(given, Refused))
            m.sums.line = m.sums.line or m.line
        return Given(forms)

    def _number(self, value: Any) -> Any:
        m = self.machine
        if isinstance(value, Extreme):
            raise Refused(NO_SUM, IN_ORDER)
        value = m.truth(value) if isinstance(value, Test | Condition) else m.whole(value)
        value = value.item() if isinstance(value, np.generic) else getattr(value, "value", value)
        if isinstance(value, int) and value.bit_length() > MAX_BITS:
            raise Refused("a number is too long for a name", "return a shorter one")
        if not isinstance(value, int | float) or not math.isfinite(value):
            if value is None:
                raise Refused("a path ends without a return, or returns None", "return an action on every path")
            raise Refused(f"what is returned is no label: {words_of(value)}", RETURN_ADVICE)
        return value

    def describe_program(self) -> Described:
        """Describes what is known once all paths were followed."""
        m = self.machine
        texts = [each for each in self.file.nodes[ast.Constant] if isinstance(each.value, str)]
        for each in sorted(self.defaults):
            m.notes[f"{escape_text(each)} is what its default says, unless --features names it"] = None
        plain = Described(
            kind=KIND,
            replayed_by=PYTHON,
            given=GIVEN[self.said.arrays],
            order=[each.value for each in _in_order(texts)],
            called=self._collect_names(),
            scores=self.said.scores,
            finite=m.finite,
            notes=tuple(m.notes),
        )
        described = m.inputs.describe_inputs(plain)
        self.shapes = m.inputs.shape_parameters(described)
        return described

    def ask_python(self, origin: Origin, decider: Decider, source: str) -> Origin:
        """The origin that Python itself answers for; without a source, nobody does."""
        if not source:
            return origin
        m, takes, shapes = self.machine, self.function.node.args, dict(self.shapes)
        first = [each.arg for each in (*takes.posonlyargs, *takes.args)][len(self.first) :]
        plain = [name for name, own in zip(first, self.names, strict=False) if name == own]
        called = Called(
            source=source,
            where=m.where,
            entry=decider.name,
            method="" if isinstance(self.file.scope.names[decider.name], Function) else self.function.name,
            made=not self.function.kind,
            given=[shapes.pop(name) for name in plain],
            named=shapes,
            forms=FORMS[self.said.arrays],
            scores=self.said.scores,
        )
        return replace(origin, second=partial(run_source, called, origin))

    def _constant(self, node: ast.expr) -> tuple[str, Any]:
        """The name of a constant of the file, or of a class, and the constant."""
        if isinstance(node, ast.Name):
            return node.id, self.file.scope.names.get(node.id)
        if not isinstance(node, ast.Attribute) or not isinstance(node.value, ast.Name):
            return "", None
        owner = self.file.scope.names.get(node.value.id, self.first[0] if self.first else None)
        kind = owner.kind if isinstance(owner, Instance) else owner
        return node.attr, kind.members.get(node.attr) if isinstance(kind, Class) else None

    def _collect_names(self) -> Mapping[Value, str]:
        """Collects the source's names of its numbers, where it uses a name for one as a value."""
        nodes, names = self.file.nodes, dict[Value, str]()
        used = [each.value for kind in (ast.Return, ast.Assign, ast.AnnAssign) for each in nodes[kind]]
        used += [each.body for kind in (ast.IfExp, ast.Lambda) for each in nodes[kind]]
        used += [each.orelse for each in nodes[ast.IfExp]]
        used += [one for kind in (ast.List, ast.Tuple) for each in nodes[kind] for one in each.elts]
        used += [one for each in nodes[ast.Dict] for one in each.values]
        for each in _in_order(each for each in used if isinstance(getattr(each, "ctx", None), ast.Load)):
            name, held = self._constant(each)
            if isinstance(held, int | float) and not isinstance(held, bool) and held == held:
                names.setdefault(held, name)
        return {**names, **self.machine.called}


def _in_order(nodes: Iterable[Any]) -> list[Any]:
    """Nodes in the order of the text."""
    return sorted(nodes, key=lambda node: (node.lineno, node.col_offset))
