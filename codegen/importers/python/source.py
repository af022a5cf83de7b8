"""If/else Python as decision trees, one for each function of a file.

Does: reads a file's syntax tree: nested ifs, comparisons of a feature with a number, and what is returned.
Assumes: Python's own grammar (the module ast); a caller that hands over observations as numbers.
Does not: run, import or evaluate anything of the file. Whatever is not understood is refused with its line.

The function takes one observation and names features as `x[0]` or `x["speed"]`, or takes one parameter a feature.
Python compares doubles, so that each test can be kept exactly (rules.py). An element of a NumPy array is no Python
float: NumPy 2 first makes the other number one of the array's type, so that float32 arrays meet float32(0.1), not 0.1.
Only the caller knows which it is: `Said.arrays`.
"""

import ast
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from codegen.errors import InputError, shown
from codegen.floats import FLOAT32, FLOAT64
from codegen.importers.origin import NOTHING, Origin, Said
from codegen.importers.python import meaning
from codegen.importers.python.file import (
    File,
    assigned,
    assigned_below,
    dotted,
    file_of,
    named_value,
    number_of,
    refused,
    text_of,
    words_of,
)
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
    labels_of,
    program,
)
from codegen.ir import Floats, Int32
from codegen.process.unwarned import unwarned

KIND, REPLAYED_BY = "if/else Python", "an interpreter of the file's syntax tree"
MAX_FEATURES = 1 << 20
MAX_BITS = 1 << 12  # of a returned integer; Python writes out no more than some thousand digits
OPERATORS: Mapping[type[ast.cmpop], str] = {
    ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!=",
}  # fmt: skip
TURNED = {"<": ">", "<=": ">=", ">": "<", ">=": "<=", "==": "==", "!=": "!="}
GIVEN = {"": "Python's floats, or float64 arrays", FLOAT32: "float32 arrays of NumPy 2", FLOAT64: "float64 arrays"}
FLOATS_ONLY = "Python's floats, no arrays: a whole number in the file is no double"
TEST_ADVICE = "compare one feature with a number; give a sum or a difference as a feature of its own"
RETURN_ADVICE = "return a number, a text, a name or a list of numbers"
NUMBER_ADVICE = "write a finite number, or a name that the file gives to one"


def from_python(text: bytes, where: str, said: Said = NOTHING) -> dict[str, Origin]:
    """The tree of each function in a file of if/else Python, by the function's name. InputError with the line for
    everything that is no such file.
    """
    try:
        with unwarned():  # about spellings, which would stand on the screen
            parsed = ast.parse(text)
            compile(parsed, "file", "exec", dont_inherit=True)  # refuses what the grammar allows: a parameter twice
        file = file_of(parsed, where)
        return {function.name: _origin(function, file, where, said) for function in file.functions}
    except SyntaxError as error:
        advice = "Python must be able to read the file"
        place = where if error.lineno is None else f"{where}, line {error.lineno}"
        raise InputError(f"not Python: {shown(error.msg)}", place, advice) from None
    except (RecursionError, MemoryError):
        raise InputError("the file is nested too deeply", where, "simplify it first") from None
    except ValueError as error:  # such as a null byte
        raise InputError(f"not Python: {shown(error)}", where, "Python must be able to read the file") from None


def _origin(function: ast.FunctionDef, file: File, where: str, said: Said) -> Origin:
    reader = _Reader(f"{where}, function {function.name}", file.constants, file.skipped, said.arrays)
    statements = reader.function(function)
    found = program(statements, reader.where)
    labels = labels_of(found.values, reader.order, reader.called, reader.where, scores=said.scores)
    place = np.array([labels.place(value) for value in found.values], dtype=np.int32)
    action = np.where(found.tree.action < 0, found.tree.action, place[found.tree.action])

    def act(rows: Floats) -> Int32:
        values = meaning.decided(function, file.constants, tuple(reader.features), rows, said.arrays)
        return np.array([labels.place(value) for value in values], dtype=np.int32)

    return Origin(
        kind=KIND,
        grown=type(found.tree)(found.tree.feature, found.tree.threshold, found.tree.left, found.tree.right, action),
        labels=labels.labels,
        called=labels.called,
        act=act,
        replayed_by=REPLAYED_BY,
        features=tuple(reader.features),
        keyed=bool(reader.features) and not reader.width,
        n_features=reader.width or len(reader.features),
        numbers=said.arrays or FLOAT64,
        given=FLOATS_ONLY if reader.long and not said.arrays else GIVEN[said.arrays],
        n_read=reader.last + 1,
        nan=found.nan,
    )


