"""Lists, dictionaries and observations as expressions: literals, lookups, comprehensions, and assignments to them.

Does: makes containers; looks up elements, numbers of the observation, and slices; gives values to targets.
Assumes: keys are constants, or whole numbers with few values.
Does not: know the methods of containers (objects.py).
"""

# pyright: basic
# the values of a program may be anything
import ast
from collections.abc import Iterator
from typing import Any

from codegen.importers.python.arithmetic import CONDITIONS, is_constant
from codegen.importers.python.expressions import eval_condition
from codegen.importers.python.machine import EXPRESSIONS, UNCOUNTED, Machine, reads, text_of
from codegen.importers.python.values import (
    Array,
    Bound,
    Class,
    Function,
    Instance,
    Member,
    Part,
    Refused,
    Scope,
    Stream,
    Symbol,
    words_of,
)


@reads(EXPRESSIONS, ast.List, ast.Tuple, ast.Set)
def _list(m: Machine, node: Any, scope: Scope) -> Any:
    items: list[Any] = []
    for each in node.elts:
        if isinstance(each, ast.Starred):
            items += m.items(m.eval(each.value, scope))
        else:
            items.append(m.eval(each, scope))
    m.keep_value(items)
    if isinstance(node, ast.Set):
        return m.keep_value({key_of(m, each) for each in items})
    return items if isinstance(node, ast.List) else tuple(items)


@reads(EXPRESSIONS, ast.Dict)
def _dict(m: Machine, node: ast.Dict, scope: Scope) -> Any:
    entries: dict[Any, Any] = {}
    for key, value in zip(node.keys, node.values, strict=True):
        if key is None:
            entries |= m.eval(value, scope)
        else:
            entries[key_of(m, m.eval(key, scope))] = m.eval(value, scope)
    return m.keep_value(entries)


def key_of(m: Machine, value: Any) -> Any:
    """A key of a dictionary: a constant; of a condition, what it is on this path."""
    m.count()
    if isinstance(value, tuple):
        return tuple(key_of(m, each) for each in value)
    value = m.truth(value) if isinstance(value, CONDITIONS) else value
    key = value if isinstance(value, Member) else m.whole(value)
    if isinstance(key, list) or not is_constant(key):
        raise Refused(f"{words_of(value)} is a key", "use numbers, texts or members of an Enum")
    return key


@reads(EXPRESSIONS, ast.Subscript)
def _subscript(m: Machine, node: ast.Subscript, scope: Scope) -> Any:
    value = m.eval(node.value, scope)
    key = slice(*_ends(m, node.slice, scope)) if isinstance(node.slice, ast.Slice) else m.eval(node.slice, scope)
    m.line = node.lineno
    if isinstance(value, Part):
        return _part_of(m, value, key, node)
    if isinstance(value, Class) and value.enum:
        value = {each.name: each for each in value.constants}
    if isinstance(value, Symbol | Bound):  # an annotation, such as list[int]
        return Symbol(text_of(node))
    if not isinstance(value, list | tuple | dict | str | range):
        raise Refused(f"something is looked up in {words_of(value)}", "compute with each x[0] by itself")
    if isinstance(key, slice):
        sequence: Any = value
        part = sequence[key]
        return part if isinstance(value, range) else m.keep_value(part)
    return value[key_of(m, key) if isinstance(value, dict) else m.whole(key)]


def _ends(m: Machine, node: ast.Slice, scope: Scope) -> list[Any]:
    return [None if each is None else m.whole(m.eval(each, scope)) for each in (node.lower, node.upper, node.step)]


def _part_of(m: Machine, part: Part, key: Any, node: ast.AST) -> Any:
    """A number of the observation, or a part of it."""
    if isinstance(key, slice):
        n = m.inputs.length(part.path)
        if not n and (key.stop is None or min(key.start or 0, key.stop, key.step or 1) < 0):
            raise Refused(*UNCOUNTED)
        parts = [m.inputs.enter(part, place) for place in range(*key.indices(n or key.stop))]
        return m.keep_value(Array(parts)) if part.array else tuple(parts)
    key = m.whole(key)
    if isinstance(key, bool) or not isinstance(key, int | str):
        raise Refused(f"{text_of(node)} is not understood", "write x[0], or x['speed']")
    return m.inputs.enter(part, key)


