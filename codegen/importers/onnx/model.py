"""ONNX models that are one decision tree, as profiles.

Does: follows a model's graph from the observation to the tree, and from its label or numbers to an output; folds the
  operators before the tree into its thresholds, and those after a regressor into the numbers of its leaves; replays the
  tree under onnxruntime, or under the reference of ONNX without it.
Assumes: the package onnx; observations [N, n_features] of float32, or of float64 where the tree takes them as they are.
Does not: take a model that is understood in part, read a file that it refers to, or guess. Another operator, or another
  way for an observation or a label, ends in an InputError that names the node.
"""

from collections.abc import Callable, Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from codegen import ir
from codegen.agreement.readback import onnx_session
from codegen.errors import InputError, MissingToolError, escape_text
from codegen.floats import FLOAT32, FLOAT64
from codegen.importers.onnx.columns import (
    FLOAT,
    MAIN,
    MAX_COLUMNS,
    ML,
    OPERATORS,
    Call,
    Column,
    Columns,
    apply_operator,
)
from codegen.importers.onnx.fitted import Asked, Folded, fold_steps, giving
from codegen.importers.onnx.tree import (
    ADVICE,
    ENSEMBLE,
    LABELS,
    MAX_TARGETS,
    NUMBER,
    REGRESSOR,
    TREES,
    WHOLE,
    describe_node,
    make_error,
    read_ensemble,
    read_tree,
)
from codegen.importers.origin import Names, profile_of
from codegen.importers.reading import AGENT, MAX_FEATURES, Origin
from codegen.ir import NO_CHILD, NO_FEATURE, Bool, Float32, Floats, GrownTree, Int32

KIND = "ONNX"
OPERATOR_TREES = (*TREES, ENSEMBLE)
UNDERSTOOD = {
    *((ML, each) for each in (*OPERATOR_TREES, "ZipMap")),
    *((MAIN, each) for each in ("Constant", "Reshape")),
    *OPERATORS,
}
CONSTANT = {(MAIN, each) for each in ("Shape", "Slice", "ConstantOfShape", "Cast", "Reshape")} | {(ML, "ZipMap")}
OBSERVATION, SCORES, UNKNOWN = "the observation", "the tree's scores", "no value of this graph"
FLAT = "the tree's number, one for each observation"
KNOWN = (SCORES, FLAT, *LABELS.values())  # what an output may be
OLD_OPSETS, NEW_OPSETS = (1, 4), (5, 5)  # of ai.onnx.ml, in which the operators are
MAX_WORK = 1 << 22  # columns of all operators together


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


# --- the graph


@dataclass(frozen=True)
class Given:
    """The columns that operators make of a regressor's numbers, whose source is the target."""

    columns: Columns


Value: TypeAlias = str | Columns | np.ndarray | Given  # a text: in words what it is


class OnnxTree(NamedTuple):
    """The deciding parts of a model: the tree, the labels of its classes, and how many features an observation has."""

    grown: GrownTree
    labels: tuple[int | str, ...]
    n_features: int  # 0: the model does not say
    input: str  # the observation's name in the graph
    output: str  # the name of an output that is the label, or a regressor's numbers
    nan: bool  # whether a NaN, which goes right, goes where the model sends it
    double: bool = False  # whether observations are float64
    gives: Float32 | None = None  # what a regressor gives at each leaf, [n_leaves, n_targets]
    actions: tuple[str, ...] = ()  # of the profile that it says it was made from, whose places its labels are


