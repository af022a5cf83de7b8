"""House rules, as tests: imports along the arrows, style, types, the public surface. Sizes are reported (house.py)."""

import ast
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from maviper.files import profiles
from tests.benchmarks import sizes
from tests.conftest import SAMPLED
from tests.support.heavy import ASIDE, HEAVY
from tests.support.sources import nodes_of, parsed

ROOT = Path(__file__).parent.parent
PACKAGES = ("codegen", "maviper", "verify")
MODULES = sorted(path for package in PACKAGES for path in (ROOT / package).rglob("*.py"))
WRITTEN = ("recompute.py",)  # files that a module writes


def tool(*command):
    found = subprocess.run([sys.executable, "-m", *command], cwd=ROOT, capture_output=True, text=True, check=False)
    assert found.returncode == 0, found.stdout + found.stderr


def test_the_version_is_everywhere_the_same():
    stated = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"]
    cited = re.findall(r"^version: (.+)$", (ROOT / "CITATION.cff").read_text(), re.MULTILINE)
    sections = re.findall(r"^## (.+?)(?: \(.+\))?$", (ROOT / "CHANGELOG.md").read_text(), re.MULTILINE)
    assert [stated] == cited == [profiles.VERSION] and sections[:2] == ["Unreleased", stated]


def test_ruff():
    tool("ruff", "check", ".")
    tool("ruff", "format", "--check", ".")


