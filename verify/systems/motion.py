"""How the state moves, as a world file writes it: expressions or matrices, for all states, in boxes or by cases.

Does: reads the table `dynamics`; takes the effects of actions out of expressions; cuts conditions of cases by the
  ranges of what they test; says where two cases share a state, or none holds one; what `otherwise` stands for.
Assumes: variables and agents are known.
Does not: enclose what is not affine (enclosures.py).

What is left of the ranges once cases are taken away is a list of polytopes, found with each mode at one value.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import combinations, product
from typing import NamedTuple

from codegen.errors import InputError, UnknownNameError
from codegen.wording import format_count
from verify.decimals import plain
from verify.language.units import Unit, times
from verify.systems.expressions import (
    Expression,
    Name,
    Number,
    Sum,
    of_affine,
)
from verify.systems.parsing import (
    Choices,
    ChosenMotion,
    Names,
    conditions,
    fitting,
    mode_of,
    outside,
)
from verify.systems.statement import Agent, Effect, Rule, set_modes
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

NAMED = ("next", "error", "cuts", "flow")  # tables with an entry for each of some variables
MAX_CUTS, MAX_RULES, MAX_LET = 1_000, 1_000, 100
OTHERWISE = "otherwise"
MAX_REGIONS = 4_096  # of all cases
NARROW = "write bounds with < on one side and >= on the other"


class CaseRegion(NamedTuple):
    """States of a case: a box that bounds all that some case tests, and what the box does not say."""

    where: Box
    when: Polytope


@dataclass(frozen=True)
class Around:
    """The statements of a file beside its motion. `names`: variables, inputs and constants; `counters`: variables that
    go up by 1 in a step, of which a file says nothing.
    """

    variables: Sequence[Variable]
    agents: Sequence[Agent]
    names: Names
    counters: Sequence[str]

    @property
    def counted(self) -> dict[str, Expression]:
        """The next values of the counters."""
        return {name: Sum(Name(name), Number(Fraction(1))) for name in self.counters}


class MotionReader:
    """Reads what the table `dynamics` and its pieces say of a file's variables; `moves`: the tables that they have."""

    moves: Sequence[str]

    def __init__(self, around: Around) -> None:
        self.around, self.names = around, around.names
        self.all_units = {one.name: self.names.known[one.name] for one in around.variables}
        self.units = {name: unit for name, unit in self.all_units.items() if name not in around.counters}
        self.bounded = self.units  # what a box of a piece may name
        self._actions = {agent.name: tuple(agent.actions) for agent in around.agents}

    def pieces(
        self, given: Mapping[str, object], where: Place
    ) -> Iterator[tuple[Mapping[str, object], Sequence[CaseRegion], Place]]:
        """Yields the statements of each piece, the states in which they hold, and its place; in all states where there
        are no pieces. InputError where pieces overlap or leave a gap.
        """
        if "piece" not in given:
            yield given, [CaseRegion({}, ())], where
            return
        pieces = as_list(given["piece"], where / "piece")
        if not 1 <= len(pieces) <= MAX_RULES:
            raise InputError(f"{len(pieces)} pieces, of 1 to {MAX_RULES}", where, ADVICE)
        tables = [as_table(each, where / "piece" / index) for index, each in enumerate(pieces)]
        for index, stated in enumerate(tables):
            only(stated, (*self.moves, "where", "when"), where / "piece" / index)
        shared = {key: value for key, value in given.items() if key in self.moves}
        for index, (stated, own) in enumerate(zip(tables, self._regions(tables, where), strict=True)):
            place = where / "piece" / index
            yield _merge_tables(shared, stated, place), own, place

    def _regions(self, tables: Sequence[Mapping[str, object]], where: Place) -> list[list[CaseRegion]]:
        """The states of each piece: all have a box, `where`, or all have conditions, `when`."""
        places = [where / "piece" / index for index in range(len(tables))]
        if not any("when" in each for each in tables):
            boxes = [self._box(each, place) for each, place in zip(tables, places, strict=True)]
            _ensure_cover(boxes, self.around.variables, where)
            return [[CaseRegion(box, ())] for box in boxes]
        for each, place in zip(tables, places, strict=True):
            if "when" not in each or "where" in each:
                raise InputError("one piece has conditions, so all have them", place, "write when, and no where")
        texts = [text(each["when"], place / "when") for each, place in zip(tables, places, strict=True)]
        if texts.count(OTHERWISE) > 1:
            raise InputError(f"several cases are {OTHERWISE!r}", where, "keep one of them")
        of_states = Names(self.all_units, self.names.meant, self.names.modes)
        stated = [
            None if each == OTHERWISE else conditions(each, of_states, place / "when")
            for each, place in zip(texts, places, strict=True)
        ]
        return case_regions(stated, self.around.variables, where / "piece")

    def _box(self, given: Mapping[str, object], where: Place) -> Box:
        """The box of a piece."""
        return {
            name: interval(bounds, self.bounded[name], self.names, where / "where" / name)
            for name, bounds in self.entries(given, "where", where, self.bounded).items()
        }

    def entries(
        self, given: Mapping[str, object], key: str, where: Place, known: Collection[str]
    ) -> Mapping[str, object]:
        """The entries of a table by the names of variables. UnknownNameError for a name that is none of those known."""
        stated = flat(table(given, key, where), where / key)
        for name in stated:
            if name not in known:
                raise UnknownNameError("variable", name, known, where / key)
        return stated

    def read_lets(self, given: Mapping[str, object], choices: Choices, where: Place) -> Names:
        """The names that texts of a table may use, with those that stand for parts of expressions."""
        meant = dict(self.names.meant)
        lets = table(given, "let", where)
        if len(lets) > MAX_LET:
            raise InputError(f"more than {MAX_LET} names", where / "let", "shorten it")
        for name, value in lets.items():
            if name in self.names.known or name in meant:
                raise InputError(f"'{name}' is named twice", where / "let", "give each a name of its own")
            known = Names(self.names.known, meant, self.names.modes, choices)
            meant[name] = as_typed(value, known, where / "let" / name)
            choices.call(name)
        return Names(self.names.known, meant, self.names.modes, choices)

    def read_next(self, name: str, value: object, known: Names, where: Place) -> Expression:
        """The next value of a variable, which may be a mode."""
        if name in known.modes:
            return mode_of(text(value, where), name, known, self._actions, where)
        return fitting(as_typed(value, known, where), self.units[name], where)

    def read_errors(
        self, given: Mapping[str, object], units: Mapping[str, Unit], known: Names, where: Place
    ) -> dict[str, Interval]:
        """The error of each variable in its unit: a number e for [-e, e], or an interval."""
        errors: dict[str, Interval] = {}
        for name, value in self.entries(given, "error", where, units).items():
            place = where / "error" / name
            if name in known.modes:
                raise InputError("a mode has no error", place, "write choice(.., ..) of modes in next")
            errors[name] = error_of(value, units[name], known, place)
        return {name: bounds for name, bounds in errors.items() if bounds != (0, 0)}


