"""Compilers and interpreters that hang: an error in words within the limit, and no process stays."""

import ast
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from codegen.agreement import programs
from codegen.errors import ExitCode, MissingToolError
from maviper.cli import main

ROOT = Path(__file__).parents[3]
PROFILE = ROOT / "generated" / "proved_defenders" / "profile.json"
HANGS = "#!/bin/sh\nsleep 300 &\necho $! > {place}/child\nwait\n"


def hanging(place, name):
    """A program of that name whose child hangs."""
    tool = place / "tools" / name
    tool.parent.mkdir()
    tool.write_text(HANGS.format(place=place))
    tool.chmod(0o755)
    return tool


def alive(process):
    """Whether a process runs; one that has ended and that nobody has asked about does not."""
    try:
        os.kill(process, 0)
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except (ProcessLookupError, FileNotFoundError):
        return False


def ended(place):
    """Whether the child of a hanging program ends, within five seconds."""
    child = int((place / "child").read_text())
    for _ in range(50):
        if not alive(child):
            return True
        time.sleep(0.1)
    return False


def impatient(tool, place):
    """Processes whose limit is over at once where the program is the hanging one, and its child has started."""

    class Process(subprocess.Popen):
        def communicate(self, input=None, timeout=None):
            if timeout == programs.LIMIT_S and Path(self.args[0]).name == tool.name:
                await_child(place)
                timeout = 0.1
            return super().communicate(input, timeout)

    return Process


def await_child(place):
    """Until the child of a hanging program has told its number; at most thirty seconds."""
    for _ in range(600):
        if (place / "child").exists() and (place / "child").read_text().strip():
            return
        time.sleep(0.05)


@pytest.mark.skipif(os.name != "posix", reason="the tools are shell scripts")
@pytest.mark.parametrize(("name", "target"), [("cc", "c"), ("gcc", "c"), ("node", "javascript"), ("rustc", "rust")])
def test_a_tool_that_hangs_is_stopped(tmp_path, name, target, monkeypatch, capsys):
    tool = hanging(tmp_path, name)
    monkeypatch.setattr(programs.subprocess, "Popen", impatient(tool, tmp_path))
    monkeypatch.setenv("PATH", f"{tool.parent}{os.pathsep}{os.environ['PATH']}")
    if name == "cc":
        monkeypatch.setenv("CC", str(tool))
    elif name == "gcc":  # one of those that read the header beside the compiler
        monkeypatch.delenv("CC", raising=False)
    code = main.run(["-q", "compile", str(PROFILE), "--target", target, "-o", str(tmp_path / "out")])
    assert code == ExitCode.MISSING
    said = capsys.readouterr().err
    assert f"{name} did not end within 120 seconds, and was stopped" in said and "Traceback" not in said
    assert not (tmp_path / "out").exists()
    assert ended(tmp_path)


def test_a_tool_that_cannot_start(tmp_path):
    (tmp_path / "broken").write_text("no program")
    (tmp_path / "broken").chmod(0o755)
    with pytest.raises(MissingToolError, match="cannot run broken"):
        programs.run([str(tmp_path / "broken")], tmp_path)
    found = programs.run([sys.executable, "-c", "print(1); import sys; sys.exit(3)"], tmp_path)
    assert (found.returncode, found.stdout) == (3, "1\n")


def test_no_other_module_starts_programs():
    """The class of the fault: whoever starts one does it there, with a limit."""
    starting = {"run", "Popen", "call", "check_call", "check_output", "getoutput", "system", "spawnv", "popen"}
    for package in ("codegen", "verify", "maviper"):
        for path in (ROOT / package).rglob("*.py"):
            called = {
                f"{node.func.value.id}.{node.func.attr}"
                for node in ast.walk(ast.parse(path.read_text()))
                if isinstance(node, ast.Call)
                and isinstance(node.func, ast.Attribute)
                and isinstance(node.func.value, ast.Name)
            }
            found = {f"{module}.{name}" for module in ("subprocess", "os", "asyncio") for name in starting} & called
            assert not found or path.name == "programs.py", (path, found)


def test_a_program_is_stopped_with_this_process(tmp_path):
    """Ctrl-C while a compiler runs ends the compiler, too, which is in a session of its own."""
    tool = hanging(tmp_path, "cc")
    script = (
        "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        f"from codegen.agreement import programs; programs.run([{str(tool)!r}], {str(tmp_path)!r})"
    )
    process = subprocess.Popen([sys.executable, "-c", script], cwd=ROOT, stderr=subprocess.DEVNULL)
    await_child(tmp_path)
    process.send_signal(2)
    process.wait(timeout=30)
    assert ended(tmp_path)