def decision_tree(model: bytes, n_features: int = 0) -> OnnxTree:
    """The tree of a model. `n_features`: for a model that does not say. InputError where it is more than one tree that
    is understood in full, MissingToolError without the package onnx.
    """
    try:
        onnx: Any = import_module("onnx")
    except ImportError:
        raise MissingToolError("reading ONNX needs the package onnx", "", "pip install onnx") from None
    try:
        loaded = onnx.load_model_from_string(model)
    except Exception as error:  # the parser's own class, which moves between versions
        raise InputError("not an ONNX model", str(error)[:200], "is this the right file?") from None
    constant = {(MAIN, "ConstantOfShape")} <= {_operator(node) for node in loaded.graph.node} <= CONSTANT
    if not constant:
        if len(loaded.functions):
            raise InputError("the model defines operators of its own", repr(loaded.functions[0].name), ADVICE)
        for node in loaded.graph.node:
            if _operator(node) not in UNDERSTOOD:
                raise make_error(node, f"the model has a node that is not understood: {node.op_type!r}")
        trees = [node.op_type for node in loaded.graph.node if node.op_type in OPERATOR_TREES]
        if len(trees) != 1:
            what = f"the model has {len(trees)} nodes {' or '.join(OPERATOR_TREES)}, one is needed"
            raise InputError(what, "", ADVICE)
        versions = {each.version for each in loaded.opset_import if each.domain == ML}
        least, most = NEW_OPSETS if trees == [ENSEMBLE] else OLD_OPSETS
        if len(versions) != 1 or not least <= min(versions) <= most:
            present = ", ".join(map(str, sorted(versions))) or "none"
            what = f"version {present} of {ML} is not supported; {least} to {most} are"
            raise InputError(what, "opset_import", "export it again")
    try:
        onnx.checker.check_model(loaded)
    except Exception as error:  # ValidationError, or what the parser of types raises
        raise InputError("not a valid ONNX model", str(error)[:200], "export it again") from None
    if constant:
        return _constant_label(onnx, loaded.graph, n_features)
    flow = _Flow(onnx, loaded.graph, n_features)
    read = partial(read_ensemble, whole=flow.whole) if flow.tree.op_type == ENSEMBLE else read_tree
    grown, labels, gives = read(onnx, flow.tree, flow.double)
    gives = None if gives is None else _after(gives, flow.values[flow.output], flow.tree)
    n_columns = len(flow.before) or flow.width
    last = int(grown.feature.max())
    if 0 < n_columns <= last:
        raise make_error(flow.tree, f"the tree tests feature {last}, the input has {n_columns}", "export it again")
    whole = _fold_columns(grown, flow.before) if flow.before else Folded(grown, True)
    nan = whole.nan and flow.nan
    said = {each.key: each.value for each in loaded.metadata_props}
    ours = {"profile", "agent", "actions"} <= said.keys() and "labels" not in said
    actions = tuple(said["actions"].split(",")) if ours else ()
    return OnnxTree(whole.tree, labels, flow.width, flow.input, flow.output, nan, flow.double, gives, actions)


def _constant_label(onnx: Any, graph: Any, n_features: int) -> OnnxTree:
    """The one leaf of a classifier that has seen one class, as skl2onnx writes it: its label is repeated as often as
    the observation's shape says.
    """
    makers = {name: node for node in graph.node for name in node.output}
    for output in graph.output:
        node = makers.get(output.name)
        while node is not None and node.op_type == "Cast" and _type(onnx, node.attribute[0].i) == "INT64":
            node = makers.get(node.input[0])
        if node is not None and node.op_type == "ConstantOfShape" and len(node.attribute) == 1:
            label = onnx.numpy_helper.to_array(node.attribute[0].t)
            if label.dtype == np.int64 and label.size == 1:
                name, width, double = _read_input(onnx, graph, frozenset())
                leaf = GrownTree(*(np.array([each]) for each in (NO_FEATURE, 0.0, NO_CHILD, NO_CHILD, 0)))
                return OnnxTree(leaf, (int(label.item()),), width or n_features, name, output.name, True, double)
    raise InputError("no output of the model is a tree's label", "graph.output", ADVICE)


def _fold_columns(grown: GrownTree, columns: Columns) -> Folded:
    split = np.flatnonzero(grown.feature != NO_FEATURE)
    tested, thresholds = grown.feature[split], grown.threshold[split]
    groups: list[tuple[Column, Any]] = [
        (columns[place], np.flatnonzero(tested == place)) for place in np.unique(tested).tolist()
    ]

    def passes(numbers: Float32) -> Bool:
        found = np.zeros(len(split), dtype=np.bool_)
        for column, places in groups:
            found[places] = column.values(numbers[places]) <= thresholds[places]
        return found

    source = np.array([each.source for each in columns])[tested]
    rising = np.array([each.rising for each in columns])[tested]
    return fold_steps(grown, Asked(source, rising, passes))


def _after(gives: Float32, value: Value, tree: Any) -> Float32:
    """The numbers of the leaves after the operators behind the tree, as these compute them: [n_leaves, n_numbers]."""
    if not isinstance(value, Given):
        return gives
    numbers: Float32 = np.stack([each.values(gives[:, each.source]) for each in value.columns], axis=1)
    if not np.isfinite(numbers).all():
        raise make_error(tree, "a leaf's number is not finite", "export it again")
    for each in value.columns:
        stages = [each._replace(steps=each.steps[:n]).values(gives[:, each.source]) for n in range(len(each.steps) + 1)]
        if not each.nan and any((np.signbit(stage) & (stage == 0)).any() for stage in stages):
            raise make_error(tree, "a number is cut at -0.0, of which runtimes keep either sign")
    return numbers


def _type(onnx: Any, number: int) -> str:
    names = {value: name for name, value in onnx.TensorProto.DataType.items()}
    return names.get(number, f"type {number}")


def _operator(node: Any) -> tuple[str, str]:
    return (MAIN if node.domain == "ai.onnx" else node.domain, node.op_type)


