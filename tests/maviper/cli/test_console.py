"""The live line, as a terminal and as a file see it."""

import os
import re
import subprocess
import sys
import threading

import pytest

from maviper.console import Console, LiveLine, duration, format_rate, say, tabulate

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


@pytest.mark.parametrize("columns", [40, 80, 200])
def test_on_a_terminal_lines_break_between_words_below_their_text(columns, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", str(columns))
    text = "a state in which agent_0 goes down, engaged with landmark_0, at /a/path-of-its-own/that/is/long.json"
    Console().line("VIOLATED", text)
    assert capsys.readouterr().err == f"VIOLATED    {text}\n"  # no terminal
    monkeypatch.setattr("sys.stdout.isatty", lambda: True, raising=False)
    Console().result("found", text)
    lines = capsys.readouterr().out.splitlines()
    assert " ".join(line[12:] for line in lines) == text
    assert all(len(line) <= columns or " " not in line[12:] for line in lines)
    assert lines[0].startswith("found       ") and all(line.startswith(" " * 12) for line in lines[1:])


def test_a_table_that_is_wider_than_the_terminal_is_a_list(capsys, monkeypatch):
    table = [["team", "measure", "subject", "ratio"], ["good", "success", "0.98 [0.93, 0.99]", ""]]
    whole = ["team  measure  subject            ratio", "good  success  0.98 [0.93, 0.99]"]
    assert tabulate(table, 2) == whole  # no terminal
    monkeypatch.setattr("sys.stdout.isatty", lambda: True, raising=False)
    monkeypatch.setenv("COLUMNS", "39")
    assert tabulate(table, 2) == whole
    monkeypatch.setenv("COLUMNS", "38")
    assert tabulate(table, 2) == ["good, success", "  subject  0.98 [0.93, 0.99]"]
    longer = [table[0], *[[*table[1][:3], "1.02"]] * 4]
    left, right = ["team  measure  subject", *whole[1:] * 4], ["team  measure  ratio", *["good  success  1.02"] * 4]
    assert tabulate(longer, 2) == [*left, "", *right]
    assert tabulate(longer, 3)[:2] == ["good, success, 0.98 [0.93, 0.99]", "  ratio  1.02"]  # no column fits
    monkeypatch.setenv("COLUMNS", "38")
    say("  a line of a result that is longer than the terminal")
    assert capsys.readouterr().out == "  a line of a result that is longer\n      than the terminal\n"


@pytest.mark.parametrize(("rate", "said"), [(0.123, "0.12/s"), (3.0, "3/s"), (1234.5, "1,234/s")])
def test_rates_have_no_exponent(rate, said):
    assert format_rate(rate) == said


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


def test_time_left_counts_what_was_done_here_alone(monkeypatch, capsys):
    """4 of 10 were done before. The clock goes on a minute at every look."""
    clock = iter(range(0, 10_000, 60))
    monkeypatch.setattr("maviper.console.time.monotonic", lambda: next(clock))
    live = LiveLine(Console(), "cells", 10, begun=4)
    live.update(5, "a cell")
    live.update(6, "a cell", left=7_500)
    lines = capsys.readouterr().err.splitlines()
    assert lines[0].startswith("cells       5/10  a cell") and lines[0].endswith(" min left")
    assert lines[1].endswith("2 h 05 min left")


def test_the_first_line_comes_early_and_a_step_under_way_shows_its_share(monkeypatch, capsys):
    """A step of 60 s is told of each second: a line after 2 s, then one each 10 s, with the time that is left."""
    now = [0.0]
    monkeypatch.setattr("maviper.console.time.monotonic", lambda: now[0])
    live = LiveLine(Console(), "extracting", 2)
    for second in range(1, 30):
        now[0] = second
        live.update(second / 60, "weighing")
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 3 and lines[0].startswith("extracting  0.0/2  weighing")
    assert lines[0].endswith("117 s left") or lines[0].endswith("118 s left")


@pytest.mark.parametrize(
    ("seconds", "said"), [(0.4, "0 s"), (119.4, "119 s"), (120, "2 min"), (3570, "1 h 00 min"), (29_000, "8 h 03 min")]
)
def test_durations_are_said_in_the_unit_that_fits(seconds, said):
    assert duration(seconds) == said


def test_the_time_left_follows_steps_that_grow_and_not_shares_of_a_step(monkeypatch):
    """Step k takes 1 + k / 20 seconds, and 0.9 of it is told in its first tenth: right within a factor of 1.9 after a
    tenth of the steps, and of 1.3 after half.
    """
    now, took = [0.0], [1 + step / 20 for step in range(20)]
    monkeypatch.setattr("maviper.console.time.monotonic", lambda: now[0])
    live = LiveLine(Console(quiet=True), "extracting", len(took))
    for step, seconds in enumerate(took):
        start = now[0]
        for part, told in ((0.1, 0.9), (0.5, 0.9), (1.0, 1)):
            now[0] = start + part * seconds
            live.update(step + told, "")
            ahead, left = live.ahead(step + told), sum(took) - now[0]
            bound = 1.3 if step >= 10 else 1.9
            if 2 <= step < 19:
                assert ahead is not None and left / bound < ahead < left * bound, (step + told, ahead, left)
    assert live.ahead(len(took)) == 0


def test_what_is_counted_anew_has_a_time_left_of_its_own(monkeypatch, capsys):
    """Boxes of a budget, then steps, two a second, then boxes again: neither rate says anything of the other."""
    now = [0.0]
    monkeypatch.setattr("maviper.console.time.monotonic", lambda: now[0])
    counts = [(9_000 * k, 60_000_000, "boxes of the budget") for k in range(1, 6)]
    counts += [(2 * k, 1_000, f"steps of {256 + k} random episodes") for k in range(12)]
    counts += [(45_000 + 100 * k, 60_000_000, "boxes of the budget, at step 3 of 40") for k in range(13)]
    with Console().following("deciding") as listener:
        for told in counts:
            now[0] += 1
            listener(*told)
    lines = [line for line in capsys.readouterr().err.splitlines() if "2/s" in line or "100/s" in line]
    assert any(re.search(r"steps of \d+ random episodes  2/s  8 min left", line) for line in lines), lines
    assert any(re.search(r"at step 3 of 40  100/s  16\d h \d\d min left", line) for line in lines), lines
