"""Claims about whole episodes: zones against unrolling in Z3, and how far zones go in the whole start region.

    python -m tests.benchmarks.closed_loop [--full | --certificates] [--json]

Trees of several depths are fitted to a script that takes each defender to its own landmark along the longer axis. Both
ways answer the same question in the same run, on small start regions, one query a goal for Z3; they must agree. Targets
for the ratio of times: 50, stretch 500. Then what certificates of proved claims cost: of those boxes, of a hand-made
team in the whole start region, and of the committed proved defenders in the start region halved.
"""

import argparse
import json
import math
import time
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import z3
from sklearn.tree import DecisionTreeClassifier

from codegen import ir
from codegen.lowering.deploy import deploy_tree
from maviper import load
from maviper.worlds import PhysicalDeception
from tests.support.episode_cases import arriving
from tests.support.teams import team
from verify.certificates.proofs import count_bytes
from verify.checker.episodes.certificates import check_certificate
from verify.claims.catalogue import find_claim
from verify.claims.region import Region
from verify.claims.wording.starts import everywhere
from verify.episodes.certificates import build_certificate
from verify.episodes.composition import decide
from verify.question import Budgets, Question
from verify.result import Verdict
from verify.solver.terms import half_line
from verify.states.episodes import find_matchings
from verify.subjects import Game

MINUTE = 60_000  # milliseconds


def number(value):
    return z3.RealVal(f"{value.numerator}/{value.denominator}")


def unrolled(profile, claim, region, goal, limit=0):
    """Whether an episode from `region` violates the claim, by one query over all steps; None after `limit` ms.

    Positions and velocities of each step are variables; trees are nested conditions on positions, over the reals.
    Agents of other teams stand still.
    """
    solver = z3.SolverFor("QF_LRA")
    if limit:
        solver.set("timeout", limit)
    world = profile.world
    entities = [entity.name for entity in world.agents + world.landmarks]
    place = {f"{name}.{axis}": z3.Real(f"{name}.{axis}") for name in entities for axis in "xy"}
    for name, variable in place.items():
        low, high = region.box[name]
        solver.add(variable >= number(low), variable <= number(high))
    speed = {f"{entity.name}.{axis}": number(Fraction(0)) for entity in world.agents for axis in "xy"}
    team, forces = profile.team(claim.team), {entity.name: Fraction(entity.force) for entity in world.agents}
    course = [place]
    dt, kept = Fraction(world.dt), 1 - Fraction(world.damping)
    for step in range(claim.steps):
        following, faster = dict(place), dict(speed)
        for policy in team:
            pushes = _pushes(policy, place, goal)
            for axis, push in zip("xy", pushes, strict=True):
                name = f"{policy.agent}.{axis}"
                following[name], faster[name] = z3.Reals(f"{name}@{step + 1} {name}'@{step + 1}")
                solver.add(following[name] == place[name] + number(dt) * speed[name])
                solver.add(faster[name] == number(kept) * speed[name] + number(dt * forces[policy.agent]) * push)
        place, speed = following, faster
        course.append(place)
    steps = course if claim.name == "reaches" else course[-1:]
    landmarks = [landmark.name for landmark in world.landmarks]
    ways = [
        z3.And(
            *(
                z3.Or(*(_at(now, policy.agent, landmarks[own], claim.radius) for now in steps))
                for policy, own in zip(team, matching, strict=True)
            )
        )
        for matching in find_matchings(profile, claim)
    ]
    solver.add(z3.Not(z3.Or(*ways)))
    answer = solver.check()
    return None if answer == z3.unknown else answer == z3.sat


def _at(place, agent, landmark, radius):
    gaps = [place[f"{agent}.{axis}"] - place[f"{landmark}.{axis}"] for axis in "xy"]
    return z3.And(*(side for gap in gaps for side in (gap <= number(radius), gap >= number(-radius))))


