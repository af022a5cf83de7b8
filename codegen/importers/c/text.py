"""The text of a C file as a parser takes it: without comments, and without lines of the preprocessor.

Does: blanks comments, an include guard and a few includes, so that lines keep their numbers.
Assumes: that no string of the file holds a comment; source.py takes no strings.
Does not: expand macros, or skip what a compiler might skip: every other line of the preprocessor is refused.
"""

import re

from codegen.errors import InputError, shown

HARMLESS = re.compile(r"#\s*(include\s*<(string|math|stdint|stdbool|stddef|float)\.h>|pragma once)")
GUARD = re.compile(r"#ifndef ([A-Za-z]\w*_H_?)")  # a name that no compiler defines by itself
COMMENT = re.compile(r"/\*(?:.*?\*/|.*\Z)|//[^\n]*", re.DOTALL)


def plain(text: str, where: str) -> str:
    """The file without comments, its guard and harmless lines of the preprocessor; other such lines are refused."""
    text = text.replace("\r\n", "\n")
    raw, lines = (each.split("\n") for each in (text, COMMENT.sub(lambda each: re.sub(r"[^\n]", " ", each[0]), text)))
    written = [place for place, line in enumerate(lines) if line.strip()]
    guard = GUARD.fullmatch(lines[written[0]].strip()) if len(written) > 2 else None
    if guard and (lines[written[1]].strip(), lines[written[-1]].strip()) == (f"#define {guard[1]}", "#endif"):
        for place in (written[0], written[1], written[-1]):
            lines[place] = ""
    for place, (line, before) in enumerate(zip(lines, raw, strict=True)):
        # a line that goes on may be a comment that goes on; trigraphs may hide it
        odd = "\\" in before or "??" in before or not before.expandtabs().isprintable()
        if odd or (line.strip().startswith("#") and not HARMLESS.fullmatch(line.strip())):
            what = f"a line is not understood: {shown(before.strip()[:80])}"
            raise InputError(what, f"{where}, line {place + 1}", "give C without macros and backslashes")
        lines[place] = "" if line.strip().startswith("#") else line
    return "\n".join(lines)
