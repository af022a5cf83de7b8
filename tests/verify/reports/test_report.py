"""What a reader meets in a report: lines of C, where two come too near, sentences that fit the claim, short numbers."""

import re
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from codegen import ir
from codegen.lowering.render import exact, render
from codegen.profiles import loads
from codegen.targets import emit
from maviper.verification.run import verify_claims
from tests.hunting.teams import bare
from tests.support.observations import blind
from tests.support.teams import STAY, UP, team, towards
from tests.support.teams import tree as tree_of
from verify.claims.catalogue import find_claim
from verify.claims.decisions import DistinctTargets
from verify.claims.files import read_properties
from verify.claims.formula import Acts, Linear, Not, disjunction
from verify.claims.observed import View
from verify.claims.region_files import everywhere
from verify.claims.views import Viewed
from verify.claims.wording import OwnFormula
from verify.question import Question
from verify.reports import report
from verify.reports.code import code_of
from verify.reports.report import as_lines, result_facts
from verify.states.shares import SAMPLE_SEED, measure
from verify.subjects import Game
from verify.verdicts.decisions import verify

GENERATED = Path(__file__).parents[3] / "generated"
LONG = re.compile(r"\d\.\d{18,}")


def committed(name):
    return loads((GENERATED / name / "profile.json").read_bytes())


@pytest.mark.parametrize("name", ["physical_deception", "verdicts/predator_prey"])
def test_lines_of_code_are_those_of_the_header(name):
    profile = committed(name)
    file, header = next((file, text) for file, text in emit(profile, ["c"]).items() if file.endswith(".h"))
    lines = header.split("\n")
    for policy in profile.agents:
        tree = policy.tree
        found = code_of(profile, policy.agent, range(len(tree.feature)))
        assert found["file"] == file
        begins = next(n for n, line in enumerate(lines, 1) if line.endswith(f"_{policy.agent}_act(const float *x)"))
        for node, line in enumerate(found["lines"]):
            assert lines[line["number"] - 1].strip() == line["text"] and line["number"] > begins
            if tree.feature[node] == ir.NO_FEATURE:
                action = policy.actions[tree.action[node]].name.upper()
                assert line["text"].startswith("return") and line["text"].endswith(f"_{action}; /* leaf {node} */")
            else:
                assert line["text"].startswith("if (") and f"node {node}:" in line["text"]


def test_code_that_is_a_walk_over_tables_has_no_lines(profile):
    levels = 102  # more than the nested style has; each split's left side is a leaf
    nodes = [one for level in range(levels) for one in ((2, float(level), 2 * level + 1, 2 * level + 2), STAY)]
    tree = tree_of(*nodes, UP)
    assert code_of(team(profile, tree, tree), "agent_0", [0]) is None


def test_a_decision_is_told_as_its_path_and_what_is_left_out(profile):
    """Each test of the path has the other side's leaves beside it; together with the path's own they are all."""
    pair = team(profile, towards(0, 0), towards(0, 1))
    (result,) = verify_claims([Question(Game(pair), DistinctTargets("defenders"), everywhere(pair))])
    facts = report.document(pair, [result], ["again"])
    agents = facts["results"][0]["counterexample"]["agents"]
    for agent in agents:
        leaves = pair.policy(agent["agent"]).tree.feature.tolist().count(ir.NO_FEATURE)
        assert sum(step["others"] for step in agent["path"]) + 1 == leaves
    lists = re.findall(r'<ol class="path">(.*?)</ol>', report.as_html(facts), re.DOTALL)
    said = [re.findall(r"leaves (\d+) (?:leaf|leaves) aside", each) for each in lists]
    assert said == [[str(step["others"]) for step in agent["path"]] for agent in agents]


# --- sentences that fit


def test_of_a_claim_that_speaks_of_no_landmark_any_joint_action_counts(profile):
    pair = team(profile, towards(0, 0), towards(1, 1))
    right = Linear(((Fraction(-1), "agent_0.x"),), Fraction(0))  # agent_0.x >= 0
    claim = OwnFormula("defenders", statement=disjunction(right, Not(Acts("agent_0", 1))))
    found = measure(Question(Game(pair), claim, everywhere(pair)), SAMPLE_SEED)
    assert abs(found.conflict.value - 0.5) < 0.01 and found.contested is None
    (result,) = verify_claims([Question(Game(pair), claim, everywhere(pair))])
    facts = report.document(pair, [result], ["again"])
    text, page = report.as_text(facts), report.as_html(facts)
    assert "closes on a landmark" not in text + page
    assert "some joint action violates the claim" in text and "engaged with" not in page


