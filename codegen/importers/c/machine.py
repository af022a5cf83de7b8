"""An interpreter of C on one path: what a file declares, expressions, whose values may be features, and statements.

Does: types of declarations, typedefs, struct tags, enumerators, scopes; variables, members and items, which are read,
  set and initialized; operators, casts, assignments; the type of an expression without computing it; branches, loops,
  switch, calls of functions of the file, from their first statement to their return.
Assumes: nodes of pycparser; `Growth` counts the work, so that what does not end is refused.
Does not: compute (arithmetic.py), choose functions (source.py), call what the file does not hold, but its library, or
  let anything be kept between decisions.
"""

# pyright: basic
# pycparser's nodes have no declared attributes
import re
from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from pathlib import PurePath
from typing import Any

from pycparser import c_ast, c_generator

from codegen.errors import InputError, escape_text
from codegen.importers.c import kinds
from codegen.importers.c.arithmetic import CONSTANTS, LIBRARY, RESULTS, TEST_ADVICE, Arithmetic, call_library
from codegen.importers.c.kinds import (
    INT,
    Inputs,
    Kind,
    Many,
    Number,
    Object,
    Pointer,
    Record,
    Reference,
    Text,
    Type,
    Value,
)
from codegen.importers.symbolic.feature import SIGNS
from codegen.importers.symbolic.memory import RemembersError
from codegen.importers.symbolic.paths import MAX_CALLS, STATE_ADVICE
from codegen.importers.symbolic.statements import End, Executor, Open, Scope, link_statements

ADVICE = "give functions of ifs, comparisons with numbers, and returns"
KEPT = "the {} keeps what earlier decisions set"
MAX_SHOWN, MAX_LENGTH = 60, 1 << 20
PLAIN_TEXT = re.compile(r'"(?:[ -\[\]-~]|\\["\\])*"')  # of ASCII; adjacent ones are one for the parser
LOGIC = (*SIGNS, "&&", "||", "!")
COUNTING = ("++", "--", "p++", "p--")
CALL_ADVICE = "a decision may depend on the observation alone; give what the call answers as a feature"
DONE = kinds.Place(-1)  # where a path keeps the actions that were called


def text_of(node: Any) -> str:
    """A node as C, short enough for a line."""
    return escape_text(" ".join(c_generator.CGenerator().visit(node).split()))[:MAX_SHOWN]


@lru_cache(maxsize=32)  # a large function is looked at from many sides
def walk(node: Any) -> list[Any]:
    """A node and all below it. Who changes the tree clears the cache."""
    nodes = [node]
    for each in nodes:
        nodes += each
    return nodes


def items_of(switch: Any) -> list[Any]:
    """The statements of a switch: its cases, and what stands before them."""
    return switch.stmt.block_items or [] if isinstance(switch.stmt, c_ast.Compound) else [switch.stmt]


def list_targets(node: Any) -> list[list[Any]]:
    """What is assigned to, counted up or down, or has its address taken, below a node: each with what it is a part of,
    up to a variable.
    """
    ways = [[each.lvalue] for each in walk(node) if isinstance(each, c_ast.Assignment)]
    ways += [[each.expr] for each in walk(node) if isinstance(each, c_ast.UnaryOp) and each.op in (*COUNTING, "&")]
    for way in ways:
        while isinstance(way[-1], c_ast.ArrayRef | c_ast.StructRef):
            way.append(way[-1].name)
    return ways


def collect_assigned(node: Any) -> set[str]:
    """The names that are assigned to, counted up or down, or whose address is taken, below a node; but not its own."""
    declared = [each for each in walk(node) if isinstance(each, c_ast.Decl)]
    return {way[-1].name for way in list_targets(node) if isinstance(way[-1], c_ast.ID)} - {
        each.name for each in declared if "static" not in each.storage
    }


