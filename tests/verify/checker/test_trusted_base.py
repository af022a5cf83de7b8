"""The trusted base: what README and reports list is what the checker imports, and is as large as is said."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from verify import checker
from verify.reports import trusted

ACCEPT = "verify.checker.accept"  # gives each proof about a system to what checks it
ROOT = Path(__file__).parents[3]
README = Path(checker.__file__).with_name("README.md")
SYSTEMS_ROW = re.compile(r"^\| `([\w/]+)\.py` \| (\d+) \| [^|]+ \|$", re.MULTILINE)
ROW = re.compile(r"^\| `([\w/]+)\.py` \| (\d+) \| (yes|) \| (.+) \|$", re.MULTILINE)


def imported(module):
    """The modules of ours that one imports, directly or not; packages, which are docstrings, aside."""
    code = (
        f"import sys, {module}; ours = {{n: m for n, m in sys.modules.items() if n.split('.')[0] in"
        " ('codegen', 'maviper', 'verify')}; print(*(n for n, m in ours.items() if not hasattr(m, '__path__')))"
    )
    found = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    return set(found.stdout.split())


@pytest.mark.parametrize(
    ("module", "base"),
    [
        ("verify.checker.decisions.certificates", trusted.DECISIONS),
        ("verify.checker.episodes.forever", trusted.EPISODES),
        ("verify.checker.systems.certificates", trusted.SYSTEMS),
        ("verify.checker.covers.certificates, verify.checker.covers.forever", trusted.COVERS),
        ("verify.checker.flows.certificates", trusted.FLOWS),
        ("verify.states.state", trusted.REFEREE),
    ],
)
def test_reports_name_what_the_accept_path_imports(module, base):
    assert imported(module) | {ACCEPT} & set(trusted.modules(base)) == set(trusted.modules(base))


def test_what_tells_proofs_about_systems_apart_imports_no_more():
    bases = (trusted.SYSTEMS, trusted.COVERS, trusted.FLOWS)
    assert imported(ACCEPT) == set().union(*map(trusted.modules, bases))


def test_the_readme_lists_the_trusted_base_and_its_sizes():
    rows = ROW.findall(README.read_text())
    listed = {path.replace("/", "."): (int(size), decisions == "yes") for path, size, decisions, _ in rows}
    assert set(listed) == imported("verify.checker.episodes.forever") and len(rows) == len(listed)
    assert {name for name, (_, decisions) in listed.items() if decisions} == set(trusted.modules(trusted.DECISIONS))
    sizes = {name: len((ROOT / f"{name.replace('.', '/')}.py").read_text().splitlines()) for name in listed}
    for name, (said, _) in listed.items():
        assert abs(said - sizes[name]) <= sizes[name] / 10, (name, said, sizes[name])
    total = re.search(r"Lines in all: about ([\d,]+)\.", README.read_text())
    assert total is not None
    assert abs(int(total.group(1).replace(",", "")) - sum(sizes.values())) <= sum(sizes.values()) / 10


def test_the_readme_says_each_thing_once():
    headings = re.findall(r"^## .+$", README.read_text(), re.MULTILINE)
    assert len(headings) > 5 and len(headings) == len(set(headings))


def test_the_readme_lists_what_proofs_about_systems_need_beside():
    listed = {path.replace("/", "."): int(size) for path, size in SYSTEMS_ROW.findall(README.read_text())}
    bases = (trusted.SYSTEMS, trusted.COVERS, trusted.FLOWS)
    assert set(listed) == set().union(*map(trusted.modules, bases)) - set(trusted.modules(trusted.DECISIONS))
    for name, said in listed.items():
        size = len((ROOT / f"{name.replace('.', '/')}.py").read_text().splitlines())
        assert abs(said - size) <= size / 10, (name, said, size)


def test_packages_of_the_trusted_base_are_empty():
    rooms = (
        "checker",
        "checker.covers",
        "checker.decisions",
        "checker.episodes",
        "checker.flows",
        "checker.systems",
        "claims",
        "states",
        "systems",
    )
    for name in ("codegen", "verify", *(f"verify.{room}" for room in rooms)):
        lines = (ROOT / name.replace(".", "/") / "__init__.py").read_text().splitlines()
        assert lines[0].startswith('"""') and lines[-1] == '"""', name
