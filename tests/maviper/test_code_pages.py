"""The manual's pages on the code hold of it: architecture.md has every module, what functions name there is."""

import builtins
import importlib
import re
from pathlib import Path

import pytest

import maviper
from maviper import answers, manual, profiles

ROOT = Path(__file__).parent.parent.parent


def rooms():
    """The rooms of the architecture page: name, packages and entry function."""
    for text in re.split(r"^### \d+\. ", manual.page("architecture"), flags=re.MULTILINE)[1:]:
        places, _, entry = text.partition("\nIn: ")[2].partition("Enter at:")
        yield text.split("\n")[0], re.findall(r"`([\w.]+)`", places), re.search(r"`([\w.]+)`", entry)[1]


def test_each_module_is_in_one_of_twelve_rooms():
    """A package of the page holds what is below it, but for what a longer name there holds."""
    listed = [place for _, places, _ in rooms() for place in places]
    assert len(list(rooms())) == 12 and len(set(listed)) == len(listed)
    for package in ("codegen", "maviper", "verify"):
        inside = [each.name for each in (ROOT / package).iterdir() if (each / "__init__.py").exists()]
        assert sorted([package, *(f"{package}.{name}" for name in inside)]) == sorted(
            place for place in listed if place.partition(".")[0] == package
        )


@pytest.mark.parametrize("entry", [entry for _, _, entry in rooms()])
def test_each_room_has_the_function_that_it_is_entered_by(entry):
    module, _, name = entry.rpartition(".")
    assert callable(getattr(importlib.import_module(module), name))


def test_the_examples_of_the_rooms_run_in_their_order(monkeypatch):
    monkeypatch.chdir(ROOT)
    known = {}
    for example in re.findall(r"```python\n(.*?)```", manual.page("architecture"), re.DOTALL):
        exec(compile(example, "architecture.md", "exec"), known)
    assert known["result"].verdict == known["results"][0].verdict == "PROVED"
    assert known["closed"] > 0 and len(known["thermostat"].agents) == 1 and "physical_deception" in known["header"]


def test_what_functions_return_and_raise_has_a_name_under_maviper():
    """And texts, which speak of errors, name none that there is not."""
    known = {*vars(answers), *vars(profiles), *vars(builtins), "Any", "AnyResult"}
    for name in maviper.__all__:
        verb = getattr(maviper, name)
        assert set(re.findall(r"\w+", verb.__annotations__["return"])) <= known, name
        assert set(re.findall(r"\b\w+Error\b", verb.__doc__)) <= {*vars(maviper.errors), "ImportError"}, name
