"""ONNX models that are one decision tree, as profiles.

Does: reads a model (graph.py), and replays the tree under onnxruntime, or under the reference of ONNX without it.
Assumes: the package onnx; float32 or float64 observations.
Does not: take a model that is understood in part.
"""

from collections.abc import Callable, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from codegen import ir
from codegen.agreement.readback import onnx_session
from codegen.errors import InputError, MissingToolError, escape_text
from codegen.floats import FLOAT32, FLOAT64
from codegen.importers.onnx.fitted import giving
from codegen.importers.onnx.graph import decision_tree
from codegen.importers.origin import Names, profile_of
from codegen.importers.reading import AGENT, Origin
from codegen.ir import Floats, Int32

KIND = "ONNX"


def from_onnx(
    model: Path | str | bytes,
    feature_names: Sequence[str] | None = None,
    action_names: Sequence[str] | None = None,
    name: str = "imported",
) -> ir.PolicyProfile:
    """A profile of one agent from an ONNX model (bytes, or a path) that is a tree ensemble of one tree, with
    scalers, selections, casts and comparisons with constants before it (columns.py).

    It decides as the model does for every observation of its input's type, float32 or float64. InputError for every
    other model: one with a node that is not understood, whatever stands before or after the tree; another type of
    input; tests other than `<=` and `<`; nodes that send NaN to the left; scores that are changed; leaves that
    runtimes read in different ways. Names as for
    `from_sklearn`, labels in the model's order. MissingToolError without the package onnx.
    """
    try:
        content = model if isinstance(model, bytes) else Path(model).read_bytes()
    except OSError as error:
        raise InputError("cannot read the file", f"{model}: {error.strerror}", "check the path") from None
    return profile_of({AGENT: origin_of(content, feature_names)}, Names(feature_names, action_names, name))


def origin_of(content: bytes, feature_names: Sequence[str] | None = None) -> Origin:
    """The tree of a model. InputError as for `from_onnx`."""
    tree = decision_tree(content, len(feature_names or ()))
    if not tree.n_features and feature_names is None:
        raise InputError("the model does not say how many features it takes", "its input", "give their names")
    place = {label: index for index, label in enumerate(tree.labels)}
    run, replayed_by = _runner(content)

    def run_model(rows: Floats) -> Any:
        (answers,) = run([tree.output], {tree.input: rows})
        return answers

    def act(rows: Floats) -> Int32:
        return np.array([place[each] for each in run_model(rows).tolist()], dtype=np.int32)

    numbers = FLOAT64 if tree.double else FLOAT32
    origin = Origin(
        kind=KIND,
        grown=tree.grown,
        labels=tree.labels,
        act=act,
        replayed_by=replayed_by,
        n_features=tree.n_features,
        nan=tree.nan,
        numbers=numbers,
        given=f"{numbers}, the type of its input",
        placed=tree.actions,
    )
    if tree.gives is None:
        return origin
    return giving(origin, tree.gives, lambda rows: run_model(rows).reshape(len(rows), -1))


def _runner(content: bytes) -> tuple[Callable[..., Any], str]:
    """Returns the function that runs a model, and its name."""
    try:
        return onnx_session(content).run, "onnxruntime"
    except MissingToolError:
        reference: Any = import_module("onnx.reference")
        return reference.ReferenceEvaluator(content).run, "the reference evaluator of ONNX"
    except Exception as error:  # onnxruntime's own classes, which have no common name
        raise InputError("onnxruntime does not run the model", escape_text(error)[:200], "export it again") from None
