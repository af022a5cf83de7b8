"""How far apart what two agents give can be, or where their actions differ, cell by cell of both trees.

Does: cuts the ranges of features into cells in which both trees reach one leaf; bounds the differences there by linear
  programs, and replays what is largest; reports it.
Assumes: agents that test sums or give numbers, and observe and do the same.
Does not: prove more than linear programs do: what they find is replayed by the reference, and the rest is said so.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import linprog

from codegen import ir
from codegen.errors import InputError, UnknownNameError
from codegen.floats import FLOAT32
from codegen.form import layout
from codegen.ir import Float64
from codegen.numbers import neighbour
from codegen.policy_json import content_hash, dumps
from codegen.profiles import ensure
from codegen.rows import Shown
from codegen.sums import CONSTANT, FLOAT64_SUMS
from codegen.wording import format_count
from maviper.files import runs
from maviper.verification.files.certificates import AGAINST_FILE
from verify.result import Verdict

SLACK = 1e-6  # relative, of what rounding of a sum may change


@dataclass(frozen=True)
class Plane:
    """A half space `weights @ x <= limit`."""

    weights: Float64  # [n_features]
    limit: float
    test: tuple[ir.Sum, str, float, bool] | None = None  # what was tested: sum, arithmetic, threshold, whether it held

    def settles(self, each: ir.Sum, arithmetic: str, threshold: float) -> bool | None:
        """Returns True if another test of the sum holds here, rounding included, else False; None if that is open."""
        if self.test is None or self.test[:2] != (each, arithmetic):
            return None
        _, _, limit, held = self.test
        return held if (limit <= threshold if held else threshold <= limit) else None


@dataclass(frozen=True)
class Cell:
    """A leaf of each tree, and the observations that both send there: a box, and half spaces of tested sums."""

    first: int
    second: int
    low: Float64  # [n_features]
    high: Float64
    planes: tuple[Plane, ...]


def affine(each: ir.Sum, n_features: int) -> tuple[Float64, float]:
    """The weights [n_features] and the constant of a sum."""
    weights, constant = np.zeros(n_features), 0.0
    for place, weight in each.expand().items():
        if place == CONSTANT:
            constant += float(weight)
        else:
            weights[place] += float(weight)
    return weights, constant


def extremes(weights: Float64, constant: float, low: Float64, high: Float64) -> tuple[float, float]:
    """The least and most that weighted features may be in a box."""
    ends = np.sort(np.stack([weights * low, weights * high]), axis=0)
    return float(constant + ends[0].sum()), float(constant + ends[1].sum())


def cells(first: ir.AgentPolicy, second: ir.AgentPolicy, low: Float64, high: Float64) -> Iterator[Cell]:
    """Every pair of leaves that boxes do not part. `low`, `high`: the ranges, [n_features] each."""
    stack = [Cell(ir.ROOT, ir.ROOT, low, high, ())]
    while stack:
        cell = stack.pop()
        policy, node = (first, cell.first) if _splits(first, cell.first) else (second, cell.second)
        if not _splits(policy, node):
            yield cell
            continue
        for side in (False, True):
            child = int(policy.tree.left[node] if side else policy.tree.right[node])
            part = _part(policy, node, cell, left=side)
            if part is not None:
                places = (child, cell.second) if policy is first and node == cell.first else (cell.first, child)
                stack.append(Cell(*places, part.low, part.high, part.planes))


def _splits(policy: ir.AgentPolicy, node: int) -> bool:
    return int(policy.tree.feature[node]) != ir.NO_FEATURE


def _part(policy: ir.AgentPolicy, node: int, cell: Cell, *, left: bool) -> Cell | None:
    """The part of a cell on one side of a test; None where the box has none."""
    tree, n = policy.tree, len(policy.features)
    place, limit = int(tree.feature[node]), float(tree.threshold[node])
    if place < n:
        low, high = cell.low.copy(), cell.high.copy()
        if left:
            high[place] = min(high[place], limit)
        else:
            low[place] = max(low[place], float(neighbour(limit, np.inf, policy.numbers)))
        return None if low[place] > high[place] else Cell(cell.first, cell.second, low, high, cell.planes)
    each = tree.sums[place - n]
    for plane in cell.planes:
        settled = plane.settles(each, tree.arithmetic, limit)
        if settled is not None:
            return cell if settled == left else None
    weights, constant = affine(each, n)
    least, most = extremes(weights, constant, cell.low, cell.high)
    doubt = SLACK * (abs(least) + abs(most) + abs(limit)) if tree.arithmetic != FLOAT64_SUMS else 0.0
    if (least - doubt > limit) if left else (most + doubt <= limit):
        return None
    if (most + doubt <= limit) if left else (least - doubt > limit):
        return cell
    test = (each, tree.arithmetic, limit, left)
    plane = Plane(weights, limit - constant, test) if left else Plane(-weights, constant - limit, test)
    return Cell(cell.first, cell.second, cell.low, cell.high, (*cell.planes, plane))


def ranges(policy: ir.AgentPolicy) -> tuple[Float64, Float64]:
    """The least and most of each feature, [n_features] each."""
    ends = np.array([(feature.low, feature.high) for feature in policy.features], np.float64)
    return ends[:, 0], ends[:, 1]


def clip_rows(rows: Float64, low: Float64, high: Float64, numbers: str) -> ir.Floats:
    """Observations [n, n_features] in the agent's numbers, within the ranges."""
    rounded = rows.astype(numbers)
    if numbers == FLOAT32:  # rounding may leave a range by one number
        rounded = np.where(rounded > high, neighbour(rounded, -np.inf), rounded)
        rounded = np.where(rounded < low, neighbour(rounded, np.inf), rounded)
    return rounded


