"""The exceptions that a user can meet, and what each one means for the exit code.

Does: carries what went wrong, where, and what to do next; suggests the closest match for a misspelt name.
Assumes: the command line prints the three lines; nothing here prints.
Does not: cover our own bugs (those stay ordinary exceptions and end in exit code 70).

    MaviperError
    |-- InputError            2  a file, option or configuration is wrong
    |   |-- PartlyReadError      some of a file's entries cannot be used; the others were read
    |   |-- Refused              something in a file of Python is not read, wherever it stands
    |   |-- ProfileError         a policy profile breaks its schema or an invariant
    |   `-- UnknownNameError     a name that does not exist, with the closest match
    |-- RefusedError          1  a certificate does not show what it claims
    |-- DisagreementError     4  generated code decides differently from the profile
    |-- MissingToolError      5  a compiler, an optional package or room for the output is missing
    `-- HangingToolError      5  a compiler or an interpreter did not end, and was stopped
"""

import difflib
from collections.abc import Iterable
from enum import IntEnum
from unicodedata import category


class ExitCode(IntEnum):
    """The exit statuses of a command; documented in `maviper --help`."""

    DONE = 0
    VIOLATED = 1
    INPUT = 2
    INCONCLUSIVE = 3
    DISAGREES = 4
    MISSING = 5
    BUG = 70
    INTERRUPTED = 130


class MaviperError(Exception):
    """Something that the user can mend: `what` happened, `where` (file, path in it), what to do `next_step`."""

    exit_code = ExitCode.INPUT

    def __init__(self, what: str, where: object = "", next_step: str = "") -> None:
        super().__init__(what)
        self.what = what
        self.where = str(where)  # a place finds its line here
        self.next_step = next_step

    def __str__(self) -> str:
        return "\n".join(line for line in (self.what, self.where, self.next_step) if line)


class InputError(MaviperError):
    """A file, an option or a configuration cannot be used as it is."""


class PartlyReadError(InputError):
    """Some entries of a file cannot be used; `read` are the others."""

    def __init__(self, what: str, where: object, next_step: str, read: Iterable[object]) -> None:
        super().__init__(what, where, next_step)
        self.read = tuple(read)


class ProfileError(InputError):
    """A policy profile breaks its schema or an invariant of the IR."""


class UnknownNameError(InputError):
    """A name that does not exist; the message carries the closest match."""

    def __init__(self, kind: str, name: str, known: Iterable[str], where: object = "") -> None:
        names, alone = list(known), name.partition(".")[2]
        advice = suggestion(name, names, LISTS.get(kind, ""))
        if kind == "coordinate" and alone in names:
            advice = f"write {escape_text(alone)}: it is shared, or there is one agent"
        super().__init__(f"unknown {kind} '{escape_text(name)}'", where, advice)


class RefusedError(MaviperError):
    """A certificate does not show what it claims."""

    exit_code = ExitCode.VIOLATED


class DisagreementError(MaviperError):
    """Generated code and the profile decide differently for some observation."""

    exit_code = ExitCode.DISAGREES


class MissingToolError(MaviperError):
    """A compiler or an optional package that the command needs is not installed, or there is no room to write."""

    exit_code = ExitCode.MISSING


class HangingToolError(MaviperError):
    """A program that the command started did not end by itself."""

    exit_code = ExitCode.MISSING


ALIKE = 0.55  # of names, the share of equal letters from which one may be meant for the other
MAX_NAMES_SHOWN, MAX_NAMES_LISTED = 10, 20  # where another command lists them, and where none does
WORLDS = "maviper worlds list"
LISTS = {"claim": "maviper verify --list", "world": WORLDS, "expert": WORLDS}  # kind of name -> what prints them all
STEERING = frozenset(("Cc", "Cf", "Zl", "Zp"))  # categories of control and format characters and of ends of lines


def escape_text(text: object) -> str:
    """A text that nobody vouches for, such as a name from a file: printable ASCII as it is, all else escaped."""
    return "".join(letter if " " <= letter <= "~" else escape_letter(letter) for letter in str(text))


def steers(text: str) -> bool:
    """Returns True if a text holds a control or format character, or the end of a line."""
    return not text.isprintable() and not STEERING.isdisjoint(map(category, text))


def escape_letter(letter: str) -> str:
    """A letter by its number."""
    return letter.encode("unicode_escape").decode()


def closest(name: str, known: Iterable[str]) -> str | None:
    """The name in `known` that is most like `name`, or None when nothing is."""
    found = max(known, key=lambda each: _likeness(each, name), default="")
    return found if _likeness(found, name) >= ALIKE else None


def suggestion(name: str, known: Iterable[str], lists: str = "") -> str:
    """One line that helps after a misspelt name: the closest matches, else the names, or if there are many the command
    that `lists` them.
    """
    names = list(known)
    match = closest(name, names)
    if match is not None:
        near = [each for each in dict.fromkeys(names) if _likeness(each, name) == _likeness(match, name)]
        return "did you mean " + " or ".join(f"'{escape_text(each)}'" for each in near[:MAX_NAMES_SHOWN]) + "?"
    if lists and len(names) > MAX_NAMES_SHOWN:
        return f"see `{lists}`"
    more = f", and {len(names) - MAX_NAMES_LISTED} more" if len(names) > MAX_NAMES_LISTED else ""
    return "known: " + ", ".join(map(escape_text, names[:MAX_NAMES_LISTED])) + more


def _likeness(known: str, name: str) -> float:
    return difflib.SequenceMatcher(None, known.casefold(), name.casefold()).ratio()
