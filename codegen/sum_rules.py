"""The rules that sums and outputs must keep, and the gate for whoever does not take them.

Does: yields every broken rule about arithmetic, sums, vectors and outputs, with its path in the JSON form; refuses
  profiles with sums, in one sentence, for those who read trees of single tests only.
Assumes: nodes that check.py has looked at: places of sums and vectors exist; a test goes through all targets and
  commands, so that none forgets to ask at the gate.
Does not: judge the tree around them.

Weights, constants and bounds that are subnormal are refused: a thread that takes them for zero would compute otherwise.
"""

import math
from collections.abc import Iterator, Sequence

import numpy as np

from codegen.errors import InputError
from codegen.floats import FLOAT32, FLOAT64
from codegen.ir import CONSTANT, NO_FEATURE, AgentPolicy, OutputSpec, PolicyProfile, Sum, Tree
from codegen.sums import ARITHMETICS, DOUBLE_SUMS, OBSERVED, choose_numbers

MAX_TERMS = 1_000  # of a sum
VERIFIER = "the verifier"  # who refuses sums
SUMMING = ("c", "python", "json", "javascript", "rust", "svg", "onnx", "onnx-old", "jax", "torch")  # who takes them
Found = Iterator[tuple[str, str]]  # path below the agent's, and what is wrong


def ensure_plain(profile: PolicyProfile, who: str) -> PolicyProfile:
    """The profile itself; InputError where an agent tests sums of features or gives numbers, which `who` does not take.

    `who`: such as "the target rust".
    """
    summing = [policy for policy in profile.agents if policy.tree.arithmetic]
    if summing:
        agents = ", ".join(policy.agent for policy in summing)
        where = "numbers as outputs" if any(policy.outputs for policy in summing) else "tests of sums"
        advice = f"`maviper show` and `maviper compile --target {','.join(SUMMING)}` take them"
        raise InputError(f"{who} does not take sums yet", f"{agents}: {where}", advice)
    return profile


def find_faults(policy: AgentPolicy) -> Found:
    """Every broken rule of an agent's sums and outputs."""
    tree = policy.tree
    if not (tree.sums or tree.vectors or policy.outputs):
        if tree.arithmetic:
            yield "arithmetic", "is for sums and outputs, and there are none"
        return
    if policy.actions and policy.outputs:
        yield "outputs", "an agent has actions or outputs, not both"
    if bool(policy.outputs) != bool(tree.vectors):
        yield "tree", "leaves give numbers where the agent has outputs, and actions elsewhere"
    if policy.grown is not None:
        yield "grown", "must be null: no learner's tree of single tests belongs to sums"
    if tree.arithmetic not in ARITHMETICS:
        yield "arithmetic", f"must be {', '.join(ARITHMETICS[:-1])} or {ARITHMETICS[-1]}"
        return
    if tree.numbers != OBSERVED[tree.arithmetic]:
        yield "numbers", f"must be {OBSERVED[tree.arithmetic]} where sums are {tree.arithmetic}"
    both = tree.arithmetic == DOUBLE_SUMS  # of which sums may be rounded once more
    kept = (FLOAT32, FLOAT64) if both else (choose_numbers(tree.arithmetic),)
    if tree.gives not in (kept if policy.outputs else (FLOAT32,)):
        yield "gives", f"must be {' or '.join(kept if policy.outputs else (FLOAT32,))} here"
    yield from _sums(policy)
    yield from _thresholds(policy)
    for index, output in enumerate(policy.outputs):
        for fault in _output(output, tree):
            yield f"outputs[{index}]", fault


def _sums(policy: AgentPolicy) -> Found:
    """Of all sums, in tests and in leaves, and of the order in which nodes name them."""
    tree, n = policy.tree, len(policy.features)
    yield from _order(tree.feature[tree.feature >= n] - n, tree.sums, "tree", "sum")
    leaves = tree.action[tree.feature == NO_FEATURE]
    if tree.vectors:
        yield from _order(leaves, tree.vectors, "tree", "vector")
    for node in np.flatnonzero(tree.feature >= n):
        each = tree.sums[int(tree.feature[node]) - n]
        for fault in _sum(each, tree.arithmetic, n):
            yield f"tree[{node}].sum", fault
        if [place for _, place in each.terms if place != CONSTANT] == [] or (
            len(each.terms) == 1 and each.terms[0][0] == 1
        ):
            yield f"tree[{node}].sum", "a test of a sum has a feature, and more than one feature alone"
    for node in np.flatnonzero(tree.feature == NO_FEATURE) if tree.vectors else ():
        vector = tree.vectors[int(tree.action[node])]
        if len(vector) != len(policy.outputs):
            yield f"tree[{node}].outputs", f"has {len(vector)} sums for {len(policy.outputs)} outputs"
        for index, each in enumerate(vector):
            for fault in _sum(each, tree.arithmetic, n):
                yield f"tree[{node}].outputs[{index}]", fault


def _order(named: np.ndarray, known: Sequence[object], path: str, kind: str) -> Found:
    first = list(dict.fromkeys(named.tolist()))
    if first != list(range(len(known))) or len({repr(each) for each in known}) < len(known):
        yield path, f"each {kind} stands once, in the order in which nodes first name it"


def _sum(each: Sum, arithmetic: str, n_features: int) -> Iterator[str]:
    places = [place for _, place in each.terms]
    if not 1 <= len(places) <= MAX_TERMS:
        yield f"a sum has 1 to {MAX_TERMS} terms"
    if any(not CONSTANT <= place < n_features for place in places):
        yield f"features are 0 to {n_features - 1}"
    if len({*places}) < len(places):
        yield "a feature, or the constant, stands twice"
    for weight, place in each.terms:
        what = "a constant" if place == CONSTANT else "a weight"
        numbers = choose_numbers(arithmetic) if place == CONSTANT else OBSERVED[arithmetic]
        if weight == 0 and place != CONSTANT:
            yield "a weight is 0: leave its term out"
        elif (fault := _number(weight, numbers)) is not None:
            yield f"{what} {fault}"


def _number(value: float, numbers: str) -> str | None:
    """Returns what is wrong with a weight, constant or bound, or None."""
    if not math.isfinite(value):
        return f"must be finite, not {value}"
    with np.errstate(over="ignore", under="ignore"):
        held = float(np.dtype(numbers).type(value))
    if held != value:
        return f"is no {numbers}: {value!r}"
    if value != 0 and abs(value) < float(np.finfo(numbers).tiny):
        return f"is subnormal: {value!r}"
    return None


def _thresholds(policy: AgentPolicy) -> Found:
    """A test of a single feature compares with one of its own numbers."""
    tree = policy.tree
    if tree.numbers == FLOAT32 and tree.compared == FLOAT64:
        single = (tree.feature != NO_FEATURE) & (tree.feature < len(policy.features))
        with np.errstate(over="ignore"):
            rounded = tree.threshold.astype(np.float32) != tree.threshold
        for node in np.flatnonzero(single & rounded):
            yield f"tree[{node}].threshold", "is no float32, which the feature is"


def _output(output: OutputSpec, tree: Tree) -> Iterator[str]:
    for bound in (output.low, output.high):
        if bound is None:
            if tree.gives != choose_numbers(tree.arithmetic):
                yield f"needs both bounds: it is rounded from {choose_numbers(tree.arithmetic)} to {tree.gives}"
        elif (fault := _number(bound, tree.gives)) is not None:
            yield f"a bound {fault}"
    if output.low is not None and output.high is not None and not output.low <= output.high:
        yield f"needs low <= high, has [{output.low}, {output.high}]"
