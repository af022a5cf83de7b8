"""Other programs, run to their end or for a limited time: compilers, and what they made.

Does: runs a command in a folder; ends it, with all that it started, when its time is over or this process is stopped.
Assumes: programs that end by themselves within seconds, so that the limit means that one hangs.
Does not: judge how a program ended.
"""

import contextlib
import os
import shlex
import shutil
import signal
import subprocess
import threading
from collections.abc import Generator, Mapping, Sequence
from pathlib import Path

from codegen.errors import HangingToolError, MissingToolError

LIMIT_S = 120
GRACE_S = 5  # for pipes to close


def find_compiler() -> list[str] | None:
    """The C compiler's command, or None. MissingToolError when $CC cannot be read as a command."""
    try:
        named = shlex.split(os.environ.get("CC", ""))
    except ValueError as error:
        raise MissingToolError("cannot read $CC as a command", str(error), "set it to a compiler") from None
    for command in [named] if named else [["cc"], ["gcc"], ["clang"]]:
        if shutil.which(command[0]):
            return command
    return None


def run(
    command: Sequence[str], folder: Path | str, limit_s: int = LIMIT_S, given: Path | str = os.devnull
) -> subprocess.CompletedProcess[str]:
    """The exit status and the output of a command that is given a file as its input. MissingToolError where it cannot
    start, HangingToolError where it does not end in time."""
    called = Path(command[0]).name
    try:
        with Path(given).open("rb") as stdin:
            process = subprocess.Popen(
                command,
                cwd=folder,
                stdin=stdin,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                text=True,
                errors="replace",
                start_new_session=True,  # a compiler starts others, which must not outlive it
            )
    except OSError as error:
        raise MissingToolError(f"cannot run {called}", f"{command[0]}: {error.strerror}", "install it again") from None
    try:
        out, err = process.communicate(timeout=limit_s)
    except subprocess.TimeoutExpired:
        _end(process)
        what = f"{called} did not end within {limit_s} seconds, and was stopped"
        raise HangingToolError(what, " ".join(command), "does it wait for something? try it by hand") from None
    except BaseException:
        _end(process)
        raise
    return subprocess.CompletedProcess(command, process.returncode, out, err)


@contextlib.contextmanager
def start(command: Sequence[str], limit_s: int, environment: Mapping[str, str]) -> "Generator[subprocess.Popen[bytes]]":
    """A process to write to and read from, which is killed at the end, or when its time is over."""
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, env=dict(environment)
    ) as process:
        clock = threading.Timer(limit_s, process.kill)
        clock.start()
        try:
            yield process
        finally:
            clock.cancel()
            process.kill()


def _end(process: subprocess.Popen[str]) -> None:
    """Kills a process and those that it started."""
    with contextlib.suppress(OSError):
        if os.name == "posix":
            os.killpg(process.pid, signal.SIGKILL)
        else:
            process.kill()
    with contextlib.suppress(subprocess.TimeoutExpired, OSError):
        process.communicate(timeout=GRACE_S)
