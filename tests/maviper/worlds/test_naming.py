"""Features named by a file: as it says, for whom it says; refused where it does not fit; played again all the same."""

import pytest

from codegen.errors import InputError
from maviper.cli import main
from maviper.evaluation import held_out
from maviper.files.profiles import load
from maviper.worlds import find
from maviper.worlds.matching import FEATURES_FILE, plays, with_names

WALKER = "tests.support.environments:walker"  # four numbers, -9 to 9
GOOD = """
["*"]
place = "cells"
time = { unit = "steps", range = [0, 6] }
nothing = "none"
third = { range = [0.25, 0.5] }
"""


def named(tmp_path, text, world=WALKER):
    file = tmp_path / "names.toml"
    file.write_text(text)
    return with_names(find(world), file)


def test_names_units_and_ranges_are_the_file_s(tmp_path):
    (features,) = named(tmp_path, GOOD).features
    found = [(each.name, each.unit, each.low, each.high) for each in features]
    assert found == [
        ("place", "cells", -9, 9),
        ("time", "steps", 0, 6),
        ("nothing", "none", -9, 9),
        ("third", "none", 0.25, 0.5),
    ]
    assert find(WALKER).features[0][0].name == "feature_0_0"


def test_an_agent_comes_before_its_team_and_that_before_everybody(tmp_path):
    text = '[left_runner]\na="1"\nb="1"\nc="1"\n[runner]\nd="2"\ne="2"\nf="2"\n["*"]\ng="3"\nh="3"\ni="3"\n'
    found = named(tmp_path, text, "tests.support.environments:early")
    assert [features[0].name for features in found.features] == ["a", "d"]
    alone = named(tmp_path, '[runner_1]\na="1"\nb="1"\nc="1"\n', "tests.support.environments:early")
    assert [features[0].name for features in alone.features] == ["feature_0", "a"]


def test_features_of_a_mask_keep_their_names(tmp_path):
    cells = "".join(f'{who}_{cell} = "0 or 1"\n' for cell in range(9) for who in ("mine", "theirs"))
    game = "pettingzoo.classic.tictactoe.tictactoe:env,wrap=turns+flatten"
    found = named(tmp_path, f"[player]\n{cells}", game)
    assert [each.name for each in found.features[1]][16:20] == [
        "mine_8",
        "theirs_8",
        "legal_action_0",
        "legal_action_1",
    ]
    assert found.masked
    with pytest.raises(InputError, match="3 features are named, but player_1 observes 18 numbers beside its mask"):
        named(tmp_path, '["*"]\na="1"\nb="1"\nc="1"', game)
    with pytest.raises(InputError, match="the name legal_action_0 is taken"):
        named(tmp_path, f"[player]\n{cells}".replace("mine_3", "LEGAL-action_0"), game)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("place = 1\n", "unknown agent or team 'place'"),
        ('[agnet]\nplace = "m"\n', "did you mean 'agent'"),
        ("[agent", "not a TOML file"),
        ('agent = "m"\n', "0 features are named, but agent observes 4 numbers"),
        (GOOD.replace("place", '"2nd place"'), "not a legal name of a feature"),
        (GOOD.replace("third", "Time"), "the name Time is taken"),
        (GOOD.replace('"cells"', "7"), "neither a unit nor a table"),
        (GOOD.replace('"cells"', '""'), "the unit is not a text"),
        (GOOD.replace('"cells"', '"a\\u001b[31m"'), "the unit is not a text"),
        (GOOD.replace("[0, 6]", "[6, 0]"), "the range needs LOW <= HIGH"),
        (GOOD.replace("[0, 6]", "[0, inf]"), "the range needs LOW <= HIGH"),
        (GOOD.replace("[0, 6]", "[nan, 6]"), "the range needs LOW <= HIGH"),
        (GOOD.replace("[0, 6]", f"[0, 1{'0' * 400}]"), "the range needs LOW <= HIGH"),
        (GOOD.replace("[0, 6]", "[0, true]"), "the range is not"),
        (GOOD.replace("range = [0, 6]", "colour = 3"), "neither a unit nor a table"),
    ],
)
def test_what_does_not_fit_is_refused_with_its_place(tmp_path, text, said):
    with pytest.raises(InputError) as caught:
        named(tmp_path, text)
    assert said in str(caught.value) and "names.toml" in str(caught.value) and caught.value.next_step


def test_our_own_games_have_names(tmp_path):
    with pytest.raises(InputError, match="our own games have names"):
        named(tmp_path, GOOD, "physical-deception")


def test_the_commands(tmp_path, monkeypatch, capsys):
    """A profile says what its file said, and still plays the environment."""
    monkeypatch.setattr(held_out, "EVALUATION_EPISODES", 6)
    (tmp_path / "names.toml").write_text(GOOD)
    names, file = ["--features-file", str(tmp_path / "names.toml")], tmp_path / "profile.json"
    assert main.run(["worlds", "show", WALKER, *names]) == 0
    assert "time             steps [0, 6]" in capsys.readouterr().out
    counts = ["--max-episodes", "60", "--algorithm", "viper", "--critic", "none"]
    asked = [
        "extract",
        "tests.support.environments:walking_expert",
        "--world",
        WALKER,
        *counts,
        *names,
        "-o",
        str(file),
    ]
    assert main.run(asked) == 0, capsys.readouterr().err
    profile = load(file)
    assert [feature.name for feature in profile.agents[0].features] == ["place", "time", "nothing", "third"]
    assert len(profile.provenance.training[FEATURES_FILE]) == 64
    assert plays(profile, find(WALKER)) and not plays(profile, find(f"{WALKER},shows=bits"))
    assert main.run(["evaluate", str(file), "--world", WALKER, "--episodes", "5"]) == 0
    assert main.run(["show", str(file)]) == 0
    out = capsys.readouterr().out
    assert "place <= " in out or "time <= " in out or "always" in out


def test_a_name_that_the_game_has_for_something_else_is_refused(tmp_path):
    """A table has no order to most who write one, and each name would be that of another number."""
    car = "gymnasium:MountainCar-v0"
    (features,) = named(tmp_path, '["*"]\nposition = "m"\nspeed = "m/s"\n', car).features
    assert [each.name for each in features] == ["position", "speed"]
    with pytest.raises(InputError, match="feature 0 of agent is position, and the file calls it velocity"):
        named(tmp_path, '["*"]\nvelocity = "m/s"\nposition = "m"\n', car)