def _read_input(onnx: Any, graph: Any, constants: AbstractSet[str]) -> tuple[str, int, bool]:
    """The input's name, its width (0: not declared), and whether it is float64. InputError for any other input."""
    if len(graph.input) != 1:
        raise InputError(f"the model has {len(graph.input)} inputs, one is needed", "graph.input", ADVICE)
    (given,) = graph.input
    if given.name in {*constants, *(each.values.name for each in graph.sparse_initializer)}:
        raise InputError("the model's input has a constant value", repr(given.name), ADVICE)
    tensor, types = given.type.tensor_type, onnx.TensorProto
    if tensor.elem_type not in (types.FLOAT, types.DOUBLE):
        what = f"the model's input is {_type(onnx, tensor.elem_type)}, but observations are FLOAT or DOUBLE"
        raise InputError(what, repr(given.name), "export it with a float32 input")
    shape = tensor.shape.dim
    if tensor.HasField("shape") and len(shape) != 2:
        raise InputError(f"the model's input has {len(shape)} axes, two are needed", repr(given.name), ADVICE)
    width = int(shape[1].dim_value) if tensor.HasField("shape") else 0
    if not 0 <= width <= MAX_FEATURES:
        raise InputError(f"the model's input has {width} features", repr(given.name), ADVICE)
    return str(given.name), width, tensor.elem_type == types.DOUBLE


