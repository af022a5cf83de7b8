"""Contracts in ACSL: what the C of a profile must return, for Frama-C to prove beside the header as it is.

Does: writes PREFIX_contracts.c: for each leaf, the tests on its path and its action, from the profile's trees; where
  code does not say `<= threshold`, the axioms that it needs, and PREFIX_axioms.smt2, which asks a solver for each.
Assumes: a checked profile, and a model of it, from which only names and the style are taken.
Does not: run anything (maviper/compilation/proofs.py), or look at the lowered trees.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from codegen import ir
from codegen.deciding import ensure_floats, ensure_plain
from codegen.errors import InputError
from codegen.floats import below_zero, short_hex
from codegen.lowering.lower import NESTED, ORDERED
from codegen.lowering.model import Model
from codegen.lowering.render import render

KINDS = {"float32": "float", "float64": "double"}  # the type of C, and the end of ACSL's predicates
FORMATS = {32: "8 24", 64: "11 53"}  # of SMT-LIB
SIGN = 1 << 31
# WP reads no long double of 80 bits, which other functions of the header have: in this machine's types it is a double
OPTIONS = (
    *("-wp", "-wp-rte", "-wp-prover", "z3", "-wp-model", "Typed+Float", "-wp-no-pruning"),
    *("-warn-special-float", "none", "-machdep", "msvc_x86_64"),
    *("-wp-status-all", "-wp-status-invalid"),  # else what RTE refutes by itself, such as 0 / 0, is no goal at all
)


@dataclass(frozen=True)
class Leaf:
    """A line of the table: observations that pass all `tests` get `action`."""

    id: int
    tests: tuple[str, ...]
    action: int


@dataclass(frozen=True)
class Contract:
    """The promises of a function."""

    name: str
    kind: str  # of an observation's numbers: float or double
    n_features: int
    tested: tuple[int, ...]  # features; what is said of others costs a prover its time
    leaves: tuple[Leaf, ...]

    @property
    def last(self) -> int:
        """The place of the last number; -1 where there is none."""
        return self.n_features - 1


@dataclass(frozen=True)
class Axiom:
    """A fact of IEEE 754 that a proof uses: two ways to ask of x whether it is at most some number."""

    name: str
    kind: str  # of x: float or double
    compared: str  # in ACSL, as are the next two
    at_most: str
    given: str  # what holds of x; "": nothing
    width: int  # bits of x
    smt: tuple[str, str]  # `compared` and `at_most` in SMT-LIB, of x with the bits b


@dataclass(frozen=True)
class Contracts:
    """The files, and what is asked of the tools: `functions` have contracts, `axioms` are questions for a solver."""

    files: dict[str, str]
    source: str  # which of the files Frama-C reads
    questions: str  # which of them a solver reads; "": none
    functions: tuple[str, ...]
    leaves: int
    axioms: int
    command: tuple[str, ...]


def contracts_of(profile: ir.PolicyProfile, model: Model) -> Contracts:
    """The contracts of every agent's `..._act`. InputError for other styles than two, whose loops or bits have no
    axioms, and for sums, whose rounding WP's floats leave open.
    """
    ensure_floats(ensure_plain(profile, "a contract in ACSL"), "a contract in ACSL")
    if model.style not in (NESTED, ORDERED):
        what = f"contracts are for the styles {NESTED} and {ORDERED}, not for {model.style}"
        raise InputError(what, "contracts", f"use --style {NESTED}, or leave it out")
    functions = [
        Contract(
            agent.names.act,
            KINDS[policy.numbers],
            len(policy.features),
            tuple(np.unique(policy.tree.feature[policy.tree.feature != ir.NO_FEATURE]).tolist()),
            table_of(policy.tree),
        )
        for policy, agent in zip(profile.agents, model.agents, strict=True)
    ]
    ordered = model.style == ORDERED
    axioms = _bits_axioms(profile, model.names.bits) if ordered else _below_zero(profile)
    source, questions = f"{model.prefix}_contracts.c", f"{model.prefix}_axioms.smt2" if axioms else ""
    names = tuple(each.name for each in functions)
    command = frama_c(source, names)
    values = {"model": model, "ordered": ordered, "axioms": axioms, "functions": functions}
    files = {source: render("c/contracts.c.j2", command=" ".join(command), **values)}
    if questions:
        files[questions] = render("smt/axioms.smt2.j2", model=model, axioms=axioms, formats=FORMATS)
    leaves = sum(len(each.leaves) for each in functions)
    return Contracts(files, source, questions, names, leaves, len(axioms), command)


def frama_c(source: str, functions: Iterable[str]) -> tuple[str, ...]:
    """The command that proves the contracts of a file. Floats are IEEE 754's, with NaN and infinities."""
    return ("frama-c", *OPTIONS, "-wp-fct", ",".join(functions), source)


