"""An origin of C that answers as the compiled program does.

Does: says of which types rows are, hands them to the builds, and answers on as places of labels, or as numbers.
Assumes: the labels that the reader gave.
Does not: evaluate anything of the source.
"""

from collections.abc import Generator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from codegen.agreement.compiled import find_compiler
from codegen.errors import escape_text
from codegen.importers.c.compiled.builds import COMPILED_BY, Answer, Compiled
from codegen.importers.c.compiled.tokens import ensure_same_tokens, list_headers
from codegen.importers.c.compiled.unit import CHAR, Asked, write_unit
from codegen.importers.c.text import Expanded
from codegen.importers.reading import Answers, Origin, Running, Said
from codegen.ir import Floats

KINDS = {CHAR: "int8"}


def ask_compiler(
    origins: Mapping[str, tuple[Origin, Asked]], parsed: Any, text: Expanded, where: str, said: Said
) -> dict[str, Origin]:
    """The origins, which the builds answer for; without a compiler, or where nothing may be run, nobody does.
    InputError where the preprocessors differ.
    """
    compiler = find_compiler() if said.run else None
    if compiler is None:
        return {name: origin for name, (origin, _) in origins.items()}
    ensure_same_tokens(text, compiler, where)
    asked = [each for _, each in origins.values()]
    unit = write_unit(parsed, asked, text.names, list_headers(text))
    compiled = Compiled(unit, asked, compiler, where, contracts=text.contracts)
    return {
        name: replace(
            origin, second=partial(_run_builds, origin, name, compiled, scores=said.scores), replayed_by=COMPILED_BY
        )
        for name, (origin, _) in origins.items()
    }


@contextmanager
def _run_builds(origin: Origin, name: str, compiled: Compiled, *, scores: bool) -> Generator[Running]:
    """The numbers of a source, and what answers observations."""
    types = compiled.types(name)
    letters = [place for place, kind in enumerate(types) if kind == CHAR]

    def ask_rows(rows: Floats) -> Answers:
        taken = np.ones(len(rows), np.bool_) if origin.takes is None else origin.takes(rows)
        if origin.takes is not None and "overflow" not in origin.given:  # where assertions alone rule observations out
            compiled.ensure_failing(name, rows[~taken & ~np.isnan(rows).any(axis=1)])
        taken &= (rows[:, letters] >= 0).all(axis=1)  # a char may have a sign, or none
        answers = compiled.answers(name, rows[taken])
        told = np.zeros((len(rows), len(origin.vectors[0])) if origin.vectors else len(rows))
        if len(answers) and origin.vectors:
            told[taken] = answers
        elif len(answers):
            places = {label: place for place, label in enumerate(origin.labels)}
            told = told.astype(np.int32)
            told[taken] = [places.get(_label(each, scores=scores), -1) for each in answers]
        words = dict(zip(np.flatnonzero(taken).tolist(), answers, strict=True))
        return Answers(told, taken, np.ones(len(rows), np.bool_), lambda place: _word(words[place]))

    yield Running(compiled.numbers, ask_rows, [KINDS.get(each, each) for each in types])


def _word(answer: Sequence[Answer]) -> str:
    return escape_text(repr(answer[0] if len(answer) == 1 else list(answer)))[:200]


def _label(answer: Sequence[Answer], *, scores: bool) -> Any:
    if len(answer) == 1:
        return answer[0]
    return answer.index(max(answer)) if scores else tuple(answer)
