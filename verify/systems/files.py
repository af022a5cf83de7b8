"""World files: variables, agents, features, start and motion of a user's own system, in TOML.

Does: reads one; checks names, units, shapes and numbers; lowers what agents compute to what proofs read.
Assumes: nothing about the text, which may come from anywhere.
Does not: run anything that a file holds: expressions are parsed, never evaluated.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction

from codegen.check import identifier
from codegen.errors import InputError, UnknownNameError
from codegen.ir import GOAL, NAME
from codegen.wording import format_count
from verify.claims.files import CLAIMS, listed_in
from verify.claims.region import Interval
from verify.claims.region_files import is_list, is_table
from verify.language.units import PURE, Typed, Unit, format_unit, unit_of
from verify.systems.enclosures import pieces
from verify.systems.expressions import Call, Expression, Number, affine
from verify.systems.flows import Keeping, flow_of
from verify.systems.lowered import Acting
from verify.systems.motion import Around, StepReader
from verify.systems.parsing import Names, feature_of, half_spaces, input_of, is_mode
from verify.systems.statement import Agent, Rule, Statement, set_modes
from verify.systems.system import Box, Feature, Flow, HalfSpace, Measure, Polytope, System, Variable, box_of, is_empty
from verify.systems.values import (
    ADVICE,
    VALUES,
    as_list,
    as_name,
    as_table,
    as_typed,
    count,
    flat,
    interval,
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
    "observed",
    "constants",
    "variables",
    "agents",
    "start",
    "dynamics",
    *CLAIMS,
)
MAX_BYTES = 2**20
MAX_STEPS = 10_000
MAX_VARIABLES = 64
MAX_MODES = 256
STEP = "step"  # what texts call the number of a step
WORD = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")


def statement_of(source: str, name: str) -> Statement:
    """Reads a world file. `name`: of the file, for errors. InputError with the place of the first fault."""
    return state_world(*parse(source, name, "not a readable file", ADVICE))


def state_world(document: Mapping[str, object], where: Place) -> Statement:
    """The statement of a file's tables, whose numbers are integers, fractions or texts. `where`: the file."""
    only(document, KEYS, where)
    constants = _constants(document, where)
    variables, units = _variables(table(document, "variables", where), constants, where)
    clock = _clock(document, variables, constants)
    counted = [each.name for each in clock]
    variables, units = (*variables, *clock), units | dict.fromkeys(counted, PURE)
    modes = {each.name: each.modes for each in variables if each.modes}
    names = Names(units, constants.meant, modes)
    described = table(document, "agents", where)
    agents, inputs = agents_of(described, names, where / "agents")
    features = features_of(described, names, where / "agents")
    rules: tuple[Rule, ...] = ()
    flow: Flow | None = None
    steps, late, place = 0, Keeping(), where / "dynamics"
    if "dynamics" in document:
        steps = count(document.get("steps"), where / "steps", MAX_STEPS)
        moved = as_table(document["dynamics"], place)
        unset = {name for each in agents for name in each.inputs - inputs.keys()}
        still = dict.fromkeys(unset, Typed[Expression](Number(Fraction(0)), None))
        around = Around(variables, agents, Names(units | inputs, {**constants.meant, **still}, modes), counted)
        parts = moved.get("piece", [])  # time is continuous where derivatives are stated, of all states or in a piece
        if "flow" in moved or any(is_table(each) and "flow" in each for each in (parts if is_list(parts) else [])):
            _ensure_numbers(_giving(agents), "a flow", place / "flow")
            if "reference" in document:
                what = "a flow is not compared with an environment"
                raise InputError(what, where / "reference", "remove the reference; worlds check integrates the flow")
            flow, late = flow_of(moved, around, features, place)
        else:
            rules, agents = StepReader(around).read(moved, place)
    start = _start(table(document, "start", where), variables, names, where / "start", clock)
    called, reference, state = (text(document.get(key, ""), where / key) for key in ("name", "reference", "state"))
    if reference:
        _ensure_numbers(_giving(agents), "an environment", where / "reference")
        _ensure_numbers((*modes, *counted), "an environment", where / "reference")
    made = pieces(rules, variables, place)
    variables, start = (*variables, *late.variables), (*start, *late.start)
    system = System(called or "system", variables, features, start, made, steps, reference, flow)
    stated = {key: value for key, value in document.items() if key in CLAIMS}
    observed = document.get("observed", False)
    if not isinstance(observed, bool):
        raise InputError("not true or false", where / "observed", "leave it out where variables are no features")
    return Statement(system, agents, rules, names, stated, where, state, inputs, {}, observed)


