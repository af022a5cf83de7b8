"""The question for Z3: is there a world state of the region in which the claim fails?

Does: encodes trees, observation maps with machine rounding, region and claim over exact rationals, one query a goal;
  counts the tests of trees that a query would state, before anything is written: one that is too large for its budget
  is not asked.
Assumes: features are sums of coordinates or functions of such; trees passed `verifiable`; parts of a formula about one
  agent's action each follow that agent's tree once.
Does not: share the arithmetic of thresholds with codegen or with any other engine, so that consensus means something;
  bound the search in Z3, which has resource units of its own (solve.py).

A sum of more than two coordinates rounds after each addition. Its exact sum plus an unknown of bounded size stands for
it, so that what is proved is proved; an answer is a candidate, which the referee judges.
"""

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from codegen import ir
from codegen.errors import InputError
from codegen.ir import AgentPolicy, FeatureSpec, PolicyProfile
from verify.claims.formula import (
    TRUE,
    And,
    Formula,
    Linear,
    Not,
    Or,
    agents,
    for_goal,
    negate,
    normal,
    substitute_actions,
)
from verify.claims.region import Region
from verify.kinds import MACHINE, REAL
from verify.question import DecisionQuestion
from verify.solver.terms import (
    HalfLine,
    Real,
    Terms,
    Test,
    add_terms,
    at_least,
    at_most,
    branch,
    compare_terms,
    conjunction,
    constant,
    disjunction,
    either,
    half_line,
    last_double,
    less_than,
    negation,
    number,
    on_line,
    sum_terms,
    unknown,
)
from verify.states.state import error_name, measurable
from verify.states.values import tighten_formula

MAX_TESTS = 280_000  # of trees that a query states: half a minute, and below two gigabytes with the solver's own copy
FEW_TESTS = 20_000  # that any budget allows
UNITS_A_TEST = 64  # of a budget in solver units: so many allow one test more