@reads(EXPRESSIONS, ast.ListComp, ast.SetComp, ast.DictComp, ast.GeneratorExp)
def _comprehension(m: Machine, node: Any, scope: Scope) -> Any:
    if any(isinstance(each, ast.NamedExpr) for each in ast.walk(node)):
        raise Refused(f"{text_of(node)} assigns a name on its way", "write a loop")
    first, inner = m.items(m.eval_stream(node.generators[0].iter, scope)), Scope({}, scope.outer)
    turns = _turns(m, node, inner, first)
    if isinstance(node, ast.DictComp):
        return m.keep_value({key_of(m, m.eval(node.key, inner)): m.eval(node.value, inner) for _ in turns})
    each = (m.eval(node.elt, inner) for _ in turns)
    if isinstance(node, ast.GeneratorExp):
        return Stream(each)
    return m.keep_value(list(each) if isinstance(node, ast.ListComp) else {key_of(m, one) for one in each})


def _turns(m: Machine, node: Any, scope: Scope, items: Any, depth: int = 0) -> Iterator[None]:
    """One turn for each element, with the names set."""
    generator = node.generators[depth]
    for each in items:
        m.count()
        assign(m, generator.target, each, scope)
        if all(eval_condition(m, test, scope) for test in generator.ifs):
            if depth + 1 < len(node.generators):
                inner = m.items(m.eval_stream(node.generators[depth + 1].iter, scope))
                yield from _turns(m, node, scope, inner, depth + 1)
            else:
                yield


# --- assignments


def assign(m: Machine, target: ast.expr, value: Any, scope: Scope) -> None:
    """Gives a value to a name, an attribute, an element, or names for its parts."""
    if isinstance(target, ast.Name):
        scope.names[target.id] = value
    elif isinstance(target, ast.Tuple | ast.List):
        _unpack_value(m, target, value, scope)
    elif isinstance(target, ast.Attribute):
        owner = m.eval(target.value, scope)
        if not isinstance(owner, Instance) or isinstance(owner.kind.members.get(target.attr), Function):
            raise Refused(f"{text_of(target)} is no plain attribute of an object", "set attributes of self in __init__")
        m.ensure_fresh(owner, target).attributes[target.attr] = value
    elif isinstance(target, ast.Subscript):
        owner, key = m.eval(target.value, scope), m.eval(target.slice, scope)
        if isinstance(owner, Array) or not isinstance(owner, list | dict) or isinstance(target.slice, ast.Slice):
            raise Refused(f"{text_of(target)} is set", "give it another name instead")
        key = key_of(m, key) if isinstance(owner, dict) else m.whole(key)
        m.ensure_fresh(owner, target)[key] = value
    else:
        raise Refused(f"{text_of(target)} is set", "give it a name")


def _unpack_value(m: Machine, target: ast.Tuple | ast.List, value: Any, scope: Scope) -> None:
    names = target.elts
    stars = [place for place, each in enumerate(names) if isinstance(each, ast.Starred)]
    if isinstance(value, Part) and not stars:
        m.inputs.count_names(value.path, [each.id if isinstance(each, ast.Name) else "" for each in names])
    items = list(m.items(value))
    if stars:
        end = max(stars[0], len(items) - (len(names) - stars[0] - 1))
        items[stars[0] : end] = [m.keep_value(items[stars[0] : end])]
    if len(items) != len(names):
        raise Refused(f"{len(items)} values are given to {len(names)} names", "give each a name")
    for each, item in zip(names, items, strict=True):
        assign(m, each.value if isinstance(each, ast.Starred) else each, item, scope)
