"""Contracts in ACSL: what the C of a profile must return, for Frama-C to prove beside the header as it is.

Does: writes PREFIX_contracts.c: for each leaf, the tests on its path and its action, from the profile's trees, and what
  becomes of what is remembered; where code does not say `<= threshold`, or says it of a whole number that it made a
  float, what a proof needs of floats, and PREFIX_axioms.smt2, which asks a solver for each. Of agents that test sums or
  give numbers only what WP's floats can show: which actions there are, each with the tests of single features and of
  memory on its paths, and the bounds of what is given.
Assumes: a checked profile, and a model of it, from which only names and the style are taken.
Does not: run anything (maviper/compilation/proofs.py), or look at the lowered trees.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from math import floor

import numpy as np

from codegen import ir
from codegen.deciding import sums_in
from codegen.errors import InputError
from codegen.floats import below_zero, short_hex
from codegen.lowering.lower import NESTED, ORDERED
from codegen.lowering.model import Agent, Machine, Model
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
    """A line of the table: observations that pass all `tests` get `action`, and memory becomes what `after` says."""

    id: int
    tests: tuple[str, ...]
    action: int
    after: tuple[str, ...] = ()


@dataclass(frozen=True)
class Contract:
    """The promises of a function."""

    name: str
    kind: str  # of an observation's numbers: float or double
    n_features: int
    tested: tuple[int, ...]  # features; what is said of others costs a prover its time
    leaves: tuple[Leaf, ...]
    actions: tuple[int, ...] = ()  # of an agent that tests sums, in place of leaves
    only: tuple[tuple[int, tuple[str, ...]], ...] = ()  # actions with the tests of single features on paths to them
    given: str = ""  # the type of the numbers that it gives
    ends: tuple[str, ...] = ()  # for each of these what holds of it, in ACSL; "": nothing

    @property
    def last(self) -> int:
        """The place of the last number; -1 where there is none."""
        return self.n_features - 1

    @property
    def last_given(self) -> int:
        """The place of the last number that it gives."""
        return len(self.ends) - 1


@dataclass(frozen=True)
class Clip:
    """The promises of the functions of the header that clip numbers of a type. `highs`: bounds that they are given."""

    kind: str
    least: str
    most: str
    highs: tuple[str, ...]


@dataclass(frozen=True)
class Remembering:
    """The promises of the functions that reset a state and take a step; `facts`: what floats of whole numbers are."""

    init: str
    step: str
    state: str  # the type
    kind: str
    machine: Machine
    numbers: tuple[int, ...]  # which features must not be NaN, of those that are observed
    facts: tuple[str, ...]
    leaves: tuple[Leaf, ...]
    # of an agent that tests sums, in place of leaves: what is taken, and the tests with the updates that lead to it
    ways: tuple[tuple[int, tuple[str, ...]], ...] = ()

    @property
    def last(self) -> int:
        """The place of the last number that is observed."""
        return self.machine.observed - 1


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
    ends: tuple[int, int] | None = None  # between which b is a whole number, of which x is made; None: it is x's bits


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
    """The contracts of every agent's `..._act`, and of the functions of its memory. InputError for other styles than
    two, whose loops or bits have no axioms.
    """
    if model.style not in (NESTED, ORDERED):
        what = f"contracts are for the styles {NESTED} and {ORDERED}, not for {model.style}"
        raise InputError(what, "contracts", f"use --style {NESTED}, or leave it out")
    functions = list(map(_promise, profile.agents, model.agents))
    clips = _clips(profile, model)
    ordered = model.style == ORDERED
    summing = sums_in(profile)  # whose code is the same in both styles
    axioms = _below_zero(summing if ordered else profile.agents)
    axioms += _bits_axioms(profile, model.names.bits) if ordered else []
    pairs = [pair for pair in zip(profile.agents, model.agents, strict=True) if pair[0].memory]
    facts = {agent.name: _remembered_floats(policy, agent, ordered) for policy, agent in pairs}
    numbers = {each.name: each.tested if ordered else () for each in functions}
    machines = [_remembering(*pair, numbers[pair[1].names.act], facts[pair[1].name]) for pair in pairs]
    asked = [*axioms, *(fact for some in facts.values() for fact in some)]
    source, questions = f"{model.prefix}_contracts.c", f"{model.prefix}_axioms.smt2" if asked else ""
    names = (
        *(each.name for each in functions),
        *(name for each in machines for name in (each.init, each.step)),
        *(name for each in clips for name in (each.least, each.most)),
    )
    command = frama_c(source, names, max((each.machine.observed + 1 for each in machines), default=0))
    values = {"model": model, "ordered": ordered, "axioms": axioms, "functions": functions, "machines": machines}
    values |= {"clips": clips, "summed": summing}
    files = {source: render("c/contracts.c.j2", command=" ".join(command), **values)}
    if questions:
        values = {"model": model, "axioms": asked, "formats": FORMATS, "whole": _smt_whole}
        files[questions] = render("smt/axioms.smt2.j2", **values)
    leaves = sum(len(each.leaves) for each in functions)
    return Contracts(files, source, questions, names, leaves, len(asked), command)


def frama_c(source: str, functions: Iterable[str], turns: int = 0) -> tuple[str, ...]:
    """The command that proves the contracts of a file. Floats are IEEE 754's, with NaN and infinities. `turns`: of the
    loops that it unrolls.
    """
    unrolled = ("-ulevel", str(turns)) if turns else ()
    return ("frama-c", *OPTIONS, *unrolled, "-wp-fct", ",".join(functions), source)


def _promise(policy: ir.AgentPolicy, agent: Agent) -> Contract:
    """The promises of an agent's `..._act`."""
    tree, named = policy.tree, (agent.names.act, _kind_of(policy), len(policy.features))
    if agent.summed is None:
        return Contract(
            *named, tuple(np.unique(tree.feature[tree.feature != ir.NO_FEATURE]).tolist()), table_of(policy)
        )
    if not policy.outputs:
        paths: dict[int, dict[str, None]] = {}
        for leaf in table_of(policy):
            paths.setdefault(leaf.action, {})[" && ".join(leaf.tests)] = None
        only = tuple((action, tuple(tests)) for action, tests in sorted(paths.items()) if "" not in tests)
        return Contract(*named, (), (), tuple(sorted(paths)), only)
    kind, ends = agent.summed.kind, list[str]()
    for place, each in enumerate(policy.outputs):
        low = "" if each.low is None else f"\\le_{kind}(({kind}){short_hex(each.low)}, y[{place}])"
        high = "" if each.high is None else f"\\le_{kind}(y[{place}], ({kind}){short_hex(each.high)})"
        told = " && ".join(filter(None, (low, high)))
        ends.append(f"\\is_NaN(y[{place}]) || ({told})" if told and not _narrows(agent) else "")
    return Contract(*named, (), (), given=kind, ends=tuple(ends))


