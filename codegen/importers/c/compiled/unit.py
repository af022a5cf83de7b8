"""What a C file says, written again for a compiler: one file of C with a door to each function that decides.

Does: writes the parts of a syntax tree that functions need by pycparser's own generator; adds what sets the parameters
  of each function, calls it and hands on its answer; lists the file's constant expressions.
Assumes: nodes of pycparser, without the types that headers name.
Does not: evaluate anything: the compiler itself says of which type each feature is, and what constants are.

All bytes of what is handed over are 0 for one row and 1 for the next, so that a program that looks at more than its
features is seen.
"""

# pyright: basic
# pycparser's nodes have no declared attributes
from collections.abc import Iterator, Mapping, Sequence
from copy import copy, deepcopy
from dataclasses import dataclass
from typing import Any

from pycparser import c_ast, c_generator

from codegen.importers.c.kinds import Place
from codegen.importers.c.objects import walk

BEFORE = "maviper_"
SLACK = 16  # items of an array behind the last one that is a feature
HEADERS: Mapping[str, tuple[str, ...]] = {  # which names make a file need which header
    "stdbool": ("bool", "true", "false"),
    "stddef": ("size_t", "ptrdiff_t", "NULL"),
    "string": ("memcpy", "memset"),
    "stdlib": ("abs", "labs", "llabs", "EXIT_SUCCESS", "EXIT_FAILURE"),
    "assert": ("assert",),
    "stdio": ("printf", "fprintf", "puts", "fputs", "putchar", "putc", "fputc", "fflush", "perror", "FILE"),
    "float": ("FLT_MAX", "FLT_MIN", "FLT_EPSILON", "DBL_MAX", "DBL_MIN", "DBL_EPSILON"),
}
WIDE, CHAR = "wide", "char"
BEGIN = "void maviper_fail(void);"
DOOR = """
#define maviper_wide(narrow) (sizeof(long) == 8 ? "wide" : narrow)
#define maviper_kind(v) _Generic((v), float: "float32", double: "float64", _Bool: "bool", char: "char", \\
    signed char: "int8", unsigned char: "uint8", short: "int16", unsigned short: "uint16", int: "int32", \\
    unsigned int: "uint32", long: maviper_wide("int32"), \\
    unsigned long: maviper_wide("uint32"), long long: "wide", \\
    unsigned long long: "wide", default: "other")
#define maviper_give(v) _Generic((v), float: maviper_number, double: maviper_number, char: maviper_letter, \\
    char *: maviper_text, const char *: maviper_text, unsigned long: maviper_natural, \\
    unsigned long long: maviper_natural, default: maviper_whole)(v)
void maviper_number(double), maviper_letter(char), maviper_text(const char *), maviper_natural(unsigned long long);
void maviper_whole(long long), maviper_say(const char *);
"""


@dataclass(frozen=True)
class Asked:
    """A function that decides: where its features stand, and where it leaves its answer; parameter "": returned."""

    name: str
    features: tuple[Place, ...]
    answers: tuple[Place, ...]


def write_unit(parsed: Any, asked: Sequence[Asked], names: Mapping[str, int], headers: Sequence[str]) -> str:
    """A file of C that needs a driver (builds.py). `names`: macros that stand in the tree as names; `headers`: that
    the source includes.
    """
    nodes = list(_choose_nodes(parsed, {each.name for each in asked}))
    generator = c_generator.CGenerator()
    parts = [BEGIN, *(f"#include <{each}.h>" for each in dict.fromkeys((*headers, *_headers(nodes))))]
    parts += ["#undef assert", "#define assert(e) ((e) ? (void)0 : maviper_fail())"]
    parts += [f"#define {name} ({value})" for name, value in names.items()]
    parts += [generator.visit(node) + ("" if isinstance(node, c_ast.FuncDef) else ";") for node in nodes]
    functions = {each.decl.name: each for each in nodes if isinstance(each, c_ast.FuncDef)}
    typedefs = {each.name: each.type for each in nodes if isinstance(each, c_ast.Typedef)}
    parts += [DOOR, *(_door(at, each, functions[each.name].decl, typedefs) for at, each in enumerate(asked))]
    doors = ", ".join(f"{BEFORE}door_{at}" for at in range(len(asked)))
    parts.append(f"int (*{BEFORE}doors[])(const double *, int) = {{{doors}}};")
    numbers = [f"{BEFORE}number({each});" for each in _constants(nodes, names)]
    parts += [f"void {BEFORE}numbers(void) {{", "#ifdef MAVIPER_NUMBERS", *numbers, "#endif", "}"]
    return "\n".join(parts) + "\n"


