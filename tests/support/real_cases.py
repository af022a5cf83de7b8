"""Questions in real arithmetic with two coordinates left open, and an account of them that shares nothing with verify/.

The account walks the trees and states the claims anew over plain fractions. Every inequality that matters is a line
in the plane of the two open coordinates, and between the lines nothing changes. So a claim fails somewhere iff it fails
at one of the points tried: on the lines, where they meet, and between them.
"""

from dataclasses import replace
from fractions import Fraction
from itertools import combinations, pairwise, product

import numpy as np

from codegen import ir
from codegen.ir import Meaning
from codegen.observe import observe
from tests.support.meanings import meanings, with_meanings
from tests.support.zone_cases import random_tree
from verify.claims.region import Region
from verify.claims.region_files import positions
from verify.claims.wording import BUILT_IN

T = Fraction(float(np.float32(0.1)))
ABOVE = Fraction(float(np.nextafter(np.float32(0.1), np.float32(1))))
THIRD, TENTH = Fraction(1, 3), Fraction(1, 10)
ENDS = [Fraction(n, 4) for n in range(-4, 5)] + [THIRD, -THIRD, TENTH, T, ABOVE, T + Fraction(1, 2**80)]
TEAM = ("agent_0", "agent_1")
LANDMARKS = ("landmark_0", "landmark_1")
DIRECTIONS = dict.fromkeys(("stay",), (0, 0)) | {"left": (-1, 0), "right": (1, 0), "down": (0, -1), "up": (0, 1)}


# --- the account: what the team does, whether a claim fails, whether a state lies in a region


def state_at(position, goal):
    return {**position, **({f"goal.{axis}": position[f"{goal}.{axis}"] for axis in "xy"} if goal else {})}


def measured(meaning, at, error=Fraction(0)):
    total = sum((Fraction(weight) * at[name] for weight, name in meaning.terms), error)
    if meaning.function == "sign":
        return Fraction((total > 0) - (total < 0))
    if meaning.function == "positive":
        return Fraction(int(total > 0))
    return Fraction(int(total == 0)) if meaning.function == "zero" else total


def leaf_of(policy, at):
    node = 0
    while policy.tree.feature[node] >= 0:
        value = measured(policy.features[policy.tree.feature[node]].meaning, at)
        left = value <= Fraction(float(policy.tree.threshold[node]))
        node = int((policy.tree.left if left else policy.tree.right)[node])
    return node


def closes(at, agent, landmark, direction, margin):
    return (
        sum(part * (at[f"{landmark}.{x}"] - at[f"{agent}.{x}"]) for part, x in zip(direction, "xy", strict=True))
        > margin
    )


def engaged(at, agent, landmark, direction, claim):
    near = max(abs(at[f"{landmark}.{axis}"] - at[f"{agent}.{axis}"]) for axis in "xy") <= claim.radius
    return near or closes(at, agent, landmark, direction, claim.margin)


def fails(profile, claim, position, goal, leaves=None):
    """Whether a claim fails in a state: the team's leaves decide, or those that are given."""
    at = state_at(position, goal)
    leaves = leaves or {agent: leaf_of(profile.policy(agent), at) for agent in TEAM}
    directions = {
        agent: DIRECTIONS[profile.policy(agent).actions[profile.policy(agent).tree.action[leaf]].name]
        for agent, leaf in leaves.items()
    }
    first, second = (
        [engaged(at, agent, landmark, directions[agent], claim) for landmark in LANDMARKS] for agent in TEAM
    )
    name = claim.of
    if name == "own_target":
        return not (first[0] and second[1])
    if name == "distinct_targets":
        return not ((first[0] and second[1]) or (first[1] and second[0]))
    only = [[closes(at, agent, landmark, directions[agent], claim.margin) for landmark in LANDMARKS] for agent in TEAM]
    return any(all(one[k] and not one[1 - k] for one in only) for k in (0, 1))  # no_double


def may_fail(profile, claim, position, goal):
    """Whether a claim fails in a state by the team's leaves, or by some that errors of at most eps lead to."""
    if not claim.eps:
        return fails(profile, claim, position, goal)
    at = state_at(position, goal)
    ways = [[(agent, leaf) for leaf in leaves_with_errors(profile.policy(agent), at, claim.eps)] for agent in TEAM]
    return any(fails(profile, claim, position, goal, dict(leaves)) for leaves in product(*ways))