NUDGES = (0.0, 1e-7, 1e-4, 1e-2)  # from an extreme towards the middle of its cell: rounding may lie beyond a tie


@dataclass(frozen=True)
class Found:
    """Two agents beside one another at one observation."""

    difference: float  # of an output, replayed; 1 for other actions
    seen: tuple[float, ...]  # the observation, in the agent's numbers
    leaves: tuple[int, int]


@dataclass
class Apart:
    """The difference of one output. `most`: the bound by linear programs, None where the cells were too many."""

    output: str
    unit: str
    found: Found | None = None  # None: no difference was met
    most: float | None = 0.0

    @property
    def reached(self) -> float:
        """The largest difference so far."""
        return 0.0 if self.found is None else self.found.difference


@dataclass(frozen=True)
class Searched:
    """The outcome of a search: by output, or one entry for actions; whether every pair of leaves was looked at, and
    whether boxes alone decided, so that a difference of 0 is exact.
    """

    apart: tuple[Apart, ...]
    cells: int
    complete: bool
    exact: bool


def search(first: ir.AgentPolicy, second: ir.AgentPolicy, low: Float64, high: Float64, max_cells: int) -> Searched:
    """The largest differences of two agents over ranges of their features, [n_features] each."""
    apart = [Apart(output.name, output.unit) for output in first.outputs] or [Apart("action", "")]
    looked, complete, exact = 0, True, True
    for cell in cells(first, second, low, high):
        if looked == max_cells:
            complete = False
            break
        looked += 1
        exact &= not cell.planes
        if first.outputs:
            exact &= _outputs(first, second, cell, apart)
        elif int(first.tree.action[cell.first]) != int(second.tree.action[cell.second]):
            for point in _points(cell, np.zeros(len(low))):
                _replay(first, second, cell, point, apart)
                apart[0].most = 1.0
    for each in apart:
        each.most = max(each.most or 0.0, each.reached) if complete else None
    return Searched(tuple(apart), looked, complete, exact)


