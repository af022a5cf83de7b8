"""Trees of others: whether imports decide as their origins, how large files may be, and what an import costs.

    python -m tests.benchmarks.interop [--json] [--trees N]
    python -m tests.benchmarks.interop --ifs [--json]

Differences are counted against the program that wrote a file, or that a compiler makes of it, at every threshold and
at both its float32 neighbours, and at random. A time is one of CPU, and a ratio to what the language itself needs
for the file: CPython to compile if/else Python, gcc -O0 to compile C.

--ifs: the command `maviper import` of a file of 5,000 nested ifs of Python and of C, as CPU time over that of a process
that parses it alone, in turns.
"""

import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import MinMaxScaler, StandardScaler
from sklearn.tree import DecisionTreeClassifier

from codegen import ir
from codegen.errors import InputError
from codegen.importers.c.source import from_c
from codegen.importers.onnx.model import decision_tree, from_onnx
from codegen.importers.origin import Names, profile_of
from codegen.importers.python.source import from_python
from codegen.importers.reading import Said
from tests.benchmarks.common import Figure, figure, reader, seconds, spent, spent_by, tell, with_children
from tests.codegen.importers.origins import asked, data
from tests.support.c_source import COMPILER, compiled, scores
from tests.support.python_source import nested

SCORES = Said(scores=True)
IFS = 12  # levels of 4,095 ifs
MANY = 5_000  # ifs of a file that is imported by a whole command
DIRECTIVES = "#include <stdint.h>\n#define IDLE 0\n#define TWICE(v) ((v) * 2)\n"
LARGE = 17  # levels: 131,072 leaves, 262,143 nodes


def fitted(seed: int) -> tuple[DecisionTreeClassifier, int]:
    """A tree of a random shape, and how many classes it knows."""
    x, y = data(seed, classes=2 + seed % 3)
    return DecisionTreeClassifier(max_depth=2 + seed % 8, random_state=seed).fit(x, y), len(np.unique(y))


def through_python(seed: int) -> int:
    """Differences of an imported tree from m2cgen's Python, run by Python."""
    import m2cgen

    text = m2cgen.export_to_python(fitted(seed)[0])
    policy, rows = asked(from_python(text.encode(), "tree.py", SCORES))
    space: dict[str, Any] = {}
    exec(text, space)
    said = [int(np.argmax(space["score"](row))) for row in rows.astype(np.float64).tolist()]
    return int((ir.act(policy, rows) != said).sum())


def through_c(seed: int) -> int:
    """Differences of an imported tree from m2cgen's C, as a compiler makes it."""
    import m2cgen

    model, n_classes = fitted(seed)
    text = m2cgen.export_to_c(model)
    policy, rows = asked(from_c(text.encode(), "tree.c", SCORES))
    with tempfile.TemporaryDirectory() as folder:
        said = scores(compiled(text, Path(folder)).score, rows, n_classes)
    return int((ir.act(policy, rows) != said).sum())


def through_onnx(seed: int) -> int:
    """Differences of an imported pipeline of two scalers and a tree from its model under onnxruntime."""
    import onnxruntime
    from skl2onnx import convert_sklearn
    from skl2onnx.common.data_types import FloatTensorType

    x, y = data(seed, classes=2 + seed % 3)
    tree = DecisionTreeClassifier(max_depth=2 + seed % 8, random_state=seed)
    pipeline = make_pipeline(StandardScaler(), MinMaxScaler(), tree).fit(x, y)
    model = convert_sklearn(pipeline, initial_types=[("x", FloatTensorType([None, x.shape[1]]))]).SerializeToString()
    (policy,) = from_onnx(model).agents
    rows = x[:, None, :] * np.array([1, 1 + 1e-7, 1 - 1e-7], dtype=np.float32)[:, None]
    rows = np.concatenate([rows.reshape(-1, x.shape[1]), beside(policy)])
    found = decision_tree(model)
    session = onnxruntime.InferenceSession(model, providers=["CPUExecutionProvider"])
    (said,) = session.run([found.output], {found.input: rows})
    return int((np.array(found.labels)[ir.act(policy, rows)] != said).sum())


def beside(policy: ir.AgentPolicy) -> np.ndarray:
    """Observations with one feature at, or next to, each threshold."""
    split = policy.tree.feature != ir.NO_FEATURE
    at, rng = policy.tree.threshold[split], np.random.default_rng(0)
    values = np.stack([np.nextafter(at, np.float32(-np.inf)), at, np.nextafter(at, np.float32(np.inf))], axis=1)
    rows = rng.normal(size=(len(at), 3, len(policy.features))).astype(np.float32)
    rows[np.arange(len(at)), :, policy.tree.feature[split]] = values
    return rows.reshape(-1, rows.shape[2])


def large() -> Iterator[Figure]:
    """A file of more than 200,000 nodes, in Python and in C."""
    bounds = dict.fromkeys(range(8), (-100.0, 100.0))
    python = "def act(x):\n" + "".join(nested(LARGE, bounds, " ", np.random.default_rng(0)))
    taken = taken_by(lambda: profile_of(from_python(python.encode(), "tree.py", SCORES), Names()))
    yield figure("262,143 nodes of if/else Python, s", taken, 60, 20)
    yield ratio("Python, import / CPython's compile", taken, taken_by(lambda: compile(python, "tree.py", "exec")))
    if COMPILER is None:
        return
    c = f"int act(const double *x)\n{{\n{''.join(in_c(python.splitlines()[1:]))}}}\n"
    taken = taken_by(lambda: profile_of(from_c(c.encode(), "tree.c", SCORES), Names()))
    yield figure("262,143 nodes of if/else C, s", taken, 60, 20)
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "tree.c").write_text(c)
        command = [COMPILER, "-O0", "-c", "-o", Path(folder) / "tree.o", Path(folder) / "tree.c"]
        peer = taken_by(lambda: subprocess.run(command, check=True))
    yield ratio("C, import / gcc -O0", taken, peer)


