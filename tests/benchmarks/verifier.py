"""How fast claims are decided and proofs are checked, in one interleaved run.

    python -m tests.benchmarks.verifier [--rounds 3] [--full] [--json]

Teams: trees fitted to hand-written experts (fixed roles; the nearer of two matchings), teams that hold fixed roles
under fitted splits, and teams that swap their roles at adjacent floats, whose claim needs both trees.

Yardstick: the same question as one query written with z3's API directly (direct.py). Against it: the zone decision with
certificate and check, and our own query to Z3, encoding included (one, where neither claim nor tests name the goal).
Most of a small query is the solver's own: a context in which nothing was asked takes as long as the whole direct query.

Also: the sweep (leaf pairs that the product of the trees has, times goals, in the time of a question; pruning counts),
features that are off by up to 1/100 (steady, against our own query, as nobody else states that), ten properties of
three agents, the checker's time for a branch, and the bytes of a proof that leaves settle. --full adds larger trees.
"""

import gc
import json
import math
import statistics
import sys
from fractions import Fraction

import numpy as np
from sklearn.tree import DecisionTreeClassifier

from codegen import ir
from codegen.floats import FLOAT32
from codegen.observe import observe
from codegen.policy_json import dumps
from codegen.profiles import ensure
from maviper.worlds import find
from tests.benchmarks import direct
from tests.benchmarks.common import listed, reader, seconds, tell
from tests.support.teams import nested
from tests.support.zone_cases import stated
from verify.checker import decisions
from verify.checker.certificate import numbers
from verify.claims.decisions import DistinctTargets, NoDouble, formula
from verify.claims.region_files import start_region
from verify.claims.wording import BUILT_IN
from verify.kinds import Semantics
from verify.question import Question
from verify.result import Verdict
from verify.solver.encode import query
from verify.solver.solve import ask, decide
from verify.solver.terms import half_line
from verify.subjects import Game
from verify.verdicts.decisions import by_zones
from verify.zones import engine as zones
from verify.zones import search

SAMPLES = 100_000
LEFT, RIGHT, DOWN, UP = 1, 2, 3, 4
TARGETS = {
    "sweep, million leaf pairs/s": (3.0, 10.0, "higher"),
    "direct Z3 over zones with certificate and check, geometric mean": (6.0, 15.0, "higher"),
    "direct Z3 over zones with certificate and check, least": (1.0, 2.0, "higher"),
    "our Z3 query over a direct one, geometric mean": (1.3, 1.0, "lower"),
    "our Z3 query over a direct one, most": (1.3, 1.0, "lower"),
    "steady: Z3 over zones, geometric mean": (3.0, 10.0, "higher"),
    "steady: Z3 over zones, least": (0.8, 1.0, "higher"),
    "three agents, ten properties, s": (10.0, 2.0, "lower"),
    "checker, us a closed branch": (10.0, 3.0, "lower"),
    "proof by leaves, bytes per leaf": (20.0, 10.0, "lower"),
}


class Played:
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
        obs = observe(self.world.features[place], self.states, self.world.spec, FLOAT32)
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
            ir.AgentPolicy(name, self.world.team_of(name), features, actions, nested(trees.get(name, 0)))
            for name, features, actions in zip(self.world.agents, self.world.features, self.world.actions, strict=True)
        )
        return ensure(ir.PolicyProfile(self.world.spec, agents, ir.Provenance("", "", 0, "", "")))


def below(tree, ending):
    """The tree with another tree in place of each leaf."""
    if not isinstance(tree, tuple):
        return ending
    return *tree[:2], below(tree[2], ending), below(tree[3], ending)


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


def main():
    parser = reader(__doc__)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--full", action="store_true")
    options = parser.parse_args()
    figures, rows = measured(options.rounds, options.full)
    if not options.json:
        print(f"zone search: {'compiled' if search.AVAILABLE else 'Python (the extension is not built)'}")
        print("\n".join(rows))
    tell(figures, options.json)


