"""Claims about episodes of teams that test sums, in their game: against mpe2 and the judge's reading of the trees."""

import json
import shlex
import tomllib
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from codegen.ir import Meaning
from codegen.policy_json import dumps
from codegen.sums import DOUBLE_SUMS, FLOAT32_STEPS
from maviper.cli import main
from maviper.verification import games
from maviper.verification.ask import VerifyOptions
from maviper.verification.run import pose_questions, results
from maviper.verification.worlds import World
from tests.hunting.summing import Team
from tests.support.game_sums import team
from tests.support.generated import FOLDER
from verify.claims.region import Region
from verify.claims.region_files import region_toml, start_region
from verify.result import SETTLED, Verdict

RADII = {"reaches": Fraction(1, 2), "covers": Fraction(1), "keeps_apart": Fraction(1, 4), "stays_in": Fraction(1)}


def region_of(profile, seed, half):
    """A small box of starts, with one goal."""
    whole, rng = start_region(profile.world), np.random.default_rng(seed)
    middles = {name: Fraction(float(rng.uniform(-0.75, 0.75))) for name in whole.box}
    return Region({name: (at - half, at + half) for name, at in middles.items()}, whole.goals[:1], name="drawn.toml")


def fulfils(name, region_radius, profile, episode):
    """Whether an episode of mpe2 fulfils a claim about the defenders, in exact numbers."""
    radius = region_radius

    def gap(at, one, other):
        return max(abs(Fraction(at[f"{one}.{axis}"]) - Fraction(at[f"{other}.{axis}"])) for axis in "xy")

    own = [("agent_0", "landmark_0"), ("agent_1", "landmark_1")]
    other = [("agent_0", "landmark_1"), ("agent_1", "landmark_0")]
    if name == "stays_in":
        return all(abs(Fraction(at[f"{each}.{axis}"])) <= radius for at in episode for each, _ in own for axis in "xy")
    if name == "keeps_apart":
        return all(gap(at, "agent_0", "agent_1") >= radius for at in episode)
    if name == "covers":
        return any(all(gap(episode[-1], *pair) <= radius for pair in way) for way in (own, other))
    return [any(gap(at, *pair) <= radius for at in episode) for pair in own]


def ensure_true(profile, name, radius, steps, region, outcomes):
    """No episode of mpe2 breaks what is proved, and each counterexample is one that does."""
    rng = np.random.default_rng(1)
    assert all(each.verdict in SETTLED for each in outcomes)
    for place, result in enumerate(outcomes):
        if result.verdict is Verdict.VIOLATED:
            start = result.counterexample.start
            assert all(low <= start[each] <= high for each, (low, high) in region.box.items())
            assert all(Fraction(float(start[each])) == start[each] for each in region.box)
            episodes = [Team(json.loads(dumps(profile))).episode(start, steps)]
        else:
            drawn = [[float(rng.choice([low, (low + high) / 2, high])) for low, high in region.box.values()]]
            drawn += [[float(rng.uniform(float(low), float(high))) for low, high in region.box.values()] for _ in "abc"]
            episodes = [
                Team(json.loads(dumps(profile))).episode(dict(zip(region.box, each, strict=True)), steps)
                for each in drawn
            ]
        kept = [fulfils(name, radius, profile, each) for each in episodes]
        kept = [each[place] for each in kept] if name == "reaches" else kept
        assert result.verdict is not Verdict.VIOLATED or not any(kept)
        assert result.verdict is not Verdict.PROVED or all(kept), (name, place)


@pytest.mark.parametrize(
    "seeds",
    [pytest.param(range(5), marks=pytest.mark.slow), pytest.param(range(5, 80), marks=pytest.mark.nightly)],
    ids=["some", "many"],
)
def test_verdicts_are_true_of_mpe2(seeds, tmp_path):
    verdicts = []
    for seed in seeds:
        profile = team(seed + 1, (DOUBLE_SUMS, FLOAT32_STEPS)[seed % 2], levels=2)
        name, steps = ("stays_in", "keeps_apart", "covers", "reaches")[seed % 4], 4
        region = region_of(profile, seed, Fraction(1, (64, 256)[seed % 3 > 0]))
        (tmp_path / "drawn.toml").write_text(region_toml(region))
        asked = VerifyOptions.about(name, str(tmp_path / "drawn.toml"), {"radius": RADII[name], "steps": steps})
        outcomes = results(profile, replace(asked, max_boxes=100_000, verdict_only=True))
        ensure_true(profile, name, RADII[name], steps, region, outcomes)
        verdicts += [each.verdict for each in outcomes]
    assert {Verdict.PROVED, Verdict.VIOLATED} <= set(verdicts)


