"""What trees of formulas are made of: the left sides of implications, single names; and trees as text again.

Does: lists the left sides of `A implies B`, `not A or B` and `B or not A` among the conjuncts of a text; spells trees.
Assumes: a tree that was parsed.
Does not: read what trees mean, or look for implications within others.
"""

from verify.language.parser import BARS, CallNode, Joined, Level, Listed, NameNode, Node, NumberNode, Prefixed


def list_conditions(node: Node) -> list[tuple[Node, ...]]:
    """The left side of each implication among the conjuncts of a tree: trees that it says hold together."""
    match node:
        case Joined(_, Level.AND, first, rest):
            return [each for part in (first, *(other for _, other in rest)) for each in list_conditions(part)]
        case Joined(_, Level.IMPLIES, first, _):
            return [(first,)]
        case Joined(_, Level.OR, first, rest):
            parts = [first, *(other for _, other in rest)]
            denied = [inside for part in parts if (inside := _find_denied(part)) is not None]
            return [(each,) for each in denied] if len(denied) == len(parts) else [tuple(denied)] if denied else []
        case _:
            return []


def _find_denied(node: Node) -> Node | None:
    """Returns what a tree denies; None where it says that something holds."""
    return node.value if isinstance(node, Prefixed) and node.signs.count("not") % 2 else None


def spell(node: Node, least: int = Level.IMPLIES) -> str:
    """The text of a tree, in parentheses where its operator binds less tightly than `least`."""
    match node:
        case NumberNode(token, unit):
            return token.text if unit is None else f"{token.text}[{unit}]"
        case NameNode(token):
            return f"'{token.text}'" if "-" in token.text else token.text
        case CallNode(token, arguments):
            inside = ", ".join(map(spell, arguments))
            return f"|{inside}|" if token.text == BARS else f"{spell(NameNode(token))}({inside})"
        case Prefixed(_, signs, value):
            level = Level.NOT if "not" in signs else Level.SIGN
            text = " ".join(signs) + " " * (level is Level.NOT) + spell(value, level)
        case Joined(_, level, first, rest):
            text = spell(first, level + 1) + "".join(f" {sign.text} {spell(other, level + 1)}" for sign, other in rest)
        case Listed(_, value, denied, names):
            level = Level.RELATION
            listed = ", ".join(spell(NameNode(name)) for name in names)
            text = f"{spell(value, level + 1)} {'not in' if denied else 'in'} [{listed}]"
    return text if level >= least else f"({text})"


def strip_signs(node: Node) -> Node:
    """Returns the tree behind signs."""
    return node.value if isinstance(node, Prefixed) and "not" not in node.signs else node


def find_single_name(node: Node) -> str:
    """The one name that a side of a comparison is, or is the absolute value of; "" for any other."""
    inside = strip_signs(node)
    if isinstance(inside, CallNode) and inside.token.text in ("abs", BARS) and len(inside.arguments) == 1:
        inside = strip_signs(inside.arguments[0])
    return inside.token.text if isinstance(inside, NameNode) else ""
