"""Trees of others: whether imports decide as their origins, how large files may be, and what an import costs. Games of
others: what small trees reach there.

    python tests/benchmarks/interop.py [--json] [--trees N]
    python tests/benchmarks/interop.py --games turns|vmas [--json]
    python tests/benchmarks/interop.py --second [--json]
    python tests/benchmarks/interop.py --ifs [--json]

Differences are counted against the program that wrote a file, or that a compiler makes of it, at every threshold and
at both its float32 neighbours, and at random. A time is one of CPU, and a ratio to what the language itself needs
for the file: CPython to compile if/else Python, gcc -O0 to compile C.

--second: what it costs that the C compiler reads a file, too: seconds of CPU of imports with and without it, of a file
of the corpus and of 5,000 ifs, and of each build of these.

--ifs: the command `maviper import` of a file of 5,000 nested ifs, as CPU time over that of the parser alone: Python
(each the least of several, one after the other), and C.

--games turns: TicTacToe of PettingZoo, with turns and masks; trees of a player written by hand, against random moves.
--games vmas: navigation of VMAS; an expert is trained by reward, without a critic, and extracted. Both play in the
library's own loop, by the generated Python module. A share is (tree - random) / (expert - random), in returns.
"""

import argparse
import itertools
import json
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[2]))  # for tests.*, also when run by this path

import numpy as np
from pycparser import CParser
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import MinMaxScaler, StandardScaler
from sklearn.tree import DecisionTreeClassifier

from codegen import ir
from codegen.errors import InputError
from codegen.importers.c.compiled import TRAPS, UNCHECKED
from codegen.importers.c.source import from_c
from codegen.importers.onnx.graph import decision_tree
from codegen.importers.onnx.model import from_onnx
from codegen.importers.origin import Names, Said, profile_of
from codegen.importers.python.source import from_python
from tests.codegen.importers.origins import asked, data
from tests.support.c_source import COMPILER, compiled, scores
from tests.support.python_source import nested

SCORES = Said(scores=True)
IFS = 12  # levels of 4,095 ifs
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


def seconds(run: Callable[[], Any]) -> float:
    """CPU time of a call, with the processes that it starts."""
    start = time.process_time() + sum(children()[:2])
    run()
    return time.process_time() + sum(children()[:2]) - start


def children() -> tuple[float, ...]:
    """CPU time of ended children."""
    import os

    return tuple(os.times()[2:4])


def large() -> Iterator[dict[str, Any]]:
    """A file of more than 200,000 nodes, in Python and in C."""
    bounds = dict.fromkeys(range(8), (-100.0, 100.0))
    python = "def act(x):\n" + "".join(nested(LARGE, bounds, " ", np.random.default_rng(0)))
    taken = seconds(lambda: profile_of(from_python(python.encode(), "tree.py", SCORES), Names()))
    yield {"name": "262,143 nodes of if/else Python, s", "value": taken, "reach": 60, "stretch": 20, "better": "lower"}
    yield ratio("Python, import / CPython's compile", taken, seconds(lambda: compile(python, "tree.py", "exec")))
    if COMPILER is None:
        return
    c = f"int act(const double *x)\n{{\n{''.join(in_c(python.splitlines()[1:]))}}}\n"
    taken = seconds(lambda: profile_of(from_c(c.encode(), "tree.c", SCORES), Names()))
    yield {"name": "262,143 nodes of if/else C, s", "value": taken, "reach": 60, "stretch": 20, "better": "lower"}
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "tree.c").write_text(c)
        command = [COMPILER, "-O0", "-c", "-o", Path(folder) / "tree.o", Path(folder) / "tree.c"]
        peer = seconds(lambda: subprocess.run(command, check=True))
    yield ratio("C, import / gcc -O0", taken, peer)


def second() -> Iterator[dict[str, Any]]:
    """Seconds of CPU of imports of C, compared with the compiler and not, and of parsing alone."""
    corpus = (Path(__file__).parents[1] / "corpus/c/plant_watering.c").read_bytes()
    for name, content in (("plant_watering.c", corpus), ("5,000 ifs", many_ifs(5_000).encode())):
        for what, run in (("compared", True), ("not compared", False)):
            taken = seconds(lambda content=content, run=run: profile_of(from_c(content, "a.c", Said(run=run)), Names()))
            yield {"name": f"{name}, {what}, s of CPU", "value": taken, "reach": 60, "stretch": 5, "better": "lower"}
    text = many_ifs(5_000)
    taken = seconds(lambda: CParser().parse(text))
    yield {"name": "5,000 ifs, pycparser alone, s of CPU", "value": taken, "reach": 60, "stretch": 5, "better": "lower"}
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "a.c").write_text(text)
        for flags in (["-O0"], ["-O2"], ["-O0", TRAPS, UNCHECKED]):
            command = [str(COMPILER), *flags, "-c", "-o", f"{folder}/a.o", f"{folder}/a.c"]
            taken = seconds(lambda command=command: subprocess.run(command, check=True))
            name = f"5,000 ifs, compiler alone, {' '.join(flags)[:14]}, s of CPU"
            yield {"name": name, "value": taken, "reach": 60, "stretch": 5, "better": "lower"}


