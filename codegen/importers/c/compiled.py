"""The second reading of C, by the C compiler itself: what was accepted is written again, built three times, and asked.

Does: compares the tokens of the compiler's preprocessor with those of pcpp; writes the parts of a syntax tree that
  functions need by pycparser's own generator, large functions in several; builds that without optimisation, with it,
  and with traps for what C leaves undefined, or once where functions only compare with constants; asks all builds about
  rows, and hands their common answers to the replay.
Assumes: a C compiler; where there is none, nothing is compared, and the profile says so. What is compiled was accepted
  by the reader: it calls nothing outside the file but functions of numbers.
Does not: share anything with the reader but the syntax tree. It runs in a scratch folder, with limits.

A compiler may join a product and a sum unless the source forbids it, so the second build lets it. In the first one,
whole numbers wrap around: compilers leave out additions before their traps see them (`w + 5 > 9` is `w > 4`), so an
overflow may show only as a difference of the two. All bytes of what is handed over are 0 for one row and 1 for the
next, so that a program that looks at more than its features is seen.
"""

# pyright: basic
# pycparser's nodes have no declared attributes
import re
import shutil
import tempfile
import weakref
from collections.abc import Generator, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from copy import deepcopy
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import repeat, zip_longest
from pathlib import Path, PurePosixPath
from subprocess import CompletedProcess
from typing import Any

import numpy as np
from pycparser import c_ast, c_generator

from codegen.agreement.compiled import find_compiler
from codegen.agreement.programs import run
from codegen.errors import InputError, MissingToolError, escape_text
from codegen.importers.c.kinds import Place
from codegen.importers.c.machine import list_targets, only_compares, walk
from codegen.importers.c.text import MORE, PREDEFINED, Expanded, parse_number
from codegen.importers.reading import Answers, Origin, Running, Said
from codegen.importers.running import asking
from codegen.ir import Floats

TRAPPING = "UBSan"
TRAPS = "-fsanitize=undefined,float-cast-overflow"
UNCHECKED = "-fno-sanitize=null,alignment,object-size,pointer-overflow"  # of memory that a door lays out
LANGUAGE = ["-std=c11", "-D_DEFAULT_SOURCE"]
LIMIT_S, BUILD_S = 120, 1_800
NO_TRAPS = "set CC to gcc or clang, or say --no-run"
AS_IT_STANDS = "give C that a compiler takes as it stands"
Answer = int | float | str
EACH, FAILED = 1, "!"  # a mode of the driver, and its word for a row at which an assertion fails


@dataclass(frozen=True)
class Asked:
    """A function that decides: where its features stand, and where it leaves its answer; parameter "": returned.

    `kept`: the last features, which it remembers; `resets`: functions that make them as they begin, and whether each is
    given the struct that they are in.
    """

    name: str
    features: tuple[Place, ...]
    answers: tuple[Place, ...]
    kept: tuple[Place, ...] = ()
    resets: tuple[tuple[str, bool], ...] = ()
    reads: tuple[str, ...] = ()  # functions whose calls are features, and those whose calls are actions
    acts: tuple[str, ...] = ()


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
    nodes = _choose_nodes(parsed, asked)
    unit = write_unit(parsed, nodes, asked, text.names, text.headers)
    once = not any(map(_computes, nodes))
    compiled = Compiled(unit, asked, compiler, where, contracts=text.contracts, once=once)
    by = f"the C compiler ({', '.join(compiled.flags)})"
    return {
        name: replace(origin, second=partial(_run_builds, origin, name, compiled, scores=said.scores), replayed_by=by)
        for name, (origin, _) in origins.items()
    }


