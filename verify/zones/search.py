"""The zone search itself: depth-first over the product of trees, with difference bounds closed under every sum.

Does: finds a branch whose bounds can hold together, or closes all branches and writes down why, in the form that
  checker/README.md specifies: in pure Python, or by _zones.c, to which a problem is handed in packed form, with equal
  bytes and equal counts, several hundred times as fast.
Assumes: a problem in integers (tables.py). The extension is optional, and sums of weights must fit into 256 bits for
  it.
Does not: know formulas, profiles or verdicts.

A zone is a matrix of least upper bounds of a - b, one for each component, and beside each entry the number of the first
bound on a path that gives it. A new bound that closes a negative cycle empties the zone, and the path is the reason.
"""

import contextlib
import sys
from array import array
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import NamedTuple, TypeAlias

from verify.certificates.proofs import varint
from verify.spending import SpentError, tell
from verify.zones.tables import TRUE, Flat, Problem, ZoneTree

Zone: TypeAlias = list[tuple[list[int], list[int]]]  # per component: bounds and first steps, [size * size]
Resolve: TypeAlias = Callable[[tuple[int, ...]], Flat | None]
Branch: TypeAlias = tuple[tuple[int, ...], list[int]]  # each agent's leaf, cells of the closed matrices in their order


TOLD = 64  # after so many nodes the search says how far it is
MAX_PARTS = 62  # parts of one agent that lemmas are tried for


class TreeProduct(NamedTuple):
    """Trees that are gone through together: in each the numbers of what is known at its nodes, and the claim's denial
    given such numbers; without these only bounds close branches, and a branch ends at a leaf of the last tree.
    """

    trees: Sequence[ZoneTree] = ()
    classes: Sequence[Sequence[int]] = ()
    resolve: Resolve | None = None


class BudgetError(SpentError):
    """The budget of search nodes has ended."""


