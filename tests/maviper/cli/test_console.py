"""The live line, as a terminal and as a file see it."""

import os
import re
import subprocess
import sys
import threading

import pytest

STAGE = """
import time
from maviper.console import Console
with Console().live("extracting", 1) as live:
    live.total = 3
    for done in (1, 2, 3):
        time.sleep(0.15)
        live.update(done, "best " + "x" * 200)
"""


def on_a_terminal(columns: int) -> list[str]:
    """The frames that a terminal of that width shows."""
    pty = pytest.importorskip("pty")
    ours, theirs = pty.openpty()
    environment = {**os.environ, "TERM": "xterm", "COLUMNS": str(columns)}
    process = subprocess.Popen([sys.executable, "-c", STAGE], stderr=theirs, env=environment)
    os.close(theirs)
    parts: list[bytes] = []

    def read():
        while True:
            try:
                part = os.read(ours, 4096)
            except OSError:
                return
            if not part:
                return
            parts.append(part)

    reader = threading.Thread(target=read)
    reader.start()
    assert process.wait(timeout=60) == 0
    reader.join(timeout=10)
    os.close(ours)
    plain = re.sub(r"\x1b\[[0-9;?]*[a-zA-Z]", "", b"".join(parts).decode(errors="replace"))
    return [frame for frame in re.split(r"[\r\n]+", plain) if frame.strip()]


@pytest.mark.parametrize("columns", [60, 80, 120])
def test_on_a_terminal_the_end_of_the_text_is_cut_not_the_numbers(columns):
    frames = on_a_terminal(columns)
    last = frames[-1]
    assert last.startswith("extracting") and "3/3" in last and "/s  best" in last
    assert all(len(frame) <= columns for frame in frames)


def test_elsewhere_it_is_plain_lines_without_control_characters():
    done = subprocess.run([sys.executable, "-c", STAGE], capture_output=True, text=True, check=True)
    assert "\x1b" not in done.stderr and "\r" not in done.stderr
    assert done.stderr.startswith("extracting  3/3  best") and done.stderr.rstrip().endswith("0 s left")
    assert done.stdout == ""
