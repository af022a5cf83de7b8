"""The origin of a tree that is a program: its tree, its labels, and its replay.

Does: follows a program for its tree, and again for each observation of the replay.
Assumes: a front end (`Reading`) that interprets its language, with `Paths` to ask where a feature decides.
Does not: know the language.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from codegen.floats import FLOAT64
from codegen.importers.origin import Origin
from codegen.importers.symbolic.labels import Value, labels_of
from codegen.importers.symbolic.paths import Growth, Replay, Run
from codegen.ir import Floats, Int32

REPLAYED_BY = "an interpreter of the file's syntax tree"


@dataclass(frozen=True)
class Described:
    """What a front end knows of a program once all its paths were followed."""

    kind: str  # in words, such as "if/else Python"
    given: str  # what the program is given, in words
    places: Sequence[int]  # the place among the features of each input that tests name
    features: Sequence[str] = ()  # their names, where the source has some
    n_features: int = 0  # 0: the source does not say
    n_read: int = 0
    keyed: bool = False
    finite: bool = False
    order: Sequence[Value] = ()  # texts as the source names them
    called: Mapping[Value, str] = field(default_factory=dict[Value, str])  # names of values
    notes: tuple[str, ...] = ()  # what was skipped or assumed, in words
    scores: bool = False  # whether the user says that lists are scores


def origin_of(run: Run, where: str, describe: Callable[[], Described], numbers: str = FLOAT64) -> Origin:
    """The origin of a program that compares `numbers`. `describe` is asked after the program was followed.

    InputError for everything that the front end refuses, and for values of several kinds.
    """
    growth = Growth(where, numbers)
    with np.errstate(all="ignore"):
        growth.follow(run)
    said, grown = describe(), growth.tree()
    values = list(growth.values)
    order = [*said.order, *values]
    labels = labels_of(values, order, said.called, where, scores=said.scores)
    place = np.array([labels.place(value) for value in values], dtype=np.int32)
    places = np.array([*said.places, -1], dtype=np.int32)  # the last one: no feature
    columns = np.array(said.places, dtype=np.int64)

    def act(rows: Floats) -> Int32:
        replay = Replay(where, rows[:, columns])
        with np.errstate(all="ignore"):
            replay.follow(run)
        return np.array([labels.place(value) for value in replay.values], dtype=np.int32)

    return Origin(
        kind=said.kind,
        grown=replace(
            grown, feature=places[grown.feature], action=np.where(grown.action < 0, grown.action, place[grown.action])
        ),
        labels=labels.labels,
        called=labels.called,
        act=act,
        replayed_by=REPLAYED_BY,
        features=tuple(said.features),
        n_features=said.n_features,
        nan=growth.nan,
        finite=said.finite,
        numbers=numbers,
        given=said.given,
        keyed=said.keyed,
        n_read=said.n_read,
        notes=said.notes,
    )