def is_const(node: Any) -> bool:
    """Returns True if a declaration of an object says that it is constant."""
    while isinstance(node, c_ast.Decl | c_ast.ArrayDecl | c_ast.Typename):
        node = node.type
    return "const" in getattr(node, "quals", ())


def only_compares(node: Any, *others: type[Any]) -> bool:
    """Returns True if a node compares variables and their parts with one another and with constants, and does nothing
    else. `others`: kinds of nodes that may stand in it.
    """
    for each in walk(node):
        plain = isinstance(each, (c_ast.ID, c_ast.Constant, c_ast.StructRef, *others))
        if isinstance(each, c_ast.BinaryOp | c_ast.UnaryOp):
            plain = each.op in LOGIC or (each.op == "-" and isinstance(getattr(each, "expr", None), c_ast.Constant))
        elif isinstance(each, c_ast.ArrayRef):
            plain = isinstance(each.subscript, c_ast.Constant)
        if not plain:
            return False
    return True


def parameters_of(node: Any) -> list[Any]:
    """The parameters of a function; `void` is none."""
    given = list(node.decl.type.args.params) if node.decl.type.args is not None else []
    return [each for each in given if isinstance(each, c_ast.Decl) and each.name]


class Machine(Executor):
    """The names of a file and those of the function that is followed, what they hold on one path, and what they do."""

    BRANCHES = c_ast.If | c_ast.Compound
    inputs: Inputs | None = None
    reads: Mapping[str, Any] = {}  # functions whose calls are features, and those whose calls are actions
    acts: Mapping[str, Any] = {}

    def __init__(self, where: str, names: Mapping[str, int], *, contracts: bool) -> None:
        self.where, self.line, self.text_file = where, 0, ""
        self.types: dict[str, Type] = dict(kinds.STANDARD)  # typedefs, and `struct` and `enum` with their tags
        self.functions: dict[str, Any] = {}
        self.results: dict[str, Type] = {}  # of functions that are declared
        self.scope = self.file = Scope({name: Number(of, INT, name) for name, of in names.items()})  # the present one
        self.constants: dict[kinds.Place, Value] = {}  # what the file's own variables hold
        self.memory = self.constants  # what was set on this path
        self.fixed: dict[str | int, str] = {}  # why a variable must not be set
        self.arithmetic = Arithmetic(self.make_error, contracts=contracts)
        self.changing: set[str] = set()  # variables of the file that some function may set
        self.notes = dict[str, None]()  # what was skipped
        self.named = dict[Any, str]()  # what the source calls some numbers that are returned
        self.depth, self._count = 0, 0  # of calls; of variables

    def at(self, node: Any) -> None:
        """The present place, for messages."""
        coord = node.coord
        if coord is not None and coord.line:
            self.line, self.text_file = coord.line, coord.file or ""

    def make_error(self, what: str, advice: str = ADVICE) -> InputError:
        """Makes an error of what is wrong at the present line."""
        file = PurePath(self.text_file).name
        header = f" of {file}" if file and file != PurePath(self.where.split(",")[0]).name else ""
        return InputError(what, f"{self.where}, line {self.line}{header}" if self.line else self.where, advice)

    def constant(self, node: Any) -> int:
        """The whole number that an expression is."""
        value = self.arithmetic.plain(self.value(node))
        if not isinstance(value, Number) or value.kind.floating:
            raise self.make_error(f"not a whole number: {text_of(node)}", "write the number")
        return int(value.value)

    def find_name(self, name: str) -> Object | Number | None:
        """Returns what a name stands for; None: nothing."""
        return next((each.names[name] for each in self.scope if name in each.names), CONSTANTS.get(name))

    # --- types

    def type_of(self, node: Any) -> Type:
        """The type that a declaration or a type name says; of a function, that of its result."""
        self.at(node)
        if isinstance(node, c_ast.TypeDecl | c_ast.Typename | c_ast.Decl | c_ast.FuncDecl):
            return self.type_of(node.type)
        if isinstance(node, c_ast.PtrDecl) and not isinstance(node.type, c_ast.FuncDecl):
            return Pointer(self.type_of(node.type))
        if isinstance(node, c_ast.ArrayDecl):
            length = 0 if node.dim is None else self.constant(node.dim)
            if not 0 <= length <= MAX_LENGTH:
                raise self.make_error(f"a length is not read: {length}")
            return Many(self.type_of(node.type), length)
        if isinstance(node, c_ast.Struct):
            name = node.name or str(node.coord)
            record: Any = self.types.setdefault(f"struct {name}", Record(name, {}))
            for each in node.decls or ():
                if each.name is None or each.bitsize is not None:
                    self.at(each)
                    raise self.make_error("a member has bits or no name", "declare it as a whole number with a name")
                record.members[each.name] = self.type_of(each)
            return record
        if isinstance(node, c_ast.Enum):
            last, lowest = -1, 0
            for each in node.values.enumerators if node.values is not None else ():
                last = last + 1 if each.value is None else self.constant(each.value)
                if not INT.holds(last):
                    raise self.make_error(f"the enumerator {escape_text(each.name)} is no int")
                lowest = min(lowest, last)
                self.scope.names[each.name] = Number(last, INT, each.name)
            kind, name = INT if lowest < 0 else kinds.ENUM, f"enum {node.name}"
            if node.name and node.values is not None:
                self.types[name] = kind
            return self.types.get(name, kind) if node.name else kind
        names = tuple(node.names) if isinstance(node, c_ast.IdentifierType) else ()
        type_ = (self.types.get(names[0]) if len(names) == 1 else None) or (kinds.kind_of(names) if names else None)
        if type_ is None:
            raise self.make_error(
                f"a type is not read: {text_of(node)}", "use float, double, and types of whole numbers"
            )
        return type_

    # --- which object an expression names

    def new_object(self, type_: Type) -> Object:
        """A variable without a value."""
        self._count += 1
        return Object(kinds.Place(self._count), type_)

    def place(self, node: Any) -> Any:
        """The object that an expression names; for what is none, its value."""
        if isinstance(node, c_ast.ID):
            target = self.find_name(node.name)
            if target is None:
                raise self.make_error(f"the name {escape_text(node.name)} is not known", "define it in the file")
            if node.name in self.changing and self.file.names.get(node.name) is target:
                if isinstance(target, Object) and target.place.base == node.name:
                    return target  # which is remembered, and an input
                self.at(node)
                raise RemembersError(node.name)
            return target
        if isinstance(node, c_ast.StructRef):
            holder = self.place(node.name) if node.type == "." else self.target(self.value(node.name), 0, node)
            members = holder.type.members if isinstance(holder, Object) and isinstance(holder.type, Record) else {}
            if node.field.name not in members:
                raise self.make_error(f"there is no such member: {text_of(node)}")
            return Object(holder.place.then(node.field.name), members[node.field.name])
        if isinstance(node, c_ast.ArrayRef):
            base = self.value(node.name)
            subscript = self.arithmetic.resolve_number(self.value(node.subscript))
            if not isinstance(subscript, Number) or subscript.kind.floating:
                what = f"an item is chosen by a feature: {text_of(node)}"
                raise self.make_error(what, "test its range first, or choose by if or switch")
            return self.target(base, int(subscript.value), node)
        if isinstance(node, c_ast.UnaryOp) and node.op == "*":
            return self.target(self.value(node.expr), 0, node)
        return self.value(node)

    def target(self, base: Value, at: int, node: Any) -> Object:
        """The item that a pointer and an index lead to."""
        target = base.target.item(at) if isinstance(base, Reference) else None
        if target is None:
            raise self.make_error(f"there is no such item: {text_of(node)}", "stay within the declared length")
        return target

    # --- what it holds

    def load(self, target: Any) -> Value:
        """Returns the value that an object holds."""
        if not isinstance(target, Object) or isinstance(target.type, Record):
            return target
        if isinstance(target.type, Many):
            return Reference(Object(target.place.then(0), target.type.of, target.type.length))
        value = self._held(target)
        if value is None and isinstance(target.place.base, str) and self.inputs is not None:
            return self.inputs.value(target)
        if value is None:
            raise self.make_error("a variable is read that holds nothing on some path", "set it where it is declared")
        return value

    def _held(self, target: Object) -> Value:
        value = self.memory.get(target.place)
        return self.constants.get(target.place) if value is None else value

    def store(self, target: Any, value: Any) -> None:
        """Sets an object."""
        if not isinstance(target, Object):
            raise self.make_error("what is assigned to is not a variable")
        if isinstance(target.type, Record | Many):
            if not isinstance(value, Object) or value.type != target.type:
                raise self.make_error("an array or a struct is set to something else", "set it item by item")
            for to, part in zip(target.parts(), value.parts(), strict=True):
                if isinstance(part.place.base, str) or self._held(part) is not None:
                    self.store(to, self.load(part))
            return
        if target.place.base in self.fixed:
            raise self.make_error(self.fixed[target.place.base], STATE_ADVICE)
        if self.inputs is not None and isinstance(target.place.base, str):
            self.inputs.write(target.place)
        self.memory[target.place] = self.cast(value, target.type)

    def cast(self, value: Value, type_: Type) -> Value:
        """A value as one of a type."""
        if isinstance(type_, Kind) and type_ != kinds.VOID:
            if not isinstance(value, Reference | Object | kinds.Text):
                return self.arithmetic.convert_value(value, type_)
            if type_ == kinds.BOOL:
                return Number(1, type_)
            raise self.make_error("a pointer or a text becomes a number", TEST_ADVICE)
        if isinstance(type_, Pointer) and isinstance(value, Reference):
            actual = value.target.type
            if type_.to not in (actual, kinds.VOID) and not (isinstance(type_.to, Many) and type_.to.of == actual):
                raise self.make_error("a pointer becomes one to another type", "read each object as its own type")
        return value

    # --- initializers

    def initialize_object(self, type_: Type, node: Any, fixed: str = "") -> Object:
        """A new object with an initializer. `fixed`: why it must not be set from there on."""
        if isinstance(type_, Many) and not type_.length and isinstance(node, c_ast.InitList):
            type_ = Many(type_.of, max((at + 1 for at, _ in self._places(type_, node)), default=0))
        target = self.new_object(type_)
        self._fill(target, node)
        if fixed:
            self.fixed[target.place.base] = fixed
        return target

    def _places(self, type_: Any, node: Any) -> list[tuple[Any, Any]]:
        """The member or item of each part of a list."""
        names = list(type_.members) if isinstance(type_, Record) else []
        room = len(names) if isinstance(type_, Record) else type_.length or MAX_LENGTH
        parts, at = list[tuple[Any, Any]](), 0
        for each in node.exprs or []:
            if isinstance(each, c_ast.NamedInitializer):
                called = each.name[0].name if isinstance(each.name[0], c_ast.ID) else ""
                if len(each.name) != 1 or (names and called not in names):
                    raise self.make_error(f"an initializer is not read: {text_of(each)}")
                at = names.index(called) if names else self.constant(each.name[0])
                each = each.expr
            if not 0 <= at < room:
                raise self.make_error("an initializer has too many parts")
            parts.append((names[at] if names else at, each))
            at += 1
        return parts

    def _fill(self, target: Object, node: Any) -> None:
        of, listed = target.type, isinstance(node, c_ast.InitList)
        if not isinstance(of, Record | Many):
            self.store(target, self.value(node.exprs[0] if listed and len(node.exprs) == 1 else node))
        elif listed:
            for key, each in self._places(of, node):
                type_ = of.members[key] if isinstance(of, Record) else of.of
                self._fill(Object(target.place.then(key), type_, getattr(of, "length", None)), each)
            self.zero_object(target)
        else:
            self.store(target, self.place(node))

    def zero_object(self, target: Object) -> None:
        """Sets each part of an object that nothing has set to 0."""
        for part in target.parts():
            if isinstance(part.type, Kind) and part.place not in self.memory:
                self.memory[part.place] = self.arithmetic.convert_value(Number(0, INT), part.type)

    # --- expressions

    def value(self, node: Any) -> Any:
        """Returns the value of an expression, or follows a statement."""
        self.at(node)
        if self.paths is not None:
            self.paths.line = self.line
            self.paths.step()
        reader = READERS.get(type(node))
        if reader is None:
            raise self.make_error(f"what is written is not read: {text_of(node)}")
        return reader(self, node)

    def truth(self, node: Any) -> bool:
        """Returns True if a condition holds."""
        if isinstance(node, c_ast.BinaryOp) and node.op in ("&&", "||"):
            return self.truth(node.right) if self.truth(node.left) == (node.op == "&&") else node.op == "||"
        if isinstance(node, c_ast.UnaryOp) and node.op == "!":
            return not self.truth(node.expr)
        value = self.value(node)
        self.at(node)
        return self.arithmetic.truth(value)

    def _text(self, node: Any) -> Text:
        if not PLAIN_TEXT.fullmatch(node.value):
            what = f"a text is not read: {escape_text(node.value)[:60]}"
            raise self.make_error(what, "write it without escapes, but of quotes and backslashes")
        return Text(re.sub(r"\\(.)", r"\1", node.value[1:-1]))

    def _constant(self, node: Any) -> Value:
        if node.type == "string":
            return self._text(node)
        parsed = kinds.literal(node.value)
        if parsed is None:
            advice = "write a finite number of int, float or double"
            raise self.make_error(f"a number is not read: {escape_text(node.value)[:60]}", advice)
        return parsed

    def _id(self, node: Any) -> Value:
        return self.load(self.place(node))

    _arrayref = _structref = _id

    def _cast(self, node: Any) -> Value:
        return self.cast(self.value(node.expr), self.type_of(node.to_type))

    def _exprlist(self, node: Any) -> Value:
        return [self.value(each) for each in node.exprs][-1]

    def _compoundliteral(self, node: Any) -> Value:
        return self.load(self.initialize_object(self.type_of(node.type), node.init))

    def _unaryop(self, node: Any) -> Value:
        if node.op == "sizeof":
            type_ = self.type_of(node.expr) if isinstance(node.expr, c_ast.Typename) else self._static(node.expr)
            if type_ is None:
                raise self.make_error(f"a size is not read: {text_of(node)}", "write the number")
            return Number(kinds.size_of(type_)[0], kinds.ULONG)
        if node.op == "&":
            target = self.place(node.expr)
            return Reference(target) if isinstance(target, Object) else target
        if node.op == "*":
            return self._id(node)
        if node.op in COUNTING:
            target = self.place(node.expr)
            before = self.load(target)
            self.store(target, self._combine(node.op.strip("p")[0], before, Number(1, INT), node))
            return before if node.op[0] == "p" else self.load(target)
        return self.arithmetic.unary(node.op, self.value(node.expr))

    def _binaryop(self, node: Any) -> Value:
        if node.op in ("&&", "||"):
            return self._both(node)
        left, right = self.value(node.left), self.value(node.right)
        self.at(node)
        return self._combine(node.op, left, right, node)

    def _combine(self, sign: str, left: Value, right: Value, node: Any) -> Value:
        """An operator of two values; of a pointer, a step or the question whether it is null."""
        if not any(isinstance(each, Reference | Text) for each in (left, right)):
            return self.arithmetic.binary(sign, left, right)
        if sign in ("==", "!=") and any(isinstance(each, Number) and each.value == 0 for each in (left, right)):
            return Number(int(sign == "!="), INT)  # no pointer that is given is null
        if sign in ("+", "-") and isinstance(left, Reference) and isinstance(right, Number):
            return Reference(self.target(left, right.value if sign == "+" else -right.value, node))
        raise self.make_error(f"pointers or texts are computed with: {text_of(node)}", TEST_ADVICE)

    def _both(self, node: Any) -> Value:
        """`&&` and `||` as a value: asked where it decides, if looking at the second part cannot fail."""
        every, truth = node.op == "&&", self.arithmetic.truth
        if not only_compares(node.right):
            return Number(int(self.truth(node)), INT)
        left, right = self.value(node.left), self.value(node.right)
        return kinds.Condition(lambda: truth(right) if truth(left) == every else not every)

    def _ternaryop(self, node: Any) -> Value:
        value = self.value(node.iftrue if self.truth(node.cond) else node.iffalse)
        kind = self._static(node)
        if isinstance(kind, Kind) and isinstance(value, Number | kinds.Symbol | kinds.Condition):
            return self.arithmetic.convert_value(value, kind)
        return value

    def _assignment(self, node: Any) -> Value:
        target = self.place(node.lvalue)
        if node.op == "=":
            value = self.value(node.rvalue)
        else:
            value = self._combine(node.op[:-1], self.load(target), self.value(node.rvalue), node)
        self.at(node)
        self.store(target, value)
        return self.load(target)

    def _funccall(self, node: Any) -> Value:
        given = [] if node.args is None else list(node.args.exprs)
        name = node.name.name if isinstance(node.name, c_ast.ID) else ""
        if name in self.reads and self.inputs is not None:
            return self.inputs.value(Object(kinds.Place(name), self.inputs.parameters[name]))
        if name in self.acts:
            done = self.memory.get(DONE, ())
            self.memory[DONE] = (*done, name)  # type: ignore[misc] - what was done, which nothing loads
            return None
        if name in self.functions and not self.find_name(name):
            function, values = self.functions[name], [self.value(each) for each in given]
            if self.depth >= MAX_CALLS:
                raise self.make_error("functions call one another too deeply", "write a loop")
            parameters, frame = parameters_of(function), dict[str, Any]()
            if len(parameters) != len(values):
                raise self.make_error(f"{escape_text(name)} is called with {len(values)} values")
            for each, value in zip(parameters, values, strict=True):
                frame[each.name] = self.new_object(self.parameter(each))
                self.store(frame[each.name], value)
            return self.answer(function, link_statements([function.body], Scope(frame, self.file)))
        if name in LIBRARY and not self.find_name(name):
            return call_library(self, name, given)
        if not name or self.find_name(name):
            what = f"a function is called through a pointer: {text_of(node.name)}"
            raise self.make_error(what, "call each function by its name, in an if or a switch")
        raise self.make_error(f"the function {escape_text(name)} is not read", CALL_ADVICE)

    def _static(self, node: Any) -> Type | None:
        """The type of an expression, without its value; None for what has no type of numbers."""
        op = getattr(node, "op", "")
        if isinstance(node, c_ast.Constant):
            if node.type == "string":
                return Many(kinds.CHAR, len(self._text(node).text) + 1)
            known = kinds.literal(node.value)
            return known.kind if known else None
        if isinstance(node, c_ast.ID):
            known = self.find_name(node.name)
            return known.kind if isinstance(known, Number) else known.type if known is not None else None
        if isinstance(node, c_ast.Cast | c_ast.CompoundLiteral):
            return self.type_of(node.to_type if isinstance(node, c_ast.Cast) else node.type)
        if isinstance(node, c_ast.FuncCall):
            name = node.name.name if isinstance(node.name, c_ast.ID) else ""
            return self.results.get(name, RESULTS.get(name))
        if isinstance(node, c_ast.StructRef | c_ast.ArrayRef) or (isinstance(node, c_ast.UnaryOp) and op == "*"):
            holder = self._static(node.expr if isinstance(node, c_ast.UnaryOp) else node.name)
            holder = holder.to if isinstance(holder, Pointer) else holder
            if isinstance(node, c_ast.StructRef):
                return holder.members.get(node.field.name) if isinstance(holder, Record) else None
            return holder.of if isinstance(holder, Many) else holder
        if op in ("!", "&&", "||") or op in SIGNS:
            return INT
        if isinstance(node, c_ast.UnaryOp) and op in ("sizeof", "&"):
            return kinds.ULONG if op == "sizeof" else None
        parts = [each for name, each in node.children() if name != "cond"]
        if isinstance(node, c_ast.Assignment | c_ast.ExprList) or op in COUNTING:
            return self._static(parts[-1 if isinstance(node, c_ast.ExprList) else 0])
        met = [each for each in map(self._static, parts) if isinstance(each, Kind)]
        if not met or len(met) < len(parts):
            return None
        met = [INT if each.rank < INT.rank or each == kinds.ENUM else each for each in met]
        return met[0] if len(met) == 1 or op in ("<<", ">>") else self.arithmetic.common(*met)

    # --- declarations

    def _typedef(self, node: Any) -> None:
        self.types[node.name] = self.type_of(node.type)

    def _decllist(self, node: Any) -> None:
        for each in node.decls:
            self.declare(each)

    def declare(self, node: Any) -> None:
        """A variable, or a type alone."""
        type_ = self.type_of(node.type)
        if node.name is None:
            return
        if isinstance(node.type, c_ast.FuncDecl):
            self.results.setdefault(node.name, type_)
            return
        self.at(node)
        shown, outside = escape_text(node.name), self.scope is self.file
        if "extern" in node.storage or "volatile" in getattr(node.type, "quals", ()):
            raise self.make_error(f"the variable {shown} is set elsewhere", STATE_ADVICE)
        if "static" in node.storage and not outside and node.name in self.changing and not is_const(node):
            raise self.make_error(KEPT.format(f"static variable {shown}"), STATE_ADVICE)
        if outside and node.init is None and node.name in self.file.names:
            return  # as it was declared before
        held = "static" in node.storage or outside
        fixed = f"the variable {shown} is kept or constant" if held or is_const(node) else ""
        if node.init is not None:
            self.scope.names[node.name] = self.initialize_object(type_, node.init, fixed)
            return
        target = self.scope.names[node.name] = self.new_object(type_)
        if held:
            self.zero_object(target)
            self.fixed[target.place.base] = fixed

    _decl = declare

    # --- statements

    def _emptystatement(self, node: Any) -> None:
        pass

    _pragma = _staticassert = _emptystatement

    def _break(self, node: Any) -> End:
        return End(type(node).__name__.lower())

    _continue = _break

    def _goto(self, node: Any) -> None:
        raise self.make_error("goto is not read", "return in each branch, or put what follows into a function")

    def _return(self, node: Any) -> End:
        return End("return", None if node.expr is None else self.value(node.expr))

    def _for(self, node: Any) -> End | None:
        self.scope = Scope({}, self.scope)
        if node.init is not None:
            self.value(node.init)
        return self._loop(node)

    def _loop(self, node: Any) -> End | None:
        scope = self.scope

        def turns() -> Iterator[None]:
            first = isinstance(node, c_ast.DoWhile)
            while first or node.cond is None or self.truth(node.cond):
                first = False
                yield
                self.scope = scope
                if isinstance(node, c_ast.For) and node.next is not None:
                    self.value(node.next)

        return self.repeat(turns(), [node.stmt], scope)

    _while = _dowhile = _loop

    def _switch(self, node: Any) -> End | None:
        chosen = self.arithmetic.plain(self.value(node.cond))
        items = items_of(node)
        start = next((at for at, each in enumerate(items) if self._is_case(chosen, each)), None)
        if start is None:
            start = next((at for at, each in enumerate(items) if isinstance(each, c_ast.Default)), len(items))
        flat = list[Any]()
        for each in items[start:]:
            flat += (each.stmts or []) if isinstance(each, c_ast.Case | c_ast.Default) else [each]
        end = self.block(flat, Scope({}, self.scope))
        return None if end is not None and end.kind == "break" else end

    def _is_case(self, chosen: Value, node: Any) -> bool:
        if not isinstance(node, c_ast.Case):
            return False
        value = self.value(node.expr)
        self.at(node)
        return self.arithmetic.truth(self.arithmetic.binary("==", chosen, value))

    # --- functions

    def parameter(self, node: Any) -> Type:
        """The type of a parameter; an array is handed over as a pointer."""
        type_ = self.type_of(node.type)
        return Pointer(type_) if isinstance(type_, Many) else type_

    def answer(self, node: Any, open_: Open, *, marks: bool = False) -> Value:
        """What a function of the file returns behind these statements. `marks`: whether it is the one that decides."""
        outer, self.depth = self.scope, self.depth + 1
        result = self.results.get(node.decl.name) or self.type_of(node.decl.type)
        end = self.follow(open_, marks=marks)
        self.scope, self.depth = outer, self.depth - 1
        if end is not None and end.kind != "return":
            raise self.make_error(f"a {end.kind} leads nowhere")
        if result == kinds.VOID:
            return None
        if end is None or end.value is None:
            self.at(node.decl)
            raise self.make_error(
                f"{escape_text(node.decl.name)} ends without a return on some path", "return on every path"
            )
        return self.cast(end.value, result)

    def run(self, node: Any, scope: Scope) -> End | None:
        """Runs a statement."""
        self.scope = scope
        end = self.value(node)
        return end if type(end) is End else None

    def branch(self, node: Any, scope: Scope, rest: Open) -> tuple[Sequence[Open], bool]:
        """The side that an `if` goes to and the other one, and whether a single test decides that; a block is one."""
        if isinstance(node, c_ast.Compound):
            return (link_statements(node.block_items or [], Scope({}, scope), rest), None), False
        self.scope = scope
        self.at(node)
        compared = isinstance(node.cond, c_ast.BinaryOp) and node.cond.op in SIGNS
        value = self.value(node.cond) if compared else None
        self.at(node.cond)
        holds = self.truth(node.cond) if value is None else self.arithmetic.truth(value)
        sides = [rest if each is None else (each, scope, rest) for each in (node.iftrue, node.iffalse)]
        return sides if holds else sides[::-1], isinstance(value, kinds.Condition)

    def keep(self, open_: Open) -> Any:
        """The state from which a path can go on: statements, and what variables hold."""
        return open_, dict(self.memory)

    # --- answers

    def together(self, values: Sequence[Value]) -> Any:
        """A value of Python for one value, a tuple for several; what they give, where that depends on features."""
        numbers = not any(isinstance(each, Text) for each in values)
        given = self.arithmetic.build_given(values) if numbers else None
        if given is not None:
            return given
        plain_values = [self._plain(each) for each in values]
        return plain_values[0] if len(plain_values) == 1 else tuple(plain_values)

    def _plain(self, value: Value) -> Any:
        if isinstance(value, Text):
            return value.text
        number = self.arithmetic.resolve_number(value)
        if not isinstance(number, Number):
            raise self.make_error("a feature is returned, not an action", "return a number that stands for an action")
        plain = number.value if isinstance(number.value, int) else float(number.value)
        if number.name not in ("", "true", "false"):
            self.named.setdefault(plain, number.name)
        return plain


READERS = {
    kind: vars(Machine)[f"_{name.lower()}"] for name, kind in vars(c_ast).items() if f"_{name.lower()}" in vars(Machine)
}
