"""The text of a C file after its preprocessor, which pcpp is, and plain C that stands in C++.

Does: expands macros; reads headers that lie beside the file; skips standard headers, and names what it could not read.
Assumes: no macro is given to the compiler, other than those of the language.
Does not: touch files (`beside` does), or guess: what a missing header might decide is refused.

A macro that is a plain whole number stays as a name, so that actions keep the names that the source gives them.
"""

# pyright: basic
# pcpp declares no types
import io
import re
import sys
from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

from pcpp.preprocessor import Action, OutputDirective, Preprocessor

from codegen.errors import InputError, escape_text

STANDARD = frozenset(
    """assert complex ctype errno fenv float inttypes iso646 limits locale math setjmp signal stdalign stdarg stdatomic
    stdbool stddef stdint stdio stdlib stdnoreturn string tgmath threads time uchar wchar wctype""".split()  # noqa: SIM905
)
PREDEFINED = "__STDC__ 1", "__STDC_VERSION__ 201112L", "__attribute__(x)", "__inline inline", "__inline__ inline"
MORE = "__restrict", "__restrict__", "__extension__", "__const const", "__volatile__ volatile"
PLAIN = re.compile(r"\(?\s*(-?\s*(?:0[0-7]*|[1-9]\d{0,9}|0[xX][0-9a-fA-F]{1,8}))\s*\)?", re.ASCII)
ODD = re.compile(r"\?\?[=(/)'<!>-]|\\[^\S\n]+$", re.MULTILINE)  # trigraphs; blanks behind the last backslash
JOINED = re.compile(r"^.*\\\n(?:.*\\\n)*.*", re.MULTILINE)
COMMENT = re.compile(r'"(?:[^"\\\n]|\\.)*"|\'(?:[^\'\\\n]|\\.)*\'|//[^\n]*|/\*.*?(?:\*/|\Z)', re.DOTALL)
DEFINED = re.compile(r"^[ \t]*#[ \t]*(?:define|undef)[ \t]+(\w+)(.*)$", re.MULTILINE)
INCLUDED = re.compile(r'^[ \t]*#[ \t]*include[ \t]*"([^"\n]*)"', re.MULTILINE)
OF_STANDARD = re.compile(
    r"[A-Z]\w*_(?:MAX|MIN|WIDTH|BIT|DIG|EPSILON|RADIX|METHOD)|M_\w+|(?:FP|FE|EXIT|MATH)_\w+|NAN|EOF|NULL|true"
)
ASKED = re.compile(r"[A-Za-z_]\w*|[()!<>+*&|-]|[<>=!]=|&&|\|\|")  # in #if, beside whole numbers of 32 bits and blanks
HIDDEN = re.compile(r"\bhidden_lines_(\d+)_(\d+)_\b(\n*)")
MAX_EXPANSIONS = 20_000  # and as many more as the text has letters
MAX_LETTERS = 1 << 24
ADVICE = "give C that a compiler takes as it stands"
Beside = Callable[[str], bytes | None]


class Expanded(NamedTuple):
    """A text without macros."""

    text: str
    names: dict[str, int]  # macros that are whole numbers, which stay as names
    missing: tuple[str, ...]  # headers that were not read
    contracts: bool  # whether a compiler may join a product and a sum
    content: bytes  # of the file, as a compiler of C takes it
    beside: dict[str, bytes]  # of headers beside it that were read
    headers: list[str]  # of the language, that these include


