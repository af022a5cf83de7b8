"""The formulas that users' texts state.

Does: coordinates, distances, comparisons, actions, named predicates, not / and / or / implies; units, where those of
  the coordinates are known; of a decimal beside a feature, the float that it is read as.
Assumes: the names that a text may use are given; every other number is exact.
Does not: parse (verify.language), run anything that a text holds, or know files (files.py).

A text that states no unit, and names no constant, is read in numbers alone. Else all of its units must fit.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import NamedTuple, Protocol

from codegen.errors import InputError
from codegen.floats import WHOLE
from codegen.ir import GOAL, AgentPolicy
from codegen.numbers import nearest_number
from verify.claims import decisions
from verify.claims.formula import FALSE, TRUE, Acts, Condition, Formula, Goal, conjunction, disjunction, negate
from verify.claims.terms import (
    CoordinateSum,
    compare_sums,
    constant,
    coordinate,
    distance,
    find_single_name,
    largest,
    list_conditions,
    spell,
    spell_unlike,
    strip_signs,
)
from verify.claims.views import UNLIKE
from verify.language.parser import (
    ACTS,
    BARS,
    CallNode,
    Joined,
    Level,
    Limits,
    Listed,
    NameNode,
    Node,
    NumberNode,
    Prefixed,
    Source,
    Token,
    parse,
)
from verify.language.units import BY_EQUALITY, Arithmetic, Modes, Typed, Unit, is_compared, resolve_modes

LIMITS = Limits(characters=100_000, depth=41)  # 40 levels, and a predicate within
EXTREMES = ("abs", "max", "min")
PREDICATES = ("closes", "engaged", "at")
EXACT = "exact"  # of a decimal that means itself, and no float
FUNCTIONS = (ACTS, *PREDICATES, "distance", *EXTREMES, EXACT)
WORDS = ("not", "and", "or", "implies", "in", "true", "false")
TRUTHS = {"true": TRUE, "false": FALSE}


@dataclass(frozen=True)
class Vocabulary:
    """The names that a text may use, and the default parameters of its predicates."""

    coordinates: tuple[str, ...]  # those that a region bounds, and the goal's
    agents: Mapping[str, AgentPolicy]  # whose actions may be spoken of
    entities: tuple[str, ...] = ()  # agents, landmarks, and the goal where there is one
    goals: tuple[str, ...] = ()
    margin: Fraction = Fraction(0)
    radius: Fraction = Fraction(0)
    units: Mapping[str, Unit] = field(default_factory=dict[str, Unit])  # of coordinates; empty: they have none
    constants: Mapping[str, Typed[Fraction]] = field(default_factory=dict[str, Typed[Fraction]])
    modes: Modes = field(default_factory=dict[str, tuple[str, ...]])  # of coordinates that are modes
    curves: "CurveReader | None" = None  # what is not linear; None: that is refused
    observed: Mapping[str, str] = field(default_factory=dict[str, str])  # feature -> its numbers; UNLIKE: of two types


class CurveReader(Protocol):
    """Reads what is not linear as coordinates of their own."""

    def is_curve(self, node: Node) -> bool:
        """Returns True if a tree states something that is not linear."""
        ...

    def coordinate(self, source: Source, node: Node) -> tuple[str, Unit | None, Token | None]:
        """The name and the unit of the coordinate that stands for it, and the first number in it with a unit."""
        ...


class StatedFormula(NamedTuple):
    """The statement of a text."""

    formula: Formula
    conditions: tuple[Condition, ...]  # the left sides of its implications
    rounded: Mapping[str, str]  # decimals as they are written -> the floats that they mean, where these differ

    def read_by(self, reading: Callable[[Formula], Formula]) -> "StatedFormula":
        """The same where formulas mean something else than they say."""
        conditions = tuple(Condition(words, reading(each)) for words, each in self.conditions)
        return StatedFormula(reading(self.formula), conditions, self.rounded)


def formula_of(text: str, vocabulary: Vocabulary, where: Callable[[int], str]) -> Formula:
    """The formula that a text states. InputError that shows the first fault, and the closest known name."""
    return read_statement(text, vocabulary, where).formula


def read_statement(text: str, vocabulary: Vocabulary, where: Callable[[int], str]) -> StatedFormula:
    """The formula that a text states, with what it depends on. InputError as of `formula_of`."""
    source = Source(text, where)
    reader, tree = _Formulas(source, vocabulary), parse(source, LIMITS)

    def claim(node: Node) -> Formula:
        return reader.claim(resolve_modes(source, node, vocabulary.modes))

    formula, sums = claim(tree), reader.sums
    if sums.measured is not None and not vocabulary.units:
        advice = "write the number alone: only a world file states the units of what it names"
        raise source.wrong("nothing here has a unit that is known", sums.measured.place, advice)
    if sums.measured is not None and sums.misfits:
        raise sums.misfits[0]
    conditions = tuple(
        Condition(" and ".join(map(spell, nodes)), conjunction(*map(claim, nodes))) for nodes in list_conditions(tree)
    )
    return StatedFormula(formula, conditions, dict(reader.rounded))


class _Sums(Arithmetic[CoordinateSum]):
    """The linear sums of a text."""

    def __init__(self, source: Source, known: Vocabulary) -> None:
        super().__init__(source)
        self._known = known

    def evaluate_node(self, node: Node) -> Typed[CoordinateSum]:
        """The value of a tree; a curve is a coordinate."""
        curves = self._known.curves
        if curves is None or not curves.is_curve(node):
            return super().evaluate_node(node)
        name, unit, measured = curves.coordinate(self.source, node)
        self.measured = self.measured or measured
        return Typed(coordinate(name), unit)

    def constant(self, number: Fraction) -> CoordinateSum:
        return constant(number)

    def negative(self, value: CoordinateSum, sign: Token | None = None) -> CoordinateSum:
        return value.times(Fraction(-1))

    def combine(self, left: CoordinateSum, sign: Token, right: CoordinateSum) -> CoordinateSum:
        if sign.text == "+":
            return left + right
        if sign.text == "/" and right.is_constant and not right.offset:
            raise self.source.wrong("division by zero", sign.place)
        if right.is_constant:
            return self._scale_sum(left, right.offset if sign.text == "*" else 1 / right.offset, sign)
        if sign.text == "*" and left.is_constant:
            return self._scale_sum(right, left.offset, sign)
        what = "only linear arithmetic can be decided"
        advice = "claims about games are linear: multiply by numbers only; a world file may multiply"
        raise self.source.wrong(what, sign.place, advice)

    def power(self, base: CoordinateSum, sign: Token, exponent: int) -> CoordinateSum:
        power = base
        for _ in range(exponent - 1):
            power = self.combine(power, sign._replace(text="*"), base)
        return power

    def _scale_sum(self, value: CoordinateSum, factor: Fraction, sign: Token) -> CoordinateSum:
        try:
            return value.times(factor)
        except OverflowError as error:
            raise self.source.wrong(str(error), sign.place, "simplify the formula") from None

    def resolve_name(self, name: Token) -> Typed[CoordinateSum]:
        known = self._known
        if name.text in TRUTHS:
            raise self.make_node_error(NameNode(name))
        if name.text in known.constants:
            self.measured = self.measured or name
            number, unit = known.constants[name.text]
            return Typed(constant(number), unit)
        if name.text in known.modes and not is_compared(name):
            raise self.source.wrong(f"{name.text} is a mode, and no number", name.place, BY_EQUALITY)
        if name.text in known.coordinates:
            return Typed(coordinate(name.text), known.units.get(name.text))
        if name.text in known.entities:
            advice = f"write {name.text}.x, or distance(a, b)"
            raise self.source.wrong(f"{name.text} is no number", name.place, advice)
        if "." in name.text:
            raise self.source.unknown("coordinate", name, known.coordinates)
        raise self.source.unknown("name", name, (*FUNCTIONS, *known.entities, *known.coordinates, *known.constants))

    def resolve_call(self, call: CallNode) -> Typed[CoordinateSum]:
        function = call.token
        if function.text == "distance":
            a, b = resolve_names(self.source, call, ("entity", self._known.entities), ("entity", self._known.entities))
            return Typed(distance(a, b), None)
        if function.text in (ACTS, *PREDICATES):
            raise self.make_node_error(call)
        if function.text == EXACT:
            return self._exactly(call)
        if function.text not in (*EXTREMES, BARS):
            raise self.source.unknown("function", function, FUNCTIONS)
        single = function.text in ("abs", BARS)
        if single and len(call.arguments) != 1:
            raise self.source.wrong("abs has one argument", function.place, "write max(..) for the largest of several")
        first, *others = [self._plain(each) for each in call.arguments]
        unit = first.unit
        for other in others:
            unit = self.same(Typed(first.value, unit), other, function)
        sums = [first.value, self.negative(first.value)] if single else [first.value, *(one.value for one in others)]
        if function.text != "min":
            return Typed(largest(sums), unit)
        return Typed(self.negative(largest([self.negative(each) for each in sums])), unit)

    def _exactly(self, call: CallNode) -> Typed[CoordinateSum]:
        given = [self.evaluate_node(each) for each in call.arguments]
        if len(given) != 1 or not given[0].value.is_constant:
            raise self.source.wrong("exact is said of one number", call.token.place, "write such as exact(0.1)")
        return given[0]

    def _plain(self, node: Node) -> Typed[CoordinateSum]:
        typed = self.evaluate_node(node)
        if typed.value.maxima:
            what = "absolute values, distances, max and min do not nest"
            raise self.source.wrong(what, node.token.place, "split the formula")
        return typed

    def make_node_error(self, node: Node) -> InputError:
        action = isinstance(node, CallNode) and node.token.text == ACTS
        what = f"{'an action' if action else 'a claim'} is no number"
        return self.source.wrong(what, node.token.place, "join claims by and, or, implies")


def resolve_names(source: Source, call: CallNode, *kinds: tuple[str, Sequence[str]]) -> list[str]:
    """The names that are the first arguments of a call: each of a kind, and one of those that are known."""
    if len(call.arguments) < len(kinds):
        what = f"{call.token.text} needs {len(kinds)} names"
        raise source.wrong(what, call.token.place, " and then ".join(f"an {kind}" for kind, _ in kinds))
    for argument, (kind, known) in zip(call.arguments, kinds, strict=False):
        if not isinstance(argument, NameNode) or argument.token.text not in known:
            raise source.unknown(kind, argument.token, known)
    return [argument.token.text for argument, _ in zip(call.arguments, kinds, strict=False)]


class _Formulas:
    """The claims of a text."""

    def __init__(self, source: Source, known: Vocabulary) -> None:
        self._source, self._known = source, known
        self.sums = _Sums(source, known)
        self.rounded: dict[str, str] = {}  # decimals -> the floats that they mean

    def claim(self, node: Node) -> Formula:
        """The formula of a tree."""
        match node:
            case Joined(_, Level.IMPLIES, first, ((_, then),)):
                return disjunction(negate(self.claim(first)), self.claim(then))
            case Joined(_, Level.OR | Level.AND as level, first, rest):
                join = disjunction if level is Level.OR else conjunction
                return join(self.claim(first), *(self.claim(other) for _, other in rest))
            case Joined(_, Level.RELATION, first, rest):
                sides = [first, *(other for _, other in rest)]
                signs = [sign for sign, _ in rest]
                return conjunction(*map(self._relate_nodes, sides, signs, sides[1:]))
            case Prefixed(_, signs, inside) if "not" in signs:
                claim = self.claim(inside)
                return negate(claim) if len(signs) % 2 else claim
            case Listed():  # `acts(agent) in [a, b]`, or `not in`
                if not _is_action(node.value):
                    raise self._source.wrong("only actions are listed", node.token.place, "write acts(AGENT) in [a, b]")
                formula = disjunction(*(self._takes(node.value, name) for name in node.names))
                return negate(formula) if node.denied else formula
            case NameNode(token) if token.text in TRUTHS:
                return TRUTHS[token.text]
            case NameNode(token) if token.text not in (*self._known.coordinates, *self._known.constants):
                raise self._source.unknown("word", token, (*FUNCTIONS, *WORDS, *self._known.entities))
            case CallNode(token, _) if token.text in PREDICATES:
                return self._predicate(node)
            case CallNode(token, _) if token.text == ACTS:
                what, advice = "an action is no claim", f"write acts({self._actor(node)}) == ACTION"
                raise self._source.wrong(what, token.place, advice)
            case _:
                self.sums.evaluate_node(node)
                what = "a number is no claim"
                raise self._source.wrong(what, node.token.place, "compare it: <, <=, >, >=, == or !=")

    # --- relations

    def _relate_nodes(self, left: Node, sign: Token, right: Node) -> Formula:
        acting = [_is_action(left), _is_action(right)]
        named = [isinstance(side, NameNode) for side in (left, right)]
        words = [self._is_word(left), self._is_word(right)]
        if not ((any(acting) and all(a or n for a, n in zip(acting, named, strict=True))) or all(words)):
            one, other = self._evaluate_side(left, right), self._evaluate_side(right, left)
            self.sums.same(one, other, sign)
            try:
                return compare_sums(one.value, sign.text, other.value)
            except OverflowError as error:
                raise self._source.wrong(str(error), sign.place, "simplify the formula") from None
        if sign.text not in ("==", "!="):
            what = f"names are not ordered by {sign.text}"
            raise self._source.wrong(what, sign.place, "write ==, != or a coordinate")
        same = self._same(left, right, sign)
        return same if sign.text == "==" else negate(same)

    def _is_word(self, node: Node) -> bool:
        """Returns True if a tree is the name of something that is no number."""
        if not isinstance(node, NameNode):
            return False
        known = (*self._known.coordinates, *self._known.constants, *TRUTHS)
        return node.token.text not in known and "." not in node.token.text

    def _evaluate_side(self, node: Node, other: Node) -> Typed[CoordinateSum]:
        """One side of a comparison: beside a feature, a number is the float that it is read as."""
        typed, numbers = self.sums.evaluate_node(node), self._known.observed.get(find_single_name(other))
        if numbers is None or numbers in WHOLE or not isinstance(strip_signs(node), NumberNode):
            return typed
        if numbers == UNLIKE:
            what = f"agents observe {find_single_name(other)} in unlike types"
            raise self._source.wrong(what, node.token.place, f"write exact({spell(strip_signs(node))})")
        exact, near = typed.value.offset, nearest_number(typed.value.offset, numbers)
        if Fraction(near) != exact:
            self.rounded[spell(node)] = spell_unlike(near, exact, numbers)
        return typed._replace(value=constant(Fraction(near)))

    def _same(self, left: Node, right: Node, sign: Token) -> Formula:
        """That two agents act alike, that an agent takes an action, or which landmark the goal is."""
        if _is_action(left) and _is_action(right):
            a, b = (self._known.agents[self._actor(side)] for side in (left, right))
            shared = [action for action in _list_taken(a) if action in _list_taken(b)]
            return disjunction(*(conjunction(_acts(a, name), _acts(b, name)) for name in shared))
        if _is_action(left) or _is_action(right):
            acting, name = (left, right) if _is_action(left) else (right, left)
            return self._takes(acting, name.token)
        if GOAL not in (left.token.text, right.token.text):
            advice = "compare coordinates, or distance(a, b) == 0"
            raise self._source.wrong("only the goal is compared by name", sign.place, advice)
        landmark = right.token if left.token.text == GOAL else left.token
        if not self._known.goals:
            raise self._source.wrong("this world has no goal", sign.place)
        if landmark.text not in self._known.goals:
            raise self._source.unknown("landmark", landmark, self._known.goals)
        return Goal(landmark.text)

    # --- actions

    def _actor(self, call: Node) -> str:
        """The agent of `acts(agent)`."""
        assert isinstance(call, CallNode)
        if len(call.arguments) > 1:
            raise self._source.wrong("acts has one agent", call.token.place, "write acts(AGENT) == ACTION")
        return resolve_names(self._source, call, ("agent", tuple(self._known.agents)))[0]

    def _takes(self, acting: Node, name: Token) -> Formula:
        policy = self._known.agents[self._actor(acting)]
        known = _list_taken(policy)
        if name.text not in known:
            raise self._source.unknown(f"action of {policy.agent}", name, known)
        return _acts(policy, name.text)

    # --- predicates

    def _predicate(self, call: CallNode) -> Formula:
        """closes, engaged or at, of an agent (for `at`: any entity) and an entity, with a bound of its own or not."""
        known, near = self._known, call.token.text == "at"
        first = ("entity", known.entities) if near else ("agent", tuple(known.agents))
        agent, target = resolve_names(self._source, call, first, ("entity", known.entities))
        if target == agent:
            raise self._source.wrong(f"{agent} is always at itself", call.arguments[1].token.place, "name two")
        bound = self._evaluate_bound(call)
        if near:
            return decisions.at(agent, target, known.radius if bound is None else bound)
        closing = decisions.closing(known.agents[agent], target, known.margin if bound is None else bound)
        near_it = decisions.at(agent, target, known.radius)
        return closing if call.token.text == "closes" else disjunction(closing, near_it)

    def _evaluate_bound(self, call: CallNode) -> Fraction | None:
        if len(call.arguments) < 3:
            return None
        given = self.sums.evaluate_node(call.arguments[2]).value
        if len(call.arguments) > 3 or not given.is_constant or given.offset < 0:
            what = "the bound must be a number that is not negative"
            raise self._source.wrong(what, call.arguments[-1].token.place)
        return given.offset


def _is_action(node: Node) -> bool:
    return isinstance(node, CallNode) and node.token.text == ACTS


def _list_taken(policy: AgentPolicy) -> list[str]:
    return [action.name for action in policy.actions if not action.acts]


def _acts(policy: AgentPolicy, action: str) -> Formula:
    """The agent takes an action, whatever becomes of its memory."""
    places = [place for place, spec in enumerate(policy.actions) if action in (spec.name, spec.acts)]
    return disjunction(*(Acts(policy.agent, place) for place in places))
