"""`maviper.from_file`, `from_sklearn` and `from_onnx`, the verbs: profiles of trees that other programs made.

Does: hands its parameters to the importers.
Assumes: it is imported with the package, so that nothing heavy may come with it.
Does not: read a file itself.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from codegen import process
from maviper.options import ImportOptions, spell_out

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path
    from typing import Unpack

    from codegen.ir import PolicyProfile


@process.defaults
@spell_out(ImportOptions)
def from_file(file: str | Path | Mapping[str, str | Path], **asked: Unpack[ImportOptions]) -> PolicyProfile:
    """Imports the trees in a file of another program, as `maviper import` does.

        team = maviper.from_file("policy.py", feature_names=["x", "v"])

    The only code that is run is if/else Python, behind a gate, and compiled C, each in a process of its own, to compare
    its answers with the tree; `run=False` runs neither, and the profile then says that the source was not compared.

    Args:
        file: If/else Python or C, a header of ours, ONNX, or trees of XGBoost, LightGBM, treelite or dtControl,
            recognised by its name and content; or agent -> file, for a team.

    Names are instead of the file's own, for every agent.

    Raises:
        InputError: The file is not understood in full, such as one that returns a list of constants without `scores`
            or `output_names`.
        MissingToolError: A package that reading it needs is not installed.
    """
    from pathlib import Path

    from maviper.importing.trees import import_trees

    if isinstance(file, str | Path):
        return import_trees(Path(file), **asked)
    return import_trees(None, {agent: Path(each) for agent, each in file.items()}, **asked)


@process.defaults
def from_sklearn(
    classifier: object,
    feature_names: Sequence[str] | None = None,
    action_names: Sequence[str] | None = None,
    name: str = "imported",
    output_names: Sequence[str] | None = None,
    numbers: str | None = None,
) -> PolicyProfile:
    """Imports a fitted tree or small forest of scikit-learn, or a Pipeline or search of one, as one agent.

        team = maviper.from_sklearn(DecisionTreeClassifier(max_depth=3).fit(x, y), ["x", "v"])

    Args:
        classifier: A classifier; or a regressor of several outputs, or of more than 64 values, which gives numbers.
        feature_names: Names of the features; default: those it was fitted with, or x0, x1, ...
        action_names: Names of the actions; default: its labels, in the order of `classes_`.
        name: The game whose agent the tree becomes, such as gymnasium:CartPole-v1; else a name for its world.
        output_names: Names of the numbers that a regressor gives; default: y0, y1, ...
        numbers: What is observed, such as int16: thresholds are rounded down; default: floats, as the model compares.

    Raises:
        InputError: This is no fitted classifier of one output, and no regressor.
    """
    from codegen.importers.scikit import from_sklearn as imported

    return imported(classifier, feature_names, action_names, name, output_names, numbers)


@process.defaults
def from_onnx(
    model: Path | str | bytes,
    feature_names: Sequence[str] | None = None,
    action_names: Sequence[str] | None = None,
    name: str = "imported",
) -> PolicyProfile:
    """Imports an ONNX model that is one decision tree, as one agent.

        team = maviper.from_onnx("policy.onnx", ["x", "v"])

    Args:
        model: The model's bytes, or its path.
        feature_names: Names of the features; default: x0, x1, ...
        action_names: Names of the actions; default: the model's labels.
        name: As for `from_sklearn`.

    Raises:
        InputError: An operator cannot be folded into the tree.
        MissingToolError: The package onnx is not installed.
    """
    from codegen.importers.onnx.model import from_onnx as imported

    return imported(model, feature_names, action_names, name)
