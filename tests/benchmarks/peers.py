"""Other generators and runtimes on the tree that our code decides: what they cost, and where they decide otherwise.

m2cgen, tl2cgen and emlearn write C; ONNX Runtime, m2cgen's Python and scikit-learn's predict decide in Python. Each
gets what it asks for (doubles, entries that may be missing, float32), so no conversion is timed. The measure of what is
wrong is scikit-learn's own tree: it rounds observations to float32 and sends NaN to the bigger side of a split that
saw none when it was fitted. NaN goes right in our code, by its contract, so there it counts as different too. Peers:
the extra maviper[bench]; who does not install or fails is named with the reason.
"""

import contextlib
import ctypes
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from sklearn.ensemble import RandomForestClassifier

from codegen import ir
from codegen.agreement import probes
from codegen.importers import scikit
from codegen.targets import emit

STYLES = ("nested", "ordered", "walk")
BASE = "nested"
ROWS = 1 << 15  # observations that are timed
DRIVER = """
#include <math.h>
#include <stdint.h>
#include <string.h>
#define WAY(name, type) \\
    long name##_chain(const type *rows) \\
    { \\
        long long at = 1; \\
        for (int i = 0; i < ROWS; i++) { \\
            at = ((i * 2654435761LL >> 5) + 7919 * name##_decide(rows + at * FEATURES)) & (ROWS - 1); \\
        } \\
        return (long)at; \\
    } \\
    long name##_free(const type *rows) \\
    { \\
        long sum = 0; \\
        for (int i = 0; i < ROWS; i++) { \\
            sum += name##_decide(rows + i * FEATURES); \\
        } \\
        return sum; \\
    } \\
    void name##_rows(const type *rows, long n, int *actions) \\
    { \\
        for (long i = 0; i < n; i++) { \\
            actions[i] = name##_decide(rows + i * FEATURES); \\
        } \\
    }
static inline int largest(const double *of)
{
    int best = 0;
    for (int k = 1; k < CLASSES; k++) {
        best = of[k] > of[best] ? k : best;
    }
    return best;
}
"""


@dataclass(frozen=True)
class Way:
    """C that decides: files, and a function NAME_decide over a row of `kind`, which `held` makes of an array."""

    name: str
    files: dict[str, str]
    text: str
    kind: str
    held: object


def singles(x):
    return np.ascontiguousarray(x, dtype=np.float32)


def doubles(x):
    return np.ascontiguousarray(x, dtype=np.float64)


def entries(x):
    """As doubles; an entry that is missing says so in its low half."""
    held = doubles(x).copy()
    held.view(np.int64)[np.isnan(held)] = 0xFFFFFFFF
    return held


def ours(style, classifier):
    files = emit(scikit.from_sklearn(classifier), ["c"], prefix=style, style=style)
    text = f'#include "{style}.h"\n#define {style}_decide {style}_agent_0_act\n'
    return Way(style, files, text, "float", singles)


def m2cgen(forest):
    import m2cgen as peer

    text = """#include "m2cgen.inc"
static inline int m2cgen_decide(const double *x)
{
    double of[CLASSES];
    score((double *)x, of);
    return largest(of);
}
"""
    return Way("m2cgen", {"m2cgen.inc": peer.export_to_c(forest.estimators_[0])}, text, "double", doubles)


def tl2cgen(forest):
    import tl2cgen as peer
    import treelite

    with tempfile.TemporaryDirectory() as place:
        peer.generate_c_code(treelite.sklearn.import_model(forest), dirpath=place, params={})
        files = {name: (Path(place) / name).read_text() for name in ("main.c", "header.h")}
    text = """#include "main.c"
static inline int tl2cgen_decide(const union Entry *x)
{
    double of[CLASSES] = {0};
    predict((union Entry *)x, 0, of);
    return largest(of);
}
"""
    return Way("tl2cgen", files, text, "union Entry", entries)


