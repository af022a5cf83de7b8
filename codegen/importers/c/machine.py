"""An interpreter of C on one path: expressions, whose values may be features, and statements.

Does: constants, operators, casts, assignments; the type of an expression without computing it; branches, loops, switch,
  calls of functions of the file, from their first statement to their return.
Assumes: nodes of pycparser; `Growth` counts the work, so that what does not end is refused.
Does not: compute (arithmetic.py), choose functions (source.py), or call what the file does not hold, but library.py.
"""

# pyright: basic
# pycparser's nodes have no declared attributes
from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

from pycparser import c_ast

from codegen.errors import InputError, escape_text
from codegen.importers.c import kinds
from codegen.importers.c.arithmetic import TEST_ADVICE
from codegen.importers.c.kinds import (
    INT,
    Condition,
    Function,
    Kind,
    Number,
    Object,
    Reference,
    Symbol,
    Text,
    Type,
    Value,
)
from codegen.importers.c.library import CONSTANTS, FUNCTIONS, RESULTS
from codegen.importers.c.objects import KEPT, Objects, acts, collect_assigned, is_const, parameters_of, text_of
from codegen.importers.symbolic.feature import SIGNS
from codegen.importers.symbolic.paths import MAX_CALLS, STATE_ADVICE

CALL_ADVICE = "a decision may depend on the observation alone; give what the call answers as a feature"
Open: TypeAlias = "tuple[Any, Open] | None"  # statements that follow: the first, and the others; None ends a scope


class _Jump(Exception):
    """A `break`, `continue` or `return`."""

    def __init__(self, kind: str, value: Any = None) -> None:
        self.kind, self.value = kind, value


