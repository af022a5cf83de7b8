"""The gate: whoever reads trees of single tests only refuses profiles with sums or outputs."""

import click
import pytest

import maviper
from codegen.deciding import SUMMING, ensure_plain
from codegen.errors import InputError
from codegen.policy_json import dumps
from codegen.targets import TARGETS, emit
from maviper.cli.main import cli, run
from tests.support import summed
from tests.support.generated import FOLDER
from verify.subjects import Game

KINDS = summed.every(1, levels=2)
ACTS, GIVES = KINDS["actions, double sums"], KINDS["outputs, double sums"]
REFUSED = "does not take sums yet"
# commands whose argument PROFILE is a policy profile, with what else they need; the others are listed below
GIVEN = {
    "compile": [
        ["--target", "smt", "-o", "out"],
        ["--prove", "-o", "out"],
        ["--pass", "merge", "-o", "out"],
        ["--test-vectors", "-o", "out"],
    ],
    "evaluate --exploit team": [[]],
    "repair": [["-o", "out"]],
    "verify --claim robust(observations=rows.csv)": [[]],
}
# replay and check find the profile beside another file; compare and extract take experts and worlds; diff,
# evaluate, play, show and verify take sums
OTHERS = {
    *("check", "compare", "diff", "demo", "edit", "evaluate", "extract", "guide", "import", "play", "replay"),
    *("reproduce", "show", "train", "verify", "worlds"),
}


@pytest.mark.parametrize("target", [target for target in TARGETS if target not in SUMMING])
@pytest.mark.parametrize("profile", [ACTS, GIVES], ids=["actions", "outputs"])
def test_targets_that_know_no_sums_refuse_them(target, profile):
    with pytest.raises(InputError, match=f"the target {target} {REFUSED}"):
        emit(profile, [target])


def test_every_command_is_looked_at():
    commands = set(cli.list_commands(click.Context(cli)))
    assert commands <= {*GIVEN, *OTHERS}, "does it take sums? say so here"
    assert {line.split()[0] for line in GIVEN} <= commands


@pytest.mark.parametrize(("verb", "options"), [(verb, each) for verb, all_ in GIVEN.items() for each in all_])
@pytest.mark.parametrize("profile", [ACTS, GIVES], ids=["actions", "outputs"])
def test_commands_refuse_sums_with_one_sentence(verb, options, profile, tmp_path, monkeypatch, capsys):
    if "robust" in verb and profile is GIVES:
        return  # it says how far outputs change
    monkeypatch.chdir(tmp_path)
    (tmp_path / "profile.json").write_text(dumps(profile))
    (tmp_path / "rows.csv").write_text("x0,x1,x2,x3,x4\n0,0,0,0,0\n")
    assert run([*verb.split(), "profile.json", *options]) == 2
    said = capsys.readouterr().err
    assert REFUSED in said and ",".join(SUMMING) in said and "Traceback" not in said
    assert not (tmp_path / "out").exists()


def test_functions_refuse_them_too(tmp_path):
    file = tmp_path / "profile.json"
    file.write_text(dumps(ACTS))
    (tmp_path / "counterexample.json").write_text("{}")
    profile = maviper.load(file)
    asked = [
        lambda: maviper.repair(profile),
        lambda: maviper.robust(profile, tmp_path / "rows.csv"),
        lambda: maviper.replay(tmp_path / "counterexample.json", profile),
        lambda: maviper.check(FOLDER / "certificate-1-distinct_targets.json", profile),
        lambda: maviper.compile(profile, ["smt"]),
        lambda: Game(profile),
    ]
    for call in asked:
        with pytest.raises(InputError, match=REFUSED):
            call()


def test_plain_profiles_pass(profile):
    assert ensure_plain(profile, "nobody") is profile