def _narrows(agent: Agent) -> bool:
    """Returns True if what an agent gives is rounded after it was clipped: WP does not know that this keeps bounds."""
    return agent.summed is not None and agent.summed.doubled and agent.summed.gives_single


def _clips(profile: ir.PolicyProfile, model: Model) -> list[Clip]:
    """The promises of the functions that clip what agents give, of each type that they are used with."""
    clips: list[Clip] = []
    names = {
        "double": (model.names.at_least, model.names.at_most),
        "float": (model.names.single_at_least, model.names.single_at_most),
    }
    for kind, (least, most) in names.items():
        giving = [
            policy
            for policy, agent in zip(profile.agents, model.agents, strict=True)
            if policy.outputs and agent.summed is not None and agent.summed.stepwise == (kind == "float")
        ]
        highs = {each.high for policy in giving for each in policy.outputs if each.high is not None}
        clips += [Clip(kind, least, most, tuple(map(short_hex, sorted(highs))))] if giving else []
    return clips


def _kind_of(policy: ir.AgentPolicy) -> str:
    """The type of what it observes in C."""
    return f"{policy.whole}_t" if policy.whole else KINDS[policy.numbers]


def _is_at_most(place: int, kind: str, threshold: float, left: bool) -> str:
    """The test of a feature in ACSL, and how it ends."""
    if kind not in KINDS.values():
        return f"x[{place}] {'<=' if left else '>'} {floor(threshold)}"
    return f"{'' if left else '!'}\\le_{kind}(x[{place}], ({kind}){short_hex(threshold)})"


def table_of(policy: ir.AgentPolicy, ask: Callable[[int, str, float, bool], str] = _is_at_most) -> tuple[Leaf, ...]:
    """The leaves from left to right, each with the tests on its path, from the tree's arrays; but for those of sums."""
    tree, kind, leaves = policy.tree, _kind_of(policy), list[Leaf]()
    waiting: list[tuple[int, tuple[str, ...]]] = [(ir.ROOT, ())]
    while waiting:
        node, tests = waiting.pop()
        if tree.feature[node] == ir.NO_FEATURE:
            leaves.append(Leaf(node, tests, int(tree.action[node])))
            continue
        asked = int(tree.feature[node]), kind, float(tree.threshold[node])
        for child, left in ((tree.right, False), (tree.left, True)):
            more = (ask(*asked, left),) if asked[0] < len(policy.features) else ()
            waiting.append((int(child[node]), (*tests, *more)))
    return tuple(leaves)


