"""The syntax tree of a C file before it is followed: what a decision remembers, and what it reads and does by calls.

Does: moves static variables of functions to the file, where both readings reach them; says which parts of an object
  are remembered, and which functions reset them. Finds the functions whose calls are features or actions, takes their
  own code away, and says which functions call them.
Assumes: a syntax tree that nobody else reads yet.
Does not: follow a decision (source.py), or write what stands for these functions where a compiler is asked
  (compiled.py).
"""

# pyright: basic
# pycparser's nodes have no declared attributes
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from pycparser import c_ast

from codegen.errors import InputError, escape_text
from codegen.importers.c.kinds import Kind, Object
from codegen.importers.c.machine import collect_assigned, is_const, list_targets, parameters_of, walk

ENTRIES = frozenset(("main", "setup", "loop"))


def hoist_statics(parsed: Any) -> dict[str, str]:
    """Makes variables of the file of static variables that their functions set: name there -> name in the function."""
    hoisted, taken = dict[str, str](), set[str]()
    for place in range(len(parsed.ext) - 1, -1, -1):
        function = parsed.ext[place]
        if not isinstance(function, c_ast.FuncDef):
            continue
        inner = [each for each in walk(function.body) if isinstance(each, c_ast.Decl)]
        if not any("static" in each.storage for each in inner):
            continue
        assigned, moved = collect_assigned(function), list[Any]()
        taken |= {each.name for each in walk(parsed) if isinstance(each, c_ast.ID | c_ast.Decl | c_ast.Enumerator)}
        outside = [each.decl if isinstance(each, c_ast.FuncDef) else each for each in parsed.ext]
        outside += [each for one in outside for each in walk(one) if isinstance(each, c_ast.Enumerator)]
        outer = {each.name for each in outside if isinstance(each, c_ast.Decl | c_ast.Enumerator)}
        named = [each for each in walk(function.body) if isinstance(each, c_ast.Enumerator)]
        declared = [each.name for each in (*inner, *named, *parameters_of(function))]
        for items in _blocks(function.body):
            for each in [one for one in items if isinstance(one, c_ast.Decl) and "static" in one.storage]:
                # a name that means something else elsewhere in the function would be renamed there, too
                hidden = declared.count(each.name) > 1 or each.name in outer
                if each.name not in assigned or is_const(each) or hidden:
                    continue
                name = f"{function.decl.name}_{each.name}"
                while name in taken:
                    name += "_"
                taken.add(name)
                hoisted[name] = each.name
                items.remove(each)
                moved.append(each)
                _rename(function.body, each, name)
        parsed.ext[place:place] = moved
        walk.cache_clear()
    return hoisted


def _blocks(body: Any) -> Iterator[list[Any]]:
    """The lists of statements below a node."""
    for each in walk(body):
        items = getattr(each, "block_items", None) or (getattr(each, "stmts", None))
        if items:
            yield items


def _rename(body: Any, decl: Any, name: str) -> None:
    """Gives a variable another name in its declaration and wherever it stands, but not as a member."""
    nodes = walk(body)
    members = {id(each.field) for each in nodes if isinstance(each, c_ast.StructRef)}
    members |= {id(part) for each in nodes if isinstance(each, c_ast.NamedInitializer) for part in each.name}
    for each in nodes:
        if isinstance(each, c_ast.ID) and each.name == decl.name and id(each) not in members:
            each.name = name
    inner = decl.type
    while not isinstance(inner, c_ast.TypeDecl):
        inner = inner.type
    inner.declname = decl.name = name


def collect_called(name: str, functions: Mapping[str, Any]) -> set[str]:
    """The functions of the file that one calls, directly or not, and itself."""
    called, open_ = set[str](), [name]
    while open_:
        each = open_.pop()
        if each in functions and each not in called:
            called.add(each)
            open_ += [part.name for part in walk(functions[each].body) if isinstance(part, c_ast.ID)]
    return called


