"""Lists, and the functions of Python that make, take apart and count them.

Does: the parts of a value; len, range, zip, sorted and so on; an observation of unknown length, number by number.
Assumes: what is counted and looked up is constant.
Does not: compare features.
"""

# pyright: basic
# the values of a program may be anything
import ast
from collections.abc import Callable
from dataclasses import replace
from typing import Any, cast

from codegen.importers.python.arithmetic import binary
from codegen.importers.python.machine import MAX_ITEMS, UNCOUNTED, Machine
from codegen.importers.python.values import Class, Length, Member, Part, Unread
from codegen.importers.symbolic.feature import Feature

Given = list[Any]
Named = dict[str, Any]
Call = Callable[[Machine, ast.AST, Given, Named], Any]


def items_of(m: Machine, value: Any) -> Any:
    """The parts of a list, a text, a dictionary, an Enum or an observation of known length."""
    value = m.require_value(value)
    if isinstance(value, Part):
        n = m.inputs.length(value.path)
        if not n:
            return m.unread(*UNCOUNTED)
        return [m.inputs.enter(value, k, m.line) for k in range(n - value.offset)]
    if isinstance(value, Class) and value.enum:
        return [each for each in value.members.values() if isinstance(each, Member)]
    if isinstance(value, set | frozenset) and len(cast("set[Any]", value)) > 1:
        return m.unread("a loop goes over a set, whose order nobody knows", "write a list")
    if isinstance(value, dict | set | frozenset):
        return list(cast("set[Any]", value))
    if isinstance(value, list | tuple | str | range) or hasattr(value, "__next__"):
        return value
    raise m.make_error(None, "a loop goes over something that is no list", "loop over literals")


def count_features(m: Machine, node: ast.AST, part: Part, named: list[str]) -> None:
    """Takes the number of names for that of features, and the names for theirs if there is one for each."""
    known = m.inputs.length(part.path)
    if known and known != len(named):
        raise m.make_error(node, f"{len(named)} names for {known} features", "give each feature a name: a, b = x")
    m.inputs.widths[part.path] = len(named)
    if all(named):
        feature_names = tuple(f"x{place}" if name == "_" else name for place, name in enumerate(named))
        if len(set(feature_names)) == len(feature_names):
            m.inputs.names.setdefault(part.path, feature_names)


def make_list_call(make: Callable[..., Any], unordered: bool = False) -> Call:
    """list, tuple, enumerate, zip and so on: lists of lists, or iterators over them, as Python makes them. `unordered`:
    what is made has no order either, so that sets may come in.
    """
    kept = int | set | frozenset if unordered else int

    def handle_call(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
        items = [each if isinstance(each, kept) else items_of(m, each) for each in given]
        unread = next((each for each in items if isinstance(each, Unread)), None)
        try:
            sequence = unread or make(*items, **named)
        except (TypeError, ValueError):
            raise m.make_error(node, "a list is made of what it cannot be made of", "write the list itself") from None
        m.streams |= hasattr(sequence, "__next__")
        return m.keep_value(sequence) if isinstance(sequence, list | dict | set | tuple) else sequence

    return handle_call


def map_of(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
    """`map`: of lists, and of an observation of unknown length."""
    if isinstance(given[1], Part) and not m.inputs.length(given[1].path):
        return map_part(m, given[1], lambda each: m.call(given[0], [each], {}, node))
    items = [items_of(m, each) for each in given[1:]]
    unread = next((each for each in items if isinstance(each, Unread)), None)
    m.streams = True
    return unread or (m.call(given[0], list(each), {}, node) for each in zip(*items, strict=False))


def map_part(m: Machine, part: Part, function: Callable[[Any], Any]) -> Any:
    """The observation with each of its numbers, however many there are, replaced by what one step makes of it."""
    feature = function(Feature(-1, part.steps))
    if isinstance(feature, Feature) and feature.place == -1:
        return replace(part, steps=feature.steps, array=False)
    return m.unread(*UNCOUNTED)


def filter_items(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
    """`filter`."""
    items = items_of(m, given[1])
    if isinstance(items, Unread):
        return items
    m.streams = True
    return (each for each in items if m.truth(m.call(given[0], [each], {}, node)))


def length(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
    """`len`: of an observation, what the file says of it."""
    if isinstance(given[0], Part):
        return m.inputs.length(given[0].path) - given[0].offset if m.inputs.length(given[0].path) else Length(given[0])
    items = items_of(m, given[0])
    return items if isinstance(items, Unread) else len(items)


def sum_of(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
    """`sum`: one after the other, as Python adds."""
    items, total = items_of(m, given[0]), given[1] if len(given) > 1 else 0
    for each in [items] if isinstance(items, Unread) else items:
        total = binary(m, ast.Add, total, each)
    return total


def next_of(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
    """`next`, of a generator."""
    items = iter(items_of(m, given[0]))
    if len(given) > 1:
        return next(items, given[1])
    return next(items, m.unread("next() finds nothing", "give a default"))


def sort_items(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
    """`sorted`, by constant keys."""
    items = items_of(m, given[0])
    if isinstance(items, Unread):
        return items
    items = list(items)
    keys = [m.whole(m.call(named["key"], [each], {}, node) if "key" in named else each) for each in items]
    order = sorted(range(len(items)), key=keys.__getitem__, reverse=bool(named.get("reverse")))
    return m.keep_value([items[place] for place in order])


def range_of(m: Machine, node: ast.AST, given: Given, named: Named) -> Any:
    """`range`, of constants."""
    numbers = [m.whole(each) for each in given]
    if not all(isinstance(each, int) for each in numbers) or len(range(*numbers)) > MAX_ITEMS:
        return m.unread("a range is no range of constants, or too long", "write range(n)")
    return range(*numbers)
