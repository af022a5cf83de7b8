"""JavaScript, Rust, SMT-LIB and pictures: they agree with the trees; names that would meet are refused."""

import re
import shutil
from dataclasses import replace
from itertools import pairwise
from xml.etree import ElementTree

import pytest
from hypothesis import given, settings

from codegen.agreement import selfcheck
from codegen.agreement.compiled import build
from codegen.errors import InputError
from codegen.lowering import names
from codegen.lowering.lower import lower
from codegen.targets import emit
from codegen.targets.rendered import harness
from maviper.compilation import compile
from tests.support.chains import chain, renamed
from tests.support.games import NAMES, random_profile
from tests.support.strategies import profiles

FEW = 1_000  # random observations; the boundary ones are what counts

MORE = ("javascript", "rust", "smt", "svg")


@pytest.mark.compile
@settings(max_examples=3)
@given(profiles())
@pytest.mark.usefixtures("unoptimised")
def test_further_targets_agree_on_random_profiles(profile):
    report = selfcheck.check_files(profile, emit(profile, MORE), random=FEW).ensure()
    missing = {tool for tool in ("node", "rustc") if shutil.which(tool) is None}
    assert len(report.skipped) == len(missing)
    assert {item.target for item in report.agreements} >= {"svg"}


@pytest.mark.solver
@pytest.mark.parametrize("name", NAMES)
def test_a_solver_finds_the_functions_to_be_the_trees(name):
    profile = random_profile(name)
    found = compile.ask_solver(build(profile, ["smt"]))
    assert [item.agent for item in found] == [policy.agent for policy in profile.agents]
    assert not any(item.differences for item in found) and min(item.observations for item in found) > 100


def test_a_picture_has_room_for_its_leaves(profile):
    for text in emit(profile, ["svg"]).values():
        root = ElementTree.fromstring(text)
        boxes = [rect.attrib for rect in root.iter("{http://www.w3.org/2000/svg}rect") if rect.attrib["width"] == "60"]
        places = sorted(float(box["x"]) for box in boxes)
        assert len(boxes) > 1 and min(b - a for a, b in pairwise(places)) >= 60
    wide = tuple(replace(policy, tree=chain(3_000), grown=None) for policy in profile.agents)
    with pytest.raises(InputError, match="at most 4096"):
        emit(replace(profile, agents=wide), ["svg"])


def test_a_missing_tool_is_said(profile, monkeypatch):
    files = emit(profile, ["javascript", "rust"])
    monkeypatch.setattr(shutil, "which", lambda name: None)
    report = selfcheck.check_files(profile, files, random=FEW)
    assert report.skipped == ("mjs: node is not installed", "rs: rustc is not installed") and not report.agreements


@pytest.mark.parametrize(
    ("first", "second"), [("a", "a_rows"), ("a", "a_batch"), ("a", "world_a"), ("b", "team"), ("b", "all")]
)
def test_agents_whose_functions_would_meet_are_refused(profile, first, second):
    with pytest.raises(InputError, match="same name"):
        lower(renamed(profile, first, second))


DEFINED = {
    "h": r"^static inline \w+ (\w+)\(|^#define (\w+)|^    (\w+) = \d+,?(?: /\*.*)?$",
    "harness": r"^void (\w+)\(",
    "py": r"^(?:def|class) ([a-zA-Z]\w+)\(",
    "mjs": r"^export function (\w+)\(",
}


@pytest.mark.parametrize("style", ["nested", "ordered", "freestanding", "walk"])
def test_all_names_in_code_are_of_the_list(profile, style):
    model = lower(profile, style=style)
    listed = {name for agent in model.agents for name in names._iterate_names(agent.names)} | set(
        names._iterate_names(model.names)
    )
    modules = {*names.of_modules(agent.lower for agent in model.agents), *names.TEAM_FUNCTIONS}
    files = emit(profile, ["c", "python", "javascript"], style=style)
    texts = {name.rpartition(".")[2]: text for name, text in files.items()} | {"harness": harness(model, "c")}
    for ending, pattern in DEFINED.items():
        found = {next(filter(None, match.groups())) for match in re.finditer(pattern, texts[ending], re.MULTILINE)}
        assert len(found) >= len(model.agents) and found <= (listed if ending in ("h", "harness") else modules), ending
