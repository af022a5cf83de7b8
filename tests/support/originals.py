"""What the files of tests/corpus answer when their own language runs them: Python in a process of its own, C by gcc.

Does: calls each file's function as the manifest says, for many observations; one process for all files of a language.
Assumes: files of the corpus, which are ours; a C compiler on the path.
Does not: import anything of ours.

As a program it is the Python half: it reads cases from a file of NumPy and a JSON file, and writes answers as JSON.
"""

import json
import subprocess
import sys
from contextlib import redirect_stdout
from enum import Enum
from os import devnull
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

CORPUS = Path(__file__).parents[1] / "corpus"
GIVE = {
    "row": lambda values, names: ((values,), {}),
    "array": lambda values, names: ((np.array(values, dtype=np.float64),), {}),
    "row_number": lambda values, names: (tuple(values), {}),
    "columns": lambda values, names: (tuple(values), {}),
    "keywords": lambda values, names: ((), dict(zip(names, values, strict=True))),
    "names": lambda values, names: ((dict(zip(names, values, strict=True)),), {}),
    "attributes": lambda values, names: ((SimpleNamespace(**dict(zip(names, values, strict=True))),), {}),
}
TYPES = {"d": float, "f": float, "i": int, "b": bool}
DRIVER = """#include <stdio.h>
#include <stdlib.h>
#define main main_{place}
#include "{path}"
#undef main
static FILE *answers;
static inline void number(double value) {{ fprintf(answers, "%.17g\\n", value); }}
static inline void text(const char *value) {{ fprintf(answers, "%s\\n", value); }}
static inline void scores(const double *value, int n) {{
    int best = 0;
    for (int i = 1; i < n; i++) if (value[i] > value[best]) best = i;
    fprintf(answers, "%d\\n", best);
}}
static void decide(const double *X) {{ {call} }}
void case_{place}(FILE *rows, FILE *out, int n, int width);
void case_{place}(FILE *rows, FILE *out, int n, int width) {{
    double X[64];
    answers = out;
    for (int i = 0; i < n; i++) {{
        if (fread(X, sizeof(double), (size_t)width, rows) != (size_t)width) exit(1);
        decide(X);
    }}
}}
"""


def answers(cases: list[tuple[dict[str, Any], np.ndarray]], folder: Path) -> list[list[list[Any]]]:
    """What each file's function answers for each of its observations: all that the answer may be called."""
    found: dict[int, list[list[Any]]] = {}
    for suffix, ask in ((".py", _python), ("", _c)):
        chosen = [
            place for place, (file, _) in enumerate(cases) if (Path(file["path"]).suffix == ".py") == bool(suffix)
        ]
        if chosen:
            found |= dict(zip(chosen, ask([cases[place] for place in chosen], folder), strict=True))
    return [found[place] for place in range(len(cases))]


def _python(cases: list[tuple[dict[str, Any], np.ndarray]], folder: Path) -> list[list[list[Any]]]:
    np.savez(folder / "rows.npz", *(rows for _, rows in cases))
    (folder / "files.json").write_text(json.dumps([file for file, _ in cases]))
    subprocess.run([sys.executable, __file__, str(folder)], check=True, timeout=600)
    return json.loads((folder / "answers.json").read_text())


def _c(cases: list[tuple[dict[str, Any], np.ndarray]], folder: Path) -> list[list[list[Any]]]:
    sources = list[str]()
    for place, (file, _) in enumerate(cases):
        text = DRIVER.format(path=(CORPUS / file["path"]).resolve(), call=file["call"], place=place)
        (folder / f"case_{place}.c").write_text(text)
        sources.append(f"case_{place}.c")
    declared = "".join(f"void case_{place}(FILE *, FILE *, int, int);\n" for place in range(len(cases)))
    calls = "".join(
        f'case_{place}(rows, out, {len(rows)}, {rows.shape[1]}); fputs("end\\n", out);\n'
        for place, (_, rows) in enumerate(cases)
    )
    (folder / "all.c").write_text(
        f"#include <stdio.h>\n{declared}int main(int n, char **names)\n{{\n(void)n;\n"
        f'FILE *rows = fopen(names[1], "rb"), *out = fopen(names[2], "w");\n{calls}return fclose(out);\n}}\n'
    )
    command = ["gcc", "-std=c11", "-O0", "-w", "-ffp-contract=off", *sources, "all.c", "-lm", "-o", "all"]
    subprocess.run(command, cwd=folder, check=True, timeout=600)
    with (folder / "rows.bin").open("wb") as to:
        for _, rows in cases:
            to.write(np.ascontiguousarray(rows, dtype=np.float64).tobytes())
    subprocess.run(
        [folder / "all", "rows.bin", "out.txt"], cwd=folder, check=True, timeout=600, stdout=subprocess.DEVNULL
    )
    blocks = (folder / "out.txt").read_text().split("end\n")[:-1]
    return [[[_plain(line)] for line in block.splitlines()] for block in blocks]


def _plain(line: str) -> int | float | str:
    try:
        return int(line) if line.lstrip("-").isdigit() else float(line)
    except ValueError:
        return line


# --- the process that runs Python files


def _main(folder: Path) -> None:
    files = json.loads((folder / "files.json").read_text())
    found: list[list[list[Any]]] = []
    with np.load(folder / "rows.npz") as rows, open(devnull, "w") as nowhere, redirect_stdout(nowhere):  # noqa: PTH123
        for place, file in enumerate(files):
            found.append(_asked(file, rows[f"arr_{place}"].tolist()))
    (folder / "answers.json").write_text(json.dumps(found))


def _asked(file: dict[str, Any], rows: list[list[float]]) -> list[list[Any]]:
    path = CORPUS / file["path"]
    module = type(sys)(path.stem)
    module.__file__ = str(path)
    sys.modules[path.stem] = module  # dataclasses look themselves up there
    exec(compile(path.read_text(), path.name, "exec"), module.__dict__)
    function: Any = module
    for name in file["entry"].split("."):
        function = getattr(function, name)
        function = function() if isinstance(function, type) else function
    types, give = [TYPES[kind] for kind in file["kinds"]], GIVE[file["takes"]]
    found: list[list[Any]] = []
    for row in rows:
        some, named = give([of(value) for of, value in zip(types, row, strict=True)], file["features"])
        found.append(_called(function(*some, **named), file.get("scores", False)))
    return found


def _called(value: Any, scores: bool) -> list[Any]:
    """What an answer may be called: an Enum's member has a name and a value."""
    if isinstance(value, Enum):
        return [value.name, f"{type(value).__name__}.{value.name}", _called(value.value, scores)[0]]
    if scores:
        return [value.index(max(value))]
    return [value.item() if isinstance(value, np.generic) else value]


if __name__ == "__main__":
    _main(Path(sys.argv[1]))
