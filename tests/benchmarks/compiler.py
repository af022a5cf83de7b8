"""How fast the emitted C and Python decide, as ratios to plain nested ifs of the same tree, in one interleaved run.

    python tests/benchmarks/compiler.py [--depth 6] [--rounds 9] [--compiler gcc] [--json]

A full tree of synthetic thresholds over 18 features, five actions, random float32 observations (a pool that a branch
predictor cannot learn), gcc -O3, one thread. chain: the next observation depends on the last action; free: decisions
that do not wait for one another; rows and columns: batches, the columns a power of two apart, so that all meet in the
same lines of a cache; columns apart: a little further, so that they do not; all: four different trees in one call, on
random observations and along a slow trajectory. Python: one decision against the same nested ifs over a list, written
here; batches against scikit-learn's `tree_.predict`. Medians over rounds of the ratio within a round. Then the peers
that are installed, on a tree of scikit-learn's (peers.py).
"""

import argparse
import json
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from codegen import ir
from codegen.agreement import readback
from codegen.importers import scikit
from codegen.profiles import ensure
from codegen.targets import emit
from tests.benchmarks import peers

FEATURES, ACTIONS, AGENTS = 18, 5, 4
STYLES = ("nested", "ordered", "walk")
POOL = 1 << 15  # observations
TARGETS = {
    "chain": (0.75, 0.70),
    "free": (0.40, 0.34),
    "columns, -march=native": (0.07, 0.05),
    "columns apart, -march=native": (0.07, 0.05),
    "rows": (0.35, 0.19),
    "all, random": (0.40, 0.32),
    "all, trajectory": (0.90, 0.66),
}
MEASURES = (  # in the order in which the driver prints them
    *(("chain", style) for style in STYLES),
    *(("free", style) for style in STYLES),
    ("rows", "rows"),
    ("columns", "columns"),
    ("columns apart", "columns apart"),
    ("all, random", "nested"),
    ("all, random", "all"),
    ("all, trajectory", "nested"),
    ("all, trajectory", "all"),
)
PLACE = {measure: place for place, measure in enumerate(MEASURES)}
PYTHON_TARGETS = {2: (0.25, 0.16), 4: (0.30, 0.19), 6: (0.60, 0.52)}


def full_tree(depth, rng):
    """A full tree, each test near the middle of what reaches it."""
    nodes = []

    def grow(low, high, left):
        place = len(nodes)
        nodes.append(None)
        if left == 0:
            nodes[place] = (ir.NO_FEATURE, 0.0, ir.NO_CHILD, ir.NO_CHILD, int(rng.integers(ACTIONS)))
            return place
        feature = int(rng.integers(FEATURES))
        cut = float(
            np.float32((low[feature] + high[feature]) / 2 + 0.1 * rng.normal() * (high[feature] - low[feature]))
        )
        below, above = high.copy(), low.copy()
        below[feature] = above[feature] = cut
        children = grow(low, below, left - 1), grow(above, high, left - 1)
        nodes[place] = (feature, cut, *children, ir.NO_ACTION)
        return place

    grow(np.full(FEATURES, -1.0), np.full(FEATURES, 1.0), depth)
    return ir.Tree(*(np.array(column) for column in zip(*nodes, strict=True)))


def team(depth):
    """A profile of four agents with full trees."""
    rng = np.random.default_rng(0)
    features = tuple(ir.FeatureSpec(f"x{k}", "none", -1.0, 1.0, None) for k in range(FEATURES))
    actions = tuple(ir.ActionSpec(f"a{k}", None) for k in range(ACTIONS))
    names = [f"agent_{agent}" for agent in range(AGENTS)]
    policies = tuple(ir.AgentPolicy(name, "team", features, actions, full_tree(depth, rng)) for name in names)
    world = ir.WorldSpec(
        name="synthetic",
        reference="",
        agents=tuple(ir.EntitySpec(name, 0.0, 0.0, None, False) for name in names),
        landmarks=(),
        goals=(),
        dt=0.0,
        damping=0.0,
        start_low=-1.0,
        start_high=1.0,
        episode_steps=1,
    )
    return ensure(ir.PolicyProfile(world, policies, ir.Provenance("synthetic", "none", 0, "", "benchmark")))


