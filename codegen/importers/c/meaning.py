"""What if/else C returns: its syntax tree followed for many observations at once, as a compiled program would run.

Does: follows statements and expressions with the observations that reach them; compares doubles, as C does.
Assumes: a function that source.py has read, so that nothing else can occur.
Does not: share a line with that reader, beyond what a literal is.
"""

# pyright: basic
# pycparser's nodes have no declared attributes
import operator
from collections.abc import Mapping
from typing import Any

import numpy as np
from pycparser import c_ast

from codegen.importers.c.numbers import Literal, literal
from codegen.ir import Bool, Floats

COMPARE: Mapping[str, Any] = {
    "<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge, "==": operator.eq, "!=": operator.ne,
}  # fmt: skip


def decided(function: Any, enumerators: Mapping[str, int], constants: Mapping[str, Literal], rows: Floats) -> list[Any]:
    """What the function returns, or copies to its output, for each observation; None where it does neither."""
    names = [each.name for each in function.decl.type.args.params]
    single = not isinstance(function.decl.type.args.params[0].type, c_ast.PtrDecl | c_ast.ArrayDecl)
    known = {**enumerators, **{name: number.value for name, number in constants.items()}}
    run = _Run(rows.astype(np.float64), names if single else [], known, set(names[1:]))
    return run.all(function.body)


class _Run:
    def __init__(self, doubles: np.ndarray, features: list[str], known: Mapping[str, Any], outputs: set[str]) -> None:
        self.doubles, self.features, self.known, self.outputs = doubles, features, known, outputs
        self.found: list[Any] = [None] * len(doubles)

    def all(self, body: Any) -> list[Any]:
        """What each observation ends in."""
        open_: list[tuple[Any, np.ndarray, dict[str, Any]]] = [((body, None), np.arange(len(self.doubles)), {})]
        while open_:
            rest, reached, held = open_.pop()
            while rest is not None and len(reached):
                node, rest = rest
                if isinstance(node, c_ast.Compound):
                    for each in reversed(node.block_items or []):
                        rest = (each, rest)
                elif isinstance(node, c_ast.If):
                    holds = self.holds(node.cond, reached)
                    open_.append(((node.iffalse, rest), reached[~holds], held))
                    rest, reached = (node.iftrue, rest), reached[holds]
                elif isinstance(node, c_ast.Return):
                    self.end(node.expr, reached, held)
                    break
                else:
                    held = self.step(node, reached, held)
        return self.found

    def step(self, node: Any, reached: np.ndarray, held: dict[str, Any]) -> dict[str, Any]:
        """What variables hold after a statement; a copy to the output is a decision."""
        if isinstance(node, c_ast.Decl) and node.init is not None:
            return held | {node.name: self.value(node.init, held)}
        if isinstance(node, c_ast.Assignment):
            return held | {node.lvalue.name: self.value(node.rvalue, held)}
        if isinstance(node, c_ast.FuncCall):
            target, source, _ = node.args.exprs
            if target.name in self.outputs:
                self.end(source, reached, held)
                return held
            return held | {target.name: self.value(source, held)}
        return held

    def end(self, node: Any, reached: np.ndarray, held: dict[str, Any]) -> None:
        """The observations return an expression."""
        if isinstance(node, c_ast.TernaryOp):
            holds = self.holds(node.cond, reached)
            self.end(node.iftrue, reached[holds], held)
            self.end(node.iffalse, reached[~holds], held)
            return
        value = self.value(node, held)
        for place in reached.tolist():
            self.found[place] = value

    def value(self, node: Any, held: Mapping[str, Any]) -> Any:
        """A number, or a list of numbers."""
        if isinstance(node, c_ast.CompoundLiteral):
            return self.value(node.init, held)
        if isinstance(node, c_ast.InitList):
            return tuple(self.value(each, held) for each in node.exprs)
        if isinstance(node, c_ast.UnaryOp):
            value = self.value(node.expr, held)
            return -value if node.op == "-" else value
        if isinstance(node, c_ast.ID):
            return held[node.name] if node.name in held else self.known.get(node.name)
        found = literal(node.value)
        return found.value if found else None

    def numbers(self, node: Any, reached: np.ndarray) -> Any:
        """A feature's values, or a number."""
        if isinstance(node, c_ast.ID) and node.name in self.features:
            return self.doubles[reached, self.features.index(node.name)]
        if isinstance(node, c_ast.ArrayRef):
            return self.doubles[reached, self.value(node.subscript, {})]
        return self.value(node, {})

    def holds(self, node: Any, reached: np.ndarray) -> Bool:
        """For which of the observations a condition holds."""
        if isinstance(node, c_ast.UnaryOp):
            return ~self.holds(node.expr, reached)
        if node.op in COMPARE:
            return np.asarray(COMPARE[node.op](self.numbers(node.left, reached), self.numbers(node.right, reached)))
        left, right = self.holds(node.left, reached), self.holds(node.right, reached)
        return left & right if node.op == "&&" else left | right
