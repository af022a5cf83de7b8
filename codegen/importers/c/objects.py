"""What a C file declares, and the objects of one path: which one an expression names, and what it holds.

Does: makes types of declarations; keeps typedefs, struct tags, enumerators and scopes; finds variables, members and
  items; reads them, so that the caller's become features; sets and initializes them.
Assumes: nodes of pycparser, of a file after its preprocessor; machine.py evaluates what stands within them.
Does not: compute, or let anything be kept between decisions.
"""

# pyright: basic
# pycparser's nodes have no declared attributes
from collections.abc import Iterator, Mapping
from pathlib import PurePath
from typing import Any

from pycparser import c_ast, c_generator

from codegen.errors import InputError, escape_text
from codegen.importers.c import kinds
from codegen.importers.c.arithmetic import TEST_ADVICE, Arithmetic
from codegen.importers.c.inputs import Inputs
from codegen.importers.c.kinds import (
    ENUM,
    INT,
    Kind,
    Many,
    Number,
    Object,
    Pointer,
    Record,
    Reference,
    Type,
    Value,
    Void,
)
from codegen.importers.c.library import CONSTANTS
from codegen.importers.symbolic.paths import STATE_ADVICE, Growth

ADVICE = "give functions of ifs, comparisons with numbers, and returns"
KEPT = "the {} keeps what earlier decisions set"
MAX_SHOWN, MAX_LENGTH = 60, 1 << 20


def text_of(node: Any) -> str:
    """A node as C, short enough for a line."""
    return escape_text(" ".join(c_generator.CGenerator().visit(node).split()))[:MAX_SHOWN]


def walk(node: Any) -> Iterator[Any]:
    """A node and all below it."""
    open_ = [node]
    while open_:
        each = open_.pop()
        yield each
        open_ += [child for _, child in each.children()]


def collect_assigned(node: Any) -> set[str]:
    """The names that are assigned to, counted up or down, or whose address is taken, below a node; but not its own."""
    assigned, own = set[str](), set[str]()
    for each in walk(node):
        target = None
        if isinstance(each, c_ast.Assignment):
            target = each.lvalue
        elif isinstance(each, c_ast.UnaryOp) and each.op in ("++", "--", "p++", "p--", "&"):
            target = each.expr
        elif isinstance(each, c_ast.Decl) and "static" not in each.storage and each.name:
            own.add(each.name)
        while isinstance(target, c_ast.ArrayRef | c_ast.StructRef):
            target = target.name
        if isinstance(target, c_ast.ID):
            assigned.add(target.name)
    return assigned - own


def is_const(node: Any) -> bool:
    """Returns True if a declaration of an object says that it is constant."""
    while isinstance(node, c_ast.Decl | c_ast.ArrayDecl | c_ast.Typename):
        node = node.type
    return "const" in getattr(node, "quals", ())


def parameters_of(node: Any) -> list[Any]:
    """The parameters of a function; `void` is none."""
    given = list(node.decl.type.args.params) if node.decl.type.args is not None else []
    return [each for each in given if isinstance(each, c_ast.Decl) and each.name]


def acts(node: Any) -> bool:
    """Returns True if an expression may do more than compute."""
    return any(
        isinstance(each, c_ast.Assignment | c_ast.FuncCall | c_ast.TernaryOp)
        or (isinstance(each, c_ast.UnaryOp) and each.op in ("++", "--", "p++", "p--"))
        for each in walk(node)
    )


