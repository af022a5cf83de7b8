"""Hostile programs: none opens a file, connects, forks or imports once the gate has begun; each is refused or harmless.

The canaries: a hook in the process itself, which reports every event of Python's audit before the process ends, and a
file that must not come to be.
"""

import ast
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from codegen.errors import MaviperError
from codegen.importers.origin import Names, profile_of
from codegen.importers.python.source import from_python
from codegen.importers.running import asking, gate
from tests.codegen.importers.running.hostile import CANARY, list_programs

PROGRAMS = list(dict.fromkeys(list_programs()))
CANARIES = ("open", "os", "subprocess", "socket", "import", "ctypes", "shutil", "pty", "mmap", "fcntl", "tempfile")
WATCHED = """
import sys, runpy
seen = []
def watch(event, given):
    if event.partition(".")[0] in {canaries} and watch.on:
        print("CANARY", event, given, file=sys.stderr, flush=True)
watch.on = False
sys.addaudithook(watch)
space = runpy.run_path({child!r})
begin = space["watch_process"]
def start():
    begin()
    watch.on = True
space["main"].__globals__["watch_process"] = start
space["main"]()
"""


def request_of(source):
    """The request that asks for `act` of a source, or for the method of its class A."""
    entry = "act" if "def act(" in source.split("class A")[0] or "act =" in source else "A"
    entry = "act" if "\ndef act(" in source or source.startswith(("def act(", "@", "async", "act")) else entry
    return {
        "source": source,
        "entry": entry,
        "method": "act" if entry == "A" else "",
        "made": True,
        "given": ["row"],
        "named": {},
        "forms": ["floats", "float64"],
        "seconds": 1,
        "bytes": 1 << 31,
        "library": str(Path(np.__file__).parent.parent),
    }


def run_watched(source):
    """What the process says, and what its canaries do."""
    rows = np.array([[1.0, -1.0], [-1.0, 1.0], [0.5, 2.0]])
    head = json.dumps({"rows": len(rows), "width": 2, "kept": []}).encode() + b"\n"
    program = WATCHED.format(canaries=CANARIES, child=str(asking.CHILD))
    ended = subprocess.run(
        [sys.executable, "-I", "-S", "-B", "-c", program],
        input=json.dumps(request_of(source)).encode() + b"\n" + head + rows.tobytes(),
        capture_output=True,
        timeout=60,
        check=False,
        env=asking.ENVIRONMENT,
    )
    return ended.stdout, ended.stderr


def test_there_are_200_of_them():
    assert len(PROGRAMS) >= 200


def fired(programs, folder):
    """The programs whose canary fires, and how many the gate refuses."""
    found, refused = {}, 0
    for place, program in enumerate(programs):
        canary = folder / f"canary_{place}"
        said, told = run_watched(program.replace(CANARY, str(canary)))
        refused += b'"refused"' in said
        if b"CANARY" in told or canary.exists():
            found[program] = told
    return found, refused


def test_no_canary_of_some_programs_fires(tmp_path):
    found, _ = fired(PROGRAMS[::12], tmp_path)
    assert found == {}


@pytest.mark.slow
def test_no_canary_fires_and_most_programs_are_refused(tmp_path):
    found, refused = fired(PROGRAMS, tmp_path)
    assert found == {}
    assert refused >= 0.8 * len(PROGRAMS)


def test_a_canary_would_fire(monkeypatch, tmp_path):
    """Without the gate's look at names: the process ends at the event, and the canary tells."""
    broken = tmp_path / "gate.py"
    text = Path(gate.__file__).read_text()
    broken.write_text(text.replace('"""abs all any bool', '"""open abs all any bool'))
    child = tmp_path / "child.py"
    child.write_text(asking.CHILD.read_text())
    monkeypatch.setattr(asking, "CHILD", child)
    canary = tmp_path / "canary"
    said, told = run_watched(f"def act(x):\n    return open({str(canary)!r}, 'w')\n")
    assert b"CANARY open" in told and not canary.exists()
    assert said.count(b"\n") == 1  # the numbers, and no answers


@pytest.mark.parametrize("program", PROGRAMS[::12], ids=range(len(PROGRAMS[::12])))
def test_an_import_ends_with_an_error_of_ours_or_a_profile(program, monkeypatch):
    monkeypatch.setattr(asking, "SECONDS", 2)
    try:
        profile = profile_of(from_python(program.encode(), "policy.py"), Names())
    except MaviperError as error:
        assert str(error).isprintable() or "\n" in str(error)
        assert "\x1b" not in str(error) and "\x07" not in str(error)
    else:
        assert profile.agents


@pytest.mark.parametrize("kind", [np.ndarray, np.generic, np.dtype, np.ufunc, np.float64, np.bool_, type(np.clip)])
def test_no_attribute_of_an_array_that_is_not_on_the_list_passes(kind):
    passing = [name for name in dir(kind) if not name.startswith("_") and name not in gate.ATTRIBUTES]
    for name in passing:
        with pytest.raises(SyntaxError):
            gate.gate_source(f"def act(x):\n    return x.{name}\n", "act")


@pytest.mark.parametrize("name", ["tofile", "dump", "dumps", "ctypes", "data", "gi_frame", "f_back", "mro", "format"])
def test_what_reaches_out_is_on_no_list(name):
    assert name not in gate.ATTRIBUTES


def test_what_passes_has_only_nodes_of_the_list():
    tree, *_ = gate.gate_source("import os\ndef act(x: int) -> int:\n    'says'\n    return x\n", "act")
    assert not any(isinstance(node, ast.Import) for node in ast.walk(tree))
    assert ast.unparse(tree) == "def act(x):\n    return x"
