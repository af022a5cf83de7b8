"""A further kind of claim: an entry in each of four tables, and no function outside it asks for it."""

from dataclasses import dataclass, field

import pytest
from click.testing import CliRunner
from jinja2 import ChoiceLoader, DictLoader

from codegen.lowering import render
from codegen.policy_json import dumps
from maviper.cli.main import cli
from maviper.page.page import page_of
from maviper.verification import ask, run
from maviper.verification.run import Procedure, pose_questions, verify_questions
from tests.support.small import small_profile
from verify.claims import catalogue
from verify.claims.claim import TeamClaim
from verify.claims.wording import region_document
from verify.reports import report
from verify.reports.report import as_lines
from verify.reports.telling import Telling
from verify.result import Cost, Evidence, Result, Verdict

KIND = "names"  # of a claim about what agents are called
TEMPLATES = {
    f"report/{KIND}.txt.j2": "   longest    {{ result.longest }}\n",
    f"report/lines-{KIND}.txt.j2": "longest {{ result.longest }}\n",
}


@dataclass(frozen=True)
class ShortNames(TeamClaim):
    """That no agent of the team has a name longer than `steps` letters."""

    kind = KIND
    limits = ()
    name = "short_names"
    sentence = "no name is long"

    steps: int = 7
    label: str = field(default="", compare=False, kw_only=True)

    @property
    def parameters(self):
        return {"steps": self.steps}


def longest(question):
    return max(len(policy.agent) for policy in question.profile.team(question.claim.team))


def answer(question, _bench, _region_file):
    holds = longest(question) <= question.claim.steps
    verdict = Verdict.PROVED if holds else Verdict.VIOLATED
    return Result(question, verdict, "", Evidence(), Cost(1, 1, "looks"))


def verdict(question, bench):
    return answer(question, bench, None).verdict, ""


def facts(_profile, result, command):
    return {
        "kind": KIND,
        "property": result.claim.name,
        "label": "",
        "team": result.claim.team,
        "claim": result.claim.sentence,
        "formula": "",
        "assumption": "",
        "parameters": result.claim.parameters,
        "semantics": result.semantics,
        "region_name": result.region.name,
        "region": region_document(result.region),
        "verdict": result.verdict.value,
        "meaning": "as counted",
        "reason": result.reason,
        "longest": longest(result.question),
        "certificate": None,
        "counterexample": None,
        "command": command,
    }


@pytest.fixture(name="registered")
def _registered(monkeypatch):
    """The kind in its four tables, with templates of its own."""
    found = catalogue.Family(
        names=("short_names",),
        find=lambda _name, profile, team, **given: ShortNames(team or profile.agents[1].team, **given),
        reads=lambda _name, _of="": ("steps",),
        usual=lambda _name: {"steps": 7},
        in_general=lambda _name: "no name is long",
    )
    monkeypatch.setattr(catalogue, "FAMILIES", [*catalogue.FAMILIES, found])
    telling = Telling(facts, lambda _profile, _results: ["Names are no deeds."], ("the count",))
    monkeypatch.setattr(report, "TELLINGS", {**report.TELLINGS, KIND: lambda: telling})
    done = Procedure(answer, verdict, str, lambda *_: None)
    monkeypatch.setattr(run, "PROCEDURES", {**run.PROCEDURES, KIND: lambda: done})
    environment = render._environment()
    monkeypatch.setattr(environment, "loader", ChoiceLoader([DictLoader(TEMPLATES), environment.loader]))


def test_a_kind_of_claim_takes_an_entry_in_each_table(registered):
    profile = small_profile()
    team = profile.agents[1].team
    options = ask.VerifyOptions.about("short_names", "start", {"team": team, "steps": 9})
    asked, stated = pose_questions(profile, "profile.json", options.ensure_usable())
    told = []
    done = verify_questions(profile, asked, options, told.append, stated)
    (result,) = done.results
    assert told == [result] and result.verdict is Verdict.PROVED
    assert asked[0].command.endswith(f"""--claim 'short_names(team="{team}", steps=9)' --region start""")
    assert done.document["results"][0]["longest"] == len("agent_0")
    assert "Names are no deeds." in done.document["limits"]
    assert "longest    7" in done.reports["report.txt"] and "<th>longest</th><td>7</td>" in done.reports["report.html"]
    assert as_lines(profile, result)[1] == ["longest 7"]
    assert set(done.files) == {"report.json", "report.txt", "report.html"}
    assert "short_names" in page_of(profile, done.results)


def test_a_kind_of_claim_on_the_command_line(registered, tmp_path):
    path = tmp_path / "profile.json"
    path.write_text(dumps(small_profile()))
    words = ["verify", str(path), "--claim"]
    of = f"short_names(team={small_profile().agents[1].team}"
    for more, ends in (([f"{of})"], 0), ([f"{of}, steps=3)"], 1), ([f"{of}, steps=3)", "--verdict-only"], 1)):
        ran = CliRunner().invoke(cli, [*words, *more], standalone_mode=False)
        assert (ran.return_value if ran.exception is None else ran.exception) == ends, ran.output
    file = tmp_path / "asked.toml"
    file.write_text('[[property]]\nname = "short_names"\nlabel = "brief"\nsteps = 3\n')
    ran = CliRunner().invoke(cli, ["verify", str(path), "--properties", str(file), "--json"], standalone_mode=False)
    assert ran.return_value == 1 and '"longest": 7' in ran.output