class Objects:
    """The names of a file and those of the function that is followed, and what they hold on one path."""

    paths: Growth | None = None
    inputs: Inputs | None = None

    def __init__(self, where: str, names: Mapping[str, int], numbers: str, *, contracts: bool) -> None:
        self.where, self.line, self.text_file = where, 0, ""
        self.typedefs: dict[str, Type] = dict(kinds.STANDARD)
        self.tags: dict[str, Record] = {}
        self.functions: dict[str, Any] = {}
        self.results: dict[str, Type] = {}  # of functions that are declared
        self.scopes: list[dict[str, Object | Number]] = [{name: Number(of, INT, name) for name, of in names.items()}]
        self.constants: dict[kinds.Place, Value] = {}  # what the file's own variables hold
        self.memory = self.constants  # what was set on this path
        self.fixed: dict[str | int, str] = {}  # why a variable must not be set
        self.arithmetic = Arithmetic(self.make_error, numbers, contracts=contracts)
        self.changing: set[str] = set()  # variables of the file that some function may set
        self._count = 0  # of variables

    def at(self, node: Any) -> None:
        """The present place, for messages."""
        coord = getattr(node, "coord", None)
        if coord is not None and coord.line:
            self.line, self.text_file = int(coord.line), coord.file or ""

    def make_error(self, what: str, advice: str = ADVICE) -> InputError:
        """Makes an error of what is wrong at the present line."""
        file = PurePath(self.text_file).name
        header = f" of {file}" if file and file != PurePath(self.where.split(",")[0]).name else ""
        return InputError(what, f"{self.where}, line {self.line}{header}" if self.line else self.where, advice)

    def value(self, node: Any) -> Value:
        """Returns the value of an expression."""
        raise NotImplementedError

    def constant(self, node: Any) -> int:
        """The whole number that an expression is."""
        value = self.arithmetic.plain(self.value(node))
        if not isinstance(value, Number) or value.kind.floating:
            raise self.make_error(f"not a whole number: {text_of(node)}", "write the number")
        return int(value.value)

    def find_name(self, name: str) -> Object | Number | None:
        """Returns what a name stands for; None: nothing."""
        return next((scope[name] for scope in reversed(self.scopes) if name in scope), None)

    # --- types

    def type_of(self, node: Any) -> Type:
        """The type that a declaration or a type name says."""
        self.at(node)
        if isinstance(node, c_ast.TypeDecl | c_ast.Typename | c_ast.Decl):
            return self.type_of(node.type)
        if isinstance(node, c_ast.PtrDecl):
            return Pointer(self.type_of(node.type))
        if isinstance(node, c_ast.ArrayDecl):
            length = 0 if node.dim is None else self.constant(node.dim)
            if not 0 <= length <= MAX_LENGTH:
                raise self.make_error(f"a length is not read: {length}")
            return Many(self.type_of(node.type), length)
        if isinstance(node, c_ast.FuncDecl):
            return kinds.Callable_(self.type_of(node.type))
        if isinstance(node, c_ast.Struct):
            return self._record(node)
        if isinstance(node, c_ast.Enum):
            return self._enum(node)
        names = tuple(node.names) if isinstance(node, c_ast.IdentifierType) else ()
        type_ = self.typedefs.get(names[0]) if len(names) == 1 else None
        type_ = type_ or kinds.SPELLED.get(tuple(sorted(names))) or (Void() if names == ("void",) else None)
        if type_ is None:
            what = f"a type is not read: {text_of(node)}"
            raise self.make_error(what, "use float, double, and types of whole numbers")
        return type_

    def _record(self, node: Any) -> Record:
        name = node.name or str(node.coord)
        record = self.tags.setdefault(name, Record(name, {}))
        for each in node.decls or ():
            if each.name is None or each.bitsize is not None:
                self.at(each)
                raise self.make_error("a member has bits or no name", "declare it as a whole number with a name")
            record.members[each.name] = self.type_of(each)
        return record

    def _enum(self, node: Any) -> Kind:
        last, lowest = -1, 0
        for each in node.values.enumerators if node.values is not None else ():
            last = last + 1 if each.value is None else self.constant(each.value)
            if not INT.holds(last):
                raise self.make_error(f"the enumerator {escape_text(each.name)} is no int")
            lowest = min(lowest, last)
            self.scopes[-1][each.name] = Number(last, INT, each.name)
        if node.name and node.values is not None:
            self.typedefs[f"enum {node.name}"] = INT if lowest < 0 else ENUM
        return INT if lowest < 0 or self.typedefs.get(f"enum {node.name}") == INT else ENUM

    # --- which object an expression names

    def new_object(self, type_: Type) -> Object:
        """A variable without a value."""
        self._count += 1
        return Object(kinds.Place(self._count), type_)

    def place(self, node: Any) -> Any:
        """The object that an expression names; for what is none, its value."""
        if isinstance(node, c_ast.ID):
            return self._find_object(node)
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
            value = self.value(node.expr)
            return value if isinstance(value, kinds.Function) else self.target(value, 0, node)
        return self.value(node)

    def _find_object(self, node: Any) -> Any:
        target = self.find_name(node.name)
        if target is None and node.name in self.functions:
            return kinds.Function(self.functions[node.name])
        if target is None and node.name in CONSTANTS:
            return CONSTANTS[node.name]
        if target is None:
            raise self.make_error(f"the name {escape_text(node.name)} is not known", "define it in the file")
        if node.name in self.changing and self.scopes[0].get(node.name) is target:
            self.at(node)
            raise self.make_error(KEPT.format(f"variable {escape_text(node.name)}"), STATE_ADVICE)
        return target

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
        if isinstance(type_, Kind) and isinstance(value, Reference | Object | kinds.Text | kinds.Function):
            if type_.name == "_Bool":
                return Number(1, type_)
            raise self.make_error("a pointer or a text becomes a number", TEST_ADVICE)
        if isinstance(type_, Kind):
            return self.arithmetic.convert_value(value, type_)
        if isinstance(type_, Pointer) and isinstance(value, Reference):
            actual = value.target.type
            if type_.to not in (actual, Void()) and not (isinstance(type_.to, Many) and type_.to.of == actual):
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
        listed = isinstance(node, c_ast.InitList)
        if not isinstance(target.type, Record | Many):
            self.store(target, self.value(node.exprs[0] if listed and len(node.exprs) == 1 else node))
        elif listed:
            of = target.type
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
