"""What other people's code prints, kept off standard output, which is for results; what it is asked for meanwhile.

Does: sends output to standard error, in several threads at once too; has a command say what a long wait is for.
Assumes: what is printed meanwhile by other threads may go there as well; a command keeps descriptor 1 to itself
  (`exits.keep_output`).
Does not: touch what programs write past Python's streams; stop what takes long.
"""

import sys
import threading
import time
from collections.abc import Generator
from contextlib import contextmanager
from typing import TextIO

from maviper import console

FIRST, NEXT = 5.0, 10.0  # seconds of a wait before it is said, and before it is said again
_lock = threading.Lock()
_inside: list[TextIO] = []  # standard output as each found it that is within: the first one's is the real one
_asked: list[tuple[str, float]] = []  # what other people's code is asked for, the outermost first, and since when
_watch: list[threading.Thread] = []


@contextmanager
def output_aside(words: str = "") -> Generator[None]:
    """Standard output is standard error until the last thread has left. `words`: as in `asking`."""
    with _lock:
        _inside.append(sys.stdout)
        sys.stdout = sys.stderr
    try:
        with asking(words):
            yield
    finally:
        with _lock:
            if len(_inside) == 1:
                sys.stdout = _inside[0]
            _inside.pop()


@contextmanager
def asking(words: str) -> Generator[None]:
    """A command says what it waits for, in these words, where this takes long; "" says nothing."""
    if not words:
        yield
        return
    if not _watch and console.current is not None:
        _watch.append(threading.Thread(target=_say_waits, daemon=True))
        _watch[0].start()
    mine = (words, time.monotonic())
    _asked.append(mine)
    try:
        yield
    finally:
        _asked.remove(mine)


def _say_waits() -> None:
    """Says, while the process lives, what is asked for long."""
    said: dict[tuple[str, float], float] = {}
    while True:
        time.sleep(FIRST / 5)
        now, asked = time.monotonic(), list(_asked)
        if not asked or console.current is None:
            continue
        since = asked[0][1]
        if now - since >= FIRST and now - said.get(asked[0], -NEXT) >= NEXT:
            said = {asked[0]: now}
            console.current.line("waiting", f"{', '.join(words for words, _ in asked)}: {now - since:.0f} s")