@dataclass
class ZoneSearch:
    """One search: counts nodes over several walks, keeps the bounds of the branch that it could not close."""

    problem: Problem
    region: Flat
    budget: int
    nodes: int = 0
    open: list[int] = field(default_factory=list[int])  # numbers of the bounds on an open branch

    def __post_init__(self) -> None:
        self._path: list[int] = []

    def is_inhabited(self) -> bool:
        """Returns True if some point meets the region's bounds; they are then in `open`."""
        return not self._close_branches(_Frame(self._whole(), 0, self.region), bytearray(), TreeProduct())

    def lemmas(
        self, tree: ZoneTree, parts: Sequence[Sequence[Flat | None]], allowed: Sequence[int] | None
    ) -> tuple[bytes, list[int]]:
        """The walk of one agent's tree, and for each node the parts that hold (-1, all of them, where nobody comes).

        `parts`: action -> the denials of the parts; `allowed`: node -> which of them may be tried.
        """
        out, masks = bytearray(), [-1] * len(tree.left)
        for end in self._ends(_Frame(self._whole(), 0, self.region, agent=0), out, TreeProduct([tree])):
            (node,) = end.leaves
            mask, proofs = 0, bytearray()
            for bit, denial in enumerate(parts[tree.action[node]][:MAX_PARTS]):
                if allowed is not None and not allowed[node] >> bit & 1:
                    continue
                mark = len(proofs)
                if denial is None or self._close_branches(_Frame(end.zone, end.length, denial), proofs, TreeProduct()):
                    mask |= 1 << bit
                else:
                    del proofs[mark:]
            masks[node] &= mask
            out.extend(varint(mask) + proofs)
        return bytes(out), masks

    def refutation(
        self, trees: Sequence[ZoneTree], classes: Sequence[Sequence[int]], resolve: Resolve
    ) -> tuple[bytes, bool]:
        """The walk over the product of the trees; whether every branch is closed.

        `classes`: agent, node -> number of what is known there; `resolve`: those numbers -> the claim's denial.
        """
        out = bytearray()
        closed = self._close_branches(self._first(classes), out, TreeProduct(trees, classes, resolve))
        return bytes(out), closed

    def violations(
        self, trees: Sequence[ZoneTree], classes: Sequence[Sequence[int]], resolve: Resolve, most: int
    ) -> tuple[list[Branch], bool]:
        """All open branches, `most` at most; whether these are all, which a spent budget of nodes leaves open too."""
        branches: list[Branch] = []
        with contextlib.suppress(BudgetError):
            for end in self._ends(self._first(classes), bytearray(), TreeProduct(trees, classes, resolve)):
                branches.append((end.leaves, [cell for bounds, _ in end.zone for cell in bounds]))
                if len(branches) > most:
                    break
            else:
                return branches, True
        return branches[:most], False

    def _first(self, classes: Sequence[Sequence[int]]) -> "_Frame":
        return _Frame(self._whole(), 0, self.region, agent=0, known=tuple(known[0] for known in classes))

    def _whole(self) -> Zone:
        matrices: Zone = []
        for size in self.problem.sizes:
            bounds = [self.problem.infinite] * (size * size)
            bounds[:: size + 1] = [0] * size
            matrices.append((bounds, [-1] * (size * size)))
        return matrices

    def _close_branches(self, start: "_Frame", out: bytearray, product: TreeProduct) -> bool:
        """Returns True if all branches are closed; the bounds of the first that is not are then in `open`."""
        for _ in self._ends(start, out, product):
            self.open = list(self._path)
            return False
        return True

    def _ends(self, start: "_Frame", out: bytearray, product: TreeProduct) -> "Iterator[_End]":
        """Closes branches, and writes down why; gives each that cannot be closed, with its bounds in `_path` until the
        next one.
        """
        trees, classes, resolve = product
        stack: list[_Frame] = [start]
        while stack:
            frame = stack.pop()
            self.nodes += 1
            if self.nodes > self.budget:
                raise BudgetError
            if not self.nodes % TOLD:
                tell(self.nodes, self.budget, "search nodes of zones")
            denial = resolve(frame.known) if frame.agent >= 0 and resolve is not None else TRUE
            zone = None if denial is None else self._enter_frame(frame, out)
            if denial is None or zone is None:
                continue
            length = len(self._path)
            # the parts of the first choice that no chosen part settles
            chosen = frame.chosen
            ors: tuple[tuple[Flat, ...], ...] = (*frame.ors, *frame.flat.ors)
            while ors and any(part in chosen for part in ors[0]):
                ors = ors[1:]
            agent, node, known, leaves = frame.agent, frame.node, frame.known, frame.leaves
            if ors:
                stack += [
                    _Frame(zone, length, part, ors[1:], (*chosen, part), agent, node, known, leaves)
                    for part in reversed(ors[0])
                ]
                continue
            # the next agent that is not at a leaf
            while 0 <= agent < len(trees) and trees[agent].left[node] < 0:
                agent, node, leaves = agent + 1, 0, (*leaves, node)
            if 0 <= agent < len(trees):
                tree = trees[agent]
                for child, side in ((tree.right[node], 1), (tree.left[node], 0)):
                    flat = tree.sides[node][side]
                    there = (*known[:agent], classes[agent][child], *known[agent + 1 :]) if classes else known
                    if flat is not None:
                        stack.append(_Frame(zone, length, flat, (), (), agent, child, there, leaves))
            elif agent >= 0 and resolve is not None:
                stack.append(_Frame(zone, length, denial, leaves=leaves))
            else:
                yield _End(leaves, zone, length)

    def _enter_frame(self, frame: "_Frame", out: bytearray) -> Zone | None:
        """The zone of a frame once its bounds are added; None where they close it, which is written down."""
        del self._path[frame.kept :]
        zone = [(bounds.copy(), steps.copy()) for bounds, steps in frame.zone]
        cycle = self._add(zone, frame.flat.edges)
        if cycle is None:
            out.append(0)
            return zone
        out.extend(varint(len(cycle)) + b"".join(map(varint, cycle)))
        return None

    def _add(self, zone: Zone, edges: Sequence[int]) -> list[int] | None:
        """Adds bounds to a zone and to the branch; the places on the branch of a negative cycle, when there is one."""
        path, weights = self._path, self.problem.weights
        for edge in edges:
            component, a, b = self.problem.edges[edge]
            weight = weights[edge]
            bounds, steps = zone[component]
            size = self.problem.sizes[component]
            place = len(path)
            path.append(edge)
            if bounds[b * size + a] + weight < 0:
                return [place, *self._steps(steps, size, b, a)]
            if weight >= bounds[a * size + b]:
                continue
            after = bounds[b * size : b * size + size]
            for i in range(size):
                row = i * size
                here = bounds[row + a] + weight
                if here >= bounds[row + b]:
                    continue  # by the triangle over b no bound of this row gets smaller
                step = place if i == a else steps[row + a]
                for j in range(size):
                    if here + after[j] < bounds[row + j]:
                        bounds[row + j] = here + after[j]
                        steps[row + j] = step
        return None

    def _steps(self, steps: Sequence[int], size: int, a: int, b: int) -> list[int]:
        """The places of the bounds on the path from a to b."""
        places: list[int] = []
        while a != b:
            places.append(steps[a * size + b])
            a = self.problem.edges[self._path[places[-1]]][2]
        return places


