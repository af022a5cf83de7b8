"""Comparisons of modes with their names, as comparisons of numbers.

Does: puts the number of a mode in place of its name, where a variable that is a mode is compared with it.
Assumes: nothing about other names.
Does not: know what trees mean.
"""

from collections.abc import Mapping, Sequence

from verify.language.parser import CallNode, Joined, Level, Listed, NameNode, Node, NumberNode, Prefixed, Source, Token

Modes = Mapping[str, Sequence[str]]  # variable -> the names of its values, in order
EQUALITY = ("==", "!=")
MODE = "mode"  # the kind of a token that names a mode in a comparison
BY_EQUALITY = "compare it by == or != with one of its modes"


def resolve_modes(source: Source, node: Node, modes: Modes) -> Node:
    """The tree with numbers for the names of modes. InputError where a mode is compared otherwise than by equality, or
    with what is none of its modes.
    """
    if not modes:
        return node
    match node:
        case Joined(token, Level.RELATION, first, rest):
            return _relate(source, token, [first, *(other for _, other in rest)], [sign for sign, _ in rest], modes)
        case Joined(token, level, first, rest):
            others = tuple((sign, resolve_modes(source, other, modes)) for sign, other in rest)
            return Joined(token, level, resolve_modes(source, first, modes), others)
        case Prefixed(token, signs, inside):
            return Prefixed(token, signs, resolve_modes(source, inside, modes))
        case CallNode(token, arguments):
            return CallNode(token, tuple(resolve_modes(source, each, modes) for each in arguments))
        case Listed(token, value, denied, names) if _mode(value, modes):
            equal = [
                _relate(source, token, [value, NameNode(name)], [Token("mark", "==", name.place)], modes)
                for name in names
            ]
            either = Joined(token, Level.OR, equal[0], tuple((names[0], each) for each in equal[1:]))
            comparison = either if either.rest else equal[0]
            return Prefixed(token, ("not",), comparison) if denied else comparison
        case _:
            return node


def is_compared(token: Token) -> bool:
    """Returns True if a name stands where a mode may stand."""
    return token.kind == MODE


def _mode(node: Node, modes: Modes) -> Sequence[str]:
    """The modes of the variable that a tree names; none for any other tree."""
    return modes.get(node.token.text, ()) if isinstance(node, NameNode) else ()


def _relate(source: Source, token: Token, sides: list[Node], signs: list[Token], modes: Modes) -> Node:
    """A comparison, or a chain of some."""
    known = [_mode(side, modes) for side in sides]
    operands = [resolve_modes(source, side, modes) for side in sides]
    for place, (sign, one, other) in enumerate(zip(signs, known, known[1:], strict=False)):
        if not one and not other:
            continue
        for at, names in ((place, one), (place + 1, other)):
            operands[at] = _mark_mode(sides[at]) if names else operands[at]
        if sign.text not in EQUALITY:
            raise source.wrong(f"modes are not ordered by {sign.text}", sign.place, BY_EQUALITY)
        if one and other and tuple(one) != tuple(other):
            raise source.wrong("these have other modes", sign.place, BY_EQUALITY)
        if not one or not other:
            at, names = (place + 1, one) if one else (place, other)
            operands[at] = _number(source, sides[at], names)
    return Joined(token, Level.RELATION, operands[0], tuple(zip(signs, operands[1:], strict=True)))


def _mark_mode(node: Node) -> Node:
    """The name of a mode where it may stand."""
    return NameNode(node.token._replace(kind=MODE))


def _number(source: Source, node: Node, names: Sequence[str]) -> Node:
    if not isinstance(node, NameNode) or node.token.text not in names:
        raise source.unknown("mode", node.token, names)
    return NumberNode(node.token._replace(kind="number", text=str(names.index(node.token.text))))