def expand_source(content: bytes, where: str, beside: Beside) -> Expanded:
    """The text as a compiler's parser meets it. InputError with its line for what is not understood."""
    text = _clean(content, where)
    if where.lower().endswith(ENDINGS):
        text = strip_cpp(text, where)
        content = text.encode()  # a compiler of C is asked about the C inside
    # macros of the text, and of headers beside it, that are not always one whole number are expanded
    texts, seen, bodies = [text], set[str](), dict[str, set[str]]()
    while texts:
        each = texts.pop()
        for name, body in DEFINED.findall(each):
            bodies.setdefault(name, set()).add(body.strip())
        for name in set(INCLUDED.findall(each)) - seen:
            seen.add(name)
            texts.append(_clean(beside(name) or b"", f"{where}, {name}"))
    expanding = {name for name, each in bodies.items() if len(each) > 1 or parse_number(each.pop()) is None}
    lines = text.split("\n")
    hides = HIDDEN.search(text) is None
    reader, out = _Reader(where, beside, MAX_EXPANSIONS + len(content)), io.StringIO()
    try:
        reader.parse(_hide_lines(lines, expanding) if hides else text, where)
        reader.write(out)
    except (IndexError, AttributeError, AssertionError, TypeError) as error:  # of lines that pcpp does not expect
        raise reader.make_error(f"not C that is understood: {escape_text(error)[:80]}", reader.directive) from None
    if out.tell() > MAX_LETTERS:
        raise reader.make_error("macros expand to too much text", 0)
    expanded = HIDDEN.sub(partial(_show_lines, lines), out.getvalue()) if hides else out.getvalue()
    missing, headers = tuple(dict.fromkeys(reader.missing)), list(dict.fromkeys(reader.headers))
    return Expanded(expanded, reader.kept, missing, reader.contracts, content, reader.read, headers)


def _clean(content: bytes, where: str) -> str:
    """The text without comments, and without backslashes at the ends of lines; each line begins where it did."""
    text = content.decode(errors="replace").replace("\r\n", "\n")
    if ODD.search(text) or not re.sub(r"[\n\t]", "", text).isprintable():
        lines = enumerate(text.split("\n"), 1)
        first = next(at for at, line in lines if ODD.search(line) or not line.expandtabs().isprintable())
        what = "a line has a trigraph, a letter that is not printed, or blanks after its last backslash"
        raise InputError(what, f"{where}, line {first}", ADVICE)
    if "\\\n" in text:
        text = JOINED.sub(lambda match: match[0].replace("\\\n", "") + _breaks(match[0]), text)
    text = text.removesuffix("\\")

    def blank(match: re.Match[str]) -> str:
        matched = match[0]
        if matched[0] != "/":
            return matched
        if matched[1] == "*" and (len(matched) < 4 or not matched.endswith("*/")):
            line = text.count("\n", 0, match.start()) + 1
            raise InputError("a comment has no end", f"{where}, line {line}", ADVICE)
        return " " + _breaks(matched)

    return COMMENT.sub(blank, text)


def parse_number(body: str) -> int | None:
    """The whole number that a macro is; None: it is none."""
    match = PLAIN.fullmatch(body.strip())
    digits = re.sub(r"\s", "", match[1]) if match else ""
    octal = re.match(r"-?0\d", digits)
    value = int(digits, 8 if octal else 0) if digits else 2**31
    return value if abs(value) < 2**31 else None


def _hide_lines(lines: list[str], expanding: set[str]) -> str:
    """The lines, with a name in place of all those in a row that no directive or macro touches, for pcpp is slow."""
    word = re.compile("|".join(map(re.escape, ("#", "__", "_Pragma", *sorted(expanding)))))
    shown, depth, first = list[str](), 0, 0  # of parentheses, behind the name of a macro; of the lines that are hidden
    for at, line in enumerate([*lines, ""]):
        if not depth and line.lstrip()[:1] not in ("", "(") and not word.search(line):
            continue
        shown += [f"hidden_lines_{first}_{at}_", *[""] * (at - first - 1)] if first < at else []
        shown.append(line)
        first = at + 1
        for each in re.sub(r"\"[^\"]*\"|'[^']*'", "", line) if "#" not in line else "":
            depth = max(depth + (each == "(") - (each == ")"), 0)
    return "\n".join(shown[:-1]).rstrip("\n") + "\n"  # nothing asks for the numbers of lines behind the last one


def _show_lines(lines: list[str], match: re.Match[str]) -> str:
    """The lines that a name stands for; pcpp has as many line ends behind it, or one and the next line's number."""
    first, end = int(match[1]), int(match[2])
    return "\n".join(lines[first:end]) + match[3].removeprefix("\n" * (end - first - 1) if match[3][1:] else "")


