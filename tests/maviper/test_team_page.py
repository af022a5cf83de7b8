"""The page "your own team": its code prints what stands there; notebook and script beside it say and do the same."""

import subprocess
import sys

import pytest

from maviper import manual
from tests.support import notebook

PAGE = manual.page("team")


def test_notebook_and_script_are_made_from_the_page(golden):
    golden("generated/team", notebook.files(PAGE))


def test_the_script_is_the_pages_code_in_its_order():
    script = notebook.files(PAGE)["team.py"]
    code = [text for kind, text in notebook.cells(PAGE) if kind == "code"]
    assert len(code) >= 7 and notebook.printed(PAGE)
    kept = [line for line in script.splitlines() if line and not line.startswith("#")]
    assert kept == [line for each in code for line in each.splitlines() if line]


def test_the_notebook_is_one_and_has_no_outputs():
    nbformat = pytest.importorskip("nbformat")
    book = nbformat.reads(notebook.files(PAGE)["team.ipynb"], as_version=4)
    nbformat.validate(book)
    assert not any(cell.outputs for cell in book.cells if cell.cell_type == "code")


@pytest.mark.slow
@pytest.mark.compile
@pytest.mark.solver
def test_the_script_prints_what_the_page_says(tmp_path):
    script = notebook.FOLDER / "team.py"
    ran = subprocess.run([sys.executable, str(script)], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert ran.stdout == notebook.printed(PAGE)


UNGUARDED = """
import maviper
from maviper.worlds.outside import processes
from mygame import act, make

processes.cores = lambda: 2
maviper.extract(act, world=make, max_depth=2, max_episodes=60)
"""


def test_a_script_without_a_guard_ends_in_one_error(tmp_path):
    """Its copies' processes import it again: each printed a traceback and the lecture of multiprocessing."""
    code = next(text for kind, text in notebook.cells(PAGE) if kind == "code")
    (tmp_path / "mygame.py").write_text(code)
    (tmp_path / "play.py").write_text(UNGUARDED)
    ran = subprocess.run([sys.executable, "play.py"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert ran.returncode == 1 and ran.stderr.count("Traceback") == 1 and "bootstrapping" not in ran.stderr
    what, where, advice = ran.stderr.splitlines()[-3:]
    assert "copies of mygame:make play in processes" in what and where.endswith("play.py")
    assert "write `if __name__ == '__main__':`" in advice
    (tmp_path / "play.py").write_text("if __name__ == '__main__':\n" + UNGUARDED.replace("\n", "\n    "))
    subprocess.run([sys.executable, "play.py"], cwd=tmp_path, check=True)


RUN = """
import sys
import nbformat
from nbclient import NotebookClient

book = nbformat.read(sys.argv[1], as_version=4)
NotebookClient(book, timeout=300, kernel_name="python3").execute()
for cell in book.cells:
    for output in cell.get("outputs", ()):
        if output.get("name") == "stdout":
            print(output["text"], end="")
"""


@pytest.mark.slow
@pytest.mark.compile
@pytest.mark.solver
def test_the_notebook_prints_what_the_page_says(tmp_path):
    pytest.importorskip("nbclient")
    pytest.importorskip("ipykernel")
    command = [sys.executable, "-c", RUN, str(notebook.FOLDER / "team.ipynb")]
    ran = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr[-2_000:]
    assert ran.stdout == notebook.printed(PAGE)
