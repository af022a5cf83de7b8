"""How fast claims are decided and proofs are checked, in one interleaved run.

    python tests/benchmarks/verifier.py [--rounds 3] [--full] [--json]

Teams: trees fitted to hand-written experts (fixed roles; the nearer of two matchings), and teams that swap their roles
at adjacent floats under fitted splits, whose claim holds and needs both trees. Measured: the sweep (leaf pairs that the
product of the trees has, times goals, in the time of a whole question; pruning counts), the time of a question against
one nested Z3 query for the same question, the same for features that are off by up to 1/100 (steady), three agents with
ten properties, the checker's time for a branch, and the bytes of a proof that leaves settle. --full adds larger trees.
"""

import argparse
import json
import math
import sys
import time
from fractions import Fraction
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))  # for tests.*, also when run by this path

import numpy as np
from sklearn.tree import DecisionTreeClassifier

from codegen import ir
from codegen.check import ensure
from codegen.observe import observe
from maviper.worlds import find
from tests.verify.zone_cases import stated
from verify.checker import decisions
from verify.checker.certificates import numbers
from verify.claims.decisions import BUILT_IN, DistinctTargets, NoDouble, formula
from verify.claims.region import Semantics, Verdict, start_region
from verify.question import Question
from verify.solver.decide import decide
from verify.zones import compiled
from verify.zones import engine as zones

SAMPLES = 100_000
LEFT, RIGHT, DOWN, UP = 1, 2, 3, 4
TARGETS = {
    "sweep, million leaf pairs/s": (3.0, 10.0, "higher"),
    "time of Z3 over zones, geometric mean": (3.0, 10.0, "higher"),
    "time of Z3 over zones, least": (0.8, 1.0, "higher"),
    "steady: Z3 over zones, geometric mean": (3.0, 10.0, "higher"),
    "steady: Z3 over zones, least": (0.8, 1.0, "higher"),
    "three agents, ten properties, s": (10.0, 2.0, "lower"),
    "checker, us a closed branch": (10.0, 3.0, "lower"),
    "proof by leaves, bytes a leaf": (20.0, 10.0, "lower"),
}


class Game:
    """A world with uniform states, observations and hand-written experts."""

    def __init__(self, name, seed=0):
        self.world = find(name)
        self.names = self.world.spec.coordinates()
        rng = np.random.default_rng(seed)
        self.states = rng.uniform(-1, 1, (SAMPLES, len(self.names)))
        if self.world.spec.goals:
            first = rng.random(SAMPLES) < 0.5
            for axis in "xy":
                self.states[:, self.names.index(f"goal.{axis}")] = np.where(
                    first, self.at("landmark_0", axis), self.at("landmark_1", axis)
                )

    def at(self, entity, axis):
        return self.states[:, self.names.index(f"{entity}.{axis}")]

    def heading(self, agent, landmark):
        """The longer axis first. `landmark`: [batch] indices."""
        count = len(self.world.spec.landmarks)
        offsets = [
            np.choose(landmark, [self.at(f"landmark_{k}", axis) for k in range(count)]) - self.at(agent, axis)
            for axis in "xy"
        ]
        along_x = np.abs(offsets[0]) > np.abs(offsets[1])
        return np.where(along_x, np.where(offsets[0] < 0, LEFT, RIGHT), np.where(offsets[1] < 0, DOWN, UP))

    def nearer(self):
        """Whether agent 0 going to landmark 0 and agent 1 to landmark 1 is the shorter matching."""

        def length(agent, landmark):
            return np.hypot(*(self.at(agent, axis) - self.at(landmark, axis) for axis in "xy"))

        straight = length("agent_0", "landmark_0") + length("agent_1", "landmark_1")
        return straight <= length("agent_0", "landmark_1") + length("agent_1", "landmark_0")

    def fitted(self, agent, actions, depth):
        """A tree of that depth, fitted to what the agent should do. Thresholds are rounded down."""
        place = self.world.agents.index(agent)
        obs = observe(self.world.features[place], self.states, self.world.spec)
        found = DecisionTreeClassifier(max_depth=depth, random_state=0).fit(obs, actions)
        classes, tree = found.classes_, found.tree_

        def node(at):
            if tree.children_left[at] < 0:
                return int(classes[np.argmax(tree.value[at])])
            threshold = np.float32(tree.threshold[at])
            if float(threshold) > tree.threshold[at]:
                threshold = np.nextafter(threshold, np.float32(-np.inf))
            return int(tree.feature[at]), threshold, node(tree.children_left[at]), node(tree.children_right[at])

        return node(0)

    def profile(self, trees):
        """The team with these nested trees; agents without one stand still."""
        agents = tuple(
            ir.AgentPolicy(name, self.world.team_of(name), features, actions, flat(trees.get(name, 0)))
            for name, features, actions in zip(self.world.agents, self.world.features, self.world.actions, strict=True)
        )
        return ensure(ir.PolicyProfile(self.world.spec, agents, ir.Provenance("", "", 0, "", "")))