@contextmanager
def _run_builds(origin: Origin, name: str, compiled: "Compiled", *, scores: bool) -> Generator[Running]:
    """The numbers of a source, and what answers observations."""
    types = compiled.types(name)
    letters = [place for place, kind in enumerate(types) if kind == CHAR]

    def ask_rows(rows: Floats) -> Answers:
        taken = np.ones(len(rows), np.bool_) if origin.takes is None else origin.takes(rows)
        if origin.takes is not None and "overflow" not in origin.given:  # where assertions alone rule observations out
            compiled.ensure_failing(name, rows[~taken & ~np.isnan(rows).any(axis=1)])
        taken &= (rows[:, letters] >= 0).all(axis=1)  # a char may have a sign, or none
        told, labels = compiled.answers(name, rows[taken]), {label: at for at, label in enumerate(origin.labels)}
        distinct, count = {id(each): each for each in told}, len(origin.memory)  # equal ones of Python may differ: -0.0

        def read_answer(answer: Sequence[Answer]) -> Any:
            """Returns the numbers of an answer, or the place of its label, with the memory after it; None: neither."""
            if origin.vectors:
                return answer
            label = labels.get(_label(answer[: len(answer) - count], scores=scores))
            kept = (ord(n) if isinstance(n, str) else n for n in answer[len(answer) - count :])
            return (label, *kept) if count and label is not None else label

        answers = [asking.Answer(None, "", asking.PRECONDITION)]  # to what the reader leaves out
        answers += [asking.Answer(read_answer(each), _word(each)) for each in distinct.values()]
        places, place_of = np.zeros(len(rows), int), {each: at for at, each in enumerate(distinct, 1)}
        places[taken] = [place_of[id(each)] for each in told]
        return asking.combine_answers(answers, places, origin)

    yield Running(compiled.numbers, ask_rows, ["int8" if each == CHAR else each for each in types])


def _word(answer: Sequence[Answer]) -> str:
    return escape_text(repr(answer[0] if len(answer) == 1 else list(answer)))[:200]


def _label(answer: Sequence[Answer], *, scores: bool) -> Any:
    if len(answer) == 1:
        return answer[0]
    return answer.index(max(answer)) if scores else tuple(answer)


# --- the builds of a file


