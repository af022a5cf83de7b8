"""A C file as the C compiler reads it: compiled three times, run, and asked for its answers.

Does: builds what unit.py writes without optimisation, with it, and with traps for what C leaves undefined; asks all of
  them about rows; says where they differ, and where a trap is met; hands their answers to the replay.
Assumes: what is compiled was accepted by the reader: it calls nothing outside the file but functions of numbers.
Does not: use anything that the reader computed. It runs in a scratch folder, with limits.

A compiler may join a product and a sum unless the source forbids it, so the second build lets it. In the first one,
whole numbers wrap around: compilers leave out additions before their traps see them (`w + 5 > 9` is `w > 4`), so an
overflow may show only as a difference of the two.
"""

import shutil
import tempfile
import weakref
from collections.abc import Generator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import replace
from functools import cached_property, partial
from itertools import repeat
from pathlib import Path
from subprocess import CompletedProcess
from typing import Any

import numpy as np

from codegen.agreement.compiled import find_compiler
from codegen.agreement.programs import run
from codegen.errors import InputError, MissingToolError, escape_text
from codegen.importers.c.compiled.tokens import ensure_same_tokens, list_headers
from codegen.importers.c.compiled.unit import CHAR, WIDE, Asked, write_unit
from codegen.importers.c.kinds import Place
from codegen.importers.c.text import Expanded
from codegen.importers.reading import Answers, Origin, Running, Said
from codegen.ir import Floats

COMPILED_BY = "the C compiler (-O0, -O2, UBSan)"
TRAPPING = "UBSan"
PLAIN = "-std=c11 -D_DEFAULT_SOURCE -Werror=implicit-function-declaration".split()  # noqa: SIM905
TRAPS = "-fsanitize=undefined,float-cast-overflow"
UNCHECKED = "-fno-sanitize=null,alignment,object-size,pointer-overflow"  # of memory that unit.py lays out
LIMIT_S, BUILD_S = 120, 1_800
NO_TRAPS = "set CC to gcc or clang, or say --no-run"
Answer = int | float | str
EACH, FAILED = 1, "!"  # a mode of the driver, and its word for a row at which an assertion fails