@dataclass(frozen=True, slots=True)
class _Frame:
    """A search node to come: the zone and branch it starts from, what is added, what is still to choose."""

    zone: Zone
    kept: int
    flat: Flat
    ors: tuple[tuple[Flat, ...], ...] = ()
    chosen: tuple[Flat, ...] = ()
    agent: int = -1  # whose tree it stands in; -1: only bounds are left
    node: int = 0
    known: tuple[int, ...] = ()
    leaves: tuple[int, ...] = ()


class _End(NamedTuple):
    """A branch that cannot be closed: its leaves, its zone, and how many bounds it has."""

    leaves: tuple[int, ...]
    zone: Zone
    length: int


try:
    from verify.zones import _zones
except ImportError:
    _zones = None
AVAILABLE = _zones is not None and sys.byteorder == "little" and array("i").itemsize == 4
WIDTHS = (128, 256)  # bits
SLOWER = 100  # so many times, without the extension


def search(problem: Problem, region: Flat, budget: int) -> "ZoneSearch | CompiledSearch":
    """The fastest search that there is for a problem."""
    if AVAILABLE and width(problem) is not None:
        return CompiledSearch(problem, region, budget)
    return ZoneSearch(problem, region, budget)


def width(problem: Problem) -> int | None:
    """The bits that hold every sum of the problem's weights; None when there are not enough."""
    return next((bits for bits in WIDTHS if 4 * problem.infinite < 1 << (bits - 1)), None)


def price(problem: Problem) -> int:
    """Prices a search node in a budget: more where numbers are too long for the extension, whoever searches."""
    return 1 if width(problem) is not None else SLOWER