def run_c(profile, compiler, flags, rounds):
    """Nanoseconds of each measure in each round, [rounds, measures]."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        for style in STYLES:
            for name, text in emit(profile, ["c"], prefix=style, style=style).items():
                (folder / name).write_text(text)
        driver = (Path(__file__).parent / "compiler_driver.c").resolve()
        defined = [f"-DFEATURES={FEATURES}", f"-DPOOL={POOL}", f"-DROUNDS={rounds}"]
        command = [compiler, "-std=gnu99", "-O3", *flags, *defined, "-I.", str(driver), "-o", "run"]
        subprocess.run(command, cwd=folder, check=True)
        out = subprocess.run([str(folder / "run")], capture_output=True, text=True, check=True).stdout
    return np.array([[float(value) for value in line.split()] for line in out.splitlines()])


def ratios(times, what):
    """Median ratio of each way of one measure to nested ifs."""
    base = times[:, PLACE[what, "nested"]]
    return {way: float(np.median(times[:, place] / base)) for (measure, way), place in PLACE.items() if measure == what}


def python_figures(rounds):
    """Batches against scikit-learn's own tree, one decision against nested ifs, and the peers."""
    found, missing = [], []
    rng = np.random.default_rng(1)
    for depth, (reach, stretch) in PYTHON_TARGETS.items():
        x = rng.uniform(-1, 1, (40_000, FEATURES)).astype(np.float32)
        forest = peers.fitted(full_tree(depth, rng), x)
        classifier = forest.estimators_[0]
        profile = scikit.from_sklearn(classifier)
        module = readback.load_python(next(iter(emit(profile, ["python"]).values())))
        ours, theirs = module["act_agent_0_batch"], classifier.tree_.predict
        ratio = float(np.median([seconds(ours, x) / seconds(theirs, x) for _ in range(5 * rounds)]))
        name = f"python batch over tree_.predict, depth {depth}"
        found.append({"name": name, "value": ratio, "reach": reach, "stretch": stretch, "better": "lower"})
    rows, act, plain = x[:1_000].tolist(), module["act_agent_0"], plain_python(profile.agents[0].tree)
    assert decided(plain, rows) == decided(act, rows)
    ratio = float(np.median([seconds(decided, act, rows) / seconds(decided, plain, rows) for _ in range(20 * rounds)]))
    name = "python: one decision over plain nested ifs over a list, depth 6"
    found.append({"name": name, "value": ratio, "reach": 1.0, "stretch": 1.0, "better": "lower"})
    each = [len(rows) * seconds(classifier.predict, x[:1], 20) / seconds(decided, act, rows) for _ in range(rounds)]
    name = "python: scikit-learn's predict over one decision, depth 6"
    found.append({"name": name, "value": float(np.median(each)), "reach": 100, "stretch": 100, "better": "higher"})
    return found + peers.python_figures(forest, plain, rounds, missing), forest, missing


def plain_python(tree):
    """The tree as nested ifs over a list, with float32 thresholds, written without our templates."""

    def lines(node, pad):
        if tree.feature[node] == ir.NO_FEATURE:
            return [f"{pad}return {tree.action[node]}"]
        opened = f"{pad}if x[{tree.feature[node]}] <= {float(tree.threshold[node])!r}:"
        inner = pad + "    "
        return [opened, *lines(tree.left[node], inner), f"{pad}else:", *lines(tree.right[node], inner)]

    space = {}
    exec("\n".join(["def act(x):", *lines(ir.ROOT, "    ")]), space)
    return space["act"]


def decided(act, rows):
    return [act(row) for row in rows]


def seconds(function, *arguments):
    """Of this thread, of one call, the mean of a few."""
    *given, number = arguments if isinstance(arguments[-1], int) else (*arguments, 3)
    started = time.thread_time()
    for _ in range(number):
        function(*given)
    return (time.thread_time() - started) / number


def c_figures(options):
    """The emitted C against nested ifs."""
    profile = team(options.depth)
    times = run_c(profile, options.compiler, [], options.rounds)
    native = run_c(profile, options.compiler, ["-march=native"], options.rounds)
    base = {what: ratios(times, what) for what in ("chain", "free", "all, random", "all, trajectory")}
    best = {what: min((value, way) for way, value in found.items() if way != "nested") for what, found in base.items()}
    batches = [("rows", times)]
    for kind in ("columns", "columns apart"):
        batches += [(kind, times), (f"{kind}, -march=native", native)]
    for what, measured in batches:
        kind = what.partition(",")[0]
        over = measured[:, PLACE[kind, kind]] / measured[:, PLACE["free", "nested"]]
        best[what] = float(np.median(over)), kind
    if not options.json:
        print(f"nested ifs: chain {np.median(times[:, 0]):.1f} ns, free {np.median(times[:, 3]):.1f} ns")
        for what in ("chain", "free"):
            print(f"{what}: " + ", ".join(f"{way} {value:.2f}" for way, value in base[what].items()))
    found = []
    for what, (value, way) in best.items():
        name = f"{options.compiler}, depth {options.depth}, {what} ({way})"
        goal = TARGETS.get(what) if options.depth == 6 else None
        more = {"reach": goal[0], "stretch": goal[1]} if goal else {}
        found.append({"name": name, "value": value, "better": "lower", **more})
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--depth", type=int, default=6)
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--compiler", default="gcc")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    python, forest, missing = python_figures(options.rounds)
    figures = []
    if shutil.which(options.compiler):
        figures += c_figures(options)
        figures += peers.c_figures(forest, options.compiler, options.rounds, missing)
    else:
        missing.append(f"{options.compiler}: not installed; no C was timed")
    figures += python
    for line in missing:
        print(f"not run: {line}", file=sys.stderr)
    if options.json:
        print(json.dumps({"figures": figures}))
        return
    for item in figures:
        goal = f"  (reach {item['reach']:g}, stretch {item['stretch']:g})" if "reach" in item else ""
        value = f"{item['value']:,}" if isinstance(item["value"], int) else f"{item['value']:.3f}"
        print(f"{item['name']}: {value}{goal}")


if __name__ == "__main__":
    main()
