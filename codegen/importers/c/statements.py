"""Statements of C on one path: branches, loops, switch, goto, calls of functions of the file.

Does: follows a function from its first statement to its return.
Assumes: nodes of pycparser; `Growth` counts the work, so that what does not end is refused.
Does not: choose functions (source.py).
"""

# pyright: basic
# pycparser's nodes have no declared attributes
from collections.abc import Sequence
from typing import Any, TypeAlias

from pycparser import c_ast

from codegen.errors import escape_text
from codegen.importers.c.declarations import collect_assigned, is_const, text_of
from codegen.importers.c.expressions import Expressions
from codegen.importers.c.kinds import Callable_, Many, Pointer, Type, Void
from codegen.importers.c.values import Array, Number, Reference, Struct, Text, Value, cells, make_object
from codegen.importers.symbolic.paths import MAX_CALLS, STATE_ADVICE

Open: TypeAlias = "tuple[Any, Open] | None"  # statements that follow: the first, and the others; None ends a scope


class _Jump(Exception):
    """A `break`, `continue`, `goto` or `return`."""

    def __init__(self, kind: str, value: Any = None) -> None:
        self.kind, self.value = kind, value


class Statements(Expressions):
    """Follows statements on one path."""

    def __init__(self, *given: Any, **named: Any) -> None:
        super().__init__(*given, **named)
        self.notes = dict[str, None]()  # what was skipped
        self.named = dict[Any, str]()  # what the source calls some numbers that are returned
        self._set = dict[str, frozenset[str]]()
        self.changing_here: frozenset[str] = frozenset()  # what the present function sets
        self._statements = {
            c_ast.Compound: lambda node: self.block(node.block_items or []),
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
            c_ast.EmptyStatement: lambda node: None,
            c_ast.Pragma: lambda node: None,
            c_ast.StaticAssert: lambda node: None,
        }

    def note(self, text: str) -> None:
        """Something was skipped."""
        self.notes[text] = None

    def follow(self, node: Any) -> None:
        """Does what a statement says."""
        self.at(node)
        if self.paths is not None:
            self.paths.line = self.line
            self.paths.step()
        handler = self._statements.get(type(node))
        if handler is not None:
            handler(node)
        elif type(node) in self._handlers:
            self.value(node)
        else:
            raise self.make_error(f"a statement is not read: {text_of(node)}")

    def block(self, nodes: Sequence[Any]) -> None:
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

    # --- declarations

    def typedef(self, node: Any) -> None:
        """A name for a type."""
        self.typedefs[node.name] = self.type_of(node.type)

    def declare(self, node: Any) -> None:
        """A variable, or a type alone."""
        type_ = self.type_of(node.type)
        if node.name is None:
            return
        if isinstance(type_, Callable_):
            self.results.setdefault(node.name, type_)
            return
        self.at(node)
        if "extern" in node.storage or "volatile" in getattr(node.type, "quals", ()):
            raise self.make_error(f"the variable {escape_text(node.name)} is set elsewhere", STATE_ADVICE)
        changing = node.name in self.changing_here and not is_const(node)  # whose address may be taken
        if "static" in node.storage and len(self.scopes) > 1 and changing:
            what = f"the static variable {escape_text(node.name)} keeps what earlier decisions set"
            raise self.make_error(what, STATE_ADVICE)
        held = "static" in node.storage or len(self.scopes) == 1
        fixed = f"the variable {escape_text(node.name)} is kept or constant" if held or is_const(node) else ""
        before = self.scopes[-1].get(node.name)
        if before is not None and (len(self.scopes) > 1 or getattr(before, "value", None) is not None) and node.init:
            raise self.make_error(f"{escape_text(node.name)} is declared twice", "give each name once")
        if node.init is not None:
            self.scopes[-1][node.name] = self.initialize_object(type_, node.init, fixed)
            return
        target = make_object(type_)
        self.scopes[-1][node.name] = target
        if held:
            self.zero_object(target)
            self._fix(target, fixed)

    # --- loops and choices

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
            if self.paths is None:
                raise self.make_error("a loop stands outside a function")
            self.paths.step()

    def _switch(self, node: Any) -> None:
        chosen = self.arithmetic.plain(self.value(node.cond))
        items = node.stmt.block_items or [] if isinstance(node.stmt, c_ast.Compound) else [node.stmt]
        cases = [(at, each) for at, each in enumerate(items) if isinstance(each, c_ast.Case | c_ast.Default)]
        start = next((at for at, each in cases if isinstance(each, c_ast.Case) and self._is(chosen, each)), None)
        if start is None:
            start = next((at for at, each in cases if isinstance(each, c_ast.Default)), len(items))
        flat = list[Any]()
        for each in items[start:]:
            flat += (each.stmts or []) if isinstance(each, c_ast.Case | c_ast.Default) else [each]
        depth = len(self.scopes)
        try:
            self.block(flat)
        except _Jump as jump:
            if jump.kind != "break":
                raise
            del self.scopes[depth:]

    def _is(self, chosen: Value, case: Any) -> bool:
        value = self.value(case.expr)
        self.at(case)
        return self.arithmetic.truth(self.arithmetic.binary("==", chosen, value))

    # --- functions

    def call_function(self, node: Any, given: Sequence[Value]) -> Value:
        """What a function of the file returns."""
        if self.depth >= MAX_CALLS:
            raise self.make_error("functions call one another too deeply", "write a loop")
        parameters = parameters_of(node)
        if len(parameters) != len(given):
            raise self.make_error(f"{escape_text(node.decl.name)} is called with {len(given)} values")
        frame: dict[str, Any] = {}
        for each, value in zip(parameters, given, strict=True):
            type_ = self.parameter(each)
            frame[each.name] = make_object(type_)
            self.store(frame[each.name], value)
        return self.run(node, frame)

    def follow_open(self, open_: Open) -> None:
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
                self.mark((node, open_))
                self.at(node)
                chosen = node.iftrue if self.truth(node.cond) else node.iffalse
                open_ = open_ if chosen is None else (chosen, open_)
            else:
                self.follow(node)

    def mark(self, open_: Open) -> None:
        """The path can go on from here."""
        raise NotImplementedError

    def run(self, node: Any, frame: dict[str, Any], state: Any = None) -> Value:
        """What a function returns for these variables. `state`: the statements that follow, and the scopes within."""
        outer, self.scopes = self.scopes, [self.scopes[0], frame]
        before, self.changing_here = self.changing_here, self._set_in(node)
        self.depth += 1
        result = self.type_of(node.decl.type.type)
        try:
            if state is None:
                self.follow(node.body)
            else:
                self.scopes += state[1]
                self.follow_open(state[0])
            value = None
        except _Jump as jump:
            if jump.kind != "return":
                raise self.make_error(f"a {jump.kind} leads nowhere") from None
            value = jump.value
        self.depth -= 1
        self.scopes, self.changing_here = outer, before
        if isinstance(result, Void):
            return None
        if value is None:
            self.at(node.decl)
            raise self.make_error(
                f"{escape_text(node.decl.name)} ends without a return on some path", "return on every path"
            )
        if isinstance(value, Struct):
            copy = make_object(value.type)
            self.store(copy, value)
            return copy  # type: ignore[return-value]
        return self.cast(value, result)

    def _set_in(self, node: Any) -> frozenset[str]:
        """The names that a function sets."""
        name = node.decl.name
        if name not in self._set:
            self._set[name] = frozenset(collect_assigned(node.body))
        return self._set[name]

    def parameter(self, node: Any) -> Type:
        """The type of a parameter; an array is handed over as a pointer."""
        type_ = self.type_of(node.type)
        return Pointer(type_) if isinstance(type_, Many) else type_

    def answer(self, target: Value) -> Any:
        """What is returned, as a value of Python."""
        if isinstance(target, Struct):
            return self.together([self.load(each) for each in cells(target)])
        if isinstance(target, Reference) and isinstance(target.target, Array):
            raise self.make_error("a pointer is returned", "return a number or a text")
        return self.together([target])

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


def parameters_of(node: Any) -> list[Any]:
    """The parameters of a function; `void` is none."""
    given = list(node.decl.type.args.params) if node.decl.type.args is not None else []
    return [each for each in given if isinstance(each, c_ast.Decl) and each.name]
