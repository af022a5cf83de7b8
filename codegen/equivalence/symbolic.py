"""Decision functions in C, read from their text as SMT-LIB definitions.

Does: runs a function of a header on an observation of unknown floats: integers are numbers, floats are terms, and a
  comparison of floats splits the run in two; what is left is one choice after another.
Assumes: IEEE comparisons; 32-bit `int`; what pycparser reads is what a compiler reads.
Does not: know the tree that the function should be, or how the emitter writes it: any function of the small part of C
  that decisions need is read, and Unreadable says what is not of it.
"""

# pyright: basic
# pycparser's nodes have no declared attributes
import operator
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np
from pycparser import c_ast, c_generator
from pycparser.c_parser import ParseError

from codegen.equivalence.structure import enumerators, functions_in, odd_lines, resolve_function, syntax
from codegen.numbers import BEYOND, nearest_single

MAX_STEPS = 1_000_000  # statements run for one function, on all its paths together
SHAPES = {"const float *x": "float", "const int *x": "int32_t"}  # of what a function is given: numbers, or their bits
HEXADECIMAL = re.compile(r"0x([0-9a-f]+)\.?([0-9a-f]*)p([+-]?\d{1,4})")
BITS_BODY = "{ union { float f; int32_t i; } u; u.f = x; return u.i; }"
FLOAT, SIGNED, UNSIGNED = "float", "int32_t", "uint32_t"
_COMPARE = {
    FLOAT: {"<=": "fp.leq", "<": "fp.lt", ">": "fp.gt", ">=": "fp.geq", "==": "fp.eq"},
    SIGNED: {"<=": "bvsle", "<": "bvslt", ">": "bvsgt", ">=": "bvsge", "==": "="},
    UNSIGNED: {"<=": "bvule", "<": "bvult", ">": "bvugt", ">=": "bvuge", "==": "="},
}
_NUMBERS: dict[str, Callable[[int, int], int]] = {
    "+": operator.add, "-": operator.sub, "*": operator.mul, "<": operator.lt, "<=": operator.le, ">": operator.gt,
    ">=": operator.ge, "==": operator.eq, "!=": operator.ne,
}  # fmt: skip


class Unreadable(ValueError):
    """The text is not of the part of the language that is read."""


class Term(NamedTuple):
    """A value that the run does not know: its C type and its SMT-LIB term (float: FloatingPoint, else bits)."""

    kind: str
    text: str


@dataclass(frozen=True)
class Fork:
    """A value that depends on a condition (an SMT-LIB formula)."""

    condition: str
    yes: Any
    no: Any


class Definitions:
    """Choices as definitions without arguments, each a line, shared where they are the same. Actions are 32 bits."""

    def __init__(self, prefix: str) -> None:
        self.lines: list[str] = []
        self._prefix = prefix
        self._names: dict[tuple[str, str, str], str] = {}

    @staticmethod
    def action(number: int) -> str:
        """The term of an action."""
        return f"#x{number & 0xFFFFFFFF:08x}"

    def choice(self, condition: str, yes: str, no: str) -> str:
        """The term of a choice."""
        if yes == no:
            return yes
        name = self._names.setdefault((condition, yes, no), f"{self._prefix}{len(self._names)}")
        if len(self.lines) < len(self._names):
            self.lines.append(f"(define-fun {name} () (_ BitVec 32) (ite {condition} {yes} {no}))")
        return name


def map_forks(function: Callable[..., Any], *values: Any) -> Any:
    """A function of values, where some may depend on conditions."""
    for place, value in enumerate(values):
        if isinstance(value, Fork):
            yes, no = (
                map_forks(function, *values[:place], side, *values[place + 1 :]) for side in (value.yes, value.no)
            )
            return yes if yes == no else Fork(value.condition, yes, no)
    return function(*values)


