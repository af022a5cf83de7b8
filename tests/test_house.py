"""House rules, as tests: imports along the arrows, style, types, sizes, module headers, the public surface."""

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.test_imports import ASIDE, HEAVY

ROOT = Path(__file__).parent.parent
PACKAGES = ("codegen", "maviper", "verify")
MODULES = sorted(path for package in PACKAGES for path in (ROOT / package).rglob("*.py"))
MAX_MODULE_LINES, MAX_FUNCTION_LINES, MAX_TEMPLATE_LINES = 400, 55, 150
MANY_PARAMETERS, MAX_WITH_MANY = 7, 11  # so many functions may have seven or more, self and cls aside
VERBS = Path("maviper/__init__.py")  # whose parameters are the options of a command, in words
MAX_MODULES_IN_A_FOLDER, MAX_README_LINES = 15, 120
MAX_KINDS_ASKED = 26  # places that ask whether a claim or result is about decisions, leaves or episodes


def tool(*command):
    found = subprocess.run([sys.executable, "-m", *command], cwd=ROOT, capture_output=True, text=True, check=False)
    assert found.returncode == 0, found.stdout + found.stderr


def test_ruff():
    tool("ruff", "check", ".")
    tool("ruff", "format", "--check", ".")


def test_imports_follow_the_arrows():
    found = subprocess.run(
        [str(Path(sys.executable).parent / "lint-imports")], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert found.returncode == 0, found.stdout


@pytest.mark.slow
def test_types():
    tool("pyright", "--pythonpath", sys.executable)


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(ROOT)))
def test_module_header_and_sizes(path):
    source = path.read_text()
    tree = ast.parse(source)
    header = ast.get_docstring(tree) or ""
    assert "\nDoes:" in header and "\nAssumes:" in header and "\nDoes not:" in header
    assert len(source.splitlines()) <= MAX_MODULE_LINES
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef):
            length = (node.end_lineno or 0) - node.lineno + 1
            assert length <= MAX_FUNCTION_LINES, f"{node.name}: {length} lines"


def parameters(function):
    """The names of a function's parameters, without the one that it is bound to."""
    given = function.args
    names = [one.arg for one in (*given.posonlyargs, *given.args, *given.kwonlyargs)]
    return names[1:] if names[:1] in (["self"], ["cls"]) else names


def test_few_functions_take_many_parameters():
    kinds = ast.FunctionDef | ast.AsyncFunctionDef
    functions = [
        (path.relative_to(ROOT), node)
        for path in MODULES
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, kinds)
    ]
    many = [
        f"{path}: {node.name}" for path, node in functions if len(parameters(node)) >= MANY_PARAMETERS and path != VERBS
    ]
    assert len(functions) > 1_000 and len(many) <= MAX_WITH_MANY, many


def test_goals_are_gone_through_one_by_one_in_one_place():
    places = [path for path in MODULES for line in path.read_text().splitlines() if "or (None,)" in line]
    assert places == [ROOT / "verify" / "claims" / "region.py"]


def test_no_goal_is_none():
    """That a world has no goal is "" in files only: `goal_text` and `goal_of` stand between."""
    empty = re.compile(r"""or \(""[,)]|goal(: str)? ?(=|==|!=|in|not in) ?\(?""|goal or \"\"$""", re.MULTILINE)
    always = re.compile(r"goal: str(?! \|)")  # of a file, as its text
    found = {path.relative_to(ROOT).as_posix(): path.read_text() for path in MODULES}
    assert {path for path, text in found.items() if empty.search(text)} == {"verify/claims/region.py"}
    assert len(empty.findall(found["verify/claims/region.py"])) == 1
    assert {path for path, text in found.items() if always.search(text)} == {
        "maviper/verification/counterexamples.py",
        "maviper/verification/episode_files.py",
        "verify/checker/episode_certificates.py",
    }


def test_what_a_claim_is_stands_in_its_class():
    """Names and classes of claims and results are not asked about one by one; what they are about is, at the rim."""
    claims = "AnyClaim|DecisionClaim|EpisodeClaim|Arrival|Result|EpisodeResult"
    asked = re.compile(rf"claim\.name (==|!=|in|not in)|isinstance\([\w.]+, *\(?({claims})\b")
    about = re.compile(r"kind is (not )?Kind\.")
    texts = {path.relative_to(ROOT).as_posix(): path.read_text() for path in MODULES}
    assert [path for path, text in texts.items() for _ in asked.finditer(text)] == []
    assert 0 < sum(len(about.findall(text)) for text in texts.values()) <= MAX_KINDS_ASKED


def test_a_folder_is_taken_in_at_a_glance():
    folders = {path.parent for path in MODULES}
    sizes = {
        folder: sum(path.parent == folder and path.name != "__init__.py" for path in MODULES) for folder in folders
    }
    crowded = {str(folder.relative_to(ROOT)): size for folder, size in sizes.items() if size > MAX_MODULES_IN_A_FOLDER}
    assert len(folders) > 20 and crowded.keys() <= {"maviper/cli"}, crowded  # one file a command


def test_the_readme_is_short():
    assert len((ROOT / "README.md").read_text().splitlines()) <= MAX_README_LINES


def test_templates_are_small():
    for path in (ROOT / "templates").rglob("*.j2"):
        assert len(path.read_text().splitlines()) <= MAX_TEMPLATE_LINES, path


def test_the_ir_is_read_in_five_minutes():
    assert len((ROOT / "codegen" / "ir.py").read_text().splitlines()) <= 270


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
    others = {"maviper.experts", "verify.reach", "verify.systems"}
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


def test_ci_asks_each_file_for_tests_that_it_has():
    """pytest ends with 5, and CI with it, where a file's only tests are among those left out without `-m`."""
    asked = re.findall(r"pytest (.*?)(tests/\S+\.py)", (ROOT / ".ci" / "run").read_text())
    assert asked
    for options, name in asked:
        mark = re.search(r"-m (\w+)", options)
        whole_file = "pytestmark = pytest.mark." + (mark.group(1) if mark else "")
        assert ("pytestmark" in (ROOT / name).read_text()) == (mark is not None), name
        assert mark is None or whole_file in (ROOT / name).read_text(), name


OLD_WORDS = {  # where each word is not to stand any more, and what is said instead
    "start box": ((*PACKAGES, "templates"), "start region"),
    "MOST_": ((*PACKAGES, "templates"), "MAX_"),
    "agreement": (("maviper/extraction", "maviper/experts", "maviper/evaluation", "maviper/episodes"), "fidelity"),
    "agrees with the expert": (PACKAGES, "fidelity"),
}
KEPT = {("maviper/evaluation/fidelity.py", "agreement")}  # a key of files that are committed


def test_one_concept_has_one_word():
    found = [
        (str(path.relative_to(ROOT)), word, f"say {instead}")
        for word, (folders, instead) in OLD_WORDS.items()
        for folder in folders
        for path in sorted((ROOT / folder).rglob("*"))
        if path.suffix in {".py", ".c", ".md", ".j2"} and word in path.read_text()
    ]
    assert [entry for entry in found if entry[:2] not in KEPT] == []