def emlearn(forest):
    with np.errstate():  # it has NumPy raise for the whole process
        import emlearn as peer

    with tempfile.TemporaryDirectory() as place:
        written = Path(place) / "emlearn.h"
        peer.convert(forest.estimators_[0], method="inline", dtype="float").save(file=str(written), name="emlearn")
        files = {"emlearn.h": written.read_text()}
    text = '#include "emlearn.h"\n#define emlearn_decide(x) emlearn_predict(x, FEATURES)\n'
    return Way("emlearn", files, text, "float", singles)


def m2cgen_python(forest):
    """One decision of m2cgen's Python over a list."""
    import m2cgen as peer

    space = {}
    exec(peer.export_to_python(forest.estimators_[0]), space)
    score = space["score"]

    def decide(row):
        of = score(row)
        return of.index(max(of))

    return decide


def onnx_session(forest):
    """A function from observations [batch, n_features] float32 to labels, of ONNX Runtime on one thread."""
    import onnxruntime
    from skl2onnx import to_onnx

    classifier = forest.estimators_[0]
    model = to_onnx(classifier, np.zeros((1, classifier.n_features_in_), dtype=np.float32), options={"zipmap": False})
    how = onnxruntime.SessionOptions()
    how.intra_op_num_threads = how.inter_op_num_threads = 1
    session = onnxruntime.InferenceSession(model.SerializeToString(), how, providers=["CPUExecutionProvider"])
    name = session.get_inputs()[0].name
    return lambda x: session.run(["label"], {name: x})[0]


def attempt(name, make, forest, missing):
    """What `make` makes, or None with the reason among `missing`."""
    try:
        with contextlib.redirect_stdout(sys.stderr):
            return make(forest)
    except Exception as error:
        missing.append(f"{name}: {type(error).__name__}: {str(error).splitlines()[0] if str(error) else ''}")
        return None


def fitted(tree, x):
    """A forest of one tree that has learnt to act as `tree`: what every peer can read."""
    forest = RandomForestClassifier(1, bootstrap=False, max_features=None, max_depth=int(ir.depth(tree).max()))
    return forest.set_params(random_state=0).fit(x, tree.action[ir.apply(tree, x)])


def built(ways, forest, compiler, folder):
    """The ways in one library."""
    for way in ways:
        for name, text in way.files.items():
            (folder / name).write_text(text)
    body = "".join(f"{way.text}WAY({way.name}, {way.kind})\n" for way in ways)
    (folder / "ways.c").write_text(DRIVER + body)
    defined = [f"-DFEATURES={forest.n_features_in_}", f"-DCLASSES={forest.n_classes_}", f"-DROWS={ROWS}"]
    command = [compiler, "-std=gnu99", "-O3", "-w", "-fPIC", "-shared", "-fno-semantic-interposition", *defined]
    subprocess.run([*command, "ways.c", "-o", "ways.so", "-lm"], cwd=folder, check=True, capture_output=True, text=True)
    return ctypes.CDLL(str(folder / "ways.so"))


def asked(classifier):
    """{question: observations}: each that scikit-learn's own tree must be followed in."""
    policy = scikit.from_sklearn(classifier).agents[0]
    rng = np.random.default_rng(2)
    near = probes.boundary(policy.tree, policy.features, rng)
    beside = near + 0.49 * rng.uniform(-1, 1, near.shape) * np.spacing(np.abs(near)).astype(np.float64)
    assert (beside.astype(np.float32) == near).all()
    nan = rng.uniform(-1, 1, (20_000, classifier.n_features_in_)).astype(np.float32)
    nan[np.arange(len(nan)), rng.integers(nan.shape[1], size=len(nan))] = np.nan
    return {
        "float32 at thresholds": near,
        "doubles that round to these": beside,
        "NaN": nan,
    }


def figure(name, value, **more):
    return {"name": name, "value": value, "better": "lower", **more}


