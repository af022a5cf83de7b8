"""A wide tree as C, Python and JSON, written and compared by plain code that knows no other tree.

    python tests/benchmarks/plain_compile.py [--rounds N]

Beside it stands `maviper compile` for the same tree and targets, in turns; CPU seconds, process start included, and the
least of the rounds. The plain code asks each of its three files, one by one, about as many observations as the command
does: the C once, in a batch; nothing about input checks, other types of numbers, batches or syntax.
"""

import argparse
import ctypes
import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[2]))

import numpy as np

ROWS = 93_000  # about as many as the command draws for that tree


def compile_plainly(profile: Path, folder: Path) -> None:
    """The forty lines."""
    agent = json.loads(profile.read_text())["agents"][0]
    place = {each["name"]: k for k, each in enumerate(agent["features"])}
    number = {each["name"]: k for k, each in enumerate(agent["actions"])}
    nodes = agent["tree"]

    def text(node: int, level: int, test: str, leaf: str) -> str:
        each, pad = nodes[node], "    " * level
        if "action" in each:
            return f"{pad}{leaf.format(number[each['action']])}\n"
        head, middle, end = (
            part.format(place[each["feature"]], each["float32"], each["threshold"]) for part in test.split("|")
        )
        left, right = (text(each[side], level + 1, test, leaf) for side in ("left", "right"))
        return f"{pad}{head}\n{left}{pad}{middle}\n{right}{pad + end if end else ''}\n"

    c = text(0, 1, "if (x[{0}] <= {1}f) {{|}} else {{|}}", "return {};")
    run = (
        f"void run(const float *x, long n, int *a) {{ for (long i = 0; i < n; i++) a[i] = act(x + {len(place)} * i); }}"
    )
    (folder / "tree.c").write_text(f"static int act(const float *x)\n{{\n{c}}}\n{run}\n")
    subprocess.run(["cc", "-std=c99", "-O2", "-fPIC", "-shared", "tree.c", "-o", "tree.so"], cwd=folder, check=True)
    python = text(0, 1, "if x[{0}] <= {2!r}:|else:|", "return {}")
    (folder / "tree.py").write_text(f"def act(x):\n{python}")
    (folder / "tree.json").write_text(json.dumps(nodes))
    rows = np.random.default_rng(0).uniform(-1, 1, (ROWS, len(place))).astype(np.float32)
    acted = np.empty(ROWS, np.int32)
    pointers = [ctypes.c_void_p(each.ctypes.data) for each in (rows, acted)]
    ctypes.CDLL(str(folder / "tree.so")).run(pointers[0], ctypes.c_long(ROWS), pointers[1])
    module: dict[str, Any] = {}
    exec((folder / "tree.py").read_text(), module)
    assert acted.tolist() == [module["act"](row.tolist()) for row in rows]
    read = json.loads((folder / "tree.json").read_text())
    for numbers, action in zip(rows, acted.tolist(), strict=True):
        row, node = numbers.tolist(), read[0]
        while "action" not in node:
            node = read[node["left" if row[place[node["feature"]]] <= node["threshold"] else "right"]]
        assert number[node["action"]] == action


def main() -> None:
    """Both in turns."""
    from codegen.policy_json import dumps
    from tests.benchmarks.large import spent, spent_by, wide

    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("--rounds", type=int, default=3)
    rounds = parser.parse_args().rounds
    with tempfile.TemporaryDirectory() as folder:
        profile, code = Path(folder) / "wide.json", str(Path(folder) / "code")
        profile.write_text(dumps(wide()))
        seconds = [
            (
                spent(["compile", str(profile), "--target", "c,python,json", "-o", code]).seconds,
                spent_by([sys.executable, __file__, "--plainly", str(profile), folder]).seconds,
            )
            for _ in range(rounds)
        ]
    ours, plain = map(min, zip(*seconds, strict=True))
    print(f"maviper compile: CPU {ours:.2f} s; plain code: CPU {plain:.2f} s; {ours / plain:.2f} times that")


if __name__ == "__main__":
    if "--plainly" in sys.argv:
        compile_plainly(Path(sys.argv[2]), Path(sys.argv[3]))
    else:
        main()