class Machine(Objects):
    """Follows statements and evaluates expressions on one path."""

    def __init__(self, *given: Any, **named: Any) -> None:
        super().__init__(*given, **named)
        self.depth = 0
        self.notes = dict[str, None]()  # what was skipped
        self.named = dict[Any, str]()  # what the source calls some numbers that are returned
        self.changing_here: set[str] = set()  # what the present function sets
        self.initialized = set[str]()  # variables of the file
        self._set = dict[str, set[str]]()
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
            c_ast.CompoundLiteral: lambda node: self.load(self.initialize_object(self.type_of(node.type), node.init)),
        }
        self._statements: dict[type, Callable[[Any], Any]] = {
            c_ast.Compound: lambda node: self._block(node.block_items or []),
            c_ast.If: self._if,
            c_ast.Return: self._return,
            c_ast.Decl: self.declare,
            c_ast.DeclList: lambda node: [self.declare(each) for each in node.decls],
            c_ast.Typedef: self.typedef,
            c_ast.For: self._for,
            c_ast.While: lambda node: self._loop(node.cond, None, node.stmt),
            c_ast.DoWhile: lambda node: self._loop(node.cond, None, node.stmt, first=True),
            c_ast.Switch: self._switch,
            c_ast.Break: lambda node: self._jump("break"),
            c_ast.Continue: lambda node: self._jump("continue"),
            c_ast.Goto: self._goto,
            **dict.fromkeys((c_ast.EmptyStatement, c_ast.Pragma, c_ast.StaticAssert), lambda node: None),
        }

    def note(self, text: str) -> None:
        """Something was skipped."""
        self.notes[text] = None

    def _step_to(self, node: Any) -> None:
        self.at(node)
        if self.paths is not None:
            self.paths.line = self.line
            self.paths.step()

    # --- expressions

    def value(self, node: Any) -> Value:
        """Returns the value of an expression."""
        self._step_to(node)
        handler = self._handlers.get(type(node))
        if handler is None:
            raise self.make_error(f"an expression is not read: {text_of(node)}")
        return handler(node)

    def truth(self, node: Any) -> bool:
        """Returns True if a condition holds."""
        if isinstance(node, c_ast.BinaryOp) and node.op in ("&&", "||"):
            return self.truth(node.right) if self.truth(node.left) == (node.op == "&&") else node.op == "||"
        if isinstance(node, c_ast.UnaryOp) and node.op == "!":
            return not self.truth(node.expr)
        value = self.value(node)
        self.at(node)
        return self.arithmetic.truth(value)

    def _constant(self, node: Any) -> Value:
        if node.type == "string":
            try:
                return Text(node.value[1:-1].encode().decode("unicode_escape"))
            except UnicodeDecodeError:
                raise self.make_error(f"a text is not read: {escape_text(node.value)[:60]}") from None
        parsed = kinds.literal(node.value)
        if parsed is None:
            advice = "write a finite number of int, float or double"
            raise self.make_error(f"a number is not read: {escape_text(node.value)[:60]}", advice)
        return parsed

    def _unary(self, node: Any) -> Value:
        if node.op == "sizeof":
            type_ = self.type_of(node.expr) if isinstance(node.expr, c_ast.Typename) else self._static(node.expr)
            if type_ is None:
                raise self.make_error(f"a size is not read: {text_of(node)}", "write the number")
            return Number(kinds.size_of(type_)[0], kinds.ULONG)
        if node.op == "&":
            target = self.place(node.expr)
            return Reference(target) if isinstance(target, Object) else target
        if node.op == "*":
            return self.load(self.place(node))
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
            return Reference(self.target(left, right.value if sign == "+" else -right.value, node))
        raise self.make_error(f"pointers or texts are computed with: {text_of(node)}", TEST_ADVICE)

    def _both(self, node: Any) -> Value:
        """`&&` and `||` as a value: asked where it decides, if the second part does nothing and can be read."""
        every, left = node.op == "&&", self.value(node.left)
        if isinstance(left, Number):
            if bool(left.value) != every:
                return Number(int(not every), INT)
            return self.arithmetic.unary("!", self.arithmetic.unary("!", self.value(node.right)))
        if not acts(node.right):
            outer, self.arithmetic.speculating = self.arithmetic.speculating, True
            try:
                right = self.value(node.right)
            except InputError:  # what the first part rules out
                right = None
            finally:
                self.arithmetic.speculating = outer
            if right is not None:
                truth = self.arithmetic.truth
                return Condition(lambda: truth(right) if truth(left) == every else not every)
        return Number(int(self.truth(node.right) if self.arithmetic.truth(left) == every else not every), INT)

    def _ternary(self, node: Any) -> Value:
        value = self.value(node.iftrue if self.truth(node.cond) else node.iffalse)
        kind = self._static(node)
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

    def _call(self, node: Any) -> Value:
        given = [] if node.args is None else list(node.args.exprs)
        name = node.name.name if isinstance(node.name, c_ast.ID) else ""
        target = self.value(node.name) if not name or self.find_name(name) or name in self.functions else None
        if isinstance(target, Function):
            return self._call_function(target.node, [self.value(each) for each in given])
        if name in FUNCTIONS and target is None:
            return FUNCTIONS[name](self, given)
        raise self.make_error(f"the function {escape_text(name or text_of(node.name))} is not read", CALL_ADVICE)

    def _static(self, node: Any) -> Type | None:
        """The type of an expression, without its value; None for what has no type of numbers."""
        if isinstance(node, c_ast.Constant):
            known = kinds.literal(node.value) if node.type != "string" else None
            return known.kind if known else kinds.Many(kinds.CHAR, len(node.value) - 1)
        if isinstance(node, c_ast.ID):
            known = self.find_name(node.name) or CONSTANTS.get(node.name)
            return known.kind if isinstance(known, Number) else known.type if known is not None else None
        if isinstance(node, c_ast.Cast | c_ast.CompoundLiteral):
            return self.type_of(node.to_type if isinstance(node, c_ast.Cast) else node.type)
        if isinstance(node, c_ast.FuncCall):
            name = node.name.name if isinstance(node.name, c_ast.ID) else ""
            result = self.results.get(name, RESULTS.get(name))
            return result.result if isinstance(result, kinds.Callable_) else result
        op = getattr(node, "op", "")
        if isinstance(node, c_ast.StructRef | c_ast.ArrayRef) or (isinstance(node, c_ast.UnaryOp) and op == "*"):
            holder = self._static(node.expr if isinstance(node, c_ast.UnaryOp) else node.name)
            holder = holder.to if isinstance(holder, kinds.Pointer) else holder
            if isinstance(node, c_ast.StructRef):
                return holder.members.get(node.field.name) if isinstance(holder, kinds.Record) else None
            return holder.of if isinstance(holder, kinds.Many) else holder
        if op in ("!", "&&", "||") or op in SIGNS:
            return INT
        if op in ("sizeof", "&"):
            return kinds.ULONG if op == "sizeof" and isinstance(node, c_ast.UnaryOp) else None
        parts = [each for name, each in node.children() if name != "cond"]
        if isinstance(node, c_ast.Assignment | c_ast.ExprList) or op in ("++", "--", "p++", "p--"):
            return self._static(parts[-1 if isinstance(node, c_ast.ExprList) else 0])
        met = [each for each in map(self._static, parts) if isinstance(each, Kind)]
        if not met or len(met) < len(parts):
            return None
        met = [INT if each.rank < INT.rank or each == kinds.ENUM else each for each in met]
        return met[0] if len(met) == 1 or op in ("<<", ">>") else self.arithmetic.common(*met)

    # --- declarations

    def typedef(self, node: Any) -> None:
        """A name for a type."""
        self.typedefs[node.name] = self.type_of(node.type)

    def declare(self, node: Any) -> None:
        """A variable, or a type alone."""
        type_ = self.type_of(node.type)
        if node.name is None:
            return
        if isinstance(type_, kinds.Callable_):
            self.results.setdefault(node.name, type_)
            return
        self.at(node)
        shown, outside = escape_text(node.name), len(self.scopes) == 1
        if "extern" in node.storage or "volatile" in getattr(node.type, "quals", ()):
            raise self.make_error(f"the variable {shown} is set elsewhere", STATE_ADVICE)
        if "static" in node.storage and not outside and node.name in self.changing_here and not is_const(node):
            raise self.make_error(KEPT.format(f"static variable {shown}"), STATE_ADVICE)
        if node.init and (node.name in self.scopes[-1]) and (not outside or node.name in self.initialized):
            raise self.make_error(f"{shown} is declared twice", "give each name once")
        held = "static" in node.storage or outside
        fixed = f"the variable {shown} is kept or constant" if held or is_const(node) else ""
        if node.init is not None:
            self.scopes[-1][node.name] = self.initialize_object(type_, node.init, fixed)
            self.initialized |= {node.name} if outside else set()
            return
        self.scopes[-1][node.name] = target = self.new_object(type_)
        if held:
            self.zero_object(target)
            self.fixed[target.place.base] = fixed

    # --- statements

    def follow(self, node: Any) -> None:
        """Does what a statement says."""
        self._step_to(node)
        handler = self._statements.get(type(node), self._handlers.get(type(node)))
        if handler is None:
            raise self.make_error(f"a statement is not read: {text_of(node)}")
        handler(node)

    def _block(self, nodes: Sequence[Any]) -> None:
        """Statements one after the other, in a scope of their own."""
        self.scopes.append({})
        depth = len(self.scopes)
        for each in nodes:
            self.follow(each)
        del self.scopes[depth - 1 :]

    def _jump(self, kind: str) -> None:
        raise _Jump(kind)

    def _goto(self, node: Any) -> None:
        raise self.make_error("goto is not read", "return in each branch, or put what follows into a function")

    def _if(self, node: Any) -> None:
        chosen = node.iftrue if self.truth(node.cond) else node.iffalse
        if chosen is not None:
            self.follow(chosen)

    def _return(self, node: Any) -> None:
        raise _Jump("return", None if node.expr is None else self.value(node.expr))

    def _for(self, node: Any) -> None:
        self.scopes.append({})
        if node.init is not None:
            self.follow(node.init)
        self._loop(node.cond, node.next, node.stmt)
        self.scopes.pop()

    def _loop(self, condition: Any, after: Any, body: Any, *, first: bool = False) -> None:
        depth = len(self.scopes)
        while first or condition is None or self.truth(condition):
            first = False
            try:
                if body is not None:
                    self.follow(body)
            except _Jump as jump:
                del self.scopes[depth:]
                if jump.kind == "break":
                    break
                if jump.kind != "continue":
                    raise
            if after is not None:
                self.follow(after)
            self._step_to(None)

    def _switch(self, node: Any) -> None:
        chosen = self.arithmetic.plain(self.value(node.cond))
        items = node.stmt.block_items or [] if isinstance(node.stmt, c_ast.Compound) else [node.stmt]
        start = next((at for at, each in enumerate(items) if self._is_case(chosen, each)), None)
        if start is None:
            start = next((at for at, each in enumerate(items) if isinstance(each, c_ast.Default)), len(items))
        flat = list[Any]()
        for each in items[start:]:
            flat += (each.stmts or []) if isinstance(each, c_ast.Case | c_ast.Default) else [each]
        depth = len(self.scopes)
        try:
            self._block(flat)
        except _Jump as jump:
            if jump.kind != "break":
                raise
            del self.scopes[depth:]

    def _is_case(self, chosen: Value, node: Any) -> bool:
        if not isinstance(node, c_ast.Case):
            return False
        value = self.value(node.expr)
        self.at(node)
        return self.arithmetic.truth(self.arithmetic.binary("==", chosen, value))

    # --- functions

    def _call_function(self, node: Any, given: Sequence[Value]) -> Value:
        """Calls a function of the file, and returns its value."""
        if self.depth >= MAX_CALLS:
            raise self.make_error("functions call one another too deeply", "write a loop")
        parameters = parameters_of(node)
        if len(parameters) != len(given):
            raise self.make_error(f"{escape_text(node.decl.name)} is called with {len(given)} values")
        frame: dict[str, Any] = {}
        for each, value in zip(parameters, given, strict=True):
            frame[each.name] = self.new_object(self.parameter(each))
            self.store(frame[each.name], value)
        return self.run(node, frame)

    def parameter(self, node: Any) -> Type:
        """The type of a parameter; an array is handed over as a pointer."""
        type_ = self.type_of(node.type)
        return kinds.Pointer(type_) if isinstance(type_, kinds.Many) else type_

    def run(self, node: Any, frame: dict[str, Any], state: Any = None) -> Value:
        """Runs a function on these variables. `state`: the statements that follow, and the scopes within."""
        outer, self.scopes = self.scopes, [self.scopes[0], frame]
        before, name = self.changing_here, node.decl.name
        if name not in self._set:
            self._set[name] = collect_assigned(node.body)
        self.changing_here = self._set[name]
        self.depth += 1
        result, value = self.type_of(node.decl.type.type), None
        try:
            if state is None:
                self.follow(node.body)
            else:
                self.scopes += state[1]
                self._follow_open(state[0])
        except _Jump as jump:
            if jump.kind != "return":
                raise self.make_error(f"a {jump.kind} leads nowhere") from None
            value = jump.value
        self.depth -= 1
        self.scopes, self.changing_here = outer, before
        if isinstance(result, kinds.Void):
            return None
        if value is None:
            self.at(node.decl)
            raise self.make_error(f"{escape_text(name)} ends without a return on some path", "return on every path")
        return self.cast(value, result)

    def _follow_open(self, open_: Open) -> None:
        """Follows statements of the function that decides. Its path can go on from each `if`, with the variables as
        they are there.
        """
        while open_ is not None:
            node, open_ = open_
            if node is None:
                self.scopes.pop()
            elif isinstance(node, c_ast.Compound):
                self.scopes.append({})
                open_ = (None, open_)
                for each in reversed(node.block_items or []):
                    open_ = (each, open_)
            elif isinstance(node, c_ast.If):
                assert self.paths is not None
                self.paths.mark(((node, open_), dict(self.memory), [dict(each) for each in self.scopes[1:]]))
                self.at(node)
                chosen = node.iftrue if self.truth(node.cond) else node.iffalse
                open_ = open_ if chosen is None else (chosen, open_)
            else:
                self.follow(node)

    # --- answers

    def together(self, values: Sequence[Value]) -> Any:
        """A value of Python for one value, a tuple for several; what they give, where that depends on features."""
        numbers = not any(isinstance(each, Text) for each in values)
        given = self.arithmetic.build_given(values) if numbers else None
        if given is not None:
            return given
        plain_values = [self._plain(each) for each in values]
        return plain_values[0] if len(plain_values) == 1 else tuple(plain_values)

    def _plain(self, value: Value) -> Any:
        if isinstance(value, Text):
            return value.text
        number = self.arithmetic.resolve_number(value)
        if not isinstance(number, Number):
            raise self.make_error("a feature is returned, not an action", "return a number that stands for an action")
        plain = number.value if isinstance(number.value, int) else float(number.value)
        if number.name not in ("", "true", "false"):
            self.named.setdefault(plain, number.name)
        return plain
