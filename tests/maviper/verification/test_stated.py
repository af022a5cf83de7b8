"""`maviper verify --system`: verdicts about a stated system, and the files that are left."""

import csv
import json
import re
import subprocess
import sys

import pytest

from codegen.errors import ExitCode
from maviper.cli.main import run as command
from tests.support.altered import sealed
from tests.support.flows import BRAKING, LOWERED, PENDULUM
from tests.support.stated import BRAKES, CAR, DRIVES, PROPERTIES, profile, verify
from tests.support.system_cases import policy
from tests.support.systems import CART, MOUNTAIN
from verify.checker.reading import RejectedError


@pytest.fixture
def cart(tmp_path):
    (tmp_path / "profile.json").write_text(profile(BRAKES))
    (tmp_path / "cart.toml").write_text(CART + PROPERTIES)
    return tmp_path


def test_verdicts_files_checks_and_replays(cart, capsys):
    out = cart / "report"
    assert verify(cart, "-o", str(out), "--json") == ExitCode.VIOLATED
    told = json.loads(capsys.readouterr().out)
    assert [each["verdict"] for each in told["results"]] == ["PROVED", "VIOLATED", "PROVED"]
    assert told["of"] == "of the stated dynamics, exactly" and told["reference"] == {}
    assert {path.name for path in out.iterdir()} == {
        "report.html",
        "report.json",
        "report.txt",
        "profile.json",
        "world.toml",
        "certificate-1-stays_in.json",
        "counterexample-2-stays_in.csv",
        "counterexample-2-stays_in.json",
        "test_counterexample_2_stays_in.py",
        "certificate-3-decides.json",
        ".maviper.json",
    }
    assert [each["shuffled_control"] for each in told["results"]] == ["PROVED", "VIOLATED", "VIOLATED"]
    for each in told["results"]:
        engine, second = each["engines"]
        assert engine["engine"] in ("boxes", "reach") and second["engine"].startswith("Z3")
        assert engine["verdict"] == each["verdict"] and second["verdict"] in (each["verdict"], "UNKNOWN")
    failing = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "test_counterexample_2_stays_in.py"]
    ran = subprocess.run(failing, cwd=out, capture_output=True, text=True, check=False)
    assert ran.returncode == 1 and " fails: " in ran.stdout
    for name in ("certificate-1-stays_in.json", "certificate-3-decides.json"):
        assert command(["check", str(out / name)]) == ExitCode.DONE
    assert "of the stated dynamics, exactly" in capsys.readouterr().out
    replay = ["replay", str(out / "counterexample-2-stays_in.json")]
    assert command(replay) == ExitCode.VIOLATED
    assert "not the one" not in capsys.readouterr().err
    (cart / "other.toml").write_text((CART + PROPERTIES).replace("range = [-5, 5]", "range = [-6, 6]"))
    assert command([*replay, "--system", str(cart / "other.toml")]) == ExitCode.VIOLATED
    assert "the world file is not the one" in capsys.readouterr().err
    still = policy("cart", ["ahead"], ["stay", "left", "right"], 0)
    (cart / "still.json").write_text(profile(still))
    replayed = ["replay", str(out / "counterexample-2-stays_in.json"), "--profile", str(cart / "still.json")]
    assert command(replayed) == ExitCode.DONE


def test_what_several_claims_are_not_is_said_under_each(cart, capsys):
    """Why there is no answer, and that nothing within the ranges is avoided; a set that is there has no such note."""
    claims = ['decides(formula="v > 9 implies v > 1")', "avoids(region={box={x=[60, 70]}})"]
    asked = [word for claim in claims for word in ("--claim", claim)]
    there = ("--claim", "avoids(region={box={x=[4, 7]}})")
    verify(cart, *asked, *there, "-o", str(cart / "report"))
    lines = capsys.readouterr().out.splitlines()
    (empty,) = [place for place, line in enumerate(lines) if line.startswith("VACUOUS")]
    assert "no state meets the condition: v > 9" in lines[empty + 1]
    (nothing,) = [place for place, line in enumerate(lines) if "lies in what it avoids" in line]
    assert lines[nothing - 1].startswith("PROVED")
    told = json.loads((cart / "report" / "report.json").read_text())["results"]
    assert [each["verdict"] for each in told] == ["VACUOUS", "PROVED", "PROVED"]
    assert ["note" in each for each in told] == [False, True, False]
    assert "note       no state within the ranges" in (cart / "report" / "report.txt").read_text()


