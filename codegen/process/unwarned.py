"""Python's warnings, kept off the screen in some calls.

Does: ignores warnings in a call; one thread at a time, since Python's filters are those of the whole process.
Assumes: short calls.
Does not: hide errors.
"""

import threading
import warnings
from collections.abc import Generator
from contextlib import contextmanager

FILTERS = threading.RLock()  # held by whoever changes them: threads that overlap put back the wrong ones


@contextmanager
def silence_warnings() -> Generator[None]:
    """No warning is shown or raised."""
    with FILTERS, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield
