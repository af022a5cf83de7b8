"""Claims written as calls, `reaches(radius=0.4, steps=25)`, in the words of property files.

Does: reads one as the table that a property file would have; writes a claim as one.
Assumes: whoever reads the table (`verify.claims.files`) checks names and values.
Does not: evaluate anything: a value is a value of TOML, or a word, which stands for a text.
"""

import json
import re
import tomllib
from collections.abc import Iterator, Mapping
from fractions import Fraction
from typing import Any

from codegen.errors import InputError, escape_text
from verify.claims.catalogue import ZONES, Claim, select_stated
from verify.claims.claim import Parameter
from verify.decimals import text

CALL = re.compile(r"\s*(\w+)\s*(?:\((.*)\)\s*)?", re.DOTALL)
WORD = re.compile(r"[\w.+/:@-]+")  # a text without quotes
PIECE = re.compile(r""""(?:[^"\\]|\\.)*"|'[^']*'|[\[{]|[\]}]|,|[^"'\[\]{},]+""")
ADVICE = "write NAME or NAME(PARAMETER=VALUE, ...), such as reaches(radius=0.4, steps=25)"


def read_call(written: str) -> dict[str, Any]:
    """The table of a property file that says the same. Decimals are texts, as there. InputError for what is no call."""
    call = CALL.fullmatch(written)
    if call is None:
        raise InputError("not a claim", escape_text(written), ADVICE)
    table: dict[str, Any] = {"name": call[1]}
    for part in _split(call[2] or "", written):
        key, equals, value = (each.strip() for each in part.partition("="))
        if not (equals and key.isidentifier() and value):
            raise InputError(f"'{escape_text(part.strip())}' is no parameter", escape_text(written), ADVICE)
        if key in table:
            raise InputError(f"{key} is given twice", escape_text(written), "leave one of them out")
        table[key] = _read_value(value, written)
    return table


def _split(listed: str, written: str) -> Iterator[str]:
    """The parts between commas that stand in no quotes and no brackets."""
    pieces, depth, part = PIECE.findall(listed), 0, ""
    if "".join(pieces) != listed:
        raise InputError("a quotation mark is not closed", escape_text(written), ADVICE)
    for piece in pieces:
        depth += (piece in "[{") - (piece in "]}")
        if piece == "," and not depth:
            yield part
        part = "" if piece == "," and not depth else part + piece
    if part.strip():
        yield part


def _read_value(value: str, written: str) -> Any:
    try:
        read = tomllib.loads(f"value = {value}", parse_float=str)
    except (ValueError, RecursionError):
        read = {}
    if read.keys() == {"value"}:
        return read["value"]
    if WORD.fullmatch(value):
        return value
    if value[0] == "[" and value[-1] == "]" and value.count("[") == 1:
        return [_read_value(each.strip(), written) for each in _split(value[1:-1], written)]
    raise InputError(
        f"cannot read the value {escape_text(value)}", escape_text(written), 'texts stand in quotes: "..."'
    )


def write_call(claim: Claim, zones: int | None = None) -> str:
    """A built-in claim as `read_call` reads it, with its team. `zones`: how many may be visited; None: as usual."""
    said: dict[str, Parameter] = {"team": claim.team, **select_stated(claim), **({ZONES: zones} if zones else {})}
    words = {"label": claim.label, "assume": getattr(claim, "assumption", "")}
    return spell_call(claim.name, said | {key: value for key, value in words.items() if value})


def spell_call(name: str, said: Mapping[str, Parameter]) -> str:
    """The call of a name with these parameters."""
    return f"{name}({', '.join(f'{key}={_write_value(value)}' for key, value in said.items())})"


def _write_value(value: Parameter) -> str:
    if isinstance(value, Fraction):
        return text(value)
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    return str(value) if isinstance(value, int) else f"[{', '.join(map(_write_value, value))}]"