def ensure_few(cases: Sequence[object], where: Place) -> None:
    """InputError for too many rules of one table."""
    if len(cases) > MAX_RULES:
        raise InputError(f"more than {MAX_RULES} cases and choices", where, "choose between fewer values")


def _merge_tables(shared: Mapping[str, object], stated: Mapping[str, object], where: Place) -> dict[str, object]:
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
        states = ", ".join(f"{name} in [{low}, {high}]" for name, (low, high) in (told or gap).items())
        raise InputError(f"pieces leave a gap: {states}", where, "add a piece, or narrow the ranges")


class StepReader(MotionReader):
    """Reads motion in steps."""

    moves = ("next", "let", "A", "B", "c", "error", "cuts")

    def read(self, given: Mapping[str, object], where: Place) -> list[Rule]:
        """The rules of a file: of each piece one for each of its regions and for each value of each choice."""
        only(given, (*self.moves, "piece"), where)
        rules: list[Rule] = []
        setters = set_modes(self.around.agents, self.around.variables)
        for stated, regions, place in self.pieces(given, where):
            moves = self._moves(stated, place)
            error, cuts = self.read_errors(stated, self.units, self.names, place), self._cuts(stated, place)
            anywhere = [
                Rule({}, {**move, **self.around.counted}, effect, error, cuts, (), words, place, following)
                for following, move, effect, words in moves
            ]
            anywhere = [each.of_actions(setters) for each in anywhere]
            own = [replace(each, where=box, when=when) for box, when in regions for each in anywhere]
            ensure_few(own, place)
            rules += own
        return rules

    def _moves(
        self, given: Mapping[str, object], place: Place
    ) -> Sequence[tuple[Mapping[str, Expression], Mapping[str, Expression], Effect, Mapping[str, str]]]:
        """For each way to choose next values over inputs too, those of matrices and their effects, and the choice."""
        if "next" in given:
            for key in ("A", "B", "c"):
                if key in given:
                    raise InputError(f"both next and {key}", place, "write expressions or matrices, not both")
            return [(chosen.next, {}, {}, chosen.words) for chosen in self._next(given, place)]
        if "A" not in given:
            raise InputError("nothing says how the state moves", place, "write next, or A, B and c")
        if self.names.modes:
            raise InputError("matrices do not say what becomes of modes", place / "A", "write next")
        return [({}, self._matrices(given, place), self._effects(table(given, "B", place), place / "B"), {})]

    def _next(self, given: Mapping[str, object], where: Place) -> list[ChosenMotion]:
        """The next values for each way to choose."""
        choices = Choices()
        known = self.read_lets(given, choices, where)
        stated = self.entries(given, "next", where, self.units)
        following: dict[str, Expression] = {}
        for name in self.units:
            if name not in stated:
                what = f"nothing says how {name} moves"
                raise InputError(what, where / "next", f'write {name} = "{name}" if it stays')
            following[name] = self.read_next(name, stated[name], known, where / "next" / name)
            choices.call(name)
        return list(choices.ways(following, where))

    def _cuts(self, given: Mapping[str, object], where: Place) -> dict[str, int]:
        """Into how many parts the range of a variable is cut where something is not affine."""
        stated = self.entries(given, "cuts", where, self.units)
        return {name: count(value, where / "cuts" / name, MAX_CUTS) for name, value in stated.items()}

    # --- matrices

    def _matrices(self, given: Mapping[str, object], where: Place) -> dict[str, Expression]:
        """`A x + c`, with a row for each variable."""
        n = len(self.units)
        rows = as_list(given["A"], where / "A")
        if len(rows) != n:
            what = f"A has {format_count(len(rows), 'row')}, and there are {format_count(n, 'variable')}"
            raise InputError(what, where / "A", "one row for each")
        constant = self._vector(given.get("c", [0] * n), where / "c")
        move: dict[str, Expression] = {}
        for index, (name, row) in enumerate(zip(self.units, rows, strict=True)):
            place = where / "A" / index
            entries = as_list(row, place)
            if len(entries) != n:
                raise InputError(f"a row of {len(entries)}, and there are {n} variables", place, "one entry for each")
            pairs = zip(self.units, entries, strict=True)
            factors = {other: self._entry(value, name, other, place) for other, value in pairs}
            move[name] = of_affine(Affine.of(factors, constant[name]))
        return move

    def _entry(self, value: object, row: str, column: str, where: Place) -> Fraction:
        """A factor; one without a unit has the unit that fits."""
        unit = times(self.units[row], self.units[column], -1)
        return as_constant(value, unit, self.names, where.saying(column))

    def _vector(self, value: object, where: Place) -> dict[str, Fraction]:
        entries = as_list(value, where, len(self.units))
        return {
            name: as_constant(entry, unit, self.names, where.saying(name))
            for (name, unit), entry in zip(self.units.items(), entries, strict=True)
        }

    def _effects(self, given: Mapping[str, object], where: Place) -> Effect:
        """B: agent -> action -> a number for each variable. An action without one adds nothing."""
        acting = {agent.name: agent for agent in self.around.agents}
        only(given, tuple(acting), where, "agent")
        gains: Effect = {}
        for agent, actions in given.items():
            stated = as_table(actions, where / agent)
            only(stated, tuple(acting[agent].actions), where / agent, "action")
            for action, vector in stated.items():
                added = self._vector(vector, where / agent / action)
                gains[agent, action] = {name: of_affine(Affine.of({}, value)) for name, value in added.items() if value}
        return gains


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
