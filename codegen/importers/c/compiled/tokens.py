"""The tokens of a C file after its preprocessor: the compiler's own beside those of pcpp.

Does: has the compiler expand the file as it stands, and the text that pcpp made of it; finds the first difference.
Assumes: a scratch folder; headers beside the file, as the reader met them.
Does not: compile. Headers of the system are read by both, and their content is compared with nothing.
"""

import re
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path, PurePosixPath

from codegen.agreement.programs import run
from codegen.errors import InputError, escape_text
from codegen.importers.c.text import MORE, PREDEFINED, STANDARD, Expanded

SOURCE, AGAIN = "source.c", "again.c"
ASSERT = "assert.h"  # whose macro names the line where it stands: left as it is
TOKEN = re.compile(
    r"""(?:u8?|U|L)?"(?:[^"\\]|\\.)*"|(?:u8?|U|L)?'(?:[^'\\]|\\.)*'|[A-Za-z_$]\w*|\.?\d(?:[eEpP][+-]|[\w.])*"""
    r"""|\.\.\.|<<=|>>=|->|\+\+|--|<<|>>|[<>=!+\-*/%&|^]=|&&|\|\||\#\#|\S"""
)
MARKER = re.compile(r'# (\d+) "((?:[^"\\]|\\.)*)"')
DEFINED = re.compile(r"#\s*define (\w+)(?: (.*))?$")
INCLUDED = re.compile(rb"^\s*#\s*include\s*<(\w+)\.h>", re.MULTILINE)
FLAGS = "-E -dD -std=c11 -D_DEFAULT_SOURCE -I .".split()  # noqa: SIM905
ADVICE = "write what the macro means where it is used"
Token = tuple[str, str]  # its place, and itself


def list_headers(text: Expanded) -> list[str]:
    """The headers of the language that a file and those beside it include."""
    names = [each.decode() for content in (text.content, *text.beside.values()) for each in INCLUDED.findall(content)]
    return [each for each in dict.fromkeys(names) if each in STANDARD]


def ensure_same_tokens(text: Expanded, compiler: Sequence[str], where: str) -> None:
    """InputError with the first token that the compiler's preprocessor gives, and pcpp does not."""
    with tempfile.TemporaryDirectory(prefix="maviper-") as folder:
        place = Path(folder)
        for name, given in {**dict.fromkeys((ASSERT, *text.missing), b""), **text.beside}.items():
            pure = PurePosixPath(name)
            if pure.is_absolute() or ".." in pure.parts:
                advice = "put it beside the file"
                raise InputError(f"a header lies outside the file's folder: {escape_text(name)}", where, advice)
            (place / pure).parent.mkdir(parents=True, exist_ok=True)
            (place / pure).write_bytes(given)
        (place / SOURCE).write_bytes(text.content)
        bodies = dict[str, str]()
        theirs = list(_tokens(_expand(compiler, place, SOURCE, where), bodies))
        again = [f"#include <{each}.h>" for each in list_headers(text)]
        again += [f"#define {name} {bodies.get(name, value)}" for name, value in text.names.items()]
        again.append(re.sub(r"^#line.*$", "", text.text, flags=re.MULTILINE))
        (place / AGAIN).write_text("\n".join(again))
        ours = list(_tokens(_expand(compiler, place, AGAIN, where), {}))
    end = ("its end", "nothing")
    for at in range(max(len(theirs), len(ours))):
        (line, one), (_, other) = (each[at] if at < len(each) else end for each in (theirs, ours))
        if one != other:
            what = f"the C compiler reads {escape_text(one)[:40]} where the reader reads {escape_text(other)[:40]}"
            raise InputError(what, f"{where}, {line}", ADVICE)


def _expand(compiler: Sequence[str], folder: Path, name: str, where: str) -> str:
    macros = [f"-D{each.replace(' ', '=', 1)}" if " " in each else f"-D{each}=" for each in (*PREDEFINED[2:], *MORE)]
    said = run([*compiler, *FLAGS, *macros, name], folder)
    if said.returncode:
        first = next((each for each in said.stderr.splitlines() if "error" in each), "no word")
        what = f"the C compiler's preprocessor does not take it: {escape_text(first.partition('error: ')[2])[:100]}"
        raise InputError(what, where, "give C that a compiler takes as it stands")
    return said.stdout


def _tokens(text: str, bodies: dict[str, str]) -> Iterator[Token]:
    """The tokens of the user's own files; what these define goes to `bodies`."""
    own, line, name = False, 0, ""
    for each in text.split("\n"):
        if marker := MARKER.match(each):
            line, name = int(marker[1]), marker[2]
            own = not name.startswith(("/", "<"))
            continue
        if own and each.startswith("#"):
            if defined := DEFINED.match(each):
                bodies[defined[1]] = defined[2] or ""
        elif own:
            header = "" if name in (SOURCE, AGAIN) else f" of {escape_text(name.removeprefix('./'))}"
            yield from ((f"line {line}{header}", token) for token in TOKEN.findall(each))
        line += 1