def _pushes(policy, place, goal):
    """The direction that a tree chooses, per axis, as nested conditions."""
    tree, found = policy.tree, {}
    at = {**place, **{f"goal.{axis}": place[f"{goal}.{axis}"] for axis in "xy"}}
    for node in reversed(range(len(tree.feature))):
        if tree.feature[node] == ir.NO_FEATURE:
            effect = policy.actions[tree.action[node]].effect
            found[node] = [number(Fraction(part)) for part in effect]
            continue
        terms = policy.features[tree.feature[node]].meaning.terms
        measured = z3.Sum(*(weight * at[name] for weight, name in terms))
        line = half_line(float(tree.threshold[node]), True)
        below = measured < number(line.end) if line.strict else measured <= number(line.end)
        sides = zip(found[int(tree.left[node])], found[int(tree.right[node])], strict=True)
        found[node] = [z3.If(below, left, right) for left, right in sides]
    return found[ir.ROOT]


# --- the benchmark


def fitted(depth, seed=0, samples=40_000):
    """A profile whose defenders go to their own landmarks along the longer axis, as trees of a depth."""
    world = PhysicalDeception()
    rng = np.random.default_rng(seed)
    state = world.start(samples, rng)
    policies = []
    for agent, features, actions in zip(world.agents, world.features, world.actions, strict=True):
        obs = world.observe(state)[world.agents.index(agent)]
        own = max(0, world.agents.index(agent) - 1)
        dx, dy = (obs[:, [f.name for f in features].index(f"landmark_{own}_d{axis}")] for axis in "xy")
        wanted = np.where(np.abs(dx) > np.abs(dy), np.where(dx > 0, 2, 1), np.where(dy > 0, 4, 3))
        grown = DecisionTreeClassifier(max_depth=depth, random_state=seed).fit(obs, wanted)
        shape = grown.tree_
        action = grown.classes_[shape.value[:, 0].argmax(axis=1)]
        leaf = shape.children_left < 0
        learnt = ir.GrownTree(
            np.where(leaf, ir.NO_FEATURE, shape.feature),
            np.where(leaf, 0.0, shape.threshold),
            np.where(leaf, ir.NO_CHILD, shape.children_left),
            np.where(leaf, ir.NO_CHILD, shape.children_right),
            np.where(leaf, action, ir.NO_ACTION),
        )
        policies.append(ir.AgentPolicy(agent, world.team_of(agent), features, actions, deploy_tree(learnt)))
    return ir.PolicyProfile(world.spec, tuple(policies), ir.Provenance("fitted", "none", seed, "", "benchmark"))


def small_box(profile, side, seed):
    """A start region of a side around random places, one goal."""
    rng = np.random.default_rng(seed)
    half = Fraction(side) / 2
    box = {}
    for name in everywhere(profile).box:
        middle = Fraction(round(float(rng.uniform(-0.9, 0.9)), 3)).limit_denominator(1000)
        box[name] = (middle - half, middle + half)
    return Region(box, ("landmark_0",), name=f"box {seed} of side {side}")


def compare(depths, seeds, side, limit):
    """Rows (depth, box, claim, zones' verdict, zones, seconds, Z3's answer, seconds)."""
    rows = []
    for depth in depths:
        profile = fitted(depth)
        for seed in seeds:
            region = small_box(profile, side, seed)
            for name in ("reaches", "covers"):
                claim = find_claim(name, profile)
                start = time.perf_counter()
                found = decide(Question(Game(profile), claim, region))
                ours = time.perf_counter() - start
                start = time.perf_counter()
                violated = unrolled(profile, claim, region, "landmark_0", limit)
                theirs = time.perf_counter() - start
                if violated is not None and found.verdict is not Verdict.UNKNOWN:
                    assert violated == (found.verdict is Verdict.VIOLATED), (depth, region.name, name)
                rows.append((depth, seed, name, found.verdict.value, found.zones, ours, violated, theirs))
                said = {None: "gave up", True: "VIOLATED", False: "PROVED"}[violated]
                ours_said = f"zones {found.verdict.value:8} {found.zones:7,} in {ours:7.3f} s"
                theirs_said = f"Z3 {said:8} in {theirs:7.2f} s   ratio {theirs / ours:8.0f}"
                print(f"depth {depth:2} box {seed} {name:8} {ours_said}   {theirs_said}", flush=True)
    return rows