class Compiled:
    """The builds of one file. `contracts`: whether a compiler may join roundings; `once`: whether one build is enough,
    as all of them would be the same comparisons.
    """

    def __init__(
        self, unit: str, asked: Sequence[Asked], compiler: list[str], where: str, *, contracts: bool, once: bool = False
    ) -> None:
        self._unit, self._compiler, self._where = unit, compiler, where
        self._asked = {each.name: (at, each) for at, each in enumerate(asked)}
        joined = ["-ffp-contract=fast", "-march=native"] if contracts else ["-ffp-contract=off"]
        self.flags = {
            "-O0": ["-O0", "-fwrapv", "-ffp-contract=off", "-DMAVIPER_NUMBERS"],
            "-O2": ["-O2", *joined],
            TRAPPING: ["-O0", "-ffp-contract=off", TRAPS, UNCHECKED, "-fno-sanitize-recover=all"],
        }
        self.flags = dict([*self.flags.items()][:1]) if once else self.flags

    @cached_property
    def _folder(self) -> Path:
        """The scratch folder with all builds. InputError for what the compiler does not take."""
        folder = Path(tempfile.mkdtemp(prefix="maviper-"))
        weakref.finalize(self, shutil.rmtree, folder, ignore_errors=True)
        (folder / "unit.c").write_text(self._unit)
        (folder / "driver.c").write_text(DRIVER)
        run([*self._compiler, *LANGUAGE, "-c", "driver.c"], folder)
        with ThreadPoolExecutor() as pool:
            for name, built in zip(self.flags, pool.map(self._build, repeat(folder), self.flags), strict=True):
                if built.returncode and name == TRAPPING:
                    raise MissingToolError(f"{self._compiler[0]} builds nothing with {TRAPS}", _first(built), NO_TRAPS)
                if built.returncode:
                    what = f"the C compiler does not take what was read: {escape_text(_first(built))[:200]}"
                    raise InputError(what, self._where, AS_IT_STANDS)
        return folder

    def _build(self, folder: Path, name: str) -> CompletedProcess[str]:
        command = [*self._compiler, *LANGUAGE, "-Werror=implicit-function-declaration", *self.flags[name]]
        command += ["unit.c", "driver.o", "-lm", "-o", name.strip("-")]
        first = run(command, folder, BUILD_S)
        if first.returncode and "-march=native" in command:
            return run([each for each in command if each != "-march=native"], folder, BUILD_S)
        if first.returncode and name == TRAPPING:  # where there is no library that says what was met
            return run([*command, "-fsanitize-undefined-trap-on-error"], folder, BUILD_S)
        return first

    @cached_property
    def numbers(self) -> list[float]:
        """The numbers that the file's constant expressions give."""
        said = run([str(self._folder / "O0"), "numbers"], self._folder, LIMIT_S).stdout
        return sorted({float.fromhex(each) for each in said.split()})

    def types(self, function: str) -> list[str]:
        """The type of each feature: NumPy's name of it, or char. InputError for one of 64 bits."""
        types = self._run(function, "-O0", np.zeros((0, 1))).stdout.split()
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
            given = list(pool.map(self._run, repeat(function), self.flags, repeat(rows)))
        for name, said in zip(self.flags, given, strict=True):
            if said.returncode:
                again = self._run(function, name, rows, EACH)
                raise self._make_error(function, rows[max(again.stdout.count("\n") - 1, 0)], _reason(again))
        lines = [said.stdout.splitlines()[1:] for said in given]
        if FAILED in given[0].stdout or any(each != lines[0] for each in lines):
            for place, each in enumerate(zip(*lines, strict=True)):
                if FAILED in each:
                    raise self._make_error(function, rows[place], "an assertion fails that the reader does not see")
                if len(set(each)) > 1:
                    told = ", ".join(f"{name} {line.strip()}" for name, line in zip(self.flags, each, strict=True))
                    raise self._make_error(function, rows[place], f"builds of it answer differently: {told}")
        known = {each: tuple(map(_part, each.split())) for each in set(lines[0])}
        return [known[each] for each in lines[0]]

    def ensure_failing(self, function: str, rows: Floats) -> None:
        """InputError unless an assertion fails at each of the rows that the reader leaves out."""
        said = self._run(function, "-O0", rows).stdout.splitlines()[1:]
        for place in np.flatnonzero(np.array(said, np.str_) != FAILED)[:1].tolist():
            what = "the reader leaves out an observation at which no assertion fails"
            raise self._make_error(function, rows[place], what)

    def _run(self, function: str, name: str, rows: Floats, mode: int = 0) -> CompletedProcess[str]:
        build = name.strip("-")
        place = self._folder / f"rows-{build}"
        np.ascontiguousarray(rows, dtype=np.float64).tofile(place)
        command = [str(self._folder / build), str(self._asked[function][0]), str(rows.shape[1]), str(mode)]
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
    return int(word) if word.lstrip("-").isdigit() else float.fromhex(word)


# --- tokens

SOURCE, AGAIN = "source.c", "again.c"
ASSERT = "assert.h"  # whose macro names the line where it stands: left as it is
TOKEN = re.compile(
    r"""(?:u8?|U|L)?"(?:[^"\\]|\\.)*"|(?:u8?|U|L)?'(?:[^'\\]|\\.)*'|[A-Za-z_$]\w*|\.?\d(?:[eEpP][+-]|[\w.])*"""
    r"""|\.\.\.|<<=|>>=|->|\+\+|--|<<|>>|[<>=!+\-*/%&|^]=|&&|\|\||\#\#|\S"""
)
MARKER = re.compile(r'# (\d+) "((?:[^"\\]|\\.)*)"')
DEFINED = re.compile(r"#\s*define (\w+)(?: (.*))?$")


