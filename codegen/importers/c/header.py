"""The C header that this compiler writes, read back: the trees of all its agents.

Does: reads each `PREFIX_AGENT_act` in any of its styles, with the names of features and actions.
Assumes: what pycparser reads is what a compiler reads.
Does not: read any other C, agents that test sums or give numbers, run a compiler, or know the profile that the header
  was made from: a threshold or an action that somebody changed is read as it stands.

A tree is taken only if the function's syntax tree is then proved to be that tree (equivalence/structure.py). Names come
back in lower case, as the header has no others.
"""

# pyright: basic
# pycparser's nodes have no declared attributes
import ast
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from pycparser import CParser, c_ast, c_generator
from pycparser.c_parser import ParseError

from codegen.equivalence import structure
from codegen.errors import InputError, escape_text
from codegen.floats import FLOAT32, FLOAT64, WHOLE
from codegen.importers.nodes import Leaf, Split, origin_of
from codegen.importers.reading import Origin
from codegen.importers.symbolic.paths import Described, renumber
from codegen.lowering.deploy import deploy_tree

KIND, PROVED_BY = "our own C header", "a second reading of the file, and a proof of its structure"
PREFIX = re.compile(r'^#define (\w+)_PROFILE "[0-9a-f]{64}"$', re.MULTILINE)
MEMORY = re.compile(r"\w+_step\(\w+_state \*state")
SUMS = re.compile(r'^#error "sums are ', re.MULTILINE)  # in headers with agents that test sums or give numbers
ADVICE = "give a header that maviper compile wrote, as it is"


def from_header(content: bytes, where: str) -> dict[str, Origin]:
    """The trees of a header, by agent. InputError for everything that `maviper compile` does not write."""
    text = content.decode(errors="replace")
    prefix = PREFIX.search(text)
    if prefix is None:
        raise InputError("the header names no profile", where, ADVICE)
    if SUMS.search(text):
        what = "the header has agents that test sums or give numbers, which are not read back"
        raise InputError(what, where, "import what it was made from, or use the profile that its hash names")
    if MEMORY.search(text):
        raise InputError("the header has agents that remember, which are not read back", where, "import what it is of")
    for odd in structure.odd_lines(text)[:1]:
        raise InputError(f"a line is not ours: {escape_text(odd[:80])}", where, ADVICE)
    try:
        parsed = CParser().parse(structure.TYPES + structure.plain(text))
        numbers = structure.enumerators(parsed)
        enums = [node.type for node in parsed.ext if isinstance(getattr(node, "type", None), c_ast.Enum)]
        names = [[each.name for each in enum.values.enumerators] for enum in enums]
        functions = structure.functions_in(parsed)
        lists = [node for node in parsed.ext if isinstance(getattr(node, "init", None), c_ast.InitList)]
        tables = {node.name: node.init for node in lists}
        origins: dict[str, Origin] = {}
        for name in functions:
            agent = re.fullmatch(rf"{prefix[1].lower()}_(\w+)_act", name)
            if agent and f"{prefix[1]}_{agent[1].upper()}_N_ACTIONS" in numbers:
                function = structure.resolve_function(functions, name)  # agents with the same tree share its code
                origin = _agent(function, f"{prefix[1]}_{agent[1].upper()}", names, numbers, where)
                origin = _add_labels(origin, tables.get(f"{name[:-4]}_label"))
                origins[agent[1]] = _prove_origin(function, origin, numbers)
    except (ParseError, RecursionError, *structure.NOT_PROVED) as error:
        raise InputError(f"not a header of ours: {escape_text(error)[:100]}", where, ADVICE) from None
    if not origins:
        raise InputError("the header has no agent", where, ADVICE)
    return origins


def _label(item: Any) -> Any:
    """A label: a number or a text."""
    if getattr(item, "op", "") == "-":
        return -_label(item.expr)
    if item.type == "string":
        return ast.literal_eval(f"b{item.value}").decode()
    return float.fromhex(item.value) if item.value.startswith("0x") else int(item.value)