def lower(statement: Statement, acting: Mapping[str, Acting]) -> Statement:
    """The statement as proofs read it: those of its agents that test sums or give numbers take the actions of `acting`,
    and their roundings are variables. Each is anywhere within its bounds, anew in each step; as the bounds hold within
    the ranges, nothing is stated beyond them. InputError for a flow, and for too many pieces.
    """
    system, place = statement.system, statement.place / "dynamics"
    if system.flow is not None:
        _ensure_numbers([*_giving(statement.agents), *acting], "a flow", place / "flow")
    agents = tuple(
        replace(each, actions=acting[each.name].settings) if each.outputs and each.name in acting else each
        for each in statement.agents
    )
    setters = set_modes(agents, system.variables)
    rules = tuple(each.of_actions(setters) for each in statement.rules)
    bounds = {each.variable: each.range for one in acting.values() for each in one.roundings}
    if bounds:
        anew: dict[str, Expression] = dict.fromkeys(bounds, ZERO)  # and an error, which is all of it
        bounded: list[Rule] = []
        for rule in rules:
            where = {each.name: each.range for each in system.variables}
            for name, (low, high) in where.items():
                least, most = rule.where.get(name, (low, high))
                where[name] = max(low, least), min(high, most)
            moved = {"move": {**rule.move, **anew}, "error": {**rule.error, **bounds}}
            bounded.append(replace(rule, where=where, **moved))
        rules = tuple(bounded)
    variables = (*system.variables, *(Variable(name, "1", ends) for name, ends in bounds.items()))
    features = dict(system.features)
    for agent, one in acting.items():
        features[agent] = {**features[agent], **one.features}
    start, made = (*system.start, *box_of(bounds)), pieces(rules, variables, place)
    system = replace(system, variables=variables, features=features, start=start, pieces=made)
    return replace(statement, system=system, agents=agents, rules=rules, acting=acting)


def _giving(agents: Sequence[Agent]) -> list[str]:
    return [f"{agent.name}.{output}" for agent in agents for output in agent.outputs]


def _ensure_numbers(strange: Sequence[str], what: str, where: Place) -> None:
    """InputError for variables that only rules of steps know."""
    if strange:
        told = ", ".join(strange)
        raise InputError(f"{what} knows nothing of {told}", where, "state numbers alone, or rules by [dynamics.next]")


def _constants(document: Mapping[str, object], where: Place) -> Names:
    """`dt` and the constants, by name."""
    given = dict(table(document, "constants", where))
    if "dt" in document:
        if "dt" in given:
            raise InputError("'dt' is stated twice", where / "constants" / "dt", "remove one of the two")
        given = {"dt": document["dt"], **given}
    constants: dict[str, Typed[Expression]] = {}
    for key, value in given.items():
        place = where / "dt" if key == "dt" else where / "constants" / key
        exact, unit = quantity(value, place)
        constants[as_name(key, place)] = Typed(Number(exact), unit if unit is not None else PURE)
    return Names({}, constants)