def ensure_same_tokens(text: Expanded, compiler: Sequence[str], where: str) -> None:
    """InputError with the first token that the compiler's preprocessor gives, and pcpp does not. What headers of the
    system hold is compared with nothing.
    """
    with tempfile.TemporaryDirectory(prefix="maviper-") as folder:
        place = Path(folder)
        for name, given in {**dict.fromkeys((ASSERT, *text.missing), b""), **text.beside}.items():
            pure = PurePosixPath(name)
            if pure.is_absolute() or ".." in pure.parts:
                what = f"a header lies outside the file's folder: {escape_text(name)}"
                raise InputError(what, where, "put it beside the file")
            (place / pure).parent.mkdir(parents=True, exist_ok=True)
            (place / pure).write_bytes(given)
        (place / SOURCE).write_bytes(text.content)
        bodies = dict[str, str]()
        theirs = list(_list_lines(_expand(compiler, place, SOURCE, where), bodies))
        again = [f"#include <{each}.h>" for each in text.headers]
        for name, value in text.names.items():
            if parse_number(bodies.get(name, str(value))) != value:
                what = f"the C compiler reads {name} as {escape_text(bodies[name])[:40]}, and the reader as {value}"
                raise InputError(what, where, "write the number where the name is used")
            again.append(f"#define {name} {bodies.get(name, value)}")
        again.append(re.sub(r"^#line.*$", "", text.text, flags=re.MULTILINE))
        (place / AGAIN).write_text("\n".join(again))
        ours = list(_list_lines(_expand(compiler, place, AGAIN, where), {}))
    pairs = enumerate(zip(theirs, ours, strict=False))
    alike = next((at for at, (one, other) in pairs if one[1] != other[1]), min(len(theirs), len(ours)))
    both = _split_tokens(theirs[alike:]), _split_tokens(ours[alike:])
    for (line, one), (_, other) in zip_longest(*both, fillvalue=("its end", "nothing")):
        if one != other:
            what = f"the C compiler reads {escape_text(one)[:40]} where the reader reads {escape_text(other)[:40]}"
            raise InputError(what, f"{where}, {line}", "write what the macro means where it is used")


def _expand(compiler: Sequence[str], folder: Path, name: str, where: str) -> str:
    macros = [f"-D{each.replace(' ', '=', 1)}" if " " in each else f"-D{each}=" for each in (*PREDEFINED[2:], *MORE)]
    said = run([*compiler, "-E", "-dD", *LANGUAGE, "-I", ".", *macros, name], folder)
    if said.returncode:
        first = _first(said).partition("error: ")[2]
        raise InputError(
            f"the C compiler's preprocessor does not take it: {escape_text(first)[:100]}", where, AS_IT_STANDS
        )
    return said.stdout


def _split_tokens(lines: Sequence[tuple[str, str]]) -> Iterator[tuple[str, str]]:
    """The tokens of lines, with their places."""
    return ((place, token) for place, line in lines for token in TOKEN.findall(line))


def _list_lines(text: str, bodies: dict[str, str]) -> Iterator[tuple[str, str]]:
    """The lines of the user's own files, with their places; what these files define goes to `bodies`."""
    own, line, header = False, 0, ""
    for each in text.split("\n"):
        if marker := MARKER.match(each):
            line, name = int(marker[1]), marker[2]
            own = not name.startswith(("/", "<"))
            header = "" if name in (SOURCE, AGAIN) else f" of {escape_text(name.removeprefix('./'))}"
            continue
        if own and each.startswith("#"):
            if defined := DEFINED.match(each):
                bodies[defined[1]] = defined[2] or ""
        elif own and (stripped := each.strip()):
            yield f"line {line}{header}", stripped
        line += 1


# --- what a file says, written again, with a door to each function that decides

