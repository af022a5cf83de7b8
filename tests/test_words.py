"""Words that sources, templates and manual do not say any more: phrases that readers stumbled over, and their kind."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
PLACES = ("codegen", "maviper", "verify", "templates")
TEXTS = {
    path.relative_to(ROOT).as_posix(): path.read_text(encoding="utf-8")
    for place in PLACES
    for path in sorted((ROOT / place).rglob("*"))
    if path.suffix in {".py", ".md", ".j2", ".js", ".toml"}
} | {"README.md": (ROOT / "README.md").read_text(encoding="utf-8")}
GONE = (
    "no gain above the interval",
    "an error of at most e a step",
    "a system that a file states",
    "ended before the proof did",
    "relax every bound of the claim",
    "not the only one: ",
    "names are known, none of them",
    "meanings: none that",
    "no state is claimed anything of",
    "An episode that may get there is no proof",
    "says nothing of later steps than it names",
    "That anything else moves like it",
    "zones are left in which the claim may fail",
    "code of somebody's own",
    "an environment of somebody's own",
    "a profile that is none of this world's",
    "a Ctrl-C in an odd place",
    "VIOLATED is what one hopes for",
    "everybody else being at the expert",
    "world's file",
    "could have been seen",
    "are against it",
    "something stands outside a function",
    "no world of this version has",
)
COUNTED = (
    "bits|bytes|comparisons|cores|decisions|entries|episodes|milliseconds|nodes|numbers|observations|points|"
    "queries|rounds|rows|samples|seconds|steps|tests|trees|units|us|ms"
)
UNITS = (
    "agent|axis|branch|cell|checkpoint|claim|core|decision|episode|feature|game|goal|iteration|landmark|leaf|level|"
    "node|observation|process|property|query|question|round|row|run|sample|second|seed|state|step|task|team|tree|worker"
)
PER = re.compile(rf"\b(?:{COUNTED}|one) an? (?:{UNITS})\b(?! (?:at a|after|is|may|has|that|tree))")
MEANT = {  # where "a" is an article: "how many steps an episode has"
    "maviper/manual/reproduce.md",
    "maviper/worlds/outside/pettingzoo.py",
}


@pytest.mark.parametrize("phrase", GONE)
def test_a_phrase_is_not_said_any_more(phrase):
    assert not [name for name, text in TEXTS.items() if phrase in text]


def test_rates_are_said_with_per():
    found = {name: PER.findall(text) for name, text in TEXTS.items() if name not in MEANT}
    assert {name: told for name, told in found.items() if told} == {}


def test_counts_agree_with_their_nouns_by_one_function():
    """`1 leaves` comes from writing the noun beside a count; the singular is the business of `format_count`."""
    written = re.compile(r"len\([a-z_.]+\)(?::,)?\} (?:agents|branches|claims|guards|cells|leaves)\b")
    allowed = {"verify/claims/language/tables.py", "maviper/page/games.py"}  # more than one: the code beside says so
    found = {name: written.findall(text) for name, text in TEXTS.items() if name not in allowed}
    assert {name: told for name, told in found.items() if told} == {}
