"""Trees that a file holds as data, asked by the program that walks them: what it returns for many observations.

Does: follows the paths that the observations take, all at once; computes sums.
Assumes: tests of inputs and of sums, as nodes.py and products.py ask them; no arithmetic on them.
Does not: replay sources of Python and C, which Python and a compiler answer for.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from codegen.importers.reading import SUMS
from codegen.importers.symbolic.affine import Sums, sum_terms
from codegen.importers.symbolic.feature import SIGNS, Test
from codegen.importers.symbolic.paths import Paths, Run
from codegen.ir import Floats


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

    def holds(self, test: Test) -> bool:
        """Splits the observations once, where some of them pass and others do not."""
        assert not test.feature.steps
        given = self._column(test.feature.place)[self.known]
        holds = np.asarray(SIGNS[test.sign](given, test.number), dtype=np.bool_)
        if holds.all() or not holds.any():
            return bool(len(holds)) and bool(holds[0])
        answer = self._fork((0, 0.0))
        self.known = self.known[holds if answer else ~holds]
        return answer

    def end_path(self, value: Any) -> None:
        """The observations that came here return this."""
        for place in self.known.tolist():
            self.values[place] = value

    def _column(self, place: int) -> Floats:
        """The numbers of an input or of a sum, one for each observation."""
        if place < SUMS or self._sums is None:
            return self.columns[place]
        if place not in self._of_sums:
            self._of_sums[place] = self._sums.column(place, self.columns)
        return self._of_sums[place]


def _answers(given: Any, values: Sequence[Any], columns: Sequence[Floats], numbers: str) -> Any:
    """The places of labels, or the numbers given, for what each observation returned."""
    if not given.vectors:
        return np.array([given.labels.place(value) for value in values], dtype=np.int32)
    outputs = np.zeros((len(values), len(given.vectors[0])))
    rows_of = dict[Any, list[int]]()
    for place, each in enumerate(values):
        rows_of.setdefault(each, []).append(place)
    for each, rows in rows_of.items():
        for output, form in enumerate(given.build_given(each).vector):
            inputs = [column[rows] for column in columns] or [np.zeros(len(rows))]
            outputs[rows, output] = sum_terms(form.terms, inputs, numbers)
    return outputs