def taken_by(run: Callable[[], Any]) -> float:
    """Seconds of CPU of a call, with the processes that it starts."""
    return seconds(run, with_children)[0]


def in_c(lines: list[str]) -> Iterator[str]:
    """Lines of nested ifs of Python as C: each `else` follows the block of its `if`."""
    open_ = 0
    for line in lines:
        level = len(line) - len(line.lstrip())
        while open_ >= level:
            open_ -= 1
            yield "}\n"
        text = line.strip()
        if text.startswith("return"):
            yield f"{text};\n"
        else:
            yield "else {\n" if text == "else:" else f"if ({text[3:-1]}) {{\n"
            open_ = level
    yield "}\n" * open_


def python_ifs(count: int = MANY) -> str:
    """So many ifs of Python: a full tree, with more ifs at its first leaves."""
    rng, rest = np.random.default_rng(0), count - 2**IFS + 1
    lines = ["def act(x):\n"]
    for line in nested(IFS, dict.fromkeys(range(8), (-100.0, 100.0)), " ", rng):
        if "return" in line and rest > 0:
            indent, rest = line[: -len(line.lstrip())], rest - 1
            lines += [f"{indent}if x[9] <= {float(rng.uniform(-1, 1))!r}:\n", f"{indent} return 7\n"]
        lines.append(line)
    assert sum("if " in line for line in lines) == count
    return "".join(lines)


def ifs() -> Iterator[Figure]:
    """The whole command for many ifs of Python and of C, over a process that only parses the text, in turns."""
    c_parser = "from pycparser import CParser; CParser().parse"
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        (place / "act.py").write_text(python_ifs())
        (place / "act.i").write_text(c_ifs())  # which is C without directives
        (place / "act.c").write_text(DIRECTIVES + c_ifs())
        for language, parsed, parse, reach in (("py", "py", "import ast; ast.parse", 8), ("c", "i", c_parser, 3)):
            command = "import", place / f"act.{language}", "-o", place / "act.json"
            words = sys.executable, "-c", f"{parse}(open({str(place / f'act.{parsed}')!r}).read())"
            turns = [(spent(*command), spent_by(*words)) for _ in range(5)]
            assert not any(each.code for turn in turns for each in turn)
            value = float(np.median([ours.seconds / theirs.seconds for ours, theirs in turns]))
            yield figure(f"{MANY:,} ifs of {language}, command / a process that parses them", value, reach, reach - 1)


def c_ifs(count: int = MANY) -> str:
    """A function of C with a tree of so many ifs, each of which may hold or not."""
    names = ["speed", "gap", "level", "heat", "load", "angle", "rate", "mass"]
    rng, lines = np.random.default_rng(0), list[str]()

    def add_lines(left: int, bounds: dict[str, tuple[float, float]], level: int) -> None:
        pad = "    " * level
        if left == 0:
            lines.append(f"{pad}return {rng.choice(['STOP', 'GO', 'TURN'])};\n")
            return
        name = str(rng.choice(names))
        low, high = bounds[name]
        at = round(float(rng.uniform(low, high)), 4)
        lines.append(f"{pad}if (o->{name} <= {at}f) {{\n")
        add_lines((left - 1) // 2, {**bounds, name: (low, at)}, level + 1)
        lines.append(f"{pad}}} else {{\n")
        add_lines(left - 1 - (left - 1) // 2, {**bounds, name: (at, high)}, level + 1)
        lines.append(f"{pad}}}\n")

    add_lines(count, dict.fromkeys(names, (-100.0, 100.0)), 1)
    head = "typedef struct { float " + ", ".join(names) + "; } obs_t;\nenum action { STOP, GO, TURN };\n"
    return f"{head}int act(const obs_t *o)\n{{\n{''.join(lines)}}}\n"


def ratio(name: str, ours: float, peer: float) -> Figure:
    """A time as a ratio to a peer's."""
    return figure(name, ours / peer, 40, 10)


def main() -> None:
    """Prints a table, or one JSON object."""
    parser = reader(__doc__)
    parser.add_argument("--trees", type=int, default=20)
    parser.add_argument("--ifs", action="store_true")
    options = parser.parse_args()
    tell(ifs() if options.ifs else imports(options.trees), options.json)


def imports(trees: int) -> list[Figure]:
    """Figures of imported trees, of so many for each origin."""
    figures = []
    for name, differences in (
        ("m2cgen's Python", through_python),
        *((("m2cgen's C", through_c),) if shutil.which("cc") else ()),
        ("skl2onnx's pipelines", through_onnx),
    ):
        try:
            found = sum(differences(seed) for seed in range(trees))
        except (ImportError, InputError) as error:
            print(f"{name}: not run: {error}", file=sys.stderr)
            continue
        what = f"{name}: differences in {trees} trees"
        figures.append(figure(what, found, 0))
    return [*figures, *ifs(), *large()]


if __name__ == "__main__":
    main()