def leaves_with_errors(policy, at, eps):
    """The leaves that some errors lead to: per feature, errors at their ends, where a test turns, and between."""
    tree, tried = policy.tree, {}
    for place, feature in enumerate(policy.features):
        total = measured(Meaning(feature.meaning.terms), at)
        exact = not feature.meaning.terms or feature.meaning.function == "zero"
        cuts = {Fraction(0)} | {Fraction(float(t)) for t in tree.threshold[tree.feature == place]}
        errors = {Fraction(0)} if exact else {-eps, eps, *(cut - total for cut in cuts if abs(cut - total) <= eps)}
        tried[place] = between(errors)
    found, waiting = set(), [(0, tried)]
    while waiting:
        node, errors = waiting.pop()
        place = int(tree.feature[node])
        if place < 0:
            found.add(node)
            continue
        meaning, threshold = policy.features[place].meaning, Fraction(float(tree.threshold[node]))
        left = [one for one in errors[place] if measured(meaning, at, one) <= threshold]
        right = [one for one in errors[place] if one not in left]
        waiting += [(int(tree.left[node]), {**errors, place: left})] if left else []
        waiting += [(int(tree.right[node]), {**errors, place: right})] if right else []
    return found


def within(region, position):
    return all(low <= position[name] <= high for name, (low, high) in region.box.items()) and all(
        low <= position[a] - position[b] <= high for a, b, (low, high) in region.differences
    )


def is_short(value):
    """A float64 number of at most 44 bits behind the point: sums of such are float64 numbers too."""
    return (value * 2**44).denominator == 1


def machine_leaves(profile, position, goal):
    """Where the reference leads in a float64 state."""
    at = state_at(position, goal)
    row = np.array([[float(at.get(name, 0)) for name in profile.world.coordinates()]])
    return {
        agent: int(
            ir.apply(
                profile.policy(agent).tree,
                observe(profile.policy(agent).features, row, profile.world, profile.policy(agent).numbers),
            )[0]
        )
        for agent in TEAM
    }


# --- all states that matter


def lines(profile, claim, region, position, goal, p, q):
    """(a, b, c) with a p + b q = c, for every inequality that may change along p and q."""
    found = set()

    def line(terms, bound):
        weights, rest = {p: 0, q: 0}, Fraction(bound)
        for weight, name in terms:
            name = f"{goal}.{name[5:]}" if name.startswith("goal.") else name
            if name in weights:
                weights[name] += weight
            else:
                rest -= weight * position[name]
        if weights[p] or weights[q]:
            found.add((weights[p], weights[q], rest))

    for agent in TEAM:
        policy = profile.policy(agent)
        for feature, threshold in zip(policy.tree.feature, policy.tree.threshold, strict=True):
            if feature >= 0:
                meaning = policy.features[feature].meaning
                cut = 0 if meaning.function else Fraction(float(threshold))
                for error in {Fraction(0), claim.eps, -claim.eps}:
                    line(meaning.terms, cut + error)
        for landmark, axis, bound in product(
            LANDMARKS, "xy", (claim.margin, -claim.margin, claim.radius, -claim.radius)
        ):
            line(((1, f"{landmark}.{axis}"), (-1, f"{agent}.{axis}")), bound)
    for name in (p, q):
        for end in region.box[name]:
            line(((1, name),), end)
    for a, b, ends in region.differences:
        for end in ends:
            line(((1, a), (-1, b)), end)
    return found


def between(values):
    values = sorted(values)
    return [*values, *((a + b) / 2 for a, b in pairwise(values))]


def states(profile, claim, region, goal, p, q):
    """States of a region, some in every part of it in which nothing changes; p and q are the open coordinates."""
    position = {name: low for name, (low, _) in region.box.items()}
    cuts = lines(profile, claim, region, position, goal, p, q)
    ends = {c / a for a, b, c in cuts if not b}
    for (a, b, c), (d, e, f) in combinations(cuts, 2):
        if a * e - b * d:
            ends.add((c * e - b * f) / (a * e - b * d))
    for x in between(ends):
        across = {(c - a * x) / b for a, b, c in cuts if b}
        for y in between(across):
            state = {**position, p: x, q: y}
            if within(region, state):
                yield state


# --- random questions


