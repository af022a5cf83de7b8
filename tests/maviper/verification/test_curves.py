"""Claims with products of variables, from a file of claims to certificate, check, replay and report."""

from pathlib import Path

import pytest

from codegen.errors import ExitCode
from maviper.cli.main import run as command

WORLDS = Path(__file__).parents[3] / "generated" / "worlds"
CLAIMS = """
[[property]]
label = "it pushes after a pole that falls further"
formula = "angle*spin > 0.5 and angle > 0 implies acts(cart) == right"
cuts = { angle = 10, spin = 10 }

[[property]]
label = "to any side"
formula = "angle*spin > 0.1 implies acts(cart) == right"
cuts = { angle = 10, spin = 10 }

[[property]]
label = "too fine for such wide cells"
formula = "angle*spin > 0.01 and angle > 0 implies acts(cart) == right"
cuts = { angle = 2, spin = 2 }
"""


@pytest.fixture(scope="module")
def answered(tmp_path_factory):
    folder = tmp_path_factory.mktemp("curves")
    (folder / "claims.toml").write_text(CLAIMS)
    profile, world = WORLDS / "pendulum.json", WORLDS / "pendulum.toml"
    options = ["--system", str(world), "--claims", str(folder / "claims.toml"), "-o", str(folder / "out")]
    return command(["verify", str(profile), *options]), folder / "out"


def test_verdicts_and_what_helps(answered):
    code, out = answered
    told = (out / "report.txt").read_text()
    assert code == ExitCode.VIOLATED
    for words in (
        "1. it pushes after a pole that falls further: PROVED",
        "formula    angle*spin > 0.5 and angle > 0 implies acts(cart) == right",
        "2. to any side: VIOLATED",
        "3. too fine for such wide cells: UNKNOWN",
        "holds or fails within what the enclosures of its products and functions leave open",
        "more `cuts` of the claim",
    ):
        assert words in told


def test_a_certificate_is_checked_with_its_enclosures(answered, capsys):
    _, out = answered
    (certificate,) = out.glob("certificate-*.json")
    assert command(["check", str(certificate)]) == ExitCode.DONE
    told = capsys.readouterr().out
    assert "angle*spin > 0.5 and angle > 0 implies acts(cart) == right, by 100 enclosures shown again" in told


def test_a_certificate_beside_a_file_of_claims_by_its_old_name(answered, capsys):
    _, out = answered
    (certificate,) = out.glob("certificate-*.json")
    (out / "claims.toml").rename(out / "properties.toml")
    try:
        assert command(["check", str(certificate)]) == ExitCode.DONE
        assert "by 100 enclosures shown again" in capsys.readouterr().out
    finally:
        (out / "properties.toml").rename(out / "claims.toml")


def test_without_the_file_of_claims_a_check_says_what_was_proved_alone(answered, capsys):
    _, out = answered
    (certificate,) = out.glob("certificate-*.json")
    claims = out / "claims.toml"
    text = claims.read_text()
    claims.write_text(text.replace("angle*spin > 0.5 and angle", "angle*spin > 0.6 and angle"))
    try:
        assert command(["check", str(certificate)]) == ExitCode.DONE
        assert "enclosures shown again" not in capsys.readouterr().out
    finally:
        claims.write_text(text)


def test_a_counterexample_replays(answered):
    _, out = answered
    (found,) = out.glob("counterexample-*.json")
    assert command(["replay", str(found)]) == ExitCode.VIOLATED
