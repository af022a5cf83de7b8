"""A source of Python asked by Python itself, in a process of its own, and its answers as those of an origin.

Does: starts the process, hands over the source and how it is called, then observations; compares what lists of floats
  and arrays are answered; makes labels or outputs of answers.
Assumes: how the reader takes the source to be called.
Does not: run anything in this process, or know how the reader read.
"""

# pyright: basic
# answers may be anything
import json
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from codegen.agreement import programs
from codegen.errors import DisagreementError, InputError, escape_text
from codegen.floats import FLOAT32, FLOAT64
from codegen.importers.reading import Answers, Origin, Running
from codegen.importers.running.gate import gate_source
from codegen.ir import Floats

SECONDS = 60
BYTES = 4 << 30  # of address space
LINE = 1 << 28
RUN_ADVICE = "write it with what importing.md lists"
PYTHON = f"Python {sys.version_info.major}.{sys.version_info.minor} itself"
CHILD = Path(__file__).parent / "child.py"
PRECONDITION = "AssertionError"
FORMS = {"floats": "Python's floats", FLOAT64: "float64 arrays", FLOAT32: "float32 arrays of NumPy 2"}
FORM_ADVICE = "say --arrays floats if it is given no arrays; else make floats of what it compares: float(x[0])"
ENVIRONMENT = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "PATH": ""}


@dataclass(frozen=True, kw_only=True)
class Called:
    """The way to call a source, as the reader takes it. A shape is the place of a number in an observation, "row" for
    all of it, or places by name.
    """

    source: str  # its bytes, each as the character of that number
    where: str
    entry: str  # a name of the file
    method: str = ""  # of the entry; "": the entry itself
    made: bool = True  # whether a class is called for an object first
    given: Sequence[Any] = ()  # the shapes of what is given by place
    named: Mapping[str, Any] = field(default_factory=dict[str, Any])  # ... and by name
    forms: Sequence[str] = ("floats",)  # "floats", "float64", "float32"
    scores: bool = False  # whether a list that is returned holds a score for each action
    kept: Sequence[tuple[str, Any]] = ()  # attributes that are remembered, with their values; None: whole numbers


@contextmanager
def run_source(called: Called, origin: Origin) -> Iterator[Running]:
    """The numbers of a source, and what answers observations, while its process lives.

    InputError for a source that does not pass the gate, or ends otherwise than with answers; DisagreementError where
    floats and arrays are answered differently.
    """
    request = {**asdict(called), "seconds": SECONDS, "bytes": BYTES, "library": str(Path(np.__file__).parent.parent)}
    command = [sys.executable, "-I", "-S", "-B", "-X", "utf8", str(CHILD)]
    with programs.start(command, 2 * SECONDS, ENVIRONMENT) as process:

        def ask_rows(rows: Floats) -> Answers:
            content = np.ascontiguousarray(rows, np.float64)
            head = json.dumps({"rows": len(rows), "width": rows.shape[1]}).encode() + b"\n"
            given = _exchange(process, called, head + content.tobytes())
            said = [([_read_answer(each, called, origin) for each in told], np.array(at, int)) for told, at in given]
            return _join_forms(called, said, content, origin)

        told = _exchange(process, called, json.dumps(request).encode() + b"\n")
        if "refused" in told:
            raise _make_error(called, told["refused"], told["line"])
        yield Running(told["numbers"], ask_rows)


def ensure_gated(called: Called) -> None:
    """InputError for a source that does not pass the gate, where nothing is to be run."""
    try:
        gate_source(called.source.encode("latin-1"), called.entry, called.method)
    except SyntaxError as error:
        raise _make_error(called, error.msg, error.lineno) from None


def _make_error(called: Called, what: str, line: int | None) -> InputError:
    where = f"{called.where}, line {line}" if line else called.where
    return InputError(f"Python does not run it: {escape_text(what)}", where, RUN_ADVICE)


def _exchange(process: Any, called: Called, content: bytes) -> Any:
    """Sends a message, and returns the process's answer. InputError where it answers nothing, or too much."""
    assert process.stdin is not None and process.stdout is not None
    try:
        process.stdin.write(content)
        process.stdin.flush()
    except (BrokenPipeError, OSError):
        pass  # it has ended, which its empty answer says
    line = process.stdout.readline(LINE)
    if not line.endswith(b"\n"):
        what = (
            f"Python gives no answer: it takes longer than {SECONDS} s, or more memory, or reaches out of its process"
        )
        raise InputError(what, called.where, RUN_ADVICE)
    return json.loads(line)


