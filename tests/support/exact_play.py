"""Episodes of stated systems in exact numbers, by an evaluator that shares no code with verify/ but the data.

Starts, errors and pieces are drawn, with the ends of all intervals and the states beside thresholds among them.
"""

from fractions import Fraction as F

from tests.support.summed import rounded
from tests.support.system_cases import ends_of


def value(form, state):
    return form.constant + sum((factor * state[name] for name, factor in form.terms), F(0))


def measured(feature, state):
    found = value(feature.form, state)
    kind = feature.measure.value
    if kind == "sign":
        return F((found > 0) - (found < 0))
    if kind in ("positive", "equals"):
        return F(found > 0 if kind == "positive" else found == 0)
    return min(max(found, feature.bounds[0]), feature.bounds[1]) if kind == "clip" else found


def action(system, policy, state):
    """The name of what an agent does."""
    tree, node = policy.tree, 0
    while tree.feature[node] >= 0:
        feature = system.features[policy.agent][policy.features[int(tree.feature[node])].name]
        seen = rounded(measured(feature, state), policy.numbers)
        node = int(tree.left[node] if seen <= tree.threshold[node] else tree.right[node])
    return policy.actions[int(tree.action[node])].name


def meets(polytope, state):
    """Whether a state lies in all half spaces."""
    found = [(value(half.form, state), half.strict) for half in polytope]
    return all(number < 0 if strict else number <= 0 for number, strict in found)


def inside(claim, state):
    return any(meets(region, state) for region in claim.regions)


def breaks(claim, states):
    """Whether an episode, or as much of it as is stated, breaks a claim."""
    met = [inside(claim, state) for state in states]
    kind = claim.pattern.value
    if kind == "avoids":
        return any(met)
    if kind == "reaches":
        return len(met) == claim.steps + 1 and not any(met)
    if kind == "always":
        return not all(met[claim.by : _spoken_of(claim, states)])
    return not all(met[claim.by if kind == "reaches_and_stays" else 0 :])


def _spoken_of(claim, states):
    """How many of the states a claim speaks of: those before the first that lies outside of what it assumes."""
    outside = [not any(meets(region, state) for region in claim.assuming) for state in states] if claim.assuming else []
    return outside.index(True) if True in outside else len(states)


def drawn(random, low, high):
    """A number of an interval: an end, the middle, or any."""
    return low + (high - low) * [F(0), F(1), F(1, 2), F(int(random.integers(0, 1 << 20)), 1 << 20)][random.integers(4)]


def start(random, system):
    """A start, or None where the one drawn is none."""
    state = {name: drawn(random, F(low), F(high)) for name, (low, high) in ends_of(system).items()}
    for half in system.start:
        found = value(half.form, state)
        if found > 0 or (half.strict and found == 0):
            return None
    return state


def episode(random, system, profile, state, steps):
    """The states of an episode of a start with errors and pieces drawn; the bool: whether it left what is stated."""
    states = [state]
    for _ in range(steps):
        here = [
            piece
            for piece in system.pieces
            if all(low <= state[name] <= high for name, (low, high) in piece.where.items()) and meets(piece.when, state)
        ]
        if not here:
            return states, True
        piece = here[random.integers(len(here))]
        after = {name: value(form, state) for name, form in piece.move.items()}
        for policy in profile.agents:
            for name, form in piece.effect.get((policy.agent, action(system, policy, state)), {}).items():
                after[name] += value(form, state)
        for name, (low, high) in piece.error.items():
            after[name] += drawn(random, F(low), F(high))
        state = after
        states.append(state)
    return states, False


def refuted(random, question, times):
    """Whether one of so many episodes breaks the claim, or leaves what is stated before the claim is fulfilled."""
    system, profile, claim = question
    for _ in range(times):
        first = start(random, system)
        if first is None:
            continue
        states, left = episode(random, system, profile, first, claim.steps)
        fulfilled = claim.pattern.value == "reaches" and any(inside(claim, state) for state in states)
        fulfilled = fulfilled or _spoken_of(claim, states) < len(states)
        if breaks(claim, states) or (left and not fulfilled):
            return True
    return False
