"""Whether the command that runs can go on after an interruption.

Does: remembers how to tell that a run has begun, so that Ctrl-C can say how it goes on.
Assumes: one command at a time in a thread.
Does not: handle signals (cli/exits.py does) or read run folders.
"""

from collections.abc import Callable
from contextvars import ContextVar

_runs: ContextVar[tuple[Callable[[], bool], ...]] = ContextVar("runs", default=())  # each tells whether it has begun


def resumable(begun: Callable[[], bool]) -> None:
    """Tells that the command that runs goes on with --resume, and with nothing else, once `begun` is true."""
    _runs.set((*_runs.get(), begun))


def forget() -> None:
    """Starts over for another command."""
    _runs.set(())


def has_begun() -> bool:
    """Returns True if the command that runs has begun a run that goes on with --resume."""
    return any(each() for each in _runs.get())
