"""If/else C as decision trees, one for each function of a file: such as m2cgen's C, or written by hand.

Does: reads a file's syntax tree: ifs, comparisons of a feature with a number, what is returned, or copied to `output`.
Assumes: what pycparser reads is what a compiler reads; a compiler without fast-math.
Does not: run anything, expand macros, or read what a file includes. Whatever is not understood is refused
  with its line.

A function takes one array of float or double, or one parameter a feature. C compares a float with a double as doubles,
and so every comparison is one of exact values (numbers.py), which rules.py keeps as it is. A function all of whose
numbers are double compares float64; any other one is taken for float32 observations.
"""

# pyright: basic
# pycparser's nodes have no declared attributes
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from pycparser import CParser, c_ast
from pycparser.c_parser import ParseError

from codegen.errors import InputError, shown
from codegen.floats import FLOAT32, FLOAT64
from codegen.importers.c import meaning
from codegen.importers.c.numbers import DOUBLE, EXACT, FLOAT, WHOLE, WHOLES, Literal, converted, fits, literal
from codegen.importers.c.refusals import ADVICE, NUMBER_ADVICE, TEST_ADVICE, kind_of, line_of, refused, text_of
from codegen.importers.c.text import plain
from codegen.importers.origin import NOTHING, Origin, Said
from codegen.importers.rules import (
    Condition,
    If,
    Joined,
    Not,
    Number,
    Return,
    Set,
    Statement,
    Value,
    compared,
    program,
)
from codegen.importers.symbolic.labels import labels_of
from codegen.ir import Floats, Int32

KIND, REPLAYED_BY = "if/else C", "an interpreter of the file's syntax tree"
TYPES = "".join(f"typedef int {name};" for name in WHOLES if name.endswith("_t") or name == "bool")
TURNED = {"<": ">", "<=": ">=", ">": "<", ">=": "<=", "==": "==", "!=": "!="}
MAX_FEATURES = 1 << 20


def from_c(content: bytes, where: str, said: Said = NOTHING) -> dict[str, Origin]:
    """The tree of each function in a file of if/else C, by the function's name. InputError with the line for everything
    that is no such file.
    """
    text = plain(content.decode(errors="replace"), where)
    try:
        parsed = CParser().parse(TYPES + text)
        return {name: _origin(node, names, where, said) for name, (node, names) in _functions(parsed, where).items()}
    except ParseError as error:
        at = re.match(r"[^:]*:(\d+):\d+: (.*)", str(error), re.DOTALL)
        place, what = (f"{where}, line {at[1]}", at[2]) if at else (where, str(error))
        raise InputError(f"not C that is understood: {shown(what)[:100]}", place, ADVICE) from None
    except RecursionError:
        raise InputError("the file is nested too deeply", where, "simplify it first") from None


# --- a file


@dataclass(frozen=True)
class _Known:
    """What names stand for in the whole file."""

    enumerators: Mapping[str, int]
    constants: Mapping[str, Literal]


def _functions(parsed: Any, where: str) -> dict[str, tuple[Any, _Known]]:
    """The functions of a file, and what its names stand for."""
    functions: dict[str, Any] = {}
    enumerators: dict[str, int] = {}
    constants: dict[str, Literal] = {}
    for node in parsed.ext:
        if isinstance(node, c_ast.Typedef) and node.name in WHOLES:
            continue
        if isinstance(node, c_ast.FuncDef) and node.decl.name not in functions:
            functions[node.decl.name] = node
        elif isinstance(node, c_ast.Decl) and isinstance(node.type, c_ast.FuncDecl):
            continue
        elif isinstance(node, c_ast.Decl) and isinstance(node.type, c_ast.Enum) and node.name is None:
            _enumerated(node.type, enumerators, where)
        elif isinstance(node, c_ast.Decl) and "const" in node.quals and node.init and node.name not in constants:
            constants[node.name] = _constant(node, where)
        else:
            raise refused(
                node, where, f"{kind_of(node)} stands outside a function", "keep functions and constants only"
            )
    names = [*functions, *enumerators, *constants]
    for name in [name for name, count in Counter(names).items() if count > 1]:
        raise InputError(f"the name {shown(name)!r} may mean several things", where, "give each name once")
    if not functions:
        raise InputError("the file has no function", where, "write one function an agent: int agent(const float *x)")
    return {name: (node, _Known(enumerators, constants)) for name, node in functions.items()}


def _enumerated(node: Any, found: dict[str, int], where: str) -> None:
    after = 0
    for each in node.values.enumerators if node.values else ():
        number = Literal(after, WHOLE) if each.value is None else _number(each.value)
        if number is None or number.kind != WHOLE or not fits(number.value, WHOLE):
            what = f"the enumerator {shown(each.name)!r} is not understood"
            raise refused(each, where, what, "give it a whole number of int")
        after = int(number.value)
        if each.name in found:
            raise refused(each, where, f"the name {shown(each.name)!r} may mean several things")
        found[each.name], after = after, after + 1