@dataclass(frozen=True)
class Answer:
    """An answer: the place of its label or its numbers; None: neither. `text`: as a person reads it."""

    value: int | tuple[float, ...] | None
    text: str
    raised: str | None = None  # the kind of an error
    member: str = ""  # of an Enum


def _read_answer(said: Any, called: Called, origin: Origin) -> Answer:
    """An answer of the process, as this origin's."""
    if called.kept and isinstance(said, list):
        inner = _read_answer(said[0], replace(called, kept=()), origin)
        known = isinstance(inner.value, int) and None not in said[1:]
        return replace(inner, value=(inner.value, *said[1:]) if known else None, text=f"{inner.text}, then {said[1:]}")
    if isinstance(said, dict) and "raised" in said:
        text = f"raises {said['raised']}: {escape_text(said['said'])}"
        return Answer(None, text[:200], said["raised"])
    if isinstance(said, dict) and "strange" in said:
        return Answer(None, f"an object of the type {escape_text(said['strange'])}")
    while isinstance(said, list) and len(said) == 1 and not isinstance(said[0], str):
        said = said[0]  # a list of one number is that number
    member = said["member"] if isinstance(said, dict) else ""
    text = escape_text(repr(member or said))[:200]
    if isinstance(said, dict):
        if origin.vectors:
            return Answer(None, text)
        said = said["value"] if isinstance(said["value"], int | float | str) else member
    if origin.vectors:
        parts = said if isinstance(said, list) else [said]
        plain = len(parts) == len(origin.vectors[0]) and all(type(each) in (int, float, bool) for each in parts)
        return Answer(tuple(map(float, parts)) if plain else None, text)
    if isinstance(said, list):
        plain = all(type(each) in (int, float, bool) for each in said) and len(said) == len(origin.labels)
        return Answer(said.index(max(said)) if plain and called.scores else None, text)
    places = {label: place for place, label in enumerate(origin.labels)}
    return Answer(None if said is None else places.get(said), text, member=member)


def _join_forms(called: Called, said: Sequence[tuple[list[Answer], Any]], rows: Floats, origin: Origin) -> Answers:
    """The answers of all forms in which the source takes observations: lists of floats, arrays. DisagreementError where
    two are answered differently.
    """
    taken = [place for place, (answers, _) in enumerate(said) if any(each.raised is None for each in answers)]
    first, *others = taken or [0]
    answers, places = said[first]
    for other in others:
        theirs, their_places = said[other]
        pairs, pair_of = np.unique(places * len(theirs) + their_places, return_inverse=True)
        wrong = [_differs(answers[pair // len(theirs)], theirs[pair % len(theirs)]) for pair in pairs.tolist()]
        for place in np.flatnonzero(np.array(wrong, bool)[pair_of])[:1].tolist():
            texts = answers[places[place]].text, theirs[their_places[place]].text
            what = (
                f"Python answers {texts[0]} to {FORMS[called.forms[first]]}, {texts[1]} to {FORMS[called.forms[other]]}"
            )
            numbers = ", ".join(map(repr, rows[place].tolist()[:20]))
            raise DisagreementError(what, f"{called.where}: [{numbers}]", FORM_ADVICE)
    told = combine_answers(answers, places, origin)
    return told if len(taken) == len(said) else replace(told, given=FORMS[called.forms[first]])


def _differs(one: Answer, other: Answer) -> bool:
    return repr(one.value) != repr(other.value) or (one.value is None and one.text != other.text)


def combine_answers(answers: Sequence[Answer], places: Any, origin: Origin) -> Answers:
    """The answers of an origin's source, of which `places` has one for each row."""
    texts, members = [each.text for each in answers], dict[Any, str]()
    alike = [each.value is not None and members.setdefault(each.value, each.member) == each.member for each in answers]
    asked = np.array([each.raised != PRECONDITION for each in answers], bool)[places]
    known = np.array(alike, bool)[places]
    if origin.vectors:
        none = (float("nan"),) * len(origin.vectors[0])
        told: Any = np.array([none if each.value is None else each.value for each in answers])[places]
    elif origin.memory:
        none = (-1,) * (1 + len(origin.memory))
        told = np.array([none if each.value is None else each.value for each in answers], np.int64)[places]
    else:
        told = np.array([-1 if each.value is None else each.value for each in answers], np.int32)[places]
    return Answers(told, asked, known, lambda place: texts[places[place]])
