"""Property files to start from can be asked as they are; one bad claim does not silence the others."""

import json

import pytest

import maviper
from codegen.errors import ExitCode, InputError
from codegen.policy_json import dumps
from maviper.experts.network import decode
from maviper.verification.starters import starter
from maviper.worlds import find
from tests.support.pole import pole
from tests.support.teams import STAY, team_in, tree
from tests.support.verifying import run

GOOD = '[[property]]\nlabel = "good"\nformula = "angle < 0 implies acts(pole) == left"\n'
BAD = '[[property]]\nformula = "anle < 0 implies acts(pole) == left"\n'


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "pole.json"
    path.write_text(dumps(pole("float32")))
    return path


def asked(capsys, profile, text, folder, *more):
    (folder / "claims.toml").write_text(text)
    return run(capsys, "verify", str(profile), "--claims", str(folder / "claims.toml"), *more)


@pytest.mark.solver
def test_a_profile_without_meanings_has_a_starter(file, tmp_path, capsys):
    text = starter(str(file))
    assert "angle > 0 implies not acts(pole) == left" in text and "none" in text
    code, out, err = asked(capsys, file, text, tmp_path, "--verdict-only", "--json")
    verdicts = [one["verdict"] for one in json.loads(out)["results"]]
    assert code == ExitCode.DONE and verdicts == ["PROVED"] * 4, err


def test_a_team_has_a_starter_with_names_of_its_own(file, tmp_path):
    (one,) = pole("float64").agents
    (tmp_path / "one.py").write_text("def f(x):\n    return 1 if x[0] < 0 else 0\n")
    two = maviper.from_file({"near": tmp_path / "one.py", "far-off": tmp_path / "one.py"})
    (tmp_path / "two.json").write_text(dumps(two))
    text = starter(str(tmp_path / "two.json"))
    assert "near.x0 > 0 implies not acts(near) == action_0" in text and "far_off.x0:" in text
    assert one.agent in starter(str(file))


@pytest.mark.solver
@pytest.mark.parametrize("world", ["gymnasium:CartPole-v1", "coordination"])
def test_games_without_places_have_a_starter_or_a_reason(world, tmp_path, capsys):
    if world == "coordination":
        with pytest.raises(InputError, match="has none"):
            starter(world)
        return
    found, text = find(world), starter(world)
    (tmp_path / "one.json").write_text(dumps(team_in(found, [tree(STAY)] * len(found.agents))))
    code, out, err = asked(capsys, tmp_path / "one.json", text, tmp_path, "--verdict-only", "--json")
    assert code in (ExitCode.DONE, ExitCode.VIOLATED) and len(json.loads(out)["results"]) == 4, err


@pytest.mark.solver
@pytest.mark.parametrize("more", [["--verdict-only"], []])
def test_one_bad_claim_does_not_silence_the_others(file, tmp_path, capsys, more):
    code, out, err = asked(capsys, file, GOOD + BAD + GOOD, tmp_path, *more)
    assert code == ExitCode.INPUT and (out + err).count("PROVED ") == 2
    assert "unknown name 'anle'" in err and "did you mean 'angle'" in err
    code, out, err = asked(capsys, file, BAD + BAD, tmp_path, *more)
    assert code == ExitCode.INPUT and "2 of 2" in err and "PROVED" not in out + err
    with pytest.raises(InputError, match="anle"):
        maviper.verify_file(pole("float32"), tmp_path / "claims.toml")


def test_modules_of_worlds_and_experts_are_named_in_errors():
    with pytest.raises(InputError, match="unknown world 'CartPole-v1'") as found:
        find("CartPole-v1")
    assert "gymnasium:CartPole-v1" in found.value.next_step
    with pytest.raises(InputError, match=r"unknown world 'cruise\.toml'") as found:
        find("cruise.toml")
    assert "system:cruise.toml" in found.value.next_step
    with pytest.raises(InputError, match="not an expert file") as found:
        decode(b"PK\x03\x04 and so on", "cartpole.zip")
    assert "sb3:cartpole.zip" in found.value.next_step
