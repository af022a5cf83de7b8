"""The checker's own reading of trees in a stated system: tests as inequalities between variables, leaves as effects.

Does: the exact side of a split on what a feature measures; a tree as a decision between effects, of which what cannot
  be known of the followed variables is left open.
Assumes: thresholds.py; belongs to what must be right for a certificate to mean something.
Does not: walk the trees of a branch.

A feature is the exact value of what it measures, rounded once to what the agent compares. Rounding never changes an
order, so a side of a split is a half line of the exact value, whose end thresholds.py gives.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from codegen.errors import UnknownNameError
from codegen.ir import NO_FEATURE, ROOT, AgentPolicy, splits
from verify.checker.systems.reading import Effect, Inequality, SystemReading
from verify.checker.thresholds import find_real_end
from verify.claims.formula import FALSE, TRUE, Formula, Or, below, disjunction
from verify.systems.system import Affine, Feature, Measure, Piece, System

Choices = frozenset[Effect]


class Split(NamedTuple):
    """A test of followed variables."""

    left_if: Inequality
    left: Decision
    right: Decision


Decision = Split | Choices  # at a leaf, the effects of which each may be taken


def goes_left(feature: Feature, threshold: float, numbers: str) -> Formula:
    """Where a split on a feature goes left, for an agent that compares such numbers: an inequality, one of two that
    exclude each other, always or never.
    """
    terms = dict(feature.form.terms)
    if feature.measure in (Measure.SIGN, Measure.POSITIVE):
        least = -1 if feature.measure is Measure.SIGN else 0
        if threshold < least or threshold >= 1:
            return TRUE if threshold >= 1 else FALSE
        return below(terms, -feature.form.constant, threshold < 0)
    if feature.measure is Measure.EQUALS:
        if threshold < 0 or threshold >= 1:
            return TRUE if threshold >= 1 else FALSE
        beyond = {name: -factor for name, factor in terms.items()}
        constant = feature.form.constant
        return disjunction(below(terms, -constant, True), below(beyond, constant, True))
    end = find_real_end(threshold, numbers)
    most, strict = end.value(), end.strict
    if feature.measure is Measure.CLIP and feature.bounds is not None:
        low, high = (bound < most or (bound == most and not strict) for bound in feature.bounds)
        if high or not low:
            return TRUE if high else FALSE
    return below(terms, most - feature.form.constant, strict)


def decisions(
    system: System, reading: SystemReading, policies: Sequence[AgentPolicy], by_action: bool
) -> list[Decision]:
    """The tree of each policy. `by_action`: actions are told apart, not what they do."""
    return [_decision(system, reading, policy, by_action) for policy in policies]


def _decision(system: System, reading: SystemReading, policy: AgentPolicy, by_action: bool) -> Decision:
    sides = sides_of(system, policy)
    effects = (
        [Effect((), number) for number in range(len(policy.actions))]
        if by_action
        else _effects(system, reading, policy)
    )
    tree, built = policy.tree, dict[int, Decision]()
    for node in reversed(range(len(tree.feature))):  # children stand behind their parents
        if tree.feature[node] == NO_FEATURE:
            built[node] = frozenset({effects[int(tree.action[node])]})
        else:
            left, right = built[int(tree.left[node])], built[int(tree.right[node])]
            built[node] = _build_split(reading, sides[node], left, right)
    return built[ROOT]


def sides_of(system: System, policy: AgentPolicy) -> dict[int, Formula]:
    """Where each split of a tree goes left."""
    features = system.features.get(policy.agent)
    if features is None:
        raise UnknownNameError("agent", policy.agent, system.features, f"system {system.name}")
    sides: dict[int, Formula] = {}
    for node in splits(policy.tree):
        name = policy.features[int(policy.tree.feature[node])].name
        if name not in features:
            raise UnknownNameError("feature", name, features, f"system {system.name}, agent {policy.agent}")
        sides[node] = goes_left(features[name], float(policy.tree.threshold[node]), policy.numbers)
    return sides


def _effects(system: System, reading: SystemReading, policy: AgentPolicy) -> list[Effect]:
    """Returns the effect of each action on the followed variables; one object for equal effects."""
    distinct: dict[object, Effect] = {}
    effects: list[Effect] = []
    for number, action in enumerate(policy.actions):
        by_piece = tuple(_of_action(reading, piece, (policy.agent, action.name)) for piece in system.pieces)
        key = tuple(tuple((name, form.terms, form.constant) for name, form in each.items()) for each in by_piece)
        effects.append(distinct.setdefault(key, Effect(by_piece, number)))
    return effects


def _of_action(reading: SystemReading, piece: Piece, choice: tuple[str, str]) -> dict[str, Affine]:
    stated = piece.effect.get(choice, {})
    return {name: stated[name] for name in reading.order if name in stated and stated[name] != Affine()}


def _build_split(reading: SystemReading, side: Formula, left: Decision, right: Decision) -> Decision:
    """A split that goes left where a formula holds; either side, where nothing is known of the test."""
    if side in (TRUE, FALSE):
        return left if side == TRUE else right
    if isinstance(side, Or):
        for part in reversed(side.parts):
            right = _build_split(reading, part, left, right)
        return right
    condition = reading.condition(side)
    if not isinstance(condition, Inequality):
        return either(left, right)
    return left if left == right else Split(condition, left, right)


def either(first: Decision, second: Decision) -> Decision:
    """One of two decisions, it is not known which."""
    if isinstance(first, Split):
        left = either(first.left, prune_decision(second, first.left_if, True))
        right = either(first.right, prune_decision(second, first.left_if, False))
        return left if left == right else Split(first.left_if, left, right)
    if isinstance(second, Split):
        return either(second, first)
    return first | second


def prune_decision(decision: Decision, known: Inequality, holds: bool) -> Decision:
    """A decision where it is known whether an inequality holds."""
    if not isinstance(decision, Split):
        return decision
    asked = decision.left_if
    if asked.sum is known.sum:
        order = (asked.most, not asked.strict), (known.most, not known.strict)
        if holds and order[0] >= order[1]:
            return prune_decision(decision.left, known, holds)
        if not holds and order[0] <= order[1]:
            return prune_decision(decision.right, known, holds)
    left, right = prune_decision(decision.left, known, holds), prune_decision(decision.right, known, holds)
    return left if left == right else Split(asked, left, right)
