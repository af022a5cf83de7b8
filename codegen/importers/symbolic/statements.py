"""Statements as the readers of both languages follow them: one after the other, to a side of each branch, in turns.

Does: follows long ladders without going deeper; lets a path go on from where it branched; ends loops; finds names.
Assumes: a language that says what a branch asks and what its sides are, and that runs all other statements. Variables
  are set again on every path: a scope that a state names is that of the path that left it last.
Does not: evaluate expressions, or know a language.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeAlias

from codegen.importers.symbolic.paths import Growth

Open: TypeAlias = "tuple[Any, Scope, Open] | None"  # a statement, the scope that it stands in, and what follows


@dataclass
class Scope:
    """Names and what they stand for, in a block, function, class or file; what cannot be read, for its error."""

    names: dict[str, Any]
    parent: "Scope | None" = None
    local: frozenset[str] = frozenset()  # names that the function assigns somewhere
    of_class: bool = False  # whose names its functions do not see

    def __iter__(self) -> "Iterator[Scope]":
        scope: Scope | None = self
        while scope is not None:
            yield scope
            scope = scope.parent

    @property
    def outer(self) -> "Scope":
        """The scope that a function, a lambda or a comprehension that stands here sees."""
        return self.parent if self.of_class and self.parent else self


class End(NamedTuple):
    """A `break`, `continue` or `return`; the value of a return."""

    kind: str
    value: Any = None


def link_statements(nodes: Sequence[Any], scope: Scope, rest: Open = None) -> Open:
    """Statements of a scope before what is still to be done."""
    for node in reversed(nodes):
        rest = (node, scope, rest)
    return rest


class Executor:
    """Follows the statements of a language, whose reader says the rest."""

    paths: Growth | None = None
    BRANCHES: Any  # the types of nodes that have sides
    branch: Callable[[Any, Scope, Open], tuple[Sequence[Open], bool]]  # to both sides; whether one test decides
    run: Callable[[Any, Scope], End | None]  # any other statement
    keep: Callable[[Open], Any]  # the state from which a path can go on

    def block(self, nodes: Sequence[Any], scope: Scope) -> End | None:
        """Follows statements of a scope; how they end, if not by going on."""
        return self.follow(link_statements(nodes, scope))

    def follow(self, open_: Open, *, marks: bool = False) -> End | None:
        """Follows statements. `marks`: whether a path may go on in between."""
        while open_ is not None:
            node, scope, rest = open_
            paths = self.paths if marks else None
            if paths is not None:
                paths.mark(self.keep(open_))
            if isinstance(node, self.BRANCHES):
                (open_, other), single = self.branch(node, scope, rest)
                if single and paths is not None:  # whose other answer is the other side
                    paths.branch(self.keep(other))
            elif (end := self.run(node, scope)) is not None:
                return end
            else:
                open_ = rest
        return None

    def repeat(self, turns: Iterable[None], body: Sequence[Any], scope: Scope, after: Sequence[Any] = ()) -> End | None:
        """Follows a loop, whose turns prepare themselves. `after`: what follows where nothing breaks it."""
        for _ in turns:
            if self.paths is not None:
                self.paths.step()
            end = self.block(body, scope)
            if end is not None and end.kind != "continue":
                return end if end.kind == "return" else None
        return self.block(after, scope)
