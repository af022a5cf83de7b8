"""The trusted base: what the README lists is what the checker imports, and is as large as is said."""

import re
from pathlib import Path

from tests.benchmarks.trusted import ACCEPT, imported
from verify import checker

ROOT = Path(__file__).parents[3]
README = Path(checker.__file__).with_name("README.md")
SYSTEMS_ROW = re.compile(r"^\| `([\w/]+)\.py` \| (\d+) \| [^|]+ \|$", re.MULTILINE)
ROW = re.compile(r"^\| `([\w/]+)\.py` \| (\d+) \| (yes|) \| (.+) \|$", re.MULTILINE)


def test_the_readme_lists_the_trusted_base_and_its_sizes():
    rows = ROW.findall(README.read_text())
    listed = {path.replace("/", "."): (int(size), decisions == "yes") for path, size, decisions, _ in rows}
    assert set(listed) == imported("verify.checker.episodes.certificates") and len(rows) == len(listed)
    assert {name for name, (_, needed) in listed.items() if needed} == imported("verify.checker.decisions")
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
    assert set(listed) == imported(ACCEPT) - imported("verify.checker.decisions")
    for name, said in listed.items():
        size = len((ROOT / f"{name.replace('.', '/')}.py").read_text().splitlines())
        assert abs(said - size) <= size / 10, (name, said, size)


def test_packages_of_the_trusted_base_are_empty():
    rooms = (
        "checker",
        "checker.covers",
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
