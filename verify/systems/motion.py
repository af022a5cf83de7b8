"""How the state moves, as a world file writes it: expressions or matrices, for all states or in boxes.

Does: reads the table `dynamics`; takes the effects of actions out of expressions.
Assumes: variables and agents are known.
Does not: enclose what is not affine (pieces.py).
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction

from codegen.errors import InputError, UnknownNameError
from codegen.wording import counted
from verify.language.units import Unit, times
from verify.systems.language.expressions import Expression, affine, names, of_affine, replaced, terms, total
from verify.systems.language.parsing import Names, fitting
from verify.systems.regions import left_out, overlapping
from verify.systems.statement import Agent, Rule
from verify.systems.system import Affine, Box, Interval, Variable
from verify.systems.values import (
    ADVICE,
    as_list,
    as_table,
    count,
    flat,
    interval,
    measured,
    only,
    table,
    typed,
)
from verify.toml_places import Place

MOVES = ("next", "let", "A", "B", "c", "error", "cuts")
NAMED = ("next", "error", "cuts")  # tables with an entry for each of some variables
MAX_CUTS, MAX_RULES, MAX_LET = 1_000, 1_000, 100
Effect = dict[tuple[str, str], dict[str, Expression]]


def rules_of(
    given: Mapping[str, object], variables: Sequence[Variable], agents: Sequence[Agent], names: Names, where: Place
) -> tuple[Rule, ...]:
    """The rules of a file. `names`: variables, inputs and constants. InputError where they overlap or leave a gap."""
    only(given, (*MOVES, "piece"), where)
    reader = _Motion(variables, agents, names)
    if "piece" not in given:
        return (reader.rule(given, {}, where),)
    pieces = as_list(given["piece"], where / "piece")
    if not 1 <= len(pieces) <= MAX_RULES:
        raise InputError(f"{len(pieces)} pieces, of 1 to {MAX_RULES}", where, ADVICE)
    shared = {key: value for key, value in given.items() if key != "piece"}
    found: list[Rule] = []
    for index, each in enumerate(pieces):
        place = where / "piece" / index
        stated = as_table(each, place)
        only(stated, (*MOVES, "where"), place)
        found.append(reader.rule(merged(shared, stated, place), reader.box(stated, place), place))
    _ensure_cover(found, variables, where)
    return tuple(found)


def merged(shared: Mapping[str, object], stated: Mapping[str, object], where: Place) -> dict[str, object]:
    """What holds in a piece: what it states itself, and name by name what it leaves to the tables of all pieces. Of A
    and c, which have no names but an entry for each variable, a piece has its own or those of all.
    """
    found = {**shared, **stated}
    for key in (each for each in (*NAMED, "let", "B") if each in found):
        common, own = table(shared, key, where), table(stated, key, where)
        if key in NAMED:
            found[key] = flat(common, where / key) | flat(own, where / key)
        elif key == "B":
            found[key] = {name: {**table(common, name, where), **table(own, name, where)} for name in {**common, **own}}
        else:
            found[key] = {**common, **own}
    return found


def _ensure_cover(rules: Sequence[Rule], variables: Sequence[Variable], where: Place) -> None:
    """InputError where two boxes share more than a border, or the ranges hold states that no box holds."""
    boxes = [rule.where for rule in rules]
    pair = overlapping(boxes)
    if pair is not None:
        what = f"pieces {pair[0] + 1} and {pair[1] + 1} overlap"
        raise InputError(what, where, "pieces may share borders only")
    gap = left_out({variable.name: variable.range for variable in variables}, boxes)
    if gap is not None:
        told = {name: bounds for name, bounds in gap.items() if any(name in box for box in boxes)}
        told = told or gap
        states = ", ".join(f"{name} in [{low}, {high}]" for name, (low, high) in told.items())
        raise InputError(f"pieces leave a gap: {states}", where, "add a piece, or narrow the ranges")


class _Motion:
    """Reads rules."""

    def __init__(self, variables: Sequence[Variable], agents: Sequence[Agent], names: Names) -> None:
        self._variables, self._agents, self._names = [each.name for each in variables], agents, names

    def box(self, given: Mapping[str, object], where: Place) -> Box:
        """The box of a piece."""
        return {
            name: interval(bounds, self._unit(name, where / "where"), self._names, where / "where" / name)
            for name, bounds in flat(table(given, "where", where), where / "where").items()
        }

    def _unit(self, name: str, where: Place) -> Unit:
        if name not in self._variables:
            raise UnknownNameError("variable", name, self._variables, where)
        return self._names.known[name]

    def rule(self, given: Mapping[str, object], where: Box, place: Place) -> Rule:
        """One rule."""
        if "next" in given:
            for key in ("A", "B", "c"):
                if key in given:
                    raise InputError(f"both next and {key}", place, "write expressions or matrices, not both")
            move, effect = self._separated(self._next(given, place), place)
        elif "A" in given:
            move, effect = self._matrices(given, place)
        else:
            raise InputError("nothing says how the state moves", place, "write next, or A, B and c")
        return Rule(where, move, effect, self._errors(given, place), self._cuts(given, place))

    # --- expressions

    def _next(self, given: Mapping[str, object], where: Place) -> dict[str, Expression]:
        """The next value of each variable."""
        meant = dict(self._names.meant)
        lets = table(given, "let", where)
        if len(lets) > MAX_LET:
            raise InputError(f"more than {MAX_LET} names", where / "let", "shorten it")
        for name, value in lets.items():
            if name in self._names.known or name in meant:
                raise InputError(f"'{name}' is named twice", where / "let", "give each a name of its own")
            meant[name] = typed(value, Names(self._names.known, meant), where / "let" / name)
        stated = flat(table(given, "next", where), where / "next")
        for name in stated:
            self._unit(name, where / "next")
        named = Names(self._names.known, meant)
        return {name: self._one(stated, name, named, where / "next") for name in self._variables}

    def _one(self, stated: Mapping[str, object], name: str, named: Names, where: Place) -> Expression:
        if name not in stated:
            raise InputError(f"nothing says how {name} moves", where, f'write {name} = "{name}" if it stays')
        return fitting(typed(stated[name], named, where / name), self._names.known[name], where / name)

    def _separated(self, found: Mapping[str, Expression], where: Place) -> tuple[dict[str, Expression], Effect]:
        """What holds for all actions, and what each action adds."""
        move: dict[str, Expression] = {}
        effect: Effect = {}
        for name, expression in found.items():
            own, acted = self._shares(expression, where / "next" / name)
            move[name] = total(own)
            for agent in self._agents:
                for action, values in agent.actions.items():
                    if acted.get(agent.name):
                        added = replaced(total(acted[agent.name]), values)
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
            what = f"A has {counted(len(rows), 'row')}, and there are {counted(n, 'variable')}"
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
        return measured(value, unit, self._names, where.saying(column))

    def _vector(self, value: object, where: Place) -> dict[str, Fraction]:
        entries = as_list(value, where, len(self._variables))
        return {
            name: measured(entry, self._names.known[name], self._names, where.saying(name))
            for name, entry in zip(self._variables, entries, strict=True)
        }

    def _effects(self, given: Mapping[str, object], where: Place) -> Effect:
        """B: agent -> action -> a number for each variable. An action without one adds nothing."""
        acting = {agent.name: agent for agent in self._agents}
        only(given, tuple(acting), where, "agent")
        found: Effect = {}
        for agent, actions in given.items():
            stated = as_table(actions, where / agent)
            only(stated, tuple(acting[agent].actions), where / agent, "action")
            for action, vector in stated.items():
                added = self._vector(vector, where / agent / action)
                found[agent, action] = {name: of_affine(Affine.of({}, value)) for name, value in added.items() if value}
        return found

    # --- errors and cuts

    def _errors(self, given: Mapping[str, object], where: Place) -> dict[str, Interval]:
        """The error of each variable: a number e for [-e, e], or an interval."""
        found: dict[str, Interval] = {}
        for name, value in flat(table(given, "error", where), where / "error").items():
            place = where / "error" / name
            unit = self._unit(name, where / "error")
            low, high = interval(value, unit, self._names, place)
            if not isinstance(value, list):
                if high < 0:
                    raise InputError(f"the error {high} is below 0", place, "write e for [-e, e], or [low, high]")
                low = -high
            found[name] = low, high
        return {name: bounds for name, bounds in found.items() if bounds != (0, 0)}

    def _cuts(self, given: Mapping[str, object], where: Place) -> dict[str, int]:
        """Into how many parts the range of a variable is cut where something is not affine."""
        found: dict[str, int] = {}
        for name, value in flat(table(given, "cuts", where), where / "cuts").items():
            self._unit(name, where / "cuts")
            found[name] = count(value, where / "cuts" / name, MAX_CUTS)
        return found
