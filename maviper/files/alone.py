"""A run's folder for one process at a time.

Does: holds a run's folder while the run works in it, and refuses a second run.
Assumes: the folder is claimed already (runs.claim); a lock ends with its process, however that ends, so that none is
  ever left behind. Where nothing can be locked, nobody is refused.
Does not: change the folder.
"""

import contextlib
import errno
import os
from collections.abc import Generator
from pathlib import Path

from codegen.errors import InputError
from maviper.files.runs import CONFIG_FILE

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None


@contextlib.contextmanager
def working_alone(folder: Path) -> Generator[None]:
    """Holds the folder of a run that was claimed. InputError while another process, or thread, holds it."""
    opened = None
    try:
        if fcntl is not None:
            with contextlib.suppress(OSError):
                opened = os.open(folder / CONFIG_FILE, os.O_RDONLY)
        if fcntl is not None and opened is not None:
            try:
                fcntl.flock(opened, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError as error:
                if error.errno in (errno.EAGAIN, errno.EACCES):
                    advice = "wait for its end, or stop it and go on with --resume"
                    raise InputError("another process works on the run in the folder", str(folder), advice) from None
        yield
    finally:
        if opened is not None:
            os.close(opened)
