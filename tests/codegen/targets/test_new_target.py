"""CONTRIBUTING's section on a new target, done as it says, in a copy of the sources."""

import re
import shutil
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

from codegen import policy_json

ROOT = Path(__file__).parents[3]
READER = '''
def table_act(text: str, agent: str, rows: Any) -> list[int]:
    """Decisions of a table."""
    nodes = [[float(item) for item in line.split(",")] for line in text.splitlines()]
    found = []
    for row in rows.tolist():
        node = nodes[0]
        while len(node) > 1:
            node = nodes[int(node[2 if row[int(node[0])] <= node[1] else 3])]
        found.append(int(node[0]))
    return found


'''
USE = """
import sys
from codegen import profiles
from codegen.agreement import selfcheck
from codegen.targets import emit
profile = profiles.loads(open("profile.json").read())
report = selfcheck.check_files(profile, emit(profile, ["table"]), random=1000)
found = report.agreements
print(len(found), {item.target for item in found}, sum(item.differences for item in found))
"""


def registered(path, before, added):
    text = path.read_text()
    assert text.count(before) == 1
    path.write_text(text.replace(before, added))


def blocks():
    """The indented blocks of the section, in order."""
    section = (ROOT / "CONTRIBUTING.md").read_text().split("## A new target\n")[1].split("\n## ")[0]
    assert len(section.splitlines()) <= 30
    found = [textwrap.dedent(block) for block in re.findall(r"(?:^    .*\n|^\n(?=(?:\n)*    ))+", section, flags=re.M)]
    return [block.strip("\n") + "\n" for block in found]


@pytest.mark.parametrize(("fault", "right"), [("", True), ("node.left, node.right", False)])
def test_the_page_makes_a_target_that_is_replayed(fault, right, profile, tmp_path):
    for folder in ("codegen", "templates"):
        shutil.copytree(ROOT / folder, tmp_path / folder, ignore=shutil.ignore_patterns("__pycache__"))
    module, template = blocks()
    if fault:
        assert fault in template
        template = template.replace(fault, "node.right, node.left")
    (tmp_path / "codegen/targets/table.py").write_text(module)
    (tmp_path / "templates/table").mkdir()
    (tmp_path / "templates/table/tree.csv.j2").write_text(template)
    targets, readback = tmp_path / "codegen/targets/__init__.py", tmp_path / "codegen/agreement/readback.py"
    registered(targets, "onnx, rendered, st, svg", "onnx, rendered, st, svg, table")
    registered(targets, '    "svg": svg.emit,\n', '    "svg": svg.emit,\n    "table": table.emit,\n')
    registered(
        readback, "READERS = [\n", READER + 'READERS = [\n    Reader("table", ("{prefix}_{agent}.csv",), table_act),\n'
    )
    (tmp_path / "profile.json").write_text(policy_json.dumps(profile))
    ran = subprocess.run(
        [sys.executable, "-c", USE],
        cwd=tmp_path,
        env={"PYTHONPATH": str(tmp_path)},
        capture_output=True,
        text=True,
        check=True,
    )
    count, target, differences = ran.stdout.split()
    assert (count, target) == ("3", "{'table'}") and (differences == "0") is right
