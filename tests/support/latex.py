"""LaTeX as pdflatex typesets it, where that is installed."""

import shutil
import subprocess

import pytest


def typeset(text, package, folder):
    """Skips where there is no pdflatex; an AssertionError shows what it says of a text that it does not take."""
    if shutil.which("pdflatex") is None:
        pytest.skip("pdflatex is not installed")
    whole = f"\\documentclass{{article}}\\usepackage{{{package}}}\\begin{{document}}{text}\\end{{document}}"
    (folder / "page.tex").write_text(whole)
    command = ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "page.tex"]
    ran = subprocess.run(command, cwd=folder, capture_output=True, text=True, errors="replace", check=False)
    assert ran.returncode == 0, ran.stdout[-2_000:]
    assert (folder / "page.pdf").read_bytes().startswith(b"%PDF")