PAIRS = (
    ("landmark_0.x", "agent_0.x"),
    ("landmark_0.x", "agent_1.x"),
    ("landmark_1.y", "agent_0.y"),
    ("agent_0.x", "agent_0.y"),
)
SHARP = [float(np.float32(0.1)), float(ABOVE), -float(np.float32(0.1)), 0.0, 0.5]


def sharpened(rng, policy_meanings, made, pair):
    """The tree with most of its tests on what the open coordinates change, at sharp thresholds."""
    feature, threshold = made.feature.copy(), made.threshold.copy()
    moved = [k for k, one in enumerate(policy_meanings) if {name for _, name in one.terms} & set(pair)]
    plain = [k for k in moved if not policy_meanings[k].function]
    for node in np.flatnonzero(made.feature >= 0):
        kind = rng.random()
        if plain and kind < 0.6:
            feature[node] = rng.choice(plain)
        elif moved and kind < 0.8:
            feature[node] = rng.choice(moved)
        if rng.random() < 0.8:
            threshold[node] = rng.choice(SHARP)
    return ir.Tree(feature, threshold, made.left, made.right, made.action)


def random_region(rng, profile, pair):
    """Two open coordinates, all others settled; often narrower than floats are apart."""
    box = {name: (Fraction(int(rng.integers(-2, 3)), 2),) * 2 for name in positions(profile.world)}
    for name in rng.choice(list(box), 2, replace=False):
        if rng.random() < 0.2:
            box[str(name)] = (rng.choice(ENDS),) * 2
    for name in pair:
        kind = rng.random()
        box[name] = (Fraction(-1), Fraction(1))
        if kind < 0.4:
            box[name] = tuple(sorted(rng.choice(ENDS, 2)))
        elif kind < 0.6:
            low = rng.choice(ENDS)
            box[name] = (low, low + rng.choice([0, Fraction(1, 2**80), Fraction(1, 2**60), Fraction(1, 2**30)]))
    differences = ()
    if rng.random() < 0.6:
        low = rng.choice([THIRD, T, T, TENTH, ABOVE, Fraction(0), -T, T + Fraction(1, 2**60), T + Fraction(1, 2**40)])
        wide = rng.choice([Fraction(0), Fraction(1, 2**80), Fraction(1, 2**50), (ABOVE - T) / 4, ABOVE - T])
        differences = ((*pair, (low, low + wide)),)
    return Region(box, (str(rng.choice(LANDMARKS)),), differences)


def random_question(rng, most_depth=2):
    """(profile, claim, region, open coordinates) of few states that matter."""
    pair = PAIRS[rng.choice(len(PAIRS), p=[0.55, 0.15, 0.15, 0.15])]
    trees = {}
    for agent in TEAM:
        made = random_tree(rng, len(meanings(agent)), int(rng.integers(0, most_depth + 1)))
        trees[agent] = sharpened(rng, meanings(agent), made, pair)
    profile = with_meanings(trees)
    margin = Fraction(rng.choice([0, 0, Fraction(1, 20), THIRD, T]))
    radius = Fraction(rng.choice([0, TENTH, THIRD, Fraction(1, 2), T]))
    claim = BUILT_IN[str(rng.choice(["distinct_targets", "own_target", "no_double"]))]("defenders", margin, radius)
    region = random_region(rng, profile, pair)
    return profile, claim, region, pair


def question_on_paper(rng):
    """As `random_question`, where the machine and real arithmetic part: an offset between a threshold and where the
    machine turns, which a tree tests first.
    """
    profile, claim, region, pair = random_question(rng)
    while pair != PAIRS[0] or not len(profile.policy(TEAM[0]).tree.feature) > 1:
        profile, claim, region, pair = random_question(rng)
    tree = profile.policy(TEAM[0]).tree
    feature, threshold = tree.feature.copy(), tree.threshold.copy()
    feature[0], threshold[0] = 1, float(T)  # landmark_0.x - agent_0.x
    trees = {name: profile.policy(name).tree for name in TEAM}
    trees[TEAM[0]] = ir.Tree(feature, threshold, tree.left, tree.right, tree.action)
    box = region.box | {name: (Fraction(-1), Fraction(1)) for name in pair}
    wide = rng.choice([Fraction(0), Fraction(1, 2**45), Fraction(1, 2**31)])
    low = T + Fraction(1, 2**40)
    return with_meanings(trees), claim, replace(region, box=box, differences=((*pair, (low, low + wide)),)), pair
