"""Claims about a system, from the `[[property]]` tables of a world file or of a file of their own.

Does: reads names, regions, steps and formulas.
Assumes: the names of a statement, and the profile whose actions formulas speak of.
Does not: decide. Formulas are parsed, never evaluated.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from codegen.errors import InputError
from codegen.ir import NO_CHILD, NO_FEATURE, ActionSpec, AgentPolicy, PolicyProfile, Tree
from verify.claims.files import Table, properties, read_each
from verify.claims.formula import Formula, coordinates, negate
from verify.claims.language.formulas import Vocabulary
from verify.claims.region_files import is_list, is_table
from verify.decimals import plain
from verify.language.units import Typed
from verify.systems.claims import MAX_STEPS, SAYS, CurvedClaim, Denied, Pattern, SystemClaim
from verify.systems.curves.following import name_next_values, without_next
from verify.systems.curves.formulas import Curves, without_curves
from verify.systems.files import region_of, region_parts
from verify.systems.given import robust
from verify.systems.given.formulas import (
    ensure_choosing,
    find_numbers,
    name_inputs,
    of_actions,
    read_observed,
    spell_inputs,
)
from verify.systems.language.expressions import Number, names
from verify.systems.language.parsing import Names
from verify.systems.pieces import list_curved
from verify.systems.regions import box_of, is_empty
from verify.systems.statement import Statement
from verify.systems.system import Polytope
from verify.systems.values import ADVICE, as_list, as_table, count, flat, only, text
from verify.systems.values import table as table_of
from verify.toml_places import Place, parse

PATTERNS = {pattern.value: pattern for pattern in Pattern}
PLAYED = 200  # steps in which counterexamples of `always` are looked for
KEYS = (
    "name",
    "label",
    "region",
    "steps",
    "by",
    "formula",
    "at_samples",
    "cuts",
    "assuming",
    "invariant",
    *robust.KEYS,
)
FOR_EVER = ("assuming", "invariant")  # parameters of claims for ever
MAX_CUTS = 1_000  # of a range


def ensure_claims(statement: Statement, where: str) -> int:
    """Counts the claims of a world file. InputError with the place of the first fault."""
    place = replace(statement.place, name=where)
    return len(_claims(statement.properties, place, statement, _build_agents(statement))) if statement.properties else 0


def _build_agents(statement: Statement) -> dict[str, AgentPolicy]:
    """The agents of a file, with all of their actions and a tree that nobody asks."""
    leaf = Tree(*(np.array([number]) for number in (NO_FEATURE, 0, NO_CHILD, NO_CHILD, 0)))
    return {
        agent.name: AgentPolicy(
            agent.name, agent.team, (), tuple(ActionSpec(name, None) for name in agent.actions), leaf
        )
        for agent in statement.agents
    }


def claims_of(statement: Statement, profile: PolicyProfile, where: str) -> tuple[SystemClaim, ...]:
    """The claims of a world file. InputError with the places of all that is wrong."""
    acting = {policy.agent: policy for policy in profile.agents}
    return _claims(statement.properties, replace(statement.place, name=where), statement, acting)


def claims_in(source: str, statement: Statement, profile: PolicyProfile, where: str) -> tuple[SystemClaim, ...]:
    """The claims of a property file, likewise."""
    document, place = parse(source, where, "not a readable property file", ADVICE)
    only(document, ("property",), place)
    return _claims(document, place, statement, {policy.agent: policy for policy in profile.agents})


def _claims(
    document: Table, file: Place, statement: Statement, acting: Mapping[str, AgentPolicy]
) -> tuple[SystemClaim, ...]:
    return tuple(read_each(properties(document, file), lambda table, place: _claim(table, statement, acting, place)))


def _claim(
    table: Mapping[str, object], statement: Statement, acting: Mapping[str, AgentPolicy], where: Place
) -> SystemClaim:
    only(table, KEYS, where)
    label = text(table.get("label", ""), where / "label")
    place = where / "region"
    stated, regions = _regions(table, "region", statement, where)
    words = " or ".join(_words(each, place) for each in stated)
    name = text(table.get("name", Pattern.DECIDES.value), where / "name")
    only({name: None}, (*PATTERNS, robust.NAME), where, "property")
    if name == robust.NAME:
        return _robust(
            table, SystemClaim(Pattern.DECIDES, regions, label=label, region=words), statement, acting, where
        )
    pattern = PATTERNS[name]
    strange = ("formula", "cuts") if pattern is not Pattern.DECIDES else ("steps", "by", "at_samples", *FOR_EVER)
    for key in (*strange, *robust.KEYS):
        if key in table:
            raise InputError(f"{name} has no {key}", where / key, "remove it")
    if pattern is Pattern.DECIDES:
        words = " or ".join(_words(each, place, _beyond(each, statement, where)) for each in stated)
        region = f"with {words}" if words else ""
        return _decides(table, SystemClaim(pattern, regions, label=label, region=region), statement, acting, where)
    if not regions:
        raise InputError(f"{name} needs a region", where, "write region = { box = { x = [0, 1] } }")
    if not statement.moves:
        what = f"{name} is about episodes, and the file does not say how the state moves"
        raise InputError(what, where, "add [dynamics.next], or write a formula")
    steps, by = _steps(table, pattern, statement, where)
    claim = SystemClaim(
        pattern, regions, steps, by, at_samples=_times(table, statement, where), label=label, region=words
    )
    return _for_ever(claim, table, statement, where)


def _robust(
    table: Mapping[str, object],
    begun: SystemClaim,
    statement: Statement,
    acting: Mapping[str, AgentPolicy],
    where: Place,
) -> SystemClaim:
    """A claim that an output changes little where observations are a little off, as a formula about two agents."""
    only(table, ("name", "label", "region", *robust.KEYS), where)
    found = robust.robust_of(table, statement, where)
    regions = tuple((*each, *found.errors) for each in begun.regions) or (found.errors,)
    words = f"with {begun.region and f'{begun.region} and '}{found.words}"
    label = begun.label or f"robust: {found.formula}"
    return _decides(
        {"formula": found.formula}, replace(begun, regions=regions, region=words, label=label), statement, acting, where
    )


def parse_written(claim: SystemClaim, statement: Statement, profile: PolicyProfile) -> Formula | None:
    """The formula of a claim about decisions as it was written, over variables, outputs and actions; None where it has
    curves or next values.
    """
    curves = Curves(Names(statement.names.known, statement.names.meant, statement.names.modes))
    vocabulary, following = _vocabulary(statement, {policy.agent: policy for policy in profile.agents}, curves)
    found = read_observed(name_inputs(claim.written), vocabulary, lambda offset: f"column {offset + 1}").formula
    return None if curves.found or coordinates(found) & following.keys() else found


def _vocabulary(
    statement: Statement, acting: Mapping[str, AgentPolicy], curves: Curves
) -> tuple[Vocabulary, dict[str, str]]:
    """Returns the names that formulas may use, and whose next value each name of one is."""
    constants = {
        name: Typed(number.value.value, number.unit)
        for name, number in statement.names.meant.items()
        if isinstance(number.value, Number)
    }
    known = statement.names.known  # without the roundings of agents, which nobody names
    stated = [each for each in statement.system.variables if each.name in known]
    following = name_next_values(stated) if statement.rules else {}
    units = {**known, **statement.inputs, **{name: known[whose] for name, whose in following.items()}}
    modes = statement.names.modes
    giving = {each.name for each in statement.agents if each.outputs}  # what they do is `out(A)`, and no action
    choosing = {name: policy for name, policy in acting.items() if name not in giving}
    vocabulary = Vocabulary(
        tuple(units),
        choosing,
        units=units,
        constants=constants,
        modes=modes,
        curves=curves,
        observed=find_numbers(statement, acting.values()) if statement.observed else {},
    )
    return vocabulary, following


def _decides(
    table: Mapping[str, object],
    begun: SystemClaim,
    statement: Statement,
    acting: Mapping[str, AgentPolicy],
    where: Place,
) -> SystemClaim:
    """A claim about decisions with its formula; one with next values or curves becomes one without, which implies
    it.
    """
    written = _read_formula(table, where)
    curves = Curves(Names(statement.names.known, statement.names.meant, statement.names.modes))
    vocabulary, following = _vocabulary(statement, acting, curves)
    ensure_choosing(written, statement, where / "formula")
    named = name_inputs(written)
    try:
        stated = read_observed(named, vocabulary, lambda offset: (where / "formula").of_offset(written, offset))
    except InputError as error:  # the text as the user wrote it, above the same mark
        error.where = error.where.replace(named, written)
        raise
    bent = frozenset[str]().union(*map(names, curves.found.values()))
    cuts: dict[str, int] = {}
    for name, value in flat(table_of(table, "cuts", where), where / "cuts").items():
        only({name: None}, sorted(bent), where / "cuts", "variable of a product or function")
        cuts[name] = count(value, where / "cuts" / name, MAX_CUTS)

    by = _Lowering(statement, acting, following, curves, cuts)

    def decides(formula: Formula, words: str) -> SystemClaim:
        claim = of_actions(formula, statement, acting, where / "formula")
        return _lower_formula(replace(begun, written=words), claim, by, where / "formula")

    conditions = [
        Denied(spell_inputs(each.words, statement), decides(negate(each.formula), f"not ({each.words})"))
        for each in stated.conditions
    ]
    rounded = tuple(stated.rounded.items())
    return replace(decides(stated.formula, written), conditions=tuple(conditions), rounded=rounded)


class _Lowering(NamedTuple):
    """The data by which next values and curves are taken out of a formula."""

    statement: Statement
    acting: Mapping[str, AgentPolicy]
    following: Mapping[str, str]  # whose next value each name of one is
    curves: Curves
    cuts: Mapping[str, int]


def _lower_formula(begun: SystemClaim, claim: Formula, by: _Lowering, where: Place) -> SystemClaim:
    """The claim of a formula over variables, next values and curves."""
    statement, stronger, weaker = by.statement, claim, claim
    if any(name in by.following for name in coordinates(claim)):
        exact = not any(map(list_curved, statement.rules))
        stronger, weaker = without_next(claim, statement.system.pieces, by.following, by.acting, exact, where)
    enclosures = ()
    if by.curves.found:
        bending = by.curves.found, statement.system.variables, by.cuts, where
        stronger, _, enclosures = without_curves(stronger, *bending)
        _, weaker, _ = without_curves(weaker, *bending)
    if stronger == weaker and not enclosures:  # else the checker shows what made them equal
        return replace(begun, formula=stronger)
    return replace(begun, formula=stronger, curved=CurvedClaim(replace(begun, formula=weaker), enclosures))


def _regions(
    table: Mapping[str, object], key: str, statement: Statement, where: Place
) -> tuple[Sequence[object], tuple[Polytope, ...]]:
    """One region or a list of them, as they are written and as data; none where the key is not there."""
    given, place = table.get(key, []), where / key
    stated = [given] if is_table(given) else as_list(given, place)
    places = [place / index for index in range(len(stated))] if is_list(given) else [place]
    return stated, tuple(region_of(each, statement.names, at) for each, at in zip(stated, places, strict=True))


def _for_ever(claim: SystemClaim, table: Mapping[str, object], statement: Statement, where: Place) -> SystemClaim:
    """The claim with what claims for ever alone have."""
    if not claim.says.ever:
        for key in FOR_EVER:
            if key in table:
                raise InputError(f"{claim.name} has no {key}", where / key, "remove it, or ask for always")
        return claim
    stated, assuming = _regions(table, "assuming", statement, where)
    assumed = " or ".join(_words(each, where / "assuming") for each in stated)
    invariant = _regions(table, "invariant", statement, where)[1]
    for place, region in enumerate(invariant):
        if is_empty(region):
            raise InputError("no state lies in this region", where / "invariant" / place, "remove it, or widen it")
    roundings = box_of({each.variable: each.range for one in statement.acting.values() for each in one.roundings})
    held = tuple((*region, *roundings) for region in invariant)  # an invariant bounds all that moves what it names
    return replace(claim, assuming=assuming, assumed=assumed, invariant=held)


def _steps(table: Mapping[str, object], pattern: Pattern, statement: Statement, where: Place) -> tuple[int, int]:
    """The steps of a claim about episodes, of one for ever those in which counterexamples are looked for; and `by`."""
    usual, says = statement.system.steps, SAYS[pattern]
    if pattern is Pattern.REACHES_AND_STAYS and "by" not in table:
        raise InputError(f"{pattern.value} needs the step by which the region is reached", where, "write by = 20")
    if says.first != "by" and "by" in table:
        what, advice = f"{pattern.value} has no by", "remove it, or ask for reaches_and_stays or always"
        raise InputError(what, where / "by", advice)
    if pattern is Pattern.ALWAYS:
        if statement.system.flow is not None:
            what = "always is about steps, and the system moves in continuous time"
            raise InputError(what, where, "ask for stays_in with a number of steps")
        later = count(table["by"], where / "by", MAX_STEPS) if "by" in table else 0
        usual = min(MAX_STEPS, later + max(usual, PLAYED))
    steps = count(table.get("steps", usual), where / "steps", MAX_STEPS)
    return steps, count(table["by"], where / "by", steps) if "by" in table else 0


def _times(table: Mapping[str, object], statement: Statement, where: Place) -> bool | None:
    """Returns True if a claim is about samples only; None where the system moves in steps."""
    given = table.get("at_samples", False)
    if statement.system.flow is None:
        if "at_samples" in table:
            raise InputError("the system moves in steps, so it has no samples", where / "at_samples", "remove it")
        return None
    if not isinstance(given, bool):
        raise InputError("not true or false", where / "at_samples", "write at_samples = true, or leave it out")
    return given


def _read_formula(table: Mapping[str, object], where: Place) -> str:
    """Reads the formula that is claimed of variables and actions."""
    if "formula" not in table:
        raise InputError("a property needs a name or a formula", where, f"names: {', '.join((*PATTERNS, robust.NAME))}")
    return text(table["formula"], where / "formula")


def _words(region: object, place: Place, beyond: Mapping[str, str] | None = None) -> str:
    """A region that was read, in words. `beyond`: what is said of variables whose bounds leave their range."""
    document = as_table(region, place)
    bounds = flat(table_of(document, "box", place), place).items()
    said = [
        (f"{name} in [{', '.join(map(str, ends))}]" if is_list(ends) else f"{name} = {ends}")
        + (beyond or {}).get(name, "")
        for name, ends in bounds
    ]
    return " and ".join([*said, *map(str, as_list(document.get("where", []), place))]) or "any state"


def _beyond(region: object, statement: Statement, where: Place) -> dict[str, str]:
    """Returns words for bounds that leave a range, since a claim about decisions is about states of the ranges."""
    bounds, _ = region_parts(as_table(region, where), statement.names, where)
    words: dict[str, str] = {}
    for one in statement.system.variables:
        low, high = bounds.get(one.name, one.range)
        least, most = max(low, one.range[0]), min(high, one.range[1])
        if least > most:
            words[one.name] = " (no state of the ranges)"
        elif (least, most) != (low, high):
            words[one.name] = f" (of the ranges [{plain(least)}, {plain(most)}])"
    return words
