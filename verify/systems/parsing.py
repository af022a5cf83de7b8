"""Expressions, conditions, features and values of modes in a world file, read from texts with their units.

Does: names, + - * / **, pi and functions as expressions; conditions as unions of polytopes; what a rule sets a mode to;
  choices, each as a name, and the rule of each way to choose.
Assumes: the names that a text may use are given with their units. Units that do not fit are refused.
Does not: parse (verify/language), evaluate, or say whether polytopes overlap or are empty (motion.py).
"""

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import pairwise, product
from math import prod
from typing import NamedTuple, TypeVar

from codegen.errors import InputError
from verify.language.parser import (
    ACTS,
    BARS,
    NEXT,
    PRIME,
    CallNode,
    Joined,
    Level,
    Limits,
    NameNode,
    Node,
    Prefixed,
    Source,
    Token,
    parse,
)
from verify.language.units import (
    BY_EQUALITY,
    DEGREE,
    PURE,
    Arithmetic,
    Modes,
    Typed,
    Unit,
    find_factor,
    format_unit,
    is_compared,
    resolve_modes,
    times,
)
from verify.systems.expressions import (
    Call,
    Expression,
    Name,
    Number,
    Pi,
    Power,
    Product,
    Quotient,
    Sum,
    affine,
    degree,
    extent,
    names,
    substitute,
)
from verify.systems.system import Affine, HalfSpace, Polytope
from verify.toml_places import Place

LIMITS = Limits(characters=2_000, depth=201)
MAX_DEPTH, MAX_PARTS, MAX_DEGREE = 150, 20_000, 64
LARGEST, MAX_BITS = 10**100, 1 << 15  # of a number that is computed from others, and of its denominator
WAVES = ("sin", "cos", "tan")  # of radians or of degrees
FUNCTIONS = {**dict.fromkeys((*WAVES, "exp", "sqrt"), 1), "clip": 3}  # name -> how many arguments
EXTREMES = ("abs", "max", "min")  # written as clips, which every reading knows
PI = "pi"
ABOVE, BELOW = (Fraction(0), Fraction(LARGEST)), (-Fraction(LARGEST), Fraction(0))  # clips to one side of 0
EQUALS = "equals"
AS, CASE = ".acts as ", ".case "  # in names that no text can write
CHOICE = "choice"
MAX_CHOICE = 64  # values of one choice
MAX_WAYS = 256  # to choose in one rule
SPECIAL = "#\\'\""  # a comment would hide what follows it; texts and line ends are no part of expressions
MINUS = Number(Fraction(-1))
IN_RADIANS = Product(Number(Fraction(1, 180)), Pi())  # of a degree
HOW = "write sums and products of names and numbers, such as x + 0.1[s]*v"
LINES = "write sums of variables times numbers: lines bound a product, as x <= 2 and v <= 1 where both are above 0"
UNION = "compare two sums by < in one region and by > in another: a list of regions is their union"
SIGNS = "compare two sums by <=, <, >=, > or =="
Read = TypeVar("Read")


class Option(NamedTuple):
    """A value of a choice, and how it is written."""

    value: Expression
    written: str


class ChosenMotion(NamedTuple):
    """The next value of each variable for some choices, and what these are in the words of the file."""

    next: Mapping[str, Expression]
    words: Mapping[str, str]