def wrong(name, act, questions, classifier):
    """How many decisions of `act` are not those of scikit-learn's tree, a figure a question."""
    found = []
    for question, x in questions.items():
        expected = classifier.tree_.predict(x.astype(np.float32)).reshape(len(x), -1).argmax(axis=1)
        count = int((np.asarray(act(x)) != expected).sum())
        found.append(figure(f"{name}: decided otherwise, {question} (of {len(x):,})", count))
    return found


def c_figures(forest, compiler, rounds, missing):
    """Ratios to nested ifs, chain and free, and what is wrong, of C."""
    classifier = forest.estimators_[0]
    made = [attempt(make.__name__, make, forest, missing) for make in (m2cgen, tl2cgen, emlearn)]
    ways = [*(ours(style, classifier) for style in STYLES), *(way for way in made if way)]
    with tempfile.TemporaryDirectory() as place:
        library = built(ways, forest, compiler, Path(place))
    pool = np.random.default_rng(3).uniform(-1, 1, (ROWS, forest.n_features_in_)).astype(np.float32)
    rows = {way.name: way.held(pool) for way in ways}
    times = {(way.name, what): [] for way in ways for what in ("chain", "free")}
    for _ in range(rounds):
        for (name, what), held in times.items():
            run = library[f"{name}_{what}"]
            started = time.thread_time()
            run(ctypes.c_void_p(rows[name].ctypes.data))
            held.append(time.thread_time() - started)
    found = []
    for (name, what), held in times.items():
        if name != BASE:
            ratio = float(np.median(np.array(held) / np.array(times[BASE, what])))
            found.append(figure(f"C of {name} over nested ifs, {what}", ratio))
    questions = asked(classifier)
    for way in ways:
        found += wrong(f"C of {way.name}", lambda x, way=way: decided(library, way, x), questions, classifier)
    return found


def decided(library, way, x):
    rows, actions = way.held(x), np.empty(len(x), dtype=np.int32)
    library[f"{way.name}_rows"](
        ctypes.c_void_p(rows.ctypes.data), ctypes.c_long(len(x)), ctypes.c_void_p(actions.ctypes.data)
    )
    return actions


def python_figures(forest, plain, rounds, missing):
    """Ratios to `plain` (one decision over a list) and to tree_.predict (batches), and what is wrong, in Python."""
    classifier = forest.estimators_[0]
    x = np.random.default_rng(4).uniform(-1, 1, (ROWS, forest.n_features_in_)).astype(np.float32)
    rows = x[:1_000].tolist()
    m2cgen_act = attempt("m2cgen's Python", m2cgen_python, forest, missing)
    onnx = attempt("ONNX Runtime", onnx_session, forest, missing)
    one = {"scikit-learn's predict": (classifier.predict, [x[k : k + 1] for k in range(20)])}
    batches, questions, found = {}, asked(classifier), []
    if m2cgen_act:
        one["m2cgen's Python"] = m2cgen_act, rows
        found += wrong("m2cgen's Python", lambda x: [m2cgen_act(row) for row in x.tolist()], questions, classifier)
    if onnx:
        one["ONNX Runtime"] = onnx, [x[k : k + 1] for k in range(200)]
        batches["ONNX Runtime"] = onnx
        found += wrong("ONNX Runtime", lambda x: onnx(x.astype(np.float32)), questions, classifier)
    ratios = {name: [] for name in one} | {f"{name}, batch": [] for name in batches}
    for _ in range(rounds):
        base, whole = each(plain, rows), each(classifier.tree_.predict, [x])
        for name, (act, given) in one.items():
            ratios[name].append(each(act, given) / base)
        for name, act in batches.items():
            ratios[f"{name}, batch"].append(each(act, [x]) / whole)
    for name, held in ratios.items():
        over = "tree_.predict" if name.endswith("batch") else "plain nested ifs over a list"
        found.append(figure(f"{name} over {over}", float(np.median(held))))
    return found


def each(act, rows):
    """Seconds of one of a few calls."""
    started = time.thread_time()
    for row in rows:
        act(row)
    return (time.thread_time() - started) / len(rows)