def everywhere_table(depths, budget):
    """The whole start region, 25 steps, each claim: verdict, zones and seconds per depth."""
    figures = []
    for depth in depths:
        profile = fitted(depth)
        for name in ("reaches", "covers"):
            start = time.perf_counter()
            found = decide(
                Question(
                    Game(profile), find_claim(name, profile), everywhere(profile), budgets=Budgets(max_zones=budget)
                )
            )
            seconds = time.perf_counter() - start
            said = f"{found.verdict.value:8} {found.zones:10,} zones {seconds:7.2f} s"
            print(f"whole start region, depth {depth:2} {name:8} {said}", flush=True)
            figures.append(
                {"name": f"{name}, whole start region, depth {depth}, s", "value": seconds, "better": "lower"}
            )
    return figures


def certificate_table(depths, seeds, side):
    """Proved claims: bytes and branches of their certificates, seconds to find and to check one."""
    committed = load(Path(__file__).parents[2] / "generated" / "proved_defenders" / "profile.json")
    arrivers = team(committed, arriving(0), arriving(1))
    whole = everywhere(committed)
    halved = replace(whole, box={name: (low / 2, high / 2) for name, (low, high) in whole.box.items()})
    cases = []
    for depth in depths:
        profile = fitted(depth)
        cases += [(f"depth {depth} box {seed}", profile, small_box(profile, side, seed)) for seed in seeds]
    cases += [
        ("hand-made, whole start region", arrivers, whole),
        ("proved defenders, start region halved", committed, halved),
    ]
    closed = spent = searched = 0.0
    for where, profile, region in cases:
        for name in ("reaches", "covers"):
            claim = find_claim(name, profile)
            start = time.perf_counter()
            found = decide(Question(Game(profile), claim, region, budgets=Budgets(max_zones=1_000_000)))
            decided = time.perf_counter() - start
            if found.verdict is not Verdict.PROVED:
                print(f"{where:34} {name:8} {found.verdict.value}: no certificate ({decided:.2f} s)", flush=True)
                continue
            start = time.perf_counter()
            certificate = build_certificate(Question(Game(profile), claim, region), found.parts)
            proving = time.perf_counter() - start
            start = time.perf_counter()
            branches = check_certificate(certificate, profile)
            checking = time.perf_counter() - start
            closed, spent, searched = closed + branches, spent + checking, searched + proving
            size = f"{count_bytes(certificate.proof):9,} bytes {branches:8,} branches"
            times = f"zones {decided:5.2f} s, found in {proving:5.2f} s, checked in {checking:5.2f} s"
            print(f"{where:34} {name:8} {size}   {times}", flush=True)
    each, finding = 1e6 * spent / closed, 1e6 * searched / closed
    print(f"to check {each:.1f} us per branch, to find {finding:.1f} s per million branches")
    return [
        {"name": "checking a certificate, us per branch", "value": each, "better": "lower"},
        {"name": "finding a certificate, s per million branches", "value": finding, "better": "lower"},
    ]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--full", action="store_true")
    parser.add_argument("--certificates", action="store_true", help="only what certificates cost")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    if options.certificates:
        figures = certificate_table((4, 6), range(4), "1/20")
        if options.json:
            print(json.dumps({"figures": figures}))
        return
    depths = (4, 6, 8) if options.full else (4, 6)
    rows = compare(depths, range(4 if options.full else 2), "1/20", 5 * MINUTE if options.full else MINUTE)
    ratio = math.exp(float(np.mean([math.log(row[7] / row[5]) for row in rows])))
    gave_up = sum(row[6] is None for row in rows)
    print(f"geometric mean of the ratios {ratio:.0f} (target 50, stretch 500); Z3 gave up on {gave_up} of {len(rows)}")
    figures = [{"name": "Z3 unrolling / zones", "value": ratio, "reach": 50, "stretch": 500, "better": "higher"}]
    figures += everywhere_table((4, 6, 8, 10) if options.full else (4, 6, 8), 50_000_000)
    figures += certificate_table((4, 6), range(4 if options.full else 2), "1/20")
    if options.json:
        print(json.dumps({"figures": figures}))


if __name__ == "__main__":
    main()