@pytest.fixture(scope="module")
def answered(tmp_path_factory):
    """A folder with a proof and a counterexample."""
    folder = tmp_path_factory.mktemp("episodes")
    profile = team(1, levels=2)
    (folder / "team.json").write_text(dumps(profile))
    (folder / "region.toml").write_text(region_toml(region_of(profile, 0, Fraction(1, 256))))
    (folder / "claims.toml").write_text(
        '[[property]]\nname = "keeps_apart"\nradius = 2\nsteps = 3\n\n'
        '[[property]]\nname = "stays_in"\nradius = 2\nsteps = 3\n'
    )
    words = ["verify", str(folder / "team.json"), "--claims", str(folder / "claims.toml")]
    code = main.run([*words, "--region", str(folder / "region.toml"), "-o", str(folder / "out")])
    assert code == 1
    return folder


def test_a_proof_is_checked_and_an_episode_replayed(answered, capsys):
    (certificate,) = (answered / "out").glob("certificate-*.json")
    assert main.run(["check", str(certificate)]) == 0
    assert "stays_in of the defenders" in capsys.readouterr().out
    (counterexample,) = (answered / "out").glob("counterexample-*.json")
    assert main.run(["replay", str(counterexample)]) == 1


@pytest.mark.parametrize(
    ("asked_for", "message"),
    [
        (["--claim", "reaches"], "one goal, and region start has several"),
        (["--claim", "stays_in", "--region", "{folder}/region.toml"], "stays_in for ever is not decided"),
        (["--claim", "reaches", "--claim", "own_target"], "own_target is about single decisions"),
    ],
)
def test_what_is_not_decided_is_refused(answered, asked_for, message, capsys):
    words = [each.format(folder=answered) for each in asked_for]
    assert main.run(["verify", str(answered / "team.json"), *words]) == 2
    assert message in capsys.readouterr().err


def test_boxes_are_counted_of_world_files_alone(capsys):
    assert main.run(["verify", str(FOLDER / "profile.json"), "--set", "max_boxes=5"]) == 2
    assert "--set max_boxes has no effect without --system" in capsys.readouterr().err


def pose(folder, profile, region, *names, **given):
    """What is asked about a team that starts in a region, and the world file that it is about."""
    (folder / "region.toml").write_text(region if isinstance(region, str) else region_toml(region))
    given = {"steps": 3, "radius": Fraction(2), **given} if names == ("stays_in",) else given
    asked = VerifyOptions(names=names, region=str(folder / "region.toml"), parameters=given)
    return pose_questions(profile, "team.json", asked)


def test_regions_of_one_name_are_told_apart(answered, tmp_path, capsys):
    near, claims = region_of(team(1, levels=2), 0, Fraction(1, 256)), []
    far = replace(near, box={name: (low + 5, high + 5) for name, (low, high) in near.box.items()})
    for folder, region in (("a", near), ("b", far), ("a", near)):
        (tmp_path / folder).mkdir(exist_ok=True)
        (tmp_path / folder / "r.toml").write_text(region_toml(region))
        claims.append(f'[[property]]\nname = "stays_in"\nradius = 2\nsteps = 3\nregion = "{folder}/r.toml"\n')
    (tmp_path / "claims.toml").write_text("\n".join(claims))
    words = ["verify", str(answered / "team.json"), "--claims", str(tmp_path / "claims.toml")]
    assert main.run([*words, "--verdict-only"]) == 2
    assert "start in one region" in capsys.readouterr().err


def observing(profile, *terms):
    """The team, whose agents observe by turns these multiples of coordinates and nothing else."""
    meanings = [Meaning(each) for each in terms]
    policies = [
        replace(
            policy,
            features=tuple(
                replace(each, meaning=meanings[place % len(meanings)]) for place, each in enumerate(policy.features)
            ),
        )
        for policy in profile.agents
    ]
    return replace(profile, agents=tuple(policies))


