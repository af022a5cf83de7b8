"""The compact form of records: what the episodes of each cell come to, their hash, and nothing of single ones.

Does: says of each line-up and measure of a cell how many episodes there are, their mean and, where signs are mixed,
  the mean of their sizes; touches of prey also over the episodes in which they stay inside; hashes the episodes; packs
  the cells of a record into one file and reads it again, within a bound.
Assumes: episodes of a line-up follow one another from the first one on.
Does not: know what a cell is about, or judge anything.
"""

import hashlib
import json
import lzma
import math
from pathlib import Path

from maviper.files import runs

FORM = "maviper-record-1"
FILE = "cells.json.xz"
HEAD = "lineup,measure,episode,value\n"
TOLD = f"`sha256` is the hash of its episodes as lines of `{HEAD.strip()}`."
MAX_BYTES = 2**27  # unpacked
TOUCHES, RETURN, INSIDE = "prey touches", "prey return", "prey touches inside"
MOST_FINE = 5.0  # of prey that stay inside the arena
PER_TOUCH = 5.0  # two prey share what a touch costs one of them


def table_of(values: dict[str, dict[str, list[float]]], first: int) -> str:
    """Every value of a cell as CSV, as `episodes.csv` of a reproduction has it; what is hashed."""
    lines = [HEAD]
    for lineup, columns in values.items():
        for measure, column in columns.items():
            lines += [f"{lineup},{measure},{episode},{value!r}\n" for episode, value in enumerate(column, first)]
    return "".join(lines)


def hash_of(table: str) -> str:
    """The SHA-256 of a table of episodes."""
    return hashlib.sha256(table.encode()).hexdigest()


def summed(values: list[float]) -> dict[str, float]:
    """What values come to."""
    told = {"count": len(values), "mean": math.fsum(values) / len(values)}
    size = math.fsum(map(abs, values)) / len(values)
    return told if size == abs(told["mean"]) else {**told, "size": size}


def summed_up(values: dict[str, dict[str, list[float]]]) -> dict[str, dict[str, dict[str, float]]]:
    """What the values of each line-up and measure come to. Where prey are touched and pay, also the touches in the
    episodes in which they stay inside: their return is what they pay for touches and a fine for leaving.
    """
    told = {lineup: {name: summed(column) for name, column in of.items()} for lineup, of in values.items()}
    for lineup, of in values.items():
        if {TOUCHES, RETURN} <= set(of):
            pairs = zip(of[TOUCHES], of[RETURN], strict=True)
            inside = [touches for touches, paid in pairs if -paid - PER_TOUCH * touches <= MOST_FINE]
            told[lineup][INSIDE] = summed(inside) if inside else {"count": 0}
    return told


def packed(cells: dict[str, dict], **more) -> bytes:
    """The file of a record: cells by name, whatever else is said of all of them beside these."""
    parts = [f'"form": {json.dumps(FORM)}', *(f"{json.dumps(name)}: {_line(more[name])}" for name in sorted(more))]
    lines = ",\n".join(f"{json.dumps(name)}: {_line(cells[name])}" for name in sorted(cells))
    text = "{" + ",\n".join([*parts, f'"cells": {{\n{lines}\n}}']) + "}\n"
    return lzma.compress(text.encode(), preset=9 | lzma.PRESET_EXTREME)


def _line(value: object) -> str:
    return json.dumps(value, sort_keys=True, separators=(",", ":"))


def unpacked(place: Path) -> dict:
    """What a record's file holds. ValueError where it is of another form, InputError where it cannot be unpacked, or is
    larger than any record.
    """
    document = json.loads(runs.read_unpacked(place, MAX_BYTES))
    if document.get("form") != FORM:
        raise ValueError(f"{place}: not of the form {FORM}")
    return document
