"""What trees meet: ranges of features from batches of any size, and where profiles keep and use them."""

import json
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from codegen.errors import ExitCode, InputError
from codegen.policy_json import content_hash, dumps
from codegen.profiles import check, loads
from maviper.episodes import trees
from maviper.episodes.trees import Ranges
from maviper.page.document import document
from maviper.page.page import contents_of
from maviper.verification.ask import resolve_region
from tests.support.pole import pole
from tests.support.verifying import run
from verify.claims.observed import View
from verify.claims.views import Viewed

SEEN = ((-0.5, -0.25, 0.5, 1.5), (0.0, 0.0, 2.0, 2.0))


def looked(numbers="float32"):
    profile = pole(numbers)
    return replace(profile, agents=(replace(profile.agents[0], seen=SEEN),))


@pytest.mark.parametrize("kept", [10, 500, 10_000])
def test_ranges_are_those_of_all_rows_in_whatever_batches(monkeypatch, kept):
    monkeypatch.setattr(trees, "KEPT", kept)
    rng = np.random.default_rng(3)
    rows = rng.normal(size=(2_000, 3)).astype(np.float32)
    rows[7, 1], rows[8, 1] = np.nan, np.inf
    found, place = Ranges(3), 0
    while place < len(rows):
        size = int(rng.integers(0, 300))
        found.add(rows[place : place + size])
        place += size
    finite = np.where(np.isfinite(rows), rows, np.nan)
    for column, (least, low, high, most) in enumerate(found.summarise()):
        assert (least, most) == (np.nanmin(finite[:, column]), np.nanmax(finite[:, column]))
        exact = np.nanpercentile(finite[:, column], [1, 99], method="nearest")
        if kept == 10_000:
            assert [low, high] == exact.tolist()
        assert least <= low <= high <= most and (kept < 500 or np.allclose([low, high], exact, atol=0.5))


def test_what_was_never_finite_has_no_range():
    found = Ranges(1)
    found.add(np.full((3, 1), np.nan, dtype=np.float32))
    assert Ranges(2).summarise() == () == found.summarise()


@pytest.mark.parametrize("numbers", ["float32", "float64"])
def test_profiles_keep_them_and_those_without_have_the_hash_of_before(numbers):
    plain, profile = pole(numbers), looked(numbers)
    again = loads(dumps(profile))
    assert again.agents[0].seen == SEEN and content_hash(again) == content_hash(profile) != content_hash(plain)
    assert '"seen"' not in dumps(plain) and loads(dumps(plain)).agents[0].seen == ()
    without = json.loads(dumps(profile))
    for feature in without["agents"][0]["features"]:
        del feature["seen"]
    without["content_hash"] = content_hash(plain)
    assert content_hash(loads(json.dumps(without))) == content_hash(plain)


@pytest.mark.parametrize("seen", [SEEN[:1], ((1.0, 0.0, 2.0, 3.0), SEEN[1]), ((0.0, 0.0, 0.0, np.inf), SEEN[1])])
def test_ranges_that_are_none_are_refused(seen):
    profile = pole("float32")
    assert any(
        "seen" in found.message or "seen" in found.path
        for found in check(replace(profile, agents=(replace(profile.agents[0], seen=seen),)))
    )


def test_regions_over_observations_are_what_was_seen():
    viewed = Viewed(looked(), View())
    for name in ("start", "seen"):
        region = resolve_region(viewed.profile, viewed, name)
        assert region.name == "seen" and region.box == {"angle": (Fraction(-1, 2), Fraction(3, 2)), "speed": (0, 2)}
    assert resolve_region(viewed.profile, viewed, "ranges").box["angle"] == (-(10**9), 10**9)
    unseen = Viewed(pole("float32"), View())
    assert resolve_region(unseen.profile, unseen, "start").name == "start"
    with pytest.raises(InputError, match="what was seen"):
        resolve_region(unseen.profile, unseen, "seen")


@pytest.mark.solver
def test_claims_and_shares_are_about_what_was_seen(tmp_path, capsys):
    (tmp_path / "pole.json").write_text(dumps(looked()))
    claim = '[[property]]\nformula = "angle > -1"\n[[property]]\nformula = "acts(pole) == left"\nregion = "start"\n'
    (tmp_path / "claims.toml").write_text(claim)
    asked = ["verify", str(tmp_path / "pole.json"), "--claims", str(tmp_path / "claims.toml"), "--json"]
    code, out, err = run(capsys, *asked)
    first, second = json.loads(out)["results"]
    assert code == ExitCode.VIOLATED and (first["verdict"], second["verdict"]) == ("PROVED", "VIOLATED"), err
    assert second["region_name"] == "seen" and second["violating"]["share"] == pytest.approx(0.75, abs=0.05)
    _, out, _ = run(capsys, *asked, "--region", "ranges")
    assert json.loads(out)["results"][0]["verdict"] == "VIOLATED"


def test_sliders_go_over_what_was_seen():
    profile = looked()
    (agent,) = document(profile, contents_of(profile, ()))["agents"]
    assert [(one["low"], one["high"]) for one in agent["features"]] == [(-1e9, 1e9), (-1e9, 1e9)]
    for (low, high), (least, most) in zip(agent["shown"], [(-0.5, 1.5), (0.0, 2.0)], strict=True):
        assert least - 1.5 < low < least and most < high < most + 1.5