def list_setters(name: str, kept: str, functions: Mapping[str, Any], aliased: bool) -> list[Any]:
    """The functions that set a variable of the file, or a struct that they are given alone, and that `name` does not
    call. `aliased`: whether what names the variable may set it.
    """
    called = collect_called(name, functions)
    others = [each for each in functions.values() if each.decl.name not in called]
    pointed = {each.name: each for each in parameters_of(functions[name])}.get(kept)
    if pointed is None:
        named = {each.decl.name for each in others for part in walk(each) if getattr(part, "name", None) == kept}
        return [each for each in others if kept in collect_assigned(each) or (aliased and each.decl.name in named)]
    return [each for each in others if [_type_name(one) for one in parameters_of(each)] == [_type_name(pointed)]]


def _type_name(node: Any) -> str:
    """What a pointer leads to, by its name; "": nothing with a name."""
    type_ = getattr(node.type, "type", None) if isinstance(node.type, c_ast.PtrDecl) else None
    inner = getattr(type_, "type", None)
    return " ".join(getattr(inner, "names", ())) or f"struct {getattr(inner, 'name', '')}" if inner is not None else ""


def list_parts(target: Object, name: str, functions: Mapping[str, Any]) -> list[Object]:
    """The parts of an object of the caller's that a decision sets: its members that are assigned to."""
    ways = [way for each in collect_called(name, functions) for way in list_targets(functions[each].body)]
    members = {each.field.name for way in ways for each in way if isinstance(each, c_ast.StructRef)}
    return [each for each in target.parts() if isinstance(target.type, Kind) or members & {*each.place.way}]


def is_read(parts: Iterable[Object], name: str, functions: Mapping[str, Any]) -> bool:
    """Returns True if a decision not only sets the members that parts are, but reads one somewhere."""
    members = {step for part in parts for step in part.place.way}
    nodes = [node for each in collect_called(name, functions) for node in walk(functions[each].body)]
    only_set = {id(node.lvalue) for node in nodes if isinstance(node, c_ast.Assignment) and node.op == "="}
    read = [node for node in nodes if isinstance(node, c_ast.StructRef) and id(node) not in only_set]
    return any(node.field.name in members for node in read)


# --- functions whose calls are features, or actions


def find_calls(parsed: Any, names: Iterable[str], where: str, *, acting: bool) -> dict[str, Any]:
    """The declarations of functions, by their names; what the file says that they do is taken away. `acting`: they
    give nothing. InputError for a function that the file does not declare, or that is given something.
    """
    found = dict[str, Any]()
    for name in names:
        what, form = (
            f"the file declares no function {escape_text(name)}",
            f"{'void' if acting else 'float'} {name}(void);",
        )
        for place, each in enumerate(parsed.ext):
            decl = each.decl if isinstance(each, c_ast.FuncDef) else each
            if not isinstance(decl, c_ast.Decl) or decl.name != name or not isinstance(decl.type, c_ast.FuncDecl):
                continue
            parsed.ext[place] = decl
            result = getattr(decl.type.type.type, "names", None)
            if parameters_of(c_ast.FuncDef(decl, None, None)):
                what = f"{escape_text(name)} is given something"
            elif acting and result != ["void"]:
                what = f"{escape_text(name)} is an action, and gives a value"
            else:
                found[name] = decl
        if name not in found:
            raise InputError(what, where, f"declare a function of its own: {form}")
    walk.cache_clear()
    return found


def list_callers(functions: Mapping[str, Any], acts: Iterable[str]) -> list[str]:
    """The functions that call one of `acts`, directly or not, and that no other of these calls; `loop` only where it
    is the only one, `main` never.
    """
    wanted = {*acts}

    def reaches(name: str) -> bool:
        called = collect_called(name, functions)
        return any(
            isinstance(part, c_ast.ID) and part.name in wanted for one in called for part in walk(functions[one])
        )

    acting = [name for name in functions if name not in ("main", "setup") and reaches(name)]
    inner = {part for name in acting if name not in ENTRIES for part in collect_called(name, functions) - {name}}
    roots = [name for name in acting if name not in inner]
    return [name for name in roots if name not in ENTRIES] or roots
