"""The judge of stated systems: plays episodes of plain data in exact numbers, and says whether one breaks a claim.

Does: what a system, a team and a claim mean, written down once more.
Assumes: data as JSON has it: the document of a system, the trees of a profile, and a claim as a dictionary. A form may
  have `products` beside its terms: multiples of products of variables.
Does not: import anything of ours, or choose what is played (sampling.py).
"""

from fractions import Fraction
from math import prod

from tests.hunting.giving import NARROW, WIDE, nearest


def total(form, state):
    """The value of a sum."""
    found = Fraction(form["constant"]) + sum(
        (Fraction(w) * state[name] for name, w in form["terms"].items()), Fraction(0)
    )
    for w, names in form.get("products", ()):
        found += Fraction(w) * prod(state[name] for name in names)
    return found


def meets(half, state):
    """Whether a state meets an inequality."""
    return total(half["below"], state) < 0 if "below" in half else total(half["most"], state) <= 0


def seen(feature, state):
    """What a feature measures."""
    value = total(feature["form"], state)
    match feature["measure"]:
        case "sign":
            return Fraction(int(value > 0) - int(value < 0))
        case "positive":
            return Fraction(int(value > 0))
        case "equals":
            return Fraction(int(value == 0))
        case "clip":
            low, high = map(Fraction, feature["bounds"])
            return min(max(value, low), high)
    return value


def action(agent, features, state):
    """The name of what an agent does. A node: [feature, threshold, left, right], or [action]."""
    node, numbers = agent["nodes"][0], WIDE if agent.get("numbers") == "float64" else NARROW
    while len(node) > 1:
        name, threshold, left, right = node
        node = agent["nodes"][left if nearest(seen(features[name], state), numbers) <= threshold else right]
    return node[0]


def holding(system, state):
    """The numbers of the pieces that hold a state."""
    found = []
    for number, piece in enumerate(system["pieces"]):
        inside = all(Fraction(low) <= state[name] <= Fraction(high) for name, (low, high) in piece["where"].items())
        if inside and all(meets(half, state) for half in piece.get("when", [])):
            found.append(number)
    return found


def moved(system, agents, state, number, errors):
    """The next state by a piece."""
    piece = system["pieces"][number]
    after = {name: total(form, state) + errors.get(name, Fraction(0)) for name, form in piece["move"].items()}
    joint = {agent["agent"]: action(agent, system["features"][agent["agent"]], state) for agent in agents}
    for agent, chosen, forms in piece["effect"]:
        if joint[agent] == chosen:
            for name, form in forms.items():
                after[name] += total(form, state)
    return after


def within(regions, state):
    """Whether a state lies in one of some regions."""
    return any(all(meets(half, state) for half in region) for region in regions)


def broken(claim, states):
    """Whether the states of a whole episode break a claim."""
    inside = [within(claim["regions"], state) for state in states]
    match claim["name"]:
        case "stays_in":
            return not all(inside)
        case "avoids":
            return any(inside)
        case "reaches":
            return not any(inside)
        case "always":
            for step, state in enumerate(states):
                if claim["assuming"] and not within(claim["assuming"], state):
                    return False  # from here on it says nothing
                if step >= claim["by"] and not inside[step]:
                    return True
            return False
        case _:
            return not all(inside[claim["by"] :])


def played(system, agents, start, steps, choose, errors):
    """The states of an episode; None where it leaves what is stated."""
    states = [start]
    for step in range(steps):
        pieces = holding(system, states[-1])
        number = choose(step, pieces) if pieces else None
        if number is None or number not in pieces:
            return None
        stated = system["pieces"][number]["error"]
        given = {name: errors(step, name, Fraction(low), Fraction(high)) for name, (low, high) in stated.items()}
        states.append(moved(system, agents, states[-1], number, given))
    return states
