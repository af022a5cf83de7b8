"""Types and names that a C file declares.

Does: makes types of declarations; keeps typedefs, struct tags, enumerators and scopes.
Assumes: nodes of pycparser, of a file after its preprocessor.
Does not: evaluate expressions, but asks `constant` for lengths and enumerators.
"""

# pyright: basic
# pycparser's nodes have no declared attributes
from collections.abc import Iterator, Mapping
from pathlib import PurePath
from typing import Any

from pycparser import c_ast, c_generator

from codegen.errors import InputError, escape_text
from codegen.importers.c.kinds import ENUM, INT, SPELLED, STANDARD, Callable_, Kind, Many, Pointer, Record, Type, Void
from codegen.importers.c.values import Number, Object

ADVICE = "give functions of ifs, comparisons with numbers, and returns"
MAX_SHOWN, MAX_LENGTH = 60, 1 << 20


def text_of(node: Any) -> str:
    """A node as C, short enough for a line."""
    return escape_text(" ".join(c_generator.CGenerator().visit(node).split()))[:MAX_SHOWN]


class Declarations:
    """The names of a file, and those of the function that is followed."""

    def __init__(self, where: str, names: Mapping[str, int]) -> None:
        self.where, self.line, self.text_file = where, 0, ""
        self.typedefs: dict[str, Type] = dict(STANDARD)
        self.tags: dict[str, Record] = {}
        self.functions: dict[str, Any] = {}
        self.results: dict[str, Type] = {}  # of functions that are declared
        self.scopes: list[dict[str, Object | Number]] = [
            {name: Number(value, INT, name) for name, value in names.items()}
        ]

    def at(self, node: Any) -> None:
        """The present place, for messages."""
        coord = getattr(node, "coord", None)
        if coord is not None and coord.line:
            self.line, self.text_file = int(coord.line), coord.file or ""

    def make_error(self, what: str, advice: str = ADVICE) -> InputError:
        """What is wrong at the present line."""
        file = PurePath(self.text_file).name
        header = f" of {file}" if file and file != PurePath(self.where.split(",")[0]).name else ""
        return InputError(what, f"{self.where}, line {self.line}{header}" if self.line else self.where, advice)

    def constant(self, node: Any) -> int:
        """The whole number that an expression is."""
        raise NotImplementedError

    def find_name(self, name: str) -> Object | Number | None:
        """What a name stands for; None: nothing."""
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
            return Callable_(self.type_of(node.type))
        if isinstance(node, c_ast.Struct):
            return self._record(node)
        if isinstance(node, c_ast.Enum):
            return self._enum(node)
        names = tuple(node.names) if isinstance(node, c_ast.IdentifierType) else ()
        type_ = self.typedefs.get(names[0]) if len(names) == 1 else None
        type_ = type_ or SPELLED.get(tuple(sorted(names))) or (Void() if names == ("void",) else None)
        if type_ is None:
            raise self.make_error(
                f"a type is not read: {text_of(node)}", "use float, double, and types of whole numbers"
            )
        return type_

    def _record(self, node: Any) -> Record:
        record = self.tags.get(node.name or "") or Record(node.name or "", {})
        if node.name:
            self.tags[node.name] = record
        for each in node.decls or ():
            type_ = self.type_of(each)
            if each.name is None and isinstance(type_, Record):
                record.members.update(type_.members)
                continue
            if each.bitsize is not None and isinstance(type_, Kind):
                bits = self.constant(each.bitsize)
                low, high = (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1) if type_.signed else (0, 2**bits - 1)
                type_ = Kind(f"{type_} of {bits} bits", 8, 1, max(low, type_.low), min(high, type_.high))
            record.members[each.name or ""] = type_
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
    """Whether a declaration of an object says that it is constant."""
    while isinstance(node, c_ast.Decl | c_ast.ArrayDecl | c_ast.Typename):
        node = node.type
    return "const" in getattr(node, "quals", ())