class Choices:
    """The choices that the texts of a table hold: a name stands for each in expressions."""

    def __init__(self) -> None:
        self._made: dict[str, tuple[Option, ...]] = {}
        self._called: dict[str, str] = {}  # each, in the words of the file

    def __contains__(self, name: str) -> bool:
        return name in self._made

    def add(self, values: Iterable[Expression], text: str) -> str:
        """The name that stands for a further choice, whose values are written in `text` from its parenthesis on."""
        name = f"{CHOICE} {len(self._made) + 1}"
        cuts, depth = list[int](), 0
        for place, letter in enumerate(text):
            depth += (letter == "(") - (letter == ")")
            if (letter, depth) in (("(", 1), (",", 1), (")", 0)):
                cuts.append(place)
            if (letter, depth) == (")", 0):
                break
        given = [text[one + 1 : other].strip() for one, other in pairwise(cuts)]
        self._made[name] = tuple(map(Option, values, [each for each in given if each]))
        return name

    def call(self, name: str) -> None:
        """Calls the choices that were read last by the name that they stand under; a second one gets a number too."""
        fresh = [each for each in self._made if each not in self._called]
        for number, each in enumerate(fresh, 1):
            self._called[each] = name if number == 1 and name not in self._called.values() else f"{name} {number}"

    def ways(self, stated: Mapping[str, Expression], where: Place) -> Iterator[ChosenMotion]:
        """The next values for each way to choose. InputError for too many."""
        used: set[str] = set()  # choices, those within others included
        pending = [name for each in stated.values() for name in names(each) if name in self._made]
        while pending:
            name = pending.pop()
            if name not in used:
                used.add(name)
                within = [other for option in self._made[name] for other in names(option.value)]
                pending += [other for other in within if other in self._made]
        ordered = [name for name in self._made if name in used]
        count = prod(len(self._made[name]) for name in ordered)
        if count > MAX_WAYS:
            raise InputError(f"{count:,} ways to choose, of at most {MAX_WAYS}", where, "choose between fewer values")
        for options in product(*(self._made[name] for name in ordered)):
            taken = dict(zip(ordered, options, strict=True))
            words = {self._called[name]: option.written for name, option in taken.items()}
            values = {name: option.value for name, option in taken.items()}
            following = dict(stated)
            for name in following:
                while names(following[name]) & values.keys():
                    following[name] = substitute(following[name], values)
            yield ChosenMotion(following, words)


@dataclass(frozen=True)
class Names:
    """The names that a text may use: `known` are variables and inputs, `meant` constants and what `let` names; `modes`
    those of variables that have some. `choices`: where texts may hold choices, those that were read.
    """

    known: Mapping[str, Unit]
    meant: Mapping[str, Typed[Expression]] = field(default_factory=dict[str, Typed[Expression]])
    modes: Modes = field(default_factory=dict[str, tuple[str, ...]])
    choices: Choices | None = None


def expression_of(text: str, names: Names, where: Place | str) -> Typed[Expression]:
    """The expression that a text states. InputError with `where`, and the text with the first fault marked."""
    return read_with(text, names, where, lambda reader, tree: reader.evaluate_node(tree))


def curve_of(source: Source, node: Node, names: Names) -> tuple[Typed[Expression], Token | None]:
    """The expression that a part of a formula states, and the first number in it that has a unit."""
    reader = _Expressions(source, names)
    expression = reader.evaluate_node(node)
    if reader.misfits:
        raise reader.misfits[0]
    return expression, reader.measured


def fitting(typed: Typed[Expression], unit: Unit, where: Place | str) -> Expression:
    """The expression in a unit, which must be its own but for units of time. InputError otherwise."""
    factor = None if typed.unit is None else find_factor(typed.unit, unit)
    if factor is None and typed.unit is not None:
        what = f"the unit is {format_unit(typed.unit or PURE)}, and {format_unit(unit)} is needed"
        raise InputError(f"units do not fit: {what}", where, "give numbers their unit, as in 0.1[s]*v")
    if factor in (None, 1):
        return typed.value
    return (
        Number(factor * typed.value.value) if isinstance(typed.value, Number) else Product(Number(factor), typed.value)
    )


def feature_of(text: str, functions: Collection[str], names: Names, where: Place | str) -> tuple[str, Expression]:
    """Reads what a text measures: which of `functions` it is, "" for none, and of what expression; EQUALS where it says
    that an expression is 0.
    """

    def read(reader: "_Expressions", tree: Node) -> tuple[str, Expression]:
        if isinstance(tree, CallNode) and tree.token.text in functions and len(tree.arguments) == 1:
            return tree.token.text, reader.evaluate_node(tree.arguments[0]).value
        match tree:
            case Joined(_, Level.RELATION, left, ((sign, right),)) if sign.text == "==":
                return EQUALS, reader.less(left, right).value
            case NameNode(token) if token.text in names.modes:  # its number
                return "", Name(token.text)
            case _:
                return "", reader.evaluate_node(tree).value

    return read_with(text, names, where, read)


def half_spaces(text: str, names: Names, where: Place | str) -> Polytope:
    """The half spaces of a comparison, `0 <= x - y < 1`. InputError for anything else."""

    def read(reader: "_Expressions", tree: Node) -> Polytope:
        if not isinstance(tree, Joined) or tree.level is not Level.RELATION:
            raise reader.source.wrong("not a comparison", tree.token.place, SIGNS)
        unequal = next((sign for sign, _ in tree.rest if sign.text == "!="), None)
        if unequal is not None:
            raise reader.source.wrong("not a comparison that a region can have", unequal.place, UNION)
        (region,) = reader.polytopes(tree)
        return region

    return read_with(text, names, where, read)