def _outputs(first: ir.AgentPolicy, second: ir.AgentPolicy, cell: Cell, apart: list[Apart]) -> bool:
    """Looks at every output in a cell; whether both leaves give numbers only, so that no program rounds."""
    leaves = (first, cell.first), (second, cell.second)
    vectors = [policy.tree.vectors[int(policy.tree.action[leaf])] for policy, leaf in leaves]
    constant = True
    for place, specs in enumerate(zip(first.outputs, second.outputs, strict=True)):
        given = [affine(vector[place], len(first.features)) for vector in vectors]
        constant &= not any(weights.any() for weights, _ in given)
        bounds = [_bounds(spec) for spec in specs]
        if vectors[0][place] == vectors[1][place] and bounds[0] == bounds[1]:
            continue
        ends = [np.clip(extremes(*each, cell.low, cell.high), *most) for each, most in zip(given, bounds, strict=True)]
        if max(ends[0][1] - ends[1][0], ends[1][1] - ends[0][0]) <= apart[place].reached:
            continue
        pieces = product(*(_pieces(*each, *most, cell) for each, most in zip(given, bounds, strict=True)))
        for sign, (one, two) in product((1, -1), pieces):  # the extreme of sign * (one - two) in a piece of the cell
            part = Cell(cell.first, cell.second, cell.low, cell.high, (*cell.planes, *one.planes, *two.planes))
            weights, offset = sign * (one.weights - two.weights), sign * (one.constant - two.constant)
            for point in _points(part, weights):
                apart[place].most = max(apart[place].most or 0.0, float(weights @ point + offset))
                _replay(first, second, part, point, apart)
    return constant


def _bounds(spec: ir.OutputSpec) -> tuple[float, float]:
    return -np.inf if spec.low is None else spec.low, np.inf if spec.high is None else spec.high


class _Piece(NamedTuple):
    """Where a sum is cut to a bound, or is within both: what is given there, and its half spaces."""

    weights: Float64
    constant: float
    planes: tuple[Plane, ...]


def _pieces(weights: Float64, constant: float, low: float, high: float, cell: Cell) -> Iterator[_Piece]:
    least, most = extremes(weights, constant, cell.low, cell.high)
    none = np.zeros_like(weights)
    if most > high:
        yield _Piece(none, high, (Plane(-weights, constant - high),) if least < high else ())
    if least < low:
        yield _Piece(none, low, (Plane(weights, low - constant),) if most > low else ())
    if most >= low and least <= high:
        within = [Plane(weights, high - constant)] if most > high else []
        within += [Plane(-weights, constant - low)] if least < low else []
        yield _Piece(weights, constant, tuple(within))


def _points(cell: Cell, weights: Float64) -> Iterator[Float64]:
    """An observation of a cell at which weighted features are largest; none where the cell is empty."""
    if not cell.planes:
        yield np.where(weights > 0, cell.high, np.where(weights < 0, cell.low, _inner(cell)))
        return
    rows, limits = np.array([plane.weights for plane in cell.planes]), np.array([one.limit for one in cell.planes])
    scale = np.maximum(np.abs(rows).max(axis=1), np.finfo(np.float64).tiny)
    done = linprog(-weights, rows / scale[:, None], limits / scale, bounds=np.stack([cell.low, cell.high], axis=1))
    if done.status == 0:
        yield done.x


def _inner(cell: Cell) -> Float64:
    """The observation nearest to 0 that lies by 1 within a cell, or halfway across it."""
    inset = np.minimum(1.0, (cell.high - cell.low) / 2)
    return np.clip(0.0, cell.low + inset, cell.high - inset)