def table_of(tree: ir.Tree) -> tuple[Leaf, ...]:
    """The leaves from left to right, each with the tests on its path, from the tree's arrays."""
    leaves: list[Leaf] = []
    waiting: list[tuple[int, tuple[str, ...]]] = [(ir.ROOT, ())]
    while waiting:
        node, tests = waiting.pop()
        if tree.feature[node] == ir.NO_FEATURE:
            leaves.append(Leaf(node, tests, int(tree.action[node])))
            continue
        kind, threshold = KINDS[tree.numbers], short_hex(float(tree.threshold[node]))
        passed = f"\\le_{kind}(x[{tree.feature[node]}], ({kind}){threshold})"
        waiting.append((int(tree.right[node]), (*tests, f"!{passed}")))
        waiting.append((int(tree.left[node]), (*tests, passed)))
    return tuple(leaves)


def _thresholds(trees: Sequence[ir.Tree]) -> list[np.float32]:
    """Every threshold once, in the order of the trees; the two zeros are two."""
    numbers = (number for tree in trees for number in tree.threshold[tree.feature != ir.NO_FEATURE])
    return list({number.tobytes(): number for number in numbers}.values())


def _bits_axioms(profile: ir.PolicyProfile, bits: str) -> list[Axiom]:
    """For each threshold, which bits the numbers have that are at most it."""
    axioms: list[Axiom] = []
    for threshold in _thresholds([policy.tree for policy in profile.agents]):
        number = int(threshold.view(np.uint32))
        digits = f"{number:08x}"
        compared = f"(uint32_t){bits}_of(x) >= 0x{digits}" if number >= SIGN else f"{bits}_of(x) <= 0x{digits}"
        smt = (f"({'bvuge' if number >= SIGN else 'bvsle'} b #x{digits})", _smt_at_most(number, 32))
        given = "!\\is_NaN(x)"
        axioms.append(Axiom(f"at_most_{digits}", "float", compared, _at_most("float", threshold), given, 32, smt))
    return axioms


def _below_zero(profile: ir.PolicyProfile) -> list[Axiom]:
    """For each kind of agent that asks x < 0, that it is to be at most the last number below: nested code says `<`."""
    axioms: list[Axiom] = []
    for numbers, kind in KINDS.items():
        last = np.dtype(numbers).type(below_zero(numbers))
        trees = [policy.tree for policy in profile.agents if policy.numbers == numbers]
        if not any(last in tree.threshold[tree.feature != ir.NO_FEATURE] for tree in trees):
            continue
        width = 8 * last.itemsize
        number = int(last.view(f"u{last.itemsize}"))
        smt = (f"(fp.lt x (_ +zero {FORMATS[width]}))", _smt_at_most(number, width))
        asked = f"\\lt_{kind}(x, ({kind})0.0)"
        axioms.append(Axiom(f"{kind}_below_zero", kind, asked, _at_most(kind, last), "", width, smt))
    return axioms


def _at_most(kind: str, threshold: np.floating) -> str:
    return f"\\le_{kind}(x, ({kind}){short_hex(float(threshold))})"


def _smt_at_most(number: int, width: int) -> str:
    return f"(fp.leq x ((_ to_fp {FORMATS[width]}) #x{number:0{width // 4}x}))"
