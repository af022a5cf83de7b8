"""The manual's pages on the code follow from it: python.md from signatures, architecture.md from the contracts."""

import ast
import builtins
import re
import tomllib
from pathlib import Path

import pytest

import maviper
from maviper import answers, manual, profiles
from tests.support import python_page

ROOT = Path(__file__).parent.parent.parent
MARK = "<!-- below: written by the tests -->\n"


def rooms(package):
    """The rooms of a package from the top floor to the bottom, each with what its own text says that it is."""
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]["contracts"]
    (floors,) = [each["layers"] for each in contracts if each.get("containers") == [package]]
    for floor in floors:
        for room in (each.strip() for each in floor.split("|")):
            place = ROOT / package / room
            text = (place / "__init__.py" if place.is_dir() else place.with_suffix(".py")).read_text()
            yield f"{room}/" if place.is_dir() else room, ast.get_docstring(ast.parse(text)).split("\n")[0]


def plan():
    """All rooms, a list for each package."""
    parts = []
    for package in ("maviper", "verify", "codegen"):
        lines = [python_page.bullet(f"`{room}`: {what}") for room, what in rooms(package)]
        parts.append(f"### {package}/, from the top floor down\n\n" + "\n".join(lines) + "\n")
    return "\n".join(parts)


@pytest.mark.parametrize(("topic", "made"), [("python", python_page.page), ("architecture", plan)])
def test_the_page_follows_from_the_code(golden, topic, made):
    written = manual.page(topic).partition(MARK)[0]
    golden("maviper/manual", {f"{topic}.md": f"{written}{MARK}\n{made()}"})


def test_every_public_function_and_claim_has_its_section():
    text = manual.page("python")
    assert all(f"\n### {name}\n" in text for name in maviper.__all__)
    assert all(f"\n### {each.__name__}\n" in text for _, classes in python_page.GROUPS.values() for each in classes)


def test_what_functions_return_and_raise_has_a_name_under_maviper():
    """And the page's text, which speaks of errors, names none that there is not."""
    known = {*vars(answers), *vars(profiles), *vars(builtins), "Any", "AnyResult"}
    for name in maviper.__all__:
        verb = getattr(maviper, name)
        assert set(re.findall(r"\w+", verb.__annotations__["return"])) <= known, name
        assert set(re.findall(r"\b\w+Error\b", verb.__doc__)) <= {*vars(maviper.errors), "ImportError"}, name
    modules = (maviper.claims, maviper.errors, answers, profiles)
    shown = {each for module in modules for each in python_page.classes(module)}
    assert {each for _, classes in python_page.GROUPS.values() for each in classes} == shown
