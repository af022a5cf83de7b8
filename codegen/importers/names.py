"""Legal names of features, actions and agents from anybody's labels.

Does: keeps what it can of a text or number; numbers equal feature names; refuses labels whose names collide.
Assumes: labels in the order of the actions.
Does not: choose the order of labels.

A name keeps a label's ASCII letters and digits, without accents; a minus sign before a number becomes the word minus,
what would begin with a number begins with action_, everything else becomes _: 5, -2 and "go left" are action_5,
action_minus_2 and go_left.
"""

import re
import unicodedata
from collections.abc import Sequence
from typing import Any

from codegen.check import identifier
from codegen.errors import InputError

SIGN = re.compile(r"(?<![A-Za-z0-9])-(?=\.?[0-9])")
MAX_LETTERS = 56  # with room for a number after them


def action_names(labels: Sequence[Any], names: Sequence[str] | None) -> list[str]:
    """The name of each class. InputError where there are more or fewer names, or two become the same one."""
    given = list(labels if names is None else names)
    if len(given) != len(labels):
        raise InputError(f"{len(given)} action names for {len(labels)} classes", "", "name each class once")
    found: dict[str, Any] = {}
    taken: dict[str, str] = {}
    for label in given:
        name = legal(label, "action")
        same = taken.setdefault(identifier(name), name)
        if same in found:
            what = f"the labels {found[same]!r} and {label!r} become the same action name, {name}"
            raise InputError(what, "", "give action_names, one per class")
        found[name] = label
    return list(found)


def legal(given: Any, prefix: str) -> str:
    """The legal name of a text or a number, as the module says."""
    text = given.decode(errors="replace") if isinstance(given, bytes) else str(given)
    text = unicodedata.normalize("NFKD", text).replace("\N{MINUS SIGN}", "-").strip()
    text = "".join(letter for letter in text if not unicodedata.combining(letter))
    signed = SIGN.match(text)
    text = SIGN.sub("minus_", text)
    text = "".join(letter if letter.isascii() and letter.isalnum() else "_" for letter in text).strip("_")
    return (f"{prefix}_{text}".rstrip("_") if signed or not text or not text[0].isalpha() else text)[:MAX_LETTERS]


def cleaned(names: Sequence[str], prefix: str) -> list[str]:
    """Legal names that keep what they can of those given; equal ones are numbered."""
    found: list[str] = []
    taken: set[str] = set()
    for given in names:
        text, number = legal(given, prefix), 2
        unique = text
        while identifier(unique) in taken:
            unique, number = f"{text}_{number}", number + 1
        taken.add(identifier(unique))
        found.append(unique)
    return found
