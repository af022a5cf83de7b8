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

from codegen.errors import InputError, UnknownNameError
from codegen.wording import format_count
from verify.language.units import Unit, times
from verify.systems.cases import OTHERWISE, CaseRegion, Conditions, Part, case_regions, split_regions
from verify.systems.expressions import (
    ZERO,
    Call,
    Expression,
    Name,
    Number,
    Product,
    Sum,
    affine,
    names,
    of_affine,
    parts,
    replace_part,
    total,
)
from verify.systems.parsing import (
    CASE,
    Choices,
    Names,
    conditions,
    fitting,
    input_of,
    mode_of,
)
from verify.systems.statement import Agent, Effect, Rule, set_modes
from verify.systems.system import (
    Affine,
    Box,
    HalfSpace,
    Interval,
    Variable,
    find_gap,
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
MAX_CUTS, MAX_RULES, MAX_LET, MAX_CLIPS = 1_000, 1_000, 100, 4


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
        self.tested = self.all_units  # ... and its conditions

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
            boxes: list[Box] = []
            for each, place in zip(tables, places, strict=True):
                ends = self.entries(each, "where", place, self.bounded).items()
                at = place / "where"
                boxes.append({x: interval(end, self.bounded[x], self.names, at / x) for x, end in ends})
            if (pair := overlapping(boxes)) is not None:
                what = f"pieces {pair[0] + 1} and {pair[1] + 1} overlap"
                raise InputError(what, where, "pieces may share borders only")
            ranges = {variable.name: variable.range for variable in self.around.variables}
            if (gap := find_gap(ranges, boxes)) is not None:
                told = {name: bounds for name, bounds in gap.items() if any(name in box for box in boxes)}
                states = ", ".join(f"{name} in [{low}, {high}]" for name, (low, high) in (told or gap).items())
                raise InputError(f"pieces leave a gap: {states}", where, "add a piece, or narrow the ranges")
            return [[CaseRegion(box, ())] for box in boxes]
        for each, place in zip(tables, places, strict=True):
            if "when" not in each or "where" in each:
                raise InputError("one piece has conditions, so all have them", place, "write when, and no where")
        texts = [text(each["when"], place / "when") for each, place in zip(tables, places, strict=True)]
        if texts.count(OTHERWISE) > 1:
            raise InputError(f"several cases are {OTHERWISE!r}", where, "keep one of them")
        of_states = Names(self.tested, self.names.meant, self.names.modes)
        stated = [
            None if each == OTHERWISE else conditions(each, of_states, place / "when")
            for each, place in zip(texts, places, strict=True)
        ]
        return self.regions_of(stated, where / "piece")

    def regions_of(self, stated: Conditions, where: Place) -> list[list[CaseRegion]]:
        """The regions of each case."""
        return case_regions(stated, self.around.variables, where)

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
            unsaid = {
                agent.name: [action for action, sets in agent.actions.items() if input_of(agent.name, name) not in sets]
                for agent in self.around.agents
            }
            return mode_of(text(value, where), name, known, unsaid, where)
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


class StepReader(MotionReader):
    """Reads motion in steps."""

    moves = ("next", "let", "A", "B", "c", "error", "cuts")

    def __init__(self, around: Around) -> None:
        super().__init__(around)
        self._acting = [agent for agent in around.agents if not agent.outputs]
        inputs = {name for agent in self._acting for name in agent.inputs} & self.names.known.keys()
        self.tested = {**self.all_units, **{name: self.names.known[name] for name in inputs}}
        self._parts: list[tuple[Agent, Part]] = []  # of cases that an agent's action chooses between
        self._inputs: dict[tuple[str, frozenset[str]], str] = {}  # by agent and the actions that set one to 1

    def read(self, given: Mapping[str, object], where: Place) -> tuple[tuple[Rule, ...], tuple[Agent, ...]]:
        """The rules of a file: of each piece one for each of its regions and for each value of each choice. The agents
        say which cases their actions take, too.
        """
        only(given, (*self.moves, "piece"), where)
        rules: list[Rule] = []
        cases: list[list[Rule]] = []
        for stated, regions, place in self.pieces(given, where):
            moves = self._moves(stated, place)
            error = self.read_errors(stated, self.units, self.names, place)
            cut = self.entries(stated, "cuts", place, self.units)  # into how many parts where something is not affine
            cuts = {name: count(value, place / "cuts" / name, MAX_CUTS) for name, value in cut.items()}
            cases.append([])
            for following, move, effect, words in moves:
                moved = {**move, **self.around.counted}
                cases[-1].append(Rule({}, moved, effect, error, cuts, (), words, place, following))
            own = [replace(each, where=box, when=when) for box, when in regions for each in cases[-1]]
            ensure_few(own, place)
            rules += own
        rules += [self._join(agent, part, cases, where) for agent, part in self._parts]
        rules = [each for rule in rules for each in self._split_clips(rule)]
        ensure_few(rules, where)
        agents = tuple(map(self._with_cases, self.around.agents))
        setters = set_modes(agents, self.around.variables)
        return tuple(each.of_actions(setters) for each in rules), agents

    # --- cases that actions choose between

    def regions_of(self, stated: Conditions, where: Place) -> list[list[CaseRegion]]:
        """The regions of each case; where conditions name what an agent sets, they are parts, which several cases
        share.
        """
        named = {name for each in stated for region in each or () for half in region for name, _ in half.form.terms}
        acting = [agent for agent in self._acting if agent.inputs & named]
        if not acting:
            return super().regions_of(stated, where)
        if len(acting) > 1:
            what = f"cases name what {' and '.join(each.name for each in acting)} set"
            raise InputError(what, where, "cases depend on the action of one agent")
        parts = split_regions(CaseRegion({}, ()), stated, acting[0], self.around.variables, where)
        for number in range(len(stated)):
            if not any(number in part.taken.values() for part in parts):
                raise InputError(f"case {number + 1} holds no state of the ranges", where / number, "remove it")
        self._parts = [(acting[0], part) for part in parts if len({*part.taken.values()}) > 1]
        return [[part.region for part in parts if {*part.taken.values()} == {number}] for number in range(len(stated))]

    def _join(self, agent: Agent, part: Part, cases: Sequence[Sequence[Rule]], where: Place) -> Rule:
        """The rule of a part in which actions take several cases. InputError where it would depend on more."""
        taken = sorted({*part.taken.values()})
        first, place = cases[taken[0]][0], where / "piece" / taken[-1]
        own = [cases[each] for each in taken]
        if any(len(each) > 1 or not each[0].next or each[0].error != first.error for each in own):
            what = "an action chooses between cases with choices, matrices or other errors"
            raise InputError(what, place, "write cases by next, with one error and no choice(..)")
        joined: dict[str, Expression] = {}
        for name in first.next:
            joined[name] = self._take(agent, part.taken, {each: cases[each][0].next[name] for each in taken})
        cuts: dict[str, int] = {}
        for (rule,) in own:
            cuts |= {name: max(count, cuts.get(name, 1)) for name, count in rule.cuts.items()}
        return replace(first, where=part.region.where, when=part.region.when, next=joined, cuts=cuts)

    def _take(self, agent: Agent, taken: Mapping[str, int], values: Mapping[int, Expression]) -> Expression:
        """The value of the case that an action takes: a sum over cases, each times an input that is 1 or 0."""
        first, *others = values.values()
        if all(each == first for each in others):
            return first
        terms: list[Expression] = []
        for number, value in values.items():
            key = agent.name, frozenset(action for action, each in taken.items() if each == number)
            name = self._inputs.setdefault(key, f"{agent.name}{CASE}{len(self._inputs) + 1}")
            terms.append(Product(Name(name), value))
        return total(terms)

    def _with_cases(self, agent: Agent) -> Agent:
        """The agent, whose actions say which cases they take."""
        actions = {action: dict(values) for action, values in agent.actions.items()}
        for (owner, ones), name in self._inputs.items():
            for action, values in actions.items() if owner == agent.name else ():
                values[name] = Number(Fraction(action in ones))
        return replace(agent, actions=actions)

    def _split_clips(self, rule: Rule) -> list[Rule]:
        """The rules of the parts in which what an action sets is at an end of a clip, or between its ends."""
        clips = {call: agent for each in rule.next.values() for call, agent in self._find_clips(each)}
        if not clips or len(clips) > MAX_CLIPS:  # more are left to enclosures
            return [rule]
        call, agent = next(iter(clips.items()))
        form, (low, high) = affine(call.argument) or Affine(), call.bounds or (ZERO, ZERO)
        below, above = form.plus(Affine((), -low)), Affine((), high).plus(form, Fraction(-1))
        inside = HalfSpace(Affine().plus(below, Fraction(-1))), HalfSpace(Affine().plus(above, Fraction(-1)))
        ends = [[(HalfSpace(below, True),)], [inside], [(HalfSpace(above, True),)]]
        values = {0: Number(low), 1: call.argument, 2: Number(high)}
        rules: list[Rule] = []
        for part in split_regions(CaseRegion(rule.where, rule.when), ends, agent, self.around.variables, rule.place):
            cut = self._take(agent, part.taken, {each: values[each] for each in sorted({*part.taken.values()})})
            following = {name: replace_part(each, call, cut) for name, each in rule.next.items()}
            rules += self._split_clips(replace(rule, where=part.region.where, when=part.region.when, next=following))
        return rules

    def _find_clips(self, expression: Expression) -> Iterator[tuple[Call, Agent]]:
        """The clips of sums of variables and of what one agent's action sets, inner ones first."""
        for part in parts(expression):
            yield from self._find_clips(part)
        if isinstance(expression, Call) and expression.bounds and affine(expression.argument) is not None:
            acting = [agent for agent in self._acting if agent.inputs & names(expression.argument)]
            if len(acting) == 1:
                yield expression, acting[0]

    def _moves(
        self, given: Mapping[str, object], place: Place
    ) -> Sequence[tuple[Mapping[str, Expression], Mapping[str, Expression], Effect, Mapping[str, str]]]:
        """For each way to choose next values over inputs too, those of matrices and their effects, and the choice."""
        if "next" in given:
            for key in ("A", "B", "c"):
                if key in given:
                    raise InputError(f"both next and {key}", place, "write expressions or matrices, not both")
            choices = Choices()
            known = self.read_lets(given, choices, place)
            stated = self.entries(given, "next", place, self.units)
            following: dict[str, Expression] = {}
            for name in self.units:
                if name not in stated:
                    what = f"nothing says how {name} moves"
                    raise InputError(what, place / "next", f'write {name} = "{name}" if it stays')
                following[name] = self.read_next(name, stated[name], known, place / "next" / name)
                choices.call(name)
            return [(chosen.next, {}, {}, chosen.words) for chosen in choices.ways(following, place)]
        if "A" not in given:
            raise InputError("nothing says how the state moves", place, "write next, or A, B and c")
        if self.names.modes:
            raise InputError("matrices do not say what becomes of modes", place / "A", "write next")
        move = self._matrices(given, place)
        # B: agent -> action -> a number for each variable. An action without one adds nothing.
        gained, where = table(given, "B", place), place / "B"
        acting = {agent.name: agent for agent in self.around.agents}
        only(gained, tuple(acting), where, "agent")
        gains: Effect = {}
        for agent, actions in gained.items():
            vectors = as_table(actions, where / agent)
            only(vectors, tuple(acting[agent].actions), where / agent, "action")
            for action, vector in vectors.items():
                added = self._vector(vector, where / agent / action)
                gains[agent, action] = {name: of_affine(Affine.of({}, value)) for name, value in added.items() if value}
        return [({}, move, gains, {})]

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
