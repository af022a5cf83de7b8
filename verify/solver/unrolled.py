"""The second opinion on claims about stated systems: the whole episode as one query, unrolled step by step.

Does: writes trees, roundings, pieces and claims down once more, from what their words say (systems/system.py,
  systems/claims.py); asks whether an episode breaks the claim, and whether one leaves what is stated before it does.
Assumes: a system whose names, units and shapes were checked.
Does not: use the search of `verify.reach` or the readings of the checker, which share one reading of a system. Where
  an episode is long, or a system has many pieces, it has no opinion.
"""

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction

import numpy as np

from codegen.ir import NO_FEATURE, AgentPolicy, PolicyProfile, leaves
from verify.claims.formula import Acts, And, Formula, Goal, Linear, Not, Or
from verify.question import Question
from verify.result import Opinion, Verdict
from verify.solver import terms
from verify.solver.encode import Query
from verify.solver.solve import ask, solver_name
from verify.solver.terms import Real, Test, conjunction, disjunction, negation, number, unknown
from verify.subjects import ClosedLoop
from verify.systems.claims import Pattern, SystemClaim
from verify.systems.system import Affine, Feature, Measure, Piece, Polytope, System, ensure_in_steps

MAX_SIZE = 1_000  # tests and rules over all steps
UNITS = 500_000  # of the solver: a second or two of a query that does not end
UNIT = "resource units"
Threshold = np.float32 | np.float64
Values = Mapping[str, Real]  # a state: the unknown value of each variable
Choices = Mapping[tuple[str, int], Test]  # (agent, the number of an action) -> that the agent takes it


def opinion(question: Question[SystemClaim]) -> Opinion:
    """Asks the solver for its opinion; SKIPPED where the query would be large, UNKNOWN where its units are spent.

    A claim is VIOLATED too where an episode leaves what is stated before it is broken: then it is not proved.
    """
    assert isinstance(question.subject, ClosedLoop)
    profile, system, claim = question.profile, question.subject.system, question.claim
    if not claim.about_decisions:
        ensure_in_steps(system, "the solver")
    if size(profile, system, claim) > MAX_SIZE:
        return Opinion(solver_name(), Verdict.SKIPPED, 0, UNIT)
    asked = Query(None, {}, [disjunction(*encode_claim(profile, system, claim))])
    answer = ask(asked, min(UNITS, question.budgets.detail_units))
    verdict = {True: Verdict.VIOLATED, False: Verdict.PROVED, None: Verdict.UNKNOWN}[answer.holds]
    if claim.says.ever and verdict is Verdict.PROVED:  # of some steps only
        verdict = Verdict.SKIPPED
    return Opinion(solver_name(), verdict, answer.resources, UNIT)


def size(profile: PolicyProfile, system: System, claim: SystemClaim) -> int:
    """Counts the splits of trees and rules of pieces that a query has, over all steps."""
    splits = sum(len(leaves(policy.tree)) for policy in profile.agents)
    rules = len(system.pieces) * len(system.variables)
    return max(1, claim.steps) * (splits + rules)


def encode_claim(profile: PolicyProfile, system: System, claim: SystemClaim) -> tuple[Test, Test]:
    """(an episode breaks the claim, an episode leaves what is stated before it does)."""
    if claim.about_decisions:
        return _encode_decisions(profile, system, claim), terms.constant(False)
    states = [{one.name: unknown(f"{one.name}@{step}") for one in system.variables} for step in range(claim.steps + 1)]
    before = [*_in_ranges(system, states[0]), _inside(system.start, states[0])]
    breaking: list[Test] = []
    leaving: list[Test] = []
    for step, state in enumerate(states):
        within = disjunction(*(_inside(region, state) for region in claim.regions))
        before += [disjunction(*(_inside(region, state) for region in claim.assuming))] if claim.assuming else []
        bad = {
            Pattern.STAYS_IN: negation(within),
            Pattern.ALWAYS: negation(within) if step >= claim.by else terms.constant(False),
            Pattern.AVOIDS: within,
            Pattern.REACHES: negation(within) if step == claim.steps else terms.constant(False),
            Pattern.REACHES_AND_STAYS: negation(within) if step >= claim.by else terms.constant(False),
        }[claim.pattern]
        breaking.append(conjunction(*before, bad))
        before += [negation(within) if claim.pattern is Pattern.REACHES else negation(bad)]
        if step < claim.steps:
            stated = disjunction(*(conjunction(*_in_box(piece, state)) for piece in system.pieces))
            leaving.append(conjunction(*before, negation(stated)))
            before.append(_encode_step(profile, system, state, states[step + 1], step))
    return disjunction(*breaking), disjunction(*leaving)


def _encode_decisions(profile: PolicyProfile, system: System, claim: SystemClaim) -> Test:
    """That in some state of the ranges and the regions the agents decide otherwise than claimed."""
    state = {one.name: unknown(one.name) for one in system.variables}
    where = [disjunction(*(_inside(region, state) for region in claim.regions))] if claim.regions else []
    fails = negation(_encode_formula(claim.formula, state, choices(profile, system, state)))
    return conjunction(*_in_ranges(system, state), *where, fails)


def _encode_formula(formula: Formula, state: Values, chosen: Choices) -> Test:
    match formula:
        case Linear(parts, bound, strict):
            total = _sum([(weight, state[name]) for weight, name in parts], Fraction(0))
            return total < number(bound) if strict else total <= number(bound)
        case Acts(agent, action):
            return chosen[agent, action]
        case Not(part):
            return negation(_encode_formula(part, state, chosen))
        case And(parts):
            return conjunction(*(_encode_formula(part, state, chosen) for part in parts))
        case Or(parts):
            return disjunction(*(_encode_formula(part, state, chosen) for part in parts))
        case Goal():
            raise AssertionError("a stated system has no goal")


