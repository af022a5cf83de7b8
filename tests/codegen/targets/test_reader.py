"""The reference reader: every probe decided as the reference decides, by nothing but the standard library."""

import ast
import subprocess
import sys

import numpy as np
import pytest

from codegen import ir
from codegen.agreement import probes, readback, selfcheck
from codegen.targets import emit


def reader(profile, folder):
    """The reader as imported from its file, and the path of the profile."""
    files = emit(profile, ["json"])
    (document,) = (name for name in files if name.endswith(".json"))
    (folder / document).write_text(files[document])
    return readback.load_python(files[document.replace(".json", "_reader.py")]), folder / document


def agrees(profile, folder, random=1_000):
    loaded, path = reader(profile, folder)
    policies = loaded["load"](path)
    assert list(policies) == [policy.agent for policy in profile.agents]
    for policy in profile.agents:
        near = probes.doubles(policy.tree, policy.features, np.random.default_rng(0))
        for rows in (selfcheck.observations(policy, random), near):
            acted = [policies[policy.agent].act(row) for row in rows.tolist()]
            assert acted == ir.act(policy, rows).tolist()


def test_a_real_profile_on_all_probes(profile, tmp_path):
    agrees(profile, tmp_path, selfcheck.RANDOM_OBSERVATIONS)


def test_it_is_short_and_needs_the_standard_library_only(profile, tmp_path):
    text = emit(profile, ["json"])["physical_deception_reader.py"]
    assert len(text.splitlines()) <= 60
    names = {name.name for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Import) for name in node.names}
    assert names <= {"json", "math", "numbers", "struct", "sys"} and not any(
        isinstance(node, ast.ImportFrom) for node in ast.walk(ast.parse(text))
    )
    reader(profile, tmp_path)
    (tmp_path / "reader.py").write_text(text)
    x = ["nan", "1e400", "-0.0", *["0.1"] * 7]
    command = [sys.executable, "-I", "-S", "reader.py", "physical_deception.json", "agent_0", *x]
    ran = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True)
    policy = profile.policy("agent_0")
    action = int(ir.act(policy, [[float(each) for each in x]])[0])
    assert ran.stdout.split() == [str(action), policy.actions[action].name]


def test_it_refuses_what_it_does_not_read(profile, tmp_path):
    loaded, path = reader(profile, tmp_path)
    act = loaded["load"](path)["agent_0"].act
    for wrong in (0, 2, 9, 11):
        for form in (list, tuple, np.array):
            with pytest.raises(ValueError, match=f"agent_0 observes 10 numbers, given {wrong}$"):
                act(form([0.0] * wrong))
    for wrong in ("0" * 10, ["0.5"] * 10, [None] * 10, [0j] * 10, np.zeros((10, 1)), np.zeros(10, dtype=complex)):
        with pytest.raises(ValueError, match="agent_0 observes 10 numbers, given "):
            act(wrong)
    path.write_text(path.read_text().replace('"schema_version": 1', '"schema_version": 2'))
    with pytest.raises(ValueError, match="schema version 2"):
        loaded["load"](path)


@pytest.mark.parametrize(("value", "expected"), [(1e39, np.inf), (-1e39, -np.inf), (3.4028235677973366e38, np.inf)])
def test_doubles_beyond_the_format_are_infinite(value, expected, profile, tmp_path):
    loaded, _ = reader(profile, tmp_path)
    assert loaded["float32"](value) == expected


def test_the_reader_says_how_it_is_used(profile, tmp_path):
    for name, text in emit(profile, ["json"]).items():
        (tmp_path / name).write_text(text)
    for words, said in (([], "reference reader"), (["physical_deception.json", "agent_9"], "agent_0, agent_1")):
        command = [sys.executable, "physical_deception_reader.py", *words]
        ran = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert ran.returncode == 1 and said in ran.stderr and "Traceback" not in ran.stderr
