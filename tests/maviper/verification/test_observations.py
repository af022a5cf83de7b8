"""An imported if/else tree end to end: import, claims over its observations, certificates, replay; and bad input."""

import json
import random
import re
from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from codegen import policy_json
from maviper import claims
from maviper.cli import main
from maviper.verification.ask import VerifyOptions, questions
from maviper.verification.run import verdicts
from tests.support.altered import sealed
from tests.support.observations import blind
from tests.support.small import small_profile
from tests.support.teams import nested, tree

pytestmark = pytest.mark.solver
CART = """
def cart(obs):
    position, velocity, angle, spin = obs
    if angle <= 0.01:
        if spin <= 0.4:
            return "left"
        if angle > -0.05:
            return "right"
        return "left"
    if spin < -0.6:
        return "left"
    return "right"
"""
CLAIMS = """
[[property]]
label = "leaning right"
formula = "angle > 0.1 and spin > 0 implies acts(cart) == right"

[[property]]
label = "leaning left"
formula = "angle < -0.02 implies acts(cart) == left"
region = { default = [-1, 1] }

[[property]]
name = "monotone"
agent = "cart"
feature = "spin"
region = { default = [-1, 1], difference = { "angle - spin" = [-1, 0.5] } }

[[property]]
name = "alive_leaves"
region = { box = { angle = [-1, -0.1] } }
"""
FALLS = """
[[property]]
name = "monotone"
agent = "cart"
feature = "spin"
order = ["right", "left"]
region = { default = [-1, 1] }
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The imported tree, its claims, and what `maviper verify -o` wrote about them."""
    place = tmp_path_factory.mktemp("cart")
    (place / "cart.py").write_text(CART)
    (place / "claims.toml").write_text(CLAIMS)
    assert main.run(["import", "--agents", f"cart={place / 'cart.py'}", "-o", str(place / "profile.json")]) == 0
    asked = ["verify", str(place / "profile.json"), "--claims", str(place / "claims.toml"), "-o", str(place / "out")]
    assert main.run(asked) == 1
    return place


def test_a_report_names_lines_of_the_header_that_is_compiled(folder):
    falls = f"{CLAIMS}{FALLS}"
    (folder / "falls.toml").write_text(falls)
    profile = str(folder / "profile.json")
    asked = ["--claims", str(folder / "falls.toml"), "-o", str(folder / "falls")]
    assert main.run(["verify", profile, *asked]) == 1
    main.run(
        ["compile", profile, "--target", "c", "-o", str(folder / "code")]
    )  # of no world: it skips a check, and says so
    (header,) = (folder / "code").glob("*.h")
    lines = header.read_text().split("\n")
    results = json.loads((folder / "falls" / "report.json").read_text())["results"]
    found = [agent for one in results if one.get("counterexample") for agent in one["counterexample"]["agents"]]
    assert [agent["agent"] for agent in found] == ["cart", "cart", "cart_raised"]  # the last has another's tree
    for agent in found:
        assert agent["code"]["file"] == header.name and len(agent["code"]["lines"]) > 1
        for line in agent["code"]["lines"]:
            assert lines[line["number"] - 1].strip() == line["text"]


def test_verdicts_and_words_are_about_observations(folder):
    report = json.loads((folder / "out" / "report.json").read_text())
    verdicts = [result["verdict"] for result in report["results"]]
    assert verdicts == ["PROVED", "VIOLATED", "PROVED", "VIOLATED"]
    assert all(result["of_start"] is None for result in report["results"])  # imported features have no range
    text = (folder / "out" / "report.txt").read_text()
    assert "world state" not in text and "goal" not in text and "over observations" in text
    assert "landmark" not in text
    page = (folder / "out" / "report.html").read_text()
    assert "<figure" not in page and "landmark" not in page and "over observations" in page
    assert (folder / "out" / "play.html").exists()
    dead = {leaf["leaf"] for leaf in report["results"][3]["leaves"] if leaf["verdict"] == "VIOLATED"}
    assert dead == {5, 7, 8}


@pytest.mark.parametrize("name", ["certificate-1-formula.json", "certificate-3-monotone.json"])
def test_certificates_are_accepted_with_the_original_profile(folder, name, capsys):
    assert main.run(["check", str(folder / "out" / name), "--profile", str(folder / "profile.json")]) == 0
    said = capsys.readouterr().out
    assert said.startswith("accepted") and "over observations" in said


