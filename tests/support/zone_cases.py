"""Random questions for the zone engine, and an exact account of what a team does at a rational point."""

from dataclasses import replace
from fractions import Fraction
from itertools import pairwise

import numpy as np

from codegen import ir
from maviper.worlds import find
from tests.support.meanings import meanings, with_meanings
from tests.support.teams import nested, team, team_in, towards
from verify.claims.formula import agents
from verify.claims.region import Region
from verify.claims.region_files import everywhere
from verify.claims.wording import BUILT_IN, OwnFormula
from verify.kinds import MACHINE
from verify.question import Budgets, Question
from verify.solver import encode
from verify.states.state import measurable
from verify.subjects import Game

PROPERTIES = ("distinct_targets", "own_target", "no_double")
SHARP = [0.0, -0.0, 0.1, -0.7, 0.5, -0.5, 1.0, -1.0, 2.0, 0.05, float(np.nextafter(np.float32(0.1), np.float32(1)))]
NODES = Budgets().max_nodes
NAVIGATION = find("cooperative-navigation")


def stated(profile, formula, region, semantics=MACHINE, budget=NODES, goals=None, eps=Fraction(0)):
    """The question whether a formula holds; `budget`: search nodes; `goals`: only these of the region's."""
    acting = agents(formula)
    team = next((policy.team for policy in profile.agents if policy.agent in acting), profile.agents[0].team)
    claim = OwnFormula(team, statement=formula, eps=eps)
    region = region if goals is None else replace(region, goals=goals)
    return Question(Game(profile), claim, region, semantics, Budgets(max_nodes=budget))


def random_tree(rng, n_features, max_depth, n_actions=5, grow=0.75):
    """A tree in preorder, thresholds sharp or anywhere."""

    def grown(level):
        if level == max_depth or rng.random() > grow:
            return int(rng.integers(n_actions))
        threshold = rng.choice(SHARP) if rng.random() < 0.5 else float(np.float32(rng.uniform(-1.5, 1.5)))
        return int(rng.integers(n_features)), float(np.float32(threshold)), grown(level + 1), grown(level + 1)

    return nested(grown(0))


def with_long_bounds(region):
    """The region with lower bounds of hundreds of digits, each of its own denominator."""
    names = [name for name in region.box if name[-2] == "."]
    lowest = {name: -Fraction(10**196 + 2 * k, 10**196 + 2 * k + 7) for k, name in enumerate(names)}
    return replace(region, box=region.box | {name: (low, Fraction(1)) for name, low in lowest.items()})


def random_region(rng, profile):
    """A part of the start region: narrower intervals, equalities, differences, distances; sometimes empty."""
    start = everywhere(profile)
    box = dict(start.box)
    for name in box:
        kind = rng.random()
        if kind < 0.3:
            low, high = sorted(Fraction(int(n), 20) for n in rng.integers(-20, 21, 2))
            box[name] = (low, high)
        elif kind < 0.45:
            box[name] = (Fraction(int(rng.integers(-4, 5)), 4),) * 2
    names = [name for name in box if name.endswith(".x")]
    differences = []
    if rng.random() < 0.5:
        a, b = rng.choice(names, 2, replace=False)
        low = Fraction(int(rng.integers(-8, 5)), 10)
        differences.append((str(a), str(b), (low, low + Fraction(int(rng.integers(0, 9)), 10))))
    apart = []
    if rng.random() < 0.4:
        entities = [entity.name for entity in profile.world.agents + profile.world.landmarks]
        a, b = rng.choice(entities, 2, replace=False)
        apart.append((str(a), str(b), Fraction(int(rng.integers(1, 13)), 10)))
    return Region(box, start.goals, tuple(differences), tuple(apart))


def deception(rng, max_depth):
    """Two defenders that observe every kind of meaning, and a claim about them."""
    count = len(meanings("agent_0"))
    depths = rng.integers(0, max_depth + 1, 2)
    trees = {f"agent_{k}": random_tree(rng, count, int(depth)) for k, depth in enumerate(depths)}
    margin, radius = Fraction(int(rng.integers(0, 3)), 20), Fraction(int(rng.integers(0, 13)), 10)
    claim = BUILT_IN[str(rng.choice(PROPERTIES))]("defenders", margin=margin, radius=radius)
    return with_meanings(trees), claim


