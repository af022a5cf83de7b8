"""generated/: every byte follows from the extracted profile.

`maviper demo -o generated/physical_deception` renews everything, profile included.
"""

import hashlib
import json
import subprocess

import pytest

from codegen.agreement.compiled import find_compiler
from maviper import load, tour
from maviper.files import runs
from tests.support.generated import FOLDER

pytestmark = [pytest.mark.compile, pytest.mark.solver]


def present():
    """Every file of the folder, by name; whoever imports the module may leave a cache of it there."""
    found = {str(path.relative_to(FOLDER)): path for path in sorted(FOLDER.rglob("*")) if path.is_file()}
    return {name: path for name, path in found.items() if "__pycache__" not in name}


@pytest.mark.slow
def test_all_files_follow_from_the_extracted_profile(golden):
    profile = load(FOLDER / tour.EXTRACTED / runs.PROFILE_FILE)
    files = tour.handout(tour.compile_trees(tour.verify_trees(profile), tour.repair_trees(profile)))
    assert set(files) == set(present())
    golden("generated/physical_deception", files)


def test_the_demo_knows_before_its_work_what_it_will_write():
    """All but the numbered files, so that it refuses to write over those of somebody else."""
    assert {name for name in present() if "-1-" not in name and "_1_" not in name} == set(tour.NAMES)


def test_the_first_page_says_what_the_repair_costs():
    """Not only the measure that went up."""
    page, cost = ((FOLDER / name).read_text() for name in ("report.html", "repair.json"))
    told = json.loads(cost)
    assert f"in {100 * told['changed']['met']['share']:.1f} % of the states met in play" in page
    for row in told["measures"]:
        values = "</td><td>".join(f"{row[when]['value']:.3f}" for when in ("before", "after"))
        assert f"<td>{row['measure']}</td><td>{values}</td><td>{row['difference']['value']:+.3f} [" in page


def test_the_manifest_names_every_hash():
    manifest = json.loads((FOLDER / "manifest.json").read_text())
    found = {name: hashlib.sha256(path.read_bytes()).hexdigest() for name, path in present().items()}
    del found["manifest.json"]
    assert manifest["sha256"] == found
    report = json.loads((FOLDER / "report.json").read_text())
    assert report["profile"] == manifest["profile"] == json.loads((FOLDER / "profile.json").read_text())["content_hash"]
    assert {"maviper", "z3-solver", "numpy", "scikit-learn", "mpe2"} <= set(manifest["versions"])


def test_the_shipped_expert_is_the_one_named(expert):
    assert json.loads((FOLDER / "manifest.json").read_text())["expert"] == expert.hash


@pytest.mark.smoke
def test_the_pages_lines_of_c_compile_and_run(tmp_path):
    page = (FOLDER / "README.md").read_text()
    example = page.split("```c\n")[1].split("```")[0]
    assert example == (FOLDER / "example.c").read_text() and len(example.splitlines()) <= 12
    (tmp_path / "example.c").write_text(example)
    build = [*find_compiler(), "-std=c99", "-Wall", "-Wextra", "-Werror", f"-I{FOLDER}", "example.c", "-o", "example"]
    subprocess.run(build, cwd=tmp_path, check=True)
    ran = subprocess.run([str(tmp_path / "example")], capture_output=True, text=True, check=True)
    assert [line.split()[0] for line in ran.stdout.splitlines()] == ["adversary_0", "agent_0", "agent_1"]