@pytest.mark.parametrize("seed", range(4))
def test_sets_of_actions_that_are_not_left_are_those_of_all_observations(seed):
    """By a search through one observation on each side of every threshold."""
    chance = random.Random(seed)

    def draw(depth):
        if not depth:
            return chance.randrange(3)
        return (chance.randrange(3), chance.randrange(3) + 0.5, draw(depth - 1), draw(depth - 1))

    names = ("angle", "spin", "place")
    profile = blind({"cart": nested(draw(3))}, {"cart": names}, span=4.0)
    policy, rows = profile.policy("cart"), list(product(range(4), repeat=3))
    acted = dict(zip(rows, policy.act(np.array(rows, np.float32)).tolist(), strict=True))
    for feature, kept, sign in product(range(3), ([0], [1, 2]), (1, -1)):
        ups = [
            (low, (*low[:feature], raised, *low[feature + 1 :])) for low in acted for raised in range(low[feature], 4)
        ]
        holds = all(acted[b] in kept or acted[a] not in kept for a, b in (pair[::sign] for pair in ups))
        claim = claims.Monotone(
            feature=names[feature],
            direction={1: "increasing", -1: "decreasing"}[sign],
            actions=[policy.actions[k].name for k in kept],
        )
        options = VerifyOptions.about(claim, "ranges", {"observations": True})
        ((verdict, _),) = verdicts([one.question for one in questions(profile, "cart.json", options)])
        assert (str(verdict) == "PROVED") == holds


def edited(text, old, new):
    """A certificate with an edit and a hash that fits it."""
    assert text.replace(old, new) != text
    return sealed(json.loads(text.replace(old, new)))


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('"raised": ["cart", "spin"]', '"raised": ["cart", "angle"]'),
        ('"raised": ["cart", "spin"]', '"raised": ["cart"]'),
        ('"raised": ["cart", "spin"]', '"raised": ["truck", "spin"]'),
        ('"raised": ["cart", "spin"]', '"raised": []'),
        ('"shared": []', '"shared": ["spin"]'),
        ('"direction": "increasing"', '"direction": "decreasing"'),
        ('"direction": "increasing"', '"direction": "up"'),
        ('"feature": "spin"', '"feature": "angle"'),
        ('"order": []', '"order": ["right", "left"]'),
        ('"order": []', '"order": ["right"]'),
        ('"view": {"shared": [], "raised": ["cart", "spin"]},', ""),
        ('"name": "monotone"', '"name": "agree"'),
        ('"cart_raised.spin": ["-1", "1"]', '"cart_raised.spin": ["-1", "2"]'),
    ],
)
def test_a_mutated_certificate_is_refused(folder, old, new, tmp_path):
    text = (folder / "out" / "certificate-3-monotone.json").read_text()
    path = tmp_path / "forged.json"
    path.write_text(edited(text, old, new))
    expected = {0} if '1", "2' in new or '"2"' in new else {1, 2}  # of a larger region the proof holds as well
    assert main.run(["check", str(path), "--profile", str(folder / "profile.json")]) in expected


def test_the_counterexample_replays_in_compiled_code(folder, capsys):
    name = str(folder / "out" / "counterexample-2-formula.json")
    assert main.run(["replay", name]) == 1
    said = capsys.readouterr().err
    assert re.search(r"cart +right", said) and ("compiled C" in said or "reference" in said)
    document = json.loads((folder / "out" / "counterexample-2-formula.json").read_text())
    assert document["view"] == {"shared": [], "raised": []}
    assert set(document["position"]) == {"position", "velocity", "angle", "spin"}


def test_a_counterexample_with_a_broken_view_is_an_input_error(folder, tmp_path, capsys):
    document = json.loads((folder / "out" / "counterexample-2-formula.json").read_text())
    for view in ({"shared": []}, {"shared": ["wheel"], "raised": []}, {"shared": [], "raised": ["cart", "wheel"]}):
        (tmp_path / "counterexample.json").write_text(json.dumps(document | {"view": view}))
        arguments = ["replay", str(tmp_path / "counterexample.json"), "--profile", str(folder / "profile.json")]
        assert main.run(arguments) == 2
        assert "error:" in capsys.readouterr().err