class Compiled:
    """The builds of one file. `contracts`: whether a compiler may join roundings."""

    def __init__(self, unit: str, asked: Sequence[Asked], compiler: list[str], where: str, *, contracts: bool) -> None:
        self._unit, self._compiler, self._where = unit, compiler, where
        self._asked = {each.name: (at, each) for at, each in enumerate(asked)}
        joined = ["-ffp-contract=fast", "-march=native"] if contracts else ["-ffp-contract=off"]
        self._flags = {
            "-O0": ["-O0", "-fwrapv", "-ffp-contract=off", "-DMAVIPER_NUMBERS"],
            "-O2": ["-O2", *joined],
            TRAPPING: ["-O0", "-ffp-contract=off", TRAPS, UNCHECKED, "-fno-sanitize-recover=all"],
        }

    @cached_property
    def _folder(self) -> Path:
        """The scratch folder with all builds. InputError for what the compiler does not take."""
        folder = Path(tempfile.mkdtemp(prefix="maviper-"))
        weakref.finalize(self, shutil.rmtree, folder, ignore_errors=True)
        (folder / "unit.c").write_text(self._unit)
        (folder / "driver.c").write_text(DRIVER)
        with ThreadPoolExecutor() as pool:
            for name, built in zip(self._flags, pool.map(self._build, repeat(folder), self._flags), strict=True):
                if built.returncode and name == TRAPPING:
                    raise MissingToolError(f"{self._compiler[0]} builds nothing with {TRAPS}", _first(built), NO_TRAPS)
                if built.returncode:
                    what = f"the C compiler does not take what was read: {escape_text(_first(built))[:200]}"
                    raise InputError(what, self._where, "give C that a compiler takes as it stands")
        return folder

    def _build(self, folder: Path, name: str) -> CompletedProcess[str]:
        def build_with(flags: Sequence[str]) -> CompletedProcess[str]:
            command = [*self._compiler, *PLAIN, *flags, "unit.c", "driver.c", "-lm", "-o", name.strip("-")]
            return run(command, folder, BUILD_S)

        first = build_with(self._flags[name])
        if first.returncode and "-march=native" in self._flags[name]:
            return build_with([each for each in self._flags[name] if each != "-march=native"])
        if first.returncode and name == TRAPPING:  # where there is no library that says what was met
            return build_with([*self._flags[name], "-fsanitize-undefined-trap-on-error"])
        return first

    @cached_property
    def numbers(self) -> list[float]:
        """The numbers that the file's constant expressions give."""
        said = run([str(self._folder / "O0"), "numbers"], self._folder, LIMIT_S).stdout
        return sorted({float.fromhex(each) for each in said.split()})

    def types(self, function: str) -> list[str]:
        """The type of each feature: NumPy's name of it, or char. InputError for one of 64 bits."""
        types = self._run(function, "O0", np.zeros((0, 1))).stdout.split()
        for type_, place in zip(types, self._asked[function][1].features, strict=True):
            if type_ == WIDE:
                what = f"{_name_place(place)} is a whole number of 64 bits, whose large numbers are no float64"
                raise InputError(what, f"{self._where}, function {function}", "declare it int32_t or uint32_t")
        return types

    def answers(self, function: str, rows: Floats) -> list[tuple[Answer, ...]]:
        """Runs the builds, and returns their common answer for each row.

        InputError where a build traps, dies or answers otherwise than another one.
        """
        with ThreadPoolExecutor() as pool:
            given = list(pool.map(self._run, repeat(function), [each.strip("-") for each in self._flags], repeat(rows)))
        lines = list[list[str]]()
        for name, said in zip(self._flags, given, strict=True):
            if said.returncode:
                again = self._run(function, name.strip("-"), rows, EACH)
                place = max(again.stdout.count("\n") - 1, 0)
                raise self._make_error(function, rows[place], _reason(again))
            lines.append(said.stdout.splitlines()[1:])
        for place, each in enumerate(zip(*lines, strict=True)):
            if FAILED in each:
                raise self._make_error(function, rows[place], "an assertion fails that the reader does not see")
            if len(set(each)) > 1:
                told = ", ".join(f"{name} {line.strip()}" for name, line in zip(self._flags, each, strict=True))
                raise self._make_error(function, rows[place], f"builds of it answer differently: {told}")
        known = {each: tuple(map(_part, each.split())) for each in set(lines[0])}
        return [known[each] for each in lines[0]]

    def ensure_failing(self, function: str, rows: Floats) -> None:
        """InputError unless an assertion fails at each of the rows that the reader leaves out."""
        said = self._run(function, "O0", rows).stdout.splitlines()[1:]
        for place in np.flatnonzero(np.array(said, np.str_) != FAILED)[:1].tolist():
            what = "the reader leaves out an observation at which no assertion fails"
            raise self._make_error(function, rows[place], what)

    def _run(self, function: str, build: str, rows: Floats, mode: int = 0) -> CompletedProcess[str]:
        at, _ = self._asked[function]
        place = self._folder / f"rows-{build}"
        np.ascontiguousarray(rows, dtype=np.float64).tofile(place)
        command = [str(self._folder / build), str(at), str(rows.shape[1]), str(mode)]
        return run(command, self._folder, LIMIT_S, place)

    def _make_error(self, function: str, row: Any, what: str) -> InputError:
        features = self._asked[function][1].features[:20]
        shown = [f"{_name_place(place)} {value!r}" for place, value in zip(features, row.tolist(), strict=False)]
        advice = "test for such numbers first, exclude them by an assert, or compute in a wider type"
        return InputError(what, f"{self._where}, function {function}, at {', '.join(shown)}", advice)


def _name_place(place: Place) -> str:
    """A feature, as messages call it."""
    return ".".join(map(str, (place.base, *place.way)))


def _first(said: CompletedProcess[str]) -> str:
    """The first line of a compiler's errors."""
    lines = said.stderr.strip().splitlines()
    return next((line for line in lines if "error" in line), lines[0] if lines else "no word")


def _reason(said: CompletedProcess[str]) -> str:
    """Why a program ended."""
    for line in said.stderr.splitlines():
        if "runtime error: " in line:
            return f"what it does is not defined in C: {escape_text(line.partition('runtime error: ')[2])[:120]}"
    return f"it ends there, with status {said.returncode}: what it does is not defined in C, or it calls abort"


def _part(word: str) -> Answer:
    if word[0] == "t":
        return bytes.fromhex(word[1:]).decode(errors="replace")
    if word[0] == "c":
        code = int(word[1:])
        return chr(code) if 32 < code < 127 else code
    digits = word.lstrip("-")
    return int(word) if digits.isdigit() else float.fromhex(word)


# --- answers for the replay


def ask_compiler(
    origins: Mapping[str, tuple[Origin, Asked]], parsed: Any, text: Expanded, where: str, said: Said
) -> dict[str, Origin]:
    """The origins, which the builds answer for; without a compiler, or where nothing may be run, nobody does.
    InputError where the preprocessors differ.
    """
    compiler = find_compiler() if said.run else None
    if compiler is None:
        return {name: origin for name, (origin, _) in origins.items()}
    ensure_same_tokens(text, compiler, where)
    asked = [each for _, each in origins.values()]
    unit = write_unit(parsed, asked, text.names, list_headers(text))
    compiled = Compiled(unit, asked, compiler, where, contracts=text.contracts)
    return {
        name: replace(
            origin, second=partial(_run_builds, origin, name, compiled, scores=said.scores), replayed_by=COMPILED_BY
        )
        for name, (origin, _) in origins.items()
    }