@pytest.mark.parametrize(
    "stated",
    [
        '"agent_0.vx" = [1, 2]\n',
        pytest.param('"agent_0.vx" = [-2, -1]\n', marks=pytest.mark.slow),
        pytest.param('[difference]\n"agent_0.vx - agent_1.vy" = [1, 2]\n', marks=pytest.mark.slow),
        '[difference]\n"agent_0.x - agent_1.x" = [-9, -8]\n',
    ],
)
def test_a_region_without_starts_at_rest_is_vacuous(stated, tmp_path):
    profile = observing(team(1, levels=2), ((1.0, "agent_0.vx"), (-1.0, "agent_1.vy")))
    (asked,), world = pose(tmp_path, profile, region_toml(region_of(profile, 0, Fraction(1, 256))) + stated, "stays_in")
    result = world.answer(asked.question)
    assert (result.verdict, result.reason) == (Verdict.VACUOUS, "the region holds no start at rest")
    assert world.document([result])["results"][0]["verdict"] == "VACUOUS"
    assert not world.started.widened.nowhere


def test_the_command_of_a_report_about_no_start_answers_so_again(tmp_path, monkeypatch):
    profile = team(1, levels=2)
    nowhere = (
        region_toml(region_of(profile, 0, Fraction(1, 256))) + '[difference]\n"agent_0.x - agent_1.x" = [-9, -8]\n'
    )
    (tmp_path / "profile.json").write_text(dumps(profile))
    (tmp_path / "nowhere.toml").write_text(nowhere)
    monkeypatch.chdir(tmp_path)
    words = ["verify", "profile.json", "--claim", "stays_in(steps=3)", "--region", "nowhere.toml"]
    assert main.run([*words, "-o", "out"]) == 3
    report = json.loads((tmp_path / "out" / "report.json").read_text())
    command = shlex.split(report["command"])
    assert command[0] == "maviper" and main.run([*command[1:], "--verdict-only"]) == 3


def test_claims_say_where_episodes_go_and_where_they_start(tmp_path):
    profile = team(1, levels=2)
    ((asked,), world) = pose(tmp_path, profile, region_of(profile, 0, Fraction(1, 256)), "stays_in")
    assert asked.claim.sentence.startswith("every episode of 3 steps stays in agent_0.x <= 2 and agent_0.x >= -2 and ")
    assert asked.claim.shown == "stays_in of the defenders, from region region.toml, at rest"
    assert asked.about == world.about == "over episodes of the game, " + world.about.partition(", ")[2]
    named = {"of": "own_target", "eps": Fraction(1, 100)}
    ((asked,), world) = pose(tmp_path, profile, region_of(profile, 0, Fraction(1, 256)), "steady", **named)
    assert asked.claim.shown.startswith("steady of the defenders: own_target, region region.toml")
    assert asked.claim.sentence.startswith("in every state of the ranges of region region.toml, ")
    assert world.about.startswith("over states of the game, ")


def find_broken(folder, landmark):
    """A world of agents that observe only how far a landmark is from the goal, which is at landmark_0; and episodes of
    its game that break a claim.
    """
    profile = team(1, levels=2)
    profile = observing(profile, *(((1.0, f"{landmark}.{axis}"), (-1.0, f"goal.{axis}")) for axis in "xy"))
    region = region_of(profile, 0, Fraction(1, 256))
    ((asked,), world) = pose(folder, profile, region, "stays_in", radius=Fraction(1, 100))
    game = games.PlayedGame(world.origin, world.profile, world.statement, world.started.goal)
    return asked, world, game


@pytest.mark.parametrize("landmark", ["landmark_0", pytest.param("landmark_1", marks=pytest.mark.slow)])
def test_the_goal_is_known_where_nobody_sees_it(landmark, tmp_path):
    asked, world, game = find_broken(tmp_path, landmark)
    assert game.goal == "landmark_0"
    assert world.answer(asked.question, beside=False).verdict is Verdict.VIOLATED


def test_an_episode_beyond_the_errors_of_its_file_is_no_counterexample(tmp_path):
    asked, _, game = find_broken(tmp_path, "landmark_1")
    course = next(games.iterate_courses(game, asked.claim))
    (piece,) = game.statement.system.pieces
    (name, *_) = [name for errors in course.errors for name, most in errors.items() if most]
    exact = replace(piece, error={**piece.error, name: (Fraction(0), Fraction(0))})
    system = replace(game.statement.system, pieces=(exact,))
    narrow = replace(game, statement=replace(game.statement, system=system))
    with pytest.raises(AssertionError, match="otherwise than its world file allows"):
        next(games.iterate_courses(narrow, asked.claim))


@pytest.mark.parametrize("text", ["safe \U0001f642", '"quoted\\', "\x7f\x00\n\t", "half \udcff"])
def test_any_text_is_one_of_toml(text):
    written = tomllib.loads(World.of("", {"text": text}).source)["text"]
    assert written == text.replace("\udcff", "?")
