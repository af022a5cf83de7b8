"""How fast the C of trees with sums decides, as ratios to the same by hand and to LightGBM, in one interleaved run.

    python -m tests.benchmarks.sums [--rounds 21] [--compiler gcc] [--json]

Trees of 64 leaves over 18 features, random observations. By hand: nested ifs with the same sums and thresholds, leaves
with the same sums, cut to the same bounds, in plain C without anything that keeps roundings apart. chain: the next
observation depends on the last answer; free: decisions that do not wait for one another. CPU time of this process.
LightGBM: a tree of its own with linear leaves, imported, against LGBM_BoosterPredictForMatSingleRowFast on the same
rows of doubles, called from C. Medians over rounds of the ratio within a round.
"""

import subprocess
import sys
import tempfile
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from codegen import ir
from codegen.importers.boosted import from_lightgbm
from codegen.importers.origin import Names, profile_of
from codegen.profiles import ensure
from codegen.sums import DOUBLE_SUMS, FLOAT32_STEPS, Sum
from codegen.targets import emit
from tests.benchmarks.common import figure, reader, tell

FEATURES, ACTIONS, LEVELS, OUTPUTS, TERMS = 18, 5, 6, 4, 4
POOL = 1 << 15
TREES = 5  # of each kind: where a compiler puts a branch moves the time of one tree by a tenth
REACH = {"sums of two": (1.0, 0.8), "linear leaves": (1.0, 0.9), "LightGBM": (0.5, 0.25)}
BOUND = 1.5


def single(value):
    """The nearest float32, as a double."""
    return float(np.float32(value))


def grown(rng, arithmetic, outputs):
    """A full tree: of sums of two where it takes actions, of single features and linear leaves where it gives."""
    rows, sums, vectors = [], [], []

    def grow(left):
        place = len(rows)
        rows.append(None)
        if left == 0:
            if not outputs:
                rows[place] = (ir.NO_FEATURE, 0.0, ir.NO_CHILD, ir.NO_CHILD, int(rng.integers(ACTIONS)))
                return place
            vectors.append(tuple(linear(rng) for _ in range(outputs)))
            rows[place] = (ir.NO_FEATURE, 0.0, ir.NO_CHILD, ir.NO_CHILD, len(vectors) - 1)
            return place
        if outputs:
            feature, threshold = int(rng.integers(FEATURES)), single(0.4 * rng.normal())
        else:
            a, b = rng.permutation(FEATURES)[:2].tolist()
            weights = (1.0, -1.0) if arithmetic == FLOAT32_STEPS else (single(rng.normal()), single(rng.normal()))
            made = Sum(tuple(zip(weights, (a, b), strict=True)))
            sums.extend([] if made in sums else [made])
            feature, threshold = FEATURES + sums.index(made), single(0.4 * rng.normal())
        left_child, right_child = grow(left - 1), grow(left - 1)
        rows[place] = (feature, threshold, left_child, right_child, ir.NO_ACTION)
        return place

    grow(LEVELS)
    arrays = (np.array(column) for column in zip(*rows, strict=True))
    return ir.Tree(*arrays, arithmetic=arithmetic, sums=tuple(sums), vectors=tuple(vectors))


def linear(rng):
    """A constant and weighted features."""
    places = rng.permutation(FEATURES)[:TERMS].tolist()
    return Sum(((single(rng.normal()), ir.CONSTANT), *((single(rng.normal()), place) for place in places)))


def team(tree, outputs):
    """A profile of one agent with this tree."""
    features = tuple(ir.FeatureSpec(f"x{k}", "none", -1.0, 1.0, None) for k in range(FEATURES))
    actions = () if outputs else tuple(ir.ActionSpec(f"a{k}", None) for k in range(ACTIONS))
    given = tuple(ir.OutputSpec(f"u{k}", "none", -BOUND, BOUND) for k in range(outputs))
    world = ir.WorldSpec("bench", "", (ir.EntitySpec("agent_0", 0.0, 0.0, None, False),), (), (), 0.0, 0.0, 0.0, 0.0, 1)
    policy = ir.AgentPolicy("agent_0", "team", features, actions, tree, outputs=given)
    return ensure(ir.PolicyProfile(world, (policy,), ir.Provenance("synthetic", "none", 0, "", "benchmark")))


