"""generated/ci/: what the workflow and the hook run ends as it should, where claims hold and where one fails."""

import re
import shlex
import shutil
from xml.etree import ElementTree

import pytest

from maviper.cli.main import run
from tests.support.generated import FOLDER

GENERATED = FOLDER.parent
CLAIM = '[[claim]]\nname = "own_target"\nteam = "defenders"\nlandmarks = ["landmark_0", "landmark_1"]\n'
TEAMS = {"proved_defenders": 0, "physical_deception/extracted": 1}  # name -> how the claim ends


def commands(name, key):
    """The commands of ours in a file."""
    text = (GENERATED / "ci" / name).read_text()
    return [shlex.split(found) for found in re.findall(rf"^ *(?:- )?{key}: maviper (.*)$", text, re.MULTILINE)]


@pytest.fixture(params=TEAMS)
def repository(request, tmp_path, monkeypatch):
    """A folder with a policy and a claim, in which commands are run; gives how the claim ends."""
    shutil.copy(GENERATED / request.param / "profile.json", tmp_path)
    (tmp_path / "claims.toml").write_text(CLAIM)
    monkeypatch.chdir(tmp_path)
    return TEAMS[request.param]


@pytest.mark.slow
@pytest.mark.compile
@pytest.mark.usefixtures("few_observations", "few_episodes")
def test_the_workflow_keeps_verdicts_and_fails_with_a_claim(repository, tmp_path):
    compiles, verifies = commands("verify.yml", "run")
    assert run(compiles) == 0 and len(list((tmp_path / "code").glob("*.h"))) == 1
    assert run(verifies) == repository
    assert (tmp_path / "report" / "report.html").exists()
    suite = ElementTree.parse(tmp_path / "verdicts.xml").getroot()
    assert len(list(suite.iter("testcase"))) == 1 and len(list(suite.iter("failure"))) == repository


@pytest.mark.solver
def test_the_hook_fails_with_a_claim_and_runs_where_policy_or_claims_change(repository, tmp_path):
    (hook,) = commands("pre-commit-config.yaml", "entry")
    assert run(hook) == repository
    (pattern,) = re.findall(r"files: (\S+)", (GENERATED / "ci" / "pre-commit-config.yaml").read_text())
    assert [bool(re.search(pattern, name)) for name in ("profile.json", "claims.toml", "a.json")] == [True, True, False]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["claims.toml", "profile.json"], "verdicts alone"