BEFORE = "maviper_"
OURS = "maviper_x_"  # before the names of parameters, and of none: what is returned
ACT = "maviper_act"  # the name of the one action that was called; "?" of several
SLACK = 16  # items of an array behind the last one that is a feature
HEADERS = ("assert", "float", "limits", "math", "stdbool", "stddef", "stdint", "stdio", "stdlib", "string")
WIDE, CHAR = "wide", "char"
BEGIN = """void maviper_fail(void);
#undef assert
#define assert(e) ((e) ? (void)0 : maviper_fail())
#define inline"""
DOOR = """
#define maviper_wide(narrow) (sizeof(long) == 8 ? "wide" : narrow)
#define maviper_kind(v) _Generic((v), float: "float32", double: "float64", _Bool: "bool", char: "char", \\
    signed char: "int8", unsigned char: "uint8", short: "int16", unsigned short: "uint16", int: "int32", \\
    unsigned int: "uint32", long: maviper_wide("int32"), unsigned long: maviper_wide("uint32"), \\
    long long: "wide", unsigned long long: "wide", default: "other")
#define maviper_give(v) _Generic((v), float: maviper_number, double: maviper_number, char: maviper_letter, \\
    char *: maviper_text, const char *: maviper_text, unsigned long: maviper_natural, \\
    unsigned long long: maviper_natural, default: maviper_whole)(v)
void maviper_number(double), maviper_letter(char), maviper_text(const char *), maviper_natural(unsigned long long);
void maviper_whole(long long), maviper_say(const char *);
"""
NUMBERS = """void maviper_numbers(void) {
#ifdef MAVIPER_NUMBERS
static const double maviper_held[] = {%s};
for (unsigned maviper_at = 0; maviper_at < sizeof maviper_held / sizeof *maviper_held; maviper_at++)
    maviper_number(maviper_held[maviper_at]);
%s
#endif
}
"""


def write_unit(
    parsed: Any, nodes: Sequence[Any], asked: Sequence[Asked], names: Mapping[str, int], headers: Sequence[str]
) -> str:
    """A file of C that needs a driver. `nodes`: of the tree, those that are needed; `names`: macros that stand in it as
    names; `headers`: that the source includes. The compiler says of which type features are, and what constants are.

    Names that the file defines are no names of the C library there: they get others by macros.
    """
    generator = c_generator.CGenerator()
    functions = {each.decl.name: each.decl for each in nodes if isinstance(each, c_ast.FuncDef)}
    typedefs = {each.name: each.type for each in nodes if isinstance(each, c_ast.Typedef)}
    outside = [each for each in nodes if not isinstance(each, c_ast.FuncDef)]
    held = {each.name for each in outside if isinstance(each, c_ast.Decl) and not isinstance(each.type, c_ast.FuncDecl)}
    enumerators = {part.name for each in outside for part in walk(each) if isinstance(part, c_ast.Enumerator)}
    called = {name for each in asked for name in (*each.reads, *each.acts)}
    own = {*functions, *typedefs, *held, *enumerators, *called} - {None}
    own = {name: BEFORE + "own_" + name for name in sorted(own)}
    own |= {name: f"({value})" for name, value in names.items()}
    parts = [*(f"#include <{each}.h>" for each in dict.fromkeys((*headers, *HEADERS))), BEGIN]
    inner = [part for each in nodes for part in walk(each)]
    declared = {part.name for part in inner if isinstance(part, DECLARING)} - {None}
    parts += [f"#undef {name}" for name in sorted({*declared, *own})]  # also those within functions: MAX_INPUT
    parts += [f"#define {name} {means}" for name, means in own.items()]
    for node in nodes:
        split = _split_function(node) if isinstance(node, c_ast.FuncDef) else [node]
        parts += [generator.visit(each) + ("" if isinstance(each, c_ast.FuncDef) else ";") for each in split]
    parts += [
        *_write_stubs(parsed, asked[0]),
        DOOR,
        *(_door(at, each, functions[each.name], typedefs) for at, each in enumerate(asked)),
    ]
    doors = ", ".join(f"{BEFORE}door_{at}" for at in range(len(asked)))
    parts.append(f"int (*{BEFORE}doors[])(const double *, int) = {{{doors}}};")
    known = {*names, *enumerators, *(each.name for each in outside if _is_scalar(each))}
    fixed = (each for each in inner if isinstance(each, COMPUTED) and _is_fixed(each, known))
    numbers, literals = dict.fromkeys([*names, *sorted(enumerators)]), dict[str, None]()
    for each in fixed:  # a compiler takes long over thousands of calls
        plain = isinstance(each, c_ast.Constant) or (
            isinstance(each, c_ast.UnaryOp) and each.op == "-" and isinstance(each.expr, c_ast.Constant)
        )
        (literals if plain else numbers)[generator.visit(each)] = None
    parts.append(NUMBERS % (", ".join(literals) or "0", " ".join(f"{BEFORE}number({each});" for each in numbers)))
    return "\n".join(parts)


