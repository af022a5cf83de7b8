"""Python that decides, as decision trees: one for each function or class of a file that takes an observation.

Does: evaluates what stands outside functions; finds the functions, methods and lambdas that take an observation and
  return a decision, and are no parts of others; follows each along all of its paths (machine.py), with the numbers of
  the observation as features; makes labels of what they return.
Assumes: Python's own grammar (the module ast); a caller that hands over observations as numbers.
Does not: run or import anything of the file. What has no meaning as a tree is refused with its line.

What is not understood outside functions is skipped with a word, if it can change nothing of the file: names that it
sets are an error where a decision reads them.

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
from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from inspect import Parameter
from typing import Any, NamedTuple, cast

import numpy as np

from codegen.errors import InputError, escape_text
from codegen.floats import FLOAT32, FLOAT64
from codegen.importers.python.library import (
    CONDITIONS,
    Class,
    Extreme,
    Function,
    Inputs,
    Instance,
    Part,
    Refused,
    words_of,
)
from codegen.importers.python.machine import (
    ARRAYS_ADVICE,
    FAILURES,
    UNSET,
    Machine,
    Slot,
    bind_arguments,
    text_of,
    walk_nodes,
)
from codegen.importers.reading import FLOATS, MAX_FEATURES, NOTHING, Kept, Origin, Said
from codegen.importers.running.asking import PYTHON, Called, ensure_gated, run_source
from codegen.importers.symbolic.feature import IN_ORDER, NO_SUM, Affine, Feature, Given, Sums, is_whole
from codegen.importers.symbolic.memory import MAX_MEMBERS, RESETS, Memories, Memory, RemembersError
from codegen.importers.symbolic.paths import STATE_ADVICE, Described, Growth, Value, origin_of, rounds
from codegen.importers.symbolic.statements import Scope, link_statements
from codegen.memory import MAX_VALUE
from codegen.process import silence_warnings

KIND = "if/else Python"
MAX_BITS = 1 << 12  # of a returned integer; Python writes out no more than some thousand digits
RETURN_ADVICE = "return a number, a text, a name or a list of numbers"
GIVEN = {
    "": "Python's floats, or float64 arrays", FLOATS: "Python's floats",
    FLOAT32: "float32 arrays of NumPy 2", FLOAT64: "float64 arrays",
}  # fmt: skip
FORMS = {"": [FLOATS, FLOAT64], FLOATS: [FLOATS], FLOAT64: [FLOAT64], FLOAT32: [FLOAT32]}  # in which a source is asked
MAGIC = frozenset(
    ("exec", "eval", "globals", "locals", "vars", "setattr", "delattr", "compile", "__import__", "__builtins__")
)
KNOWN = ("__name__", "__init__")
PLAYING = frozenset(("step", "reset", "render"))  # of an environment: whoever calls it plays
USUAL = ("__call__", "act", "decide", "predict", "select_action", "choose_action", "get_action", "policy", "control",
         "compute_action", "step", "forward", "action")  # fmt: skip
HELD = (list, dict, Function, Class, Instance)  # what a call may change
INNER = (ast.FunctionDef, ast.ClassDef, ast.Lambda)
STORING = (ast.Name, *INNER[:2], ast.alias, ast.MatchAs)
ALONE = "say --agents {}=FILE to take this function alone"
MAIN = 'put what only demonstrates the controller under if __name__ == "__main__":'


def from_python(text: bytes, where: str, said: Said = NOTHING) -> dict[str, Origin]:
    """The tree of each function that decides in a file of Python, by its name. InputError with the line for everything
    that is no such file.
    """
    try:
        with silence_warnings():  # about spellings, which would stand on the screen
            parsed = ast.parse(text)
            compile(parsed, "file", "exec", dont_inherit=True)  # refuses what the grammar allows: a parameter twice
            with np.errstate(all="ignore"):
                file = read_file(parsed, Machine(where, said.arrays))
            chosen = choose_deciders(file, said.wanted)
            return {each.name: _origin(file, each, said, len(chosen), text.decode("latin-1")) for each in chosen}
    except (RecursionError, MemoryError):
        raise InputError("the file is nested too deeply", where, "simplify it first") from None
    except (SyntaxError, ValueError) as error:  # the latter for a null byte
        line = getattr(error, "lineno", None)
        what = f"not Python: {escape_text(getattr(error, 'msg', error))}"
        raise InputError(what, f"{where}, line {line}" if line else where, "Python must be able to read it") from None


# --- the file


class Decider(NamedTuple):
    """A function that decides, and what stands before the observation: the object whose method it is."""

    name: str
    function: Function
    first: tuple[Any, ...] = ()


class File(NamedTuple):
    """The contents of a file."""

    scope: Scope
    nodes: Mapping[type[ast.AST], Sequence[Any]]  # by their kinds
    machine: Machine

    def inside(self, node: Any, *kinds: type[ast.AST]) -> list[Any]:
        """The nodes of these kinds within a function."""
        first, last = node.lineno, node.end_lineno
        return [each for kind in kinds for each in self.nodes.get(kind, ()) if first <= each.lineno <= last]


def _stores(node: Any) -> bool:
    """Returns True if a node gives something to a name, an attribute or an element."""
    return not isinstance(getattr(node, "ctx", None), ast.Load)


def read_file(parsed: ast.Module, m: Machine) -> File:
    """A file, evaluated but for its functions. InputError for what may give names other meanings."""
    nodes = defaultdict[type[ast.AST], list[Any]](list)
    for node in walk_nodes(parsed):
        nodes[type(node)].append(node)
    odd = [each for each in nodes[ast.Name] if each.id in MAGIC]
    odd += [each for each in nodes[ast.Attribute] if each.attr[:2] == "__" == each.attr[-2:] and each.attr not in KNOWN]
    odd += [each for each in nodes[ast.ImportFrom] if each.names[0].name == "*"]
    annotations = [each.annotation for each in (*nodes[ast.arg], *nodes[ast.AnnAssign])]
    for annotation in filter(None, (*annotations, *(each.returns for each in nodes[ast.FunctionDef]))):
        odd += [each for each in ast.walk(annotation) if isinstance(each, ast.Call | ast.NamedExpr)]
    if odd:
        what = f"{text_of(odd[0])!r} may change what names stand for"
        raise m.make_error(odd[0], Refused(what, "remove it; import names one by one, and annotate with types only"))
    m.stores = [each for kind in STORING for each in nodes[kind] if _stores(each)]
    m.sets = [each for each in nodes[ast.Attribute] if _stores(each)]
    scope = Scope({"__name__": "policy"})
    for node in parsed.body:
        try:
            m.run(node, scope)
        except InputError as error:
            if m.steps > 1 << 22:
                raise
            # a statement that can change nothing of the file is skipped: names that it sets are not known any more
            inner = walk_nodes(node, INNER)
            held = [scope.names.get(each.id) for each in inner if isinstance(each, ast.Name)]
            changes = any(isinstance(each, ast.Attribute | ast.Subscript) and _stores(each) for each in inner)
            if changes or any(isinstance(each, HELD) for each in held):  # what changes may have other names
                raise InputError(error.what, error.where, f"{error.next_step}; or {MAIN}") from None
            for each in inner:
                if isinstance(each, STORING) and _stores(each):
                    name = each.id if isinstance(each, ast.Name) else each.name
                    scope.names[name or ""] = Refused(error.what, error.next_step, f"{m.where}, line {node.lineno}")
            m.notes[f"line {node.lineno}: {text_of(node)} is skipped: {error.what}"] = None
    for node in nodes[ast.Global]:
        for name in node.names:
            where = f"{m.where}, line {node.lineno}"
            scope.names[name] = Refused(f"{escape_text(name)!r} may change between calls", STATE_ADVICE, where)
    return File(scope, nodes, m)


# --- which functions decide


def choose_deciders(file: File, wanted: str = "") -> list[Decider]:
    """The functions that decide; `wanted`: the only one that is asked for, if there is one of that name."""
    names = {name: value for name, value in file.scope.names.items() if isinstance(value, Function | Class | Instance)}
    chosen = names.get(wanted)
    if isinstance(chosen, Function):
        return [Decider(wanted, chosen)]
    made = {id(each.kind) for each in names.values() if isinstance(each, Instance)}
    by_name: dict[str, Decider] = {}
    for name, value in names.items():
        if isinstance(value, Class) and id(value) in made:
            continue
        decider = Decider(name, value) if isinstance(value, Function) else _choose_method(file, name, value)
        why = _idle(file, decider) if decider else ""
        if why:
            file.machine.notes[f"{escape_text(name)} is skipped: it {why}"] = None
        elif decider and decider[1:] not in [each[1:] for each in by_name.values()]:
            by_name[name] = decider
    if chosen is not None and wanted in by_name:
        return [by_name[wanted]]
    if not by_name:
        if not any(file.nodes[kind] for kind in INNER):
            advice = "write def agent(x): ... and return the action"
            raise InputError("no function: put the rule into one", file.machine.where, advice)
        for each in file.scope.names.values():
            if isinstance(each, Refused) and each.where:
                raise InputError(each.what, each.where, each.next_step)
        what = "the file has no function that takes an observation and returns a decision"
        advice = "; ".join(("write one function per agent: def agent(x): ...", *file.machine.notes))
        raise InputError(what, file.machine.where, advice[:300])
    used = {inner for name, each in by_name.items() for inner in _names(file, each) if inner != name}
    roots = [each for name, each in by_name.items() if name not in used]
    # a class whose objects the file makes is a part of something, if anything else decides
    whole = [each for each in roots if not file.machine.made.intersection(each.first)]
    return whole or roots or list(by_name.values())


def _choose_method(file: File, name: str, value: Class | Instance) -> Decider | None:
    """The method of a class that decides."""
    kind = value if isinstance(value, Class) else value.kind
    public = [each for each in kind.members.values() if isinstance(each, Function) and each.kind != "property"]
    public = [each for each in public if each.name == "__call__" or not each.name.startswith("_")]
    given = [Decider(name, each, () if each.kind == "staticmethod" else (value,)) for each in public]
    taking = [each for each in given if not _idle(file, each)]
    used = {inner.attr for each in taking for inner in file.inside(each.function.node, ast.Attribute)}
    roots = [each for each in taking if each.function.name not in used] or taking
    usual = [each for wanted in USUAL for each in roots if each.function.name == wanted]
    if len(roots) > 1 and not usual:
        several = ", ".join(each.function.name for each in roots)
        what = f"the class {escape_text(kind.name)} has several methods that may decide: {several}"
        raise file.machine.make_error(roots[1].function.node, Refused(what, "name the one that decides act"))
    return next(iter(usual or roots), None)


def _idle(file: File, decider: Decider) -> str:
    """Why a function decides nothing; "": it may."""
    node, takes = decider.function.node, decider.function.signature.parameters.values()
    required = [each for each in takes if each.default is Parameter.empty]
    if len(required) <= len(decider.first) and not (node.args.vararg or node.args.kwarg):
        return "takes no observation"
    if isinstance(node, ast.FunctionDef) and all(each.value is None for each in file.inside(node, ast.Return)):
        return "returns nothing"
    called = [each.func for each in file.inside(node, ast.Call)]
    if any(isinstance(each, ast.Attribute) and each.attr in PLAYING for each in called):
        return "plays an environment"
    return ""


def _names(file: File, decider: Decider) -> set[str]:
    """The names that a function, or the class whose method it is, mentions."""
    nodes: list[ast.AST] = [decider.function.node]
    for each in decider.first:
        kind = each if isinstance(each, Class) else each.kind
        nodes += [one.node for one in kind.members.values() if isinstance(one, Function)]
    return {inner.id for node in nodes for inner in file.inside(node, ast.Name)}


# --- one function


def _origin(file: File, decider: Decider, said: Said, count: int, source: str) -> Origin:
    """The origin of a function. InputError also for sums whose arithmetic nobody states."""
    width, kept = len(said.features), _Kept()
    while True:  # again, where a later line says how many features there are, or a path sets what is remembered
        follower = _Follower(file, decider, said, kept)
        m = follower.machine
        m.inputs.width = width
        try:
            origin = origin_of(
                follower.run, m.where, follower.describe_program, m.kind or FLOAT64, m.sums, kept.memories.list_ranges()
            )
            if kept.memories.widen():
                continue
            if not said.arrays and rounds(origin):
                what = "sums of features are computed, and their roundings depend on the numbers that are given"
                raise InputError(what, f"{m.where}, line {m.sums.line}", ARRAYS_ADVICE)
            return follower.ask_python(origin, source)
        except RemembersError as found:
            kept.names.append(str(found))
            kept.begin(follower, file)
        except InputError as error:
            if m.inputs.width != width:
                width = m.inputs.width
                continue
            more = f"; or {ALONE.format(escape_text(decider.name))}" if count > 1 else ""
            raise InputError(error.what, error.where, f"{error.next_step}{more}") from None


@dataclass
class _Kept:
    """What a decision remembers, as far as it is known: attributes of its object, and their ranges."""

    names: list[str] = field(default_factory=list[str])
    slots: dict[str, Slot] = field(default_factory=dict[str, Slot])
    memories: Memories = field(default_factory=lambda: Memories((), ""))

    def begin(self, follower: "_Follower", file: File) -> None:
        """Starts again with what the object holds now. InputError for what other functions set, too."""
        m, known = follower.machine, list[Memory]()
        methods = follower.first[0].kind.members.values()
        methods = {each.name: each.node for each in methods if isinstance(each, Function)}
        own, open_ = set[ast.AST](), [follower.function.node]  # what the decision may call, itself among them
        while open_:
            node = open_.pop()
            if node not in own:
                own.add(node)
                open_ += [methods[each.attr] for each in file.inside(node, ast.Attribute) if each.attr in methods]
        for at, name in enumerate(self.names):
            others = [each for each in m.kept.get(name, set()) - m.ran if each not in own]
            for each in others:
                called = getattr(each, "name", "")
                if not RESETS.fullmatch(called):
                    what = f"{escape_text(name)!r} is remembered, and {escape_text(called)} sets it, too"
                    raise m.make_error(each, Refused(what, "have the method that decides set it alone"))
            value = m.owner.attributes.get(name, m.owner.kind.members.get(name, UNSET))
            if not isinstance(value, bool | int | str | enum.Enum | None):
                what = f"what is remembered is no whole number, text, bool or member: {escape_text(name)}"
                if value is UNSET:
                    what = f"{escape_text(name)!r} is remembered, and __init__ does not set it"
                raise m.make_error(next(each for each in m.sets if each.attr == name), Refused(what, STATE_ADVICE))
            counted = type(value) is int
            self.slots[name] = Slot(at, None if counted else [value])
            ends = (-MAX_VALUE, MAX_VALUE) if counted else (0, MAX_MEMBERS)
            known.append(Memory(name, value if counted else 0, ends))
        self.memories = Memories(known, m.where)


class _Follower:
    """Follows one function along the paths that it is handed."""

    def __init__(self, file: File, decider: Decider, said: Said, kept: _Kept) -> None:
        self.kept = kept
        self.file, self.decider, self.said = file, decider, said
        # where no function changes a list or an object, or holds another one, a path may go on from any state
        kinds = (ast.FunctionDef, ast.Lambda, ast.Attribute, ast.Subscript)
        functions = file.nodes.get(ast.FunctionDef, ())
        inside = [each for node in functions for each in file.inside(node, *kinds) if each is not node]
        self.simple = not any(_stores(each) or getattr(each, "attr", "") == "append" for each in inside)
        self.function = decider.function
        self.members = dict[Any, enum.Enum | None]()  # by labels: what is returned for each; None: numbers are given
        self.machine = m = copy.copy(file.machine)
        m.where = f"{m.where}, function {escape_text(decider.name)}"
        self.first = [self._object(m, each) for each in decider.first]
        m.owner, m.slots = (self.first or [None])[0], kept.slots
        takes = [*self.function.signature.parameters.values()]
        has_default = [each.name for each in takes if each.default is not Parameter.empty]
        self.defaults = {*has_default} - {*said.features}
        self.keywords = [each.name for each in takes if each.kind is Parameter.KEYWORD_ONLY]
        self.places = [each.name for each in takes if each.name not in self.keywords][len(self.first) :]
        given = [name for name in (*self.places, *self.keywords) if name not in self.defaults]
        m.sums, m.inputs = Sums(m.kind or FLOAT64), Inputs(tuple(given), first=len(kept.slots))
        m.notes, m.called, m.finite = dict(m.notes), {}, False
        arguments = self.function.node.args
        for each in (*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs):
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
            return m.make_object(given, [], {})
        except (InputError, *FAILURES) as error:
            where = getattr(error, "where", "") or f"{m.where}, line {self.function.node.lineno}"
            what = getattr(error, "what", f"{given.name}() fails with {escape_text(error)[:80]}")
            advice = f"give defaults, or make one in the file: agent = {given.name}(...)"
            raise InputError(what, where, advice) from None

    def run(self, paths: Growth, state: Any) -> Value:
        """Runs the function on the present path, and returns its value."""
        m, function = self.machine, self.function
        m.paths, m.fresh, m.held, m.depth = paths, {}, {}, 0
        if state is None:
            m.ensure_named(function)
            named = {name: Part((name,)) for name in m.inputs.parameters}
            body = function.node.body
            if isinstance(body, ast.expr):  # of a lambda
                body = [ast.copy_location(ast.Return(body), body)]
            scope = Scope(bind_arguments(function.signature, self.first, named), function.scope, function.local)
            state = m.keep(link_statements(body, scope))
        open_, names = state
        try:
            if open_ is not None:
                open_[1].names = dict(names)
            end = m.follow(open_, marks=self.simple)
            label = self._label(end.value if end else None)
            if not m.slots:
                return label
            return cast(Any, Kept(label, self.kept.memories.settle(paths, [m.settle(each) for each in m.slots])))
        except FAILURES as error:
            raise m.make_error(None, error) from None

    def _label(self, value: Any) -> Value:
        """Turns what is returned into a label."""
        while isinstance(value, list | tuple) and len(value) == 1 and not isinstance(value[0], str):
            value = value[0]  # a list of one number is that number
        member = value if isinstance(value, enum.Enum) else None
        if member is not None:
            value = member.value if isinstance(member.value, int | float | str) else member.name
            if value != member.name:
                self.machine.called.setdefault(value, member.name)
        label = self._plain_label(value)
        self._ensure_alike(label, member)
        return label

    def _ensure_alike(self, label: Value, member: enum.Enum | None) -> None:
        """InputError where one label is a member of an Enum on some paths only, or of another one."""
        known = self.members.setdefault(None if isinstance(label, Given) else label, member)
        mixed = None in self.members and any(each is not None for each in self.members.values())
        if known is not member or mixed:
            what = "a member of an Enum is returned, and elsewhere a number or a text that may be taken for it"
            raise Refused(what, "return members of one Enum on every path, or numbers on every path")

    def _plain_label(self, value: Any) -> Value:
        m = self.machine
        if type(value) is int and not self.said.outputs and value.bit_length() <= MAX_BITS:
            return value  # most are this
        if isinstance(value, CONDITIONS):
            return m.truth(value)
        parts = [*value] if isinstance(value, list | tuple) else [value]
        whole = isinstance(value, Part) and value.path == m.inputs.parameters  # the observation itself
        if parts and not (whole or self.said.scores or any(isinstance(each, str | list | tuple) for each in parts)):
            # numbers are given where the user says so, or where they depend on features
            numbers = [m.plain(each) for each in parts if isinstance(each, Feature | Part)]
            if self.said.outputs or any(not (isinstance(each, Feature) and is_whole(each)) for each in numbers):
                forms = list[Affine]()
                for part in map(m.plain, parts):
                    if isinstance(part, Extreme):
                        raise Refused(NO_SUM, IN_ORDER)
                    given = part if isinstance(part, Feature) else self._number(part)
                    forms.append(m.sums.represent(given, Refused))
                    m.sums.line = m.sums.line or m.line
                return cast(Any, Given(forms))
        if isinstance(value, list | tuple) and value:
            return tuple(self._number(each) for each in value)
        return value if isinstance(value, str) else self._number(value)

    def _number(self, value: Any) -> int | float:
        """A number that is returned, or counts as a score; of a condition, or of a feature that is a whole number, what
        it is on this path.
        """
        m = self.machine
        value = m.truth(value) if isinstance(value, CONDITIONS) else m.whole(value)
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
        for name, slot in m.slots.items():
            spelled = [f"{at} for {escape_text(_spell(each)[1])}" for at, each in enumerate(slot.values or ())]
            if spelled:
                m.notes[f"{escape_text(name)} is {', '.join(spelled)}"] = None
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

    def ask_python(self, origin: Origin, source: str) -> Origin:
        """The origin that Python itself answers for, unless nothing is to be run. InputError where the gate refuses."""
        m, shapes = self.machine, dict(self.shapes)
        required = [name for name in self.places if name not in self.defaults]
        plain = [name for name, own in zip(self.places, required, strict=False) if name == own]
        called = Called(
            source=source,
            where=m.where,
            entry=self.decider.name,
            method="" if isinstance(self.file.scope.names[self.decider.name], Function) else self.function.name,
            made=not self.function.kind,
            given=[shapes.pop(name) for name in plain],
            named=shapes,
            forms=FORMS[self.said.arrays],
            scores=self.said.scores,
            kept=[(name, each.values and [*map(_spell, each.values)]) for name, each in m.slots.items()],
        )
        if self.said.run:  # the process has its own gate
            return replace(origin, second=partial(run_source, called, origin))
        ensure_gated(called)
        return origin

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
        """Collects the source's names of its labels, where it uses a name for one as a value. A gain of 2.0 is no name
        of the action 2, though both are equal; nor is `self.gain`, unless it is returned, nor what a function also
        calls something of its own.
        """
        nodes, names = self.file.nodes, dict(self.machine.called)
        stored = Counter(each.id for each in nodes[ast.Name] if isinstance(each.ctx, ast.Store))
        stored.update(each.arg for each in nodes[ast.arg])
        floats = {each: isinstance(each, float) for each in self.members}
        returned = [each.value for each in nodes[ast.Return]]
        used = [each.value for kind in (ast.Return, ast.Assign, ast.AnnAssign) for each in nodes[kind]]
        used += [each.body for kind in (ast.IfExp, ast.Lambda) for each in nodes[kind]]
        used += [each.orelse for each in nodes[ast.IfExp]]
        used += [one for kind in (ast.List, ast.Tuple) for each in nodes[kind] for one in each.elts]
        used += [one for each in nodes[ast.Dict] for one in each.values]
        for each in _in_order(each for each in used if isinstance(getattr(each, "ctx", None), ast.Load)):
            own = isinstance(each, ast.Attribute) and getattr(each.value, "id", "") not in self.file.scope.names
            twice = isinstance(each, ast.Name) and stored[each.id] > 1
            name, held = ("", None) if twice or (own and each not in returned) else self._constant(each)
            if type(held) in (int, float) and floats.get(held) is isinstance(held, float):
                names.setdefault(held, name)
        return names


def _spell(value: Any) -> tuple[str, Any]:
    """A value that is remembered, for the process: a member by its class and name."""
    return (type(value).__name__, value.name) if isinstance(value, enum.Enum) else ("", value)


def _in_order(nodes: Iterable[Any]) -> list[Any]:
    """Nodes in the order of the text."""
    return sorted(nodes, key=lambda node: (node.lineno, node.col_offset))