def by_hand(tree, outputs):
    """The same tree as somebody writes it."""
    steps = tree.arithmetic == FLOAT32_STEPS

    def total(each):
        read = "x[{}]" if steps else "(double)x[{}]"
        number = (lambda value: f"{value.hex()}f") if steps else float.hex
        parts = [
            number(weight)
            if place == ir.CONSTANT
            else ("-" if weight == -1 else "" if weight == 1 else f"{number(weight)} * ") + read.format(place)
            for weight, place in each.terms
        ]
        return " + ".join(parts).replace("+ -x", "- x")

    def body(node, pad):
        place = int(tree.feature[node])
        if place == ir.NO_FEATURE:
            if not outputs:
                return [f"{pad}return {int(tree.action[node])};"]
            vector = tree.vectors[int(tree.action[node])]
            lines = [f"{pad}const double u{k} = {total(each)};" for k, each in enumerate(vector)]
            cut = "u{0} < -{1} ? -{1} : u{0} > {1} ? {1} : u{0}"
            return [*lines, *(f"{pad}y[{k}] = (float)({cut.format(k, BOUND)});" for k in range(outputs))]
        threshold = float(tree.threshold[node]).hex()
        plain = f"x[{place}] <= {threshold}f"
        summed = place >= FEATURES and f"{total(tree.sums[place - FEATURES])} <= {threshold}{'f' if steps else ''}"
        sides = [body(int(child), pad + "    ") for child in (tree.left[node], tree.right[node])]
        return [f"{pad}if ({summed or plain}) {{", *sides[0], f"{pad}}} else {{", *sides[1], f"{pad}}}"]

    head = "void hand(const float *x, float *y)" if outputs else "int hand(const float *x)"
    return "\n".join([f"static inline {head}", "{", *body(0, "    "), "}"])


GIVES = """
static int {name}_way(const float *x)
{{
    float y[{outputs}];
    {function}(x, y);
    return (y[0] > 0.0f) + (y[{last}] > 0.0f);
}}
"""


def against_hand(tree, outputs, compiler, flags, rounds):
    """Nanoseconds by hand and generated, [rounds, (chain hand, chain ours, free hand, free ours)]."""
    functions = {"hand": "hand", "ours": "bench_agent_0_act"}
    text = ['#include "bench.h"', by_hand(tree, outputs)]
    if outputs:
        for name, function in functions.items():
            text.append(GIVES.format(name=name, function=function, outputs=outputs, last=outputs - 1))
        functions = {name: f"{name}_way" for name in functions}
    ways = " ".join(f"each({name}, {function})" for name, function in functions.items())
    text += [f"#define WAYS(each) {ways}", "#define PREPARE"]
    files = {"bench.h": emit(team(tree, outputs), ["c"], prefix="bench")["bench.h"], "ways.h": "\n".join(text) + "\n"}
    return timed(files, compiler, flags, rounds, "float", ())


LIGHTGBM = """
#include "bench.h"
#include <stdint.h>
typedef void *Handle;
int LGBM_BoosterLoadModelFromString(const char *text, int *iterations, Handle *out);
int LGBM_BoosterPredictForMatSingleRowFastInit(Handle, int, int, int, int, int32_t, const char *, Handle *out);
int LGBM_BoosterPredictForMatSingleRowFast(Handle, const void *data, int64_t *length, double *out);
static Handle fast;
static char text[1 << 22];
static void prepare(void)
{
    Handle model;
    int iterations;
    FILE *file = fopen("model.txt", "rb");
    if (file == NULL || fread(text, 1, sizeof text - 1, file) == 0) exit(1);
    if (LGBM_BoosterLoadModelFromString(text, &iterations, &model) != 0) exit(1);
    if (LGBM_BoosterPredictForMatSingleRowFastInit(model, 0, 0, -1, 1, FEATURES, "num_threads=1", &fast) != 0) exit(1);
}
static int theirs(const double *x)
{
    int64_t length;
    double y;
    LGBM_BoosterPredictForMatSingleRowFast(fast, x, &length, &y);
    return y > 0.0;
}
static int ours(const double *x)
{
    double y;
    bench_agent_0_act(x, &y);
    return y > 0.0;
}
#define PREPARE prepare();
#define WAYS(each) each(theirs, theirs) each(ours, ours)
"""