def conditions(text: str, names: Names, where: Place | str) -> list[Polytope]:
    """The polytopes of a condition, of which a state lies in one just where it holds."""
    return read_with(text, names, where, lambda reader, tree: reader.polytopes(tree))


def read_with(text: str, names: Names, where: Place | str, read: "Callable[[_Expressions, Node], Read]") -> Read:
    """Reads a text by a function, given its reader and its tree. InputError with the place of the first fault."""

    def locate(offset: int) -> str:
        return where.of_offset(text, offset) if isinstance(where, Place) else f"{where}, column {offset + 1}"

    source = Source(text, locate)
    if not text.isascii() or not text.isprintable():
        what = "an expression is one line of ASCII characters"
        raise InputError(what, where, "split it, and write spaces for tabs and ends of lines")
    for place, letter in enumerate(text):
        if letter in SPECIAL:
            raise source.wrong(f"cannot read {letter!r}", place, NEXT if letter == PRIME else HOW)
    reader = _Expressions(source, names)
    reading = read(reader, resolve_modes(source, parse(source, LIMITS), names.modes))
    if reader.misfits:
        raise reader.misfits[0]
    return reading


class _Expressions(Arithmetic[Expression]):
    """The expressions of one text."""

    def __init__(self, source: Source, names: Names) -> None:
        super().__init__(source)
        self._names = names

    def constant(self, number: Fraction) -> Expression:
        return Number(number)

    def negative(self, value: Expression, sign: Token) -> Expression:
        return Number(-value.value) if isinstance(value, Number) else self._small(Product(MINUS, value), sign)

    def combine(self, left: Expression, sign: Token, right: Expression) -> Expression:
        if sign.text == "/" and right == Number(Fraction(0)):
            raise self.source.wrong("division by zero", sign.place)
        join = {"+": Sum, "*": Product, "/": Quotient}[sign.text]
        return self._small(join(left, right), sign)

    def power(self, base: Expression, sign: Token, exponent: int) -> Expression:
        return self._small(Power(base, exponent), sign)

    def resolve_name(self, name: Token) -> Typed[Expression]:
        if name.text in self._names.modes and not is_compared(name):
            raise self.source.wrong(f"{name.text} is a mode, and no number", name.place, BY_EQUALITY)
        if name.text in self._names.meant:
            return self._names.meant[name.text]
        if name.text == PI and PI not in self._names.known:
            return Typed(Pi(), PURE)
        if name.text not in self._names.known:
            raise self.source.unknown("name", name, (*self._names.known, *self._names.meant))
        return Typed(Name(name.text), self._names.known[name.text])

    def resolve_call(self, call: CallNode) -> Typed[Expression]:
        function = call.token
        if function.text == CHOICE:
            return self._choice(call)
        if function.text in (*EXTREMES, BARS):
            return self._extreme(call)
        if function.text not in FUNCTIONS:
            raise self.source.unknown("function", function, (*FUNCTIONS, *EXTREMES))
        given = [self.evaluate_node(each) for each in call.arguments]
        if len(given) != FUNCTIONS[function.text]:
            how = "clip(SUM, LOW, HIGH)" if function.text == "clip" else f"{function.text}(SUM)"
            raise self.source.wrong(f"{function.text} has other arguments", function.place, f"write {how}")
        if function.text == "clip":
            return self._apply_clip(function, given)
        return self._apply_function(function, given[0])

    def _apply_function(self, function: Token, given: Typed[Expression]) -> Typed[Expression]:
        """A function of one number, with its unit."""
        inner, unit = given
        if function.text == "sqrt":
            return Typed(self._small(Call("sqrt", inner), function), unit and times(PURE, unit, Fraction(1, 2)))
        if unit == DEGREE and function.text in WAVES:
            inner, unit = Product(IN_RADIANS, inner), PURE
        if unit not in (None, PURE):
            advice = "give it radians, or degrees" if function.text in WAVES else "give it a pure number"
            raise self.source.wrong(
                f"units do not fit: {function.text} of {format_unit(unit or PURE)}", function.place, advice
            )
        return Typed(self._small(Call(function.text, inner), function), PURE)

    def _apply_clip(self, function: Token, given: list[Typed[Expression]]) -> Typed[Expression]:
        ends = [affine(each.value) for each in given[1:]]
        low, high = (None if end is None or end.terms else end.constant for end in ends)
        if low is None or high is None or low > high:
            what = "the bounds of clip are two numbers, the lower one first"
            raise self.source.wrong(what, function.place, "write clip(SUM, LOW, HIGH)")
        unit = self.same(given[0], given[1], function)
        unit = self.same(Typed(given[0].value, unit), given[2], function)
        return Typed(self._small(Call("clip", given[0].value, (low, high)), function), unit)

    def _extreme(self, call: CallNode) -> Typed[Expression]:
        """abs, max and min: what a value is above 0 is its clip to the numbers from 0 to the largest."""
        function, given = call.token, [self.evaluate_node(each) for each in call.arguments]
        single = function.text in ("abs", BARS)
        if single != (len(given) == 1):
            how = "write abs(SUM)" if single else f"write {function.text}(SUM, SUM)"
            raise self.source.wrong(f"{function.text} has other arguments", function.place, how)
        extreme = given[0]
        if single:
            return Typed(self._distance(extreme.value, function), extreme.unit)
        for other in given[1:]:
            extreme = Typed(self._larger(extreme.value, other.value, function), self.same(extreme, other, function))
        return extreme

    def _distance(self, inner: Expression, function: Token) -> Expression:
        """Returns the part of a value above 0, less its part below."""
        known = affine(inner)
        if known is not None and not known.terms:
            return Number(abs(known.constant))
        above, below = (Call("clip", inner, bounds) for bounds in (ABOVE, BELOW))
        return self._small(Sum(above, self.negative(below, function)), function)

    def _larger(self, one: Expression, other: Expression, function: Token) -> Expression:
        """The larger of two values, or of `min` the smaller."""
        least = function.text == "min"
        for value, fixed in ((one, other), (other, one)):
            form = affine(fixed)
            if form is not None and not form.terms:
                known, end = affine(value), form.constant
                if known is not None and not known.terms:
                    return Number((min if least else max)(known.constant, end))
                bounds = (-Fraction(LARGEST), end) if least else (end, Fraction(LARGEST))
                return self._small(Call("clip", value, bounds), function)
        less = Sum(one, self.negative(other, function)) if least else Sum(other, self.negative(one, function))
        above = Call("clip", less, ABOVE)
        return self._small(Sum(one, self.negative(above, function) if least else above), function)

    def _choice(self, call: CallNode) -> Typed[Expression]:
        """A name that stands for any of some values. Each choice that is written is one of its own."""
        made, place = self._names.choices, call.token.place
        if made is None:
            raise self.source.wrong("nothing is chosen here", place, "choices stand in the rules of [dynamics]")
        if not 2 <= len(call.arguments) <= MAX_CHOICE:
            raise self.source.wrong(f"a choice has 2 to {MAX_CHOICE} values", place, "write choice(-1, 1)")
        first, *others = given = [self.evaluate_node(each) for each in call.arguments]
        unit = first.unit
        for other in others:
            unit = self.same(Typed(first.value, unit), other, call.token)
        return Typed(Name(made.add((one.value for one in given), self.source.text[place + len(CHOICE) :])), unit)

    def polytopes(self, tree: Node) -> list[Polytope]:
        """Polytopes of which a state lies in one just where the condition of a tree holds."""
        match tree:
            case Joined(_, Level.OR, first, rest):
                union = [each for part in (first, *(other for _, other in rest)) for each in self.polytopes(part)]
            case Joined(_, Level.AND, first, rest):
                union = _every([self.polytopes(part) for part in (first, *(other for _, other in rest))])
            case Prefixed(_, signs, inside) if "not" in signs:
                union = self.polytopes(inside)
                union = outside(union) if len(signs) % 2 else union
            case Joined(_, Level.RELATION, first, rest):
                sides = [first, *(other for _, other in rest)]
                union = _every([self._compare(*each) for each in zip(sides, rest, strict=False)])
            case _:
                raise self.source.wrong("not a condition", tree.token.place, COMPARING)
        if len(union) > MAX_POLYTOPES:
            raise self.source.wrong("too many alternatives", tree.token.place, "split the case")
        return union

    def _compare(self, left: Node, than: tuple[Token, Node]) -> list[Polytope]:
        sign, right = than
        less = affine(self.less(left, right).value)
        if less is None:
            raise self.source.wrong("not an affine form", left.token.place, LINES)
        more = Affine().plus(less, OPPOSITE)
        match sign.text:
            case "<=" | "<":
                return [(HalfSpace(less, sign.text == "<"),)]
            case ">=" | ">":
                return [(HalfSpace(more, sign.text == ">"),)]
            case "==":
                return [(HalfSpace(less), HalfSpace(more))]
            case _:
                return [(HalfSpace(less, True),), (HalfSpace(more, True),)]

    def make_node_error(self, node: Node) -> InputError:
        return self.source.wrong("not an expression", node.token.place, HOW)

    def _small(self, expression: Expression, token: Token) -> Expression:
        """The expression itself. InputError for one that is large or deep, and for powers of powers, whose numbers
        would fill the memory.
        """
        count, depth = extent(expression)
        form = affine(expression) if depth <= MAX_DEPTH and degree(expression) <= MAX_DEGREE else None
        numbers = () if form is None else (form.constant, *(factor for _, factor in form.terms))
        faults = {
            f"nested deeper than {MAX_DEPTH} levels": depth > MAX_DEPTH,
            f"more than {MAX_PARTS} parts": count > MAX_PARTS,
            f"names are multiplied more than {MAX_DEGREE} times": degree(expression) > MAX_DEGREE,
            "a number that is too large or too fine": any(
                abs(number) > LARGEST or number.denominator.bit_length() > MAX_BITS for number in numbers
            ),
        }
        for what, is_so in faults.items():
            if is_so:
                raise self.source.wrong(what, token.place, "simplify the expression")
        return expression


