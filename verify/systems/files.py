"""World's files: variables, features, start and motion of a user's own system, in TOML.

Does: reads one; checks names, units, shapes and numbers.
Assumes: nothing about the text, which may come from anywhere.
Does not: run anything that a file holds: expressions are parsed, never evaluated.
"""

import tomllib
from collections.abc import Mapping
from fractions import Fraction

from codegen.check import identifier
from codegen.errors import InputError, UnknownNameError
from codegen.ir import GOAL
from verify.claims.region import Interval
from verify.systems.actors import agents_of, features_of
from verify.systems.language.expressions import Number
from verify.systems.language.parsing import Names, Typed, half_spaces
from verify.systems.language.units import PURE, Unit, unit_of, written
from verify.systems.motion import rules_of
from verify.systems.pieces import pieces
from verify.systems.regions import box_of, is_empty
from verify.systems.statement import Rule, Statement
from verify.systems.system import Box, HalfSpace, Polytope, System, Variable
from verify.systems.values import (
    ADVICE,
    as_list,
    as_table,
    count,
    flat,
    interval,
    named,
    only,
    quantity,
    table,
    text,
)

KEYS = (
    "name",
    "steps",
    "dt",
    "reference",
    "state",
    "constants",
    "variables",
    "agents",
    "start",
    "dynamics",
    "property",
)
MAX_BYTES = 2**20
MAX_STEPS = 10_000
MAX_VARIABLES = 64


def parsed(source: str, where: str) -> dict[str, object]:
    """The document of a TOML text, with decimals as texts. InputError for what is none."""
    try:
        return tomllib.loads(source, parse_float=str)
    except (tomllib.TOMLDecodeError, ValueError, RecursionError) as error:
        raise InputError("not a readable file", f"{where}: {error}", ADVICE) from None


def statement_of(source: str, where: str) -> Statement:
    """What a world's file states. `where`: its name, for errors. InputError with the place of the first fault."""
    document = parsed(source, where)
    only(document, KEYS, where)
    constants = _constants(document, where)
    variables, units = _variables(table(document, "variables", where), constants, where)
    names = Names(units, constants.meant)
    described = table(document, "agents", where)
    agents, inputs = agents_of(described, names, f"{where}: agents")
    features = features_of(described, names, f"{where}: agents")
    rules: tuple[Rule, ...] = ()
    steps = 0
    if "dynamics" in document:
        steps = count(document.get("steps"), f"{where}: steps", MAX_STEPS)
        moved = as_table(document["dynamics"], f"{where}: dynamics")
        still = {name: Typed(Number(Fraction(0)), None) for each in agents for name in each.inputs - inputs.keys()}
        known = Names(units | inputs, {**constants.meant, **still})
        rules = rules_of(moved, variables, agents, known, f"{where}: dynamics")
    start = _start(table(document, "start", where), variables, names, f"{where}: start")
    name, reference, state = (text(document.get(key, ""), f"{where}: {key}") for key in ("name", "reference", "state"))
    made = pieces(rules, variables, f"{where}: dynamics")
    system = System(name or "system", variables, features, start, made, steps, reference)
    properties = as_list(document.get("property", []), f"{where}: property")
    return Statement(system, agents, rules, names, tuple(properties), state)


def system_of(source: str, where: str) -> System:
    """The system that a world's file states, as `statement_of`."""
    return statement_of(source, where).system


def _constants(document: Mapping[str, object], where: str) -> Names:
    """`dt` and the constants, by name."""
    given = dict(table(document, "constants", where))
    if "dt" in document:
        given = {"dt": document["dt"], **given}
    found: dict[str, Typed] = {}
    for key, value in given.items():
        place = f"{where}: {'dt' if key == 'dt' else f'constants.{key}'}"
        exact, unit = quantity(value, place)
        found[named(key, place)] = Typed(Number(exact), unit if unit is not None else PURE)
    return Names({}, found)


def _variables(
    given: Mapping[str, object], constants: Names, where: str
) -> tuple[tuple[Variable, ...], dict[str, Unit]]:
    if not 1 <= len(flat(given)) <= MAX_VARIABLES:
        raise InputError(f"{len(flat(given))} variables, of 1 to {MAX_VARIABLES}", f"{where}: variables", ADVICE)
    found: list[Variable] = []
    units: dict[str, Unit] = {}
    for name, described in flat(given).items():
        place = f"{where}: variables.{name}"
        value = as_table(described, place)
        only(value, ("unit", "range"), place)
        if name in constants.meant:
            raise InputError(f"'{name}' is a constant too", place, "give each a name of its own")
        if identifier(name.split(".")[0]) == GOAL:
            raise InputError("'goal' is the place of a game's goal", place, "give the variable another name")
        if identifier(name) in map(identifier, units):
            raise InputError(f"another variable is '{name}' but for its case", place, "give each a name of its own")
        if "range" not in value:
            raise InputError("a variable needs a range", place, "write range = [-1, 1]")
        units[named(name, place, dotted=True)] = unit = unit_of(text(value.get("unit", ""), place), place)
        found.append(Variable(name, written(unit), interval(value["range"], unit, constants, place)))
    return tuple(found), units


def _start(given: Mapping[str, object], variables: tuple[Variable, ...], names: Names, where: str) -> Polytope:
    """The start region: bounds on every variable, and further conditions."""
    bounds, conditions = region_parts(given, names, where)
    for variable in variables:
        low, high = variable.range
        place = f"{where}: box.{variable.name}"
        if variable.name not in bounds:
            raise InputError(f"the start says nothing of {variable.name}", f"{where}: box", "bound every variable")
        if bounds[variable.name][0] < low or bounds[variable.name][1] > high:
            raise InputError("the start lies outside the range", place, "widen the range of the variable")
    found = (*box_of(bounds), *conditions)
    if is_empty(found):
        raise InputError("the start region is empty", where, "no state meets all of its conditions")
    return found


def region_parts(given: Mapping[str, object], names: Names, where: str) -> tuple[Box, Polytope]:
    """The box of a region, and the half spaces of its further conditions: `box` and `where`."""
    only(given, ("box", "where"), where)
    bounds: dict[str, Interval] = {}
    for name, value in flat(table(given, "box", where)).items():
        if name not in names.known:
            raise UnknownNameError("variable", name, names.known, f"{where}: box")
        bounds[name] = interval(value, names.known[name], names, f"{where}: box.{name}")
    conditions: list[HalfSpace] = []
    for index, value in enumerate(as_list(given.get("where", []), f"{where}: where"), 1):
        place = f"{where}: where, condition {index}"
        conditions += half_spaces(text(value, place), names, place)
    return bounds, tuple(conditions)


def region_of(given: object, names: Names, where: str) -> Polytope:
    """A region as half spaces."""
    bounds, conditions = region_parts(as_table(given, where), names, where)
    return (*box_of(bounds), *conditions)