@pytest.mark.smoke
def test_terms_are_explained_once_and_each_claim_has_a_button(profile):
    pair = team(profile, towards(0, 0), towards(0, 1))
    claims = [DistinctTargets("defenders"), DistinctTargets("defenders", margin=Fraction(1, 40))]
    results = verify_claims([Question(Game(pair), claim, everywhere(pair)) for claim in claims])
    page = report.as_html(report.document(pair, results, ["again"] * 2))
    assert page.count("an agent closes on a landmark if") == 1 and page.count("how often does it fail?") == 1
    assert [f'href="play.html#claim-{number}"' in page for number in (1, 2, 3)] == [True, True, False]
    assert page.count("Play this counterexample") == 2
    agents = report.document(pair, results, ["", ""])["results"][0]["counterexample"]["agents"]
    lines = [agent["code"]["lines"][-1]["number"] for agent in agents]
    assert all(f"line {number}</summary>" in page for number in lines)


def test_the_start_region_is_one_line_and_numbers_are_short():
    profile = bare("predator-prey")
    claim = OwnFormula("prey", statement=Not(Acts("agent_0", 1)))
    (result,) = verify_claims([Question(Game(profile), claim, everywhere(profile))])
    facts = report.document(profile, [result], ["again"])
    text = report.as_text(facts)
    assert "every start position" in text and "<= adversary_0.x <=" not in text
    assert not LONG.search(text) and not LONG.search(re.sub(r'title="[^"]*"', "", report.as_html(facts)))
    part = replace(
        everywhere(profile), name="part.toml", differences=(("agent_0.x", "agent_1.x", (Fraction(1, 3),) * 2),)
    )
    (result,) = verify_claims([Question(Game(profile), claim, part)])
    text = report.as_text(report.document(profile, [result], ["again"]))
    assert "<= adversary_0.x <=" in text and not LONG.search(text)


def test_where_two_come_too_near_is_drawn():
    profile = committed("verdicts/predator_prey")
    claim = find_claim("keeps_apart", profile, "prey", others=("adversary_0", "adversary_1"), steps=25)
    (result,) = verify_claims([Question(Game(profile), claim, everywhere(profile))])
    assert result.verdict.value == "VIOLATED"
    drawing = report.document(profile, [result], ["again"])["results"][0]["counterexample"]["picture"]
    near = [way for way in result.evidence.ways if way.nearest < claim.radius]
    assert near and len(drawing["meetings"]) == len(near)
    scale = drawing["size"] / 2
    for meeting, way in zip(drawing["meetings"], near, strict=True):
        gap = max(abs(a - b) for a, b in zip(meeting["from"], meeting["to"], strict=True))
        assert gap < scale * float(claim.radius) + 0.1 and meeting["says"] == f"step {way.step}"


def test_a_terminal_shows_all_digits_of_a_state_that_has_more_than_six():
    position = {"angle": 0.09999999999, "spin": -2.0, "left": "1/3", "far": 2e30}
    found = {"position": position, "agents": [], "replayed_by": ["reference"], "explanation": None}
    text = render("report/lines-counterexample.txt.j2", result={"counterexample": found, "observations": "all"})
    assert text.startswith("at angle 0.09999999999, spin -2, left 1/3, far 2e+30\n")
    assert [exact(number) for number in (0.1, 1e6, 1234567.0, -0.0)] == ["0.1", "1e+06", "1234567.0", "-0"]
    assert exact(np.float64(0.12345678)) == "0.12345678"


def test_a_terminal_shows_what_the_agents_of_the_claim_observe():
    """The report has the numbers of all others."""
    stump = tree_of((0, 0.5, 1, 2), 0, 1)
    viewed = Viewed(blind({"a": stump, "b": stump}), View())
    file = '[[property]]\nformula = "acts(a) == left"\n'
    (stated,) = read_properties(file, viewed.profile, "file", lambda name: pytest.fail(name))
    result = verify(Question(Game(viewed.profile, viewed=viewed), stated.claim, stated.region), {})
    lines = "\n".join(as_lines(viewed.origin, result)[1])
    assert "a.angle" in lines and "b.angle" not in lines and "b takes" not in lines
    assert "b.angle" in result_facts(viewed.origin, result, "")["counterexample"]["position"]