def forged(text, **words):
    """A certificate whose claim calls itself otherwise, with a hash that fits again."""
    document = json.loads(text)
    document["claim"] |= words
    return sealed(document)


def test_a_certificate_is_told_by_what_it_proves(cart, capsys):
    """Its own words may say more: the region is not what it is called, nor the formula what its label says."""
    out = cart / "report"
    verify(cart, "-o", str(out))
    words = {"label": "never \x1b[31mfails", "region": "x in [0, 0]"}
    for name, called, said in (
        (
            "certificate-1-stays_in.json",
            "stays_in (in the file: 'it stays near')",
            "every episode of 10 steps stays in x >= -2 and x <= 2, of the stated",
        ),
        (
            "certificate-3-decides.json",
            "decides",
            "in every state of the ranges (x in [-10, 10], v in [-5, 5]) with v <= 0, (x > -0.5 or not acts(cart) =="
            " left), of the stated",
        ),
    ):
        (out / "forged.json").write_text(forged((out / name).read_text(), **words, name="avoids"))
        assert command(["check", str(out / "forged.json")]) == ExitCode.INPUT  # a name that is none of its kind
        (out / "forged.json").write_text(forged((out / name).read_text(), **words))
        capsys.readouterr()
        assert command(["check", str(out / "forged.json")]) == ExitCode.DONE
        told = capsys.readouterr().out
        assert said in told and "\x1b" not in told and "[0, 0]" not in told
        assert told.startswith(f"accepted  {called}: ") and "never" not in told


@pytest.mark.parametrize(
    ("region", "verdict", "said"),
    [
        ("x = [0.5, 1000]", "PROVED", "with x in [0.5, 1000] (of the ranges [0.5, 10])"),
        ("x = [11, 1000]", "VACUOUS", "with x in [11, 1000] (no state of the ranges)"),
    ],
)
def test_a_claim_about_decisions_speaks_of_states_of_the_ranges(tmp_path, capsys, region, verdict, said):
    """The tree pushes right from x = 50 on, which lies outside the range of x, [-10, 10]."""
    tree = policy("cart", ["place"], ["stay", "left", "right"], ((0, 50.0), 0, 2))
    claim = f'[[property]]\nregion = {{ box = {{ {region} }} }}\nformula = "not acts(cart) == right"\n'
    (tmp_path / "profile.json").write_text(profile(tree))
    (tmp_path / "cart.toml").write_text(CART + claim)
    verify(tmp_path, "-o", str(tmp_path / "report"), "--json")
    [told] = json.loads(capsys.readouterr().out)["results"]
    assert told["verdict"] == verdict
    assert told["sentence"] == f"in every state of the ranges {said}, the agents decide as claimed"
    if verdict == "PROVED":
        assert command(["check", str(tmp_path / "report" / "certificate-1-decides.json")]) == ExitCode.DONE
        told = "in every state of the ranges (x in [-10, 10]) with x >= 0.5 and x <= 1000, not acts(cart) == right"
        assert told in capsys.readouterr().out


@pytest.mark.parametrize("count", [2, 3, 4])
def test_a_claim_need_not_name_the_modes(tmp_path, capsys, count):
    """The middle of an even number of modes is none of them; a state of the claim has one of them."""
    modes = json.dumps([f"M{number}" for number in range(count)])
    world = CART.replace("[agents", f"mode = {{ modes = {modes} }}\n\n[agents", 1)
    world = world.replace("v = [0, 0] }", 'v = [0, 0], mode = "M0" }').replace('cart.a"', 'cart.a"\nmode = "mode"')
    tree = policy("cart", ["place"], ["stay", "left", "right"], ((0, 50.0), 0, 2))
    (tmp_path / "profile.json").write_text(profile(tree))
    (tmp_path / "cart.toml").write_text(f'{world}[[claim]]\nformula = "x <= 10"\n')
    verify(tmp_path, "--json")
    [told] = json.loads(capsys.readouterr().out)["results"]
    assert told["verdict"] == "PROVED", told


def test_a_certificate_about_an_action_that_there_is_not(cart, capsys):
    out = cart / "report"
    verify(cart, "-o", str(out))
    text = (out / "certificate-3-decides.json").read_text()
    formula = json.loads(text)["claim"]["formula"]
    for number in (3, -1):
        other = json.loads(json.dumps(formula).replace('"takes": 1', f'"takes": {number}'))
        assert other != formula
        (out / "forged.json").write_text(forged(text, formula=other))
        assert command(["check", str(out / "forged.json")]) == ExitCode.INPUT
        assert "do not have" in capsys.readouterr().err