class _Flow:
    """A graph in which each value has a known origin: its tree, what the tree is given, and an output that is the
    tree's label.
    """

    def __init__(self, onnx: Any, graph: Any, n_features: int) -> None:
        self.onnx, self.work = onnx, 0
        self.before: Columns = ()  # what the tree is given; (): the observation itself
        self.nan = True  # whether it is known what becomes of a NaN
        self.tree: Any = next(node for node in graph.node if node.op_type in OPERATOR_TREES)
        given = set(self.tree.output)  # whether a Cast is given it; nodes stand in order, and Identity changes nothing
        for node in graph.node:
            if node.op_type == "Identity" and given.intersection(node.input):
                given.update(node.output)
        self.whole = any(node.op_type == "Cast" and given.intersection(node.input) for node in graph.node)
        self.values: dict[str, Value] = {}
        for tensor in graph.initializer:
            self.values[tensor.name] = self.array(tensor, tensor.name)
        self.input, self.width, self.double = _read_input(onnx, graph, self.values.keys())
        self.values[self.input] = OBSERVATION
        if not self.width:
            self.width = n_features
        if 0 < self.width <= MAX_COLUMNS and not self.double:
            self.values[self.input] = tuple(Column(place) for place in range(self.width))
        for node in graph.node:
            self.values |= dict(zip(node.output, self.follow_node(node), strict=False))
        self.output = self.label(graph)

    def array(self, tensor: Any, name: str) -> np.ndarray | str:
        """A constant; one that lies in another file, or is no array of numbers, is no value."""
        if tensor.data_location == self.onnx.TensorProto.EXTERNAL or tensor.external_data:
            raise InputError("a constant lies in another file", repr(name), "save the model in one file")
        try:
            return np.asarray(self.onnx.numpy_helper.to_array(tensor))
        except (ValueError, TypeError) as error:
            what = f"a constant is not readable: {str(error)[:100]!r}"
            raise InputError(what, repr(name), "export it again") from None

    def label(self, graph: Any) -> str:
        """The name of an output that is the label. InputError for outputs that are something else."""
        outputs = {each.name: self.values.get(each.name, UNKNOWN) for each in graph.output}
        for name, value in outputs.items():
            if not self.is_given(value) and not (isinstance(value, str) and value in KNOWN):
                raise InputError(f"an output of the model is {_words(value)}", repr(name), ADVICE)
        if sum(map(self.is_given, outputs.values())) > 1:
            raise InputError("the tree's numbers are given twice", "graph.output", "export one output")
        label = next((name for name, value in outputs.items() if value != SCORES), None)
        if label is None:
            raise InputError("no output of the model is the tree's label", "graph.output", ADVICE)
        return label

    def is_given(self, value: Value) -> bool:
        """Returns True if a value is numbers that a regressor gives, whatever was done to them since. InputError for
        others than float32.
        """
        if not isinstance(value, Given):
            return False
        for kind in {column.kind for column in value.columns} - {FLOAT}:
            raise InputError(f"the tree's numbers are given as {kind}", "graph.output", "cast them to float32")
        return True

    def follow_node(self, node: Any) -> Sequence[Value]:
        """Follows a node, and returns its outputs."""
        attributes = {item.name: self.onnx.helper.get_attribute_value(item) for item in node.attribute}
        if _operator(node) == (MAIN, "Constant"):
            return [self.constant(node, attributes)]
        given = [self.values.get(name, UNKNOWN) if name else None for name in node.input]
        texts = [each for each in given if isinstance(each, str)]
        if node.op_type in OPERATOR_TREES:
            return self.follow_tree(node, attributes, given)
        if node.op_type == "Reshape" and _flattens(given):
            return [FLAT]
        if not texts and _operator(node) in OPERATORS and len(node.output) == 1:
            return [self.columns(node, attributes, given)]
        if len(given) != 1 or not texts:
            raise make_error(node, f"a node has {len(given)} inputs, one is understood")
        return [self.follow_label(node, attributes, texts[0])]

    def constant(self, node: Any, attributes: Mapping[str, Any]) -> Value:
        """The value of a node Constant."""
        ((name, value),) = attributes.items() if len(attributes) == 1 else [("", None)]
        if name == "value":
            return self.array(value, node.name)
        kinds = {"value_float": np.float32, "value_floats": np.float32, "value_int": np.int64, "value_ints": np.int64}
        if name not in kinds:
            raise make_error(node, "a constant is no array of numbers")
        return np.array(value, dtype=kinds[name])

    def columns(self, node: Any, attributes: Mapping[str, Any], given: Sequence[Any]) -> Columns | Given:
        """Applies an operator to columns, before the tree, or to a regressor's numbers, behind it."""
        behind = any(isinstance(each, Given) for each in given)
        if behind and any(isinstance(each, tuple) for each in given):
            raise make_error(node, "a node mixes the tree's numbers with the observation")
        if "to" in attributes:
            attributes = {**attributes, "to": _type(self.onnx, attributes["to"])}
        given = [each.columns if isinstance(each, Given) else each for each in given]
        columns = apply_operator(_operator(node), Call(describe_node(node), attributes, given))
        self.work += len(columns) * (1 + len(columns[0].steps))
        self.nan &= behind or all(column.nan for column in columns)  # a leaf's numbers are no NaN
        if self.work > MAX_WORK:
            raise make_error(node, "the operators before the tree are too many")
        return Given(columns) if behind else columns

    def follow_tree(self, node: Any, attributes: Mapping[str, Any], given: Sequence[Value | None]) -> Sequence[Value]:
        """The outputs of the tree."""
        value = given[0] if len(given) == 1 else UNKNOWN
        if not isinstance(value, tuple) and not (isinstance(value, str) and value == OBSERVATION):
            what = value if isinstance(value, str) else "a constant"
            raise make_error(node, f"a node works on {what}: {node.op_type!r}")
        if isinstance(value, tuple):
            for other in sorted({column.kind for column in value} - {FLOAT}):
                raise make_error(node, f"a node works on {other}: {node.op_type!r}", "cast it to float32")
            untouched = tuple(Column(place) for place in range(self.width))
            self.before = () if value == untouched else value
        if node.op_type == REGRESSOR:
            targets = int(attributes.get("n_targets", 1))
            return [Given(tuple(Column(place) for place in range(min(targets, MAX_TARGETS))))]
        if node.op_type == ENSEMBLE:
            return [NUMBER if self.whole else Given((Column(0),))]
        kinds = [words for name, words in LABELS.items() if name in attributes]
        return [*(kinds or [UNKNOWN]), SCORES]

    def follow_label(self, node: Any, attributes: Mapping[str, Any], origin: str) -> Value:
        """Follows the tree's label or scores through a node, and returns what becomes of them."""
        if origin == OBSERVATION and self.double:
            what = "operators work on float64 observations before the tree"
            raise make_error(node, what, "export it with a float32 input")
        if origin == OBSERVATION:
            what = "the model does not say how many features it takes, or takes too many"
            raise make_error(node, what, "give their names")
        if node.op_type == "Identity" or (node.op_type in ("ZipMap", "Cast") and origin == SCORES):
            return origin
        if node.op_type == "Cast" and origin == NUMBER and _type(self.onnx, attributes["to"]) == "INT64":
            return WHOLE
        if node.op_type == "Cast" and origin in LABELS.values():
            to = _type(self.onnx, attributes["to"])
            if origin.endswith(f", {to}"):
                return origin
            raise make_error(node, f"a Cast makes {to} of {origin}", "export the label as it is")
        raise make_error(node, f"a node works on {origin}: {node.op_type!r}")


def _flattens(given: Sequence[Any]) -> bool:
    """Returns True if a Reshape makes one axis of the tree's whole numbers."""
    if len(given) != len(("data", "shape")) or not isinstance(given[1], np.ndarray):
        return False
    return isinstance(given[0], str) and given[0] == WHOLE and given[1].tolist() == [-1]


def _words(value: Value) -> str:
    return value if isinstance(value, str) else "a constant" if isinstance(value, np.ndarray) else OBSERVATION
