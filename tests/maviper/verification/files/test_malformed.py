"""Certificates whose members are anything: each is accepted or refused in words, and none ends as a bug of ours."""

import json
import lzma
from pathlib import Path

import pytest

import maviper
from codegen.errors import MaviperError, RefusedError
from codegen.policy_json import dumps
from maviper.cli.main import run
from maviper.verification.files.certificates import check_file
from tests.support.altered import edited, sealed
from tests.support.observations import blind
from tests.support.teams import tree

GENERATED = Path(__file__).parents[4] / "generated"
FILES = {
    "decisions": "proved_defenders/certificate-1-distinct_targets.json",
    "episodes": "verdicts/physical_deception/certificate-7-reaches.json.xz",
    "symbolic states": "../tests/golden/system_certificate_1/certificate-1-stays_in.json",
    "boxes": "worlds/corridor/certificate-1-avoids.json",
    "flow": "arch/pendulum/certificate-1-reaches_and_stays.json",
    "for ever": "worlds/tanks/certificate-2-always.json",
}
STRANGE = ("1/3", "", "1/0", "1e999", ["x"], [], {}, {"x": "1"}, None, True, -1, 10**30, 0.5)
LARGE = ("cuts", "proof", "proofs", "regions", "formula", "invariant", "box")  # of these a few members stand for all


def members(value, path=()):
    """The path of each member of a document; of long lists and tables the first one's."""
    items = list(value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ())
    for key, item in items[:1] if path and (path[0] in LARGE or isinstance(value, list)) else items:
        if key != "content_hash":
            yield (*path, key)
            yield from members(item, (*path, key))


def refuse_all(document, folder, given, every=1, **files):
    """Checks changed documents, one of `every`; how many were refused."""
    file, refused = folder / "changed.json", 0
    pairs = [(path, strange) for path in members(document) for strange in (*STRANGE, KeyError)]
    for path, strange in pairs[::every]:
        file.write_text(sealed(edited(document, path, strange)))
        try:
            check_file(file, given, **files)
        except MaviperError:
            refused += 1
        except Exception as error:
            pytest.fail(f"{path} as {strange!r}: {type(error).__name__} {error}")
    return refused


SLOW = {"for ever": 4}  # rules with curves are shown again each time


@pytest.mark.parametrize("every", [11, pytest.param(1, marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", FILES)
def test_strange_members_are_refused(name, every, tmp_path):
    place = GENERATED / FILES[name]
    packed = place.suffix == ".xz"
    document = json.loads(lzma.decompress(place.read_bytes()) if packed else place.read_text())
    world = place.parent / "world.toml"
    files = {"world": world} if world.exists() else {}
    profile = place.parent / "profile.json"
    given = maviper.load(profile if profile.exists() else GENERATED / "physical_deception" / "profile.json")
    assert refuse_all(document, tmp_path, given, every * SLOW.get(name, 1), **files) > 5


@pytest.mark.parametrize("every", [5, pytest.param(1, marks=pytest.mark.slow)])
def test_claims_over_observations_name_what_there_is(every, tmp_path):
    """An unknown feature ended as a bug of ours."""
    profile = blind({"a": tree((0, 0.5, 1, 2), 0, 1)}, {"a": ["angle", "spin"]})
    (tmp_path / "profile.json").write_text(dumps(profile))
    asked = ["--observations", "--claim", "ignores(agent=a, feature=spin)"]
    assert run(["verify", str(tmp_path / "profile.json"), *asked, "-o", str(tmp_path / "out")]) == 0
    document = json.loads((tmp_path / "out" / "certificate-1-ignores.json").read_text())
    assert refuse_all(document, tmp_path, profile, every) > 5
    (tmp_path / "changed.json").write_text(sealed(edited(document, ("property", "feature"), "tilt")))
    with pytest.raises(RefusedError, match="the formula is not the one that ignores has"):
        check_file(tmp_path / "changed.json", profile)
