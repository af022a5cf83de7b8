"""Plain C that stands in C++: the text without the classes and namespaces around it.

Does: takes off namespaces, `extern "C"` and classes around functions; puts C's words for a few of C++.
Assumes: a text without comments.
Does not: read C++: what is left of it is no C, which the parser refuses. Objects have no state: a member that a method
  sets is a variable of the file that a function sets, which is refused.
"""

import re

from codegen.errors import InputError

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
        end = _closing(text, match.end())
        if end is None:
            line = text.count("\n", 0, match.start()) + 1
            raise InputError("a class or namespace has no end", f"{where}, line {line}", "close its brace")
        inner, after = text[match.end() : end], text[end + 1 :]
        if match[1]:
            inner = PARTS.sub(lambda each: _breaks(each[0]), inner)
            inner = OF_CONST.sub(lambda each: f"){_breaks(each[0])} {{", inner)
            after = re.sub(r"\A(\s*);", r"\1", after)
        text = text[: match.start()] + _breaks(match[0]) + inner + after
    return text


def _breaks(text: str) -> str:
    return "\n" * text.count("\n")


def _closing(text: str, start: int) -> int | None:
    """The place of the brace that closes the one before `start`."""
    depth = 1
    masked = TEXTS.sub(lambda match: " " * len(match[0]), text)
    for match in re.finditer(r"[{}]", masked[start:]):
        depth += 1 if match[0] == "{" else -1
        if depth == 0:
            return start + match.start()
    return None
