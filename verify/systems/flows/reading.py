"""Continuous time, as a world file writes it: derivatives of the variables, and actions that are held for a period.

Does: reads `flow`, `period`, `next`, `let` and `error` of the table `dynamics`; checks names and units.
Assumes: variables and agents are known.
Does not: integrate.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction

from codegen.errors import InputError, UnknownNameError
from verify.language.units import Unit, times, unit_of
from verify.systems.flows.sampling import ADVICE as PERIOD
from verify.systems.flows.sampling import Keeping, keeping, sampling_of
from verify.systems.language.expressions import Call, Expression, Number, affine, parts
from verify.systems.language.parsing import Names, fitting
from verify.systems.statement import Agent
from verify.systems.system import Feature, Flow, Interval, Variable
from verify.systems.values import ADVICE, error_of, flat, only, table, typed
from verify.toml_places import Place

KEYS = ("flow", "period", "next", "let", "error")
STEPWISE = ("A", "B", "c", "cuts", "piece")  # of systems that move in steps
MAX_LET = 100
STILL = Number(Fraction(0))  # the derivative of what keeps an earlier value
SMOOTH = ("sin", "cos", "tan", "exp", "sqrt")  # functions that have derivatives of all orders where they are defined


def flow_of(
    given: Mapping[str, object],
    variables: Sequence[Variable],
    agents: Sequence[Agent],
    features: Mapping[str, Mapping[str, Feature]],
    names: Names,
    where: Place,
) -> tuple[Flow, Keeping]:
    """The flow of a file, and what its delays keep. `names`: variables, inputs and constants. InputError with the place
    of the first fault.
    """
    for key in STEPWISE:
        if key in given:
            what = f"both flow and {key}"
            raise InputError(
                what, where / key, f"a flow states derivatives, and next what jumps: remove {key}, or flow"
            )
    only(given, KEYS, where)
    second = unit_of("s", where)
    if "period" not in given:
        raise InputError("a flow needs the period of its samples", where, PERIOD)
    sampling = sampling_of(given["period"], names, where / "period")
    late = keeping(sampling.delays, variables, features, where / "period")
    meant = dict(names.meant)
    lets = table(given, "let", where)
    if len(lets) > MAX_LET:
        raise InputError(f"more than {MAX_LET} names", where / "let", "shorten it")
    for name, value in lets.items():
        if name in names.known or name in meant:
            raise InputError(f"'{name}' is named twice", where / "let", "give each a name of its own")
        meant[name] = typed(value, Names(names.known, meant), where / "let" / name)
    known, units = Names(names.known, meant), {each.name: names.known[each.name] for each in variables}
    stated = flat(table(given, "flow", where), where / "flow")
    _ensure_variables(stated, units, where / "flow")
    rates = {name: _rate(stated, name, times(unit, second, -1), known, where / "flow") for name, unit in units.items()}
    errors = _errors(given, units, known, where)
    jumping = flat(table(given, "next", where), where / "next")
    _ensure_variables(jumping, units, where / "next")
    jumps = {name: _smooth(jumping[name], units[name], known, where / "next" / name) for name in jumping}
    rates |= {each.name: STILL for each in late.variables}
    jumps |= late.jumps
    flow = Flow(sampling.length, rates, _held(agents, where), errors, jumps, sampling.jitter, late.seen, late.kept)
    return flow, late


def _ensure_variables(given: Mapping[str, object], units: Mapping[str, Unit], where: Place) -> None:
    for name in given:
        if name not in units:
            raise UnknownNameError("variable", name, units, where)


def _rate(stated: Mapping[str, object], name: str, unit: Unit, names: Names, where: Place) -> Expression:
    """A derivative, in the unit of its variable per second."""
    if name not in stated:
        raise InputError(f"nothing says how {name} moves", where, f"write {name} = 0 if it stays")
    return _smooth(stated[name], unit, names, where / name)


def _smooth(value: object, unit: Unit, names: Names, where: Place) -> Expression:
    """An expression of a unit that has derivatives of all orders."""
    found = fitting(typed(value, names, where), unit, where)
    pending = [found]
    while pending:
        part = pending.pop()
        if isinstance(part, Call) and part.function not in SMOOTH:
            what = f"{part.function} beside a flow cannot be enclosed: it has a corner"
            raise InputError(what, where, f"write sums, products, quotients, powers, {', '.join(SMOOTH)}")
        pending += parts(part)
    return found


def _errors(given: Mapping[str, object], units: Mapping[str, Unit], names: Names, where: Place) -> dict[str, Interval]:
    """By how much a derivative may be off at any time: a number e for [-e, e], or an interval."""
    stated = flat(table(given, "error", where), where / "error")
    _ensure_variables(stated, units, where / "error")
    found: dict[str, Interval] = {}
    for name, value in stated.items():
        place = where / "error" / name
        found[name] = error_of(value, times(units[name], unit_of("s", place), -1), names, place)
    return {name: bounds for name, bounds in found.items() if bounds != (0, 0)}


def _held(agents: Sequence[Agent], where: Place) -> dict[tuple[str, str], Mapping[str, Fraction]]:
    """What each action of each agent holds its inputs at for a period."""
    found: dict[tuple[str, str], Mapping[str, Fraction]] = {}
    for agent in agents:
        for action, settings in agent.actions.items():
            values: dict[str, Fraction] = {}
            for name, setting in settings.items():
                form = affine(setting)
                if form is None or form.terms:
                    what = f"action {action} of {agent.name} sets {name} to what is no number"
                    raise InputError(what, where, f"an action of a flow holds numbers: {ADVICE}")
                values[name] = form.constant
            found[agent.name, action] = values
    return found
