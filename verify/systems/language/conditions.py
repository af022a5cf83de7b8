"""Conditions of a world file as unions of polytopes: comparisons of sums, joined by and, or and not.

Does: the polytopes of a tree; what lies outside of some.
Assumes: a reader that knows how two sums compare.
Does not: say whether polytopes overlap, or are empty (verify/systems/cases.py).
"""

from collections.abc import Callable, Sequence
from fractions import Fraction
from itertools import product

from verify.language.parser import Joined, Level, Node, Prefixed, Source, Token
from verify.systems.system import Affine, HalfSpace, Polytope

MAX_POLYTOPES = 1_000
Compare = Callable[[Node, Token, Node], Affine]  # one side less the other, as an affine form
HOW = "write comparisons, and join them by and, or, not"
MINUS = Fraction(-1)


def polytopes(source: Source, node: Node, less: Compare) -> list[Polytope]:
    """Polytopes of which a state lies in one just where the condition of a tree holds."""
    match node:
        case Joined(_, Level.OR, first, rest):
            union = [each for part in (first, *(other for _, other in rest)) for each in polytopes(source, part, less)]
        case Joined(_, Level.AND, first, rest):
            union = _every([polytopes(source, part, less) for part in (first, *(other for _, other in rest))])
        case Prefixed(_, signs, inside) if "not" in signs:
            union = polytopes(source, inside, less)
            union = outside(union) if len(signs) % 2 else union
        case Joined(_, Level.RELATION, first, rest):
            sides = [first, *(other for _, other in rest)]
            signs = [sign for sign, _ in rest]
            union = _every(
                [_compare_to_zero(source, less(*each), each[1]) for each in zip(sides, signs, sides[1:], strict=False)]
            )
        case _:
            raise source.wrong("not a condition", node.token.place, HOW)
    if len(union) > MAX_POLYTOPES:
        raise source.wrong("too many alternatives", node.token.place, "split the case")
    return union


def outside(regions: Sequence[Polytope]) -> list[Polytope]:
    """Polytopes of which a state lies in one just where it lies in none of some."""
    return _every([[(_opposite(half),) for half in region] for region in regions])


def _every(parts: Sequence[Sequence[Polytope]]) -> list[Polytope]:
    union: list[Polytope] = [()]
    for part in parts:
        union = [(*one, *other) for one, other in product(union, part)]
        if len(union) > MAX_POLYTOPES:
            return union
    return union


def _opposite(half: HalfSpace) -> HalfSpace:
    return HalfSpace(Affine().plus(half.form, MINUS), not half.strict)


def _compare_to_zero(source: Source, less: Affine, sign: Token) -> list[Polytope]:
    """`less` compared with 0."""
    more = Affine().plus(less, MINUS)
    match sign.text:
        case "<=" | "<":
            return [(HalfSpace(less, sign.text == "<"),)]
        case ">=" | ">":
            return [(HalfSpace(more, sign.text == ">"),)]
        case "==":
            return [(HalfSpace(less), HalfSpace(more))]
        case "!=":
            return [(HalfSpace(less, True),), (HalfSpace(more, True),)]
        case _:
            raise source.wrong("not a comparison", sign.place, HOW)