class Header:
    """A header's functions, each to be run on unknown observations."""

    def __init__(self, header: str) -> None:
        try:
            parsed = syntax(header)
        except ParseError as error:
            raise Unreadable(f"not C: {error}") from None
        odd = odd_lines(header)
        if odd:
            raise Unreadable(f"a line that may change the rest: {odd[0][:60]}")
        self.functions = functions_in(parsed)
        self.numbers = enumerators(parsed)

    def decide(self, name: str, inputs: Sequence[str], bits: Mapping[str, str], into: Definitions) -> str:
        """The term of the answer of `int name(const float *x)`. `inputs`: the terms of x[0], x[1], ...; `bits`: of each
        of them as an integer. Unreadable for what is not of the small part of C.
        """
        if name not in self.functions:
            raise Unreadable(f"there is no function {name}")
        function = resolve_function(self.functions, name)
        if function is None:
            raise Unreadable(f"{name} calls another function in another way")
        try:
            kind = SHAPES.get(_text(function.decl.type.args))
            if _text(function.decl.type.type.type) != "int" or kind is None:
                raise Unreadable(f"{name} is not int {name}({next(iter(SHAPES))})")
            seen = [Term(kind, each if kind == FLOAT else bits[each]) for each in inputs]
            run = _Run(self, function.decl.type.args.params[0].name, seen, bits, into)
            return run.run(run.cell(function.body, None), {})
        except (AttributeError, LookupError, TypeError, ValueError, RecursionError) as error:
            raise Unreadable(f"{name}: {error}") from None