class _Reader(Preprocessor):
    """pcpp, which refuses where it would warn or guess."""

    def __init__(self, where: str, beside: Beside, most: int) -> None:
        self.where, self.beside, self.most = where, beside, most
        self.kept, self.ever = dict[str, int](), dict[str, int]()  # ever: also where it was forgotten since
        self.missing, self.headers, self.expansions, self.directive = list[str](), list[str](), 0, 0
        self.contracts, self.read = True, dict[str, bytes]()
        super().__init__()
        self.evaluating, self.evaluator = self.evaluator, self.evaluate
        self.expand_filemacro = self.expand_linemacro = self.expand_countermacro = False
        for name in ("__DATE__", "__TIME__", "__PCPP__", "__FILE__"):
            self.macros.pop(name, None)
        for each in (*PREDEFINED, *MORE):
            self.define(each)

    def make_error(self, what: str, line: int, advice: str = ADVICE) -> InputError:
        return InputError(what, f"{self.where}, line {line}" if line else self.where, advice)

    def on_error(self, file: str, line: int, msg: str) -> None:
        if isinstance(known := sys.exception(), InputError):  # pcpp would wrap it
            raise known
        raise self.make_error(f"not C that is understood: {escape_text(msg)[:100]}", line)

    def on_directive_handle(self, directive: Any, toks: Any, ifpassthru: bool, precedingtoks: Any) -> Any:
        self.directive = directive.lineno  # also of lines that no compiler meets: nothing is decided here
        if directive.value == "pragma" and not toks:
            raise OutputDirective(Action.IgnoreAndRemove)
        return True

    def on_directive_unknown(self, directive: Any, toks: Any, ifpassthru: bool, precedingtoks: Any) -> Any:
        """A line that a compiler meets: not one in a branch of #if that is not taken."""
        text = "".join(tok.value for tok in toks)
        if directive.value == "error":
            raise self.make_error(f"#error: {escape_text(text)[:80]}", directive.lineno)
        if directive.value not in ("pragma", "line", "warning"):
            raise self.make_error(f"a line is not understood: #{escape_text(directive.value)}", directive.lineno)
        self.contracts &= text.split() != ["STDC", "FP_CONTRACT", "OFF"]
        return True

    def on_include_not_found(self, is_malformed: bool, is_system_include: bool, curdir: str, includepath: str) -> Any:
        raise self.make_error(f"a header is not understood: {escape_text(includepath)}", self.directive)

    def on_unknown_macro_in_defined_expr(self, tok: Any) -> Any:
        return not tok.value.startswith("__") and not tok.value.endswith("_H") and self._find_in_headers(tok.value)

    def on_unknown_macro_in_expr(self, ident: str) -> Any:
        if self.headers and OF_STANDARD.fullmatch(ident):
            what = f"#if asks for {escape_text(ident)}, which compilers give other values"
            raise self.make_error(what, self.directive, "write the branch that your compiler takes")
        return self._find_in_headers(ident)

    def _find_in_headers(self, ident: str) -> int:
        if self.missing:
            what = f"{self.missing[0]} is not there, and may say what the macro {escape_text(ident)} is"
            raise self.make_error(what, self.directive, "put the header beside the file, or take the test out")
        return 0

    def on_unknown_macro_function_in_expr(self, ident: str) -> Any:
        raise self.make_error(f"the macro {escape_text(ident)} is not known", self.directive)

    def include(self, tokens: Any, original_line: Any) -> Any:
        """Reads a header that lies beside the file; others are skipped."""
        text = "".join(tok.value for tok in self.tokenstrip(list(tokens)))
        name = text[1:-1]
        if text[:1] == "<" and {name.removesuffix(".h"), name.removeprefix("c")} & STANDARD:
            self.headers.append(name.removesuffix(".h"))
            return
        content = self.beside(name) if text[:1] == '"' else None
        if content is None:
            self.missing.append(name)
        elif name not in self.include_once:
            if re.search(rb"^\s*#\s*pragma\s+once\b", content, re.MULTILINE):
                self.include_once[name] = None
            if self.include_depth > 20:
                raise self.make_error(f"the header {escape_text(name)} includes itself", self.directive)
            self.most += len(content)
            self.read[name] = content
            yield from self.parsegen(_clean(content, f"{self.where}, {name}"), name, name)

    def define(self, tokens: Any) -> Any:
        """Keeps a macro that is a whole number as a name."""
        if not isinstance(tokens, str) and tokens:
            if tokens[0].value == "NDEBUG":
                what = "NDEBUG takes assertions away, which are read as preconditions"
                raise self.make_error(what, self.directive, "take out the assertions, or the line")
            name, value = tokens[0].value, parse_number("".join(tok.value for tok in tokens[1:]))
            self.kept.pop(name, None)  # a name that means several things is expanded where it stands
            if value is not None:
                self.kept[name] = value
                if self.ever.setdefault(name, value) != value:  # which its earlier uses would get, too
                    what = f"the macro {escape_text(name)} means two numbers"
                    raise self.make_error(what, self.directive, "give each number a name")
        return super().define(tokens)

    def undef(self, tokens: Any) -> Any:
        """Forgets a macro."""
        self.kept.pop(tokens[0].value if tokens else "", None)
        return super().undef(tokens)

    def evaluate(self, tokens: Any, **known: Any) -> Any:
        """What #if asks, once macros are expanded. Of numbers without signs, divisions and shifts pcpp is no C."""
        for each in (tok.value for tok in tokens):
            if parse_number(each.rstrip("lL")) is None and not ASKED.fullmatch(each) and each.strip():
                what = f"#if computes with {escape_text(each)[:40]}"
                raise self.make_error(what, self.directive, "compare macros with whole numbers, or write the branch")
        return self.evaluating(tokens, **known)

    def evalexpr(self, tokens: Any) -> Any:
        kept, self.kept = self.kept, {}
        try:
            return super().evalexpr(tokens)
        finally:
            self.kept = kept

    def expand_macros(self, tokens: Any, expanding_from: Any = ()) -> Any:
        self.expansions += 1
        if max(self.expansions, len(tokens)) > self.most:
            raise self.make_error("macros expand to too much text", self.directive)
        return super().expand_macros(tokens, [*dict.fromkeys((*expanding_from, *self.kept))])


