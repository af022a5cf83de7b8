"""`maviper check` after something was changed: it refuses, or says exactly what the certificate holds."""

import json
import re

import pytest

from codegen import policy_json
from codegen.errors import MaviperError
from maviper.cli import main
from maviper.verification.files.certificates import check_file
from tests.support.observations import blind
from tests.support.small import small_profile
from tests.support.teams import team, towards, tree

pytestmark = pytest.mark.solver
CLAIM = '[[property]]\nlabel = "q"\nformula = "angle < {} implies acts(cart) == left"\nregion = "near.toml"\n'
REGION = "[box]\nangle = [{}, 1]\n"
HIDDEN = {"content_hash"}


def run(*arguments):
    return main.run([*map(str, arguments)])


@pytest.fixture
def proved(tmp_path):
    """A folder with profile, property file, region file and, in `out`, the certificate of a proof."""
    cart = blind({"cart": tree((0, 0.5, 1, 2), 0, 2)})
    (tmp_path / "profile.json").write_text(policy_json.dumps(cart))
    (tmp_path / "q.toml").write_text(CLAIM.format("1/4"))
    (tmp_path / "near.toml").write_text(REGION.format(-1))
    assert run("verify", tmp_path / "profile.json", "--claims", tmp_path / "q.toml", "-o", tmp_path / "out") == 0
    return tmp_path


def test_another_property_or_region_file_changes_nothing_that_is_said(proved):
    certificate = proved / "out" / "certificate-1-formula.json"
    before = check_file(certificate, proved / "profile.json").subject
    # what is a float32 number of at least 1/4 once it is rounded
    assert "angle in [-1, 1]" in before and "-1 * angle <= -0.249999992549419403076171875" in before
    assert "acts(cart) == left" in before
    (proved / "q.toml").write_text(CLAIM.format("3/4"))  # which is violated
    (proved / "near.toml").write_text(REGION.format(-2))
    assert check_file(certificate, proved / "profile.json").subject == before
    again = ["verify", proved / "profile.json", "--claims", proved / "q.toml", "-o", proved / "out"]
    assert run(*again) == 1 and not certificate.exists()


def leaves(document, path=()):
    """The places of all plain values in a document."""
    if isinstance(document, dict | list):
        for key, value in document.items() if isinstance(document, dict) else enumerate(document):
            yield from leaves(value, (*path, key))
    else:
        yield path


def other(value):
    if isinstance(value, bool) or value is None:
        return not value
    return value + 1 if isinstance(value, int | float) else f"{value}x" if isinstance(value, str) else value


def changed(text, path):
    document = json.loads(text)
    place = document
    for key in path[:-1]:
        place = place[key]
    place[path[-1]] = other(place[path[-1]])
    document.pop("content_hash", None)
    return json.dumps(document)


@pytest.mark.parametrize("game", [False, True])
def test_every_value_of_a_profile_is_under_the_certificate(game, tmp_path):
    """Whatever is changed in the profile, hash left out: it is refused, whether it matters to the claim or not."""
    profile = (
        team(small_profile(), towards(0, 0), towards(1, 1)) if game else blind({"cart": tree((0, 0.5, 1, 2), 0, 2)})
    )
    text = policy_json.dumps(profile)
    (tmp_path / "profile.json").write_text(text)
    (tmp_path / "q.toml").write_text(CLAIM.format("1/4").replace('region = "near.toml"\n', ""))
    asked = ["--claim", "distinct_targets"] if game else ["--claims", tmp_path / "q.toml"]
    assert run("verify", tmp_path / "profile.json", *asked, "-o", tmp_path / "out") == 0
    (certificate,) = (tmp_path / "out").glob("certificate-1-*.json")
    check_file(certificate, tmp_path / "profile.json")
    accepted = set()
    for path in leaves(json.loads(text)):
        if path[0] in HIDDEN:
            continue
        (tmp_path / "profile.json").write_text(changed(text, path))
        try:
            check_file(certificate, tmp_path / "profile.json")
            accepted.add(re.sub(r"\d+", "N", ".".join(map(str, path))))
        except MaviperError:
            pass
    assert accepted == set()