class _Run:
    """One function's run over all its paths. Statements that are left are linked cells, one for each position."""

    def __init__(
        self, header: Header, given: str, inputs: Sequence[Term], bits: Mapping[str, str], into: Definitions
    ) -> None:
        self.header, self.given, self.inputs, self.bits, self.into = header, given, inputs, bits, into
        self.steps = 0
        self._cells: dict[tuple[int, int], Any] = {}
        self._kept: list[Any] = []  # so that no identity is given twice
        self._answers: dict[Any, str] = {}

    def cell(self, statement: Any, rest: Any) -> Any:
        key = (id(statement), id(rest))
        if key not in self._cells:
            self._cells[key] = (statement, rest)
            self._kept.append(statement)
        return self._cells[key]

    def run(self, rest: Any, names: dict[str, Any]) -> str:
        """The answer's term from here on; equal positions with equal values have one answer."""
        here = (id(rest), frozenset(names.items()))
        if here not in self._answers:
            self._answers[here] = self._run(rest, names)
        return self._answers[here]

    def _run(self, rest: Any, names: dict[str, Any]) -> str:
        while rest is not None:
            self.steps += 1
            if self.steps > MAX_STEPS:
                raise Unreadable("too many steps")
            statement, rest = rest
            if isinstance(statement, c_ast.Return):
                return self.split(self.value(statement.expr, names), self.number)
            if isinstance(statement, c_ast.If):
                sides = {True: statement.iftrue, False: statement.iffalse}
                after = {truth: self.cell(side, rest) if side else rest for truth, side in sides.items()}
                return self.split(
                    self.value(statement.cond, names),
                    lambda value, a=after, n=names: self.run(a[_truth(value) != 0], n),
                )
            changed, rest = self.simple(statement, rest, names)
            if changed is not None:
                name, value = changed
                if isinstance(value, Fork):
                    return self.split(value, lambda each, r=rest, n=names, k=name: self.run(r, {**n, k: each}))
                names = {**names, name: value}
        raise Unreadable("the function ends without an answer")

    def simple(self, statement: Any, rest: Any, names: dict[str, Any]) -> tuple[tuple[str, Any] | None, Any]:
        """Returns what a statement without a choice changes, and what is left after it."""
        if isinstance(statement, c_ast.Compound):
            for item in reversed(statement.block_items or []):
                rest = self.cell(item, rest)
        elif isinstance(statement, (c_ast.DeclList, c_ast.ExprList)):
            for item in reversed(statement.decls if isinstance(statement, c_ast.DeclList) else statement.exprs):
                rest = self.cell(item, rest)
        elif isinstance(statement, c_ast.For):
            body = c_ast.Compound([statement.stmt, *([statement.next] if statement.next else [])])
            rest = self.cell(statement.init, self.cell(c_ast.While(statement.cond, body), rest))
        elif isinstance(statement, c_ast.While):
            holds = self.value(statement.cond, names)
            if not isinstance(holds, int):
                raise Unreadable("a loop whose end depends on the observation")
            rest = self.cell(statement.stmt, self.cell(statement, rest)) if holds else rest
        elif isinstance(statement, c_ast.Decl):
            _ensure_plain(statement, names, self.value)
            return None if statement.init is None else (statement.name, self.value(statement.init, names)), rest
        elif isinstance(statement, c_ast.Assignment) and statement.op == "=" and isinstance(statement.lvalue, c_ast.ID):
            return (statement.lvalue.name, self.value(statement.rvalue, names)), rest
        elif isinstance(statement, c_ast.UnaryOp) and statement.op in ("p++", "++"):
            return (statement.expr.name, map_forks(lambda value: value + 1, names[statement.expr.name])), rest
        elif not (isinstance(statement, c_ast.Cast) and _text(statement) == f"(void) {self.given}"):
            raise Unreadable(f"a statement: {_text(statement)[:60]}")
        return None, rest

    def split(self, value: Any, then: Callable[[Any], str]) -> str:
        if isinstance(value, Fork):
            return self.into.choice(value.condition, self.split(value.yes, then), self.split(value.no, then))
        return then(value)

    def number(self, value: Any) -> str:
        if not isinstance(value, int):
            raise Unreadable("an answer that is no number")
        return self.into.action(value)

    # --- expressions

    def value(self, item: Any, names: dict[str, Any]) -> Any:
        """A number, a Term, a table (a tuple of those), or a Fork of such values."""

        def of(each: Any) -> Any:
            return self.value(each, names)

        if isinstance(item, c_ast.Constant):
            return _constant(item)
        if isinstance(item, c_ast.ID):
            return names[item.name] if item.name in names else self.header.numbers[item.name]
        if isinstance(item, c_ast.InitList):
            return tuple(of(each) for each in item.exprs)
        if isinstance(item, c_ast.ArrayRef):
            table = None if item.name.name == self.given else of(item.name)
            return map_forks(lambda place: self.entry(table, place), of(item.subscript))
        if isinstance(item, c_ast.UnaryOp):
            return map_forks(lambda value: _unary(item.op, value), of(item.expr))
        if isinstance(item, c_ast.BinaryOp) and item.op in ("&&", "||"):
            left = map_forks(_truth, of(item.left))
            stops = item.op == "||"
            return map_forks(lambda value: value if value == stops else map_forks(_truth, of(item.right)), left)
        if isinstance(item, c_ast.BinaryOp):
            return map_forks(lambda left, right: _binary(item.op, left, right), of(item.left), of(item.right))
        if isinstance(item, c_ast.TernaryOp):
            return map_forks(lambda value: of(item.iftrue if _truth(value) else item.iffalse), of(item.cond))
        if isinstance(item, c_ast.Cast):
            return map_forks(lambda value: _cast(item.to_type.type.type.names, value), of(item.expr))
        if isinstance(item, c_ast.FuncCall):
            return self.call(item, names)
        raise Unreadable(f"an expression: {_text(item)[:60]}")

    def entry(self, table: Any, place: int) -> Any:
        entries = self.inputs if table is None else table
        if not 0 <= place < len(entries):
            raise Unreadable(f"entry {place} of {len(entries)} is read")
        return entries[place]

    def call(self, item: Any, names: dict[str, Any]) -> Any:
        name, (given,) = item.name.name, item.args.exprs
        if name in ("INT32_C", "UINT32_C"):
            return _bits(SIGNED if name == "INT32_C" else UNSIGNED, int(given.value, 0))
        function = self.header.functions.get(name)
        if (
            function is None
            or _text(function.body) != BITS_BODY
            or not _text(function.decl).endswith(f"int32_t {name}(float x)")
        ):
            raise Unreadable(f"a call of {name}")
        return map_forks(lambda value: Term(SIGNED, self.bits[value.text]), self.value(given, names))


def _text(item: Any) -> str:
    return " ".join(c_generator.CGenerator().visit(item).split())


def _truth(value: Any) -> int:
    if not isinstance(value, int):
        raise Unreadable("a condition that is no comparison")
    return int(value != 0)


