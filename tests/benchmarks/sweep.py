"""How fast boxes decide claims about stated systems, and how fast their covers are checked.

    python tests/benchmarks/sweep.py [--rounds 5] [--worlds [NAME ...]] [--vcas] [--json]

All times are of the processor. `--worlds` adds whole commands on generated/worlds/, all or the named ones: process
start, reference environment, second engine and control included; and `maviper check` over `maviper verify`, for these
and for the systems below, as files. The yardstick is plain numpy written for the one system: a
quadrotor whose tree of 90 leaves tests single variables. It is run in turn with our sweep, from the same start. Each
counts its own boxes, as slivers on borders differ. The other cases: a cruise controller with
drag (v squared, 100 steps, three claims), and MountainCar with a published tree (one cosine, 200 steps). Plain numpy
for the latter, intervals over 1,000 thin starts with libm's cosine, is run beside ours. Claims for ever about three
committed worlds come last.
"""

import argparse
import json
import math
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from dataclasses import replace
from fractions import Fraction as F
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))  # for tests.*, also when run by this path

import numpy as np
from sklearn.tree import DecisionTreeClassifier

from codegen.numbers import round_down
from codegen.policy_json import dumps
from codegen.world import EntitySpec
from maviper.files.profiles import find_profile
from maviper.worlds.stated.systems import read
from tests.support import system_cases as cases
from verify.checker.covers.sweep import BoxSweep, Cells
from verify.claims.region import UNBOUNDED
from verify.question import Budgets, Question
from verify.reach.decide import decide
from verify.subjects import ClosedLoop
from verify.systems.claims import Pattern, SystemClaim
from verify.systems.files import statement_of
from verify.systems.properties import claims_of

WORLDS = Path(__file__).parents[2] / "generated" / "worlds"
STEPS, DT, PUSH, HALF = 30, 0.2, 0.5, F(1, 10)
TARGETS = {
    "worlds, whole command, geometric mean, s": (2.0, 1.0, "lower"),
    "boxes a second over plain numpy": (1 / 3, 1.0, "higher"),
    "vcas, the slowest row, s": (2.0, 1.0, "lower"),
    "one `maviper check` over `maviper verify`": (1.0, 1 / 3, "lower"),
    "cruise, three claims with checks, s": (5.0, 2.0, "lower"),
    "valley, 200 steps, s": (3.0, 1.5, "lower"),
}
FOR_EVER = {
    "quadrotor": dict.fromkeys("xyz", (F(-3, 5), F(3, 5))),
    "pendulum": {"angle": (F(-3, 20), F(3, 20))},
    "crossing": dict.fromkeys(("north", "east"), (F(0), F(6))),
}
CRUISE = """
name = "cruise"
steps = 100
dt = "0.1 s"
[constants]
drag = "0.0005 1/m"
[variables]
gap = { unit = "m", range = [0, 120] }
v = { unit = "m/s", range = [0, 40] }
lead = { unit = "m/s", range = [15, 25] }
[agents.car.features]
gap = "gap"
speed = "v"
closing = "v - lead"
[agents.car.actions]
brake = { acc = "-3 m/s^2" }
coast = {}
drive = { acc = "1.5 m/s^2" }
[start]
box = { gap = [40, 50], v = [18, 22], lead = [19, 21] }
[dynamics]
next = { gap = "gap + dt*(lead - v)", v = "v + dt*(car.acc - drag*v**2)", lead = "lead" }
error = { v = 0.005 }
cuts = { v = 8 }
[[property]]
name = "stays_in"
region = { box = { gap = [5, 120] } }
[[property]]
name = "stays_in"
region = { box = { v = [10, 30] } }
[[property]]
name = "reaches_and_stays"
by = 90
region = { box = { gap = [10, 100] } }
"""
KEEPING = ((0, 15.0), 0, ((2, 1.0), ((0, 60.0), ((2, -0.5), 2, 1), 2), 0))
VALLEY = """
name = "valley"
steps = 200
[variables]
position = { range = [-1.25, 0.6] }
velocity = { range = [-0.08, 0.08] }
[agents.agent.features]
position = "position"
velocity = "velocity"
[agents.agent.actions]
left = { push = -1 }
right = { push = 1 }
[start]
box = { position = [-0.53, -0.47], velocity = 0 }
[dynamics.let]
after = "velocity + 0.001*agent.push - 0.0025*cos(3*position)"
[dynamics]
next = { position = "position + after", velocity = "after" }
cuts = { position = 60 }
[[property]]
name = "reaches"
region = { box = { position = [0.5, 10] } }
"""
CLIMBING = ((1, 0.01923), ((1, -0.00015), ((0, -0.94281), 1, 0), ((0, -0.38912), 1, 0)), 1)  # vgarciasc/erltrees


