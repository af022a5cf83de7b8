"""Ctrl-C and SIGTERM at any moment of a command: it ends with a code of its own or as interrupted, without a traceback.

The process sends the signal to itself, so that no test depends on a clock: at so many calls of functions after its
first module began, drawn as a logarithm, since imports are early.
"""

import json
import math
import os
import random
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from codegen.errors import ExitCode
from maviper import starting

GENERATED = Path(__file__).parents[3] / "generated"
PROVED = GENERATED / "proved_defenders" / "profile.json"
VIOLATED = GENERATED / "physical_deception" / "profile.json"
SIGNALLING = """
import os, signal, sys
left = [int(os.environ.pop("SIGNAL_AFTER")), int(os.environ.pop("SIGNAL_NUMBER")), False]

def count_call(frame, event, given):
    if event == "call" and left[2]:
        left[0] -= 1
        if left[0] <= 0:
            sys.setprofile(None)
            os.kill(os.getpid(), left[1])
    elif event == "call":
        left[2] = frame.f_code.co_filename.endswith("siblings.py")

sys.setprofile(count_call)
"""
SMALL = ["--max-episodes", "30", "--max-depth", "2"]
COMMANDS = {
    "worlds": (["worlds", "list"], 300_000),
    "show": (["show", PROVED], 300_000),
    "verify": (["verify", PROVED, "-o", "out"], 3_000_000),
    "compile": (["compile", PROVED, "-o", "out"], 3_000_000),
    "import": (["import", "act.py", "-o", "out/profile.json"], 1_000_000),
    "extract": (["extract", "physical-deception", *SMALL, "-o", "out"], 3_000_000),
    "repair": (["repair", VIOLATED, "-o", "out"], 10_000_000),
    "reproduce": (["reproduce", "--quick", "-o", "out"], 10_000_000),
    "train": (["train", "physical-deception", "-o", "out"], 300_000),
}


def ended(folder, number, after, arguments):
    """The exit code and the last words of a command that gets a signal."""
    (folder / "sitecustomize.py").write_text(SIGNALLING)
    (folder / "act.py").write_text("def act(x):\n    return 1 if x[0] > 0.5 else 0\n")
    signals = {"SIGNAL_AFTER": str(after), "SIGNAL_NUMBER": str(int(number)), "PYTHONPATH": str(folder)}
    command = [sys.executable, "-m", "maviper", "-q", *map(str, arguments)]
    done = subprocess.run(
        command, cwd=folder, env={**os.environ, **signals}, capture_output=True, text=True, check=False
    )
    return done.returncode, done.stderr


def check(folder, name, seed):
    arguments, most = COMMANDS[name]
    rng = random.Random(f"{name} {seed}")
    number, after = rng.choice([signal.SIGINT, signal.SIGTERM]), round(math.exp(rng.uniform(0, math.log(most))))
    code, said = ended(folder, number, after, arguments)
    asked = f"{name}: {number.name} after {after} calls"
    assert "Traceback" not in said and "bug" not in said, f"{asked}\n{said}"
    assert code in list(ExitCode), asked
    if code == ExitCode.INTERRUPTED:
        assert said.splitlines()[-2:-1] == ["error: interrupted"], f"{asked}\n{said}"
    for written in folder.glob("out/**/*.json"):
        json.loads(written.read_text())


@pytest.mark.parametrize("after", [1, 20, 400, 8_000])
def test_signals_while_modules_are_imported(tmp_path, after):
    """Nothing of the command line is there yet."""
    for number in (signal.SIGINT, signal.SIGTERM):
        code, said = ended(tmp_path, number, after, ["worlds", "list"])
        assert (code, said.splitlines()) == (ExitCode.INTERRUPTED, ["error: interrupted", f"  {starting.AGAIN}"])


def test_only_the_command_itself_listens():
    """Not a program that imports the package, which has handlers of its own."""
    asked = "import signal; before = signal.getsignal(2); import maviper; assert signal.getsignal(2) is before"
    subprocess.run([sys.executable, "-c", asked], check=True)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("name", COMMANDS)
def test_signals_at_any_moment(tmp_path, name, seed):
    check(tmp_path, name, seed)