def navigation(rng, max_depth):
    """Three agents with velocities."""
    profile = team_in(NAVIGATION, [random_tree(rng, len(features), max_depth) for features in NAVIGATION.features])
    return profile, BUILT_IN[str(rng.choice(PROPERTIES))]("agents", radius=Fraction(int(rng.integers(1, 13)), 10))


def joined(split, left, right):
    """A tree of one split (feature, threshold) above two trees."""
    columns = []
    parts = ((left, 1), (right, 1 + len(left.feature)))
    for name, first in (
        ("feature", split[0]),
        ("threshold", split[1]),
        ("left", 1),
        ("right", parts[1][1]),
        ("action", -1),
    ):
        rest = [getattr(tree, name) for tree, _ in parts]
        if name in ("left", "right"):
            rest = [
                np.where(column >= 0, column + shift, column) for column, (_, shift) in zip(rest, parts, strict=True)
            ]
        columns.append(np.concatenate([[first], *rest]))
    return ir.Tree(*columns)


def switching(threshold):
    """Two trees that swap their landmarks where the other defender is above, by complementary adjacent thresholds."""
    first = joined((9, threshold), towards(0, 0), towards(1, 0))
    beside = float(np.nextafter(np.float32(-threshold), np.float32(-np.inf)))
    return first, joined((9, beside), towards(0, 1), towards(1, 1))


def near_roles(rng, profile):
    """Teams that hold their claim, or nearly: fixed or switching roles, some with a leaf or threshold changed."""
    pair = (
        [towards(0, 0), towards(1, 1)] if rng.random() < 0.4 else list(switching(float(rng.choice([0.1, -0.3, 0.5]))))
    )
    for place, tree in enumerate(pair):
        if rng.random() < 0.4:
            node = int(rng.integers(len(tree.feature)))
            change = {"action": tree.action.copy(), "threshold": tree.threshold.copy()}
            if tree.feature[node] == ir.NO_FEATURE:
                change["action"][node] = rng.integers(5)
            else:
                side = np.float32(rng.choice([-np.inf, np.inf]))
                beside = np.nextafter(tree.threshold[node], side)
                change["threshold"][node] = beside if abs(beside) > 1e-30 or beside < 0 else 0.001  # subnormal, refused
            pair[place] = replace(tree, **change)
    claim = BUILT_IN[str(rng.choice(PROPERTIES[:2]))]("defenders", radius=Fraction(int(rng.integers(4, 12)), 100))
    return team(profile, *pair), claim


def noisy_roles(rng, profile):
    """Teams with fixed roles that test the same features again further up, some with a leaf changed: leaves that no
    path's tests reach together, though errors would pass each of them; and a claim about features that are off.
    """
    pair = []
    for place in (0, 1):
        tree = towards(place, place)
        for _ in range(int(rng.integers(0, 3))):
            split = (2 + 2 * place + int(rng.integers(2)), float(rng.choice([-0.05, 0.0, 0.03, 0.05, 0.1])))
            tree = joined(split, tree, towards(place, place) if rng.random() < 0.7 else tree)
        if rng.random() < 0.6:
            action = tree.action.copy()
            leaf = ir.leaves(tree)
            action[rng.choice(leaf)] = rng.integers(5)
            tree = replace(tree, action=action)
        pair.append(tree)
    of, eps = str(rng.choice(PROPERTIES[:2])), Fraction(int(rng.integers(1, 50)), 1000)
    radius = Fraction(int(rng.integers(5, 14)), 100)
    return team(profile, *pair), BUILT_IN[of]("defenders", radius=radius, eps=eps)


def noisy(rng, profile):
    """A claim about features that are off, of a random kind of team."""
    kind = rng.random()
    if kind < 0.6:
        return noisy_roles(rng, profile)
    pair, claim = deception(rng, 4) if kind < 0.9 else near_roles(rng, profile)
    eps = Fraction(int(rng.choice([1, 10, 50, 333])), 1000)
    return pair, replace(claim, eps=eps)