def _replay(first: ir.AgentPolicy, second: ir.AgentPolicy, cell: Cell, point: Float64, best: list[Apart]) -> None:
    """Both references at a point and a little beside it."""
    middle = _inner(cell)
    if cell.planes:
        middle = next(_points(cell, middle - point), middle)
    rows = clip_rows(
        np.array([point + share * (middle - point) for share in NUDGES]), cell.low, cell.high, first.numbers
    )
    leaves = [ir.apply(policy.tree, rows) for policy in (first, second)]
    if first.outputs:
        given = [ir.outputs(policy, rows).astype(np.float64) for policy in (first, second)]
        apart = np.abs(given[0] - given[1])
    else:
        apart = (ir.act(first, rows) != ir.act(second, rows)).astype(np.float64)[:, None]
    for row, differences in enumerate(np.nan_to_num(apart)):
        at = (int(leaves[0][row]), int(leaves[1][row]))
        for each, difference in zip(best, differences.tolist(), strict=True):
            if difference > each.reached:
                each.found = Found(difference, tuple(rows[row].astype(float).tolist()), at)


FORM = "maviper-difference-outputs-1"
REPORT_FILE = "difference.json"
ALIKE = ("features", "actions", "numbers")  # what two agents must share


@dataclass(frozen=True)
class Agent:
    """An agent compared. PROVED: its trees are the same, or boxes alone show that they give the same numbers."""

    agent: str
    searched: Searched
    verdict: Verdict
    reason: str  # why there is no answer


@dataclass(frozen=True, repr=False)
class OutputsCompared(Shown):
    """Two profiles compared over the ranges of what agents observe.

    For example:

        maviper.diff(before, after).verdict
    """

    first: ir.PolicyProfile
    second: ir.PolicyProfile
    agents: tuple[Agent, ...]
    unplayable: str = "a page of two profiles shows no sums yet"

    @property
    def verdict(self) -> Verdict:
        """PROVED where all agents act alike, VIOLATED where some does not."""
        verdicts = {one.verdict for one in self.agents}
        if Verdict.VIOLATED in verdicts:
            return Verdict.VIOLATED
        return Verdict.PROVED if verdicts == {Verdict.PROVED} else Verdict.UNKNOWN

    @property
    def verdicts(self) -> list[Verdict]:
        """Each agent's."""
        return [one.verdict for one in self.agents]

    @property
    def told(self) -> list[str]:
        """Verdict and reasons, in few lines."""
        return [f"OutputsCompared: {self.verdict}", *(f"{label} {text}" for label, text in self.lines[:3])]

    @property
    def rows(self) -> list[dict[str, Any]]:
        """A row for each agent: its verdict."""
        return [{"agent": one.agent, "verdict": str(one.verdict)} for one in self.agents]

    @property
    def facts(self) -> dict[str, Any]:
        """All facts as plain data."""
        return {
            "difference": FORM,
            "profiles": [content_hash(self.first), content_hash(self.second)],
            "verdict": self.verdict.value,
            "agents": [
                {
                    "agent": one.agent,
                    "verdict": one.verdict.value,
                    "reason": one.reason,
                    "cells": one.searched.cells,
                    "outputs": [_apart(each) for each in one.searched.apart],
                }
                for one in self.agents
            ],
        }

    @property
    def lines(self) -> list[tuple[str, str]]:
        """What a person is told: labels and texts."""
        return [line for one in self.agents for line in _lines(one, self.first.policy(one.agent), self.second)]

    @property
    def files(self) -> dict[str, str]:
        """Both profiles and the report, name -> text."""
        files = {runs.PROFILE_FILE: dumps(self.first), AGAINST_FILE: dumps(self.second)}
        return {**files, REPORT_FILE: layout(self.facts) + "\n"}


def compare_outputs(
    first: ir.PolicyProfile, second: ir.PolicyProfile, agents: Sequence[str], region: str, max_cells: int
) -> OutputsCompared:
    """Compares how far apart what agents give can be. InputError for agents that cannot be compared."""
    if region != "start":
        what = "agents that test sums or give numbers are compared over the ranges of their features"
        raise InputError(what, "--region", "leave it out")
    for profile in (first, second):
        ensure(profile)
    return OutputsCompared(first, second, tuple(_agent(first, second, agent, max_cells) for agent in agents))