def flat(nested):
    """Nested trees (feature, threshold, left, right) and bare actions as arrays in preorder."""
    rows = []

    def put(node):
        place = len(rows)
        rows.append((ir.NO_FEATURE, 0.0, ir.NO_CHILD, ir.NO_CHILD, node))
        if isinstance(node, tuple):
            left = put(node[2])
            right = put(node[3])
            rows[place] = (node[0], node[1], left, right, ir.NO_ACTION)
        return place

    put(nested)
    return ir.Tree(*(np.array(column) for column in zip(*rows, strict=True)))


def below(nested, ending):
    """The tree with another tree in place of each leaf."""
    if not isinstance(nested, tuple):
        return ending
    return nested[0], nested[1], below(nested[2], ending), below(nested[3], ending)


def towards(dx, dy):
    """Goes to what the features dx and dy point at, exactly: x first unless it is within a twentieth."""
    return dx, np.float32(-0.05), LEFT, (dx, np.float32(0.05), (dy, np.float32(0.0), DOWN, UP), RIGHT)


def offset(game, agent, landmark):
    place = game.world.agents.index(agent)
    names = [feature.name for feature in game.world.features[place]]
    return names.index(f"{landmark}_dx"), names.index(f"{landmark}_dy")


def deception_team(game, kind, depth):
    """Two defenders with trees of about that depth."""
    agents = ("agent_0", "agent_1")
    if kind == "swapping":
        between = [game.world.features[1 + k].index(other_dy(game, k)) for k in (0, 1)]
        cut = np.float32(0.1), np.nextafter(np.float32(-0.1), np.float32(-np.inf))
        matched = game.nearer()
        trees = {}
        for k, agent in enumerate(agents):
            above = game.fitted(agent, game.heading(agent, np.where(matched, k, 1 - k)), depth - 5)
            roles = [towards(*offset(game, agent, f"landmark_{landmark}")) for landmark in ((0, 1), (0, 1))[k]]
            trees[agent] = below(above, (between[k], cut[k], *roles))
        return game.profile(trees)
    first = np.full(SAMPLES, True) if kind == "roles" else game.nearer()
    goals = {agent: np.where(first, k, 1 - k) for k, agent in enumerate(agents)}
    return game.profile({agent: game.fitted(agent, game.heading(agent, goals[agent]), depth) for agent in agents})


def other_dy(game, k):
    """The feature of a defender that says how far above it the other one is."""
    name = f"agent_{1 - k}_dy"
    return next(feature for feature in game.world.features[1 + k] if feature.name == name)


def leaf_product(profile, team):
    return math.prod(len(ir.leaves(policy.tree)) for policy in profile.team(team))


def seconds(work):
    start = time.perf_counter()
    found = work()
    return time.perf_counter() - start, found


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--full", action="store_true")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    figures, rows = measured(options.rounds, options.full)
    if options.json:
        print(json.dumps({"figures": figures}))
        return
    print(f"zone search: {'compiled' if compiled.AVAILABLE else 'Python (the extension is not built)'}")
    for row in rows:
        print(row)
    for figure in figures:
        print(f"{figure['name']:40} {figure['value']:10.3g}   reach {figure['reach']:g}, stretch {figure['stretch']:g}")