def _type(node: Any) -> str:
    """The name of a plain type; "": it is none."""
    if isinstance(node, c_ast.TypeDecl) and isinstance(node.type, c_ast.IdentifierType):
        return " ".join(node.type.names)
    return ""


def _constant(node: Any, where: str) -> Literal:
    kind, number = _type(node.type), _number(node.init)
    value = None if number is None or kind not in (FLOAT, DOUBLE, *WHOLES) else converted(number, kind)
    if value is None:
        raise refused(node, where, f"the constant {shown(node.name)!r} is not understood", "give it a number that fits")
    return Literal(value, kind if kind in EXACT else WHOLE)


def _number(node: Any) -> Literal | None:
    """A number with its sign; None: it is none."""
    if isinstance(node, c_ast.UnaryOp) and node.op in "+-":
        inner = _number(node.expr) if isinstance(node.expr, c_ast.Constant) else None
        return inner and Literal(-inner.value if node.op == "-" else inner.value, inner.kind)
    return literal(node.value) if isinstance(node, c_ast.Constant) else None


# --- a function


def _origin(node: Any, known: _Known, where: str, said: Said) -> Origin:
    reader = _Reader(f"{where}, function {shown(node.decl.name)}", known)
    found = program(reader.function(node), reader.where)
    labels = labels_of(found.values, (), reader.called, reader.where, scores=said.scores)
    place = np.array([labels.place(value) for value in found.values], dtype=np.int32)
    action = np.where(found.tree.action < 0, found.tree.action, place[found.tree.action])

    def act(rows: Floats) -> Int32:
        values = meaning.decided(node, known.enumerators, known.constants, rows)
        return np.array([labels.place(value) for value in values], dtype=np.int32)

    return Origin(
        kind=KIND,
        grown=type(found.tree)(found.tree.feature, found.tree.threshold, found.tree.left, found.tree.right, action),
        labels=labels.labels,
        called=labels.called,
        act=act,
        replayed_by=REPLAYED_BY,
        features=tuple(reader.features),
        n_features=reader.width,
        numbers=FLOAT64 if {*reader.kinds, reader.kind} - {""} == {DOUBLE} else FLOAT32,
        given="numbers of the types that it declares",
        n_read=reader.last + 1,
        nan=found.nan,
    )


