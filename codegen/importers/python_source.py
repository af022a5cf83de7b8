"""If/else Python as decision trees, one for each function of a file.

Does: reads a file's syntax tree: nested ifs, comparisons of a feature with a number, and what is returned.
Assumes: Python's own grammar (the module ast); a caller that hands over observations as numbers.
Does not: run, import or evaluate anything of the file. Whatever is not understood is refused with its line.

The function takes one observation and names features as `x[0]` or `x["speed"]`, or takes one parameter a feature.
Python compares doubles, so that each test can be kept exactly (rules.py).
"""

import ast
import math
import warnings
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from codegen.errors import InputError, shown
from codegen.floats import FLOAT64
from codegen.importers import python_meaning
from codegen.importers.origin import Origin
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

KIND, REPLAYED_BY = "if/else Python", "an interpreter of the file's syntax tree"
MAX_FEATURES = 1 << 20
MAX_BITS = 1 << 12  # of a returned integer; Python writes out no more than some thousand digits
OPERATORS: Mapping[type[ast.cmpop], str] = {
    ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!=",
}  # fmt: skip
TURNED = {"<": ">", "<=": ">=", ">": "<", ">=": "<=", "==": "==", "!=": "!="}
TEST_ADVICE = "compare one feature with a number; give a sum or a difference as a feature of its own"
RETURN_ADVICE = "return a number, a text, a name or a list of numbers"
NUMBER_ADVICE = "write a finite number, or a name that the file gives to one"
MAX_SHOWN = 60


