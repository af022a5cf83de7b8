"""A program asked once more, for many observations at once: what it returns for each by its own comparisons.

Does: follows the paths that the observations take; computes sums and what they are cut to.
Assumes: the program whose tree program.py has made.
Does not: anything for the tree: without this module an origin has no `act`.
"""

from collections.abc import Sequence
from itertools import repeat
from typing import Any

import numpy as np

from codegen.importers.reading import SUMS
from codegen.importers.symbolic.affine import Affine, Sums, sum_terms
from codegen.importers.symbolic.feature import SIGNS, Feature, Test
from codegen.importers.symbolic.paths import Paths, Run
from codegen.ir import Bool, Floats


def replay_program(run: Run, where: str, rows: Floats, sums: Sums | None, given: Any, numbers: str) -> Any:
    """The places of labels, or the numbers given, for each row of inputs. `given`: the values of program.py."""
    replay = Replay(where, rows, sums)
    with np.errstate(all="ignore"):
        replay.follow(run)
    return _answers(given, replay.values, replay.columns, numbers)


class Replay(Paths):
    """What a program returns for each of many observations, by its own comparisons."""

    def __init__(self, where: str, rows: Floats, sums: Sums | None = None) -> None:
        super().__init__(where, np.arange(len(rows)))  # the observations that come this far
        self.columns = [np.asarray(column, dtype=np.float64) for column in rows.T]
        self._sums, self._of_sums = sums, dict[int, Floats]()
        self.values: list[Any] = [None] * len(rows)
        self._computed: dict[str, dict[int, Any]] = {}  # by feature, of each observation that came where it is asked

    def holds(self, test: Test) -> bool:
        """Splits the observations once, where some of them pass and others do not."""
        holds = self._passing(test)
        if holds.all() or not holds.any():
            return bool(len(holds)) and bool(holds[0])
        answer = self._fork((0, 0.0))
        self.known = self.known[holds if answer else ~holds]
        return answer

    def end_path(self, value: Any) -> None:
        """The observations that came here return this."""
        for place in self.known.tolist():
            self.values[place] = value

    def least(self, feature: Feature) -> Any:
        """The least among the observations that came here."""
        return min(self._values(feature))

    def _column(self, place: int) -> Floats:
        """The numbers of an input or of a sum, one for each observation."""
        if place < SUMS or self._sums is None:
            return self.columns[place]
        if place not in self._of_sums:
            self._of_sums[place] = self._sums.column(place, self.columns)
        return self._of_sums[place]

    def _passing(self, test: Test) -> Bool:
        if test.feature.steps or not isinstance(test.number, float):
            compare, number = SIGNS[test.sign], test.number
            return np.fromiter(map(compare, self._values(test.feature), repeat(number)), np.bool_, len(self.known))
        given = self._column(test.feature.place)[self.known]
        return np.asarray(SIGNS[test.sign](given, test.number), dtype=np.bool_)

    def _values(self, feature: Feature) -> list[Any]:
        """What is computed of the observations that came here; of each once, for many tests ask about it."""
        computed, column = self._computed.setdefault(feature.key, {}), self._column(feature.place)
        known: list[int] = self.known.tolist()
        if len(computed) < len(self.values):
            new = np.array([row for row in known if row not in computed], np.int64)
            computed |= zip(new.tolist(), map(feature.value, column[new].tolist()), strict=True)
        return list(map(computed.__getitem__, known))


def _answers(given: Any, values: Sequence[Any], columns: Sequence[Floats], numbers: str) -> Any:
    """The places of labels, or the numbers given, for what each observation returned."""
    if not given.vectors:
        return np.array([given.labels.place(value) for value in values], dtype=np.int32)
    outputs = np.zeros((len(values), len(given.vectors[0])))
    rows_of = dict[Any, list[int]]()
    for place, each in enumerate(values):
        rows_of.setdefault(each, []).append(place)
    for each, rows in rows_of.items():
        vector = given.build_given(each)
        for output, form in enumerate(vector.vector):
            inputs = [column[rows] for column in columns] or [np.zeros(len(rows))]
            outputs[rows, output] = _cut(form, sum_terms(form.terms, inputs, numbers), numbers)
    return outputs


def _cut(form: Affine, values: Floats, numbers: str) -> Floats:
    """What the program's own minima and maxima make of values."""
    if form.cut is None:
        return values
    kind, cut = np.dtype(numbers).type, form.cut
    return np.array([float(cut.value(kind(value))) for value in values], np.float64)
