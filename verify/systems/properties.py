"""Claims about a system, from the `[[property]]` tables of a world's file or of a file of their own.

Does: reads names, regions, steps and formulas.
Assumes: the names of a statement, and the profile whose actions formulas speak of.
Does not: decide. Formulas are parsed, never evaluated.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction

import numpy as np

from codegen.errors import InputError
from codegen.ir import NO_CHILD, NO_FEATURE, ActionSpec, AgentPolicy, PolicyProfile, Tree
from verify.claims.language.parser import Vocabulary, parse
from verify.claims.region import is_list, is_table
from verify.systems.claims import MAX_STEPS, SystemClaim, SystemKind
from verify.systems.files import parsed, region_of
from verify.systems.statement import Statement
from verify.systems.values import as_list, as_table, count, flat, only, text
from verify.systems.values import table as table_of

KINDS = {kind.value: kind for kind in SystemKind}
KEYS = ("name", "label", "region", "steps", "by", "formula")
MAX_PROPERTIES = 200
ZERO = Fraction(0)


def ensure_claims(statement: Statement, where: str) -> int:
    """How many claims a world's file has. InputError with the place of the first fault."""
    tables = [as_table(table, f"{where}: property {index}") for index, table in enumerate(statement.properties, 1)]
    return len(_claims(tables, statement, _stated(statement), where)) if tables else 0


def _stated(statement: Statement) -> dict[str, AgentPolicy]:
    """The agents of a file, with all of their actions and a tree that nobody asks."""
    leaf = Tree(*(np.array([number]) for number in (NO_FEATURE, 0, NO_CHILD, NO_CHILD, 0)))
    return {
        agent.name: AgentPolicy(
            agent.name, agent.team, (), tuple(ActionSpec(name, None) for name in agent.actions), leaf
        )
        for agent in statement.agents
    }


def claims_of(statement: Statement, profile: PolicyProfile, where: str) -> tuple[SystemClaim, ...]:
    """The claims of a world's file. InputError with the place of the first fault."""
    tables = [as_table(table, f"{where}: property {index}") for index, table in enumerate(statement.properties, 1)]
    return _claims(tables, statement, {policy.agent: policy for policy in profile.agents}, where)


def claims_in(source: str, statement: Statement, profile: PolicyProfile, where: str) -> tuple[SystemClaim, ...]:
    """The claims of a property file. InputError with the place of the first fault."""
    document = parsed(source, where)
    only(document, ("property",), where)
    given = as_list(document.get("property", []), f"{where}: property")
    tables = [as_table(table, f"{where}: property {index}") for index, table in enumerate(given, 1)]
    return _claims(tables, statement, {policy.agent: policy for policy in profile.agents}, where)


def _claims(
    tables: Sequence[Mapping[str, object]], statement: Statement, acting: Mapping[str, AgentPolicy], where: str
) -> tuple[SystemClaim, ...]:
    if not 1 <= len(tables) <= MAX_PROPERTIES:
        advice = "begin each with a line [[property]]"
        raise InputError(f"{len(tables)} properties, of 1 to {MAX_PROPERTIES}", where, advice)
    return tuple(
        _claim(table, statement, acting, f"{where}: property {index}") for index, table in enumerate(tables, 1)
    )


def _claim(
    table: Mapping[str, object], statement: Statement, acting: Mapping[str, AgentPolicy], where: str
) -> SystemClaim:
    only(table, KEYS, where)
    label = text(table.get("label", ""), f"{where}: label")
    given = table.get("region", [])
    stated = [given] if is_table(given) else as_list(given, f"{where}: region")
    regions = tuple(
        region_of(each, statement.names, f"{where}: region {index}") for index, each in enumerate(stated, 1)
    )
    words = " or ".join(map(_words, stated))
    name = text(table.get("name", SystemKind.DECIDES.value), f"{where}: name")
    only({name: None}, KINDS, where, "property")
    kind = KINDS[name]
    for key in ("formula",) if kind is not SystemKind.DECIDES else ("steps", "by"):
        if key in table:
            raise InputError(f"{name} has no {key}", f"{where}: {key}", "remove it")
    if kind is SystemKind.DECIDES:
        written = _written(table, where)
        known = Vocabulary(tuple(statement.names.known), acting, (), (), ZERO, ZERO)
        found = parse(written, known, lambda place: f"{where}: formula, column {place + 1}")
        region = f"with {words}" if words else ""
        return SystemClaim(name, kind, regions, formula=found, label=label, region=region, written=written)
    if not regions:
        raise InputError(f"{name} needs a region", where, "write region = { box = { x = [0, 1] } }")
    if not statement.rules:
        what = f"{name} is about episodes, and the file does not say how the state moves"
        raise InputError(what, where, "add [dynamics.next], or write a formula")
    steps = count(table.get("steps", statement.system.steps), f"{where}: steps", MAX_STEPS)
    by = 0
    if kind is SystemKind.REACHES_AND_STAYS:
        if "by" not in table:
            raise InputError(f"{name} needs the step by which the region is reached", where, "write by = 20")
        by = count(table["by"], f"{where}: by", steps)
    elif "by" in table:
        raise InputError(f"{name} has no by", f"{where}: by", "remove it, or ask for reaches_and_stays")
    return SystemClaim(name, kind, regions, steps, by, label=label, region=words)


def _written(table: Mapping[str, object], where: str) -> str:
    """What is claimed of variables and actions."""
    if "formula" not in table:
        raise InputError("a property needs a name or a formula", where, f"names: {', '.join(KINDS)}")
    return text(table["formula"], f"{where}: formula")


def _words(region: object) -> str:
    """A region that was read, in words."""
    document = as_table(region, "region")
    bounds = flat(table_of(document, "box", "region")).items()
    said = [
        f"{name} in [{', '.join(map(str, ends))}]" if is_list(ends) else f"{name} = {ends}" for name, ends in bounds
    ]
    return " and ".join([*said, *map(str, as_list(document.get("where", []), "region"))])
