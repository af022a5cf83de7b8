"""With `--json` standard output is one JSON value and nothing else, whatever the libraries below print."""

import json
import subprocess
import sys

import pytest

from codegen import policy_json
from tests.support.far import far
from tests.support.stated import BRAKES, PROPERTIES, profile
from tests.support.systems import CART


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    folder = tmp_path_factory.mktemp("json")
    (folder / "cart.json").write_text(profile(BRAKES))
    (folder / "cart.toml").write_text(CART + PROPERTIES)
    (folder / "a.json").write_text(policy_json.dumps(far(30.0, 1)))
    (folder / "b.json").write_text(policy_json.dumps(far(40.0, 1)))
    (folder / "seen.csv").write_text("gap\n35\n")
    return folder


@pytest.mark.parametrize(
    "asked",
    [
        "verify cart.json --system cart.toml --json",
        "verify cart.json --system cart.toml --json --verdict-only",
        "verify a.json --observations --claim alive_leaves --json",
        "diff a.json b.json --json",
        "robust a.json seen.csv --json",
    ],
)
def test_standard_output_is_json_alone(asked, place):
    """A process of its own: some libraries write past Python, and only once."""
    command = [sys.executable, "-m", "maviper", *asked.split()]
    done = subprocess.run(command, cwd=place, capture_output=True, text=True, timeout=120)
    assert done.returncode in (0, 1, 3), done.stderr
    assert json.loads(done.stdout)
