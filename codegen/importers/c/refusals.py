"""What the reader of if/else C says of what it refuses: the thing itself, its line, and what to write instead.

Does: errors with the line of a node; a node as C again, short enough for a line; why a comparison is refused.
Assumes: nodes of pycparser.
Does not: decide what is refused (source.py).
"""

# pyright: basic
# pycparser's nodes have no declared attributes
from typing import Any

from pycparser import c_generator

from codegen.errors import InputError, shown

ADVICE = "give functions of ifs, comparisons with numbers, and returns, as m2cgen writes them"
TEST_ADVICE = "compare one feature with a number; give a sum or a difference as a feature of its own"
NUMBER_ADVICE = "write a finite number of int, float or double, without a cast, a sum or the suffix u"
MAX_SHOWN = 60


def line_of(node: Any) -> int:
    """The line of a node, 0 where it has none."""
    return int(getattr(getattr(node, "coord", None), "line", None) or 0)


def refused(node: Any, where: str, what: str, advice: str = ADVICE) -> InputError:
    """What is wrong at a node's line."""
    return InputError(what, f"{where}, line {line_of(node)}" if line_of(node) else where, advice)


def kind_of(node: Any) -> str:
    """The parser's word for a node."""
    return f"{type(node).__name__!r}"


def text_of(node: Any) -> str:
    """A node as C."""
    return shown(" ".join(c_generator.CGenerator().visit(node).split()))[:MAX_SHOWN]