def fitted(axes=3, leaves=90):
    """A tree on the positions and velocities of some axes, fitted to a switching expert."""
    random = np.random.default_rng(0)
    seen = random.uniform(-1, 1, (20_000, 2 * axes)) * np.array([0.5] * axes + [0.3] * axes)
    wanted = ((seen[:, :axes] + 2 * seen[:, axes:] <= 0) * 2 ** np.arange(axes)).sum(axis=1)
    grown = DecisionTreeClassifier(max_leaf_nodes=leaves, random_state=0).fit(seen.astype(np.float32), wanted)

    def nested(node):
        tree = grown.tree_
        if tree.children_left[node] < 0:
            return int(grown.classes_[np.argmax(tree.value[node])])
        test = int(tree.feature[node]), float(round_down(tree.threshold[node]))
        return test, nested(tree.children_left[node]), nested(tree.children_right[node])

    names = [*"xyz"[:axes], *(f"v{name}" for name in "xyz"[:axes])]
    return cases.team(cases.policy("drone", names, [f"push{n}" for n in range(2**axes)], nested(0)))


def plain(tree):
    """The boxes of all steps, counted, by numpy for this one system."""
    low, high = np.array([[-float(HALF)] * 3 + [0.0] * 3]), np.array([[float(HALF)] * 3 + [0.0] * 3])
    pushes = np.array([[PUSH if number >> bit & 1 else -PUSH for bit in range(3)] for number in range(8)])
    total = 1
    for _ in range(STEPS):
        done, node = [], np.zeros(len(low), dtype=np.int64)
        while len(node):
            leaf = tree.feature[node] < 0
            done.append((low[leaf], high[leaf], tree.action[node[leaf]]))
            low, high, node = low[~leaf], high[~leaf], node[~leaf]
            rows, column, cut = np.arange(len(node)), tree.feature[node], tree.threshold[node].astype(float)
            left, right = low[rows, column] <= cut, high[rows, column] > cut
            below, above = high[left].copy(), low[right].copy()
            below[np.arange(len(below)), column[left]] = np.minimum(high[rows, column], cut)[left]
            above[np.arange(len(above)), column[right]] = np.maximum(low[rows, column], cut)[right]
            low, high = np.concatenate([low[left], above]), np.concatenate([below, high[right]])
            node = np.concatenate([tree.left[node[left]], tree.right[node[right]]])
        low, high, action = (np.concatenate(each) for each in zip(*done, strict=True))
        push = pushes[action]
        for bounds in (low, high):
            bounds[:, :3] += DT * bounds[:, 3:] + push * DT**2 / 2
            bounds[:, 3:] += push * DT
        total += len(low)
    return total


def timed(call):
    began = time.process_time()  # other work on the machine does not count
    return call(), time.process_time() - began


def beside_numpy(rounds):
    """Boxes a second in our sweep, over those of plain numpy, run in turn; seconds of one sweep."""
    system, profile = cases.double_integrator(axes=3, half=HALF), fitted()
    claim = cases.stays(system, STEPS, **dict.fromkeys("xyz", (F(-2), F(2))))
    found = []
    for _ in range(rounds):
        boxes, by_numpy = timed(lambda: plain(profile.agents[0].tree))
        swept, ours = timed(lambda: BoxSweep(profile, system, claim).run(Cells((0,))))
        found.append((by_numpy / boxes * swept / ours, ours))
    leaves = int((profile.agents[0].tree.feature < 0).sum())
    print(f"{leaves} leaves: plain numpy {boxes:,} boxes, ours {swept:,}", file=sys.stderr)
    return [statistics.median(column) for column in zip(*found, strict=True)]