@contextmanager
def _run_builds(origin: Origin, name: str, compiled: Compiled, *, scores: bool) -> Generator[Running]:
    """The numbers of a source, and what answers observations."""
    types = compiled.types(name)
    letters = [place for place, kind in enumerate(types) if kind == CHAR]

    def ask_rows(rows: Floats) -> Answers:
        taken = np.ones(len(rows), np.bool_) if origin.takes is None else origin.takes(rows)
        if origin.takes is not None and "overflow" not in origin.given:  # where assertions alone rule observations out
            compiled.ensure_failing(name, rows[~taken & ~np.isnan(rows).any(axis=1)])
        taken &= (rows[:, letters] >= 0).all(axis=1)  # a char may have a sign, or none
        answers = compiled.answers(name, rows[taken])
        told = np.zeros((len(rows), len(origin.vectors[0])) if origin.vectors else len(rows))
        if len(answers) and origin.vectors:
            told[taken] = answers
        elif len(answers):
            places = {label: place for place, label in enumerate(origin.labels)}
            told = told.astype(np.int32)
            told[taken] = [places.get(_label(each, scores=scores), -1) for each in answers]
        words = dict(zip(np.flatnonzero(taken).tolist(), answers, strict=True))
        return Answers(told, taken, np.ones(len(rows), np.bool_), lambda place: _word(words[place]))

    yield Running(compiled.numbers, ask_rows, ["int8" if each == CHAR else each for each in types])


def _word(answer: Sequence[Answer]) -> str:
    return escape_text(repr(answer[0] if len(answer) == 1 else list(answer)))[:200]


def _label(answer: Sequence[Answer], *, scores: bool) -> Any:
    if len(answer) == 1:
        return answer[0]
    return answer.index(max(answer)) if scores else tuple(answer)


# --- the program around the file: rows in, answers out, nothing else; POSIX for its limits, elsewhere time alone

DRIVER = r"""
#include <setjmp.h>
#include <stdio.h>
#include <stdlib.h>
#if defined(__unix__) || defined(__APPLE__)
#include <sys/resource.h>
#include <unistd.h>
static void limit(int what, rlim_t most) {
    struct rlimit both = {most, most};
    if (setrlimit(what, &both)) exit(3);
}
static void limits(void) {
    limit(RLIMIT_CPU, 60);
    limit(RLIMIT_AS, (rlim_t)4 << 30);
    limit(RLIMIT_FSIZE, 0);
    limit(RLIMIT_CORE, 0);
#ifdef RLIMIT_NPROC
    limit(RLIMIT_NPROC, 0);
#endif
}
#else
#define dup _dup
#define fdopen _fdopen
int dup(int);
FILE *fdopen(int, const char *);
static void limits(void) {}
#endif

extern int (*maviper_doors[])(const double *, int);
void maviper_numbers(void);
static FILE *out;
static jmp_buf failed;

void maviper_number(double value) { fprintf(out, "%a ", value); }
void maviper_whole(long long value) { fprintf(out, "%lld ", value); }
void maviper_natural(unsigned long long value) { fprintf(out, "%llu ", value); }
void maviper_say(const char *word) { fprintf(out, "%s ", word); }
void maviper_letter(char value) { fprintf(out, "c%d ", value); }
void maviper_text(const char *value) {
    fputs("t", out);
    for (; value && *value; value++) fprintf(out, "%02x", (unsigned)(unsigned char)*value);
    fputs(" ", out);
}
void maviper_fail(void) { longjmp(failed, 1); }

/* DRIVER numbers | DRIVER FUNCTION WIDTH MODE; mode 1: each answer at once */
int main(int n, char **given) {
    out = fdopen(dup(1), "w");
    if (!out || !freopen("/dev/null", "w", stdout)) return 3;
    limits();
    if (n < 4) {
        setvbuf(out, 0, _IONBF, 0);
        maviper_numbers();
        return fclose(out) != 0;
    }
    int function = atoi(given[1]), mode = atoi(given[3]);
    volatile int row = 0;
    size_t width = (size_t)atol(given[2]);
    double *in = malloc((width + 1) * sizeof *in);
    if (!in) return 3;
    maviper_doors[function](0, 0);
    fputs("\n", out);
    for (; fread(in, sizeof *in, width, stdin) == width; row ^= 1) {
        if (setjmp(failed)) fputs("!", out);
        else if (!maviper_doors[function](in, row)) fputs("-", out);
        fputs("\n", out);
        if (mode == 1) fflush(out);
    }
    free(in);
    return fclose(out) != 0;
}
"""
