"""Where a JSON text breaks off: the path of the value that was being read.

Does: follows a damaged text as far as it goes.
Assumes: the decoder has already refused the text; this only finds words for the place.
Does not: decode values.
"""

import re

_TOKEN = re.compile(r'"(?:[^"\\]|\\.)*"|[{}\[\],:]|[^\s{}\[\],:"]+|"')


def place(text: str) -> str:
    """The path in `text` at its end, with the line, e.g. `$.agents[1].tree[3] (line 87)`."""
    stack: list[str | int] = []  # keys of open objects, indices into open lists
    kinds: list[str] = []
    key_next = False
    end = 0
    for match in _TOKEN.finditer(text):
        token, end = match[0], match.end()
        if token in "{[":
            kinds.append(token)
            stack.append("" if token == "{" else 0)
            key_next = token == "{"
        elif token in "}]" and kinds:
            kinds.pop()
            stack.pop()
            key_next = False
        elif token == "," and kinds:
            last = stack[-1]
            stack[-1] = last + 1 if isinstance(last, int) else ""
            key_next = kinds[-1] == "{"
        elif token == ":":
            key_next = False
        elif key_next and len(token) > 1 and token.startswith('"'):
            stack[-1] = token[1:-1]
    steps = [f"[{step}]" if isinstance(step, int) else f".{step}" for step in stack if step != ""]
    return f"${''.join(steps)} (line {text.count(chr(10), 0, end) + 1})"