def climbed(parts=1_000):
    """Whether all episodes of the valley reach its goal, by intervals over thin starts, for this one system. The bounds
    are not rounded outward, and libm's cosine is trusted.
    """
    ends = np.linspace(-0.53, -0.47, parts + 1)
    low, high, slow, fast = ends[:-1], ends[1:], np.zeros(parts), np.zeros(parts)
    for _ in range(200):
        go = ~(low >= 0.5)
        low, high, slow, fast = low[go], high[go], slow[go], fast[go]
        if not len(low):
            return True
        sides = [(low, high, slow, fast)]
        for column, cut in ((2, 0.01923), (2, -0.00015), (0, -0.94281), (0, -0.38912)):
            cuts = []
            for box in sides:
                below, above = box[column] <= cut, box[column + 1] > cut
                under, over = [each[below] for each in box], [each[above] for each in box]
                under[column + 1] = np.minimum(under[column + 1], cut)
                over[column] = np.maximum(over[column], cut)
                cuts += [tuple(under), tuple(over)]
            sides = cuts
        low, high, slow, fast = (np.concatenate(each) for each in zip(*sides, strict=True))
        at, speed = (low + high) / 2, (slow + fast) / 2
        left = (speed <= 0.01923) & np.where(speed <= -0.00015, at > -0.94281, at > -0.38912)
        ends = np.stack([np.cos(3 * low), np.cos(3 * high)])
        most = np.where((low <= 0) & (high >= 0), 1.0, ends.max(axis=0))
        least = np.where((3 * low <= -np.pi) & (3 * high >= -np.pi), -1.0, ends.min(axis=0))
        push = np.where(left, -0.001, 0.001)
        slow, fast = slow + push - 0.0025 * most, fast + push - 0.0025 * least
        low, high = low + slow, high + fast
    return False


def decided(text, profile):
    """(verdicts, seconds, boxes) of all claims of a file, each searched for, and its certificate made and checked."""
    statement = statement_of(text, "file")
    claims = claims_of(statement, profile, "file")
    subject = ClosedLoop(profile, statement.system)

    def answers():
        return [decide(Question(subject, claim, UNBOUNDED)) for claim in claims]

    found, seconds = timed(answers)
    return ", ".join(each.verdict.value for each in found), seconds, found[-1].boxes


def for_ever():
    """Seconds in which claims for ever about committed worlds are proved, their invariants made and checked."""
    found = {}
    for name, bounds in FOR_EVER.items():
        system = read(WORLDS / f"{name}.toml").system
        profile = find_profile(WORLDS / name / "profile.json", beside=WORLDS / name)
        claim = SystemClaim(Pattern.ALWAYS, (cases.box(**bounds),), 200)
        (answer,), found[f"{name} for ever, s"] = timed(
            lambda profile=profile, system=system, claim=claim: cases.decided(profile, system, [claim], Budgets())
        )
        print(f"{name} for ever: {answer.verdict.value}, {answer.branches:,} cells", file=sys.stderr)
    return found


def drone(axes="xyz"):
    """The system of the 90 leaves as a file."""
    pushes = [[PUSH if number >> bit & 1 else -PUSH for bit in range(len(axes))] for number in range(2 ** len(axes))]
    lines = ['name = "drone"', f"steps = {STEPS}", f'dt = "{DT} s"', "[variables]"]
    lines += [f'{name} = {{ unit = "m", range = [-10, 10] }}' for name in axes]
    lines += [f'v{name} = {{ unit = "m/s", range = [-10, 10] }}' for name in axes]
    lines += ["[agents.drone.features]", *(f'{name} = "{name}"' for axis in axes for name in (axis, f"v{axis}"))]
    lines += ["[agents.drone.actions]"]
    for number, push in enumerate(pushes):
        sets = ", ".join(f'a{name} = "{value} m/s^2"' for name, value in zip(axes, push, strict=True))
        lines.append(f"push{number} = {{ {sets} }}")
    starts = ", ".join(f"{name} = [-{HALF}, {HALF}], v{name} = 0" for name in axes).replace("1/10", "0.1")
    lines += ["[start]", f"box = {{ {starts} }}", "[dynamics.next]"]
    for name in axes:
        lines.append(f'{name} = "{name} + dt*v{name} + dt**2/2*drone.a{name}"')
        lines.append(f'v{name} = "v{name} + dt*drone.a{name}"')
    bounds = ", ".join(f"{name} = [-2, 2]" for name in axes)
    return "\n".join([*lines, "[[property]]", 'name = "stays_in"', f"region = {{ box = {{ {bounds} }} }}\n"])


