"""Structured Text of IEC 61131-3: a function block for each agent.

Does: emits PREFIX_AGENT.st, with names that a controller's languages do not keep, which ignore case; inputs are whole
  numbers where the agent observes such; what it remembers is a whole number of the block.
Assumes: REAL is IEEE binary32. Literals have enough digits for LREAL, in which some controllers compare.
Does not: add floats, of which standard and controllers leave the rounding open.
"""

import math
from collections.abc import Mapping, Sequence

import numpy as np

from codegen import ir
from codegen.errors import InputError
from codegen.lowering.model import Action, Agent, Change, Machine, Model, Node
from codegen.lowering.render import render
from codegen.numbers import decimal_literal

WHOLE = {"int8": "SINT", "uint8": "USINT", "int16": "INT", "uint16": "UINT", "int32": "DINT", "uint32": "UDINT"}


def emit(model: Model, profile: ir.PolicyProfile) -> dict[str, str]:
    """A file for each agent; one that several agents need. InputError for names that cannot be told apart there."""
    return {f"{model.prefix}_{agent.lower}.st": _write_block(model, agent) for agent in model.agents}


def _write_block(model: Model, agent: Agent) -> str:
    machine = agent.machine or Machine((), (), len(agent.features))
    inputs = [_join_name("x", each.upper) for each in agent.features[: machine.observed]]
    kept = {each.name: _join_name("m", agent.features[each.index].upper) for each in machine.memory}
    changes = {each.action.index: each for each in machine.changes}
    flags = [_join_name("act", each.upper) for each in agent.actions if each.index not in changes]
    for names in (inputs, flags, [*kept.values()]):
        for name in names:
            if names.count(name) > 1:
                what = f"{agent.name} has two names that are {name} in Structured Text"
                raise InputError(what, "--target", "rename one")
    within = list[str]()  # of whole numbers, an end of the range that is none of the type
    for name, each in zip(inputs, agent.features, strict=False):
        ends = (each.low, each.high) if agent.whole else (literal(each.low_seen), literal(each.high_seen))
        asked = zip((">=", "<="), ends, each.bounded, strict=True)
        within.append(" AND ".join(f"({name} {sign} {end})" for sign, end, bounded in asked if bounded))
    tested = [*inputs, *kept.values()]
    tests = {node.id: _write_test(node, tested, machine.observed, agent.whole) for node in agent.nodes if node.feature}
    done = {node.action.index: _write_leaf(node.action, changes, kept) for node in agent.nodes if node.action}
    name = _join_name(model.prefix, agent.lower)
    block = {"name": name, "inputs": inputs, "kept": kept, "flags": flags, "tests": tests, "within": within}
    kind = WHOLE.get(agent.whole, "REAL")
    return render("st/block.st.j2", model=model, agent=agent, kind=kind, memory=machine.memory, done=done, **block)


def _join_name(*parts: str) -> str:
    """An identifier of the parts: no two underscores stand side by side, or one at the end."""
    return "_".join(word for part in parts for word in part.lower().split("_") if word)


def _write_test(node: Node, names: Sequence[str], observed: int, whole: str) -> str:
    """What a split asks. A number that is remembered is whole, so that it is compared with a whole number. The least
    one of a type is no literal, but the negative of a number that the type may lack.
    """
    place = node.feature.index if node.feature else 0
    threshold = float.fromhex(node.literal.rstrip("f"))
    if place >= observed or whole:
        most = math.floor(threshold)
        least = place < observed and most == np.iinfo(whole).min
        return f"{names[place]} < {most + 1}" if least else f"{names[place]} <= {most}"
    return f"{names[place]} {'< 0.0' if node.below_zero else f'<= {literal(decimal_literal(threshold))}'}"


def _write_leaf(action: Action, changes: Mapping[int, Change], kept: Mapping[str, str]) -> list[str]:
    """The assignments of a leaf: the action that is taken, and what changes of memory."""
    if action.index not in changes:
        return [f"act := {action.index}"]
    change = changes[action.index]
    lines = [f"act := {change.taken.index}"]
    for name, sign, value in change.updates:
        added = f"{kept[name]} {'-' if value < 0 else '+'} {abs(value)}"
        lines.append(f"{kept[name]} := {value if sign == '=' else added}")
    return lines


def literal(decimal: str) -> str:
    """A number as REAL literals are: with a point, and digits on both sides of it."""
    digits, exponent, power = decimal.partition("e")
    return f"{digits if '.' in digits else digits + '.0'}{exponent.upper()}{power}"