MAX_POLYTOPES = 1_000
COMPARING = "write comparisons, and join them by and, or, not"
OPPOSITE = Fraction(-1)


def outside(regions: Sequence[Polytope]) -> list[Polytope]:
    """Polytopes of which a state lies in one just where it lies in none of some."""
    beyond = [[HalfSpace(Affine().plus(half.form, OPPOSITE), not half.strict) for half in each] for each in regions]
    return _every([[(half,) for half in halves] for halves in beyond])


def _every(parts: Sequence[Sequence[Polytope]]) -> list[Polytope]:
    union: list[Polytope] = [()]
    for part in parts:
        union = [(*one, *other) for one, other in product(union, part)]
        if len(union) > MAX_POLYTOPES:
            return union
    return union


Actions = Mapping[str, Sequence[str]]  # of each agent
OF_MODES = "write one of its modes, its name to keep it, acts(AGENT), or choice(.., ..) of these"


def input_of(agent: str, variable: str) -> str:
    """The name of the input by which an agent's action is a mode of a variable. No text can write it."""
    return f"{agent}{AS}{variable}"


def is_mode(name: str) -> bool:
    """Returns True if an input says which mode an action is."""
    return AS in name


def mode_of(text: str, variable: str, names: Names, actions: Actions, where: Place) -> Expression:
    """Reads the value of a mode from a text. InputError for anything else."""
    return read_with(text, names, where, lambda reader, tree: _value(reader.source, tree, variable, names, actions))


