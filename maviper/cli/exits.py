"""How a command ends: every exception becomes an exit code and at most three lines, including
Ctrl-C during cleanup or output.

Does: keeps standard output for results; runs a command, prints its error, returns the code of
  `codegen.errors.ExitCode`; says how one that was interrupted goes on.
Assumes: it is called from the main thread of a process that ends afterwards.
Does not: know any command.
"""

import _thread
import contextlib
import os
import signal
import sys
import threading
import traceback
from collections.abc import Callable, Generator
from typing import Any

from codegen.errors import ExitCode, MaviperError
from codegen.wording import visible
from maviper.files import resuming
from maviper.starting import AGAIN

_interrupts: list[int] = []
RESUME = "what is finished is kept; run the command again with --resume"


def listen_for_interrupts() -> None:
    """Makes Ctrl-C count wherever it falls, and SIGTERM as one.

    Foreign-function calls turn a KeyboardInterrupt into another exception, and destructors swallow it (a solver's
    terms have both); so the signal is remembered, and raised again when a destructor was hit.
    """
    signal.signal(signal.SIGINT, _interrupt)
    signal.signal(signal.SIGTERM, _interrupt)  # or the processes that we started would stay
    sys.unraisablehook = _interrupt_again


def _interrupt(number: int, _frame: object) -> None:
    _interrupts.append(number)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)  # a second one ends what does not end by the first
    raise KeyboardInterrupt


def _interrupt_again(unraisable: Any) -> None:
    if _interrupts:
        # a moment later, or it would fall into this very hook
        threading.Timer(0.01, _thread.interrupt_main).start()
    else:
        sys.__unraisablehook__(unraisable)


@contextlib.contextmanager
def limit_seconds(seconds: float | None) -> Generator[Callable[[], bool]]:
    """Interrupts what runs inside after so many seconds, as Ctrl-C does, which solvers listen to. None: never. Gives a
    function that says whether it did.
    """
    over, lock = threading.Event(), threading.Lock()

    def end() -> None:
        with lock:
            over.set()
            os.kill(os.getpid(), signal.SIGINT)

    timer = None if seconds is None else threading.Timer(seconds, end)
    try:
        if timer is not None:
            timer.start()
        yield over.is_set
    finally:
        if timer is not None:
            with lock:
                timer.cancel()
        if over.is_set():
            _interrupts.clear()  # nobody asked for an end of the command


def keep_output() -> None:
    """Keeps standard output for results, from here to the end of the process: what else writes to descriptor 1 (the
    child processes and the C code of an environment) writes to standard error.
    """
    if sys.stdout is None:  # closed by whoever started us
        return
    with contextlib.suppress(OSError):  # standard error is closed
        kept = os.dup(1)
        os.dup2(2, 1)
        sys.stdout = open(kept, "w", encoding=sys.stdout.encoding, errors=sys.stdout.errors)  # noqa: SIM115, PTH123


def end_output() -> None:
    """What is written from here on is no result; what could not be written is given up."""
    if sys.stdout is not None and sys.stdout is not sys.__stdout__:
        with contextlib.suppress(OSError):
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.stdout.flush()
        sys.stdout = sys.stderr


def run_command(command: Callable[[], Any], verbose: bool) -> int:
    """Runs `command`; its exit code. Errors are told in three lines, with the traceback when `verbose`."""
    resuming.forget()
    try:
        result = command()
        if sys.stdout is not None:
            sys.stdout.flush()  # here, where it can fail in words
        return int(result) if isinstance(result, int) else ExitCode.DONE
    except MaviperError as error:
        return _tell(verbose, error.exit_code, error.what, error.where, error.next_step)
    except (BrokenPipeError, SystemExit):  # the latter is click's answer to a closed pipe
        return ExitCode.MISSING  # nobody read the verdict, so the code does not say one
    except KeyboardInterrupt:
        return _tell_interruption()
    except Exception as error:
        return _tell_interruption() if _interrupts else _other(error, verbose)


def _other(error: Exception, verbose: bool) -> int:
    import click  # here, so that Ctrl-C is listened for before it is imported

    if isinstance(error, click.exceptions.NoArgsIsHelpError):
        print(error.format_message(), file=sys.stderr)
        return ExitCode.INPUT
    if isinstance(error, click.UsageError):
        path = error.ctx.command_path if error.ctx else "maviper"
        return _tell(verbose, ExitCode.INPUT, error.format_message(), "", f"see `{path} --help`")
    if isinstance(error, click.ClickException):
        return _tell(verbose, ExitCode.INPUT, error.format_message())
    if isinstance(error, click.Abort):
        return _tell_interruption()
    if isinstance(error, OSError) and error.filename is None:  # no file that was named: a stream, or a scratch file
        advice = "make room for standard output, standard error and temporary files"
        return _tell(verbose, ExitCode.MISSING, f"cannot write: {error.strerror}", "", advice)
    return _tell(True, ExitCode.BUG, f"a bug in maviper: {error}", "", "please report it with the lines above")


def _tell_interruption() -> int:
    # a second signal, or the first one raised again, must not change how the process ends
    signal.signal(signal.SIGINT, lambda number, frame: None)
    sys.unraisablehook = lambda unraisable: None
    return _tell(False, ExitCode.INTERRUPTED, "interrupted", "", RESUME if resuming.has_begun() else AGAIN)


def _tell(with_traceback: bool, code: int, what: str, where: str = "", next_step: str = "") -> int:
    with contextlib.suppress(OSError):  # standard error may be full; the code says the rest
        if with_traceback:
            traceback.print_exc()
        first, *more = f"error: {what}".split("\n")
        below = (line for part in ("\n".join(more), where, next_step) for line in part.split("\n") if line)
        print("\n".join(map(visible, [first, *(f"  {line}" for line in below)])), file=sys.stderr)
    return code