def test_where_gives_the_exact_share_and_a_region(folder, tmp_path, capsys):
    arguments = ["verify", str(folder / "profile.json"), "--claims", str(tmp_path / "c.toml"), "--where", "--json"]
    (tmp_path / "c.toml").write_text(CLAIMS.split("[[property]]")[2].join(["[[property]]", ""]))
    assert main.run([*arguments, "-o", str(tmp_path / "out")]) == 1
    where = json.loads(capsys.readouterr().out)["results"][0]["where"]
    assert where["zones"] == 1
    assert where["exact"]["share"] == pytest.approx(
        0.03 * 0.6 / 4, rel=1e-6
    )  # angle from -0.05 to -0.02, spin above 0.4
    assert (tmp_path / "out" / "region-1-formula.toml").is_file()


def run_two(tmp_path, *arguments, teams=None, spans=None):
    """`maviper verify` about two agents that both observe an angle and a spin."""
    names = ("angle", "spin")
    profile = blind(
        {"a": tree((0, 0.5, 1, 2), 0, 2), "b": tree((0, 0.5, 1, 2), 0, 2)}, {"a": names, "b": names}, teams=teams
    )
    if spans is not None:
        first, second = profile.agents
        features = tuple(replace(one, high=spans) for one in second.features)
        profile = replace(profile, agents=(first, replace(second, features=features)))
    (tmp_path / "profile.json").write_text(policy_json.dumps(profile))
    return main.run(["verify", str(tmp_path / "profile.json"), *arguments])


@pytest.mark.parametrize(("shared", "code"), [(["--shared", "angle"], 0), (["--shared", "all"], 0), ([], 1)])
def test_two_agents_agree_where_they_see_the_same(shared, code, tmp_path, capsys):
    assert run_two(tmp_path, "--claim", "agree(agents=[a,b])", "--observations", *shared) == code


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--claim", "agree(agents=[a,b])", "--shared", "angel"], "unknown feature 'angel'"),
        (["--claim", "agree(agents=[a,c])"], "unknown agent 'c'"),
        (["--claim", "agree(agents=[a])"], "two agents"),
        (["--claim", "agree"], "agree"),
        (["--claim", "monotone(agent=a, feature=tilt)"], "unknown feature 'tilt'"),
        (["--claim", "monotone(agent=q, feature=spin)"], "unknown agent 'q'"),
        (["--claim", "monotone(agent=a)"], "name them: agent=A, feature=F"),
        (["--claim", "monotone(feature=spin)"], "name them: agent=A, feature=F"),
        (["--claim", "monotone(agent=a, feature=spin, direction=up)"], "unknown direction 'up'"),
        (["--claim", "monotone(agent=a, feature=spin, order=[left,stay])"], "every action once"),
        (["--claim", "monotone(agent=a, feature=spin, actions=[up])"], "unknown action 'up'"),
        (["--claim", "monotone(agent=a, feature=spin, actions=[left], order=[left,stay,right])"], "leave out one"),
        (["--claim", "ignores(agent=a)"], "ignores is about one feature"),
        (["--claim", "ignores(agent=a, feature=tilt)"], "unknown feature 'tilt'"),
        (["--claim", "ignores(agent=a, feature=spin, actions=[up])"], "unknown action 'up'"),
        (["--claim", "reaches"], "landmark|episodes"),
        (["--claim", "distinct_targets"], "landmark for each agent"),
    ],
)
def test_bad_input_is_told(arguments, said, tmp_path, capsys):
    assert run_two(tmp_path, *arguments) == 2
    assert re.search(said, capsys.readouterr().err)


def test_unlike_ranges_are_not_shared(tmp_path, capsys):
    assert run_two(tmp_path, "--claim", "agree(agents=[a,b])", "--shared", "angle", spans=1.5) == 2
    assert "unlike ranges" in capsys.readouterr().err


def test_agents_of_two_teams_do_not_agree(tmp_path, capsys):
    assert run_two(tmp_path, "--claim", "agree(agents=[a,b])", teams={"a": "red", "b": "blue"}) == 2
    assert "unknown agent 'b'" in capsys.readouterr().err


def test_a_particle_game_is_asked_about_observations_on_demand(tmp_path, capsys):
    (tmp_path / "profile.json").write_text(policy_json.dumps(small_profile()))
    arguments = ["verify", str(tmp_path / "profile.json"), "--claim", "alive_leaves(team=defenders)"]
    assert main.run([*arguments, "--shared", "all"]) == 2
    assert "add --observations" in capsys.readouterr().err
    assert main.run([*arguments, "--observations", "--json"]) in (0, 1)
    facts = json.loads(capsys.readouterr().out)
    assert facts["results"][0]["observations"] == "over observations"
    assert any("agent_0." in name for name in facts["results"][0]["region"]["box"])
