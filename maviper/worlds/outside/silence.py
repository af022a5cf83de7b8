"""What other people's code prints, kept off standard output, which is for results.

Does: sends it to standard error, in several threads at once too.
Assumes: what is printed meanwhile by other threads may go there as well.
Does not: touch what programs write past Python's streams.
"""

import sys
import threading
from collections.abc import Generator
from contextlib import contextmanager
from typing import TextIO

_lock = threading.Lock()
_inside: list[TextIO] = []  # standard output as each found it that is within: the first one's is the real one


@contextmanager
def output_aside() -> Generator[None]:
    """Standard output is standard error until the last thread has left."""
    with _lock:
        _inside.append(sys.stdout)
        sys.stdout = sys.stderr
    try:
        yield
    finally:
        with _lock:
            if len(_inside) == 1:
                sys.stdout = _inside[0]
            _inside.pop()