def _write_stubs(parsed: Any, asked: Asked) -> Iterator[str]:
    """Functions in place of those that read sensors, which give a feature, and of those that act, which say so."""
    generator = c_generator.CGenerator()
    if asked.acts:
        yield f'static const char *{ACT} = "";'
    for each in parsed.ext:
        if isinstance(each, c_ast.Decl) and each.name in asked.reads:
            yield f"static {_declare(deepcopy(each.type.type), each.name)};"
            yield f"{generator.visit(each)} {{ return {OURS}{each.name}; }}"
        elif isinstance(each, c_ast.Decl) and each.name in asked.acts:
            yield f'{generator.visit(each)} {{ {ACT} = *{ACT} ? "?" : "{each.name}"; }}'


def _choose_nodes(parsed: Any, asked: Sequence[Asked]) -> list[Any]:
    """The nodes of the file that functions need, in its order."""
    decls = [(each, getattr(each, "decl", each)) for each in parsed.ext]
    decls = [(each, decl) for each, decl in decls if isinstance(decl, c_ast.Decl | c_ast.Typedef)]
    named: dict[str, list[Any]] = {}
    for each, decl in decls:
        named.setdefault(decl.name, []).append(each)
    needed, open_ = set[str](), [name for each in asked for name in (each.name, *(one for one, _ in each.resets))]
    while open_:
        name = open_.pop()
        if name not in needed and name in named:
            needed.add(name)
            for part in (part for each in named[name] for part in walk(each)):
                open_ += [part.name] if isinstance(part, c_ast.ID) else getattr(part, "names", [])
    return [each for each, decl in decls if decl.name in needed or (decl is each and _defines(decl))]


def _defines(decl: Any) -> bool:
    """Returns True if a declaration defines a struct or enumerators."""
    kinds = c_ast.Struct | c_ast.Union | c_ast.Enum
    return any(isinstance(each, kinds) and getattr(each, "decls", getattr(each, "values", None)) for each in walk(decl))


COMPUTED = (c_ast.Constant, c_ast.UnaryOp, c_ast.BinaryOp, c_ast.Cast)
DECLARING = (c_ast.Decl, c_ast.Typedef, c_ast.Enumerator)


def _is_scalar(node: Any) -> bool:
    """Returns True for a constant of the file that is one number."""
    plain = isinstance(node, c_ast.Decl) and isinstance(node.type, c_ast.TypeDecl) and "const" in node.quals
    return plain and isinstance(node.type.type, c_ast.IdentifierType | c_ast.Enum)


def _is_fixed(node: Any, known: set[str]) -> bool:
    """Returns True if an expression is a number: a literal, an enumerator, or what is computed of them."""
    if isinstance(node, c_ast.Constant | c_ast.ID):
        return node.name in known if isinstance(node, c_ast.ID) else node.type != "string"
    plain = isinstance(node, c_ast.UnaryOp) and node.op in "-+~!"
    plain |= isinstance(node, c_ast.Cast) and isinstance(node.to_type.type, c_ast.TypeDecl)
    parts = [node.left, node.right] if isinstance(node, c_ast.BinaryOp) else [node.expr] if plain else []
    return bool(parts) and all(_is_fixed(each, known) for each in parts)


