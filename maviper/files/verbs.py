"""`maviper.from_file`, `from_sklearn` and `from_onnx`, the verbs: profiles of trees that other programs made.

Does: hands its parameters to the importers.
Assumes: it is imported with the package, so that nothing heavy may come with it.
Does not: read a file itself.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, TypedDict

from codegen.process import flags

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from codegen.ir import PolicyProfile


class Said(TypedDict, total=False):
    """What the user says of a file that does not say it itself."""

    scores: bool
    arrays: str


@flags.defaults
def from_file(
    file: str | Path | Mapping[str, str | Path],
    feature_names: Sequence[str] | None = None,
    action_names: Sequence[str] | None = None,
    name: str = "imported",
    numbers: str | None = None,
    said: Said | None = None,
) -> PolicyProfile:
    """A profile of the trees in a file of another program, as `maviper import` makes it; nothing in the file is run.

    `file`: if/else Python, ONNX, a single tree of XGBoost, LightGBM, treelite or dtControl, recognised by its name and
    content; or agent -> file, for a team. `feature_names`,
    `action_names`: instead of the file's own, for every agent. `numbers`: "float32" for agents that compare float32
    also where the file compares doubles. InputError for a file that is not understood in full, MissingToolError without
    a package that reading it needs.

    `said` may hold `scores`: whether a list of numbers that is returned holds a score for each action, of which the
    largest acts; without it such a file is refused. And `arrays`: "float32" or "float64" where if/else Python is given
    arrays of NumPy 2 of that type; without it, it is taken to be given Python's floats.
    """
    from pathlib import Path

    from maviper.files.importing import ImportOptions, imported

    features, actions = (None if each is None else tuple(each) for each in (feature_names, action_names))
    alone = Path(file) if isinstance(file, str | Path) else None
    team = None if isinstance(file, str | Path) else {agent: Path(each) for agent, each in file.items()}
    return imported(ImportOptions(alone, team, features, actions, name, numbers, **(said or {})))


@flags.defaults
def from_sklearn(
    classifier: object,
    feature_names: Sequence[str] | None = None,
    action_names: Sequence[str] | None = None,
    name: str = "imported",
) -> PolicyProfile:
    """A profile of one agent from a fitted scikit-learn DecisionTreeClassifier, or a Pipeline, search or forest of one.

    `feature_names`: default those it was fitted with, or x0, x1, ...; `action_names`: default its labels, in the order
    of `classes_`. InputError for anything but a fitted classifier of one output.
    """
    from codegen.importers.scikit import from_sklearn as imported

    return imported(classifier, feature_names, action_names, name)


@flags.defaults
def from_onnx(
    model: Path | str | bytes,
    feature_names: Sequence[str] | None = None,
    action_names: Sequence[str] | None = None,
    name: str = "imported",
) -> PolicyProfile:
    """A profile of one agent from an ONNX model (bytes, or a path) that is one decision tree.

    Names as for `from_sklearn`. InputError for a model with any other node; MissingToolError without the package onnx.
    """
    from codegen.importers.onnx.model import from_onnx as imported

    return imported(model, feature_names, action_names, name)
