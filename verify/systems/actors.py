"""Who acts in a world file, what its actions set, and what its features measure.

Does: reads the tables of agents.
Assumes: variables and constants are known.
Does not: know how the state moves (motion.py).
"""

from collections.abc import Mapping
from fractions import Fraction
from types import MappingProxyType

from codegen.errors import InputError
from codegen.ir import NAME
from codegen.wording import format_count
from verify.language.units import PURE, Unit, format_unit, unit_of
from verify.systems.given.agents import Acting
from verify.systems.language.expressions import Call, Expression, Number, affine
from verify.systems.language.parsing import Names, feature_of
from verify.systems.statement import Agent
from verify.systems.system import Feature, Measure
from verify.systems.values import ADVICE, as_name, as_table, as_typed, only, table, text
from verify.toml_places import Place

KEYS = ("team", "like", "features", "actions", "outputs", "reward")
GIVEN = "given"  # the action that stands for all that an agent gives, as long as no profile says what
MAX_AGENTS, MAX_FEATURES, MAX_ACTIONS, MAX_OUTPUTS = 64, 1_024, 1_024, 64
ZERO = Number(Fraction(0))
FUNCTIONS = {measure.value: measure for measure in (Measure.SIGN, Measure.POSITIVE)}


def agents_of(
    given: Mapping[str, object], names: Names, where: Place, acting: Mapping[str, Acting] = MappingProxyType({})
) -> tuple[tuple[Agent, ...], dict[str, Unit]]:
    """The agents, and the units of their inputs by name. `acting`: how proofs read those that give numbers."""
    if not 1 <= len(given) <= MAX_AGENTS:
        raise InputError(f"{format_count(len(given), 'agent')}, of 1 to {MAX_AGENTS}", where, ADVICE)
    agents: list[Agent] = []
    inputs: dict[str, Unit] = {}
    for name, value in given.items():
        place = where / name
        described = as_table(value, place)
        only(described, KEYS, place)
        outputs = _outputs(name, described, inputs, place) if "outputs" in described else ()
        if outputs:
            actions = acting[name].settings if name in acting else {GIVEN: dict.fromkeys(outputs, ZERO)}
        else:
            actions = _actions(name, described, names, inputs, place)
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
    """Reads what each action sets; all of them set the same inputs."""
    actions: dict[str, Mapping[str, Expression]] = {}
    for action, settings in _some(described, "actions", where, MAX_ACTIONS).items():
        place = where / "actions" / action
        actions[_as_label(action, place)] = _settings(agent, as_table(settings, place), names, inputs, place)
    return _whole(actions)


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
        raise InputError(f"{len(stated)} {key}, of 1 to {most}", where / key, ADVICE)
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
        setting = as_typed(value, names, place)
        if setting.value != ZERO or setting.unit is not None:
            unit = PURE if setting.unit is None else setting.unit
            if inputs.setdefault(name, unit) != unit:
                what = f"units do not fit: {format_unit(unit)}, and {format_unit(inputs[name])} in another action"
                raise InputError(what, place, "set an input in one unit")
        settings[name] = setting.value
    return settings


def _whole(actions: Mapping[str, Mapping[str, Expression]]) -> dict[str, Mapping[str, Expression]]:
    """The actions with 0 for every input that one of them leaves out."""
    inputs = dict.fromkeys(name for values in actions.values() for name in values)
    return {action: {name: values.get(name, ZERO) for name in inputs} for action, values in actions.items()}


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