def choices(profile: PolicyProfile, system: System, state: Values) -> Choices:
    """When each agent takes each of its actions: on one of the paths to a leaf that has it."""
    taken: dict[tuple[str, int], Test] = {}
    for policy in profile.agents:
        paths: dict[int, list[Test]] = {number: [] for number in range(len(policy.actions))}
        for action, path in _paths(policy, system.features[policy.agent], state, 0):
            paths[action].append(conjunction(*path))
        taken |= {(policy.agent, action): disjunction(*each) for action, each in paths.items()}
    return taken


def _paths(
    policy: AgentPolicy, features: Mapping[str, Feature], state: Values, node: int
) -> Iterator[tuple[int, list[Test]]]:
    """Of each leaf below a node its action, and the sides that lead to it."""
    tree = policy.tree
    place = int(tree.feature[node])
    if place == NO_FEATURE:
        yield int(tree.action[node]), []
        return
    left = _goes_left(features[policy.features[place].name], tree.threshold[node], state)
    for child, side in ((tree.left, left), (tree.right, negation(left))):
        for action, path in _paths(policy, features, state, int(child[node])):
            yield action, [side, *path]


def _goes_left(feature: Feature, threshold: Threshold, state: Values) -> Test:
    exact, zero, one = _value(feature.form, state), number(Fraction(0)), number(Fraction(1))
    match feature.measure:
        case Measure.VALUE:
            pass
        case Measure.SIGN:
            exact = terms.either_number(
                exact > zero, one, terms.either_number(exact < zero, number(Fraction(-1)), zero)
            )
        case Measure.POSITIVE:
            exact = terms.either_number(exact > zero, one, zero)
        case Measure.EQUALS:
            exact = terms.either_number(terms.equal(exact, zero), one, zero)
        case Measure.CLIP:
            assert feature.bounds is not None
            low, high = map(number, feature.bounds)
            exact = terms.either_number(exact < low, low, terms.either_number(exact > high, high, exact))
    return _rounds_to_at_most(exact, threshold)


def _rounds_to_at_most(exact: Real, threshold: Threshold) -> Test:
    """That the nearest number of a threshold's kind is at most it: up to the middle between it and the next one, and
    at the middle where ties, which go to even, go down.
    """
    after = np.nextafter(threshold, threshold.dtype.type(np.inf))
    middle = (Fraction(float(threshold)) + Fraction(float(after))) / 2
    even = int.from_bytes(threshold.tobytes(), "little") % 2 == 0
    return exact <= number(middle) if even else exact < number(middle)


def _encode_step(profile: PolicyProfile, system: System, state: Values, after: Values, step: int) -> Test:
    """That a state may follow another one."""
    chosen = choices(profile, system, state)
    errors = {name: unknown(f"error of {name}@{step}") for name in after}
    return disjunction(*(_encode_move(profile, piece, state, after, errors, chosen) for piece in system.pieces))


def _encode_move(
    profile: PolicyProfile, piece: Piece, state: Values, after: Values, errors: Values, chosen: Choices
) -> Test:
    """That a state may follow another one by a piece."""
    tests = _in_box(piece, state)
    nothing = number(Fraction(0))
    for name, variable in after.items():
        low, high = piece.error.get(name, (Fraction(0), Fraction(0)))
        tests += [errors[name] >= number(low), errors[name] <= number(high)]
        total = errors[name] + (_value(piece.move[name], state) if name in piece.move else nothing)
        for policy in profile.agents:
            for place, action in enumerate(policy.actions):
                form = piece.effect.get((policy.agent, action.name), {}).get(name)
                if form is not None:
                    total += terms.either_number(chosen[policy.agent, place], _value(form, state), nothing)
        tests.append(terms.equal(variable, total))
    return conjunction(*tests)


def _in_ranges(system: System, state: Values) -> list[Test]:
    ranges = {one.name: one.range for one in system.variables}
    return [
        *_between(ranges, state),
        *(_is_mode(state[one.name], len(one.modes)) for one in system.variables if one.modes),
    ]


def _is_mode(value: Real, count: int) -> Test:
    return disjunction(*(terms.equal(value, number(Fraction(mode))) for mode in range(count)))


def _in_box(piece: Piece, state: Values) -> list[Test]:
    return [*_between(piece.where, state), *([_inside(piece.when, state)] if piece.when else [])]


def _between(bounds: Mapping[str, tuple[Fraction, Fraction]], state: Values) -> list[Test]:
    lower = [state[name] >= number(low) for name, (low, _) in bounds.items()]
    return [*lower, *(state[name] <= number(high) for name, (_, high) in bounds.items())]


def _inside(polytope: Polytope, state: Values) -> Test:
    nothing = number(Fraction(0))
    sums = [(_value(half.form, state), half.strict) for half in polytope]
    return conjunction(*(total < nothing if strict else total <= nothing for total, strict in sums))


def _value(form: Affine, state: Values) -> Real:
    return _sum([(factor, state[name]) for name, factor in form.terms], form.constant)


def _sum(parts: Sequence[tuple[Fraction | float, Real]], constant: Fraction) -> Real:
    total = number(constant)
    for factor, value in parts:
        total += number(Fraction(factor)) * value
    return total
