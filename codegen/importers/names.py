"""Names and places of features and actions: what a source calls them, and what the user makes of that.

Does: keeps names and numbers that the source gives; lets the user rename (new=old), state an order, or name what has no
  name; refuses everything else, and says what became of each.
Assumes: labels in the source's order, numbers ascending.
Does not: read a source.

Labels that are whole numbers from 0 on are the actions' places: what returns 2 is action 2, and an action that no leaf
takes is there, too. That holds up to MAX_NUMBERED actions, and further where no number is left out. Any other label is
kept beside the action's name (`ActionSpec.label`), since generated code answers with places.

A name keeps a label's ASCII letters and digits, without accents; a minus sign before a number becomes the word minus,
what would begin with a number begins with action_, everything else becomes _: 5, -2 and "go left" are action_5,
action_minus_2 and go_left.
"""

import re
import unicodedata
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeAlias

from codegen.check import identifier
from codegen.errors import InputError, UnknownNameError, escape_text, steers
from codegen.wording import format_count

SIGN = re.compile(r"(?<![A-Za-z0-9])-(?=\.?[0-9])")
WHOLE = re.compile(r"0|[1-9][0-9]{0,8}")
NUMBERED = re.compile(r"(.*?)([0-9]+)")
MAX_LETTERS = 56  # with room for a number after them
MAX_LISTED = 30  # names in a line
MAX_NUMBERED = 256  # actions, where some are no label
EXACT = 2**53  # up to which every program reads a whole number as it is
RENAME = "write new=old for each that has another name"
Label: TypeAlias = int | float | str


class Renaming(NamedTuple):
    """Names that the user gives: a list, or new names by old ones."""

    plain: Sequence[str] | None
    pairs: Mapping[str, str]  # old -> new

    def rename(self, name: str, *others: str) -> str:
        """Returns the new name of one thing; `others`: what else it is called in the source."""
        for old in (each for each in (*others, name) if each in self.pairs):
            return legal(self.pairs[old], "x")
        known = {identifier(legal(each, "x")) for each in (name, *others)}
        return next((legal(new, "x") for old, new in self.pairs.items() if identifier(legal(old, "x")) in known), name)


class Action(NamedTuple):
    """An action: its name, what the source returns for it where neither name nor place say so, and that in words."""

    name: str
    label: Label | None
    source: str  # "": no leaf takes it

    @property
    def line(self) -> str:
        """A line that says in words what it is in the source."""
        told = f" <- {self.source}" if self.source else " (no leaf)"
        return self.name if self.source == self.name else f"{self.name}{told}"


@dataclass(frozen=True)
class Placed:
    """The features or actions that there are, and the place among them of each that the source has."""

    names: tuple[str, ...]
    place: tuple[int, ...]
    lines: tuple[str, ...]  # in words, what each is in the source
    labels: tuple[Label | None, ...] = ()
    known: tuple[str, ...] = ()  # what the source calls them


def renaming(given: Sequence[str] | None) -> Renaming:
    """Reads the user's names. InputError for a mixture of names and renamings, and for an old name that comes twice."""
    pairs = [tuple(part.strip() for part in each.partition("=")) for each in given or ()]
    if not any(sign for _, sign, _ in pairs):
        return Renaming(given, {})
    if not all(new and sign and old for new, sign, old in pairs) or len({old for _, _, old in pairs}) < len(pairs):
        raise InputError("some names are written new=old and others are not, or one is renamed twice", "", RENAME)
    return Renaming(None, {old: new for new, _, old in pairs})


def ensure_known(given: Renaming, placed: Sequence[Placed], kind: str) -> None:
    """UnknownNameError for an old name that no agent has."""
    known = list(dict.fromkeys(name for each in placed for name in each.known))
    keys = {identifier(legal(each, "x")) for each in known} | {*known}
    for old in given.pairs:
        if old not in keys and identifier(legal(old, "x")) not in keys:
            raise UnknownNameError(kind, old, known, f"--{kind}s")


def format_first(lines: Sequence[str]) -> str:
    """The first ones of many, and how many more there are."""
    more = len(lines) - MAX_LISTED
    return ", ".join([*lines[:MAX_LISTED], *([f"and {more} more"] if more > 0 else [])])