def _value(source: Source, node: Node, variable: str, names: Names, actions: Actions) -> Expression:
    known = names.modes[variable]
    match node:
        case NameNode(token) if token.text in known:
            return Number(Fraction(known.index(token.text)))
        case NameNode(token) if token.text in names.modes:
            if tuple(names.modes[token.text]) != tuple(known):
                raise source.wrong(f"{token.text} has other modes than {variable}", token.place, OF_MODES)
            return Name(token.text)
        case NameNode(token):
            raise source.unknown(f"mode of {variable}", token, known)
        case CallNode(token, (NameNode(agent),)) if token.text == ACTS:
            if agent.text not in actions:
                raise source.unknown("agent", agent, actions)
            strange = [action for action in actions[agent.text] if action not in known]
            if strange:
                what = f"{agent.text} has the action {strange[0]}, which is no mode of {variable}"
                raise source.wrong(what, token.place, f"add it to the modes of {variable}")
            return Name(input_of(agent.text, variable))
        case CallNode(token, given) if token.text == CHOICE and len(given) > 1 and names.choices is not None:
            values = [_value(source, each, variable, names, actions) for each in given]
            return Name(names.choices.add(values, source.text[token.place + len(CHOICE) :]))
        case _:
            raise source.wrong("no mode", node.token.place, OF_MODES)
