"""The language of claims that users write: text in, a formula out, by a parser of our own.

Does: numbers, coordinates, distances, comparisons, actions, named predicates, not / and / or / implies, parentheses.
Assumes: the names that a text may use are given; every number is exact.
Does not: run anything that a text holds, or know files (files.py).

    claim      = either [ "implies" claim ]
    either     = both { "or" both }          both = denied { "and" denied }
    denied     = "not" denied | relation
    relation   = sum { ("<" | "<=" | ">" | ">=" | "==" | "!=") sum } | action | "goal" ("==" | "!=") landmark
    action     = "acts(" agent ")" ( ("==" | "!=") name | [ "not" ] "in" "[" name { "," name } "]" )
    sum        = product { ("+" | "-") product }          product = signed { ("*" | "/") signed }
    signed     = [ "-" ] signed | number | coordinate | "|" sum "|" | "(" claim ")" | call
    call       = "distance(" entity "," entity ")" | ("abs" | "max" | "min") "(" sum { "," sum } ")"
               | ("closes" | "engaged" | "at") "(" agent "," entity [ "," number ] ")"
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple, TypeAlias, TypeVar

from codegen.errors import InputError, UnknownNameError
from codegen.ir import GOAL, AgentPolicy
from verify.claims import predicates
from verify.claims.formula import FALSE, TRUE, Acts, Formula, Goal, conjunction, disjunction, negated
from verify.claims.language.lexer import HINTS, Token, Where, tokens
from verify.claims.language.sums import Sum, compared, constant, coordinate, distance, largest
from verify.claims.region import exact

MAX_DEPTH = 40  # of parentheses, negations and chains of `implies`
RELATIONS = ("<=", ">=", "==", "!=", "<", ">")
FUNCTIONS = ("acts", "closes", "engaged", "at", "distance", "abs", "max", "min")
WORDS = ("not", "and", "or", "implies", "in", "true", "false")


@dataclass(frozen=True)
class Vocabulary:
    """What a text may speak of, and the default parameters of its predicates."""

    coordinates: tuple[str, ...]  # those that a region bounds, and the goal's
    agents: Mapping[str, AgentPolicy]  # whose actions may be spoken of
    entities: tuple[str, ...]  # agents, landmarks, and the goal where there is one
    goals: tuple[str, ...]
    margin: Fraction
    radius: Fraction


class Name(NamedTuple):
    """A word that names an entity or an action; what it means shows in what stands beside it."""

    token: Token


class Action(NamedTuple):
    """`acts(agent)`, before it is compared."""

    agent: str


Made = TypeVar("Made")
Value: TypeAlias = Sum | Formula | Name | Action


def parse(text: str, vocabulary: Vocabulary, where: Where) -> Formula:
    """The formula that a text states. InputError with the place of the first fault, and the closest known name."""
    return _Parser(tokens(text, where), vocabulary, where).whole()


class _Parser:
    def __init__(self, tokens: Sequence[Token], vocabulary: Vocabulary, where: Where) -> None:
        self._tokens, self._next, self._depth = tokens, 0, 0
        self._known, self._where = vocabulary, where

    # --- tokens

    @property
    def _here(self) -> Token:
        return self._tokens[self._next]

    def _take(self) -> Token:
        token = self._here
        self._next += token.kind != "end"
        return token

    def _takes(self, *texts: str) -> Token | None:
        """The next token, if it is a mark or word of these."""
        return self._take() if self._here.kind != "number" and self._here.text in texts and self._here.text else None

    def _need(self, text: str, after: str) -> None:
        if self._takes(text) is None:
            raise self._wrong(f"expected {text!r} {after}, not {self._here.text or 'the end'!r}", self._here)

    def _wrong(self, what: str, token: Token, advice: str = "") -> InputError:
        return InputError(what, self._where(token.place), advice or HINTS.get(token.text, ""))

    def _unknown(self, kind: str, token: Token, known: Sequence[str]) -> UnknownNameError:
        return UnknownNameError(kind, token.text, known, self._where(token.place))

    # --- claims

    def whole(self) -> Formula:
        """The formula of the whole text."""
        found = self._claim()
        if self._here.kind != "end":
            raise self._wrong(f"cannot go on with {self._here.text!r}", self._here, HINTS.get(self._here.text, ""))
        return found

    def _claim(self) -> Formula:
        start = self._here
        return self._true_or_false(self._value(), start)

    def _true_or_false(self, value: Value, start: Token) -> Formula:
        if isinstance(value, Sum):
            raise self._wrong("a number is no claim", start, "compare it: <, <=, >, >=, == or !=")
        if isinstance(value, Action):
            raise self._wrong("an action is no claim", start, f"write acts({value.agent}) == ACTION")
        if isinstance(value, Name):
            raise self._unknown("word", start, (*FUNCTIONS, *WORDS, *self._known.entities))
        return value

    def _value(self) -> Value:
        """A claim, or a sum where only a sum stands: parentheses hold either."""
        self._depth += 1
        if self._depth > MAX_DEPTH:
            raise self._wrong(f"nested deeper than {MAX_DEPTH} levels", self._here, "split the formula")
        start = self._here
        left = self._joined("or", disjunction, lambda: self._joined("and", conjunction, self._denied))
        if self._takes("implies"):
            right = self._claim()
            left = disjunction(negated(self._true_or_false(left, start)), right)
        self._depth -= 1
        return left

    def _joined(self, word: str, join: Callable[..., Formula], part: Callable[[], Value]) -> Value:
        start = self._here
        first = part()
        if self._here.text != word:
            return first
        parts = [self._true_or_false(first, start)]
        while self._takes(word):
            start = self._here
            parts.append(self._true_or_false(part(), start))
        return join(*parts)

    def _denied(self) -> Value:
        odd = False
        denied = False
        while self._takes("not"):
            odd, denied = not odd, True
        start = self._here
        value = self._relation()
        if not denied:
            return value
        claim = self._true_or_false(value, start)
        return negated(claim) if odd else claim

    # --- relations

    def _relation(self) -> Value:
        start = self._here
        left = self._sum()
        if isinstance(left, Action) and (self._here.text in ("in", "not")):
            return self._listed(left)
        parts: list[Formula] = []
        while (sign := self._takes(*RELATIONS)) is not None:
            beside = self._here
            right = self._beside(left)
            parts.append(self._related(left, sign, right, start, beside))
            start, left = beside, right
        return conjunction(*parts) if parts else left

    def _beside(self, left: Value) -> Value:
        """What stands after a relation. Beside `acts(agent)` a name is that of an action, whatever else it names."""
        named = isinstance(left, Action) and self._here.kind == "name"
        if named and self._tokens[self._next + 1].text != "(":
            return Name(self._take())
        return self._sum()

    def _related(self, left: Value, sign: Token, right: Value, start: Token, beside: Token) -> Formula:
        if isinstance(left, Sum) and isinstance(right, Sum):
            return self._bounded(lambda: compared(left, sign.text, right), sign)
        if isinstance(left, (Name, Action)) and isinstance(right, (Name, Action)):
            if sign.text not in ("==", "!="):
                raise self._wrong(f"names are not ordered by {sign.text}", sign, "write ==, != or a coordinate")
            same = self._same(left, right, sign)
            return same if sign.text == "==" else negated(same)
        odd, token = (left, start) if not isinstance(left, Sum) else (right, beside)
        raise self._no_number(odd, token)

    def _same(self, left: Name | Action, right: Name | Action, sign: Token) -> Formula:
        if isinstance(left, Action) and isinstance(right, Action):
            a, b = self._known.agents[left.agent], self._known.agents[right.agent]
            shared = [action.name for action in a.actions if action.name in [other.name for other in b.actions]]
            return disjunction(*(conjunction(_acts(a, name), _acts(b, name)) for name in shared))
        if isinstance(left, Action) or isinstance(right, Action):
            action, name = (left, right) if isinstance(left, Action) else (right, left)
            assert isinstance(action, Action) and isinstance(name, Name)
            return self._takes_action(action, name.token)
        if GOAL not in (left.token.text, right.token.text):
            raise self._wrong("only the goal is compared by name", sign, "compare coordinates, or distance(a, b) == 0")
        landmark = right.token if left.token.text == GOAL else left.token
        if not self._known.goals:
            raise self._wrong("this world has no goal", sign)
        if landmark.text not in self._known.goals:
            raise self._unknown("landmark", landmark, self._known.goals)
        return Goal(landmark.text)

    def _listed(self, action: Action) -> Formula:
        """`in [a, b]` or `not in [a, b]` after `acts(agent)`."""
        denied = self._takes("not")
        self._need("in", "after not" if denied else "after acts(...)")
        self._need("[", "after in")
        found = [self._takes_action(action, self._take())]
        while self._takes(","):
            found.append(self._takes_action(action, self._take()))
        self._need("]", "after the actions")
        return negated(disjunction(*found)) if denied else disjunction(*found)

    def _takes_action(self, action: Action, name: Token) -> Formula:
        policy = self._known.agents[action.agent]
        known = [spec.name for spec in policy.actions]
        if name.text not in known:
            raise self._unknown(f"action of {action.agent}", name, known)
        return _acts(policy, name.text)

    # --- arithmetic

    def _number_of(self, value: Value, token: Token) -> Sum:
        if not isinstance(value, Sum):
            raise self._no_number(value, token)
        return value

    def _no_number(self, value: Value, token: Token) -> InputError:
        if isinstance(value, Name) and token.text in self._known.entities:
            return self._wrong(f"{token.text} is no number", token, f"write {token.text}.x, or distance(a, b)")
        if isinstance(value, Name):
            known = (*FUNCTIONS, *self._known.entities, *self._known.coordinates)
            return self._unknown("name", token, known)
        kind = f"acts({value.agent})" if isinstance(value, Action) else "a claim"
        return self._wrong(f"{kind} is no number", token, "join claims by and, or, implies")

    def _sum(self) -> Value:
        start = self._here
        left = self._product()
        while (sign := self._takes("+", "-")) is not None:
            beside = self._here
            right = self._number_of(self._product(), beside)
            left = self._number_of(left, start)
            left = left + (right if sign.text == "+" else right.times(Fraction(-1)))
        return left

    def _product(self) -> Value:
        start = self._here
        left = self._signed()
        while (sign := self._takes("*", "/")) is not None:
            beside = self._here
            right, first = self._number_of(self._signed(), beside), self._number_of(left, start)
            if sign.text == "/" and right.is_constant and not right.offset:
                raise self._wrong("division by zero", sign)
            if right.is_constant:
                factor = right.offset if sign.text == "*" else 1 / right.offset
                left = self._bounded(lambda a=first, b=factor: a.times(b), sign)
            elif sign.text == "*" and first.is_constant:
                left = self._bounded(lambda a=right, b=first.offset: a.times(b), sign)
            else:
                raise self._wrong("only linear arithmetic can be decided", sign, "multiply and divide by numbers only")
        if self._here.text == "**":
            raise self._wrong("powers cannot be decided", self._here)
        return left

    def _bounded(self, make: Callable[[], Made], token: Token) -> Made:
        try:
            return make()
        except OverflowError as error:
            raise self._wrong(str(error), token, "simplify the formula") from None

    def _signed(self) -> Value:
        minus = 0
        while self._takes("-"):
            minus += 1
        start = self._here
        value = self._atom()
        return self._number_of(value, start).times(Fraction((-1) ** minus)) if minus else value

    def _atom(self) -> Value:
        token = self._take()
        if token.kind == "number":
            return constant(exact(token.text, self._where(token.place)))
        if token.text == "(":
            inside = self._value()
            self._need(")", "after the parenthesis")
            return inside
        if token.text == "|":
            inside = self._plain_sum()
            self._need("|", "after the absolute value")
            return largest([inside, inside.times(Fraction(-1))])
        if token.text in ("true", "false"):
            return TRUE if token.text == "true" else FALSE
        if token.kind != "name" or token.text in WORDS:
            what = f"cannot begin with {token.text!r} here" if token.text else "the formula ends too early"
            raise self._wrong(what, token, HINTS.get(token.text, "") or "write a comparison or a predicate")
        if self._here.text == "(":
            return self._call(token)
        if token.text in self._known.coordinates:
            return coordinate(token.text)
        if "." in token.text:
            raise self._unknown("coordinate", token, self._known.coordinates)
        return Name(token)

    def _plain_sum(self) -> Sum:
        start = self._here
        self._depth += 1
        if self._depth > MAX_DEPTH:
            raise self._wrong(f"nested deeper than {MAX_DEPTH} levels", self._here, "split the formula")
        found = self._number_of(self._sum(), start)
        self._depth -= 1
        if found.maxima:
            raise self._wrong("absolute values, distances, max and min do not nest", start, "split the formula")
        return found

    # --- calls

    def _call(self, function: Token) -> Value:
        if function.text not in FUNCTIONS:
            raise self._unknown("function", function, FUNCTIONS)
        self._take()
        if function.text in ("abs", "max", "min"):
            value = self._extreme(function)
        elif function.text == "acts":
            value = Action(self._named("agent", tuple(self._known.agents)))
        elif function.text == "distance":
            a = self._named("entity", self._known.entities)
            self._need(",", "after the first entity")
            value = distance(a, self._named("entity", self._known.entities))
        else:
            value = self._predicate(function)
        self._need(")", f"after the arguments of {function.text}")
        return value

    def _extreme(self, function: Token) -> Sum:
        sums = [self._plain_sum()]
        while function.text != "abs" and self._takes(","):
            sums.append(self._plain_sum())
        if function.text == "abs":
            return largest([sums[0], sums[0].times(Fraction(-1))])
        sign = Fraction(1 if function.text == "max" else -1)
        return largest([one.times(sign) for one in sums]).times(sign)

    def _named(self, kind: str, known: Sequence[str]) -> str:
        token = self._take()
        if token.text not in known:
            if not token.text:
                raise self._wrong("the formula ends too early", token, f"write one of: {', '.join(known[:10])}")
            raise self._unknown(kind, token, known)
        return token.text

    def _predicate(self, function: Token) -> Formula:
        """closes, engaged or at, of an agent (for `at`: any entity) and an entity, with a bound of its own or not."""
        known, near = self._known, function.text == "at"
        agent = self._named("entity" if near else "agent", known.entities if near else tuple(known.agents))
        self._need(",", "after the agent")
        second = self._here
        target = self._named("entity", known.entities)
        if target == agent:
            raise self._wrong(f"{agent} is always at itself", second, "name two")
        bound = None
        if self._takes(","):
            start = self._here
            given = self._number_of(self._sum(), start)
            if not given.is_constant or given.offset < 0:
                raise self._wrong("the bound must be a number that is not negative", start)
            bound = given.offset
        if near:
            return predicates.at(agent, target, known.radius if bound is None else bound)
        closing = predicates.closing(known.agents[agent], target, known.margin if bound is None else bound)
        return (
            closing if function.text == "closes" else disjunction(closing, predicates.at(agent, target, known.radius))
        )


def _acts(policy: AgentPolicy, action: str) -> Formula:
    return Acts(policy.agent, [spec.name for spec in policy.actions].index(action))