def _variables(
    given: Mapping[str, object], constants: Names, where: Place
) -> tuple[tuple[Variable, ...], dict[str, Unit]]:
    stated = flat(given, where / "variables")
    if not 1 <= len(stated) <= MAX_VARIABLES:
        raise InputError(f"{len(stated)} variables, of 1 to {MAX_VARIABLES}", where / "variables", ADVICE)
    variables: list[Variable] = []
    units: dict[str, Unit] = {}
    for name, described in stated.items():
        place = where / "variables" / name
        value = as_table(described, place)
        only(value, VALUES, place)
        if name in constants.meant:
            raise InputError(f"'{name}' is a constant too", place, "give each a name of its own")
        if identifier(name.split(".")[0]) == GOAL:
            raise InputError("'goal' is the place of a game's goal", place, "give the variable another name")
        if identifier(name) in map(identifier, units):
            raise InputError(f"another variable is '{name}' but for its case", place, "give each a name of its own")
        if "modes" in value:
            as_name(name, place, dotted=True)
            only(value, ("modes",), place)
            place /= "modes"
            modes = [as_name(text(each, place), place) for each in as_list(value["modes"], place)]
            if not 2 <= len(modes) <= MAX_MODES or len(set(modes)) < len(modes):
                raise InputError(f"not 2 to {MAX_MODES} different modes", place, 'write modes = ["off", "on"]')
            variables.append(Variable(name, "1", (Fraction(0), Fraction(len(modes) - 1)), tuple(modes)))
            units[name] = PURE
            continue
        if "range" not in value:
            raise InputError("a variable needs a range", place, "write range = [-1, 1]")
        units[as_name(name, place, dotted=True)] = unit = unit_of(text(value.get("unit", ""), place), place)
        variables.append(Variable(name, format_unit(unit), interval(value["range"], unit, constants, place)))
    return tuple(variables), units


def _clock(document: Mapping[str, object], variables: tuple[Variable, ...], constants: Names) -> tuple[Variable, ...]:
    """The number of the step as a variable, where a file speaks of it and nothing of its own is named so."""
    named = {each.name for each in variables} | constants.meant.keys()
    told = [document.get(key, {}) for key in ("agents", "dynamics", "start")]
    claims = [each for key in CLAIMS for each in listed_in(document, key)]
    told += [{**each, "label": ""} for each in claims if is_table(each)]
    if STEP in named or "dynamics" not in document or not any(_says(each, STEP) for each in told):
        return ()
    steps = document.get("steps")
    return (Variable(STEP, "1", (Fraction(0), Fraction(steps if isinstance(steps, int) else 1))),)


def _says(value: object, word: str) -> bool:
    """Returns True if a text in a document has a word, or a table in it has it as a key."""
    if is_table(value):
        return word in value or any(_says(each, word) for each in value.values())
    if is_list(value):
        return any(_says(each, word) for each in value)
    return isinstance(value, str) and word in WORD.findall(value)


def _start(
    given: Mapping[str, object],
    variables: tuple[Variable, ...],
    names: Names,
    where: Place,
    clock: tuple[Variable, ...],
) -> Polytope:
    """The start region: bounds on every variable, and further conditions."""
    bounds, conditions = region_parts(given, names, where)
    for each in clock:
        if each.name in bounds:
            raise InputError(f"every episode starts at {each.name} 0", where / "box" / each.name, "remove it")
        bounds = {**bounds, each.name: (Fraction(0), Fraction(0))}
    for variable in variables:
        low, high = variable.range
        place = where / "box" / variable.name
        if variable.name not in bounds:
            raise InputError(f"the start says nothing of {variable.name}", where / "box", "bound every variable")
        if bounds[variable.name][0] < low or bounds[variable.name][1] > high:
            raise InputError("the start lies outside the range", place, "widen the range of the variable")
    start = (*box_of(bounds), *conditions)
    if is_empty(start):
        raise InputError("the start region is empty", where, "no state meets all of its conditions")
    return start