def measured(rounds, full):
    values, rows = {}, []
    game = Game("physical-deception")
    ratios, sweeps, branches = [], [], []
    claim = DistinctTargets("defenders")
    region = start_region(game.world.spec)
    for kind in ("roles", "nearer", "swapping"):
        for depth in (4, 6, 8, 10, 12) if full or kind == "swapping" else (4, 6, 8, 10):
            if kind == "swapping" and depth < 6:
                continue
            profile = deception_team(game, kind, depth)
            pairs = leaf_product(profile, "defenders") * len(region.goals)
            ratio = []
            for _ in range(rounds):
                ours, found = seconds(lambda: zones.decide(stated(profile, formula(profile, claim), region)))  # noqa: B023
                theirs, second = seconds(lambda: decide(Question(profile, claim, region)))  # noqa: B023
                assert found.verdict is second.verdict
                ratio.append((theirs / ours, ours, theirs))
            middle = sorted(ratio)[len(ratio) // 2]
            if depth <= 10:
                ratios.append(middle[0])
            rows.append(
                f"{kind:9} depth {depth:2}  {found.verdict.value:8}  {pairs:9} pairs  {found.nodes:8} nodes  "
                f"zones {1e3 * middle[1]:8.1f} ms  Z3 {1e3 * middle[2]:8.1f} ms  ratio {middle[0]:6.1f}"
            )
            if found.verdict is Verdict.PROVED:
                rows[-1] += f"  proof {sum(map(len, found.proofs.values()))} bytes"
                asked = formula(profile, claim)
                checks = [seconds(lambda: checked(profile, asked, region, found)) for _ in range(rounds)]  # noqa: B023
                took, closed = min(checks)
                branches.append((closed, took))
                if depth == 10:
                    sweeps.append(pairs / min(one[1] for one in ratio) / 1e6)
    values["sweep, million leaf pairs/s"] = max(sweeps)
    values["time of Z3 over zones, geometric mean"] = math.exp(np.mean(np.log(ratios)))
    values["time of Z3 over zones, least"] = min(ratios)
    closed, took = max(branches)
    values["checker, us a closed branch"] = 1e6 * took / closed
    ratios, said = steady(game, region, rounds)
    values["steady: Z3 over zones, geometric mean"] = math.exp(np.mean(np.log(ratios)))
    values["steady: Z3 over zones, least"] = min(ratios)
    rows += said
    values["three agents, ten properties, s"], said = ten_properties()
    rows += said
    values["proof by leaves, bytes a leaf"] = bytes_a_leaf(game, region)
    figures = [
        {"name": name, "value": values[name], "reach": reach, "stretch": stretch, "better": better}
        for name, (reach, stretch, better) in TARGETS.items()
    ]
    return figures, rows


def checked(profile, asked, region, found):
    return sum(
        decisions.check(profile, asked, region, goal, Semantics(), numbers(proof))
        for goal, proof in found.proofs.items()
    )


def steady(game, region, rounds):
    """Though features are off: fixed roles under fitted splits, which hold, and the nearer of two matchings."""
    claim = DistinctTargets("defenders", eps=Fraction(1, 100))
    ratios, rows = [], []
    for kind, depth in [("held", 6), ("held", 8), ("held", 10), ("nearer", 6), ("nearer", 8), ("nearer", 10)]:
        profile = held_roles(game, depth - 3) if kind == "held" else deception_team(game, kind, depth)
        asked, times = formula(profile, claim), []
        for _ in range(rounds):
            ours, found = seconds(lambda: zones.decide(stated(profile, asked, region, eps=claim.eps)))  # noqa: B023
            theirs, second = seconds(lambda: decide(Question(profile, claim, region)))  # noqa: B023
            assert found.verdict is second.verdict
            times.append((theirs / ours, ours, theirs))
        ratio, ours, theirs = sorted(times)[rounds // 2]
        ratios.append(ratio)
        rows.append(
            f"{kind:9} depth {depth:2}  {found.verdict.value:8}  steady at eps 0.01  {found.nodes:8} nodes  "
            f"zones {1e3 * ours:8.1f} ms  Z3 {1e3 * theirs:8.1f} ms  ratio {ratio:6.1f}"
        )
    return ratios, rows


def held_roles(game, depth):
    """Fixed roles under fitted splits of that depth."""
    trees = {}
    for k, agent in enumerate(("agent_0", "agent_1")):
        above = game.fitted(agent, game.heading(agent, np.full(SAMPLES, k)), depth)
        trees[agent] = below(above, towards(*offset(game, agent, f"landmark_{k}")))
    return game.profile(trees)


def ten_properties():
    """Three agents with fixed roles under fitted splits of depth 6 in all."""
    game = Game("cooperative-navigation")
    trees = {}
    for k, agent in enumerate(game.world.agents):
        above = game.fitted(agent, game.heading(agent, np.full(SAMPLES, k)), 3)
        trees[agent] = below(above, towards(*offset(game, agent, f"landmark_{k}")))
    profile = game.profile(trees)
    radii = [Fraction(n, 100) for n in (6, 8, 10, 20)]
    claims = [BUILT_IN[name]("agents", radius=r) for name in ("distinct_targets", "own_target") for r in radii]
    claims += [NoDouble("agents", margin=margin) for margin in (Fraction(0), Fraction(1, 40))]
    region = start_region(game.world.spec)
    took, answers = seconds(
        lambda: [zones.decide(stated(profile, formula(profile, one), region)).verdict for one in claims]
    )
    triples = leaf_product(profile, "agents")
    return took, [f"three agents: {triples} triples, {', '.join(answer.value for answer in answers)}"]


def bytes_a_leaf(game, region):
    """Fixed roles under fitted splits: bytes of each goal's proof over the leaves of both trees."""
    profile = held_roles(game, 5)
    found = zones.decide(stated(profile, formula(profile, DistinctTargets("defenders")), region))
    leaves = sum(len(ir.leaves(policy.tree)) for policy in profile.team("defenders"))
    return max(map(len, found.proofs.values())) / leaves


if __name__ == "__main__":
    main()
