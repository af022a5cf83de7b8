"""How far a long search is, told to whoever listens.

Does: hands numbers and a few words from inside a search to a listener that the caller set for the time of a call.
Assumes: counts that do not depend on the machine; listeners that return soon.
Does not: print, measure time, or change what is searched.
"""

from collections.abc import Callable, Generator
from contextlib import contextmanager
from contextvars import ContextVar

Listener = Callable[[int, int, str], None]  # done, of at most, in words
_listener: ContextVar[Listener | None] = ContextVar("listener", default=None)


@contextmanager
def listening(listener: Listener) -> Generator[None]:
    """Everything that is told inside goes to `listener`."""
    before = _listener.set(listener)
    try:
        yield
    finally:
        _listener.reset(before)


def tell(done: int, most: int, words: str) -> None:
    """That `done` of at most `most` are done; `words`: what they are, and what else is known."""
    listener = _listener.get()
    if listener is not None:
        listener(done, most, words)
