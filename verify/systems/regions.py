"""Sets of states by exact inequalities: is one empty, do boxes overlap, and what do they leave out?

Does: Fourier-Motzkin elimination; cuts boxes by boxes.
Assumes: few inequalities, as a file states them; beyond a limit emptiness stays open.
Does not: decide claims.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from fractions import Fraction
from itertools import combinations, product

from verify.systems.system import Affine, Box, HalfSpace, Interval, Polytope

MAX_INEQUALITIES = 4_000  # of one elimination


def box_of(bounds: Mapping[str, Interval]) -> Polytope:
    """The half spaces of a box."""
    halves: list[HalfSpace] = []
    for name, (low, high) in bounds.items():
        halves.append(HalfSpace(Affine.of({name: Fraction(-1)}, low)))
        halves.append(HalfSpace(Affine.of({name: Fraction(1)}, -high)))
    return tuple(halves)


def narrow(ends: Interval, factor: Fraction, end: Fraction) -> Interval:
    """Cuts an interval to what is below an end, or above it where the factor is negative; empty where they cross."""
    low, high = ends
    return (low, min(high, end)) if factor > 0 else (max(low, end), high)


def is_empty(region: Polytope) -> bool | None:
    """Returns True if no state lies in all half spaces; None where that takes too many steps to say."""
    open_ = set(region)
    while new := _count_new(open_):
        if any(_false(half) for half in open_):
            return True
        open_ = _without(open_, min(new, key=lambda name: (new[name], name)))
        if len(open_) > MAX_INEQUALITIES:
            return None
    return any(_false(half) for half in open_)


def _false(half: HalfSpace) -> bool:
    return not half.form.terms and not half.holds({})


def _count_new(halves: set[HalfSpace]) -> dict[str, int]:
    """Counts the inequalities that eliminating each variable makes, in one go: a game has tens of variables."""
    above, below = Counter[str](), Counter[str]()
    for half in halves:
        for name, factor in half.form.terms:
            above[name] += factor.numerator > 0
            below[name] += factor.numerator < 0
    return {name: count * below[name] for name, count in above.items()}


def _without(halves: set[HalfSpace], name: str) -> set[HalfSpace]:
    """Returns the half spaces that remain once a variable is eliminated."""
    above, below = list[tuple[HalfSpace, Fraction]](), list[tuple[HalfSpace, Fraction]]()
    for half in halves:
        if factor := next((factor for each, factor in half.form.terms if each == name), None):
            (above if factor > 0 else below).append((half, factor))
    remaining = halves.difference(half for half, _ in (*above, *below))  # a set knows the hashes of what stays
    for (one, up), (other, down) in product(above, below):
        form = one.form.plus(other.form, up / -down)
        remaining.add(HalfSpace(_normalise_form(form), one.strict or other.strict))
    return remaining


def _normalise_form(form: Affine) -> Affine:
    """A positive multiple in which the first factor is 1 or -1, so that equal half spaces are equal data."""
    return Affine().plus(form, 1 / abs(form.terms[0][1])) if form.terms else form


def overlapping(boxes: Sequence[Box]) -> tuple[int, int] | None:
    """Two boxes that share more than a border, or None."""
    for (i, one), (j, other) in combinations(enumerate(boxes), 2):
        if not apart(one, other):
            return i, j
    return None


def apart(one: Box, other: Box) -> bool:
    """Tests if two boxes share at most a border. A box of no width is apart from others only where it lies outside."""
    for name in one.keys() & other.keys():
        low, high = max(one[name][0], other[name][0]), min(one[name][1], other[name][1])
        if low > high or (low == high and _is_wide(one[name]) and _is_wide(other[name])):
            return True
    return False


def _is_wide(bounds: Interval) -> bool:
    return bounds[0] < bounds[1]


def find_gap(whole: Box, boxes: Sequence[Box]) -> Box | None:
    """A box of states of `whole` that lie in none of the boxes, but for borders; None where there is none."""
    open_ = [dict(whole)]
    for box in boxes:
        open_ = [part for each in open_ for part in _less(each, box)]
    return open_[0] if open_ else None


def _less(whole: Box, box: Box) -> list[dict[str, Interval]]:
    """A box without another, as boxes."""
    rest, parts = dict(whole), list[dict[str, Interval]]()
    for name, (low, high) in box.items():
        least, most = rest[name]
        inner = max(least, low), min(most, high)
        if inner[0] > inner[1] or (inner[0] == inner[1] and least != most):
            return [dict(whole)]
        parts += [rest | {name: side} for side in ((least, inner[0]), (inner[1], most)) if side[0] < side[1]]
        rest[name] = inner
    return parts