def test_nothing_is_proved_of_an_enclosure_that_is_not_shown_again(cart, capsys, monkeypatch):
    def refusing(statement, on_piece):
        raise RejectedError("piece 1: v: its error is exceeded")

    monkeypatch.setattr("maviper.verification.stated.ensure_enclosed", refusing)
    assert verify(cart) == ExitCode.INPUT
    assert "an enclosure was not shown again" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda found: found["start"].update(x="2"), "does not start where the world file has starts"),
        (lambda found: found["start"].update(v="1/10"), "does not start where the world file has starts"),
        (lambda found: found["claim"].update(steps=10**15), "an episode has 0 to 1000 steps"),
        (lambda found: found["claim"].update(by=-1), "is no step of an episode"),
    ],
)
def test_a_counterexample_that_asks_for_more_is_refused(cart, capsys, change, said):
    """Not told as a claim that holds, and not played for ever."""
    out = cart / "report"
    verify(cart, "-o", str(out))
    found = json.loads((out / "counterexample-2-stays_in.json").read_text())
    change(found)
    (out / "other.json").write_text(json.dumps(found))
    assert command(["replay", str(out / "other.json")]) == ExitCode.INPUT
    assert said in capsys.readouterr().err


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (["--claim", "reaches"], "--claim reaches"),
        (["--claim", "stays_in(region=near.toml)"], "--claim stays_in(region=near.toml): region"),
        (["--claim", "stays_in(region={box={x=[-2, 2]}}, radius=1)"], "unknown key 'radius'"),
        (["--region", "near.toml"], "--region has no effect with --system"),
        (["--steps", "3"], "No such option '--steps'"),
        (["--where"], "--where has no effect with --system"),
        (["--claims", "none.toml"], "cannot read the file"),
    ],
)
def test_options_that_do_not_fit(cart, capsys, more, said):
    assert verify(cart, *more) == ExitCode.INPUT
    assert said in capsys.readouterr().err


def test_claims_as_they_are_written(cart, capsys):
    """They are asked after those of a file, without one in place of the world's, and a report's folder has them."""
    near, slow = "stays_in(region={box={x=[-2, 2.25]}}, label=near)", 'decides(formula="v <= 0 implies v <= 0.5")'
    assert verify(cart, "--claim", near, "--claim", slow, "-o", str(cart / "report"), "--json") == ExitCode.DONE
    told = json.loads(capsys.readouterr().out)
    assert [each["verdict"] for each in told["results"]] == ["PROVED", "PROVED"]
    assert "--claims claims.toml" in (cart / "report" / "report.txt").read_text()
    again = ["verify", "profile.json", "--system", "world.toml", "--claims", "claims.toml", "--json"]
    known = subprocess.run(
        [sys.executable, "-m", "maviper", *again], cwd=cart / "report", capture_output=True, text=True, check=True
    )
    assert json.loads(known.stdout)["results"] == told["results"]
    assert command(["check", str(cart / "report" / "certificate-1-stays_in.json")]) == ExitCode.DONE
    said = capsys.readouterr().out
    assert "(in the file: 'near')" in said and re.search(r": \d+ boxes, made again from the proof's recipe\n", said)
    (cart / "more.toml").write_text(PROPERTIES)
    assert verify(cart, "--claims", str(cart / "more.toml"), "--claim", near, "--verdict-only") == ExitCode.VIOLATED
    assert capsys.readouterr().out.count("PROVED") == 3


def test_options_that_need_a_world(cart, capsys):
    assert command(["verify", str(cart / "profile.json"), "--set", "max_boxes=3"]) == ExitCode.INPUT
    assert "--set max_boxes has no effect without --system" in capsys.readouterr().err
    assert verify(cart, "--set", "max_boxes=0") == ExitCode.INPUT
    assert "--set max_boxes must be at least 1" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("[agents.cart", "[agents.car", "unknown agent 'cart'"),
        ('ahead = "x', 'before = "x', "unknown feature 'ahead'"),
        ("stay = {}", "rest = {}", "unknown action 'stay'"),
        ("[[property]]", "[[proberty]]", "unknown key 'proberty'"),
    ],
)
def test_a_profile_of_another_world(cart, capsys, old, new, said):
    text = (CART + PROPERTIES).replace(old, new).replace("cart.a", "car.a" if "car" in new else "cart.a")
    (cart / "cart.toml").write_text(text)
    assert verify(cart) == ExitCode.INPUT
    assert said in capsys.readouterr().err