@dataclass
class _Reader:
    """Reads one function; knows what its names stand for."""

    where: str
    constants: Mapping[str, Number]  # of the file
    skipped: frozenset[str]  # names of the file that stand for something else
    arrays: str = ""  # see Said
    long: bool = False  # whether a feature is compared with a whole number that no double equals
    order: list[Value] = field(default_factory=list[Value])  # values as the text names them
    called: dict[Value, str] = field(default_factory=dict[Value, str])  # values that have a name
    features: list[str] = field(default_factory=list[str])  # their names, where the function has some
    width: int = 0  # how many features there are, where the function says so
    whole: str = ""  # the parameter that is the whole observation
    aliases: dict[str, int] = field(default_factory=dict[str, int])  # local names of features
    numbers: dict[str, Number] = field(default_factory=dict[str, Number])  # local names of numbers
    variables: set[str] = field(default_factory=set[str])  # assigned somewhere
    once: set[str] = field(default_factory=set[str])  # ... once, and on every path
    names: set[str] = field(default_factory=set[str])  # returned without being defined
    numbered: bool = False  # whether features are looked up by numbers
    last: int = -1  # the largest of these numbers
    bare: bool = False  # whether the observation itself is compared, as a single number
    texts: set[str] = field(default_factory=set[str])  # returned as texts

    def function(self, node: ast.FunctionDef) -> tuple[Statement, ...]:
        """The statements of a function."""
        given = node.args
        odd = given.vararg or given.kwarg or given.kwonlyargs or given.defaults or node.decorator_list
        parameters = [each.arg for each in (*given.posonlyargs, *given.args)]
        if odd or not parameters:
            raise self.refused(node, "the parameters are not understood", "def agent(x): or def agent(speed, gap):")
        if len(parameters) == 1:
            self.whole = parameters[0]
        else:
            self.features, self.width = parameters, len(parameters)
            self.aliases = {name: place for place, name in enumerate(parameters)}
        count = assigned_below(node.body)
        self.variables = set(count)
        self.once = {name for each in node.body for name in assigned(each) if count[name] == 1}
        for name in (count.keys() & {*parameters}) | (self.constants.keys() & {*count, *parameters}):
            raise self.refused(node, f"the name {shown(name)!r} means several things", "give each name once")
        found = self.statements(node.body)
        if self.names & self.texts:
            name = min(self.names & self.texts)
            raise self.refused(node, f"{shown(name)!r} is returned as a text and as a name", "return one of them")
        return found

    def refused(self, node: ast.AST, what: str, advice: str) -> InputError:
        """What is wrong at a node's line."""
        return refused(node, self.where, what, advice)

    # --- statements

    def statements(self, nodes: Sequence[ast.stmt]) -> tuple[Statement, ...]:
        """Statements, without those that do nothing."""
        return tuple(found for node in nodes for found in self.statement(node))

    def statement(self, node: ast.stmt) -> tuple[Statement, ...]:
        """A statement as rules.py knows it."""
        if isinstance(node, ast.If):
            condition = self.condition(node.test)
            return (If(condition, self.statements(node.body), self.statements(node.orelse), node.lineno),)
        if isinstance(node, ast.Return):
            if node.value is None:
                raise self.refused(node, "nothing is returned", RETURN_ADVICE)
            return self.returned(node.value)
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Tuple | ast.List):
            self.unpacked(node, node.targets[0])
            return ()
        named = named_value(node)
        if named is not None:
            return self.assigned(named[0], named[1])
        if isinstance(node, ast.Pass) or (isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)):
            return ()
        what = f"a statement is not understood: {words_of(node)}"
        raise self.refused(node, what, "use if, elif, else, return and name = value")

    def returned(self, node: ast.expr) -> tuple[Statement, ...]:
        """The return of an expression."""
        if isinstance(node, ast.IfExp):
            condition = self.condition(node.test)
            return (If(condition, self.returned(node.body), self.returned(node.orelse), node.lineno),)
        if isinstance(node, ast.Name) and node.id in self.variables and node.id not in self.aliases:
            return (Return(None, node.id, node.lineno),)
        return (Return(self.value(node), "", node.lineno),)

    def assigned(self, name: str, node: ast.expr) -> tuple[Statement, ...]:
        """The assignment of an expression to a name."""
        if isinstance(node, ast.IfExp):
            condition = self.condition(node.test)
            return (If(condition, self.assigned(name, node.body), self.assigned(name, node.orelse), node.lineno),)
        feature = self.feature(node)
        if feature is not None:
            if name not in self.once:
                what = f"{shown(name)!r} is a feature on some paths only"
                raise self.refused(node, what, "name features first, once each")
            self.aliases[name] = feature
            return ()
        value = self.value(node)
        if name in self.once and isinstance(value, int | float):
            self.numbers[name] = value
        return (Set(name, value),)

    def unpacked(self, node: ast.Assign, target: ast.Tuple | ast.List) -> None:
        """`a, b = x`: names for all features."""
        names = [each.id for each in target.elts if isinstance(each, ast.Name)]
        whole = isinstance(node.value, ast.Name) and node.value.id == self.whole != ""
        fits = len(node.targets) == 1 and len(names) == len(target.elts) and set(names) <= self.once
        if not whole or not fits or self.features or self.width or len(set(names)) < len(names):
            raise self.refused(node, "an unpacking is not understood", "give each feature a name: a, b = x")
        self.features, self.width = names, len(names)
        self.aliases |= {name: place for place, name in enumerate(names)}

    # --- expressions

    def value(self, node: ast.expr) -> Value:
        """A value that can be returned."""
        found = self.plain(node)
        self.order.append(found)
        return found

    def plain(self, node: ast.expr) -> Value:
        """A number, a text, a name or a list of numbers."""
        number = number_of(node)
        if isinstance(number, int) and number.bit_length() > MAX_BITS:
            raise self.refused(node, "a number is too long for a name", "return a shorter one")
        if number is not None:
            return number
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            self.texts.add(node.value)
            return node.value
        if isinstance(node, ast.List | ast.Tuple):
            numbers = [number_of(each) for each in node.elts]
            if numbers and None not in numbers:
                return tuple(each for each in numbers if each is not None)
        name = dotted(node)
        if name and name.split(".")[0] not in {self.whole, *self.aliases, *self.variables}:
            if name in self.constants:
                self.called.setdefault(self.constants[name], name)
                return self.constants[name]
            if name.split(".")[0] in self.constants:
                raise self.refused(node, "a number has no attributes", RETURN_ADVICE)
            if name.split(".")[0] in self.skipped:
                what = f"the name {shown(name)!r} stands for a literal that is not read"
                raise self.refused(node, what, "write the number or the text itself")
            self.names.add(name)
            return name
        raise self.refused(node, f"a value is not understood: {text_of(node)}", RETURN_ADVICE)

    def condition(self, node: ast.expr) -> Condition:
        """What an `if` asks."""
        if isinstance(node, ast.BoolOp):
            return Joined(isinstance(node.op, ast.And), tuple(self.condition(each) for each in node.values))
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
            return Not(self.condition(node.operand))
        if isinstance(node, ast.Compare):
            operands = [node.left, *node.comparators]
            pairs = zip(operands, node.ops, operands[1:], strict=False)
            return Joined(True, tuple(self.comparison(node, *each) for each in pairs))
        if isinstance(node, ast.Constant) and isinstance(node.value, bool):
            return node.value
        feature = self.feature(node)
        if feature is None:
            raise self.refused(node, f"a condition is not understood: {text_of(node)}", TEST_ADVICE)
        return compared(feature, "!=", 0)

    def comparison(self, node: ast.Compare, left: ast.expr, operator: ast.cmpop, right: ast.expr) -> Condition:
        """A comparison of a feature with a number, on either side."""
        name = OPERATORS.get(type(operator))
        if name is None:
            what = f"a comparison is not understood: {words_of(operator)}"
            raise self.refused(node, what, "use <, <=, >, >=, == or !=")
        for one, other, said in ((left, right, name), (right, left, TURNED[name])):
            feature, number = self.feature(one), self.threshold(other)
            if feature is not None and number is not None:
                return compared(feature, said, self.met(node, number))
        others = [each for each in (left, right) if self.feature(each) is None]
        if len(others) == 1:
            what = f"a feature is compared with what is not read as a number: {text_of(others[0])}"
            raise self.refused(node, what, NUMBER_ADVICE)
        what = "a comparison is not of a feature and a number" if others else "two features are compared"
        raise self.refused(node, f"{what}: {text_of(node)}", TEST_ADVICE)

    def met(self, node: ast.expr, number: Number) -> Number:
        """The number that a feature is compared with where a comparison names `number`."""
        try:
            with np.errstate(over="ignore", under="ignore"):
                near = float(np.dtype(self.arrays or FLOAT64).type(number))
        except OverflowError:  # of a whole number
            near = math.inf
        if self.arrays and not math.isfinite(near):
            what = f"a number is beyond {self.arrays}: {text_of(node)}"
            raise self.refused(node, what, "write a smaller one; NumPy warns of it, too")
        self.long |= near != number and isinstance(number, int)
        return near if self.arrays else number

    def threshold(self, node: ast.expr) -> Number | None:
        """A number, or the name of one."""
        if isinstance(node, ast.Name):
            return self.numbers.get(node.id, self.constants.get(node.id))
        return number_of(node)

    def feature(self, node: ast.expr) -> int | None:
        """The place of a feature; None: the expression is none."""
        if isinstance(node, ast.Name) and node.id == self.whole:
            if self.numbered or self.features or self.width > 1:
                raise self.refused(node, "the observation is used as a number", TEST_ADVICE)
            self.width, self.bare = 1, True
            return 0
        if isinstance(node, ast.Name):
            return self.aliases.get(node.id)
        if not isinstance(node, ast.Subscript) or not isinstance(node.value, ast.Name) or node.value.id != self.whole:
            return None
        key: object = node.slice.value if isinstance(node.slice, ast.Constant) else None
        if isinstance(key, str) and not self.numbered and self.width == 0:
            if key not in self.features:
                self.features.append(key)
            return self.features.index(key)
        named = self.features and self.width == 0  # by texts, as above
        mixed = named or self.bare or isinstance(key, bool)
        if not isinstance(key, int) or mixed or not 0 <= key < (self.width or MAX_FEATURES):
            raise self.refused(node, "a feature is not understood", "write x[0], or x['speed'], one of both everywhere")
        self.numbered, self.last = True, max(self.last, key)
        return key