def many_ifs(count: int) -> str:
    """A balanced tree of ifs, a test of one of six features each."""

    def lines(left: int, box: dict[int, tuple[float, float]], indent: str) -> Iterator[str]:
        if left == 0:
            yield f"{indent}return {next(leaves) % 5};\n"
            return
        feature = int(rng.integers(6))
        low, high = box[feature]
        middle = round((low + high) / 2, 6)
        yield f"{indent}if (x[{feature}] <= {middle}f) {{\n"
        yield from lines((left - 1) // 2, {**box, feature: (low, middle)}, indent + " ")
        yield f"{indent}}} else {{\n"
        yield from lines(left - 1 - (left - 1) // 2, {**box, feature: (middle, high)}, indent + " ")
        yield f"{indent}}}\n"

    rng, leaves = np.random.default_rng(1), itertools.count()
    return f"int act(const float *x)\n{{\n{''.join(lines(count, dict.fromkeys(range(6), (-10.0, 10.0)), ' '))}}}\n"


def python_ifs(count: int = 5_000) -> Iterator[dict[str, Any]]:
    """The whole command on so many ifs, and a process that only parses them."""
    rng, rest = np.random.default_rng(0), count - 2**IFS + 1
    lines = ["def act(x):\n"]
    for line in nested(IFS, dict.fromkeys(range(8), (-100.0, 100.0)), " ", rng):
        if "return" in line and rest > 0:
            indent, rest = line[: -len(line.lstrip())], rest - 1
            lines += [f"{indent}if x[9] <= {float(rng.uniform(-1, 1))!r}:\n", f"{indent} return 7\n"]
        lines.append(line)
    assert sum("if " in line for line in lines) == count
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder) / "act.py"
        source.write_text("".join(lines))
        command = [sys.executable, "-m", "maviper", "import", str(source), "-o", str(Path(folder) / "act.json")]
        parse = [sys.executable, "-c", f"import ast; ast.parse(open({str(source)!r}).read())"]
        turns = [(seconds(lambda: quiet(command)), seconds(lambda: quiet(parse))) for _ in range(7)]
    ours, peer = (min(each) for each in zip(*turns, strict=True))
    name = f"{count:,} ifs, whole command / a process with ast.parse"
    yield {"name": name, "value": ours / peer, "reach": 8, "stretch": 5, "better": "lower"}


def quiet(command: list[str]) -> None:
    """Runs a command to its end, without its words."""
    subprocess.run(command, check=True, capture_output=True)


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


def ifs() -> Iterator[dict[str, Any]]:
    """The whole command for 5,000 ifs of C, over pycparser alone for the text behind its preprocessor, in turns."""
    from pycparser import CParser

    names = ["speed", "gap", "level", "heat", "load", "angle", "rate", "mass"]
    head = "typedef struct { float " + ", ".join(names) + "; } obs_t;\nenum action { STOP, GO, TURN };\n"
    plain = f"{head}int act(const obs_t *o)\n{{\n{nested_ifs(5_000, names)}}}\n"
    written = "#include <stdint.h>\n#define IDLE 0\n#define TWICE(v) ((v) * 2)\n" + plain
    ratios = []
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "tree.c").write_text(written)
        command = [sys.executable, "-m", "maviper", "import", f"{folder}/tree.c", "-o", f"{folder}/profile.json"]
        for _ in range(3):
            peer = seconds(lambda: CParser().parse(plain))
            ratios.append(seconds(lambda: subprocess.run(command, check=True, capture_output=True)) / peer)
            (Path(folder) / "profile.json").unlink()
    name = "5,000 ifs of C, command / pycparser alone"
    yield {"name": name, "value": float(np.median(ratios)), "reach": 3, "stretch": 2, "better": "lower"}


def nested_ifs(count: int, names: list[str]) -> str:
    """A tree of so many ifs of C, each of which may hold or not."""
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
    return "".join(lines)


def ratio(name: str, ours: float, peer: float) -> dict[str, Any]:
    """A time as a ratio to a peer's."""
    return {"name": name, "value": ours / peer, "reach": 40, "stretch": 10, "better": "lower"}


def main() -> None:
    """Prints a table, or one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--trees", type=int, default=20)
    parser.add_argument("--ifs", action="store_true")
    parser.add_argument("--games", choices=["turns", "vmas"])
    parser.add_argument("--second", action="store_true")
    options = parser.parse_args()
    figures = list(second()) if options.second else [*python_ifs(), *ifs()] if options.ifs else []
    figures = figures or (games(options.games) if options.games else imports(options.trees))
    if options.json:
        print(json.dumps({"figures": figures}))
        return
    for item in figures:
        print(f"{item['name']:75} {item['value']:10.2f}   reach {item['reach']}, stretch {item['stretch']}")


def games(which: str) -> list[dict[str, Any]]:
    """Figures of a game of another library."""
    from tests.benchmarks import outside

    return list({"turns": outside.turns, "vmas": outside.vmas}[which]())


def imports(trees: int) -> list[dict[str, Any]]:
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
        figures.append({"name": what, "value": found, "reach": 0, "stretch": 0, "better": "lower"})
    return figures + list(ifs()) + list(large())


if __name__ == "__main__":
    main()
