"""Work in a process of its own that is killed at one of its calls of the system."""

import os
import signal
import sys

import pytest

CALLS = ("open", "os.rename", "os.link", "os.remove", "os.mkdir", "os.rmdir", "os.scandir", "os.listdir", "os.utime")
needs_fork = pytest.mark.skipif(not hasattr(os, "fork"), reason="a process is forked, and killed by a signal")


def killed_at(last, work):
    """Whether `work` is killed at its call `last`, and how many calls it makes where it is not; 0: it is not."""
    told, tell = os.pipe()
    process = os.fork()
    if not process:
        calls = 0

        def count(event, _):
            nonlocal calls
            if event in CALLS:
                calls += 1
                if calls == last:
                    os.kill(os.getpid(), signal.SIGKILL)

        sys.addaudithook(count)
        try:
            work()
            os.write(tell, str(calls).encode())
        finally:
            os._exit(0)
    os.close(tell)
    _, status = os.waitpid(process, 0)
    with os.fdopen(told) as said:
        return os.WIFSIGNALED(status), int(said.read() or 0)