def _choose_nodes(parsed: Any, wanted: set[str]) -> Iterator[Any]:
    """Yields the nodes of the file that functions need, in its order; each name is the file's own."""
    named: dict[str, list[Any]] = {}
    for each in parsed.ext:
        decl = each.decl if isinstance(each, c_ast.FuncDef) else each
        if isinstance(decl, c_ast.Decl | c_ast.Typedef) and decl.name:
            named.setdefault(decl.name, []).append(each)
    needed, open_ = set[str](), list(wanted)
    while open_:
        name = open_.pop()
        if name not in needed and name in named:
            needed.add(name)
            for part in (part for each in named[name] for part in walk(each)):
                open_ += [part.name] if isinstance(part, c_ast.ID) else []
                open_ += part.names if isinstance(part, c_ast.IdentifierType) else []
    defined = {each.decl.name for each in parsed.ext if isinstance(each, c_ast.FuncDef)}
    for each in parsed.ext:
        function = isinstance(each, c_ast.FuncDef)
        decl = each.decl if function else each
        if isinstance(each, c_ast.Typedef):
            yield from [each] * (each.name in needed or _defines(each))
        elif isinstance(decl, c_ast.Decl) and (decl.name in needed or (not function and _defines(decl))):
            own = decl.name in defined or not isinstance(decl.type, c_ast.FuncDecl)
            held = copy(decl)
            held.storage = ["static"] if decl.name and own and "extern" not in decl.storage else decl.storage
            if function:
                each = copy(each)
                each.decl, held = held, each
            yield held


def _defines(decl: Any) -> bool:
    """Returns True if a declaration defines a struct or enumerators."""
    return any(
        (isinstance(each, c_ast.Struct | c_ast.Union) and each.decls) or (isinstance(each, c_ast.Enum) and each.values)
        for each in walk(decl)
    )


def _headers(nodes: Sequence[Any]) -> Iterator[str]:
    """Headers whose names are used and not declared."""
    used, declared, types = set[str](), set[str](), set[str]()
    for each in (part for node in nodes for part in walk(node)):
        if isinstance(each, c_ast.ID):
            used.add(each.name)
        elif isinstance(each, c_ast.IdentifierType):
            types |= set(each.names)
        elif isinstance(each, c_ast.Typedef | c_ast.Decl | c_ast.Enumerator):
            declared.add(each.name)
    known = {name for names in HEADERS.values() for name in names}
    rest = used - declared - known
    yield from (header for header, names in HEADERS.items() if ((used | types) - declared) & set(names))
    ends = any(name.endswith(("_MAX", "_MIN")) for name in rest)
    yield from (["stdint"] if ends or any(name.endswith("_t") for name in types - declared - known) else [])
    yield from ([*["limits"] * ends, "math"] if rest else [])


def _constants(nodes: Sequence[Any], names: Mapping[str, int]) -> Iterator[str]:
    """The constant expressions of a file, each once: literals, enumerators, and what is computed of them."""
    generator, outside = c_generator.CGenerator(), [each for each in nodes if not isinstance(each, c_ast.FuncDef)]
    enumerators = [part.name for each in outside for part in walk(each) if isinstance(part, c_ast.Enumerator)]
    scalars = [
        each.name
        for each in outside
        if isinstance(each, c_ast.Decl) and isinstance(each.type, c_ast.TypeDecl) and "const" in each.quals
        and isinstance(each.type.type, c_ast.IdentifierType | c_ast.Enum)
    ]  # fmt: skip
    known = {*names, *enumerators, *scalars}
    found = dict.fromkeys([*names, *enumerators])
    for each in (part for node in nodes for part in walk(node)):
        if isinstance(each, c_ast.Constant | c_ast.UnaryOp | c_ast.BinaryOp | c_ast.Cast) and _is_fixed(each, known):
            found[generator.visit(each)] = None
    yield from found


