"""The page that maps the paper to the code: complete, and nothing that it names is missing."""

import ast
import re
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "generated" / "reproduction" / "pseudocode.md").read_text()
LINES = {"Algorithm 1: IVIPER": 9, "Algorithm 2: MAVIPER": 26, "Algorithm 3: VIPER": 8}  # of the paper's listings
PLACES = re.findall(r"`([\w/]+\.py): ([\w.]+)`", re.sub(r"\s+", " ", PAGE))


@cache
def names(path):
    """Functions and classes of a file, methods as `Class.method`."""
    found = set()
    for node in ast.parse((ROOT / path).read_text()).body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            found.add(node.name)
        if isinstance(node, ast.ClassDef):
            found |= {f"{node.name}.{each.name}" for each in node.body if isinstance(each, ast.FunctionDef)}
    return found


@pytest.mark.parametrize(("path", "name"), sorted(set(PLACES)))
def test_what_is_named_is_there(path, name):
    assert name in names(path)


@pytest.mark.parametrize(("title", "count"), LINES.items())
def test_every_line_of_the_pseudocode_has_an_entry(title, count):
    part = PAGE.split(f"## {title}\n")[1].split("\n## ")[0]
    assert [int(number) for number in re.findall(r"^- \*\*Line (\d+)\*\*", part, re.MULTILINE)] == [
        *range(1, count + 1)
    ]
    entries = re.split(r"^- ", part, flags=re.MULTILINE)[1:]
    assert all("`maviper/" in entry or "a comment" in entry for entry in entries)


def test_every_equation_has_an_entry():
    assert re.findall(r"\*\*Equation (\d)\*\*", PAGE) == list("12345")
    assert len(PLACES) >= 45