def _agent(first: ir.PolicyProfile, second: ir.PolicyProfile, agent: str, max_cells: int) -> Agent:
    for profile in (first, second):
        names = [policy.agent for policy in profile.agents]
        if agent not in names:
            raise UnknownNameError("agent", agent, names, "--agent")
    one, other = first.policy(agent), second.policy(agent)
    named = [[(each.name, each.unit) for each in policy.outputs] for policy in (one, other)]
    differing = [name for name in ALIKE if getattr(one, name) != getattr(other, name)]
    differing += ["outputs"] if named[0] != named[1] else []
    if differing:
        what = f"{agent} has different {differing[0]} in the two profiles"
        raise InputError(what, "", "compare policies that observe the same, and do or give the same")
    comparison = search(one, other, *ranges(one), max_cells)
    if any(each.found for each in comparison.apart):
        return Agent(agent, comparison, Verdict.VIOLATED, "")
    if _same(one.tree, other.tree) and one.outputs == other.outputs:
        return Agent(agent, comparison, Verdict.PROVED, "")
    if comparison.exact and comparison.complete:
        return Agent(agent, comparison, Verdict.PROVED, "")
    why = "linear programs found no difference, which is no proof"
    if not comparison.complete:
        why = f"no difference in {max_cells:,} pairs of leaves, and there are more; a larger --effort may find one"
    return Agent(agent, comparison, Verdict.UNKNOWN, why)


def _same(one: ir.Tree, other: ir.Tree) -> bool:
    arrays = ("feature", "threshold", "left", "right", "action")
    texts = ("numbers", "arithmetic", "sums", "vectors", "gives")
    alike = all(getattr(one, name).tobytes() == getattr(other, name).tobytes() for name in arrays)
    return alike and all(repr(getattr(one, name)) == repr(getattr(other, name)) for name in texts)


def _apart(each: Apart) -> dict[str, Any]:
    example = each.found
    at = None if example is None else {"observation": list(example.seen), "leaves": list(example.leaves)}
    return {
        "output": each.output,
        "unit": each.unit,
        "difference": 0.0 if example is None else example.difference,
        "bound": each.most,
        "at": at,
    }


def _lines(one: Agent, policy: ir.AgentPolicy, second: ir.PolicyProfile) -> Iterator[tuple[str, str]]:
    if one.verdict is Verdict.PROVED:
        yield "alike", f"{one.agent}: the same for every observation in the ranges of its features"
        return
    if one.verdict is Verdict.UNKNOWN:
        yield one.verdict.value, f"{one.agent}: {one.reason}"
        return
    looked = f"{format_count(one.searched.cells, 'pair')} of leaves meet{'' if one.searched.complete else ', not all'}"
    yield "different", f"{one.agent}: {looked}"
    for each in one.searched.apart:
        if each.found is None:
            yield "", f"{each.output}: no difference found"
            continue
        yield "", _largest(policy, each, each.found)
        yield "", f"  {_beside(policy, second.policy(one.agent), each.found)}"
        named = zip(policy.features, each.found.seen, strict=True)
        yield "", "  at " + ", ".join(f"{feature.name} {value:.9g}" for feature, value in named)


def _largest(policy: ir.AgentPolicy, each: Apart, largest: Found) -> str:
    if not policy.outputs:
        return "other actions:"
    unit = f" {each.unit}" if each.unit not in ("", "none") else ""
    bound = "" if each.most is None else f", and by no more than {each.most:.6g} by linear programs"
    return f"{each.output} by {largest.difference:.6g}{unit}{bound}:"


def _beside(one: ir.AgentPolicy, other: ir.AgentPolicy, largest: Found) -> str:
    said: list[str] = []
    for policy, leaf in zip((one, other), largest.leaves, strict=True):
        if policy.outputs:
            (given,) = ir.outputs(policy, [largest.seen]).tolist()
            does = ", ".join(f"{spec.name} {value:.6g}" for spec, value in zip(policy.outputs, given, strict=True))
        else:
            does = policy.actions[int(policy.tree.action[leaf])].name
        said.append(f"{does} (leaf {leaf})")
    return " or ".join(said)
