"""An origin of C that answers as the compiled program does.

Does: hands rows of the declared types to the builds, and their answers on as places of labels, or as numbers.
Assumes: the labels that the reader gave.
Does not: evaluate anything of the source.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from codegen.agreement.compiled import find_compiler
from codegen.importers.c.compiled.builds import COMPILED_BY, Answer, Compiled
from codegen.importers.c.compiled.tokens import ensure_same_tokens, list_headers
from codegen.importers.c.compiled.unit import BITS, CHAR, Asked, write_unit
from codegen.importers.c.text import Expanded
from codegen.importers.reading import Origin, Said
from codegen.importers.sourced import choose_rows
from codegen.ir import Bool, Floats

KINDS = {CHAR: "int8", BITS: "int32"}


def ask_compiler(
    origins: Mapping[str, tuple[Origin, Asked]], parsed: Any, text: Expanded, where: str, said: Said
) -> dict[str, Origin]:
    """The origins, which the builds answer for; without a compiler, or where nothing may be run, nobody does.
    InputError where the preprocessors differ.
    """
    compiler = find_compiler() if said.run else None
    if compiler is None:
        return {name: replace(origin, act=None, compared=False) for name, (origin, _) in origins.items()}
    ensure_same_tokens(text, compiler, where)
    asked = [each for _, each in origins.values()]
    unit = write_unit(parsed, asked, text.names, list_headers(text))
    compiled = Compiled(unit, asked, compiler, where, contracts=text.contracts)
    return {name: _ask_builds(origin, name, compiled, scores=said.scores) for name, (origin, _) in origins.items()}


def _ask_builds(origin: Origin, name: str, compiled: Compiled, *, scores: bool) -> Origin:
    def act(rows: Floats) -> Any:
        answers = compiled.answers(name, rows)
        if origin.vectors:
            return np.array(answers, np.float64)
        places = {label: place for place, label in enumerate(origin.labels)}
        return np.array([places.get(_label(each, scores=scores), -1) for each in answers], np.int32)

    def asks(rows: Floats) -> Floats:
        known = compiled.types(name)
        types = [
            *known,
            *["float64"] * (rows.shape[1] - len(known)),
        ]  # others are handed over, and nobody looks at them
        kinds = [KINDS.get(each, each) for each in types]
        sourced = choose_rows(compiled.numbers, kinds)
        tested = [_as_type(rows[:, column], kind) for column, kind in enumerate(kinds)]
        typed = np.column_stack([np.concatenate(pair).astype(np.float64) for pair in zip(tested, sourced, strict=True)])
        typed[:, np.array(types) == CHAR] = typed[:, np.array(types) == CHAR].clip(0)  # it may have a sign, or none
        return typed[compiled.holds(name, typed)] if BITS in types else typed

    def takes(rows: Floats) -> Bool:
        assert origin.takes is not None
        good = origin.takes(rows)
        if "overflow" not in origin.given:  # where assertions alone rule observations out
            compiled.ensure_failing(name, rows[~good & ~np.isnan(rows).any(axis=1)])
        return good

    return replace(origin, act=act, asks=asks, takes=origin.takes and takes, replayed_by=COMPILED_BY)


def _as_type(values: Floats, kind: str) -> Any:
    """Numbers of the tree's rows as a NumPy type has them: whole ones rounded up, and cut to its ends."""
    with np.errstate(over="ignore"):
        if kind.startswith("float"):
            return values.astype(kind)
        low, high = (0, 1) if kind == "bool" else (np.iinfo(kind).min, np.iinfo(kind).max)
        return np.nan_to_num(np.ceil(values.astype(np.float64))).clip(low, high).astype(kind)


def _label(answer: Sequence[Answer], *, scores: bool) -> Any:
    if len(answer) == 1:
        return answer[0]
    return answer.index(max(answer)) if scores else tuple(answer)
