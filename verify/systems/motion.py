"""How the state moves, as a world file writes it: expressions or matrices, for all states, in boxes or by cases.

Does: reads the table `dynamics`; takes the effects of actions out of expressions; cuts conditions of cases by the
  ranges of what they test; says where two cases share a state, or none holds one; what `otherwise` stands for.
Assumes: variables and agents are known.
Does not: enclose what is not affine (enclosures.py).

What is left of the ranges once cases are taken away is a list of polytopes, found with each mode at one value.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import combinations, product
from typing import NamedTuple

from codegen.errors import InputError, UnknownNameError
from codegen.wording import format_count
from verify.decimals import plain
from verify.language.arithmetic import Typed, Unit, times
from verify.systems.expressions import (
    Expression,
    Name,
    Number,
    Sum,
    affine,
    names,
    of_affine,
    substitute,
    terms,
    total,
)
from verify.systems.parsing import (
    Choice,
    ChosenMotion,
    Names,
    call,
    conditions,
    fitting,
    input_of,
    mode_of,
    outside,
    ways,
)
from verify.systems.statement import Agent, Rule
from verify.systems.system import (
    Affine,
    Box,
    HalfSpace,
    Interval,
    Polytope,
    Variable,
    box_of,
    find_gap,
    is_empty,
    narrow,
    overlapping,
)
from verify.systems.values import (
    ADVICE,
    as_constant,
    as_list,
    as_table,
    as_typed,
    count,
    error_of,
    flat,
    interval,
    only,
    table,
    text,
)
from verify.toml_places import Place

MOVES = ("next", "let", "A", "B", "c", "error", "cuts")
NAMED = ("next", "error", "cuts", "flow")  # tables with an entry for each of some variables
MAX_CUTS, MAX_RULES, MAX_LET = 1_000, 1_000, 100
Effect = dict[tuple[str, str], dict[str, Expression]]


def rules_of(
    given: Mapping[str, object],
    variables: Sequence[Variable],
    agents: Sequence[Agent],
    names: Names,
    where: Place,
    counters: Sequence[str] = (),
) -> tuple[Rule, ...]:
    """The rules of a file. `names`: variables, inputs and constants; `counters`: variables that go up by 1 in a step,
    of which a file says nothing. InputError where rules overlap or leave a gap.
    """
    only(given, (*MOVES, "piece"), where)
    reader = _Motion(variables, agents, names, counters)
    pieces = read_pieces(given, MOVES, reader.regions, where)
    return tuple(rule for stated, own, place in pieces for rule in reader.rules(stated, own, place))


def read_pieces(
    given: Mapping[str, object],
    moves: Sequence[str],
    regions: Callable[[Sequence[Mapping[str, object]], Place], list[list[CaseRegion]]],
    where: Place,
) -> Iterator[tuple[Mapping[str, object], Sequence[CaseRegion], Place]]:
    """Yields the statements of each piece, the states in which they hold, and its place; in all states where there are
    no pieces. `moves`: the tables that a piece may state itself.
    """
    if "piece" not in given:
        yield given, [CaseRegion({}, ())], where
        return
    pieces = as_list(given["piece"], where / "piece")
    if not 1 <= len(pieces) <= MAX_RULES:
        raise InputError(f"{len(pieces)} pieces, of 1 to {MAX_RULES}", where, ADVICE)
    tables = [as_table(each, where / "piece" / index) for index, each in enumerate(pieces)]
    for index, stated in enumerate(tables):
        only(stated, (*moves, "where", "when"), where / "piece" / index)
    shared = {key: value for key, value in given.items() if key in moves}
    for index, (stated, own) in enumerate(zip(tables, regions(tables, where), strict=True)):
        place = where / "piece" / index
        yield merge_tables(shared, stated, place), own, place


def read_lets(
    given: Mapping[str, object], names: Names, choices: dict[str, Choice], called: dict[str, str], where: Place
) -> dict[str, Typed[Expression]]:
    """Names that stand for parts of expressions. `choices` gets what is chosen, `called` how each choice is called."""
    meant = dict(names.meant)
    lets = table(given, "let", where)
    if len(lets) > MAX_LET:
        raise InputError(f"more than {MAX_LET} names", where / "let", "shorten it")
    for name, value in lets.items():
        if name in names.known or name in meant:
            raise InputError(f"'{name}' is named twice", where / "let", "give each a name of its own")
        meant[name] = as_typed(value, Names(names.known, meant, names.modes, choices), where / "let" / name)
        call(called, choices, name)
    return meant


def ensure_few(cases: Sequence[object], where: Place) -> None:
    """InputError for too many rules of one table."""
    if len(cases) > MAX_RULES:
        raise InputError(f"more than {MAX_RULES} cases and choices", where, "choose between fewer values")


def merge_tables(shared: Mapping[str, object], stated: Mapping[str, object], where: Place) -> dict[str, object]:
    """Returns the statements that hold in a piece: what it states itself, and name by name what it leaves to the tables
    of all pieces. Of A and c, which have no names but an entry for each variable, a piece has its own or those of all.
    """
    piece = {**shared, **stated}
    for key in (each for each in (*NAMED, "let", "B") if each in piece):
        common, own = table(shared, key, where), table(stated, key, where)
        if key in NAMED:
            piece[key] = flat(common, where / key) | flat(own, where / key)
        elif key == "B":
            piece[key] = {name: {**table(common, name, where), **table(own, name, where)} for name in {**common, **own}}
        else:
            piece[key] = {**common, **own}
    return piece


def _ensure_cover(boxes: Sequence[Box], variables: Sequence[Variable], where: Place) -> None:
    """InputError where two boxes share more than a border, or the ranges hold states that no box holds."""
    pair = overlapping(boxes)
    if pair is not None:
        what = f"pieces {pair[0] + 1} and {pair[1] + 1} overlap"
        raise InputError(what, where, "pieces may share borders only")
    gap = find_gap({variable.name: variable.range for variable in variables}, boxes)
    if gap is not None:
        told = {name: bounds for name, bounds in gap.items() if any(name in box for box in boxes)}
        told = told or gap
        states = ", ".join(f"{name} in [{low}, {high}]" for name, (low, high) in told.items())
        raise InputError(f"pieces leave a gap: {states}", where, "add a piece, or narrow the ranges")


def setting_modes(agents: Sequence[Agent], variables: Sequence[Variable]) -> list[Agent]:
    """The agents, whose actions set each mode of their name too."""
    modes = [each for each in variables if each.modes]
    setters: list[Agent] = []
    for agent in agents:
        own = [each for each in modes if all(action in each.modes for action in agent.actions)]
        actions = {
            action: {**values, **{input_of(agent.name, m.name): Number(Fraction(m.modes.index(action))) for m in own}}
            for action, values in agent.actions.items()
        }
        setters.append(replace(agent, actions=actions))
    return setters


def regions_of(
    tables: Sequence[Mapping[str, object]], variables: Sequence[Variable], names: Names, where: Place
) -> list[list[CaseRegion]]:
    """The states of each piece. InputError where pieces overlap or leave a gap."""
    return _Motion(variables, (), names, ()).regions(tables, where)


class _Motion:
    """Reads rules."""

    def __init__(
        self, variables: Sequence[Variable], agents: Sequence[Agent], names: Names, counters: Sequence[str]
    ) -> None:
        self._variables, self._names = [each.name for each in variables if each.name not in counters], names
        self._counted = {name: Sum(Name(name), Number(Fraction(1))) for name in counters}
        self._all, self._modes = variables, [each for each in variables if each.modes]
        self._agents = setting_modes(agents, variables)

    def regions(self, tables: Sequence[Mapping[str, object]], where: Place) -> list[list[CaseRegion]]:
        """The states of each piece: all have a box, `where`, or all have conditions, `when`."""
        cases = ["when" in each for each in tables]
        if not any(cases):
            boxes = [self._box(each, where / "piece" / index) for index, each in enumerate(tables)]
            _ensure_cover(boxes, self._all, where)
            return [[CaseRegion(box, ())] for box in boxes]
        for index, each in enumerate(tables):
            place = where / "piece" / index
            if "when" not in each or "where" in each:
                raise InputError("one piece has conditions, so all have them", place, "write when, and no where")
        texts = [text(each["when"], where / "piece" / index / "when") for index, each in enumerate(tables)]
        if texts.count(OTHERWISE) > 1:
            raise InputError(f"several cases are {OTHERWISE!r}", where, "keep one of them")
        stated = [
            None if each == OTHERWISE else conditions(each, self._of_states, where / "piece" / index / "when")
            for index, each in enumerate(texts)
        ]
        return case_regions(stated, self._all, where / "piece")

    @property
    def _of_states(self) -> Names:
        """The names that conditions may use: variables and constants."""
        known = {each.name: self._names.known[each.name] for each in self._all}
        return Names(known, self._names.meant, self._names.modes)

    def _box(self, given: Mapping[str, object], where: Place) -> Box:
        """The box of a piece."""
        return {
            name: interval(bounds, self._unit(name, where / "where"), self._names, where / "where" / name)
            for name, bounds in flat(table(given, "where", where), where / "where").items()
        }

    def _unit(self, name: str, where: Place) -> Unit:
        if name not in self._variables:
            raise UnknownNameError("variable", name, self._variables, where)
        return self._names.known[name]

    def rules(self, given: Mapping[str, object], regions: Sequence[CaseRegion], place: Place) -> tuple[Rule, ...]:
        """The rules of a table: one for each of its regions and for each value of each choice."""
        if "next" in given:
            for key in ("A", "B", "c"):
                if key in given:
                    raise InputError(f"both next and {key}", place, "write expressions or matrices, not both")
            moves = [(*self._split_next(chosen.next, place), chosen.words) for chosen in self._list_moves(given, place)]
        elif "A" in given:
            if self._modes:
                raise InputError("matrices do not say what becomes of modes", place / "A", "write next")
            moves = [(*self._matrices(given, place), dict[str, str]())]
        else:
            raise InputError("nothing says how the state moves", place, "write next, or A, B and c")
        error, cuts = self._errors(given, place), self._cuts(given, place)
        rules = [
            Rule(where, {**move, **self._counted}, effect, error, cuts, when, words, place)
            for where, when in regions
            for move, effect, words in moves
        ]
        ensure_few(rules, place)
        return tuple(rules)

    def _list_moves(self, given: Mapping[str, object], place: Place) -> list[ChosenMotion]:
        """The next values for each way to choose."""
        choices: dict[str, Choice] = {}
        called: dict[str, str] = {}
        stated = self._next(given, choices, called, place)
        return list(ways(stated, choices, called, place))

    # --- expressions

    def _next(
        self, given: Mapping[str, object], choices: dict[str, Choice], called: dict[str, str], where: Place
    ) -> dict[str, Expression]:
        """The next value of each variable. `choices` gets what is chosen, `called` how each choice is called."""
        meant = read_lets(given, self._names, choices, called, where)
        stated = flat(table(given, "next", where), where / "next")
        for name in stated:
            self._unit(name, where / "next")
        named = Names(self._names.known, meant, self._names.modes, choices)
        following: dict[str, Expression] = {}
        for name in self._variables:
            following[name] = self._one(stated, name, named, where / "next")
            call(called, choices, name)
        return following

    def _one(self, stated: Mapping[str, object], name: str, named: Names, where: Place) -> Expression:
        if name not in stated:
            raise InputError(f"nothing says how {name} moves", where, f'write {name} = "{name}" if it stays')
        if name in named.modes:
            actions = {agent.name: tuple(agent.actions) for agent in self._agents}
            return mode_of(text(stated[name], where / name), name, named, actions, where / name)
        return fitting(as_typed(stated[name], named, where / name), self._names.known[name], where / name)

    def _split_next(self, following: Mapping[str, Expression], where: Place) -> tuple[dict[str, Expression], Effect]:
        """Splits next values into what holds for all actions, and what each action adds."""
        move: dict[str, Expression] = {}
        effect: Effect = {}
        for name, expression in following.items():
            own, acted = self._shares(expression, where / "next" / name)
            move[name] = total(own)
            for agent in self._agents:
                for action, values in agent.actions.items():
                    if acted.get(agent.name):
                        added = substitute(total(acted[agent.name]), values)
                        effect.setdefault((agent.name, action), {})[name] = added
        return move, effect

    def _shares(self, expression: Expression, where: Place) -> tuple[list[Expression], dict[str, list[Expression]]]:
        """The terms without inputs, and those of each agent's. What is not affine goes to the one agent that has such
        terms too: together they are enclosed more tightly.
        """
        form = affine(expression)
        own: list[Expression] = []
        acted: dict[str, list[Expression]] = {}
        for term in terms(expression if form is None else of_affine(form)):
            owners = [agent.name for agent in self._agents if agent.inputs & names(term)]
            if len(owners) > 1:
                what = f"one term holds actions of {' and '.join(owners)}"
                raise InputError(what, where, "effects of agents must add up: write a sum of terms")
            if owners:
                acted.setdefault(owners[0], []).append(term)
            else:
                own.append(term)
        curved = [name for name, shares in acted.items() if any(affine(term) is None for term in shares)]
        if len(curved) == 1:
            acted[curved[0]] += [term for term in own if affine(term) is None]
            own = [term for term in own if affine(term) is not None]
        return own, acted

    # --- matrices

    def _matrices(self, given: Mapping[str, object], where: Place) -> tuple[dict[str, Expression], Effect]:
        """`x' = A x + B(action) + c`, with a row for each variable."""
        n = len(self._variables)
        rows = as_list(given["A"], where / "A")
        if len(rows) != n:
            what = f"A has {format_count(len(rows), 'row')}, and there are {format_count(n, 'variable')}"
            raise InputError(what, where / "A", "one row for each")
        constant = self._vector(given.get("c", [0] * n), where / "c")
        move: dict[str, Expression] = {}
        for index, (name, row) in enumerate(zip(self._variables, rows, strict=True)):
            place = where / "A" / index
            entries = as_list(row, place)
            if len(entries) != n:
                raise InputError(f"a row of {len(entries)}, and there are {n} variables", place, "one entry for each")
            pairs = zip(self._variables, entries, strict=True)
            factors = {other: self._entry(value, name, other, place) for other, value in pairs}
            move[name] = of_affine(Affine.of(factors, constant[name]))
        return move, self._effects(table(given, "B", where), where / "B")

    def _entry(self, value: object, row: str, column: str, where: Place) -> Fraction:
        """A factor; one without a unit has the unit that fits."""
        unit = times(self._names.known[row], self._names.known[column], -1)
        return as_constant(value, unit, self._names, where.saying(column))

    def _vector(self, value: object, where: Place) -> dict[str, Fraction]:
        entries = as_list(value, where, len(self._variables))
        return {
            name: as_constant(entry, self._names.known[name], self._names, where.saying(name))
            for name, entry in zip(self._variables, entries, strict=True)
        }

    def _effects(self, given: Mapping[str, object], where: Place) -> Effect:
        """B: agent -> action -> a number for each variable. An action without one adds nothing."""
        acting = {agent.name: agent for agent in self._agents}
        only(given, tuple(acting), where, "agent")
        gains: Effect = {}
        for agent, actions in given.items():
            stated = as_table(actions, where / agent)
            only(stated, tuple(acting[agent].actions), where / agent, "action")
            for action, vector in stated.items():
                added = self._vector(vector, where / agent / action)
                gains[agent, action] = {name: of_affine(Affine.of({}, value)) for name, value in added.items() if value}
        return gains

    # --- errors and cuts

    def _errors(self, given: Mapping[str, object], where: Place) -> dict[str, Interval]:
        """The error of each variable: a number e for [-e, e], or an interval."""
        errors: dict[str, Interval] = {}
        for name, value in flat(table(given, "error", where), where / "error").items():
            place = where / "error" / name
            unit = self._unit(name, where / "error")
            if name in self._names.modes:
                raise InputError("a mode has no error", place, "write choice(.., ..) of modes in next")
            errors[name] = error_of(value, unit, self._names, place)
        return {name: bounds for name, bounds in errors.items() if bounds != (0, 0)}

    def _cuts(self, given: Mapping[str, object], where: Place) -> dict[str, int]:
        """Into how many parts the range of a variable is cut where something is not affine."""
        cuts: dict[str, int] = {}
        for name, value in flat(table(given, "cuts", where), where / "cuts").items():
            self._unit(name, where / "cuts")
            cuts[name] = count(value, where / "cuts" / name, MAX_CUTS)
        return cuts


OTHERWISE = "otherwise"
MAX_REGIONS = 4_096  # of all cases
NARROW = "write bounds with < on one side and >= on the other"


class CaseRegion(NamedTuple):
    """States of a case: a box that bounds all that some case tests, and what the box does not say."""

    where: Box
    when: Polytope


def case_regions(
    conditions: Sequence[Sequence[Polytope] | None], variables: Sequence[Variable], where: Place
) -> list[list[CaseRegion]]:
    """The regions of each case; None: whatever the others leave. InputError where cases overlap or leave a gap."""
    named = {name for each in conditions for region in each or () for half in region for name, _ in half.form.terms}
    tested = [one for one in variables if one.name in named]
    ranges = {one.name: one.range for one in tested}
    modes = {one.name: len(one.modes) for one in tested if one.modes}
    regions = [[_tight(each, modes) for each in given or ()] for given in conditions]
    last = next((number for number, given in enumerate(conditions) if given is None), None)
    others: list[Polytope] = []
    met: list[set[Polytope]] = [set() for _ in regions]  # of each case the polytopes that hold some state
    for fixed in _combinations(modes):
        whole = _with(box_of(ranges), fixed)
        kept = [{each: _restrict_region(each, fixed, whole) for each in given} for given in regions]
        held = [[part for part in given.values() if part is not None] for given in kept]
        for seen, given in zip(met, kept, strict=True):
            seen |= {each for each, part in given.items() if part is not None}
        _ensure_apart(held, where)
        for left in _subtract_regions(whole, [each for given in held for each in given]):
            if last is None:
                what = f"cases leave a gap: {_states(left, ranges, fixed, variables)}"
                raise InputError(what, where, f'add a case, or one with when = "{OTHERWISE}"')
            others.append((*left, *box_of({name: (value, value) for name, value in fixed.items()})))
            if len(others) > MAX_REGIONS:
                raise InputError(f"more than {MAX_REGIONS} cases", where, "test less")
    regions = [[each for each in given if each in seen] for given, seen in zip(regions, met, strict=True)]
    if last is not None:
        regions[last] = others
    for number, given in enumerate(regions):
        if not given:
            raise InputError(f"case {number + 1} holds no state of the ranges", where / number, "remove it")
    return [[_region(each, ranges) for each in given] for given in regions]


def _combinations(modes: Mapping[str, int]) -> Iterator[dict[str, Fraction]]:
    for values in product(*map(range, modes.values())):
        yield dict(zip(modes, map(Fraction, values), strict=True))


def _tight(region: Polytope, modes: Mapping[str, int]) -> Polytope:
    """A polytope whose bounds of single modes are whole numbers."""
    halves: list[HalfSpace] = []
    for half in region:
        match half.form.terms:
            case ((name, factor),) if name in modes:
                end = -half.form.constant / factor
                whole = Fraction(end.__floor__() if factor > 0 else end.__ceil__())
                if half.strict and whole == end:
                    whole += -1 if factor > 0 else 1
                sign = Fraction(1 if factor > 0 else -1)
                halves.append(HalfSpace(Affine.of({name: sign}, -sign * whole)))
            case _:
                halves.append(half)
    return tuple(halves)


def _with(region: Polytope, fixed: Mapping[str, Fraction]) -> Polytope:
    """A polytope with modes at values, in the other variables."""
    halves: list[HalfSpace] = []
    for half in region:
        terms = {name: factor for name, factor in half.form.terms if name not in fixed}
        added = sum((factor * fixed[name] for name, factor in half.form.terms if name in fixed), Fraction(0))
        halves.append(HalfSpace(Affine.of(terms, half.form.constant + added), half.strict))
    return tuple(half for half in dict.fromkeys(halves) if half.form.terms or not half.holds({}))


def _restrict_region(region: Polytope, fixed: Mapping[str, Fraction], whole: Polytope) -> Polytope | None:
    """A region with modes at values; None where it has no state then."""
    restricted = _with(region, fixed)
    return None if is_empty((*restricted, *whole)) else restricted


def _ensure_apart(held: Sequence[Sequence[Polytope]], where: Place) -> None:
    for (i, one), (j, other) in combinations(enumerate(held), 2):
        if any(is_empty((*a, *b)) is not True for a, b in product(one, other)):
            raise InputError(f"cases {i + 1} and {j + 1} overlap", where / j, NARROW)


def _subtract_regions(whole: Polytope, held: Sequence[Polytope]) -> list[Polytope]:
    """Polytopes that hold what is in none of some regions."""
    open_ = [whole]
    for region in held:
        parts: list[Polytope] = []
        for each in open_:
            for number, half in enumerate(region):
                ((opposite,),) = outside([(half,)])
                part = (*each, *region[:number], opposite)
                if not is_empty(part):
                    parts.append(tuple(dict.fromkeys(part)))
        open_ = parts
    return open_


def _region(region: Polytope, ranges: Mapping[str, Interval]) -> CaseRegion:
    """A polytope as a box and the rest."""
    box, rest = dict(ranges), list[HalfSpace]()
    for half in region:
        if len(half.form.terms) == 1:
            ((name, factor),) = half.form.terms
            inner = narrow(box[name], factor, -half.form.constant / factor)
            box[name] = inner if inner[0] <= inner[1] else box[name]
            if half.strict or inner[0] > inner[1]:
                rest.append(half)
        else:
            rest.append(half)
    return CaseRegion(box, tuple(dict.fromkeys(rest)))


def _states(
    region: Polytope, ranges: Mapping[str, Interval], fixed: Mapping[str, Fraction], variables: Sequence[Variable]
) -> str:
    """States in words."""
    names = {one.name: one.modes for one in variables}
    told = [f"{name} = {names[name][int(value)]}" for name, value in fixed.items()]
    box = _region(region, ranges).where
    told += [f"{name} in [{plain(low)}, {plain(high)}]" for name, (low, high) in box.items() if name not in fixed]
    return ", ".join(told)