def _agent(
    function: c_ast.FuncDef, upper: str, names: Sequence[Sequence[str]], numbers: Mapping[str, int], where: str
) -> Origin:
    enums = [next(each for each in names if each[-1] == f"{upper}_N_{kind}") for kind in ("FEATURES", "ACTIONS")]
    features, actions = (each[:-1] for each in enums)
    if any(numbers[name] != place for each in enums for place, name in enumerate(each)):
        raise ValueError("an enumerator is not its place")
    parse = structure.parse_bits if structure.takes_bits(function) else structure.parse_test
    items = [item for item in function.body.block_items or [] if not structure.is_void(item)]
    tables = {structure.name_table(function, each.name): each.init.exprs for each in items if structure.is_table(each)}
    called = [each.removeprefix(f"{upper}_X_").lower() for each in features]
    labels = [each.removeprefix(f"{upper}_").lower() for each in actions]
    said = Described(kind=KIND, replayed_by=PROVED_BY, features=called, n_features=len(called))
    if tables:
        origin = origin_of(0, _Tables(tables, labels).read, said, where)
    else:
        origin = origin_of(items, partial(_read_nested, parse=parse, numbers=numbers, labels=labels), said, where)
    place, act = np.array([labels.index(each) for each in origin.labels]), origin.act
    assert act is not None
    origin = renumber(origin, range(len(origin.features)), place.tolist())
    return replace(origin, labels=tuple(labels), act=lambda rows: place[act(rows)])


def _add_labels(origin: Origin, table: c_ast.InitList | None) -> Origin:
    """The origin with the labels that a header has beside its actions' names."""
    if table is None:
        return origin
    labels = tuple(map(_label, table.exprs))
    if len({*labels}) != len(origin.labels) or len(labels) != len(origin.labels):
        raise ValueError("there is a label for each action, and one only")
    return replace(origin, labels=labels, called=dict(zip(labels, origin.labels, strict=True)))


def _prove_origin(function: c_ast.FuncDef, origin: Origin, numbers: Mapping[str, int]) -> Origin:
    """The origin, with what it compares; ValueError where the function is not its tree."""
    given = c_generator.CGenerator().visit(function.decl.type.args)
    compared = {"const float *x": FLOAT32, "const int *x": FLOAT32, "const double *x": FLOAT64}.get(given)
    whole = given.removeprefix("const ").removesuffix("_t *x")
    compared = WHOLE.get(whole, compared)
    if compared is None:
        raise ValueError("a function takes neither float *x nor double *x, nor whole numbers")
    tree = deploy_tree(origin.grown, compared)
    for fault in structure.act_faults(function, replace(tree, numbers=whole) if whole in WHOLE else tree, numbers):
        raise ValueError(fault)
    origin = replace(origin, numbers=compared, given=f"{whole if whole in WHOLE else compared}, as it declares")
    if whole not in WHOLE:
        return origin
    limits = np.iinfo(whole)
    return replace(origin, whole=((int(limits.min), int(limits.max)),) * len(origin.features))


def _read_nested(
    node: list[Any], parse: structure.Parser, numbers: Mapping[str, int], labels: Sequence[str]
) -> Split | Leaf:
    """A block of nested ifs: one statement."""
    (item,) = [each for each in node if not structure.is_void(each)]
    if isinstance(item, c_ast.Return):
        return Leaf(labels[structure.read_place(item.expr, numbers)])
    feature, threshold = parse(item.cond, numbers)
    then, otherwise = item.iftrue.block_items, item.iffalse.block_items
    return Split(feature, "<=", float(threshold), then, otherwise, nan=False)


class _Tables:
    """Tables that are walked: complete ones, whose leaves follow all splits, or with the places of children."""

    def __init__(self, tables: Mapping[str, Any], labels: Sequence[str]) -> None:
        self.labels = labels
        self.actions = [int(each.value) for each in tables["action"]]
        self.thresholds = [float(structure.number(each)) for each in tables.get("threshold", ())]
        self.features = [int(each.value) for each in tables.get("feature", ())]
        self.child = [int(each.value) for each in tables.get("child", ())]

    def read(self, at: int) -> Split | Leaf:
        """A split or leaf."""
        n = len(self.thresholds)
        if self.child and self.child[2 * at] == at:
            return Leaf(self.labels[self.actions[at]])
        if not self.child and at >= n:
            return Leaf(self.labels[self.actions[at - n]])
        pair = self.child[2 * at : 2 * at + 2] if self.child else (2 * at + 1, 2 * at + 2)
        return Split(self.features[at], "<=", self.thresholds[at], *pair, nan=False)
