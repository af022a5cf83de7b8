"""Continuous time, as a world file writes it: derivatives, actions held for a period, and when agents observe.

Does: reads `flow`, `period`, `next`, `let`, `error` and `piece` of the table `dynamics`, a case for each piece and each
  way to choose; checks names, units, and that expressions have derivatives of all orders; keeps earlier values, which
  late agents observe, in variables of their own.
Assumes: variables, agents and features are known.
Does not: integrate, or show that some case holds every state (verify/checker/flows/samples.py).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction

from codegen.errors import InputError
from verify.claims.region_files import is_list, is_table
from verify.language.units import times, unit_of
from verify.systems.cases import CaseRegion
from verify.systems.expressions import Call, Expression, Name, Number, affine, parts
from verify.systems.expressions import names as names_in
from verify.systems.motion import Around, MotionReader, ensure_few
from verify.systems.parsing import Choices, Names, fitting
from verify.systems.statement import Agent, set_modes
from verify.systems.system import Affine, Feature, Flow, FlowCase, HalfSpace, Interval, Polytope, Variable
from verify.systems.values import ADVICE, as_constant, as_list, as_typed, count, error_of, only
from verify.toml_places import Place

KEYS = ("flow", "next", "let", "error", "period", "piece")
STEPWISE = ("A", "B", "c", "cuts")  # of systems that move in steps
STILL = Number(Fraction(0))  # the derivative of what changes at samples only
SMOOTH = ("sin", "cos", "tan", "exp", "sqrt")  # functions that have derivatives of all orders where they are defined


def flow_of(
    given: Mapping[str, object], around: Around, features: Mapping[str, Mapping[str, Feature]], where: Place
) -> tuple[Flow, Keeping]:
    """The flow of a file, and what its delays keep. InputError with the place of the first fault."""
    for key in STEPWISE:
        if key in given:
            advice = f"a flow states derivatives, and next what jumps: remove {key}, or flow"
            raise InputError(f"both flow and {key}", where / key, advice)
    only(given, KEYS, where)
    if "period" not in given:
        raise InputError("a flow needs the period of its samples", where, TIME)
    period, jitter, delays = _read_period(given["period"], around.names, where / "period")
    late = keeping(delays, around.variables, features, where / "period")
    reader = _FlowReader(around, late)
    cases = tuple(case for piece in reader.pieces(given, where) for case in reader.cases(*piece))
    first = cases[0]
    alone = not first.where and not first.when and len(cases) == 1
    held, of = _hold_inputs(set_modes(around.agents, around.variables), where), () if alone else cases
    samples = jitter, late.seen, late.kept
    return Flow(period, first.rates, held, first.error, first.jumps, *samples, of), late


class _FlowReader(MotionReader):
    """Reads derivatives and jumps."""

    moves = ("flow", "next", "let", "error")

    def __init__(self, around: Around, late: Keeping) -> None:
        super().__init__(around)
        self._late, self.bounded = late, self.all_units
        self.units = {name: unit for name, unit in self.units.items() if name not in self.names.modes}
        still = [*(name for name in self.all_units if name not in self.units), *(each.name for each in late.variables)]
        self._still: dict[str, Expression] = dict.fromkeys(still, STILL)

    def cases(self, given: Mapping[str, object], regions: Sequence[CaseRegion], where: Place) -> list[FlowCase]:
        """Reads the cases that a table states for some regions, once for each way to choose."""
        choices = Choices()
        choosing = self.read_lets(given, choices, where)
        known = replace(choosing, choices=None)
        stated = self.entries(given, "flow", where, self.units)
        second = unit_of("s", where)
        rates_in = {name: times(unit, second, -1) for name, unit in self.units.items()}
        rates: dict[str, Expression] = {}
        for name, unit in rates_in.items():
            place = where / "flow"
            if name not in stated:
                raise InputError(f"nothing says how {name} moves", place, f"write {name} = 0 if it stays")
            rates[name] = fitting(as_typed(stated[name], known, place / name), unit, place / name)
            _ensure_smooth(rates[name], place / name)
        for name, rate in rates.items():
            if any(each in choices for each in names_in(rate)):
                raise InputError("a derivative is not chosen", where / "flow" / name, "choose in [dynamics.next]")
        errors = self.read_errors(given, rates_in, known, where)
        jumps: dict[str, Expression] = {}
        for name, value in self.entries(given, "next", where, (*self.units, *self.names.modes)).items():
            jumps[name] = self.read_next(name, value, choosing, where / "next" / name)
            choices.call(name)
        cases: list[FlowCase] = []
        for chosen in choices.ways(jumps, where):
            for name, jump in chosen.next.items():
                _ensure_smooth(jump, where / "next" / name)
            jumped = {**chosen.next, **self.around.counted, **self._late.jumps}
            cases += (FlowCase(box, when, rates | self._still, errors, jumped, chosen.words) for box, when in regions)
            ensure_few(cases, where)
        return cases


def _ensure_smooth(expression: Expression, where: Place) -> None:
    pending = [expression]
    while pending:
        part = pending.pop()
        if isinstance(part, Call) and part.function not in SMOOTH:
            what = f"{part.function} beside a flow cannot be enclosed: it has a corner"
            raise InputError(what, where, f"write sums, products, quotients, powers, {', '.join(SMOOTH)}")
        pending += parts(part)


def _hold_inputs(agents: Sequence[Agent], where: Place) -> dict[tuple[str, str], Mapping[str, Fraction]]:
    """Returns the values at which each action of each agent holds its inputs for a period."""
    held: dict[tuple[str, str], Mapping[str, Fraction]] = {}
    for agent in agents:
        for action, settings in agent.actions.items():
            values: dict[str, Fraction] = {}
            for name, setting in settings.items():
                form = affine(setting)
                if form is None or form.terms:
                    what = f"action {action} of {agent.name} sets {name} to what is no number"
                    raise InputError(what, where, f"an action of a flow holds numbers: {ADVICE}")
                values[name] = form.constant
            held[agent.name, action] = values
    return held


OF_PERIODS = ("length", "jitter", "delay")
MAX_DELAY = 32  # periods
MAX_VARIABLES = 256  # with those that keep earlier values
TIME = 'write period = "0.1 s", or a table with length, jitter and delay'


def _read_period(stated: object, names: Names, where: Place) -> tuple[Fraction, Interval, range]:
    """A period in seconds, by how much it may be longer, and the delays of observations in whole periods, from a time
    or a table. InputError with the place of the first fault.
    """
    second = unit_of("s", where)
    given, at = (stated, where / "length") if is_table(stated) else ({"length": stated}, where)
    only(given, OF_PERIODS, where)
    if "length" not in given:
        raise InputError("a period needs a length", where, 'write length = "0.1 s"')
    length = as_constant(given["length"], second, names, at)
    if length <= 0:
        raise InputError(f"the period {length} is not above 0", at, TIME)
    jitter = error_of(given.get("jitter", 0), second, names, where / "jitter")
    if length + jitter[0] <= 0:
        what = f"a period of {length} s may be {length + jitter[0]} s long"
        raise InputError(what, where / "jitter", "keep the jitter below the length")
    delay, where = given.get("delay", 0), where / "delay"  # whole periods: one number, or the ends of an interval
    ends = as_list(delay, where, 2) if is_list(delay) else [delay, delay]
    low, high = (0 if end == 0 and not isinstance(end, bool) else count(end, where, MAX_DELAY) for end in ends)
    if low > high:
        raise InputError(f"the least delay {low} is above the largest one {high}", where, "swap them")
    return length, jitter, range(low, high + 1)


@dataclass(frozen=True)
class Keeping:
    """Variables that keep what others were at earlier samples: themselves, what bounds their starts, what becomes of
    them at a sample, which variable each keeps, and for each delay what is observed in place of what.
    """

    variables: tuple[Variable, ...] = ()
    start: Polytope = ()
    jumps: Mapping[str, Expression] = field(default_factory=dict[str, Expression])
    kept: Mapping[str, str] = field(default_factory=dict[str, str])
    seen: tuple[Mapping[str, str], ...] = ({},)


def keeping(
    delays: Sequence[int],
    variables: Sequence[Variable],
    features: Mapping[str, Mapping[str, Feature]],
    where: Place,
) -> Keeping:
    """Returns what delays need; before the first sample all was as at the start. InputError for too many variables."""
    tested = {name for of in features.values() for each in of.values() for name, _ in each.form.terms}
    late = [one for one in variables if one.name in tested]
    if not any(delays):
        return Keeping()
    ages = range(1, max(delays) + 1)
    if len(variables) + len(late) * len(ages) > MAX_VARIABLES:
        what = f"{len(late)} observed variables kept for {len(ages)} periods are too many"
        raise InputError(what, where, "a smaller delay, or features of fewer variables")
    added = [Variable(earlier(one.name, age), one.unit, one.range, one.modes) for age in ages for one in late]
    kept = {earlier(one.name, age): one.name for age in ages for one in late}
    jumps = {earlier(one.name, age): Name(earlier(one.name, age - 1)) for age in ages for one in late}
    seen = tuple({one.name: earlier(one.name, delay) for one in late if delay} for delay in delays)
    one = Fraction(1)  # every start: what is kept is what the variable is
    ways = [(a, b) for pair in kept.items() for a, b in (pair, pair[::-1])]
    alike = tuple(HalfSpace(Affine.of({a: one, b: -one})) for a, b in ways)
    return Keeping(tuple(added), alike, jumps, kept, seen)


def earlier(name: str, age: int) -> str:
    """The variable that keeps what another was so many periods ago. No text can write it."""
    return f"{name} {age} ago" if age else name
