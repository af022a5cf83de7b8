"""The compiled zone search: hands a problem to _zones.c in packed form.

Does: the same walks as search.ZoneSearch, with equal bytes and equal counts, several hundred times as fast.
Assumes: the optional extension was built; sums of weights fit into 256 bits.
Does not: serve where either is missing; `search` then gives the pure Python search.
"""

import sys
from array import array
from collections.abc import Callable, Sequence
from typing import NamedTuple, TypeAlias

from verify.zones.search import MAX_PARTS, Branch, BudgetError, Resolve, ZoneSearch
from verify.zones.tables import Flat, Problem, ZoneTree

try:
    from verify.zones import _zones
except ImportError:
    _zones = None
AVAILABLE = _zones is not None and sys.byteorder == "little" and array("i").itemsize == 4
WIDTHS = (128, 256)  # bits
SLOWER = 100  # so many times, without the extension
Packed: TypeAlias = Callable[[tuple[int, ...]], "bytes | None"]


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


class _Walk(NamedTuple):
    """The trees of one call of the extension, packed: agents' trees from `agent` on (-1: only the region)."""

    agent: int
    trees: Sequence[ZoneTree]
    classes: tuple[bytes, ...] | None = None  # of a product of trees
    resolve: Packed | None = None
    denials: bytes | None = None  # of lemmas
    parts: int = 0
    allowed: bytes | None = None


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
        return not self._walk(_Walk(-1, ()))[1]

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
        stream, _, masks = self._walk(_Walk(0, (tree,), denials=denials.tobytes(), parts=count, allowed=tried))
        return stream, list(array("q", masks))

    def refutation(
        self, trees: Sequence[ZoneTree], classes: Sequence[Sequence[int]], resolve: Resolve
    ) -> tuple[bytes, bool]:
        """Does what `ZoneSearch.refutation` does."""
        places = tuple(array("i", own).tobytes() for own in classes)
        stream, closed, _ = self._walk(_Walk(0, trees, places, self._packing(resolve)))
        return stream, closed

    def _packing(self, resolve: Resolve) -> Packed:
        known: dict[tuple[int, ...], bytes | None] = {}  # keeps the packed formulas alive while the search reads them

        def pack_numbers(numbers: tuple[int, ...]) -> bytes | None:
            if numbers not in known:
                flat = resolve(numbers)
                known[numbers] = None if flat is None else array("i", self._pack(flat)).tobytes()
            return known[numbers]

        return pack_numbers

    def violations(
        self, trees: Sequence[ZoneTree], classes: Sequence[Sequence[int]], resolve: Resolve, most: int
    ) -> tuple[list[Branch], bool]:
        """Does what `ZoneSearch.violations` does."""
        places = tuple(array("i", own).tobytes() for own in classes)
        _, closed, kept = self._walk(_Walk(0, trees, places, self._packing(resolve)), wanted=most + 1)
        bytes_each, leaves, cells = self._bits // 8, 4 * len(trees), sum(size * size for size in self._counts)
        branches: list[Branch] = []
        for start in range(0, len(kept), leaves + bytes_each * cells):
            weights = range(start + leaves, start + leaves + bytes_each * cells, bytes_each)
            numbers = [int.from_bytes(kept[at : at + bytes_each], "little", signed=True) for at in weights]
            branches.append((tuple(array("i", kept[start : start + leaves])), numbers))
        return branches[:most], closed

    def _walk(self, walk: _Walk, wanted: int = 0) -> tuple[bytes, bool, bytes]:
        rows = tuple(self._rows(tree) for tree in walk.trees)
        assert _zones is not None
        status, self.nodes, stream, path, masks, kept = _zones.walk(
            self._bits, self._sizes, self._edges, self._weights, self._infinite, array("i", self._pool).tobytes(),
            self._region, walk.agent, rows, walk.classes, walk.resolve, walk.denials, walk.parts, walk.allowed,
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