@dataclass
class _Reader:
    """Reads one function; knows what its names stand for."""

    where: str
    known: _Known
    features: list[str] = field(default_factory=list[str])  # parameters, where each is one
    kinds: list[str] = field(default_factory=list[str])  # ... and their types
    whole: str = ""  # the array that is the observation, and its type
    kind: str = ""
    output: str = ""  # the array that takes the scores
    result: str = ""  # the type that is returned; "": none
    width: int = 0  # 0: not declared
    last: int = -1  # the largest place that is looked at
    variables: dict[str, tuple[str, int]] = field(default_factory=dict[str, tuple[str, int]])  # type, length or 0
    called: dict[Value, str] = field(default_factory=dict[Value, str])  # values that have a name

    def refused(self, node: Any, what: str, advice: str = ADVICE) -> InputError:
        """What is wrong at a node's line."""
        return refused(node, self.where, what, advice)

    def function(self, node: Any) -> tuple[Statement, ...]:
        """The statements of a function."""
        declared = node.decl.type
        self.result = _type(declared.type)
        if self.result not in ("void", FLOAT, DOUBLE, *WHOLES) or node.param_decls or not declared.args:
            raise self.refused(node, "a function of this type is not understood", "write int agent(const float *x)")
        for each in declared.args.params:
            self.parameter(each)
        self.width = self.width or len(self.features)
        if (self.result == "void") != bool(self.output) or bool(self.whole) == bool(self.features):
            raise self.refused(node, "the parameters are not understood", "take one array, or one parameter a feature")
        return self.statements(node.body.block_items or [], top=True)

    def parameter(self, node: Any) -> None:
        """A parameter: the observation, a feature, or where scores go."""
        taken = {self.whole, self.output, *self.features, *self.known.enumerators, *self.known.constants}
        kind = node.type if isinstance(node, c_ast.Decl) else None
        if isinstance(kind, c_ast.PtrDecl | c_ast.ArrayDecl) and node.name not in taken:
            inner = _type(kind.type)
            if inner in EXACT and not self.whole and not self.features:
                size = _number(kind.dim) if isinstance(kind, c_ast.ArrayDecl) and kind.dim else None
                self.whole, self.kind, self.width = node.name, inner, int(size.value) if size else 0
                if not 0 <= self.width <= MAX_FEATURES:
                    raise self.refused(node, "the observation's length is not understood")
                return
            if inner in EXACT and self.result == "void" and not self.output and "const" not in kind.type.quals:
                self.output = node.name
                self.variables[node.name] = (inner, 0)
                return
        if _type(kind) in EXACT and not self.whole and node.name not in taken and self.result != "void":
            self.features.append(node.name)
            self.kinds.append(_type(kind))
            return
        raise self.refused(node, "a parameter is not understood", "take one array, or one parameter a feature")

    # --- statements

    def statements(self, nodes: Sequence[Any], *, top: bool = False) -> tuple[Statement, ...]:
        """Statements, without those that do nothing. `top`: of the function itself, which may end in its scores."""
        found: list[Statement] = []
        for place, node in enumerate(nodes):
            found += self.statement(node, last=top and place == len(nodes) - 1)
        return tuple(found)

    def statement(self, node: Any, *, last: bool = False) -> tuple[Statement, ...]:
        """A statement as rules.py knows it."""
        if node is None or isinstance(node, c_ast.EmptyStatement):
            return ()
        if isinstance(node, c_ast.Compound):
            return self.statements(node.block_items or [], top=last)
        if isinstance(node, c_ast.If):
            condition = self.condition(node.cond)
            return (If(condition, self.statement(node.iftrue), self.statement(node.iffalse), line_of(node)),)
        if isinstance(node, c_ast.Return) and node.expr is not None and self.result != "void":
            return self.returned(node.expr, line_of(node))
        if isinstance(node, c_ast.Decl):
            return self.declared(node)
        if isinstance(node, c_ast.Assignment) and node.op == "=" and isinstance(node.lvalue, c_ast.ID):
            return (Set(node.lvalue.name, self.value(node.rvalue, *self.variable(node.lvalue))),)
        if isinstance(node, c_ast.FuncCall) and isinstance(node.name, c_ast.ID) and node.name.name == "memcpy":
            return self.copied(node, last=last)
        raise self.refused(node, f"a statement is not understood: {kind_of(node)}")

    def returned(self, node: Any, line: int) -> tuple[Statement, ...]:
        """The return of an expression."""
        if isinstance(node, c_ast.TernaryOp):
            condition = self.condition(node.cond)
            return (If(condition, self.returned(node.iftrue, line), self.returned(node.iffalse, line), line),)
        if isinstance(node, c_ast.ID) and node.name in self.variables:
            if self.variable(node) != (self.result, 0):
                raise self.refused(node, "a variable of another type is returned", "give it the function's type")
            return (Return(None, node.name, line),)
        return (Return(self.value(node, self.result, 0), "", line),)

    def declared(self, node: Any) -> tuple[Statement, ...]:
        """A variable, with or without a first value."""
        array = isinstance(node.type, c_ast.ArrayDecl)
        kind = _type(node.type.type if array else node.type)
        size = _number(node.type.dim) if array and node.type.dim is not None else None
        names = {self.whole, *self.features, *self.variables, *self.known.enumerators, *self.known.constants}
        plain = kind in (*EXACT, *WHOLES) and not node.storage and (not array or (size and size.kind == WHOLE))
        if not plain or node.name in names:
            raise self.refused(
                node, f"the variable {shown(node.name)!r} is not understood, or not the first of its name"
            )
        self.variables[node.name] = (kind, int(size.value) if size else 0)
        if node.init is None:
            return ()
        return (Set(node.name, self.value(node.init, *self.variables[node.name])),)

    def variable(self, node: Any) -> tuple[str, int]:
        """A variable's type, and its length (0: no array)."""
        if not isinstance(node, c_ast.ID) or node.name not in self.variables or node.name == self.output:
            raise self.refused(node, "something that is no variable is set")
        return self.variables[node.name]

    def copied(self, node: Any, *, last: bool) -> tuple[Statement, ...]:
        """memcpy(variable, (double[]){...}, n * sizeof(double)), or at the end memcpy(output, variable, ...)."""
        given: list[Any] = node.args.exprs if node.args else []
        target, source, size = given if len(given) == 3 else [*given, node, node, node][:3]
        ends = isinstance(target, c_ast.ID) and target.name == self.output != ""
        kind, length = self.variable(source if ends else target)
        if (
            not length
            or self.bytes(size) != (length, kind)
            or (ends and (not last or self.variables[self.output][0] != kind))
        ):
            raise self.refused(node, "a memcpy is not understood", "copy a whole array, and to the output at the end")
        if ends:
            return (Return(None, source.name, line_of(node)),)
        literal_type = source.type.type if isinstance(source, c_ast.CompoundLiteral) else None
        if not isinstance(literal_type, c_ast.ArrayDecl) or literal_type.dim or _type(literal_type.type) != kind:
            raise self.refused(node, "a memcpy is not understood", "copy a list of numbers of the same type")
        return (Set(target.name, self.value(source.init, kind, length)),)

    def bytes(self, node: Any) -> tuple[int, str] | None:
        """The number and the type of `n * sizeof(type)`."""
        if not isinstance(node, c_ast.BinaryOp) or node.op != "*" or not isinstance(node.right, c_ast.UnaryOp):
            return None
        number, of = _number(node.left), node.right.expr
        if node.right.op != "sizeof" or number is None or number.kind != WHOLE or not isinstance(of, c_ast.Typename):
            return None
        return int(number.value), _type(of.type)

    # --- expressions

    def value(self, node: Any, kind: str, length: int) -> Value:
        """A value of a type: a number, or a list of as many as `length` says."""
        if isinstance(node, c_ast.InitList):
            numbers = [self.value(each, kind, 0) for each in node.exprs]
            if not length or len(numbers) != length:
                raise self.refused(node, f"a list of {len(numbers)} numbers is set, {length} are declared")
            return tuple(each for each in numbers if isinstance(each, int | float))
        if length:
            raise self.refused(node, f"a value is not understood: {text_of(node)}")
        if isinstance(node, c_ast.ID) and node.name in self.known.enumerators:
            number: Literal | None = Literal(self.known.enumerators[node.name], WHOLE)
            self.called.setdefault(self.known.enumerators[node.name], node.name)
        elif isinstance(node, c_ast.ID):
            number = self.known.constants.get(node.name)
        else:
            number = _number(node)
        if number is None or not fits(number.value, kind):
            what = (
                f"a value is not understood: {text_of(node)}"
                if number is None
                else f"a number is no {kind}: {text_of(node)}"
            )
            raise self.refused(node, what, "give a number of the type that is declared")
        return float(number.value) if kind in EXACT else number.value

    def condition(self, node: Any) -> Condition:
        """What an `if` asks."""
        if isinstance(node, c_ast.BinaryOp) and node.op in ("&&", "||"):
            return Joined(node.op == "&&", (self.condition(node.left), self.condition(node.right)))
        if isinstance(node, c_ast.UnaryOp) and node.op == "!":
            return Not(self.condition(node.expr))
        if not isinstance(node, c_ast.BinaryOp) or node.op not in TURNED:
            raise self.refused(node, f"a condition is not understood: {text_of(node)}", TEST_ADVICE)
        for one, other, said in ((node.left, node.right, node.op), (node.right, node.left, TURNED[node.op])):
            feature = self.feature(one)
            number = None if feature is None else self.threshold(other, feature[1])
            if feature is not None and number is not None:
                return compared(feature[0], said, number)
        raise self.odd(node)

    def odd(self, node: Any) -> InputError:
        """What is wrong with a comparison."""
        places = [self.feature(each) for each in (node.left, node.right)]
        if places.count(None) != 1:
            what = (
                "two features are compared" if None not in places else "a comparison is not of a feature and a number"
            )
            return self.refused(node, f"{what}: {text_of(node)}", TEST_ADVICE)
        feature, number = places[0] or places[1], node.left if places[0] is None else node.right
        read = number.name in self.known.constants if isinstance(number, c_ast.ID) else _number(number) is not None
        what = (
            f"a number is no {feature[1]}"
            if read and feature
            else "a feature is compared with what is not read as a number"
        )
        return self.refused(node, f"{what}: {text_of(number)}", NUMBER_ADVICE)

    def threshold(self, node: Any, kind: str) -> Number | None:
        """A number that a feature of this type is compared with, exactly as C compares them."""
        number = self.known.constants.get(node.name) if isinstance(node, c_ast.ID) else _number(node)
        exact = number is not None and (number.kind != WHOLE or abs(number.value) <= EXACT[kind])
        return number.value if number is not None and exact else None

    def feature(self, node: Any) -> tuple[int, str] | None:
        """The place and the type of a feature; None: the expression is none."""
        if isinstance(node, c_ast.ID) and node.name in self.features:
            place = self.features.index(node.name)
            return place, self.kinds[place]
        if not isinstance(node, c_ast.ArrayRef) or not isinstance(node.name, c_ast.ID) or node.name.name != self.whole:
            return None
        at = node.subscript
        named = self.known.enumerators.get(at.name) if isinstance(at, c_ast.ID) else None
        number = Literal(named, WHOLE) if named is not None else _number(at)
        if number is None or number.kind != WHOLE or not 0 <= number.value < (self.width or MAX_FEATURES):
            raise self.refused(node, "a feature is not understood", "write x[0], x[1] and so on")
        self.last = max(self.last, int(number.value))
        return int(number.value), self.kind
