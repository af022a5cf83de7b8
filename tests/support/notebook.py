"""The page "your own team" as a notebook and as a script: the same text, the same code, in the same order.

Does: parts the page into prose and Python; writes both, `python -m tests.support.notebook` into `generated/team`; fills
  what the page's code prints into the page.
Assumes: blocks of Python make one program; a block without a language, right below one, is what that one prints.
Does not: run anything itself but to fill the page.
"""

import contextlib
import io
import json
import os
import re
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

from maviper import manual

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "generated" / "team"
PAGE = ROOT / "maviper" / "manual" / "team.md"
PYTHON = re.compile(r"```python\n(.*?)\n```\n(?:\n```\n(.*?)```\n)?", flags=re.S)


def cells(page: str) -> Iterator[tuple[str, str]]:
    """The page in parts: ("markdown", text) or ("code", program), in its order."""
    place = 0
    for block in PYTHON.finditer(page):
        yield "markdown", page[place : block.start()].strip()
        yield "code", block[1]
        place = block.end() if block[2] is None else block.start(2) - len("```\n")
    yield "markdown", page[place:].strip()


def printed(page: str) -> str:
    """Everything that the page says its code prints."""
    return "".join(block[2] or "" for block in PYTHON.finditer(page))


def files(page: str) -> dict[str, str]:
    """Notebook and script, by their names."""
    linked = re.sub(r"\]\((\w+\.md)", r"](../../maviper/manual/\1", page)
    parts = [(kind, text) for kind, text in cells(linked) if text]
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    book = {
        "cells": [_cell(number, kind, text) for number, (kind, text) in enumerate(parts)],
        "metadata": {"kernelspec": kernel, "language_info": {"name": "python"}},
        "nbformat": 4,
        "nbformat_minor": 5,
    }
    script = [text if kind == "code" else re.sub(r"^(?=.)", "# ", text, flags=re.M) for kind, text in parts]
    script = [re.sub(r"^$", "#", text, flags=re.M) if text.startswith("# ") else text for text in script]
    return {"team.ipynb": json.dumps(book, indent=1) + "\n", "team.py": "\n\n".join(script) + "\n"}


def _cell(number: int, kind: str, text: str) -> dict[str, object]:
    cell = {"cell_type": kind, "id": f"part-{number}", "metadata": {}, "source": text.splitlines(keepends=True)}
    return cell | ({"execution_count": None, "outputs": []} if kind == "code" else {})


def fill(page: str) -> str:
    """The page with what its code prints here, run in a folder of its own."""
    names: dict[str, object] = {"__name__": "__main__"}

    def run(block: re.Match[str]) -> str:
        out = io.StringIO()
        with contextlib.redirect_stdout(out):
            exec(compile(block[1], "team.md", "exec"), names)
        said = "" if block[2] is None else f"\n```\n{out.getvalue()}```\n"
        return f"```python\n{block[1]}\n```\n{said}"

    before = Path.cwd()
    with TemporaryDirectory() as folder:
        os.chdir(folder)
        try:
            return PYTHON.sub(run, page)
        finally:
            os.chdir(before)


if __name__ == "__main__":
    PAGE.write_text(fill(manual.page("team")), encoding="utf-8")
    FOLDER.mkdir(exist_ok=True)
    for name, text in files(manual.page("team")).items():
        (FOLDER / name).write_text(text, encoding="utf-8")