def _is_fixed(node: Any, known: set[str]) -> bool:
    if isinstance(node, c_ast.Constant):
        return node.type != "string"
    if isinstance(node, c_ast.ID):
        return node.name in known
    if isinstance(node, c_ast.UnaryOp):
        return node.op in "-+~!" and _is_fixed(node.expr, known)
    if isinstance(node, c_ast.BinaryOp):
        return _is_fixed(node.left, known) and _is_fixed(node.right, known)
    plain = isinstance(node, c_ast.Cast) and isinstance(node.to_type.type, c_ast.TypeDecl)
    return plain and _is_fixed(node.expr, known)


def _door(at: int, asked: Asked, decl: Any, typedefs: Mapping[str, Any]) -> str:
    """Writes C that sets a function's parameters to a row, calls it, and hands on its answer; without a row it says of
    which type each feature is. 0 is returned for a number that a parameter does not hold.
    """
    places = [*asked.features, *asked.answers]
    given = [each for each in (decl.type.args.params if decl.type.args else ()) if isinstance(each, c_ast.Decl)]
    pointers, lines = set[str](), list[str]()
    for each in given:
        counted = [place.way[0] for place in places if place.base == each.name and place.way]
        most = max((step for step in counted if isinstance(step, int)), default=0)
        lines.append(f"static {_storage(each, most + 1 + SLACK, typedefs, pointers)};")
        lines.append(f"__builtin_memset(&{BEFORE}{each.name}, row & 1, sizeof {BEFORE}{each.name});")
    inputs = [_place(each, pointers) for each in asked.features]
    lines.append("if (!in) {")
    lines += [f"maviper_say(maviper_kind({each}));" for each in inputs]
    lines += ["return 1;", "}"]
    lines += [f"{each} = in[{column}];" for column, each in enumerate(inputs)]
    lines += [
        f"if ({each} != in[{column}] && in[{column}] == in[{column}]) return 0;" for column, each in enumerate(inputs)
    ]
    call = f"{asked.name}({', '.join(BEFORE + each.name for each in given)})"
    result = deepcopy(decl.type.type)
    if getattr(getattr(result, "type", None), "names", None) != ["void"] or isinstance(result, c_ast.PtrDecl):
        call = f"{_declare(result, 'returned')} = {call}"
        pointers |= {"returned"} if isinstance(result, c_ast.PtrDecl) else set()
    lines += [f"{call};", *(f"maviper_give({_place(each, pointers)});" for each in asked.answers), "return 1;"]
    body = "\n".join(lines)
    return f"static int {BEFORE}door_{at}(const double *in, int row) {{\n{body}\n}}"


def _place(place: Place, pointers: set[str]) -> str:
    """A feature or a part of an answer, as C says it."""
    name = str(place.base or "returned")
    single = name in pointers and place.way and isinstance(place.way[0], str)
    steps = "".join(f".{step}" if isinstance(step, str) else f"[{step}]" for step in place.way)
    return f"{BEFORE}{name}{'[0]' if single else ''}{steps}"


def _storage(decl: Any, length: int, typedefs: Mapping[str, Any], pointers: set[str]) -> str:
    """A variable for a parameter; for a pointer, an array of what it points to."""
    type_ = known = decl.type
    while isinstance(known, c_ast.TypeDecl) and isinstance(known.type, c_ast.IdentifierType):
        known = typedefs.get(" ".join(known.type.names))
    type_ = deepcopy(known if isinstance(known, c_ast.PtrDecl) else type_)
    if isinstance(type_, c_ast.PtrDecl) or (isinstance(type_, c_ast.ArrayDecl) and type_.dim is None):
        pointers |= {decl.name}
        type_ = c_ast.ArrayDecl(type_.type, c_ast.Constant("int", str(length)), [])
        if getattr(getattr(type_.type, "type", None), "names", None) == ["void"]:
            type_.type.type.names = ["char"]
    inner = type_
    while not isinstance(inner, c_ast.TypeDecl):
        if isinstance(inner, c_ast.ArrayDecl):
            inner.dim_quals = []
        else:
            inner.quals = []
        inner = inner.type
    inner.quals = []
    return _declare(type_, decl.name)


def _declare(type_: Any, name: str) -> str:
    """The declaration of a variable of ours."""
    inner = type_
    while not isinstance(inner, c_ast.TypeDecl):
        inner = inner.type
    inner.declname = BEFORE + name
    return c_generator.CGenerator().visit(c_ast.Decl(BEFORE + name, [], [], [], [], type_, None, None))
