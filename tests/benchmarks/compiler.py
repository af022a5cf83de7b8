"""How fast the emitted C and Python decide, as ratios to plain nested ifs of the same tree, in one interleaved run.

    python -m tests.benchmarks.compiler [--depth 6] [--rounds 9] [--compiler gcc] [--json]

A full tree of synthetic thresholds over 18 features, five actions, random float32 observations (a pool that a branch
predictor cannot learn), gcc -O3, one thread. chain: the next observation depends on the last action; free: decisions
that do not wait for one another; rows and columns: batches, the columns a power of two apart, so that all meet in the
same lines of a cache; columns apart: a little further, so that they do not; all: four different trees in one call, on
random observations and along a slow trajectory. Python: one decision against the same nested ifs over a list, written
here; batches against scikit-learn's `tree_.predict`. Size: the text of a vast tree, against nested ifs. Medians over
rounds of the ratio within a round.
"""

import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from sklearn.tree import DecisionTreeClassifier

from codegen import ir
from codegen.agreement import readback
from codegen.dynamics import motionless
from codegen.importers import scikit
from codegen.profiles import ensure
from codegen.targets import emit
from tests.benchmarks.common import figure, interleave, reader, tell
from tests.support.teams import nested

FEATURES, ACTIONS, AGENTS = 18, 5, 4
STYLES = ("nested", "ordered", "walk")
POOL = 1 << 15  # observations
TARGETS = {
    "chain": (0.75, 0.70), "free": (0.40, 0.34), "columns, -march=native": (0.07, 0.05),
    "columns apart, -march=native": (0.07, 0.05), "rows": (0.35, 0.19), "all, random": (0.40, 0.32),
    "all, trajectory": (0.90, 0.66),
}  # fmt: skip
MEASURES = (  # in the order in which the driver prints them
    *((loop, style) for loop in ("chain", "free") for style in STYLES),
    *((name, name) for name in ("rows", "columns", "columns apart")),
    *((f"all, {states}", way) for states in ("random", "trajectory") for way in ("nested", "all")),
)
PLACE = {measure: place for place, measure in enumerate(MEASURES)}
PYTHON_TARGETS = {2: (0.25, 0.16), 4: (0.30, 0.19), 6: (0.60, 0.52), 10: (1.1, 0.8)}
DECISION_TARGETS = (1.4, 1.2)


def full_tree(depth, rng):
    """A full tree, each test near the middle of what reaches it."""

    def grow(low, high, left):
        if left == 0:
            return int(rng.integers(ACTIONS))
        feature = int(rng.integers(FEATURES))
        cut = float(
            np.float32((low[feature] + high[feature]) / 2 + 0.1 * rng.normal() * (high[feature] - low[feature]))
        )
        below, above = high.copy(), low.copy()
        below[feature] = above[feature] = cut
        return feature, cut, grow(low, below, left - 1), grow(above, high, left - 1)

    return nested(grow(np.full(FEATURES, -1.0), np.full(FEATURES, 1.0), depth))


def team(depth, agents=AGENTS):
    """A profile of so many agents with full trees."""
    rng = np.random.default_rng(0)
    features = tuple(ir.FeatureSpec(f"x{k}", "none", -1.0, 1.0, None) for k in range(FEATURES))
    actions = tuple(ir.ActionSpec(f"a{k}", None) for k in range(ACTIONS))
    names = [f"agent_{agent}" for agent in range(agents)]
    policies = tuple(ir.AgentPolicy(name, "team", features, actions, full_tree(depth, rng)) for name in names)
    world = motionless("synthetic", "", names, 1, {})
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
    """Batches against scikit-learn's own tree, one decision against nested ifs."""
    found = []
    rng = np.random.default_rng(1)
    for depth, targets in PYTHON_TARGETS.items():
        x = rng.uniform(-1, 1, (40_000, FEATURES)).astype(np.float32)
        tree = full_tree(depth, rng)
        classifier = DecisionTreeClassifier(max_depth=depth, random_state=0).fit(x, tree.action[ir.apply(tree, x)])
        profile = scikit.from_sklearn(classifier)
        module = readback.load_python(next(iter(emit(profile, ["python"]).values())))
        imported = profile.agents[0].tree
        found += batch_figures(module["act_agent_0_batch"], classifier, imported, x, 15 * rounds, targets)
        if depth >= 6:
            found += decision_figures(module["act_agent_0"], classifier, imported, x[:1_000], rounds)
    return found