def test_the_environment_is_measured_and_asked(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("maviper.worlds.stated.deviation.STEPS", 400)
    (tmp_path / "profile.json").write_text(profile(DRIVES))
    (tmp_path / "car.toml").write_text(MOUNTAIN + CAR)
    assert verify(tmp_path, "-o", str(tmp_path / "report"), world="car.toml") == ExitCode.VIOLATED
    said = "".join(capsys.readouterr())
    assert "with a per-step error of at most" in said and "400 steps were measured" in said
    assert "MountainCar-v0 breaks the claim from there too" in said
    assert command(["check", str(tmp_path / "report" / "certificate-1-stays_in.json")]) == ExitCode.DONE
    (tmp_path / "car.toml").write_text((MOUNTAIN + CAR).replace("0.0025", "0.0024"))
    assert verify(tmp_path, world="car.toml") == ExitCode.INPUT
    assert "the statement is not that of gymnasium:MountainCar-v0" in capsys.readouterr().err


def test_a_counterexample_of_the_statement_only(tmp_path, capsys, monkeypatch):
    """With a large stated error the statement may leave where the environment stays."""
    monkeypatch.setattr("maviper.worlds.stated.deviation.STEPS", 400)
    (tmp_path / "profile.json").write_text(profile(DRIVES))
    (tmp_path / "car.toml").write_text((MOUNTAIN + CAR).replace("position = 1e-12", "position = 0.2"))
    assert verify(tmp_path, world="car.toml") == ExitCode.VIOLATED
    assert "this is a counterexample of the statement only" in capsys.readouterr().out


def test_code_that_a_file_names_is_not_run(tmp_path, capsys):
    (tmp_path / "profile.json").write_text(profile(DRIVES))
    text = (MOUNTAIN + CAR).replace("gymnasium:MountainCar-v0", "tests.nowhere:make")
    (tmp_path / "car.toml").write_text(text)
    assert verify(tmp_path, world="car.toml") == ExitCode.VIOLATED
    assert "was not run" in capsys.readouterr().err
    assert verify(tmp_path, "--run-reference", world="car.toml") == ExitCode.INPUT
    assert "no module 'tests.nowhere'" in capsys.readouterr().err
    assert command(["worlds", "check", str(tmp_path / "car.toml")]) == ExitCode.DONE
    assert "was not run" in capsys.readouterr().out


@pytest.fixture
def pendulum(tmp_path):
    (tmp_path / "profile.json").write_text(profile(BRAKING.agents[0]))
    (tmp_path / "world.toml").write_text(PENDULUM + LOWERED + LOWERED.replace("[0, 1]", "[0, 0.6]"))
    return tmp_path


def test_verdicts_files_checks_and_replays_in_continuous_time(pendulum, capsys):
    out = pendulum / "report"
    assert verify(pendulum, "-o", str(out), "--json", world="world.toml") == ExitCode.VIOLATED
    told = json.loads(capsys.readouterr().out)
    assert [each["verdict"] for each in told["results"]] == ["PROVED", "VIOLATED"]
    assert told["of"] == "of the stated flow, with actions held for 0.05 s, exactly" and told["dt"] == "0.05"
    assert told["results"][0]["engines"][0]["engine"] == "flows" and "held until the next" in told["semantics"]
    assert any("for a proof about continuous time" in line for line in told["trusted"])
    assert "hold all states at all times" in (out / "report.txt").read_text()
    rows = list(csv.DictReader((out / "counterexample-2-reaches_and_stays.csv").read_text().splitlines()))
    assert rows[-1]["time_s"] == "0.5" and float(rows[-1]["angle"]) > 0.6
    certificate, broken = out / "certificate-1-reaches_and_stays.json", out / "counterexample-2-reaches_and_stays.json"
    assert command(["check", str(certificate)]) == ExitCode.DONE
    assert "at all times" in capsys.readouterr().out
    assert command(["replay", str(broken), "--profile", str(out / "profile.json")]) == ExitCode.VIOLATED
    assert "in enclosures of the flow that is stated" in capsys.readouterr().err
    _refused_about_another_world(out, certificate, broken, capsys)


def _refused_about_another_world(out, certificate, broken, capsys):
    world = out / "world.toml"
    world.write_text(world.read_text().replace("2[1/s^2]*sin", "2.1[1/s^2]*sin"))
    assert command(["check", str(certificate)]) == ExitCode.INPUT
    assert "another system" in capsys.readouterr().err
    command(["replay", str(broken), "--profile", str(out / "profile.json")])
    assert "not the one that the counterexample was made from" in capsys.readouterr().err
