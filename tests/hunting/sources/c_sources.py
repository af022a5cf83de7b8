"""Random C sources, imported and asked beside the compiler: kinds `c-sources` and `c-beyond`.

Does: imports so many sources at once, compiles them as one translation unit in two ways, and compares.
Assumes: gcc; names of a file end with its seed. A row at which UBSan traps, or an assertion fails, has no answer.
Does not: draw sources.
"""

import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from tests.hunting.sources import c_beyond, c_programs, judging, observing
from tests.hunting.sources.drafts import Program, take
from tests.hunting.sources.judging import Import, Told

ASKED = ("#ifdef compiler", "#if system")  # steps that only a compiler can refuse: imported as a user does
ROOT = Path(__file__).parents[3]
SHORT = 700  # characters of a source that a finding keeps
COMPILER = ("gcc", "-std=gnu11", "-w", "-shared", "-fPIC", "-Wl,-Bsymbolic", "-Wl,--no-undefined")
STRICT = ("-Werror=implicit-function-declaration", "-Werror=implicit-int", "-Werror=int-conversion")
BUILDS = {
    "quick": ("-O1",),
    "plain": ("-O0", "-fsanitize=undefined,float-cast-overflow", "-fsanitize-undefined-trap-on-error"),
}
HEAD = """#include <setjmp.h>
#include <signal.h>
#include <stdbool.h>
#include <stdint.h>
#include <assert.h>
#include <math.h>
static sigjmp_buf hunt_env;
static void hunt_stop(int number) { siglongjmp(hunt_env, number); }
void __assert_fail(const char *a, const char *b, unsigned c, const char *d) { siglongjmp(hunt_env, 100); }
void abort(void) { siglongjmp(hunt_env, 101); }
"""
DRIVER = """
#line 1 "driver_{seed}.c"
long long labels_{seed}[16] = {{{labels}}};
void drive_{seed}(const double *d, const unsigned long long *u, long rows, long long *out, unsigned char *idle)
{{
    signal(SIGILL, hunt_stop); signal(SIGFPE, hunt_stop);
    for (volatile long row = 0; row < rows; row++, d += {count}, u += {count}) {{
        int stopped = sigsetjmp(hunt_env, 1);
        if (stopped) {{ idle[row] = stopped; continue; }}
        {call}
    }}
}}
"""
NUMBER = re.compile(r"(?<![\w.])(0[xX][\da-fA-F.]+(?:[pP][+-]?\d+)?|\d+\.?\d*(?:[eE][+-]?\d+)?|\.\d+)[fFuUlL]*")


def program(seed: int, beyond: bool) -> Program:
    """The source of a seed."""
    return take(c_programs.make, seed, c_beyond.STEPS) if beyond else c_programs.make(seed)[1]