# --- actions


def actions_of(labels: Sequence[Any], called: Mapping[Any, str], given: Renaming) -> Placed:
    """The actions of a source that has these labels, some of which it calls by a name. InputError where names do not
    fit the source's own, or where the user gives two actions the same name; equal ones of the source are numbered.
    """
    values = [_value(each) for each in labels]
    known = [called.get(each, "") for each in labels]
    whole = [number for each in values if (number := _whole(each)) is not None]
    if len({*whole}) == len(values) and max(whole) < max(MAX_NUMBERED, len(whole)):
        labels_by_number = dict(zip(whole, zip(values, known, strict=True), strict=True))
        actions, place = _number_actions(labels_by_number, given), tuple(whole)
        known += map(str, range(len(actions)))
    else:  # in the source's order, or in that of the user
        own = [legal(name or value, "action") for name, value in zip(known, values, strict=True)]
        order = list(range(len(values))) if given.plain is None else _order(own, given.plain, "actions")
        texts = all(isinstance(each, str) for each in values)
        spelled = texts or any(isinstance(each, int) and abs(each) > EXACT for each in values)
        actions = list[Action]()
        for k in order:
            name, text = given.rename(own[k], str(values[k]), known[k]), str(values[k])
            actions.append(Action(name, text if spelled else values[k], known[k] or text))
        actions = _make_distinct(actions, given)
        if texts and all(each.label == each.name for each in actions):
            actions = [each._replace(label=None) for each in actions]
        place = tuple(order.index(k) for k in range(len(values)))
    names, kept, _ = zip(*actions, strict=True)
    lines = tuple(f"{k} {each.line}" for k, each in enumerate(actions))
    return Placed(names, place, lines, kept, tuple(filter(None, (*known, *map(str, values)))))


def outputs_of(count: int, given: Sequence[str] | None) -> Placed:
    """The numbers that a source gives: by the user's names, or y0, y1, ... InputError for another number
    of names, and for a name that maps another one."""
    if given is not None and len(given) != count:
        what = f"{format_count(len(given), 'output name')} for {format_count(count, 'number')}"
        raise InputError(what, "--outputs", "name each number once")
    if any("=" in name for name in given or ()):
        raise InputError("outputs are named in their order, without =", "--outputs", "write NAME,NAME,...")
    names = clean_names(list(given) if given is not None else [f"y{place}" for place in range(count)], "y")
    return Placed(tuple(names), tuple(range(count)), tuple(f"{place} {name}" for place, name in enumerate(names)))


def _value(label: Any) -> Label:
    """A label as numbers and texts of Python. InputError for control characters."""
    plain = label.item() if hasattr(label, "item") else label
    plain = plain.decode(errors="replace") if isinstance(plain, bytes) else plain
    if isinstance(plain, str) and steers(plain):
        raise InputError(f"a label holds control characters: {escape_text(plain)[:40]}", "", "rename it in the source")
    return plain


def _whole(value: Label) -> int | None:
    """The whole number from 0 on that a label is, or spells."""
    if isinstance(value, str):
        return int(value) if WHOLE.fullmatch(value) else None
    return int(value) if value >= 0 and value == value // 1 else None


def _number_actions(labels: Mapping[int, tuple[Label, str]], given: Renaming) -> list[Action]:
    """Actions whose labels are their places. `labels`: number -> label, and what the source calls it."""
    count = max(labels) + 1
    if given.plain is not None and len(given.plain) < count:
        what = f"{len(given.plain)} action names for the numbers 0 to {count - 1}"
        raise InputError(what, "", "name the action of each number, from 0 on, also of those that nothing returns")
    actions: list[Action] = []
    for number in range(count if given.plain is None else len(given.plain)):
        value, known = labels.get(number, (number, ""))
        name = legal(known or (value if isinstance(value, bool) else number), "action")
        if given.plain is not None:
            new = legal(given.plain[number], "action")
            if known and identifier(new) != identifier(name):
                what = f"the source calls the action {number} {escape_text(known)}, not {escape_text(new)}"
                raise InputError(what, "", f"name the actions of the numbers 0, 1, ... in this order, or {RENAME}")
            name = new
        name = given.rename(name, str(number), known)
        actions.append(Action(name, None, (known or str(value)) if number in labels else ""))
    return _make_distinct(actions, given)