def batch_figures(act, classifier, tree, x, rounds, targets):
    """Batches against scikit-learn's own tree, and that beside numpy as anybody writes it."""
    leaves, depth = len(ir.leaves(tree)), int(ir.depth(tree).max())
    walk = by_level(tree)
    ways = {"ours": lambda: act(x), "sklearn": lambda: classifier.tree_.predict(x), "numpy": lambda: walk(x)}
    assert (ways["ours"]() == ways["numpy"]()).all()
    times = {name: np.array(each) for name, each in interleave(ways, rounds, time.thread_time).items()}
    over = {name: float(np.median(each / times["sklearn"])) for name, each in times.items()}
    name = f"depth {depth} ({leaves} leaves)"
    return [
        figure(f"python batch over tree_.predict, {name}", over["ours"], *targets),
        figure(f"numpy level by level over tree_.predict, {name}", over["numpy"]),
    ]


def by_level(tree):
    """A function of the tree that takes all rows of a batch down a level at a time; leaves lead to themselves."""
    leaf, here = tree.feature == ir.NO_FEATURE, np.arange(len(tree.feature))
    feature, left, right = (
        np.where(leaf, 0, tree.feature),
        np.where(leaf, here, tree.left),
        np.where(leaf, here, tree.right),
    )

    def act(x):
        node, rows = np.zeros(len(x), dtype=np.intp), np.arange(len(x))
        for _ in range(int(ir.depth(tree).max())):
            node = np.where(x[rows, feature[node]] <= tree.threshold[node], left[node], right[node])
        return tree.action[node]

    return act


def decision_figures(act, classifier, tree, x, rounds):
    """One decision against nested ifs over a list, and over `tolist()` of an array; scikit-learn's against it."""
    depth, rows, plain = int(ir.depth(tree).max()), x.tolist(), plain_python(tree)
    ways = {
        "list": (lambda: decided(act, rows), lambda: decided(plain, rows)),
        "array": (lambda: decided(act, x), lambda: [plain(row.tolist()) for row in x]),
    }
    found = []
    for given, (ours, theirs) in ways.items():
        assert ours() == theirs()
        name = f"python: one decision over plain nested ifs, {given}, depth {depth}"
        found.append(figure(name, ratio({"ours": ours, "theirs": theirs}, 20 * rounds), *DECISION_TARGETS))
    ways = {"ours": lambda: [classifier.predict(x[:1]) for _ in rows[:100]], "theirs": lambda: decided(act, rows[:100])}
    name = f"python: scikit-learn's predict over one decision, depth {depth}"
    return [*found, figure(name, ratio(ways, rounds), 100, better="higher")]


def ratio(ways, rounds):
    """The median over rounds of the first way's seconds over the other's, of this thread."""
    ours, theirs = interleave(ways, rounds, time.thread_time).values()
    return float(np.median(np.array(ours) / np.array(theirs)))


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
        found.append(figure(name, value, *(goal or ())))
    return found


def plain_c(tree, node=ir.ROOT):
    """The tree as nested ifs in C, as a program of twenty lines writes them."""
    if tree.feature[node] == ir.NO_FEATURE:
        return f"return {tree.action[node]};\n"
    below, above = plain_c(tree, tree.left[node]), plain_c(tree, tree.right[node])
    return f"if (x[{tree.feature[node]}] <= {tree.threshold[node]}f) {{\n{below}}} else {{\n{above}}}\n"


def size_figure(depth=16):
    """Bytes of a header in style nested over the same ifs by hand, of a tree that nobody reads."""
    profile = team(depth, agents=1)
    ((_, header),) = emit(profile, ["c"], style="nested").items()
    ratio = len(header) / len(plain_c(profile.agents[0].tree))
    return figure(f"C, depth {depth}, nested: bytes over the same by hand", ratio, 2.0, 1.2)


def main() -> None:
    parser = reader(__doc__)
    parser.add_argument("--depth", type=int, default=6)
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--compiler", default="gcc")
    options = parser.parse_args()
    if not shutil.which(options.compiler):
        print(f"{options.compiler}: not installed; no C was timed", file=sys.stderr)
    figures = c_figures(options) if shutil.which(options.compiler) else []
    tell([*figures, size_figure(), *python_figures(options.rounds)], options.json)


if __name__ == "__main__":
    main()