def judge(programs: list[Program], run: bool = False) -> list[Told]:
    """Imports programs, has compiled C answer, and compares."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        every = {each.seed: Told(each.seed, kind=each.step or each.form) for each in programs}
        imports: dict[int, Import] = {}
        for each in programs:
            read = judging.read(each, folder / f"policy_{each.seed}.c", every[each.seed], run or each.step in ASKED)
            if read is not None:
                imports[each.seed] = read
        failed = build([each.program for each in imports.values()], folder)
        for seed, text in failed.items():
            again = judging.read(imports[seed].program, folder / f"policy_{seed}.c", every[seed], run=True)
            if again is not None:  # what no path reaches is refused by the product's own compiler alone
                every[seed].wrong.append(f"the compiler refuses it: {text}")
        rows = {seed: rows_of(each) for seed, each in imports.items() if seed not in failed}
        for seed, (numbers, whole) in rows.items():
            np.savez(folder / f"rows_{seed}.npz", rows=numbers, whole=whole)
        (folder / "jobs.json").write_text(json.dumps(list(rows)))
        command = [sys.executable, "-m", "tests.hunting.sources.c_child", str(folder)]
        subprocess.run(command, cwd=ROOT, check=True, stdin=subprocess.DEVNULL)
        for seed, pair in rows.items():
            _judge_answers(imports[seed], pair, folder / f"answers_{seed}.npz", every[seed])
    for each in programs:
        told = every[each.seed]
        told.wrong = [f"{text}\n{each.source[:SHORT]}" for text in told.wrong]
    return list(every.values())


def build(programs: list[Program], folder: Path) -> dict[int, str]:
    """Compiles programs; those that the compiler refuses, with what it says."""
    failed: dict[int, str] = {}
    for name, flags in BUILDS.items():
        while True:
            kept = [each for each in programs if each.seed not in failed]
            if not kept:
                break
            path = folder / f"{name}.c"
            path.write_text(HEAD + "".join(unit(each) for each in kept))
            command = [*COMPILER, *STRICT, *flags, str(path), "-o", str(folder / f"{name}.so"), "-lm"]
            done = subprocess.run(command, capture_output=True, text=True, check=False)
            if done.returncode == 0:
                break
            blamed = re.findall(r"(?:program|driver)_(\d+)\.c:.*(?:error|undefined reference).*", done.stderr)
            blamed = {int(each) for each in blamed} or {each.seed for each in kept if not _alone(each, flags, folder)}
            assert blamed, done.stderr
            for seed in blamed:
                said = [line for line in done.stderr.splitlines() if f"_{seed}.c" in line and "error" in line]
                failed[seed] = said[0][:200] if said else "it does not compile"
    return failed


def _alone(program: Program, flags: tuple[str, ...], folder: Path) -> bool:
    path = folder / "alone.c"
    path.write_text(HEAD + unit(program))
    command = [*COMPILER, *STRICT, *flags, str(path), "-o", str(folder / "alone.out"), "-lm"]
    return subprocess.run(command, capture_output=True, check=False).returncode == 0


def unit(program: Program) -> str:
    """A program and what asks it."""
    return f'\n#line 1 "program_{program.seed}.c"\n{program.source}{driver(program)}'


def driver(program: Program) -> str:
    """What asks a program each row."""
    values = []
    for place, feature in enumerate(program.features):
        typed = c_programs.CDraft.typed(feature.type)
        values.append(f"({typed}) {'u' if feature.type in observing.WHOLE else 'd'}[{place}]")
    joined = ", ".join(values)
    if program.form == "array":
        typed = c_programs.CDraft.typed(program.features[0].type)
        call = f"{typed} x[] = {{{joined}}}; out[row] = {program.agent}(x);"
    elif program.form == "columns":
        call = f"out[row] = {program.agent}({joined});"
    else:
        sign = "&" if program.form == "pointer" else ""
        call = f"input_{program.seed}_t x = {{{joined}}}; out[row] = {program.agent}({sign}x);"
    labels = ", ".join(program.labels) or "0"
    return DRIVER.format(seed=program.seed, labels=labels, count=len(program.features), call=call)


def numbers_of(source: str) -> list[float]:
    """Every number in a source, its whole numbers exactly."""
    out: set[float] = set()
    for text in NUMBER.findall(source):
        if text.lower().startswith("0x"):
            out.add(float.fromhex(text) if "p" in text.lower() else int(text, 16))
        else:
            out.add(int(text) if text.isdigit() else float(text))
    for one, other in re.findall(r"(\d+)[uUlL]* << (\d+)", source):
        out.add(int(one) << min(int(other), 64))
    return sorted(out)


def rows_of(read: Import) -> tuple[np.ndarray, np.ndarray]:
    """Rows as numbers, and as whole numbers."""
    types = [feature.type for feature in read.program.features]
    numbers = numbers_of(read.program.source)
    rows = observing.draw(types, map(float, numbers), read.tests, read.program.seed)
    whole = observing.whole_rows(
        rows, types, [int(each) for each in numbers if isinstance(each, int)], read.program.seed
    )
    for place, kind in enumerate(types):
        if kind in observing.WHOLE:
            rows[:, place] = whole[:, place].astype(np.int64) if not kind.startswith("u") else whole[:, place]
    return rows, whole


def _judge_answers(read: Import, pair: tuple[np.ndarray, np.ndarray], place: Path, told: Told) -> None:
    if not place.exists():
        told.wrong.append("compiled C comes to no end, or dies")
        return
    rows = pair[0]
    with np.load(place) as arrays:
        plain, trapped, quick = arrays["plain"], arrays["plain idle"] > 0, arrays["quick"]
        again = arrays["again"]
        apart = (plain[: len(again)] != again) & ~trapped[: len(again)]
        if apart.any() and not read.policy.memory:
            told.wrong.append(f"C answers {rows[np.flatnonzero(apart)[0]].tolist()} in two ways: state")
            return
        apart = (plain != quick) & ~trapped
        if apart.any():
            told.wrong.append(f"-O0 and -O2 answer {rows[np.flatnonzero(apart)[0]].tolist()} in two ways")
            return
        values, answers = np.unique(np.where(trapped, 0, plain), return_inverse=True)
        labels = [["number", int(each)] for each in values] + [["raised", "AssertionError"]]
        answers = np.where(trapped, len(values), answers)
        enumerators = dict(zip(read.program.labels, arrays["labels"].tolist(), strict=False))
    judging.compare(read, rows, answers, labels, "compiled", told, enumerators)


ask = judging.asking(program, judge)