def _computes(node: Any) -> bool:
    """Returns True unless a node is no function, or compares what it is given with constants, and returns constants."""
    if not isinstance(node, c_ast.FuncDef):
        return False
    given = {each.name for each in (node.decl.type.args.params if node.decl.type.args else ())}
    returned = [each.expr for each in walk(node.body) if isinstance(each, c_ast.Return)]
    converted = any(getattr(each, "name", None) in given for each in returned)  # a parameter, to another type
    return converted or not only_compares(node.body, c_ast.Compound, c_ast.If, c_ast.Return)


LARGE = 1_000  # statements of a part


def _split_function(node: Any) -> list[Any]:
    """A function, behind parts that it calls: a compiler takes long over thousands of ifs in one. A part is an `if`
    that returns on every path. A function that sets or declares something stays whole.
    """
    given = node.decl.type.args.params if node.decl.type.args else []
    acting = list_targets(node.body) or any(isinstance(each, c_ast.Decl) for each in walk(node.body))
    if not all(isinstance(each, c_ast.Decl) and each.name for each in given) or _defines(node.decl) or acting:
        return [node]
    parts = list[Any]()
    body, _, _ = _split_statement(node.body, node.decl, parts)
    return [*parts, c_ast.FuncDef(node.decl, None, body)] if parts else [node]


def _split_statement(each: Any, of: Any, parts: list[Any]) -> tuple[Any, int, bool]:
    """The statement, how many are left in it, and whether it returns on every path. `of`: the function's declaration;
    `parts`: those that were made of it, which grow.
    """
    before = len(parts)
    if isinstance(each, c_ast.Compound) and each.block_items:
        items, counts, ends = zip(*[_split_statement(one, of, parts) for one in each.block_items], strict=True)
        return each if len(parts) == before else c_ast.Compound([*items]), sum(counts), ends[-1]
    if not isinstance(each, c_ast.If) or each.iffalse is None:
        return each, 1, isinstance(each, c_ast.Return) and each.expr is not None
    then, n_then, then_ends = _split_statement(each.iftrue, of, parts)
    otherwise, n_otherwise, otherwise_ends = _split_statement(each.iffalse, of, parts)
    whole = each if len(parts) == before else c_ast.If(each.cond, then, otherwise)
    count, returns = 1 + n_then + n_otherwise, then_ends and otherwise_ends
    if not returns or count < LARGE:
        return whole, count, returns
    name, decl = f"{BEFORE}part_{len(parts)}", deepcopy(of)
    decl.storage, decl.funcspec, inner = ["static"], ["__attribute__((noinline))"], decl.type
    while not isinstance(inner, c_ast.TypeDecl):
        inner = inner.type
    inner.declname = name
    parts.append(c_ast.FuncDef(decl, None, c_ast.Compound([whole])))
    given = [c_ast.ID(one.name) for one in (of.type.args.params if of.type.args else [])]
    return c_ast.Compound([c_ast.Return(c_ast.FuncCall(c_ast.ID(name), c_ast.ExprList(given)))]), 1, True


