"""Random teams: trees that fulfil a role by construction, trees one change away from that, and wild ones.

Does: worlds with features of every kind, trees with nasty thresholds, role trees, one leaf or one threshold changed.
Assumes: the worlds of maviper.worlds; actions in the games' order: stay, left, right, down, up.
Does not: say what holds: whether a role is fulfilled is asked of the judge.
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import numpy as np

from codegen import ir
from codegen.floats import below_zero
from maviper.worlds import find
from tests.support.strategies import with_trees
from tests.support.teams import nested

WORLDS = {  # and how often
    "physical-deception": 6,
    "physical-deception,features=signs": 2,
    "physical-deception,defenders=1": 1,
    "cooperative-navigation,agents=2": 2,
    "cooperative-navigation": 1,
    "predator-prey": 2,
}
TEAMS = {"physical-deception": "defenders", "cooperative-navigation": "agents", "predator-prey": "predators"}
RIGHT, LEFT, UP, DOWN = 2, 1, 4, 3
SHARP = (0.0, -0.0, -(2.0**-149), 0.1, -0.1, 0.05, -0.05, 0.5, -0.5, 0.25, 1.0, -1.0, 0.7, -0.3, 1 / 3)
EXTREME = (1.1754944e-38, -1.1754944e-38, 3.4028235e38, -3.4028235e38, 1e30, 1e-30, -1e-30, 65536.0)
NOBODY = ir.Provenance("", "", 0, "", "")


Node = int | tuple[int, float, "Node", "Node"]  # an action, or (feature, threshold, left, right)


@cache
def bare(world: str) -> ir.PolicyProfile:
    """A profile of a world in which nobody does anything, with three more features for each agent."""
    game, rng = find(world), np.random.default_rng(list(world.encode()))
    entities = [entity.name for entity in game.spec.agents + game.spec.landmarks]
    policies = []
    for agent, features, actions in zip(game.agents, game.features, game.actions, strict=True):
        others = [name for name in entities if name != agent]
        more = []
        for number, function in enumerate(("sign", "zero", "positive")):
            axis, other = "xy"[number % 2], others[int(rng.integers(len(others)))]
            meaning = ir.Meaning(((1, f"{other}.{axis}"), (-1, f"{agent}.{axis}")), function)
            more.append(ir.FeatureSpec(f"own_{function}", "none", -1.0, 1.0, meaning))
        tree = nested(0)
        policies.append(ir.AgentPolicy(agent, game.team_of(agent), (*features, *more), actions, tree))
    return ir.PolicyProfile(game.spec, tuple(policies), NOBODY)


def threshold(rng: np.random.Generator, known: Sequence[float] = ()) -> float:
    """A threshold as float32: plain, sharp, extreme, or that of another test or beside it."""
    kind = rng.random()
    if kind < 0.0005:
        return 1e-45  # subnormal, which claims refuse
    if kind < 0.3 and known:
        found = np.float32(known[int(rng.integers(len(known)))])
        side = np.float32(rng.choice([-np.inf, np.inf, np.nan]))
        return float(found if np.isnan(side) else _beside(found, side))
    if kind < 0.65:
        return float(np.float32(SHARP[int(rng.integers(len(SHARP)))]))
    if kind < 0.7:
        return float(np.float32(EXTREME[int(rng.integers(len(EXTREME)))]))
    return float(np.float32(rng.uniform(-1.2, 1.2)))


def _beside(value: np.float32, side: np.float32) -> np.float32:
    """The neighbouring float32 number that is finite and not subnormal, unless it is that of x < 0."""
    with np.errstate(over="ignore"):
        found = np.nextafter(value, side)
    tiny = np.finfo(np.float32).tiny
    if not np.isfinite(found):
        return value
    if found == below_zero("float32"):
        return np.float32(found)
    return np.float32(np.copysign(tiny, found)) if 0 < abs(found) < tiny else found


def doubled(rng: np.random.Generator, *profiles: ir.PolicyProfile) -> list[ir.PolicyProfile]:
    """The profiles with one or more agents that compare float64, the same ones and alike in each: thresholds where they
    were, or one or two float64 numbers beside.
    """
    names = [policy.agent for policy in profiles[0].agents]
    chosen = names if rng.random() < 0.4 else [str(rng.choice(names))]
    steps: dict[float, int] = {}

    def moved(value: float) -> float:
        count = steps.setdefault(value, int(rng.choice([0, 0, 0, 1, -1, 2, -2])))
        if value == below_zero("float32") or (value == 0 and count < 0):
            return below_zero("float64")
        for _ in range(abs(count) if abs(value) > 1e-300 else 0):  # beside 0 are subnormal numbers, which claims refuse
            value = math.nextafter(value, math.copysign(math.inf, count))
        return value

    def tree(old: ir.Tree) -> ir.Tree:
        columns = (old.feature, np.array([moved(value) for value in old.threshold.tolist()]), old.left, old.right)
        return ir.Tree(*columns, old.action, numbers="float64")

    return [with_trees({name: tree(one.policy(name).tree) for name in chosen}, one) for one in profiles]


def useful(policy: ir.AgentPolicy) -> list[int]:
    """The features that are not constant."""
    return [number for number, one in enumerate(policy.features) if one.meaning and one.meaning.terms]


def wild(rng: np.random.Generator, policy: ir.AgentPolicy, depth: int) -> Node:
    known: list[float] = []
    features = useful(policy)

    def made(level: int) -> Node:
        if level == depth or (level > 1 and rng.random() > 0.85):
            return int(rng.integers(len(policy.actions)))
        feature = int(rng.choice(features[-6:] if rng.random() < 0.3 else features))
        function = policy.features[feature].meaning.function
        value = float(rng.choice([-1.0, -0.5, 0.0, 0.5, 1.0])) if function else threshold(rng, known)
        known.append(value)
        return feature, value, made(level + 1), made(level + 1)

    return made(0)


def towards(rng: np.random.Generator, policy: ir.AgentPolicy, landmark: str, room: tuple[float, float]) -> Node:
    """A small tree that closes on a landmark or is at it: tests its offset on one axis, then on the other.

    `room`: between which lengths the tests may lie: more than the margin, less than the radius.
    """
    axes = ["x", "y"] if rng.random() < 0.5 else ["y", "x"]
    middle = int(rng.integers(len(policy.actions)))
    for axis in axes:
        feature, scale = _offset(policy, landmark, axis)
        small = 0.5 if scale else float(np.float32(rng.uniform(*room)))
        other = 0.5 if scale else float(np.float32(rng.uniform(*room)))
        over, under = (RIGHT, LEFT) if axis == "x" else (UP, DOWN)
        if rng.random() < 0.5:
            middle = (feature, -small, under, (feature, other, middle, over))
        else:
            middle = (feature, other, (feature, -small, under, middle), over)
    return middle


def _offset(policy: ir.AgentPolicy, landmark: str, axis: str) -> tuple[int, bool]:
    """The feature that is the landmark's offset from the agent, and whether only its sign is seen."""
    terms = ((1, f"{landmark}.{axis}"), (-1, f"{policy.agent}.{axis}"))
    for number, one in enumerate(policy.features):
        if one.meaning and one.meaning.terms == terms and one.meaning.function in ("", "sign"):
            return number, bool(one.meaning.function)
    raise LookupError(terms)


