"""The process `maviper`, also as `python -m maviper`.

Does: listens for Ctrl-C before anything is imported that takes time, then runs the command line and exits; until it
  listens, starting.py does.
Assumes: it is the main thread.
Does not: parse anything itself.
"""

import contextlib
import gc
import os
import signal
import sys
from typing import NoReturn

from codegen.errors import ExitCode
from maviper.cli import exits


def main() -> NoReturn:
    """Runs the command line as a process."""
    exits.keep_output()
    try:
        code = exits.run_command(_command, bool({"-v", "--verbose"} & set(sys.argv)))
    except KeyboardInterrupt:  # while the command said how it ended
        code = ExitCode.INTERRUPTED
    # the command has ended and said how; the interpreter, as it ends, would let the signal kill it in place of that
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    if code == ExitCode.INTERRUPTED:
        # an interrupt inside exec() makes the interpreter end by the signal whatever is done about the exception
        with contextlib.suppress(OSError):
            sys.stdout.flush()
            sys.stderr.flush()
        os._exit(code)
    exits.end_output()
    gc.freeze()  # or the interpreter, as it ends, looks for circles in all that there is: a seventh of a command
    sys.exit(code)


def _command() -> object:
    exits.listen_for_interrupts()  # here, where an interrupt is told in words
    gc.set_threshold(200_000)  # circles are rare in what commands make; to look for them took a tenth of a short one
    # our matrix products are small: threads cost more than they give, all the more beside other processes
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    from maviper.cli.main import cli

    return cli.main(prog_name="maviper", standalone_mode=False)


if __name__ == "__main__":
    main()
