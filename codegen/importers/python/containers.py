"""Lists, dictionaries and observations as expressions: literals, subscripts, comprehensions.

Does: makes containers; looks up elements, numbers of the observation, and slices.
Assumes: keys are constants, or whole numbers with few values.
Does not: change containers (statements.py).
"""

# pyright: basic
# the values of a program may be anything
import ast
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from codegen.errors import escape_text
from codegen.importers.python.expressions import eval_condition
from codegen.importers.python.machine import EXPRESSIONS, UNCOUNTED, Machine, reads, text_of
from codegen.importers.python.sequences import count_features, items_of, map_part
from codegen.importers.python.values import Array, Bound, Class, Instance, Length, Member, Part, Scope, Symbol, Unread


@reads(EXPRESSIONS, ast.List, ast.Tuple, ast.Set)
def _list(m: Machine, node: Any, scope: Scope) -> Any:
    items: list[Any] = []
    for each in node.elts:
        if isinstance(each, ast.Starred):
            more = items_of(m, m.eval(each.value, scope))
            if isinstance(more, Unread):
                return more
            items += list(more)
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
            more = m.require_value(m.eval(value, scope))
            if not isinstance(more, dict):
                raise m.make_error(node, f"{text_of(node)} is not understood", "write its items")
            entries |= more
        else:
            entries[key_of(m, m.eval(key, scope))] = m.eval(value, scope)
    return m.keep_value(entries)


def key_of(m: Machine, value: Any) -> Any:
    """A key of a dictionary: a constant."""
    m.count()
    if isinstance(value, tuple):
        return tuple(key_of(m, each) for each in value)
    value = m.whole(value)
    if isinstance(value, list | dict | set):
        raise m.make_error(None, "a list is no key", "use numbers or texts")
    return value


@reads(EXPRESSIONS, ast.Subscript)
def _subscript(m: Machine, node: ast.Subscript, scope: Scope) -> Any:
    value = m.eval(node.value, scope)
    if isinstance(value, Unread):
        return value
    key = m.eval(node.slice, scope)
    m.line = node.lineno
    if isinstance(value, Part):
        return part_of(m, value, key, node)
    if isinstance(value, Class) and value.enum:
        return value.members.get(key) or m.unread(f"{escape_text(str(key))} is no member", "name one")
    if isinstance(value, tuple) and len(value) == 1 and isinstance(value[0], Length):
        return value[0]
    if isinstance(value, Symbol | Bound | Class):  # an annotation, such as list[int]
        return value
    if not isinstance(value, list | tuple | dict | str | range):
        m.require_value(value)
        raise m.make_error(node, f"{text_of(node)} is not understood", "look things up in lists and dictionaries")
    try:
        return value[key] if isinstance(key, slice) else value[key_of(m, key)]
    except (LookupError, TypeError, ValueError):
        what = f"{text_of(node)} looks up what is not there"
        raise m.make_error(node, what, "clip the index, or give every key") from None


def part_of(m: Machine, part: Part, key: Any, node: ast.AST) -> Any:
    """A number of the observation, or a part of it."""
    if part.scaled and not part.array and isinstance(key, int | slice):
        return m.unread(
            "arithmetic is done on the whole observation", "take it as an array: np.asarray(x); or do it on each number"
        )
    if isinstance(key, tuple):
        for each in key:
            part = part_of(m, part, each, node)
        return part
    if isinstance(key, slice):
        low, high, step = key.start or 0, key.stop, key.step or 1
        n = max(m.inputs.length(part.path) - part.offset, 0)
        if high is None and not n and isinstance(low, int) and low >= 0 and step == 1:
            return replace(part, offset=part.offset + low)
        if not n and (not isinstance(high, int) or min(low, high) < 0 or step != 1):
            return m.unread(*UNCOUNTED)
        places = range(*key.indices(n or int(high or 0)))
        parts = [m.inputs.enter(part, place, m.line) for place in places]
        return m.keep_value(Array(parts)) if part.array else tuple(parts)
    key = m.whole(key)
    key = key.value if isinstance(key, Member) else key
    if isinstance(key, bool) or not isinstance(key, int | str):
        raise m.make_error(node, f"{text_of(node)} is not understood", "write x[0], or x['speed']")
    if isinstance(key, int) and key < 0 and not m.inputs.length(part.path):
        what = f"{text_of(node)} counts from the end, and the file does not say how many features there are"
        return m.unread(what, "count from the front, or name all features: --features a,b,c")
    return m.inputs.enter(part, key, m.line)


@reads(EXPRESSIONS, ast.Slice)
def _slice(m: Machine, node: ast.Slice, scope: Scope) -> Any:
    ends = (node.lower, node.upper, node.step)
    return slice(*(None if each is None else m.whole(m.eval(each, scope)) for each in ends))