def measured(rounds, full):
    values, rows = {}, []
    game = Played("physical-deception")
    against_direct, ours_over_direct, sweeps, branches = [], [], [], []
    region = start_region(game.world.spec)
    asked = list(teams(game, full))
    gc.collect()
    gc.freeze()  # what the benchmark itself has loaded and made is no part of a question
    for kind, depth, profile in asked:
        pairs = leaf_product(profile, "defenders") * len(region.goals)
        found, times = interleaved(profile, region, rounds)
        if depth <= 10:
            against_direct.append(times["direct"] / times["zones"])
            ours_over_direct.append(times["ours"] / times["direct"])
        rows.append(
            f"{kind:9} depth {depth:2}  {found.verdict.value:8}  {pairs:9} pairs  {found.nodes:8} nodes  "
            + "  ".join(f"{name} {1e3 * took:8.1f} ms" for name, took in times.items())
            + f"  ratio {times['direct'] / times['zones']:6.2f}"
        )
        if found.verdict is Verdict.PROVED:
            rows[-1] += f"  proof {sum(map(len, found.proofs.values()))} bytes"
            asked = formula(profile, DistinctTargets("defenders"))
            took, closed = min(seconds(lambda: checked(profile, asked, region, found)) for _ in range(rounds))  # noqa: B023
            branches.append((closed, took))
            if depth == 10:
                sweeps.append(pairs / times["search"] / 1e6)
    values["sweep, million leaf pairs/s"] = max(sweeps)
    values["direct Z3 over zones with certificate and check, geometric mean"] = statistics.geometric_mean(
        against_direct
    )
    values["direct Z3 over zones with certificate and check, least"] = min(against_direct)
    values["our Z3 query over a direct one, geometric mean"] = statistics.geometric_mean(ours_over_direct)
    values["our Z3 query over a direct one, most"] = max(ours_over_direct)
    closed, took = max(branches)
    values["checker, us a closed branch"] = 1e6 * took / closed
    ratios, said = steady(game, region, rounds)
    values["steady: Z3 over zones, geometric mean"] = math.exp(np.mean(np.log(ratios)))
    values["steady: Z3 over zones, least"] = min(ratios)
    rows += said
    values["three agents, ten properties, s"], said = ten_properties()
    rows += said
    values["proof by leaves, bytes per leaf"] = bytes_a_leaf(game, region)
    return listed(values, TARGETS), rows


def teams(game, full):
    """(kind, depth, profile) of each team that the engines are compared on."""
    depths = {"roles": (2, 4, 6, 8, 10), "nearer": (2, 4, 6, 8, 10), "held": (6, 8, 10), "swapping": (6, 8, 10)}
    for kind, usual in depths.items():
        for depth in (*usual, 12) if full and kind != "held" else usual:
            yield kind, depth, held_roles(game, depth - 3) if kind == "held" else deception_team(game, kind, depth)


def interleaved(profile, region, rounds):
    """The zones' answer, and the median seconds of CPU of each way to it, in turns."""
    question = Question(Game(profile), DistinctTargets("defenders"), region)
    document = json.loads(dumps(profile))
    ways = {
        "zones": lambda: by_zones(Question(Game(profile), question.claim, region)).opinion.verdict is Verdict.PROVED,
        "search": lambda: zones.decide(question).verdict is Verdict.PROVED,
        "direct": lambda: direct.decided(document, "defenders", _machine_end),
        "ours": lambda: _by_solver(Question(Game(profile), question.claim, region)),
    }
    times, answers = {name: [] for name in ways}, set()
    for _ in range(rounds):
        for name, way in ways.items():
            forget()
            took, proved = seconds(way)
            times[name].append(took)
            answers.add(proved)
    assert len(answers) == 1
    return zones.decide(question), {name: statistics.median(each) for name, each in times.items()}


def _machine_end(threshold):
    line = half_line(threshold, True)
    return line.end, line.strict


def _by_solver(question):
    """Whether the claim holds, by our queries to Z3: those of `solver.decide`, less the one about the region alone."""
    asked = question.goals if question.names_goal else question.goals[:1]
    return not any(ask(query(question, goal)).holds for goal in asked)


def forget():
    """Clears what is kept between questions, so that every way starts as in a process of its own."""
    ours = [module for name, module in sys.modules.items() if name.split(".")[0] in ("codegen", "verify")]
    for module in ours:
        for kept in vars(module).values():
            if hasattr(kept, "cache_clear"):
                kept.cache_clear()


def checked(profile, asked, region, found):
    return sum(
        decisions.check(profile, (asked,), region, goal, Semantics(), numbers(proof))
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
            theirs, second = seconds(lambda: decide(Question(Game(profile), claim, region)))  # noqa: B023
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


def navigators(count):
    """Agents of cooperative navigation with fixed roles under fitted splits, of depth 6 in all."""
    game = Played(f"cooperative-navigation,agents={count}")
    trees = {}
    for k, agent in enumerate(game.world.agents):
        above = game.fitted(agent, game.heading(agent, np.full(SAMPLES, k)), 3)
        trees[agent] = below(above, towards(*offset(game, agent, f"landmark_{k}")))
    return game.profile(trees)


def ten_properties():
    """Seconds of the zones for ten properties of three agents."""
    profile = navigators(3)
    radii = [Fraction(n, 100) for n in (6, 8, 10, 20)]
    claims = [BUILT_IN[name]("agents", radius=r) for name in ("distinct_targets", "own_target") for r in radii]
    claims += [NoDouble("agents", margin=margin) for margin in (Fraction(0), Fraction(1, 40))]
    region = start_region(profile.world)
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