def actions_at(profile, state, goal, machine=True):
    """What each agent does at a rational point, by the solver's account of thresholds."""
    at = dict(state)
    if goal:
        at |= {f"goal.{axis}": at[f"{goal}.{axis}"] for axis in "xy"}
    found = {}
    for policy in profile.agents:
        tree, node = policy.tree, ir.ROOT
        while tree.feature[node] != ir.NO_FEATURE:
            left = _left(policy.features[tree.feature[node]].meaning, float(tree.threshold[node]), at, machine)
            node = int(tree.left[node] if left else tree.right[node])
        found[policy.agent] = int(tree.action[node])
    return found


def _left(meaning, threshold, at, machine, error=0, noisy=False):
    total = sum((weight * at[name] for weight, name in meaning.terms), Fraction(error))
    if meaning.function:
        value = {"sign": (total > 0) - (total < 0), "positive": total > 0, "zero": total == 0}[meaning.function]
        return value <= threshold
    if not meaning.terms or not machine:
        return total <= Fraction(threshold)
    once = len(meaning.terms) == 1 and not noisy
    line = encode.last_double(threshold, True) if once else encode.half_line(threshold, True)
    return total < line.end or (total == line.end and not line.strict)


def actions_with_errors(profile, state, goal, eps, machine=True):
    """What each agent can be led to do at a rational point: errors at their extremes, at every end, and between."""
    at = dict(state)
    if goal:
        at |= {f"goal.{axis}": at[f"{goal}.{axis}"] for axis in "xy"}
    found = {}
    for policy in profile.agents:
        tree, actions, waiting = policy.tree, set(), [(ir.ROOT, _tried(policy, at, eps, machine))]
        while waiting:
            node, errors = waiting.pop()
            feature = int(tree.feature[node])
            if feature == ir.NO_FEATURE:
                actions.add(int(tree.action[node]))
                continue
            meaning, threshold = policy.features[feature].meaning, float(tree.threshold[node])
            sides = {True: [], False: []}
            for error in errors[feature]:
                sides[_left(meaning, threshold, at, machine, error, True)].append(error)
            for side, child in ((True, tree.left[node]), (False, tree.right[node])):
                if sides[side]:
                    waiting.append((int(child), {**errors, feature: sides[side]}))
        found[policy.agent] = actions
    return found


def _tried(policy, at, eps, machine):
    """For each feature, errors with which its tests fall out in every way that they can."""
    found = {}
    for feature, spec in enumerate(policy.features):
        if not measurable(spec.meaning):
            found[feature] = [Fraction(0)]
            continue
        total = sum((weight * at[name] for weight, name in spec.meaning.terms), Fraction(0))
        thresholds = [float(t) for t in policy.tree.threshold[policy.tree.feature == feature]]
        ends = [Fraction(t) if not machine else encode.half_line(t, True).end for t in thresholds]
        ends = [Fraction(0)] * bool(ends) if spec.meaning.function else ends
        errors = sorted({-eps, eps, *(end - total for end in ends if abs(end - total) <= eps)})
        found[feature] = [*errors, *((a + b) / 2 for a, b in pairwise(errors))]
    return found


def exactly_inside(region, state):
    """Whether a rational point lies in a region."""
    gaps = [(max(abs(state[f"{a}.{x}"] - state[f"{b}.{x}"]) for x in "xy"), d) for a, b, d in region.apart]
    return (
        all(low <= state[name] <= high for name, (low, high) in region.box.items())
        and all(low <= state[a] - state[b] <= high for a, b, (low, high) in region.differences)
        and all(gap >= least for gap, least in gaps)
    )


def grid_points(rng, region, count):
    """Rational points of a region on a grid of twentieths."""
    for _ in range(count):
        state = {}
        for name, (low, high) in region.box.items():
            step = Fraction(int(rng.integers(0, 21)), 20)
            state[name] = low + (high - low) * step
        if exactly_inside(region, state):
            yield state