def region_parts(given: Mapping[str, object], names: Names, where: Place) -> tuple[Box, Polytope]:
    """The box of a region, and the half spaces of its further conditions: `box` and `where`."""
    only(given, ("box", "where"), where)
    bounds: dict[str, Interval] = {}
    for name, value in flat(table(given, "box", where), where / "box").items():
        if name not in names.known:
            raise UnknownNameError("variable", name, names.known, where / "box")
        if name in names.modes:
            value = _number_of(value, name, names, where / "box" / name)
        bounds[name] = interval(value, names.known[name], names, where / "box" / name)
    conditions: list[HalfSpace] = []
    for index, value in enumerate(as_list(given.get("where", []), where / "where")):
        place = where / "where" / index
        conditions += half_spaces(text(value, place), names, place)
    return bounds, tuple(conditions)


def _number_of(value: object, name: str, names: Names, where: Place) -> int:
    """The number of a mode by its name."""
    mode = text(value, where)
    if mode not in names.modes[name]:
        raise UnknownNameError(f"mode of {name}", mode, names.modes[name], where)
    return names.modes[name].index(mode)


def region_of(given: object, names: Names, where: Place) -> Polytope:
    """A region as half spaces."""
    bounds, conditions = region_parts(as_table(given, where), names, where)
    return (*box_of(bounds), *conditions)


OF_AGENTS = ("team", "like", "features", "actions", "outputs", "reward")
GIVEN = "given"  # the action that stands for all that an agent gives, as long as no profile says what
MAX_AGENTS, MAX_FEATURES, MAX_ACTIONS, MAX_OUTPUTS = 64, 1_024, 1_024, 64
ZERO = Number(Fraction(0))
FUNCTIONS = {measure.value: measure for measure in (Measure.SIGN, Measure.POSITIVE)}


def agents_of(given: Mapping[str, object], names: Names, where: Place) -> tuple[tuple[Agent, ...], dict[str, Unit]]:
    """The agents, and the units of their inputs by name."""
    if not 1 <= len(given) <= MAX_AGENTS:
        raise InputError(f"{format_count(len(given), 'agent')}, of 1 to {MAX_AGENTS}", where, ADVICE)
    agents: list[Agent] = []
    inputs: dict[str, Unit] = {}
    for name, value in given.items():
        place = where / name
        described = as_table(value, place)
        only(described, OF_AGENTS, place)
        outputs = _outputs(name, described, inputs, place) if "outputs" in described else ()
        actions = {GIVEN: dict.fromkeys(outputs, ZERO)} if outputs else _actions(name, described, names, inputs, place)
        team = _as_label(text(described.get("team", name), place / "team"), place / "team")
        reward = as_typed(described.get("reward", 0), names, place / "reward").value
        called = tuple(each.partition(".")[2] for each in outputs)
        agents.append(Agent(as_name(name, place), team, actions, reward, called, _like(name, given, place)))
    for name in inputs.keys() & names.known.keys():
        raise InputError(f"'{name}' is a variable and an input", where, "give each a name of its own")
    return tuple(agents), inputs


def _like(agent: str, given: Mapping[str, object], where: Place) -> str:
    """The agent whose tree this one acts by; "": its own."""
    described = as_table(given[agent], where)
    if "like" not in described:
        return ""
    other = text(described["like"], where / "like")
    own = [name for name, value in given.items() if name != agent and "like" not in as_table(value, where)]
    only({other: None}, own, where / "like", "agent with a tree of its own")
    return other


def _actions(
    agent: str, described: Mapping[str, object], names: Names, inputs: dict[str, Unit], where: Place
) -> Mapping[str, Mapping[str, Expression]]:
    """Reads what each action sets: all of them the same inputs, those that one leaves out to 0."""
    actions: dict[str, Mapping[str, Expression]] = {}
    for action, settings in _some(described, "actions", where, MAX_ACTIONS).items():
        place = where / "actions" / action
        actions[_as_label(action, place)] = _settings(agent, as_table(settings, place), names, inputs, place)
    known = dict.fromkeys((name for values in actions.values() for name in values if not is_mode(name)), ZERO)
    return {action: {**known, **values} for action, values in actions.items()}


