"""What agents observe, do and round in an exact state of a stated system; file and profile as proofs read them.

Does: observations; joint actions; the value of an expression in floats, of one state or of many; reads the file again
  with what its agents compute, where they test sums or give numbers; says which roundings the real agents make in a
  state.
Assumes: a system that has the features of the profile.
Does not: move states, or decide claims.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from fractions import Fraction
from operator import itemgetter
from typing import Any, NamedTuple

import numpy as np

from codegen import ir
from codegen.errors import InputError
from codegen.ir import CONSTANT, AgentPolicy, Floats, PolicyProfile, act, apply
from codegen.numbers import nearest_double, nearest_number
from codegen.sums import clip_values
from verify.systems.expressions import Call, Expression, Name, Number, Pi, Power, Product, Quotient, Sum, affine
from verify.systems.files import lower
from verify.systems.lowered import Rounded, acting
from verify.systems.remembering import with_memory
from verify.systems.statement import Statement
from verify.systems.system import Affine, Feature, Measure, State, System

ROUNDED = 1e-12  # what rounding may take from a number that is 0


def measure_feature(feature: Feature, state: State) -> Fraction:
    """The exact value of a feature in a state."""
    value = feature.form.at(state)
    if feature.measure is Measure.SIGN:
        return Fraction((value > 0) - (value < 0))
    if feature.measure is Measure.POSITIVE:
        return Fraction(value > 0)
    if feature.measure is Measure.EQUALS:
        return Fraction(value == 0)
    if feature.measure is Measure.CLIP and feature.bounds is not None:
        return max(feature.bounds[0], min(feature.bounds[1], value))
    return value


def observe_state(system: System, policy: AgentPolicy, state: State) -> Floats:
    """Returns what an agent observes in a state, [1, n_features] of the numbers that it compares. KeyError for a
    feature that the system does not have.
    """
    features = system.features[policy.agent]
    exact = [measure_feature(features[feature.name], state) for feature in policy.features]
    return np.array([[nearest_number(value, policy.numbers) for value in exact]], dtype=policy.numbers)


def choose_actions(system: System, profile: PolicyProfile, state: State) -> Mapping[str, int]:
    """The number of the action that each agent takes in a state."""
    return {policy.agent: int(act(policy, observe_state(system, policy, state))[0]) for policy in profile.agents}


def as_played(statement: Statement, profile: PolicyProfile) -> tuple[Statement, PolicyProfile]:
    """Both as proofs read them; as they are where no agent tests sums, gives numbers or remembers. InputError for
    agents whose sums are not affine in the state.
    """
    profile = with_copies(statement, profile)
    statement = with_memory(statement, profile)
    ranges = {each.name: each.range for each in statement.system.variables}
    features = statement.system.features
    read = {
        policy.agent: acting(policy, features[policy.agent], ranges)
        for policy in profile.agents
        if policy.tree.arithmetic
    }
    if not read:
        return statement, profile
    agents = tuple(read[each.agent].policy if each.agent in read else each for each in profile.agents)
    return lower(statement, read), replace(profile, agents=agents, region=None)


def with_copies(statement: Statement, profile: PolicyProfile) -> PolicyProfile:
    """The profile with the agents of a file that act by the tree of another one, as policies of their own. InputError
    where it has such an agent itself.
    """
    own = {policy.agent: policy for policy in profile.agents}
    copied = [each for each in statement.agents if each.like in own]
    for each in copied:
        if each.name in own:
            what = f"the profile has a tree for {each.name}, which the file lets act like {each.like}"
            raise InputError(what, statement.system.name, f"remove `like` from [agents.{each.name}]")
    copies = tuple(replace(own[each.like], agent=each.name, team=each.team) for each in copied)
    return replace(profile, agents=(*profile.agents, *copies)) if copies else profile


def list_settings(statement: Statement, agent: str, action: str) -> dict[str, Affine]:
    """Returns the values to which an action of an agent that chooses sets its inputs, by name. Those that are not
    affine are left out, as no formula names them.
    """
    (stated,) = (each for each in statement.agents if each.name == agent)
    forms = {name: affine(each) for name, each in stated.actions[action].items()}
    return {name: form for name, form in forms.items() if form is not None}


def list_roundings(statement: Statement) -> list[str]:
    """The variables that roundings are."""
    return [each.variable for one in statement.acting.values() for each in one.roundings]


def with_roundings(statement: Statement, state: State) -> dict[str, Fraction]:
    """A state with the roundings that the real agents make there, exactly, if it lies in the ranges; its other
    variables are kept.
    """
    extended, system = dict(state), statement.system
    added = set(list_roundings(statement))
    stated = [one for one in system.variables if one.name not in added]
    if any(not one.range[0] <= state[one.name] <= one.range[1] for one in stated):
        return extended
    for lowered in statement.acting.values():
        real = lowered.real
        row = observe_state(system, real, state)
        vector = int(real.tree.action[apply(real.tree, row)[0]]) if real.outputs else 0
        for each in lowered.roundings:
            chosen = each.sums[0 if each.output is None else vector]
            if each.output is not None and not chosen.places:
                extended[each.variable] = each.bound
                continue
            exact = Fraction(0)
            for place, weight in chosen.expand().items():
                feature = None if place == CONSTANT else system.features[real.agent][real.features[place].name]
                exact += weight * (1 if feature is None else feature.form.at(state))
            rounding = _rounding(real, each, chosen, row, exact)
            assert abs(rounding) <= each.bound, f"{each.variable}: {rounding} beyond {each.bound}"
            extended[each.variable] = each.bound + rounding
    return extended


def _rounding(real: AgentPolicy, rounded: Rounded, chosen: ir.Sum, row: np.ndarray, exact: Fraction) -> Fraction:
    """By how much a sum is above its exact value; or what its last rounding adds."""
    if len(chosen.terms) == 1 and chosen.terms[0][0] == 1 and rounded.output is None:
        return Fraction(float(row[0, chosen.places[0]])) - exact  # a feature
    value = chosen.value(row, real.tree.arithmetic)
    if not rounded.given:
        return Fraction(float(value[0])) - exact
    assert rounded.output is not None
    spec = real.outputs[rounded.output]
    cut = clip_values(value, spec.low, spec.high)
    return Fraction(float(cut.astype(real.tree.gives)[0])) - Fraction(float(cut[0]))


# --- expressions in floats


def _power(exponent: int) -> Callable[[Any], Any]:
    return lambda base: base**exponent


def _divide(one: Any, other: Any) -> Any:
    return one / other


class Computing(NamedTuple):
    """A way to compute in float64: how a constant becomes a number, the clip of a number to bounds, functions, powers
    and quotients.
    """

    constant: Callable[[Fraction], Any]
    clip: Callable[[Any, Any, Any], Any]
    functions: Mapping[str, Callable[[Any], Any]]
    power: Callable[[int], Callable[[Any], Any]] = _power
    divide: Callable[[Any, Any], Any] = _divide


def _root(number: float) -> float:
    """The square root, 0 of what rounding has put below 0."""
    return math.sqrt(0.0 if -ROUNDED < number < 0 else number)


def _clip(value: float, low: float, high: float) -> float:
    return min(max(value, low), high)


def _array(value: Fraction) -> ir.Float64:
    return np.asarray(nearest_double(value))


SINGLE = Computing(
    float,
    _clip,
    {"sin": math.sin, "cos": math.cos, "tan": math.tan, "exp": math.exp, "sqrt": _root},
)
ARRAYS = Computing(
    _array,
    np.clip,
    {"sin": np.sin, "cos": np.cos, "tan": np.tan, "exp": np.exp, "sqrt": np.sqrt},
)


def function(expression: Expression, by: Computing = SINGLE) -> Callable[[Mapping[str, Any]], Any]:
    """Its value in a state, in float64, operation by operation as it is written.

    The function raises ZeroDivisionError, OverflowError and ValueError as Python has them; with ARRAYS it takes many
    states at a time, and what is not defined is NaN or infinite.
    """
    match expression:
        case Number(value):
            number = by.constant(value)
            return lambda state: number
        case Pi():
            pi = by.constant(Fraction(math.pi))
            return lambda state: pi
        case Name(name):
            return itemgetter(name)
        case Power(base, exponent):
            under, raised = function(base, by), by.power(exponent)
            return lambda state: raised(under(state))
        case Call(_, argument, (least, most)):
            inner, low, high = function(argument, by), by.constant(least), by.constant(most)
            return lambda state: by.clip(inner(state), low, high)
        case Call(called, argument, _):
            inner, named = function(argument, by), by.functions[called]
            return lambda state: named(inner(state))
        case Sum(left, right):
            one, other = function(left, by), function(right, by)
            return lambda state: one(state) + other(state)
        case Product(left, right):
            one, other = function(left, by), function(right, by)
            return lambda state: one(state) * other(state)
        case Quotient(left, right):
            one, other = function(left, by), function(right, by)
            return lambda state: by.divide(one(state), other(state))
