"""Claims about stated systems asked of Z3 directly: the episode unrolled, step by step, as its users do it.

Nothing of the engine or the checker is used: trees, roundings, pieces and claims are written down once more, from the
text of `verify/systems`.
"""

from fractions import Fraction

import numpy as np
import z3

from verify.systems.claims import SystemKind
from verify.systems.system import Measure


def number(value):
    return z3.Q(value.numerator, value.denominator)


def value(form, state):
    return number(form.constant) + z3.Sum([number(factor) * state[name] for name, factor in form.terms])


def inside(polytope, state):
    forms = [value(half.form, state) for half in polytope]
    return z3.And([found < 0 if half.strict else found <= 0 for found, half in zip(forms, polytope, strict=True)])


def in_some(regions, state):
    return z3.Or([inside(polytope, state) for polytope in regions])


def rounds_to_at_most(exact, threshold):
    """That the nearest number of a threshold's kind is at most it: up to the middle between it and the next one."""
    after = np.nextafter(threshold, threshold.dtype.type(np.inf))
    middle = (Fraction(float(threshold)) + Fraction(float(after))) / 2
    even = int.from_bytes(threshold.tobytes(), "little") % 2 == 0
    return exact <= number(middle) if even else exact < number(middle)


def goes_left(feature, threshold, state):
    exact = value(feature.form, state)
    if feature.measure is Measure.SIGN:
        exact = z3.If(exact > 0, z3.RealVal(1), z3.If(exact < 0, z3.RealVal(-1), z3.RealVal(0)))
    if feature.measure is Measure.POSITIVE:
        exact = z3.If(exact > 0, z3.RealVal(1), z3.RealVal(0))
    if feature.measure is Measure.CLIP:
        low, high = map(number, feature.bounds)
        exact = z3.If(exact < low, low, z3.If(exact > high, high, exact))
    return rounds_to_at_most(exact, threshold)


def action(system, policy, state):
    """The number of the action that an agent takes."""
    features, tree = system.features[policy.agent], policy.tree

    def below(node):
        if tree.feature[node] < 0:
            return z3.IntVal(int(tree.action[node]))
        side = goes_left(features[policy.features[tree.feature[node]].name], tree.threshold[node], state)
        return z3.If(side, below(tree.left[node]), below(tree.right[node]))

    return below(0)


def stepped(system, profile, state, after, errors, actions):
    """That a state may follow another one."""
    ways = []
    for piece in system.pieces:
        told = [z3.And(state[n] >= number(low), state[n] <= number(high)) for n, (low, high) in piece.where.items()]
        for name, variable in after.items():
            low, high = piece.error.get(name, (Fraction(0), Fraction(0)))
            told += [errors[name] >= number(low), errors[name] <= number(high)]
            total = errors[name] + (value(piece.move[name], state) if name in piece.move else 0)
            for policy in profile.agents:
                for place, spec in enumerate(policy.actions):
                    form = piece.effect.get((policy.agent, spec.name), {}).get(name)
                    if form is not None:
                        total += z3.If(actions[policy.agent] == place, value(form, state), 0)
            told.append(variable == total)
        ways.append(z3.And(told))
    return z3.Or(ways)


def somewhere(system, state):
    return z3.Or(
        [
            z3.And(
                [z3.And(state[n] >= number(low), state[n] <= number(high)) for n, (low, high) in piece.where.items()]
            )
            for piece in system.pieces
        ]
    )


def question(system, profile, claim):
    """(an episode breaks the claim, an episode leaves what is stated before it does), as formulas."""
    states = [{one.name: z3.Real(f"{one.name}@{t}") for one in system.variables} for t in range(claim.steps + 1)]
    told = [inside(system.start, states[0])]
    told += [states[0][one.name] >= number(one.range[0]) for one in system.variables]
    told += [states[0][one.name] <= number(one.range[1]) for one in system.variables]
    broken, left = [], []
    for step, state in enumerate(states):
        within = in_some(claim.regions, state)
        bad = {
            SystemKind.STAYS_IN: z3.Not(within),
            SystemKind.AVOIDS: within,
            SystemKind.REACHES: z3.Not(within) if step == claim.steps else z3.BoolVal(False),
            SystemKind.REACHES_AND_STAYS: z3.Not(within) if step >= claim.by else z3.BoolVal(False),
        }[claim.kind]
        broken.append(z3.And(*told, bad))
        told.append(z3.Not(bad))
        if claim.kind is SystemKind.REACHES:
            told.append(z3.Not(within))
        if step < claim.steps:
            left.append(z3.And(*told, z3.Not(somewhere(system, state))))
            actions = {one.agent: action(system, one, state) for one in profile.agents}
            errors = {one.name: z3.Real(f"e_{one.name}@{step}") for one in system.variables}
            told.append(stepped(system, profile, state, states[step + 1], errors, actions))
    return z3.Or(broken), z3.Or(left) if left else z3.BoolVal(False)


def possible(formula, timeout=60_000):
    """Whether Z3 finds that a formula can hold."""
    solver = z3.Solver()
    solver.set("timeout", timeout)
    solver.add(formula)
    answer = solver.check()
    return None if answer == z3.unknown else answer == z3.sat