def _order(own: Sequence[str], given: Sequence[str], kind: str) -> list[int]:
    """The place in `own` of each name given. InputError where these are other names."""
    keys, wanted = [identifier(each) for each in own], [identifier(legal(each, "x")) for each in given]
    if sorted(keys) != sorted(wanted) or len(set(keys)) < len(keys):
        what = f"the source names its {kind} itself: {', '.join(map(escape_text, own[:20]))}"
        where = f"given: {', '.join(map(escape_text, given[:20]))}"
        raise InputError(what, where, f"list the same names in your order, or {RENAME}")
    return [keys.index(each) for each in wanted]


def _make_distinct(actions: Sequence[Action], given: Renaming) -> list[Action]:
    """The actions, equal names numbered. InputError where the user gave such names."""
    by_name: dict[str, Action] = {}
    for each in actions:
        other = by_name.setdefault(identifier(each.name), each)
        if other is not each and (given.pairs or given.plain is not None):
            what = f"the labels {other.source!r} and {each.source!r} become the same action name, {each.name}"
            raise InputError(what, "", f"give them names: {RENAME}")
    names = clean_names([each.name for each in actions], "action")
    return [each._replace(name=name) for each, name in zip(actions, names, strict=True)]


# --- features


def features_of(own: Sequence[str], width: int, given: Renaming, *, keyed: bool = False) -> Placed:
    """The features of a source that gives these names, or none. `keyed`: it looks them up by name, so that observations
    may hold more, in any order.
    """
    names = list(own) or [f"x{index}" for index in range(width)]
    place = tuple(range(len(names)))
    if given.plain is not None:
        keys, wanted = ([identifier(legal(each, "x")) for each in some] for some in (names, given.plain))
        if keyed and set(keys) <= set(wanted) and len(set(wanted)) == len(wanted):
            place = tuple(map(wanted.index, keys))
        elif own and not (_is_numbered(own) and sorted(keys) != sorted(wanted)):
            order = _order([legal(each, "x") for each in own], given.plain, "features")
            place = tuple(order.index(k) for k in range(len(own)))
        elif len(given.plain) != width:
            raise InputError(f"{len(given.plain)} feature names for {width} features", "", "name each feature once")
        new = list(given.plain)
    else:
        new = [given.rename(each) for each in names]
    old = dict(zip(place, names, strict=True))
    new = clean_names(new, "x")
    lines = (
        f"{k} {name}" + (f" <- {old[k]}" if own and old.get(k, name) != name else "") for k, name in enumerate(new)
    )
    return Placed(tuple(new), place, tuple(lines), known=tuple(names))


def _is_numbered(names: Sequence[str]) -> bool:
    """Returns True if names say no more than places: x0, x1 and so on."""
    parts = [NUMBERED.fullmatch(each) for each in names]
    stems = {each[1] if each and int(each[2]) == k else None for k, each in enumerate(parts)}
    return len(stems) == 1 and None not in stems


# --- legal names


def legal(given: Any, prefix: str) -> str:
    """The legal name of a text or a number, as the module says."""
    text = given.decode(errors="replace") if isinstance(given, bytes) else str(given)
    text = unicodedata.normalize("NFKD", text).replace("\N{MINUS SIGN}", "-").strip()
    text = "".join(letter for letter in text if not unicodedata.combining(letter))
    signed = SIGN.match(text)
    text = SIGN.sub("minus_", text)
    text = "".join(letter if letter.isascii() and letter.isalnum() else "_" for letter in text).strip("_")
    return (f"{prefix}_{text}".rstrip("_") if signed or not text or not text[0].isalpha() else text)[:MAX_LETTERS]


def clean_names(names: Sequence[str], prefix: str) -> list[str]:
    """Legal names that keep what they can of those given; equal ones are numbered."""
    unique_names: list[str] = []
    taken: set[str] = set()
    for given in names:
        text, number = legal(given, prefix), 2
        unique = text
        while identifier(unique) in taken:
            unique, number = f"{text}_{number}", number + 1
        taken.add(identifier(unique))
        unique_names.append(unique)
    return unique_names
