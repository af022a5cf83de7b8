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
    """A profile of the trees in a file of another program, as `maviper import` makes it.

    The only code that is run is if/else Python, behind a gate, and compiled C, each in a process of its own, to compare
    its answers with the tree; `run=False` runs neither, and the profile then says that the source was not compared.

    `file`: if/else Python or C, a header of ours, ONNX, or trees of XGBoost, LightGBM, treelite or dtControl,
    recognised by its name and content; or agent -> file, for a team. Names are instead of the file's own, for every
    agent. InputError for a file that is not understood in full, such as one that returns a list of constants without
    `scores` or `output_names`; MissingToolError without a package that reading it needs.
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
) -> PolicyProfile:
    """A profile of one agent from scikit-learn: a fitted tree or small forest, or a Pipeline or search of one.

    `feature_names`: default those it was fitted with, or x0, x1, ...; `action_names`: default its labels, in the order
    of `classes_`. A regressor of several outputs, or of more than 64 values, gives numbers: `output_names`, default y0,
    y1, ... InputError for anything but a fitted classifier of one output, or a regressor.
    """
    from codegen.importers.scikit import from_sklearn as imported

    return imported(classifier, feature_names, action_names, name, output_names)


@process.defaults
def from_onnx(
    model: Path | str | bytes,
    feature_names: Sequence[str] | None = None,
    action_names: Sequence[str] | None = None,
    name: str = "imported",
) -> PolicyProfile:
    """A profile of one agent from an ONNX model (bytes, or a path) that is one decision tree.

    Names as for `from_sklearn`. InputError for an operator that cannot be folded into the tree; MissingToolError
    without the package onnx.
    """
    from codegen.importers.onnx.model import from_onnx as imported

    return imported(model, feature_names, action_names, name)