def from_python(text: bytes, where: str) -> dict[str, Origin]:
    """The tree of each function in a file of if/else Python, by the function's name. InputError with the line for
    everything that is no such file.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # about spellings, which would stand on the screen
            parsed = ast.parse(text)
            compile(parsed, "file", "exec", dont_inherit=True)  # refuses what the grammar allows: a parameter twice
        functions, constants = _module(parsed, where)
        return {function.name: _origin(function, constants, where) for function in functions}
    except SyntaxError as error:
        advice = "Python must be able to read the file"
        place = where if error.lineno is None else f"{where}, line {error.lineno}"
        raise InputError(f"not Python: {shown(error.msg)}", place, advice) from None
    except (RecursionError, MemoryError):
        raise InputError("the file is nested too deeply", where, "simplify it first") from None
    except ValueError as error:  # such as a null byte
        raise InputError(f"not Python: {shown(error)}", where, "Python must be able to read the file") from None


def _refused(node: ast.AST, where: str, what: str, advice: str) -> InputError:
    return InputError(what, f"{where}, line {getattr(node, 'lineno', 1)}", advice)


def _module(parsed: ast.Module, where: str) -> tuple[list[ast.FunctionDef], dict[str, Number]]:
    """The functions of a file, and the numbers that it names for all of them."""
    functions: list[ast.FunctionDef] = []
    constants: dict[str, Number] = {}
    bound: Counter[str] = Counter()
    _ensure_idle(parsed, where)
    for node in parsed.body:
        if isinstance(node, ast.FunctionDef):
            functions.append(node)
            bound[node.name] += 1
        elif isinstance(node, ast.Import | ast.ImportFrom):
            bound.update((each.asname or each.name).split(".")[0] for each in node.names)
        elif (named := _named(node)) is not None and (value := _number(named[1])) is not None:
            constants[named[0]] = value
            bound[named[0]] += 1
        elif not (isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)):
            what = f"{_words(node)} stands outside a function"
            raise _refused(node, where, what, "keep functions, and numbers with names, only")
    for name in [name for name, count in bound.items() if count > 1 or name == "*"]:
        raise InputError(f"the name {shown(name)!r} may mean several things", where, "give each name once")
    if not functions:
        raise InputError("the file has no function", where, "write one function an agent: def agent(x): ...")
    return functions, constants


def _ensure_idle(parsed: ast.Module, where: str) -> None:
    """InputError for annotations that do something: Python evaluates them, and they may give names other values."""
    for given in ast.walk(parsed):
        annotation = getattr(given, "annotation", None) or getattr(given, "returns", None)
        for node in ast.walk(annotation) if isinstance(annotation, ast.AST) else ():
            if isinstance(node, ast.Call | ast.NamedExpr):
                raise _refused(node, where, "an annotation calls or assigns something", "name types only")


def _words(node: ast.AST) -> str:
    return f"{type(node).__name__!r}"


def _text(node: ast.expr) -> str:
    """An expression as Python, short enough for a line."""
    try:
        return shown(ast.unparse(node))[:MAX_SHOWN]
    except ValueError:  # of integers with thousands of digits
        return _words(node)


def _named(node: ast.stmt) -> tuple[str, ast.expr] | None:
    """The name and the value of `name = value` or `name: type = value`."""
    if isinstance(node, ast.Assign) and len(node.targets) == 1 and isinstance(node.targets[0], ast.Name):
        return node.targets[0].id, node.value
    if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name) and node.value is not None:
        return node.target.id, node.value
    return None


def _number(node: ast.expr) -> Number | None:
    """A finite number with its signs; None: it is none."""
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub | ast.UAdd):
        inner = _number(node.operand)
        return None if inner is None else -inner if isinstance(node.op, ast.USub) else +inner
    value = node.value if isinstance(node, ast.Constant) else None
    return value if isinstance(value, int | float) and (isinstance(value, int) or math.isfinite(value)) else None


def _origin(function: ast.FunctionDef, constants: Mapping[str, Number], where: str) -> Origin:
    reader = _Reader(f"{where}, function {function.name}", constants)
    statements = reader.function(function)
    found = program(statements, reader.where)
    labels = labels_of(found.values, reader.order, reader.called, reader.where)
    place = np.array([labels.place(value) for value in found.values], dtype=np.int32)
    action = np.where(found.tree.action < 0, found.tree.action, place[found.tree.action])

    def act(rows: Floats) -> Int32:
        values = python_meaning.decided(function, constants, tuple(reader.features), rows)
        return np.array([labels.place(value) for value in values], dtype=np.int32)

    return Origin(
        kind=KIND,
        grown=type(found.tree)(found.tree.feature, found.tree.threshold, found.tree.left, found.tree.right, action),
        labels=labels.labels,
        act=act,
        replayed_by=REPLAYED_BY,
        features=tuple(reader.features),
        n_features=reader.width or len(reader.features),
        numbers=FLOAT64,
        n_read=reader.last + 1,
        nan=found.nan,
    )


@dataclass
class _Reader:
    """Reads one function; knows what its names stand for."""

    where: str
    constants: Mapping[str, Number]  # of the file
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
        count = _assigned_below(node.body)
        self.variables = set(count)
        self.once = {name for each in node.body for name in _assigned(each) if count[name] == 1}
        for name in (count.keys() & {*parameters}) | (self.constants.keys() & {*count, *parameters}):
            raise self.refused(node, f"the name {shown(name)!r} means several things", "give each name once")
        found = self.statements(node.body)
        if self.names & self.texts:
            name = min(self.names & self.texts)
            raise self.refused(node, f"{shown(name)!r} is returned as a text and as a name", "return one of them")
        return found

    def refused(self, node: ast.AST, what: str, advice: str) -> InputError:
        """What is wrong at a node's line."""
        return _refused(node, self.where, what, advice)

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
        named = _named(node)
        if named is not None:
            return self.assigned(named[0], named[1])
        if isinstance(node, ast.Pass) or (isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)):
            return ()
        what = f"a statement is not understood: {_words(node)}"
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
        number = _number(node)
        if isinstance(number, int) and number.bit_length() > MAX_BITS:
            raise self.refused(node, "a number is too long for a name", "return a shorter one")
        if number is not None:
            return number
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            self.texts.add(node.value)
            return node.value
        if isinstance(node, ast.List | ast.Tuple):
            numbers = [_number(each) for each in node.elts]
            if numbers and None not in numbers:
                return tuple(each for each in numbers if each is not None)
        name = _dotted(node)
        if name and name.split(".")[0] not in {self.whole, *self.aliases, *self.variables}:
            if name in self.constants:
                self.called.setdefault(self.constants[name], name)
                return self.constants[name]
            if name.split(".")[0] in self.constants:
                raise self.refused(node, "a number has no attributes", RETURN_ADVICE)
            self.names.add(name)
            return name
        raise self.refused(node, f"a value is not understood: {_text(node)}", RETURN_ADVICE)

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
            raise self.refused(node, f"a condition is not understood: {_text(node)}", TEST_ADVICE)
        return compared(feature, "!=", 0)

    def comparison(self, node: ast.Compare, left: ast.expr, operator: ast.cmpop, right: ast.expr) -> Condition:
        """A comparison of a feature with a number, on either side."""
        name = OPERATORS.get(type(operator))
        if name is None:
            what = f"a comparison is not understood: {_words(operator)}"
            raise self.refused(node, what, "use <, <=, >, >=, == or !=")
        for one, other, said in ((left, right, name), (right, left, TURNED[name])):
            feature, number = self.feature(one), self.threshold(other)
            if feature is not None and number is not None:
                return compared(feature, said, number)
        others = [each for each in (left, right) if self.feature(each) is None]
        if len(others) == 1:
            what = f"a feature is compared with what is not read as a number: {_text(others[0])}"
            raise self.refused(node, what, NUMBER_ADVICE)
        what = "a comparison is not of a feature and a number" if others else "two features are compared"
        raise self.refused(node, f"{what}: {_text(node)}", TEST_ADVICE)

    def threshold(self, node: ast.expr) -> Number | None:
        """A number, or the name of one."""
        if isinstance(node, ast.Name):
            return self.numbers.get(node.id, self.constants.get(node.id))
        return _number(node)

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


def _dotted(node: ast.expr) -> str:
    """A name with dots, such as Action.LEFT; "": it is none."""
    parts: list[str] = []
    while isinstance(node, ast.Attribute):
        parts.append(node.attr)
        node = node.value
    return ".".join([node.id, *reversed(parts)]) if isinstance(node, ast.Name) else ""


def _assigned(node: ast.stmt) -> list[str]:
    """The names that a statement assigns to, itself; of ways to assign, no others are understood."""
    targets = node.targets if isinstance(node, ast.Assign) else [node.target] if isinstance(node, ast.AnnAssign) else []
    return [each.id for target in targets for each in ast.walk(target) if isinstance(each, ast.Name)]


def _assigned_below(nodes: Sequence[ast.stmt]) -> Counter[str]:
    """How often names are assigned to in statements and below them."""
    found: Counter[str] = Counter()
    open_ = list(nodes)
    while open_:
        node = open_.pop()
        found.update(_assigned(node))
        if isinstance(node, ast.If):
            open_ += [*node.body, *node.orelse]
    return found