def against_lightgbm(compiler, flags, rounds):
    """Nanoseconds of LightGBM and ours on its own tree with linear leaves, as above."""
    import lightgbm

    rng = np.random.default_rng(0)
    x = rng.uniform(-1, 1, (20_000, FEATURES))
    y = x[:, 0] * 2 + np.where(x[:, 1] > x[:, 2], x[:, 3], -x[:, 4]) + np.abs(x[:, 5]) * x[:, 6]
    settings = {"objective": "regression", "linear_tree": True, "num_leaves": 64, "num_threads": 1, "verbose": -1}
    model = lightgbm.train(settings, lightgbm.Dataset(x, y), 2).model_to_string(start_iteration=1, num_iteration=1)
    profile = profile_of(from_lightgbm(model.encode(), "model.txt"), Names())
    files = {"bench.h": emit(profile, ["c"], prefix="bench")["bench.h"], "ways.h": LIGHTGBM, "model.txt": model}
    (library,) = Path(find_spec("lightgbm").origin).parent.rglob("lib_lightgbm.so")
    return timed(files, compiler, flags, rounds, "double", (str(library), f"-Wl,-rpath,{library.parent}"))


def timed(files, compiler, flags, rounds, real, libraries):
    """Nanoseconds of each way in each round, [rounds, ways]."""
    with tempfile.TemporaryDirectory() as place:
        for name, text in files.items():
            (Path(place) / name).write_text(text)
        driver = (Path(__file__).parent / "sums_driver.c").resolve()
        defined = [f"-DFEATURES={FEATURES}", f"-DPOOL={POOL}", f"-DROUNDS={rounds}", f"-DREAL={real}"]
        command = [compiler, "-std=gnu99", "-O3", *flags, *defined, "-I.", str(driver), *libraries, "-o", "run"]
        subprocess.run(command, cwd=place, check=True)
        out = subprocess.run(["./run"], cwd=place, capture_output=True, text=True, check=True).stdout
    return np.array([[float(value) for value in line.split()] for line in out.splitlines()])


def figures(name, row, times):
    """The ratio of ours to the other way, chained and free."""
    reach, stretch = REACH[row]
    for place, how in ((0, "chain"), (2, "free")):
        ratio = float(np.median(times[:, place + 1] / times[:, place]))
        yield figure(f"{name}, {how}", ratio, reach, stretch)


def main():
    parser = reader(__doc__)
    parser.add_argument("--rounds", type=int, default=21)
    parser.add_argument("--compiler", default="gcc")
    given = parser.parse_args()
    found = []
    for flags in ([], ["-march=native"]):
        with_flags = " ".join(["", *flags])
        for name, row, arithmetic, outputs in (
            ("differences of two, float32 steps", "sums of two", FLOAT32_STEPS, 0),
            ("weighted sums of two, double sums", "sums of two", DOUBLE_SUMS, 0),
            (f"linear leaves of {OUTPUTS} outputs, double sums", "linear leaves", DOUBLE_SUMS, OUTPUTS),
        ):
            trees = [grown(np.random.default_rng(seed), arithmetic, outputs) for seed in range(TREES)]
            each = [against_hand(tree, outputs, given.compiler, flags, given.rounds) for tree in trees]
            times = np.concatenate(each)
            found += figures(f"{name} over by hand{with_flags}", row, times)
        if find_spec("lightgbm") is None:
            print("lightgbm is not installed: pip install lightgbm", file=sys.stderr)
        else:
            times = against_lightgbm(given.compiler, flags, given.rounds)
            found += figures(f"linear leaves over LightGBM's single row{with_flags}", "LightGBM", times)
    tell(found, given.json)


if __name__ == "__main__":
    main()
