"""Structured Text of IEC 61131-3: a function block for each agent.

Does: emits PREFIX_AGENT.st, with names that a controller's languages do not keep, which ignore case.
Assumes: REAL is IEEE binary32. Literals have enough digits for LREAL, in which some controllers compare.
Does not: add, of which standard and controllers leave the rounding open, or remember.
"""

from codegen import ir
from codegen.errors import InputError
from codegen.lowering.model import Agent, Model, Node
from codegen.lowering.render import render
from codegen.numbers import decimal_literal


def emit(model: Model, profile: ir.PolicyProfile) -> dict[str, str]:
    """A file for each agent; one that several agents need. InputError for names that cannot be told apart there."""
    return {f"{model.prefix}_{agent.lower}.st": _write_block(model, agent) for agent in model.agents}


def _write_block(model: Model, agent: Agent) -> str:
    inputs = [_join_name("x", each.upper) for each in agent.features]
    flags = [_join_name("act", each.upper) for each in agent.actions]
    names = [*inputs, *flags]
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"{agent.name} has two names that are {name} in Structured Text", "--target", "rename one")
    ranges = [
        (name, literal(each.low_seen), literal(each.high_seen))
        for name, each in zip(inputs, agent.features, strict=True)
    ]
    tests = {node.id: _write_test(node) for node in agent.nodes if node.split}
    name = _join_name(model.prefix, agent.lower)
    block = {"name": name, "inputs": inputs, "flags": flags, "tests": tests, "ranges": ranges}
    return render("st/block.st.j2", model=model, agent=agent, **block)


def _join_name(*parts: str) -> str:
    """An identifier of the parts: no two underscores stand side by side, or one at the end."""
    return "_".join(word for part in parts for word in part.lower().split("_") if word)


def _write_test(node: Node) -> str:
    if node.below_zero:
        return "< 0.0"
    return f"<= {literal(decimal_literal(float.fromhex(node.literal.rstrip('f'))))}"


def literal(decimal: str) -> str:
    """A number as REAL literals are: with a point, and digits on both sides of it."""
    digits, exponent, power = decimal.partition("e")
    return f"{digits if '.' in digits else digits + '.0'}{exponent.upper()}{power}"
