"""World's files: variables, features, start and motion of a user's own system, in TOML.

Does: reads one; checks names, units, shapes and numbers.
Assumes: nothing about the text, which may come from anywhere.
Does not: run anything that a file holds: expressions are parsed, never evaluated.
"""

from collections.abc import Mapping
from fractions import Fraction

from codegen.check import identifier
from codegen.errors import InputError, UnknownNameError
from codegen.ir import GOAL
from verify.claims.region import Interval
from verify.language.arithmetic import Typed
from verify.language.units import PURE, Unit, unit_of, written
from verify.systems.actors import agents_of, features_of
from verify.systems.flows.reading import flow_of
from verify.systems.language.expressions import Expression, Number
from verify.systems.language.parsing import Names, half_spaces
from verify.systems.motion import rules_of
from verify.systems.pieces import pieces
from verify.systems.regions import box_of, is_empty
from verify.systems.statement import Rule, Statement
from verify.systems.system import Box, Flow, HalfSpace, Polytope, System, Variable
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
from verify.toml_places import Place, parse

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


def statement_of(source: str, name: str) -> Statement:
    """What a world file states. `name`: of the file, for errors. InputError with the place of the first fault."""
    document, where = parse(source, name, "not a readable file", ADVICE)
    only(document, KEYS, where)
    constants = _constants(document, where)
    variables, units = _variables(table(document, "variables", where), constants, where)
    names = Names(units, constants.meant)
    described = table(document, "agents", where)
    agents, inputs = agents_of(described, names, where / "agents")
    features = features_of(described, names, where / "agents")
    rules: tuple[Rule, ...] = ()
    flow: Flow | None = None
    steps = 0
    if "dynamics" in document:
        steps = count(document.get("steps"), where / "steps", MAX_STEPS)
        moved = as_table(document["dynamics"], where / "dynamics")
        unset = {name for each in agents for name in each.inputs - inputs.keys()}
        still = dict.fromkeys(unset, Typed[Expression](Number(Fraction(0)), None))
        known = Names(units | inputs, {**constants.meant, **still})
        if "flow" in moved:
            if "reference" in document:
                what = "a flow is not compared with an environment"
                raise InputError(what, where / "reference", "remove the reference; worlds check integrates the flow")
            flow = flow_of(moved, variables, agents, known, where / "dynamics")
        else:
            rules = rules_of(moved, variables, agents, known, where / "dynamics")
    start = _start(table(document, "start", where), variables, names, where / "start")
    called, reference, state = (text(document.get(key, ""), where / key) for key in ("name", "reference", "state"))
    made = pieces(rules, variables, where / "dynamics")
    system = System(called or "system", variables, features, start, made, steps, reference, flow)
    stated = {key: value for key, value in document.items() if key == "property"}
    return Statement(system, agents, rules, names, stated, where, state)


def _constants(document: Mapping[str, object], where: Place) -> Names:
    """`dt` and the constants, by name."""
    given = dict(table(document, "constants", where))
    if "dt" in document:
        if "dt" in given:
            raise InputError("'dt' is stated twice", where / "constants" / "dt", "remove one of the two")
        given = {"dt": document["dt"], **given}
    found: dict[str, Typed[Expression]] = {}
    for key, value in given.items():
        place = where / "dt" if key == "dt" else where / "constants" / key
        exact, unit = quantity(value, place)
        found[named(key, place)] = Typed(Number(exact), unit if unit is not None else PURE)
    return Names({}, found)


def _variables(
    given: Mapping[str, object], constants: Names, where: Place
) -> tuple[tuple[Variable, ...], dict[str, Unit]]:
    stated = flat(given, where / "variables")
    if not 1 <= len(stated) <= MAX_VARIABLES:
        raise InputError(f"{len(stated)} variables, of 1 to {MAX_VARIABLES}", where / "variables", ADVICE)
    found: list[Variable] = []
    units: dict[str, Unit] = {}
    for name, described in stated.items():
        place = where / "variables" / name
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


def _start(given: Mapping[str, object], variables: tuple[Variable, ...], names: Names, where: Place) -> Polytope:
    """The start region: bounds on every variable, and further conditions."""
    bounds, conditions = region_parts(given, names, where)
    for variable in variables:
        low, high = variable.range
        place = where / "box" / variable.name
        if variable.name not in bounds:
            raise InputError(f"the start says nothing of {variable.name}", where / "box", "bound every variable")
        if bounds[variable.name][0] < low or bounds[variable.name][1] > high:
            raise InputError("the start lies outside the range", place, "widen the range of the variable")
    found = (*box_of(bounds), *conditions)
    if is_empty(found):
        raise InputError("the start region is empty", where, "no state meets all of its conditions")
    return found


def region_parts(given: Mapping[str, object], names: Names, where: Place) -> tuple[Box, Polytope]:
    """The box of a region, and the half spaces of its further conditions: `box` and `where`."""
    only(given, ("box", "where"), where)
    bounds: dict[str, Interval] = {}
    for name, value in flat(table(given, "box", where), where / "box").items():
        if name not in names.known:
            raise UnknownNameError("variable", name, names.known, where / "box")
        bounds[name] = interval(value, names.known[name], names, where / "box" / name)
    conditions: list[HalfSpace] = []
    for index, value in enumerate(as_list(given.get("where", []), where / "where")):
        place = where / "where" / index
        conditions += half_spaces(text(value, place), names, place)
    return bounds, tuple(conditions)


def region_of(given: object, names: Names, where: Place) -> Polytope:
    """A region as half spaces."""
    bounds, conditions = region_parts(as_table(given, where), names, where)
    return (*box_of(bounds), *conditions)
