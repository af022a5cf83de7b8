"""House rules, as tests: imports along the arrows, style, types, sizes, module headers, the public surface."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
PACKAGES = ("codegen", "maviper", "verify")
MODULES = sorted(path for package in PACKAGES for path in (ROOT / package).rglob("*.py"))
MOST_MODULE_LINES, MOST_FUNCTION_LINES, MOST_TEMPLATE_LINES = 400, 55, 150


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
    assert len(source.splitlines()) <= MOST_MODULE_LINES
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef):
            length = (node.end_lineno or 0) - node.lineno + 1
            assert length <= MOST_FUNCTION_LINES, f"{node.name}: {length} lines"


def test_templates_are_small():
    for path in (ROOT / "templates").rglob("*.j2"):
        assert len(path.read_text().splitlines()) <= MOST_TEMPLATE_LINES, path


def test_the_ir_is_read_in_five_minutes():
    assert len((ROOT / "codegen" / "ir.py").read_text().splitlines()) <= 260


def test_public_surface():
    import maviper

    assert maviper.__all__ == sorted(maviper.__all__)
    public = {name for name, value in vars(maviper).items() if callable(value) and not name.startswith("_")}
    assert public == set(maviper.__all__)


def test_help_and_import_load_nothing_heavy():
    code = (
        "import sys; from maviper import cli; cli.run(['--help']);"
        "heavy = {'numpy', 'torch', 'sklearn', 'scipy', 'z3', 'mpe2', 'pygame', 'rich', 'jinja2', 'msgspec'};"
        "print(sorted(heavy & set(sys.modules)), file=sys.stderr)"
    )
    found = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert found.stderr.strip() == "[]"


def test_nothing_committed_is_a_pickle_or_names_a_machine():
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=False)
    if listed.returncode != 0:
        pytest.skip("not a git checkout")
    for name in listed.stdout.split():
        path = ROOT / name
        assert path.suffix not in {".pkl", ".pickle", ".pt", ".pth", ".joblib"}, name
        if path.suffix in {".py", ".md", ".toml", ".txt", ".j2", ".json", ".h"} and path.exists():
            text = path.read_text()
            for word in ("/" + "work/", "index" + "-url", "/" + "root/"):
                assert word not in text, (name, word)