def _outputs(agent: str, described: Mapping[str, object], inputs: dict[str, Unit], where: Place) -> tuple[str, ...]:
    """The inputs that the numbers of an agent are, `AGENT.OUTPUT`; their units go into `inputs`."""
    if "actions" in described:
        raise InputError("an agent has actions or outputs, not both", where, "remove one of the two")
    outputs: list[str] = []
    for key, value in _some(described, "outputs", where, MAX_OUTPUTS).items():
        place = where / "outputs" / key
        outputs.append(f"{agent}.{as_name(key, place)}")
        inputs[outputs[-1]] = unit_of(text(value, place), place)
    return tuple(outputs)


def _some(described: Mapping[str, object], key: str, where: Place, most: int) -> Mapping[str, object]:
    """A table that must hold something."""
    stated = table(described, key, where)
    if not 1 <= len(stated) <= most:
        none = key == "actions" and not stated
        what = "an agent has no actions" if none else f"{len(stated)} {key}, of 1 to {most}"
        advice = "add [agents.NAME.actions] or [agents.NAME.outputs]" if none else ADVICE
        raise InputError(what, where / key, advice)
    return stated


def _as_label(name: str, where: Place) -> str:
    if not NAME.fullmatch(name):
        raise InputError(f"not a name: {name[:60]!r}", where, "use letters, digits, _ and -, a letter first")
    return name


def _settings(
    agent: str, given: Mapping[str, object], names: Names, inputs: dict[str, Unit], where: Place
) -> dict[str, Expression]:
    """Reads what one action sets, by `AGENT.INPUT`; their units go into `inputs`."""
    settings: dict[str, Expression] = {}
    for key, value in given.items():
        place, name = where / key, f"{agent}.{as_name(key, where)}"
        if value in names.modes.get(key, ()):
            settings[input_of(agent, key)] = Number(Fraction(_number_of(value, key, names, place)))
            continue
        setting = as_typed(value, names, place)
        if setting.value != ZERO or setting.unit is not None:
            unit = PURE if setting.unit is None else setting.unit
            if inputs.setdefault(name, unit) != unit:
                what = f"units do not fit: {format_unit(unit)}, and {format_unit(inputs[name])} in another action"
                raise InputError(what, place, "set an input in one unit")
        settings[name] = setting.value
    return settings


# --- features


def features_of(given: Mapping[str, object], names: Names, where: Place) -> dict[str, dict[str, Feature]]:
    """The features of each agent, in their order."""
    features: dict[str, dict[str, Feature]] = {}
    for agent, described in given.items():
        place = where / agent
        stated = _some(as_table(described, place), "features", place, MAX_FEATURES)
        features[agent] = {
            _as_label(name, place): _feature(text(value, place / "features" / name), names, place / "features" / name)
            for name, value in stated.items()
        }
    return features


def _feature(stated: str, names: Names, where: Place) -> Feature:
    """A feature by its text: an affine form, or sign, positive or clip of one."""
    function, expression = feature_of(stated, FUNCTIONS, names, where)
    if function == Measure.EQUALS.value and (form := affine(expression)) is not None:
        return Feature(form, Measure.EQUALS)
    if not function and isinstance(expression, Call) and expression.bounds is not None:
        form = affine(expression.argument)
        if form is not None:
            return Feature(form, Measure.CLIP, expression.bounds)
    form = affine(expression)
    if form is None:
        what = "a feature is an affine form of variables, sign, positive or clip of one, or an equation of two"
        raise InputError(f"not a feature: {stated[:60]!r}", where, what)
    return Feature(form, FUNCTIONS.get(function, Measure.VALUE))