def spent(*command):
    """Seconds of the processor that a command of ours took."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([sys.executable, "-m", "maviper", *map(str, command)], check=False, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def commanded(name, profile, world):
    """Seconds of `maviper verify`, and of a `maviper check` on each of its certificates, NaN where there is none."""
    with tempfile.TemporaryDirectory() as folder:
        verify = spent("verify", profile, "--world", world, "-o", f"{folder}/out")
        checks = [spent("check", each) for each in sorted(Path(folder, "out").glob("certificate-*.json"))]
    check = statistics.fmean(checks) if checks else math.nan
    told = f"{len(checks)} certificates, {check:.2f} s each" if checks else "no certificate"
    print(f"{name:<16} {verify:6.2f} s, {told}", file=sys.stderr, flush=True)
    return verify, check


def advised():
    """Seconds of whole commands on the rows of VCAS, a certificate made and checked where a row is PROVED."""
    rows = sorted((WORLDS / "vcas").glob("*.toml"))
    seconds = [commanded(path.stem, WORLDS / "vcas" / "vcas.json", path)[0] for path in rows]
    return {"vcas, mean of the rows, s": statistics.fmean(seconds), "vcas, the slowest row, s": max(seconds)}


def commands(wanted, stated):
    """Whole commands on the committed worlds, and check over verify on these and on some systems as files."""
    worlds = [path for path in sorted(WORLDS.glob("*.toml")) if path.stem in wanted or not wanted]
    rows = [commanded(path.stem, WORLDS / f"{path.stem.removesuffix('_wide')}.json", path) for path in worlds]
    values = {"worlds, whole command, geometric mean, s": math.exp(np.mean([math.log(verify) for verify, _ in rows]))}
    with tempfile.TemporaryDirectory() as folder:
        for name, text, team in () if wanted else stated:
            profile, world = Path(folder, f"{name}.json"), Path(folder, f"{name}.toml")
            players = tuple(EntitySpec(each.agent, 0.0, 0.0, None, False) for each in team.agents)
            profile.write_text(dumps(replace(team, world=replace(team.world, agents=players))))
            world.write_text(text)
            rows.append(commanded(name, profile, world))
    ratios = [check / verify for verify, check in rows if not math.isnan(check)]
    return values | {"one `maviper check` over `maviper verify`": math.exp(np.mean(np.log(ratios)))}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--worlds", nargs="*", metavar="NAME", help="also whole commands on the committed worlds")
    parser.add_argument("--vcas", action="store_true", help="whole commands on the rows of VCAS alone")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    told(advised() if options.vcas else measured(options), options.json)


def measured(options):
    """All figures but those of VCAS."""
    rate, ours = beside_numpy(options.rounds)
    values = {"boxes a second over plain numpy": rate, "90 leaves, one sweep, s": ours}
    car = cases.team(cases.policy("car", ["gap", "speed", "closing"], ["brake", "coast", "drive"], KEEPING))
    agent = cases.team(cases.policy("agent", ["position", "velocity"], ["left", "right"], CLIMBING))
    for name, text, team in (("cruise, three claims with checks", CRUISE, car), ("valley, 200 steps", VALLEY, agent)):
        verdicts, seconds, boxes = decided(text, team)
        print(f"{name}: {verdicts}, {boxes:,} boxes", file=sys.stderr)
        values[f"{name}, s"] = seconds
    shown, seconds = timed(climbed)
    assert shown, "plain numpy shows the valley"
    values["valley, plain numpy, s"] = seconds
    values |= for_ever()
    if options.worlds is not None:
        stated = [("90 leaves", drone(), fitted()), ("cruise", CRUISE, car), ("valley", VALLEY, agent)]
        values |= commands(options.worlds, stated)
    return values


def told(values, as_json):
    """Prints figures, beside their targets where these are asked for as JSON."""
    if as_json:
        keys = ("reach", "stretch", "better")
        targets = {name: dict(zip(keys, TARGETS.get(name, ()), strict=False)) for name in values}
        figures = [{"name": name, "value": float(value), **targets[name]} for name, value in values.items()]
        print(json.dumps({"figures": figures}))
    else:
        for name, value in values.items():
            print(f"{name:<50} {value:8.3f}")


if __name__ == "__main__":
    main()