@reads(EXPRESSIONS, ast.ListComp, ast.SetComp, ast.DictComp, ast.GeneratorExp)
def _comprehension(m: Machine, node: Any, scope: Scope) -> Any:
    first = m.eval(node.generators[0].iter, scope)
    inner = Scope({}, scope)
    if isinstance(first, Part) and not m.inputs.length(first.path) and isinstance(node, ast.ListComp):
        target = node.generators[0].target
        if isinstance(target, ast.Name) and len(node.generators) == 1 and not node.generators[0].ifs:
            return map_part(m, first, lambda each: m.eval(node.elt, Scope({target.id: each}, scope)))
    items = items_of(m, first)
    if isinstance(items, Unread):
        return items
    turns = _turns(m, node, inner, items)
    if isinstance(node, ast.DictComp):
        return m.keep_value({key_of(m, m.eval(node.key, inner)): m.eval(node.value, inner) for _ in turns})
    each = (m.eval(node.elt, inner) for _ in turns)
    if isinstance(node, ast.GeneratorExp):
        return each
    return m.keep_value(list(each) if isinstance(node, ast.ListComp) else {key_of(m, one) for one in each})


def _turns(m: Machine, node: Any, scope: Scope, items: Any, depth: int = 0) -> Iterator[None]:
    """One turn for each element, with the names set."""
    generator = node.generators[depth]
    for each in items:
        m.count()
        assign(m, generator.target, each, scope)
        if all(eval_condition(m, test, scope) for test in generator.ifs):
            if depth + 1 < len(node.generators):
                inner = items_of(m, m.eval(node.generators[depth + 1].iter, scope))
                yield from _turns(m, node, scope, inner, depth + 1)
            else:
                yield


# --- assignments to them


def assign(m: Machine, target: ast.expr, value: Any, scope: Scope) -> None:
    """Gives a value to a name, an attribute, an element, or names for its parts."""
    if isinstance(target, ast.Name):
        scope.names[target.id] = value
    elif isinstance(target, ast.Tuple | ast.List):
        _unpack_value(m, target, value, scope)
    elif isinstance(target, ast.Attribute):
        owner = m.eval(target.value, scope)
        if not isinstance(owner, Instance | Class):
            raise m.make_error(
                target, f"{text_of(target)} is set, which is no attribute of the file's", "remove the line"
            )
        if m.paths is None:
            (owner.attributes if isinstance(owner, Instance) else owner.members)[target.attr] = value
        else:
            m.written[id(owner), target.attr] = value
    elif isinstance(target, ast.Subscript):
        owner, key = m.require_value(m.eval(target.value, scope)), m.whole(m.eval(target.slice, scope))
        if isinstance(owner, Part) or not isinstance(owner, list | dict) or isinstance(key, slice):
            raise m.make_error(target, f"{text_of(target)} is set", "give it another name instead")
        try:
            m.ensure_fresh(owner, target)[key] = value
        except (LookupError, TypeError):
            raise m.make_error(target, f"{text_of(target)} does not exist", "mend it") from None


def _unpack_value(m: Machine, target: ast.Tuple | ast.List, value: Any, scope: Scope) -> None:
    names = target.elts
    stars = [place for place, each in enumerate(names) if isinstance(each, ast.Starred)]
    if isinstance(value, Part):
        ensure_length(m, target, value, names, stars)
        if stars and not m.inputs.length(value.path) and stars[0] == len(names) - 1:
            for place, each in enumerate(names[:-1]):
                assign(m, each, m.inputs.enter(value, place, m.line), scope)
            assign(m, names[-1].value, replace(value, offset=value.offset + stars[0]), scope)  # type: ignore[attr-defined]
            return
    items = items_of(m, value) if not isinstance(value, Unread) else value
    if isinstance(items, Unread):
        for each in ast.walk(target):
            if isinstance(each, ast.Name):
                scope.names[each.id] = items
        return
    items = list(items)
    if stars:
        after = len(names) - stars[0] - 1
        items[stars[0] : len(items) - after] = [m.keep_value(items[stars[0] : len(items) - after])]
    if len(items) != len(names):
        raise m.make_error(target, f"{len(items)} values are given to {len(names)} names", "give each a name")
    for each, item in zip(names, items, strict=True):
        assign(m, each.value if isinstance(each, ast.Starred) else each, item, scope)


def ensure_length(m: Machine, target: ast.AST, part: Part, names: list[ast.expr], stars: list[int]) -> None:
    """Takes the number of names for that of features, and the names for theirs."""
    if stars or part.offset:
        return
    named = [each.id if isinstance(each, ast.Name) else "" for each in names]
    count_features(m, target, part, named)
