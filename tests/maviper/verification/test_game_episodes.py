"""Claims about episodes of teams that test sums, in their game: against mpe2 and the judge's reading of the trees."""

import json
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from codegen.policy_json import dumps
from codegen.sums import DOUBLE_SUMS, FLOAT32_STEPS
from maviper.cli import main
from maviper.files.profiles import load
from maviper.verification.ask import VerifyOptions
from maviper.verification.run import results
from tests.hunting.summing import Team
from tests.support.game_sums import team
from tests.support.generated import FOLDER
from verify.claims.region import Region
from verify.claims.uncertified.starts import start_region
from verify.result import Verdict

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
    [
        range(1),
        pytest.param(range(1, 5), marks=pytest.mark.slow),
        pytest.param(range(5, 80), marks=pytest.mark.full),
    ],
    ids=["one", "some", "many"],
)
def test_verdicts_are_true_of_mpe2(seeds, tmp_path):
    verdicts = []
    for seed in seeds:
        profile = team(seed + 1, (DOUBLE_SUMS, FLOAT32_STEPS)[seed % 2], levels=2)
        name, steps = ("stays_in", "keeps_apart", "covers", "reaches")[seed % 4], 4
        region = region_of(profile, seed, Fraction(1, (64, 256)[seed % 3 > 0]))
        (tmp_path / "drawn.toml").write_text(region.toml())
        asked = VerifyOptions.about(name, str(tmp_path / "drawn.toml"), {"radius": RADII[name], "steps": steps})
        outcomes = results(profile, replace(asked, max_boxes=100_000, verdict_only=True))
        ensure_true(profile, name, RADII[name], steps, region, outcomes)
        verdicts += [each.verdict for each in outcomes]
    assert len(verdicts) < 5 or {Verdict.PROVED, Verdict.VIOLATED} <= set(verdicts)


@pytest.fixture(scope="module")
def answered(tmp_path_factory):
    """A folder with a proof and a counterexample."""
    folder = tmp_path_factory.mktemp("episodes")
    profile = team(1, levels=2)
    (folder / "team.json").write_text(dumps(profile))
    (folder / "region.toml").write_text(region_of(profile, 0, Fraction(1, 256)).toml())
    (folder / "claims.toml").write_text(
        '[[property]]\nname = "keeps_apart"\nradius = 2\nsteps = 3\n\n'
        '[[property]]\nname = "stays_in"\nradius = 2\nsteps = 3\n'
    )
    words = ["verify", str(folder / "team.json"), "--properties", str(folder / "claims.toml")]
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
        (["--property", "reaches"], "one goal, and region start has several"),
        (["--property", "stays_in", "--region", "{folder}/region.toml"], "stays_in for ever is not decided"),
        (["--property", "reaches", "--property", "own_target"], "own_target is about single decisions"),
    ],
)
def test_what_is_not_decided_is_refused(answered, asked_for, message, capsys):
    words = [each.format(folder=answered) for each in asked_for]
    assert main.run(["verify", str(answered / "team.json"), *words]) == 2
    assert message in capsys.readouterr().err


def test_boxes_are_counted_of_world_files_alone(capsys):
    assert main.run(["verify", str(FOLDER / "profile.json"), "--max-boxes", "5"]) == 2
    assert "--max-boxes has no effect without --world" in capsys.readouterr().err
    assert load(FOLDER / "profile.json").agents