def role(
    rng: np.random.Generator, policy: ir.AgentPolicy, landmark: str, extra: int, room: tuple[float, float]
) -> Node:
    """A tree that goes to one landmark whatever its other tests say."""
    if not extra:
        return towards(rng, policy, landmark, room)
    feature = int(rng.choice(useful(policy)))
    less = extra - 1 - int(rng.integers(2)) * (extra > 1)
    below = [role(rng, policy, landmark, level, room) for level in (less, extra - 1)]
    return feature, threshold(rng), *below


def between(feature: int, usual: Node, other: Node) -> Node:
    """Does as usual, but another thing where a sign is 0: tests of it at -0.5 and 0.5."""
    return feature, -0.5, usual, (feature, 0.5, other, usual)


def switching(
    rng: np.random.Generator, policies: Sequence[ir.AgentPolicy], marks: Sequence[str], room: tuple[float, float]
) -> list[Node]:
    """Two trees that swap their landmarks by a test of each other's offset, with thresholds that complement each other;
    in a third of the teams they miss each other by one float32 number.
    """
    axis = str(rng.choice(["x", "y"]))
    first, _ = _offset(policies[0], policies[1].agent, axis)
    second, _ = _offset(policies[1], policies[0].agent, axis)
    value = np.float32(threshold(rng))
    value = np.float32(0.25) if abs(value) > 2 else value
    complement = _beside(-value, np.float32(-np.inf))
    if rng.random() < 0.33:
        complement = np.float32(-value)
    extra = [int(rng.integers(0, 2)) for _ in range(4)]
    a, b = ([role(rng, policies[k], marks[m], extra[2 * k + m], room) for m in (0, 1)] for k in (0, 1))
    return [(first, float(value), a[0], a[1]), (second, float(complement), b[0], b[1])]


def changed(rng: np.random.Generator, tree: ir.Tree, actions: int) -> ir.Tree:
    """The tree with one leaf's action changed, or one threshold moved to the next float32 number or another one."""
    splits = np.flatnonzero(tree.feature >= 0)
    if not len(splits) or rng.random() < 0.5:
        action = tree.action.copy()
        action[rng.choice(ir.leaves(tree))] = rng.integers(actions)
        return replace(tree, action=action)
    moved, node = tree.threshold.copy(), rng.choice(splits)
    side = np.float32(rng.choice([-np.inf, np.inf]))
    moved[node] = _beside(moved[node], side) if rng.random() < 0.6 else threshold(rng, moved[splits].tolist())
    return replace(tree, threshold=moved)