def affordable(problem: Problem, budget: int) -> int:
    """The search nodes that a budget allows: one at least, unless nothing is left of it."""
    return max(min(1, budget), budget // price(problem))


class CompiledSearch:
    """The search of `search.ZoneSearch`, by the compiled extension."""

    def __init__(self, problem: Problem, region: Flat, budget: int) -> None:
        bits = width(problem)
        assert bits is not None
        self.nodes, self.open, self._budget, self._bits = 0, list[int](), budget, bits
        self._counts = problem.sizes
        self._sizes = array("i", problem.sizes).tobytes()
        self._edges = array("i", [end for edge in problem.edges for end in edge]).tobytes()
        self._weights = b"".join(weight.to_bytes(bits // 8, "little", signed=True) for weight in problem.weights)
        self._infinite = problem.infinite.to_bytes(bits // 8, "little", signed=True)
        self._pool: list[int] = []
        self._places: dict[Flat, int] = {}
        self._ids: dict[Flat, int] = {}
        self._packed: dict[int, bytes] = {}  # id of a tree -> its rows
        self._region = self._place(region)

    def is_inhabited(self) -> bool:
        """Does what `ZoneSearch.is_inhabited` does."""
        return not self._walk(-1, ())[1]

    def lemmas(
        self, tree: ZoneTree, parts: Sequence[Sequence[Flat | None]], allowed: Sequence[int] | None
    ) -> tuple[bytes, list[int]]:
        """Does what `ZoneSearch.lemmas` does."""
        count = min(MAX_PARTS, max(map(len, parts), default=0))
        rows = [[self._place(part) for part in row[:count]] for row in parts]
        nothing = [-1] * count
        denials = array("i")
        for left, action in zip(tree.left, tree.action, strict=True):
            denials.extend(rows[action] if left < 0 else nothing)
        tried = None if allowed is None else array("q", allowed).tobytes()
        stream, _, masks = self._walk(0, (tree,), denials=denials.tobytes(), parts=count, allowed=tried)
        return stream, list(array("q", masks))

    def refutation(
        self, trees: Sequence[ZoneTree], classes: Sequence[Sequence[int]], resolve: Resolve
    ) -> tuple[bytes, bool]:
        """Does what `ZoneSearch.refutation` does."""
        stream, closed, _ = self._walk(0, trees, classes, resolve)
        return stream, closed

    def violations(
        self, trees: Sequence[ZoneTree], classes: Sequence[Sequence[int]], resolve: Resolve, most: int
    ) -> tuple[list[Branch], bool]:
        """Does what `ZoneSearch.violations` does."""
        _, closed, kept = self._walk(0, trees, classes, resolve, wanted=most + 1)
        bytes_each, leaves, cells = self._bits // 8, 4 * len(trees), sum(size * size for size in self._counts)
        branches: list[Branch] = []
        for start in range(0, len(kept), leaves + bytes_each * cells):
            weights = range(start + leaves, start + leaves + bytes_each * cells, bytes_each)
            numbers = [int.from_bytes(kept[at : at + bytes_each], "little", signed=True) for at in weights]
            branches.append((tuple(array("i", kept[start : start + leaves])), numbers))
        return branches[:most], closed

    def _walk(
        self, agent: int, trees: Sequence[ZoneTree], classes: Sequence[Sequence[int]] = (),
        resolve: Resolve | None = None, denials: bytes | None = None, parts: int = 0, allowed: bytes | None = None,
        wanted: int = 0,
    ) -> tuple[bytes, bool, bytes]:  # fmt: skip
        """Calls the extension for trees from `agent` on (-1: only the region): `classes` and `resolve` of a product of
        them, `denials`, `parts` and `allowed` of lemmas.
        """

        @cache  # keeps the packed formulas alive while the search reads them
        def pack_numbers(numbers: tuple[int, ...]) -> bytes | None:
            flat = resolve(numbers) if resolve is not None else None
            return None if flat is None else array("i", self._pack(flat)).tobytes()

        rows = tuple(self._rows(tree) for tree in trees)
        product = tuple(array("i", own).tobytes() for own in classes), pack_numbers
        assert _zones is not None
        status, self.nodes, stream, path, masks, kept = _zones.walk(
            self._bits, self._sizes, self._edges, self._weights, self._infinite, array("i", self._pool).tobytes(),
            self._region, agent, rows, *((None, None) if resolve is None else product), denials, parts, allowed,
            self.nodes, self._budget, wanted,
        )  # fmt: skip
        if wanted:
            return stream, status == 0, kept
        if status is None:
            raise BudgetError
        if status:
            self.open = list(array("i", path))
        return stream, not status, masks

    def _rows(self, tree: ZoneTree) -> bytes:
        if id(tree) not in self._packed:
            rows = array("i")
            for left, right, (low, high) in zip(tree.left, tree.right, tree.sides, strict=True):
                rows.extend((left, right, self._place(low), self._place(high)))
            self._packed[id(tree)] = rows.tobytes()
        return self._packed[id(tree)]

    def _place(self, flat: Flat | None) -> int:
        if flat is None:
            return -1
        place = self._places.get(flat)
        if place is None:
            place = self._places[flat] = len(self._pool)
            self._pool += self._pack(flat)
        return place

    def _pack(self, flat: Flat) -> list[int]:
        packed = [len(flat.edges), *flat.edges, len(flat.ors)]
        for choice in flat.ors:
            parts: list[int] = []
            for part in choice:
                inner = self._pack(part)
                parts += [self._ids.setdefault(part, len(self._ids)), len(inner), *inner]
            packed += [2 + len(parts), len(choice), *parts]
        return packed
