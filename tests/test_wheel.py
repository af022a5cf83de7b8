"""The wheel: built from a clean copy, installed with run-time dependencies only, used from another folder."""

import os
import shutil
import subprocess
import sys
import venv
import zipfile
from pathlib import Path

import pytest

import maviper
from maviper.experts import network

ROOT = Path(__file__).parent.parent
pytestmark = pytest.mark.slow
PARTS = ("codegen", "maviper", "verify", "templates", "pyproject.toml", "README.md", "LICENSE")


def pip(python, *arguments, cwd):
    command = [str(python), "-m", "pip", "--disable-pip-version-check", "-q", *map(str, arguments)]
    done = subprocess.run(command, cwd=cwd, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    place = tmp_path_factory.mktemp("source")
    for part in PARTS:
        source = ROOT / part
        ignore = shutil.ignore_patterns("__pycache__")
        shutil.copytree(source, place / part, ignore=ignore) if source.is_dir() else shutil.copy(source, place / part)
    pip(sys.executable, "wheel", "--no-deps", "-w", place / "dist", ".", cwd=place)
    return next((place / "dist").glob("*.whl"))


def test_top_level_names_are_exactly_three(wheel):
    names = {name.split("/")[0] for name in zipfile.ZipFile(wheel).namelist()}
    assert {name for name in names if not name.endswith(".dist-info")} == {"codegen", "maviper", "verify"}


def test_templates_experts_and_manual_are_inside_and_nothing_else(wheel):
    names = zipfile.ZipFile(wheel).namelist()
    templates = {str(path.relative_to(ROOT / "templates")) for path in (ROOT / "templates").glob("*/*.*")}
    place = "codegen/templates/"
    assert {name.removeprefix(place) for name in names if name.startswith(place)} - {"__init__.py"} == templates
    place = "maviper/experts/shipped/"
    best = {network.file_of(stem, seed) for stem, _, seed in network.LEARNED.values()}
    experts = {name.removeprefix(place) for name in names if name.startswith(place)} - {"__init__.py"}
    assert experts == best | {name.replace(".safetensors", ".json") for name in best}
    assert "maviper/reproduction/claims.toml" in names
    pages = {path.name for path in (ROOT / "maviper" / "manual").iterdir() if path.suffix in (".md", ".svg")}
    found = {name.removeprefix("maviper/manual/") for name in names if name.startswith("maviper/manual/")}
    assert found == {*pages, "__init__.py"} and len(pages) > 10
    kinds = {Path(name).suffix for name in names if ".dist-info/" not in name}
    known = {".py", ".j2", ".js", ".css", ".safetensors", ".json", ".svg", ".md", ".toml", ".typed"}
    assert kinds - {".so", ".pyd"} == known
    compiled = [name for name in names if name.endswith((".so", ".pyd"))]
    assert len(compiled) <= 1 and all(name.startswith("verify/zones/_zones.") for name in compiled)


def test_it_is_small(wheel):
    assert wheel.stat().st_size <= 4 * 10**6


def test_the_demo_runs_from_another_folder(wheel, tmp_path):
    venv.create(tmp_path / "fresh", with_pip=True)
    python = tmp_path / "fresh" / "bin" / "python"
    pip(python, "install", "-c", ROOT / "constraints.txt", wheel, cwd=tmp_path)
    installed = subprocess.run([python, "-m", "pip", "list"], capture_output=True, text=True, check=True).stdout.lower()
    for absent in ("torch", "pytest", "hypothesis", "ruff", "pyright"):
        assert f"\n{absent} " not in installed
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    command = [tmp_path / "fresh" / "bin" / "maviper", "demo", "-o", "tour"]
    environment = {"PATH": "/usr/bin:/bin"}
    done = subprocess.run(command, cwd=elsewhere, capture_output=True, text=True, check=False, env=environment)
    assert done.returncode == 0, done.stderr
    assert sorted(path.name for path in elsewhere.iterdir()) == ["tour"]
    committed = ROOT / "generated" / "physical_deception" / "physical_deception.py"
    assert (elsewhere / "tour" / "physical_deception.py").exists() and committed.exists()
    command = [tmp_path / "fresh" / "bin" / "maviper", "evaluate", "predator-prey@maddpg", "--episodes", "100"]
    done = subprocess.run(command, cwd=elsewhere, capture_output=True, text=True, check=False, env=environment)
    assert done.returncode == 2 and network.REPOSITORY in done.stderr  # says where it lies
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False, env=environment)
    assert done.returncode == 0, done.stderr  # in a clone it is found by name


@pytest.mark.timeout(1200)
def test_pipx_runs_it_from_an_empty_folder(wheel, tmp_path):
    """As `pipx run maviper` does once an index has the name."""
    venv.create(tmp_path / "tools", with_pip=True)
    python = tmp_path / "tools" / "bin" / "python"
    pip(python, "install", "pipx", cwd=tmp_path)
    empty = tmp_path / "empty"
    empty.mkdir()
    pins = f"--no-compile -c '{ROOT / 'constraints.txt'}'"
    command = [python, "-m", "pipx", "run", "--spec", wheel, "--pip-args", pins, "maviper", "--version"]
    homes = {name: str(tmp_path / name.lower()) for name in ("PIPX_HOME", "PIPX_BIN_DIR", "XDG_CACHE_HOME")}
    done = subprocess.run(command, cwd=empty, capture_output=True, text=True, check=False, env={**os.environ, **homes})
    assert done.returncode == 0, done.stderr
    assert done.stdout == f"maviper, version {maviper.__version__}\n" and not list(empty.iterdir())
