"""The first moments of the process `maviper`, in which its modules are imported: Ctrl-C and SIGTERM end it in words.

Does: has both signals end the process with the exit code and the words of a command that is interrupted, until
  `maviper/cli/exits.py` listens; where a program imports `maviper`, nothing.
Assumes: it is imported before all that takes time.
Does not: import anything that does. Before Python runs any of ours, the signals do what Python does.
"""

import os
import signal
import sys

AGAIN = "finished files are complete; run the command again"
INTERRUPTED = 130  # codegen.errors.ExitCode has it, too, which is not imported yet


def is_command() -> bool:
    """Returns True if this process is the command: the script that is installed, or `python -m maviper`; and not one of
    those that it starts, which have its words and begin with `python -c`.
    """
    called = os.path.basename(sys.argv[0]) if sys.argv else ""  # noqa: PTH119
    named = called.partition(".")[0] == "maviper" or (called == "-m" and "maviper" in sys.orig_argv)
    return named and "-c" not in sys.orig_argv


def _end_process(number: int, frame: object) -> None:
    try:
        os.write(2, f"error: interrupted\n  {AGAIN}\n".encode())
    finally:
        os._exit(INTERRUPTED)


if is_command():
    signal.signal(signal.SIGINT, _end_process)
    signal.signal(signal.SIGTERM, _end_process)
