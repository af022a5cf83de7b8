"""Curves that a formula names, such as `angle*spin`, as coordinates of their own.

Does: reads the parts of a formula that are not affine as expressions; one coordinate stands for equal ones.
Assumes: the names of a statement.
Does not: enclose them (formulas.py).
"""

from __future__ import annotations

from dataclasses import dataclass, field

from verify.language.lexer import Source, Token
from verify.language.parser import CallNode, Joined, Level, NameNode, Node, Prefixed
from verify.language.units import Unit
from verify.systems.language.expressions import Expression
from verify.systems.language.parsing import FUNCTIONS, Names, curve_of


@dataclass(frozen=True)
class Curves:
    """What stands for the curves of a formula: expressions by the name of a coordinate that no file can have."""

    names: Names
    found: dict[str, Expression] = field(default_factory=dict[str, Expression])

    def is_curve(self, node: Node) -> bool:
        """Whether a tree is a product, quotient, power or function of what varies, which no sum is."""
        match node:
            case CallNode(token, _):
                return token.text in FUNCTIONS
            case Joined(_, Level.POWER, base, _):
                return self._varies(base)
            case Joined(_, Level.PRODUCT, first, rest):
                over = any(sign.text == "/" and self._varies(other) for sign, other in rest)
                return over or sum(map(self._varies, (first, *(other for _, other in rest)))) > 1
            case _:
                return False

    def _varies(self, node: Node) -> bool:
        match node:
            case NameNode(token):
                return token.text in self.names.known
            case Prefixed(_, _, inside):
                return self._varies(inside)
            case CallNode(_, inside):
                return any(map(self._varies, inside))
            case Joined(_, _, first, rest):
                return any(map(self._varies, (first, *(other for _, other in rest))))
            case _:
                return False

    def coordinate(self, source: Source, node: Node) -> tuple[str, Unit | None, Token | None]:
        """The name and the unit of the coordinate of a curve, and the first number in it that has a unit."""
        (expression, unit), measured = curve_of(source, node, self.names)
        known = {each: name for name, each in self.found.items()}
        name = known.get(expression, f"curve {len(known) + 1}")
        self.found[name] = expression
        return name, unit, measured