def _remembering(policy: ir.AgentPolicy, agent: Agent, numbers: Iterable[int], facts: Iterable[Axiom]) -> Remembering:
    """The promises of the functions of an agent's memory: what is remembered is asked as a whole number."""
    assert agent.machine is not None
    names = [each.name for each in agent.machine.memory]
    known = {each.name: name for each, name in zip(policy.memory, names, strict=True)}

    def ask(place: int, kind: str, threshold: float, left: bool) -> str:
        if place < len(policy.features) - len(names):
            return _is_at_most(place, kind, threshold, left)
        name = known[policy.features[place].name]
        return f"state->{name} {'<=' if left else '>'} {floor(threshold)}"

    def find_after(action: int) -> tuple[str, ...]:
        changed = {known[each.memory]: each for each in policy.actions[action].updates}
        return tuple(_say_after(name, changed.get(name)) for name in names)

    named = agent.names
    observed = tuple(each for each in numbers if each < agent.machine.observed)
    about = (named.init, named.step, named.state, _kind_of(policy), agent.machine, observed)
    leaves = tuple(
        Leaf(leaf.id, leaf.tests, policy.taken[leaf.action], find_after(leaf.action)) for leaf in table_of(policy, ask)
    )
    told = tuple(f"{fact.compared} <==> {fact.at_most}" for fact in facts)
    if agent.summed is None:
        return Remembering(*about, told, leaves)
    # a goal for each action that is taken: where one has to tell them apart, Z3 is lost among floats
    ways: dict[int, dict[str, None]] = {}
    for leaf in leaves:
        tests = (f"\\old({' && '.join(leaf.tests)})",) if leaf.tests else ()
        ways.setdefault(leaf.action, {})[" && ".join((*tests, *leaf.after))] = None
    return Remembering(*about, told, (), tuple((action, tuple(each)) for action, each in sorted(ways.items())))


def _say_after(name: str, update: ir.Update | None) -> str:
    """What a memory is after a step, in ACSL."""
    if update is not None and not update.adds:
        return f"state->{name} == {update.value}"
    return f"state->{name} == \\old(state->{name})" + ("" if update is None else f" + {update.value}")


def _remembered_floats(policy: ir.AgentPolicy, agent: Agent, ordered: bool) -> list[Axiom]:
    """For each memory of an agent that compares floats, and each number that it is compared with, that it is at most
    this as a float where it is as a whole number; of one that compares bits also the memory's end, for what is at most
    any number is not NaN.
    """
    assert agent.machine is not None
    if policy.whole:
        return []
    ordered &= agent.summed is None
    kind, width, facts = KINDS[policy.numbers], np.dtype(policy.numbers).itemsize * 8, list[Axiom]()
    first, tested = len(policy.features) - len(policy.memory), policy.tree.feature
    for place, each in enumerate(agent.machine.memory, first):
        numbers = policy.tree.threshold[tested == place].astype(policy.numbers)
        ends = np.array([each.high] if ordered and numbers.size else [], numbers.dtype)
        for threshold in np.unique(np.append(numbers, ends)):
            number = int(threshold.view(f"u{threshold.itemsize}"))
            compared = f"state->{each.name} <= {floor(threshold)}"
            at_most = _at_most(kind, threshold).replace("(x,", f"(({kind})state->{each.name},")
            smt = (f"(bvsle b {_smt_whole(floor(threshold))})", _smt_at_most(number, width))
            name = f"{agent.lower}_{each.name}_at_most_{number:0{width // 4}x}"
            facts.append(Axiom(name, kind, compared, at_most, "", width, smt, (each.low, each.high)))
    return facts


def _smt_whole(number: int) -> str:
    """A whole number of 32 bits in SMT-LIB."""
    return f"#x{number % (1 << 32):08x}"


def _bits_axioms(profile: ir.PolicyProfile, bits: str) -> list[Axiom]:
    """For each threshold, which bits the numbers have that are at most it."""
    axioms: list[Axiom] = []
    trees = [policy.tree for policy in profile.agents if not policy.tree.arithmetic]
    thresholds = (each for tree in trees for each in tree.threshold[tree.feature != ir.NO_FEATURE])
    for threshold in {each.tobytes(): each for each in thresholds}.values():  # each once; the two zeros are two
        number = int(threshold.view(np.uint32))
        digits = f"{number:08x}"
        compared = f"(uint32_t){bits}_of(x) >= 0x{digits}" if number >= SIGN else f"{bits}_of(x) <= 0x{digits}"
        smt = (f"({'bvuge' if number >= SIGN else 'bvsle'} b #x{digits})", _smt_at_most(number, 32))
        given = "!\\is_NaN(x)"
        axioms.append(Axiom(f"at_most_{digits}", "float", compared, _at_most("float", threshold), given, 32, smt))
    return axioms


def _below_zero(policies: Iterable[ir.AgentPolicy]) -> list[Axiom]:
    """For each kind of agent that asks x < 0, that it is to be at most the last number below: nested code says `<`."""
    axioms: list[Axiom] = []
    for numbers, kind in KINDS.items():
        last = np.dtype(numbers).type(below_zero(numbers))
        trees = [policy.tree for policy in policies if policy.numbers == numbers and not policy.whole]
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
