"""Expressions of C, whose values may be features.

Does: constants, operators, casts, assignments, calls; the type of an expression without computing it.
Assumes: nodes of pycparser; objects.py finds what names stand for, statements.py follows what a call runs.
Does not: compute (arithmetic.py), or call anything that the file does not hold, but library.py.
"""

# pyright: basic
# pycparser's nodes have no declared attributes
from collections.abc import Callable, Sequence
from typing import Any

from pycparser import c_ast

from codegen.errors import InputError, escape_text
from codegen.importers.c.arithmetic import TEST_ADVICE
from codegen.importers.c.declarations import text_of, walk
from codegen.importers.c.kinds import CHAR, ENUM, INT, ULONG, Callable_, Kind, Many, Pointer, Type, literal, size_of
from codegen.importers.c.library import CONSTANTS, FUNCTIONS, RESULTS
from codegen.importers.c.objects import Objects
from codegen.importers.c.values import Array, Cell, Condition, Function, Number, Reference, Struct, Symbol, Text, Value
from codegen.importers.symbolic.feature import SIGNS

CALL_ADVICE = "a decision may depend on the observation alone; give what the call answers as a feature"


class Expressions(Objects):
    """Evaluates expressions on one path."""

    def __init__(self, *given: Any, **named: Any) -> None:
        super().__init__(*given, **named)
        self.depth = 0
        self._handlers: dict[type, Callable[[Any], Value]] = {
            c_ast.Constant: self._constant,
            c_ast.ID: lambda node: self.load(self.place(node)),
            c_ast.ArrayRef: lambda node: self.load(self.place(node)),
            c_ast.StructRef: lambda node: self.load(self.place(node)),
            c_ast.UnaryOp: self._unary,
            c_ast.BinaryOp: self._binary,
            c_ast.TernaryOp: self._ternary,
            c_ast.Assignment: self._assignment,
            c_ast.FuncCall: self._call,
            c_ast.Cast: lambda node: self.cast(self.value(node.expr), self.type_of(node.to_type)),
            c_ast.ExprList: lambda node: [self.value(each) for each in node.exprs][-1],
            c_ast.CompoundLiteral: self._compound,
        }

    def value(self, node: Any) -> Value:
        """What an expression is."""
        self.at(node)
        if self.paths is not None:
            self.paths.line = self.line
            self.paths.step()
        handler = self._handlers.get(type(node))
        if handler is None:
            raise self.make_error(f"an expression is not read: {text_of(node)}")
        return handler(node)

    def truth(self, node: Any) -> bool:
        """Whether a condition holds."""
        if isinstance(node, c_ast.BinaryOp) and node.op in ("&&", "||"):
            return self.truth(node.right) if self.truth(node.left) == (node.op == "&&") else node.op == "||"
        if isinstance(node, c_ast.UnaryOp) and node.op == "!":
            return not self.truth(node.expr)
        value = self.value(node)
        self.at(node)
        return self.arithmetic.truth(value)

    def constant(self, node: Any) -> int:
        """The whole number that an expression is."""
        value = self.value(node)
        if isinstance(value, Condition):
            return int(value.holds())
        if not isinstance(value, Number) or value.kind.floating:
            raise self.make_error(f"not a whole number: {text_of(node)}", "write the number")
        return int(value.value)

    # --- handlers

    def _constant(self, node: Any) -> Value:
        if node.type == "string":
            try:
                return Text(node.value[1:-1].encode().decode("unicode_escape"))
            except UnicodeDecodeError:
                raise self.make_error(f"a text is not read: {escape_text(node.value)[:60]}") from None
        parsed = literal(node.value)
        if parsed is None:
            advice = "write a finite number of int, float or double"
            raise self.make_error(f"a number is not read: {escape_text(node.value)[:60]}", advice)
        return parsed

    def _unary(self, node: Any) -> Value:
        if node.op == "sizeof":
            of = node.expr
            type_ = self.type_of(of) if isinstance(of, c_ast.Typename) else self.static(of)
            if type_ is None:
                raise self.make_error(f"a size is not read: {text_of(node)}", "write the number")
            return Number(size_of(type_)[0], ULONG)
        if node.op == "&":
            if isinstance(node.expr, c_ast.ArrayRef):
                base, at = self.value(node.expr.name), self.constant(node.expr.subscript)
                return Reference(base.target, base.at + at) if isinstance(base, Reference) else base
            target = self.place(node.expr)
            return Reference(target) if isinstance(target, Cell | Array | Struct) else target  # type: ignore[return-value]
        if node.op == "*":
            value = self.value(node.expr)
            return value if isinstance(value, Function) else self.load(self._target(value, 0, node))
        if node.op in ("++", "--", "p++", "p--"):
            target = self.place(node.expr)
            before = self.load(target)
            self.store(target, self._combine(node.op.strip("p")[0], before, Number(1, INT), node))
            return before if node.op[0] == "p" else self.load(target)
        return self.arithmetic.unary(node.op, self.value(node.expr))

    def _binary(self, node: Any) -> Value:
        if node.op in ("&&", "||"):
            return self._both(node)
        left, right = self.value(node.left), self.value(node.right)
        self.at(node)
        return self._combine(node.op, left, right, node)

    def _combine(self, sign: str, left: Value, right: Value, node: Any) -> Value:
        """An operator of two values; of a pointer, a step or the question whether it is null."""
        if not any(isinstance(each, Reference | Text | Function) for each in (left, right)):
            return self.arithmetic.binary(sign, left, right)
        if sign in ("==", "!=") and any(isinstance(each, Number) and each.value == 0 for each in (left, right)):
            return Number(int(sign == "!="), INT)  # no pointer that is given is null
        if sign in ("+", "-") and isinstance(left, Reference) and isinstance(right, Number):
            return Reference(left.target, left.at + (right.value if sign == "+" else -right.value))
        raise self.make_error(f"pointers or texts are computed with: {text_of(node)}", TEST_ADVICE)

    def _both(self, node: Any) -> Value:
        """`&&` and `||` as a value: asked where it decides, if the second part does nothing and can be read."""
        every, left = node.op == "&&", self.value(node.left)
        if isinstance(left, Number):
            if bool(left.value) != every:
                return Number(int(not every), INT)
            return self.arithmetic.unary("!", self.arithmetic.unary("!", self.value(node.right)))
        if not _acts(node.right):
            outer, self.arithmetic.speculating = self.arithmetic.speculating, True
            try:
                right = self.value(node.right)
            except InputError:  # what the first part rules out
                right = None
            finally:
                self.arithmetic.speculating = outer
            if right is not None:
                truth = self.arithmetic.truth
                if every:
                    return Condition(lambda: truth(left) and truth(right))
                return Condition(lambda: truth(left) or truth(right))
        return Number(int(self.truth(node.right) if self.arithmetic.truth(left) == every else not every), INT)

    def _ternary(self, node: Any) -> Value:
        holds = self.truth(node.cond)
        value = self.value(node.iftrue if holds else node.iffalse)
        kind = self.static(node)
        if isinstance(kind, Kind) and isinstance(value, Number | Symbol | Condition):
            return self.arithmetic.convert_value(value, kind)
        return value

    def _assignment(self, node: Any) -> Value:
        target = self.place(node.lvalue)
        if node.op == "=":
            value = self.value(node.rvalue)
        else:
            value = self._combine(node.op[:-1], self.load(target), self.value(node.rvalue), node)
        self.at(node)
        self.store(target, value)
        return self.load(target)

    def _compound(self, node: Any) -> Value:
        target = self.initialize_object(self.type_of(node.type), node.init)
        return self.load(target)

    def _call(self, node: Any) -> Value:
        given = [] if node.args is None else list(node.args.exprs)
        name = node.name.name if isinstance(node.name, c_ast.ID) else ""
        target = self.value(node.name) if not name or self.find_name(name) or name in self.functions else None
        if isinstance(target, Function):
            return self.call_function(target.node, [self.value(each) for each in given])
        if name in FUNCTIONS and target is None:
            return FUNCTIONS[name](self, given)
        raise self.make_error(f"the function {escape_text(name or text_of(node.name))} is not read", CALL_ADVICE)

    def call_function(self, node: Any, given: Sequence[Value]) -> Value:
        """What a function of the file returns."""
        raise NotImplementedError

    # --- types of expressions

    def static(self, node: Any) -> Type | None:
        """The type of an expression; None for what has no type of numbers."""
        if isinstance(node, c_ast.Constant):
            known = literal(node.value) if node.type != "string" else None
            return known.kind if known else Many(CHAR, len(node.value) - 1)
        if isinstance(node, c_ast.ID):
            known = self.find_name(node.name) or CONSTANTS.get(node.name)
            return known.kind if isinstance(known, Number) else known.type if known is not None else None
        if isinstance(node, c_ast.StructRef):
            holder = self.static(node.name)
            holder = holder.to if isinstance(holder, Pointer) else holder
            return getattr(holder, "members", {}).get(node.field.name)
        if isinstance(node, c_ast.ArrayRef) or (isinstance(node, c_ast.UnaryOp) and node.op == "*"):
            holder = self.static(node.name if isinstance(node, c_ast.ArrayRef) else node.expr)
            holder = holder.to if isinstance(holder, Pointer) else holder
            return holder.of if isinstance(holder, Many) else holder
        if isinstance(node, c_ast.Cast | c_ast.CompoundLiteral):
            return self.type_of(node.to_type if isinstance(node, c_ast.Cast) else node.type)
        if isinstance(node, c_ast.Assignment):
            return self.static(node.lvalue)
        if isinstance(node, c_ast.ExprList):
            return self.static(node.exprs[-1])
        if isinstance(node, c_ast.FuncCall):
            name = node.name.name if isinstance(node.name, c_ast.ID) else ""
            result = self.results.get(name, RESULTS.get(name))
            return result.result if isinstance(result, Callable_) else result
        return self._infer_type(node)

    def _infer_type(self, node: Any) -> Type | None:
        if isinstance(node, c_ast.UnaryOp) and node.op in ("sizeof", "!", "&"):
            return ULONG if node.op == "sizeof" else INT if node.op == "!" else None
        if isinstance(node, c_ast.BinaryOp) and (node.op in SIGNS or node.op in ("&&", "||")):
            return INT
        parts = (
            [node.expr] if isinstance(node, c_ast.UnaryOp)
            else [node.left, node.right] if isinstance(node, c_ast.BinaryOp)
            else [node.iftrue, node.iffalse] if isinstance(node, c_ast.TernaryOp) else []
        )  # fmt: skip
        kinds = [each for each in map(self.static, parts) if isinstance(each, Kind)]
        if not kinds or len(kinds) < len(parts):
            return None
        if isinstance(node, c_ast.UnaryOp) and "+" in node.op + "-" and len(node.op) > 1:
            return kinds[0]
        kinds = [INT if each.rank < INT.rank or each == ENUM else each for each in kinds]
        if isinstance(node, c_ast.BinaryOp) and node.op in ("<<", ">>"):
            return kinds[0]
        return kinds[0] if len(kinds) == 1 else self.arithmetic.common(*kinds)


def _acts(node: Any) -> bool:
    """Whether an expression may do more than compute."""
    return any(
        isinstance(each, c_ast.Assignment | c_ast.FuncCall | c_ast.TernaryOp)
        or (isinstance(each, c_ast.UnaryOp) and each.op in ("++", "--", "p++", "p--"))
        for each in walk(node)
    )