def _ensure_plain(declared: Any, names: Mapping[str, Any], value: Callable[[Any, Any], Any]) -> None:
    """Unreadable for a declaration whose type or storage could change what is put into it."""
    table = isinstance(declared.init, c_ast.InitList)
    kind = declared.type.type if table else declared.type
    words = " ".join(kind.type.names)
    most = {"unsigned char": 2**8, "unsigned short": 2**16, "unsigned int": 2**32, "int": 2**31}.get(words, 0)
    wanted = ["static"] if table else []
    if declared.storage != wanted or (table and "const" not in declared.quals) or declared.name in names:
        raise Unreadable(f"a declaration: {_text(declared)[:60]}")
    for item in declared.init.exprs if table else [declared.init] if declared.init is not None else []:
        initial = value(item, names)
        fits = 0 <= initial < most if isinstance(initial, int) else isinstance(initial, Term) and words == "float"
        if not fits and not (isinstance(initial, Fork) and not table and words == "int"):
            raise Unreadable(f"{_text(item)[:40]} as {words}")


def _constant(item: Any) -> Any:
    text = item.value.lower()
    if item.type in ("int", "unsigned int"):
        number = int(text.removesuffix("u"), 0)  # which refuses octal numbers
        if number < 2**32 and (item.type != "int" or (number >= 2**31 and text.startswith("0x"))):
            return _bits(UNSIGNED, number)
        if number >= 2**31:
            raise Unreadable(f"the constant {text}, which is no int")
        return number
    if item.type != "float" or not text.endswith("f"):
        raise Unreadable(f"the constant {item.value}, which is no float")
    hexadecimal = HEXADECIMAL.fullmatch(text[:-1])
    if hexadecimal:
        whole, part, power = hexadecimal.groups()
        exact = int(whole + part, 16) * Fraction(2) ** (int(power) - 4 * len(part))
    elif text.startswith("0x"):
        raise Unreadable(f"the constant {text[:-1]}")
    else:
        exact = Fraction(text[:-1])
    if exact >= BEYOND:
        raise Unreadable("a constant beyond the floats")
    near = nearest_single(exact)  # as compilers make one
    if hexadecimal and Fraction(float(near)) != exact:
        raise Unreadable(f"the constant {item.value}, which is no float32")
    return Term(FLOAT, f"((_ to_fp 8 24) #x{int(near.view(np.uint32)):08x})")


def _bits(kind: str, number: int) -> Term:
    if kind == SIGNED and not -(2**31) <= number < 2**31:
        raise Unreadable(f"the constant {number}, which is no int32_t")
    return Term(kind, f"#x{number & 0xFFFFFFFF:08x}")


def _unary(sign: str, value: Any) -> Any:
    if sign == "!":
        return 1 - _truth(value)
    if sign == "-" and isinstance(value, int):
        return -value
    if sign == "-" and value.kind == FLOAT:
        return Term(FLOAT, f"(fp.neg {value.text})")
    raise Unreadable(f"the operator {sign}")


def _binary(sign: str, left: Any, right: Any) -> Any:
    if isinstance(left, int) and isinstance(right, int):
        number = int(_NUMBERS[sign](left, right))
        if not -(2**31) <= number < 2**31:
            raise Unreadable("an int that overflows")
        return number
    sides = [_bits(SIGNED, side) if isinstance(side, int) else side for side in (left, right)]
    kinds = {side.kind for side in sides}
    if FLOAT in kinds and kinds != {FLOAT}:
        raise Unreadable("a float compared with an integer")
    kind = UNSIGNED if UNSIGNED in kinds else sides[0].kind  # as C converts
    return Fork(f"({_COMPARE[kind][sign]} {sides[0].text} {sides[1].text})", 1, 0)


def _cast(kinds: list[str], value: Any) -> Any:
    kind = UNSIGNED if kinds == ["unsigned", "int"] else " ".join(kinds)
    if kind == "int" and isinstance(value, int):
        return value
    if kind == "int" and isinstance(value, Term) and value.kind == UNSIGNED:  # of 32 bits, which the header asks for
        return Term(SIGNED, value.text)
    if kind in (SIGNED, UNSIGNED) and not (isinstance(value, Term) and value.kind == FLOAT):
        return Term(kind, _bits(UNSIGNED, value).text if isinstance(value, int) else value.text)
    raise Unreadable(f"a cast to {kind}")
