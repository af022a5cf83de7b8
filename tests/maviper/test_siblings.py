"""Another package of a name that is ours is told at once, with the place where it lies."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent.parent


@pytest.mark.parametrize("name", ["codegen", "verify"])
@pytest.mark.parametrize("form", ["{}.py", "{}/__init__.py", "{}/inner.py"])
def test_a_package_of_another_is_named(name, form, tmp_path):
    place = tmp_path / form.format(name)
    place.parent.mkdir(exist_ok=True)
    place.write_text("raise SystemExit('this code of another was run')\n")
    program = "import sys\nsys.path[:0] = sys.argv[1:]\nimport maviper"
    words = [sys.executable, "-I", "-c", program, str(tmp_path), str(ROOT)]
    ran = subprocess.run(words, capture_output=True, text=True, check=False)
    if form.endswith("inner.py"):  # a folder without __init__ gives way to a package, wherever that stands
        assert ran.returncode == 0, ran.stderr
        return
    last = ran.stderr.splitlines()[-1]
    assert ran.returncode == 1 and "this code of another was run" not in ran.stderr
    assert last.startswith("ImportError: another package") and str(place) in last and "environment of its own" in last