# --- plain C that stands in C++

ENDINGS = (".ino", ".cpp", ".hpp", ".cc", ".h")
AROUND = re.compile(r'\bnamespace(?:\s+\w+)?\s*\{|\bextern\s*"C"\s*\{|\b(class)\s+\w+(?:\s+final)?\s*\{')
PARTS = re.compile(r"\b(?:public|private|protected)\s*:")
OF_CONST = re.compile(r"\)(\s*)(?:const\b\s*)?(?:noexcept\b\s*)?\{")
TEXTS = re.compile(r'"(?:[^"\\\n]|\\.)*"|\'(?:[^\'\\\n]|\\.)*\'')
WORDS = (
    (re.compile(r"\b(?:static\s+|inline\s+)*constexpr\b(?:\s+static\b)?"), "static const"),
    (re.compile(r"\bstatic_cast\s*<\s*([\w\s]+?)\s*>\s*\("), r"(\1)("),
    (re.compile(r"\bnullptr\b"), "NULL"),
    (re.compile(r"(?m)^([ \t]*#[ \t]*include[ \t]*<)c([a-z]+)>"), r"\1\2.h>"),  # <cstdint>
)


def strip_cpp(text: str, where: str) -> str:
    """The text as C; each line stays where it is. InputError for a class or namespace that has no end."""
    for words, plain in WORDS:
        text = words.sub(lambda match, plain=plain: match.expand(plain) + _breaks(match[0]), text)
    while match := AROUND.search(text):
        start = match.end()
        masked, depth, end = TEXTS.sub(lambda each: " " * len(each[0]), text), 1, start
        while depth and (brace := re.compile(r"[{}]").search(masked, end)):
            depth, end = depth + (1 if brace[0] == "{" else -1), brace.end()
        if depth:
            line = text.count("\n", 0, match.start()) + 1
            raise InputError("a class or namespace has no end", f"{where}, line {line}", "close its brace")
        inner, after = text[start : end - 1], text[end:]
        if match[1]:
            inner = PARTS.sub(lambda each: _breaks(each[0]), inner)
            inner = OF_CONST.sub(lambda each: f"){_breaks(each[0])} {{", inner)
            after = re.sub(r"\A(\s*);", r"\1", after)
        text = text[: match.start()] + _breaks(match[0]) + inner + after
    return text


def _breaks(text: str) -> str:
    return "\n" * text.count("\n")