@pytest.mark.smoke
def test_imports_follow_the_arrows():
    found = subprocess.run(
        [str(Path(sys.executable).parent / "lint-imports")], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert found.returncode == 0, found.stdout


@pytest.mark.slow
def test_types():
    tool("pyright", "--pythonpath", sys.executable)


def test_modules_that_headers_name_exist():
    """`room/module.py`, from the module's own folder up to the root, and `module.name` of a module of ours."""
    stems = {path.stem: [] for path in MODULES}
    for path in MODULES:
        stems[path.stem].append(path)
    wrong = []
    for path in MODULES:
        header = ast.get_docstring(parsed(path)) or ""
        above = [folder for folder in path.parents if folder.is_relative_to(ROOT)] + [ROOT / name for name in PACKAGES]
        for name in re.findall(r"(?<![/\w])[a-z_][\w/]*\.(?:py|md)\b", header):
            if name not in WRITTEN and not any((folder / name).is_file() for folder in above):
                wrong.append(f"{path.relative_to(ROOT)}: {name}")
        for module, name in re.findall(r"`([a-z_]+)\.(?!toml|json|csv|save\b)(\w+)`", header):
            defined = re.compile(rf"^((def|class) )?{name}\b|import .*\b{name}\b", re.MULTILINE)
            if (ROOT / module / name).exists():  # a package
                continue
            if module in stems and not any(defined.search(each.read_text()) for each in stems[module]):
                wrong.append(f"{path.relative_to(ROOT)}: {module}.{name}")
    assert not wrong, wrong


def test_test_files_that_comments_and_pages_name_exist():
    sources = [*(ROOT / "tests").rglob("*.py"), *MODULES, *(ROOT / "maviper" / "manual").glob("*.md")]
    names = {path.name for path in sources}
    named = {(path, name) for path in sources for name in re.findall(r"[# `(]+(test_\w+\.py)\b", path.read_text())}
    named = {(path.relative_to(ROOT).as_posix(), name) for path, name in named if "_N_" not in name}
    assert named and not {(path, name) for path, name in named if name not in names}


def inheriting(bases, roots):
    """The names of classes that inherit from some root, these included."""
    found = set(roots)
    while more := {name for name, above in bases.items() if above & found} - found:
        found |= more
    return found


def test_public_exceptions_stand_in_a_tree():
    """Of what a user can mend, or of searches without an answer: drawn where it begins. Or a certificate is refused."""
    sources = [path for path in MODULES if path.relative_to(ROOT).parts[0] != "maviper"]
    classes = [node for path in sources for node in parsed(path).body if isinstance(node, ast.ClassDef)]
    bases = {node.name: set().union(*map(names_in, node.bases)) for node in classes}
    public = {name for name in inheriting(bases, {"Exception"}) - {"Exception"} if not name.startswith("_")}
    trees = {"MaviperError": "codegen/errors.py", "UnansweredError": "verify/spending.py"}
    for root, place in trees.items():
        drawing = ast.get_docstring(ast.parse((ROOT / place).read_text()))
        assert all(re.search(rf"\b{name}\b", drawing) for name in inheriting(bases, {root})), root
    assert public == inheriting(bases, {*trees, "RejectedError"})


def names_in(node):
    return {getattr(each, "id", getattr(each, "attr", "")) for each in ast.walk(node)}


def test_public_surface():
    import maviper

    assert maviper.__all__ == sorted(maviper.__all__)
    public = {name for name, value in vars(maviper).items() if callable(value) and not name.startswith("_")}
    assert public == set(maviper.__all__)


def test_help_and_import_load_nothing_heavy():
    code = (
        "import sys; from maviper.cli import main; main.run(['--help']);"
        "heavy = {'numpy', 'torch', 'sklearn', 'scipy', 'z3', 'mpe2', 'pygame', 'rich', 'jinja2', 'msgspec'};"
        "print(sorted(heavy & set(sys.modules)), file=sys.stderr)"
    )
    found = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert found.stderr.strip() == "[]"


@pytest.mark.solver
def test_a_claim_about_decisions_loads_no_more_than_it_needs():
    """What is imported is waited for, and of episodes, of stated systems and of experts nothing is asked."""
    others = {"codegen.targets", "jinja2", "maviper.experts", "verify.reach", "verify.systems"}
    unasked = tuple(sorted(ASIDE | others | HEAVY - {"mpe2", "pettingzoo", "z3"}))
    code = (
        "import sys; from maviper.cli import main;"
        "main.run(['-q', 'verify', 'generated/physical_deception/profile.json']);"
        f"print(sorted(name for name in sys.modules if name.startswith({unasked!r})))"
    )
    found = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert found.stdout.splitlines()[-1] == "[]"


def test_nothing_committed_is_a_pickle_or_names_a_machine():
    listed = subprocess.run(["git", "ls-files", "-s", "-z"], cwd=ROOT, capture_output=True, text=True, check=False)
    if listed.returncode != 0:
        pytest.skip("not a git checkout")
    for entry in filter(None, listed.stdout.split("\0")):
        mode, name = entry.split()[0], entry.split("\t", 1)[1]
        assert mode in {"100644", "100755"}, f"{name}: only plain files; a link points into one machine"
        path = ROOT / name
        assert path.suffix not in {".pkl", ".pickle", ".pt", ".pth", ".joblib"}, name
        data = path.read_bytes() if path.exists() else b""
        for word in ("/" + "work/", "index" + "-url", "/" + "root/"):
            assert word.encode() not in data, (name, word)


def test_a_checkout_keeps_no_single_episodes_and_stays_small():
    """`python -m tests.benchmarks.sizes` says what takes how much."""
    try:
        files = sizes.committed()
    except subprocess.CalledProcessError:
        pytest.skip("not a git checkout")
    assert not [name for name in files if name.endswith((".tar.xz", ".tar.gz", ".zip"))]
    # beside the experts, of which a wheel has one per game, and what an unfinished record needs to go on
    kept = {name: files.pop(name) for name in [*files] if name.endswith(".kept.xz")}
    rest = [size for name, size in files.items() if not name.startswith(sizes.EXPERTS)]
    assert sum(rest) / sizes.MB < 18 and max(rest) / sizes.MB < 0.55 and sum(kept.values()) / sizes.MB < 3


def test_ci_asks_each_file_for_tests_that_it_has():
    """pytest ends with 5, and CI with it, where a file's only tests are among those left out without `-m`."""
    asked = re.findall(r"pytest (.*?)(tests/\S+\.py)", (ROOT / ".ci" / "run").read_text())
    assert asked
    for options, name in asked:
        mark = re.search(r'-m "?(\w+)', options)
        whole_file = "pytestmark = pytest.mark." + (mark.group(1) if mark else "")
        assert ("pytestmark" in (ROOT / name).read_text()) == (mark is not None), name
        assert mark is None or whole_file in (ROOT / name).read_text(), name


def test_numbers_that_tests_make_smaller_are_known_wherever_they_are_held():
    """A module that a test loads while such a number is smaller would keep the smaller one for all later tests."""
    for name, known in SAMPLED.items():
        origins = [module for module in known if f"\n{name}" in text_of(module)]
        taking = re.compile(rf"^from ({'|'.join(map(re.escape, origins))}) import .*\b{name}\b", re.MULTILINE)
        found = [path for path in MODULES if taking.search(path.read_text())]
        assert {".".join(path.relative_to(ROOT).with_suffix("").parts) for path in found} <= set(known), name


def text_of(module):
    return (ROOT / module.replace(".", "/")).with_suffix(".py").read_text()


IMPORTS_OF_TESTS = re.compile(r"^\s*from\s+(\S*\btest_|\S+\s+import\s+(\([^)]*|.*)\btest_)", re.MULTILINE)


def test_no_test_file_imports_another_one():
    """What several tests use stands in tests/support, or in a module beside them that is no test file."""
    tests = sorted((ROOT / "tests").rglob("*.py"))
    files = {".".join(path.relative_to(ROOT).with_suffix("").parts) for path in tests if path.name.startswith("test_")}
    suspects = [path for path in tests if IMPORTS_OF_TESTS.search(path.read_text(encoding="utf-8"))]
    found = [
        (str(path.relative_to(ROOT)), node.module)
        for path in suspects
        for node in nodes_of(path)
        if isinstance(node, ast.ImportFrom)
        and files & {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
    ]
    assert len(files) > 100 and found == []


def test_no_test_asserts_a_time():
    """Machines are shared: a clock in an assertion fails where nothing is wrong. Hangs are ended by pytest-timeout."""
    clocked = re.compile(r"assert [^\n]*\b(process_time|perf_counter|monotonic|time\.time)\(")
    waiting = ROOT / "tests" / "maviper" / "reproduction" / "test_dask.py"  # for workers, with an end
    tests = [path for path in (ROOT / "tests").rglob("test_*.py") if path not in (waiting, Path(__file__))]
    assert len(tests) > 100 and not [str(path) for path in tests if clocked.search(path.read_text())]


def test_every_room_is_in_the_wheel():
    """An editable installation finds a room that the list of packages forgot; a wheel does not hold it."""
    listed = set(tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]["packages"])
    rooms = {
        path.parent for package in ("codegen", "verify", "maviper") for path in (ROOT / package).rglob("__init__.py")
    }
    assert listed - {"codegen.templates"} == {".".join(room.relative_to(ROOT).parts) for room in rooms}