def _door(at: int, asked: Asked, decl: Any, typedefs: Mapping[str, Any]) -> str:
    """Writes C that sets a function's parameters to a row, calls it, and hands on its answer; without a row it says of
    which type each feature is. 0 is returned for a number that a parameter does not hold.
    """
    places = [*asked.features, *asked.answers, *asked.kept]
    given = [each for each in (decl.type.args.params if decl.type.args else ()) if isinstance(each, c_ast.Decl)]
    pointers, lines = set[str](), list[str]()
    for each in given:
        counted = [place.way[0] for place in places if place.base == each.name and place.way]
        most = max((step for step in counted if isinstance(step, int)), default=0)
        lines.append(f"static {_storage(each, most + 1 + SLACK, typedefs, pointers)};")
        if all(place.base != each.name for place in asked.kept):
            lines.append(f"__builtin_memset(&{OURS}{each.name}, maviper_row & 1, sizeof {OURS}{each.name});")
    own = {each.name for each in given} | {*asked.reads}
    inputs = [_place(each, pointers, own) for each in asked.features]
    lines.append("if (!maviper_in) {")
    lines += [f"maviper_say(maviper_kind({each}));" for each in inputs]
    lines += ["return 1;", "}"]
    row = [(each, f"maviper_in[{column}]") for column, each in enumerate(inputs)]
    held = [OURS + str(each.base) for each in asked.kept if each.base in own][:1]
    begin = " ".join(f"{name}({held[0] if taken else ''});" for name, taken in asked.resets)
    lines.append(f"static int maviper_begun; if (!maviper_begun) {{ maviper_begun = 1; {begin} }}" if begin else "")
    first = len(row) - len(asked.kept)
    lines += [f"{each} = {number};" for each, number in row[:first]]
    lines += [f"if ({number} == {number}) {each} = {number};" for each, number in row[first:]]
    lines += [f"if ({each} != {number} && {number} == {number}) return 0;" for each, number in row]
    call, result = f"{asked.name}({', '.join(OURS + each.name for each in given)})", deepcopy(decl.type.type)
    if getattr(result.type, "names", None) != ["void"]:
        pointers |= {""} if isinstance(result, c_ast.PtrDecl) else set()
        call = f"{_declare(result, '')} = {call}"
    told = [_place(each, pointers, own) for each in (*asked.answers, *asked.kept)]
    lines += [f'{ACT} = "";'] if asked.acts else []
    lines += [f"{call};", *(f"maviper_give({each});" for each in told), "return 1;"]
    body = "\n".join(lines)
    return f"static int {BEFORE}door_{at}(const double *maviper_in, int maviper_row) {{\n{body}\n}}"


def _place(place: Place, pointers: set[str], own: set[str]) -> str:
    """A feature or a part of an answer, as C says it. `own`: the parameters; others are variables of the file."""
    single = place.base in pointers and place.way and isinstance(place.way[0], str)
    steps = "".join(f".{step}" if isinstance(step, str) else f"[{step}]" for step in place.way)
    return f"{OURS if place.base in own or not place.base else ''}{place.base}{'[0]' if single else ''}{steps}"


def _storage(decl: Any, length: int, typedefs: Mapping[str, Any], pointers: set[str]) -> str:
    """A variable for a parameter; for a pointer, an array of what it points to."""
    type_ = known = decl.type
    while isinstance(known, c_ast.TypeDecl) and isinstance(known.type, c_ast.IdentifierType):
        known = typedefs.get(" ".join(known.type.names))
    type_ = deepcopy(known if isinstance(known, c_ast.PtrDecl) else type_)
    if isinstance(type_, c_ast.PtrDecl) or (isinstance(type_, c_ast.ArrayDecl) and type_.dim is None):
        pointers |= {decl.name}
        type_ = c_ast.ArrayDecl(type_.type, c_ast.Constant("int", str(length)), [])
        if getattr(getattr(type_.type, "type", None), "names", None) == ["void"]:
            type_.type.type.names = ["char"]
    return _declare(type_, decl.name)


def _declare(type_: Any, name: str) -> str:
    """The declaration of a variable of ours, which may be set."""
    inner = type_
    while not isinstance(inner, c_ast.TypeDecl):
        setattr(inner, "dim_quals" if isinstance(inner, c_ast.ArrayDecl) else "quals", [])
        inner = inner.type
    inner.quals, inner.declname = [], OURS + name
    return c_generator.CGenerator().visit(c_ast.Decl(OURS + name, [], [], [], [], type_, None, None))


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