def beyond_budget(question: DecisionQuestion) -> str:
    """Why a question is too large for its budget to be written down; "" where it is not."""
    tests = _tests(question)
    most = min(MAX_TESTS, max(FEW_TESTS, question.budgets.solver_units // UNITS_A_TEST))
    return f"a query with {tests:,} tests of trees, more than {most:,}, is not asked" if tests > most else ""


def beyond_any(question: DecisionQuestion) -> bool:
    """Returns True if no budget allows the question to be written down."""
    return _tests(question) > MAX_TESTS


def _tests(question: DecisionQuestion) -> int:
    """The tests of trees that a query states."""
    lone = dict.fromkeys(_lone(question.formula))  # each follows its agent's tree
    return sum(len(question.profile.policy(next(iter(agents(part)))).tree.left) // 2 for part in lone)


def _lone(formula: Formula) -> Iterator[Formula]:
    """The largest parts of a formula that speak of one agent's action."""
    acting = agents(formula)
    if len(acting) == 1:
        yield formula
    elif acting:
        for part in (
            formula.parts if isinstance(formula, (And, Or)) else [formula.part] if isinstance(formula, Not) else []
        ):
            yield from _lone(part)


LAST_BELOW_ZERO = -(2.0**-1074)  # of float64: what is at most it is below 0
UNDERFLOW = Fraction(1, 2**1000)  # more than all products with a weight can lose
ROUNDED_ONCE = 2  # a sum of so many coordinates rounds once before it becomes a float32


class Query(NamedTuple):
    """A question to the solver, for one goal: the variables (position -> real) and the constraints."""

    goal: str | None
    variables: dict[str, Real]
    constraints: list[Test]
    exact: bool = True  # whether every answer is one; else rounding may keep the state from doing what was asked
    beyond: str = ""  # why it was not written: it is too large for the budget, and has no constraints


def query(
    question: DecisionQuestion, goal: str | None, slack: Fraction = Fraction(0), however_large: bool = False
) -> Query:
    """Constraints that hold exactly for the world states of the region, goal `goal`, in which the claim fails.

    With a positive `slack` every inequality is met with that much to spare: a stronger question whose answers lie
    inside their leaf cells, used to find counterexamples that survive rounding. Where the claim has an `eps`, each
    feature of each agent that a tree tests has an error, a variable of its own (`states.state.error_name`).
    `however_large`: whatever the question's budget of solver units allows.
    """
    beyond = "" if however_large else beyond_budget(question)
    if beyond:
        return Query(goal, {}, [], beyond=beyond)
    encoder, fails = _failing(question, goal, slack)
    return encoder.query(fails)


def _failing(question: DecisionQuestion, goal: str | None, slack: Fraction = Fraction(0)) -> tuple["_Encoder", Test]:
    """Returns the encoder of a goal's query, and the constraint that the claim fails."""
    encoder = _Encoder(question.profile, question.region, goal, slack, question.semantics, question.claim.eps)
    return encoder, encoder.encode_formula(tighten_formula(for_goal(negate(question.formula), goal), slack))


def in_both(question: DecisionQuestion, goal: str | None, slack: Fraction = Fraction(0)) -> Query:
    """Makes a query as `query` does, in which the claim fails in real arithmetic and in the deployed one."""
    real, machine = (query(question.by(semantics), goal, slack) for semantics in (REAL, MACHINE))
    if real.beyond:
        return real
    return Query(goal, real.variables | machine.variables, [*real.constraints, *machine.constraints], machine.exact)


def region_only(region: Region, assume: Formula = TRUE, goal: str | None = None) -> Query:
    """Constraints of the region and an assumption alone: unsatisfiable iff no world state meets them."""
    encoder = _Encoder(None, region, goal)
    return encoder.query(*([] if assume == TRUE else [encoder.encode_formula(for_goal(normal(assume), goal))]))


def reaching(
    policy: AgentPolicy,
    leaf: int,
    region: Region,
    goal: str | None,
    slack: Fraction = Fraction(0),
    semantics: str = MACHINE,
) -> Query:
    """Constraints that hold exactly for the world states of `region`, goal `goal`, in which an agent reaches a leaf."""
    encoder = _Encoder(None, region, goal, slack, semantics)
    return encoder.query(*encoder.path(policy, leaf))


def elsewhere(
    question: DecisionQuestion, goal: str | None, leaves: Mapping[str, int], slack: Fraction = Fraction(0)
) -> Query:
    """Makes a query as `query` does, in which some agent of `leaves` reaches another leaf than the one named there."""
    if beyond := beyond_budget(question):
        return Query(goal, {}, [], beyond=beyond)
    encoder, fails = _failing(question, goal, slack)
    policy = question.profile.policy
    turned = [turn for agent, leaf in leaves.items() for turn in encoder.list_turns(policy(agent), leaf)]
    return encoder.query(fails, disjunction(constant(False), *turned))


def there(question: DecisionQuestion, goal: str | None, leaves: Mapping[str, int]) -> Query:
    """Makes a query as `query` does, in which every agent of `leaves` reaches the leaf named there."""
    if beyond := beyond_budget(question):
        return Query(goal, {}, [], beyond=beyond)
    encoder, fails = _failing(question, goal)
    policy = question.profile.policy
    taken = [test for agent, leaf in leaves.items() for test in encoder.path(policy(agent), leaf)]
    return encoder.query(fails, *taken)


def fix_variables(query: Query, values: Mapping[str, Fraction]) -> Query:
    """The question with some of its variables settled."""
    if query.beyond:
        return query
    equal = [query.variables[name] == number(value) for name, value in values.items()]
    return query._replace(constraints=[*query.constraints, *equal])


def _region(region: Region, at: dict[str, Real]) -> list[Test]:
    constraints: list[Test] = []
    for name, (low, high) in region.box.items():
        constraints += [at[name] >= number(low), at[name] <= number(high)]
    for a, b, (low, high) in region.differences:
        constraints += [at[a] - at[b] >= number(low), at[a] - at[b] <= number(high)]
    for a, b, least in region.apart:
        gaps = [at[f"{a}.{axis}"] - at[f"{b}.{axis}"] for axis in "xy"]
        constraints.append(
            disjunction(*(side for gap in gaps for side in (gap >= number(least), gap <= number(-least))))
        )
    return constraints


class _Encoder:
    """Formulas of `normal` form for one question; equal parts become one expression."""

    def __init__(
        self,
        profile: PolicyProfile | None,
        region: Region,
        goal: str | None,
        slack: Fraction = Fraction(0),
        semantics: str = MACHINE,
        eps: Fraction = Fraction(0),
    ) -> None:
        self.variables = {name: unknown(name) for name in region.box}
        self.at = dict(self.variables)  # coordinate -> variable
        self._named = {} if goal is None else {f"{ir.GOAL}.{axis}": f"{goal}.{axis}" for axis in "xy"}
        self.at |= {name: self.variables[of_landmark] for name, of_landmark in self._named.items()}
        self.noise: list[Test] = []  # bounds of the errors
        self._profile, self._slack, self._semantics, self._eps = profile, slack, semantics, eps
        self._goal, self._region = goal, region
        self._known: dict[Formula, Test] = {}
        self._asked: dict[tuple[str, int], tuple[Test, Test]] = {}  # agent, node of its tree
        self._roundings: dict[str, Real] = {}  # no variables of the question: no answer settles them

    def query(self, *facts: Test) -> Query:
        """That these facts hold in some world state of the region, errors within their bounds."""
        bounds = [*_region(self._region, self.at), *self.noise]
        return Query(self._goal, self.variables, [*bounds, *facts], exact=not self._roundings)

    def encode_formula(self, claim: Formula) -> Test:
        """The formula. Where it speaks of one agent's actions only, it follows that agent's tree."""
        if claim not in self._known:
            self._known[claim] = self._build_test(claim)
        return self._known[claim]

    def _build_test(self, claim: Formula) -> Test:
        acting = agents(claim)
        if len(acting) == 1:
            (agent,) = acting
            assert self._profile is not None
            return self._follow_tree(self._profile.policy(agent), claim)
        if isinstance(claim, And):
            return conjunction(*(self.encode_formula(part) for part in _group_parts(claim.parts, And)))
        if isinstance(claim, Or):
            return disjunction(*(self.encode_formula(part) for part in _group_parts(claim.parts, Or)))
        assert isinstance(claim, Linear), claim
        parts = [self.at[name] if weight == 1 else number(weight) * self.at[name] for weight, name in claim.terms]
        return (less_than if claim.strict else at_most)(add_terms(parts), number(claim.bound))

    def _follow_tree(self, policy: ir.AgentPolicy, claim: Formula) -> Test:
        """The claim once the agent has chosen, as nested conditions over the world state."""
        tree, agent, formulas = policy.tree, policy.agent, dict[int, Test]()
        taken = dict.fromkeys(tree.action[ir.leaves(tree)].tolist())
        ends = {action: self.encode_formula(substitute_actions(claim, {agent: action})) for action in taken}
        columns = zip(tree.left.tolist(), tree.right.tolist(), tree.action.tolist(), strict=True)
        for node, (left, right, action) in reversed([*enumerate(columns)]):  # preorder: children come after parents
            if left == ir.NO_CHILD:
                formulas[node] = ends[action]
                continue
            if (agent, node) not in self._asked:
                self._asked[agent, node] = self._tests(policy, node)
            below, above = self._asked[agent, node]
            first, second = formulas.pop(left), formulas.pop(right)
            formulas[node] = branch(below, first, above, second) if self._slack else either(below, first, second)
        return formulas[ir.ROOT]

    def path(self, policy: ir.AgentPolicy, leaf: int) -> list[Test]:
        """The tests between the root and a leaf, as they must fall out to reach it."""
        return [taken for taken, _ in self._path(policy, leaf)]

    def list_turns(self, policy: ir.AgentPolicy, leaf: int) -> list[Test]:
        """The tests between the root and a leaf, as one of them must fall out to reach another leaf."""
        return [other for _, other in self._path(policy, leaf)]

    def _path(self, policy: ir.AgentPolicy, leaf: int) -> list[tuple[Test, Test]]:
        """(as it falls out on the way to the leaf, otherwise) of each test, from the leaf upwards."""
        tree, node, path = policy.tree, leaf, list[tuple[Test, Test]]()
        while node != ir.ROOT:
            parent = int(np.flatnonzero((tree.left == node) | (tree.right == node))[0])
            left, right = self._tests(policy, parent)
            path.append((left, right) if tree.left[parent] == node else (right, left))
            node = parent
        return path

    def _tests(self, policy: ir.AgentPolicy, node: int) -> tuple[Test, Test]:
        """(goes left, goes right) of a split, in terms of world coordinates."""
        feature = policy.features[int(policy.tree.feature[node])]
        meaning, slack = feature.meaning, self._slack
        if meaning is None:
            raise InputError(f"feature {feature.name} has no meaning", policy.agent)
        terms = self._terms(feature)
        threshold = float(policy.tree.threshold[node])
        noisy = bool(self._eps) and measurable(meaning)
        single = policy.tree.threshold.dtype == np.float32  # read here, as the checker reads it elsewhere
        arithmetic = _Arithmetic(self._semantics, bool(self._eps), single)
        line = None if meaning.function == "zero" else _line(meaning, threshold, arithmetic)
        rounds = self._semantics == MACHINE and len(meaning.terms) > ROUNDED_ONCE
        if line is not None and not (noisy or slack or rounds):
            return compare_terms(terms, line)
        measured = sum_terms(terms)
        if noisy:
            measured = measured + self._error(policy.agent, feature.name)
        if rounds:
            measured = measured + self._rounding(policy.agent, feature.name, meaning)
        if line is None and not (meaning.function == "zero" and 0 <= threshold < 1):
            always = constant(threshold >= 1)
            return always, negation(always)
        if line is None:
            # "is zero" (0 or 1): a difference of two float64 numbers is zero iff they are equal, so rounding does not
            # matter; what it adds to longer sums is in `measured`. Being equal has nothing to spare
            apart = disjunction(measured <= number(-slack), measured >= number(slack)) if slack else measured != 0
            return apart, measured == 0
        if slack:
            return at_most(measured, number(line.end - slack)), at_least(measured, number(line.end + slack))
        return on_line(measured, line)

    def _terms(self, feature: FeatureSpec) -> Terms:
        """A feature's terms, the goal's coordinates as those of the landmark that it is."""
        terms = feature.meaning.terms if feature.meaning else ()
        for _, name in terms:
            if name not in self.at:
                what = f"feature {feature.name} observes {name}, which regions cannot bound yet"
                raise InputError(what, str(feature.meaning))
        return tuple((weight, self._named.get(name, name)) for weight, name in terms)

    def _rounding(self, agent: str, feature: str, meaning: ir.Meaning) -> Real:
        """Returns the rounding error of a sum of coordinates: known within bounds only, the same one in every test.

        n - 1 additions are off by at most (n - 1) u / (1 - (n - 1) u) of the sum of all sizes, with u = 2**-53 (Higham
        2002, Accuracy and Stability of Numerical Algorithms, 4.2); twice (n - 1) u is more.
        """
        key = f"rounding of {error_name(agent, feature)}"
        if key not in self._roundings:
            sizes = sum((abs(Fraction(weight)) * self._largest(name) for weight, name in meaning.terms), Fraction(0))
            most = (len(meaning.terms) - 1) * sizes / 2**52 + UNDERFLOW
            one = self._roundings[key] = unknown(key)
            self.noise += [one >= number(-most), one <= number(most)]
        return self._roundings[key]

    def _largest(self, name: str) -> Fraction:
        """The largest size of a coordinate in the region."""
        of_goal = name.startswith(f"{ir.GOAL}.") and self._goal is not None
        return max(map(abs, self._region.box[f"{self._goal}{name.removeprefix(ir.GOAL)}" if of_goal else name]))

    def _error(self, agent: str, feature: str) -> Real:
        """The one error of a feature as an agent sees it, within eps."""
        name = error_name(agent, feature)
        if name not in self.variables:
            error = self.variables[name] = unknown(name)
            self.noise += [error >= number(-self._eps), error <= number(self._eps)]
        return self.variables[name]


def _group_parts(parts: Sequence[Formula], kind: type[And] | type[Or]) -> list[Formula]:
    """Parts that speak of the same single agent joined, so that its tree is written once for all of them."""
    by_agents: dict[frozenset[str], list[Formula]] = {}
    for part in parts:
        acting = agents(part)
        by_agents.setdefault(acting, []).append(part)
    joined: list[Formula] = []
    for acting, members in by_agents.items():
        joined += [kind(tuple(members))] if len(acting) == 1 else members
    return joined


class _Arithmetic(NamedTuple):
    """The treatment of a sum before it is compared."""

    semantics: str
    noisy: bool  # an error is added to it
    single: bool  # it is rounded to float32 at last


def _line(meaning: ir.Meaning, threshold: float, by: _Arithmetic) -> HalfLine | None:
    """The sums whose test goes left; None when all or none do. One coordinate with an error is no float64 number."""
    if meaning.function:
        least = -1 if meaning.function == "sign" else 0  # else "is positive": 0 or 1
        return HalfLine(Fraction(0), strict=threshold < 0) if least <= threshold < 1 else None
    if by.semantics == REAL:
        return HalfLine(Fraction(threshold), strict=False)
    if threshold == LAST_BELOW_ZERO and not (by.single or by.noisy):
        return HalfLine(Fraction(0), strict=True)  # what is rounded is float64, or a sum of two: 0 only from 0
    alone = len(meaning.terms) == 1 and not by.noisy
    return last_double(threshold, by.single) if alone else half_line(threshold, by.single)
