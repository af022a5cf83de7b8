"""The types of the compiled search, `_zones.c`; numbers are packed in little-endian order.

Does: says what `walk` takes and gives, for compiled.py.
Assumes: the order of the C function's parameters, which have no names.
Does not: serve at run time; wheels leave it out.
"""

from collections.abc import Callable

def walk(
    width: int,  # bits of a weight
    sizes: bytes,
    edges: bytes,
    weights: bytes,
    infinite: bytes,
    pool: bytes,
    region: int,
    agent: int,
    trees: tuple[bytes, ...],
    classes: tuple[bytes, ...] | None,
    resolve: Callable[[tuple[int, ...]], bytes | None] | None,
    denials: bytes | None,
    parts: int,
    allowed: bytes | None,
    nodes: int,
    budget: int,
    wanted: int,
    /,
) -> tuple[int | None, int, bytes, bytes, bytes, bytes]:
    """Status (None: the budget ended), nodes, proof stream, bounds of the open branch, masks, collected branches."""
