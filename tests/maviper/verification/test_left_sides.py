"""Implications whose left side never holds are VACUOUS, and decimals beside a feature are floats: by what files say."""

import textwrap
from dataclasses import replace

import numpy as np
import pytest

from codegen.errors import InputError, RefusedError
from maviper.cli.main import run
from maviper.files.profiles import load
from maviper.verification.ask import VerifyOptions
from maviper.verification.files.certificates import check_file
from maviper.verification.run import verify_world
from tests.support.altered import read_game, resealed
from tests.support.pole import pole
from verify.certificates.games import to_json
from verify.checker.decisions import FORM, MET
from verify.result import Verdict

pytestmark = pytest.mark.solver
DOSE = """
    def dose(level: float) -> str:
        return "hold" if level == 0.1 else "open"
"""
STEP = """
    def step(x) -> str:
        return "low" if x[0] <= 0.1 else "high"
"""
PUMP = """
    def pump(glucose: float) -> float:
        return 0.0 if glucose < 80.0 else 0.8
"""
WORLD = """
    name = "pump"
    [variables]
    glucose = { unit = "mg/dL", range = [20, 400] }
    [agents.pump.features]
    glucose = "glucose"
    [agents.pump.outputs]
    basal = "U/h"
    [start]
    box = { glucose = 100 }
"""


def imported(folder, source, *options):
    """The profile of a function."""
    (folder / "source.py").write_text(textwrap.dedent(source))
    assert run(["import", str(folder / "source.py"), *options, "-o", str(folder / "profile.json")]) == 0
    return folder / "profile.json"


def answered(profile, claims, world=None, **options):
    """The results of formulas."""
    tables = [f"formula = '''{each}'''" for each in claims]
    properties = profile.parent / "claims.toml"
    properties.write_text("".join(f"[[property]]\n{table}\n" for table in tables))
    asked = VerifyOptions(file=properties, world=world, **options)
    return verify_world(load(profile, sums=True), asked)


def verdicts(profile, claims, world=None, **options):
    return [result.verdict.value for result in answered(profile, claims, world, **options).results]


CLAIMS = {
    "level == 0.1 implies acts(dose) == hold": "PROVED",
    "level == 0.1 implies acts(dose) == open": "VIOLATED",
    "level == exact(0.1) implies acts(dose) == hold": "VACUOUS",
    "level == exact(0.1) implies acts(dose) == open": "VACUOUS",
    "exact(0.1) == level implies acts(dose) == open": "VACUOUS",
    "level == 1/10 implies acts(dose) == hold": "VACUOUS",
    "level > 1 and level < 0 implies acts(dose) == open": "VACUOUS",
    "(level > 1 and level < 0 implies acts(dose) == open) and (level > 1 and level < 0 implies acts(dose) == hold)": (
        "VACUOUS"
    ),
    "not (level > 1 and level < 0) or acts(dose) == open": "VACUOUS",
    "acts(dose) == open or not (level > 1 and level < 0)": "VACUOUS",
    "(level == 0.1 implies acts(dose) == hold) and (false implies acts(dose) == open)": "VACUOUS",
    "(level == 0.1 implies acts(dose) == open) and (false implies acts(dose) == open)": "VIOLATED",
    "acts(dose) == hold implies level == 0.1": "PROVED",
    "acts(dose) == hold and level < 0 implies level == 0.1": "VACUOUS",
    "not level < 0 or not level > 1": "PROVED",  # never both: each can hold
    "|level| < 0.1 implies acts(dose) == open": "PROVED",
    "|level| <= 0.1 implies acts(dose) == open": "VIOLATED",
    "level + level == exact(0.2) implies acts(dose) == open": "VACUOUS",
}


def test_a_left_side_must_be_met(tmp_path):
    profile = imported(tmp_path, DOSE)
    done = answered(profile, CLAIMS)
    assert dict(zip(CLAIMS, [result.verdict.value for result in done.results], strict=True)) == CLAIMS
    reasons = {text: result.reason for text, result in zip(CLAIMS, done.results, strict=True)}
    assert reasons["level == exact(0.1) implies acts(dose) == open"].endswith("condition: level == exact(0.1)")
    assert reasons["not (level > 1 and level < 0) or acts(dose) == open"].endswith("condition: level > 1 and level < 0")


def test_a_vacuous_claim_is_no_success(tmp_path, capsys):
    profile = imported(tmp_path, DOSE)
    (tmp_path / "claims.toml").write_text("[[property]]\nformula = 'level > 1 and level < 0 implies level > 5'\n")
    assert run(["verify", str(profile), "--claims", str(tmp_path / "claims.toml")]) == 3
    assert "no observation of the region meets the condition: level > 1 and level < 0" in capsys.readouterr().out


@pytest.mark.parametrize("arrays", ["float32", "float64"])
def test_a_decimal_is_the_number_that_the_program_reads(tmp_path, capsys, arrays):
    profile = imported(tmp_path, STEP, "--arrays", arrays)
    claims = {
        "x0 > 0.1 implies acts(step) == high": "PROVED",
        "x0 <= 0.1 implies acts(step) == low": "PROVED",
        "x0 >= 0.1 implies acts(step) == high": "VIOLATED",
        "acts(step) == low implies -0.1 > -x0 or x0 == 0.1 or 0.1 > x0": "PROVED",
    }
    assert verdicts(profile, claims) == list(claims.values())
    assert run(["verify", str(profile), "--claims", str(tmp_path / "claims.toml"), "--verdict-only"]) == 1
    said = {"float32": "0.1, read as 0.100000001490116\n", "float64": "0.1, read as 0.10000000000000001\n"}
    assert capsys.readouterr().err.count(said[arrays]) == 1
    assert '"0.1, read as' in answered(profile, claims).reports["report.json"]


@pytest.mark.parametrize("numbers", ["float32", "float64"])
def test_a_decimal_is_the_nearest_float(tmp_path, numbers):
    """Against numpy's own reading of random decimals."""
    profile, rng = imported(tmp_path, STEP, "--arrays", numbers), np.random.default_rng(0)
    for _ in range(12):
        text = f"{rng.uniform(-1, 1):.{rng.integers(1, 12)}f}"
        near = np.dtype(numbers).type(text)
        below, above = (float(np.nextafter(near, near.dtype.type(end))) for end in (-9, 9))
        claims = [
            f"x0 == {text} implies x0 > exact({below:.60g}) and x0 < exact({above:.60g})",
            f"x0 < {text} implies x0 <= exact({below:.60g})",
            f"x0 > {text} implies x0 >= exact({above:.60g})",
        ]
        claims = [claim.replace("exact(-", "-exact(") for claim in claims]
        assert verdicts(profile, claims) == ["PROVED"] * 3, text


def test_a_feature_of_two_types_needs_exact(tmp_path):
    profile, other = pole("float32"), pole("float64")
    world = replace(
        profile.world, agents=tuple(replace(profile.world.agents[0], name=name) for name in ("pole", "other"))
    )
    profile = replace(profile, world=world, agents=(*profile.agents, replace(other.agents[0], agent="other")))
    claims = tmp_path / "claims.toml"
    options = VerifyOptions(file=claims, shared=("all",), observations=True)
    claims.write_text("[[property]]\nformula = 'angle > 0.1 implies acts(pole) != left'\n")
    with pytest.raises(InputError, match="agents observe angle in unlike types"):
        verify_world(profile, options)
    claims.write_text("[[property]]\nformula = 'angle > exact(0.5) implies acts(pole) != left'\n")
    assert verify_world(profile, options).results[0].verdict is Verdict.PROVED


def test_neither_a_state_nor_a_proof_of_none(tmp_path):
    """No two floats add up to a tenth, and no engine knows."""
    claims = tmp_path / "claims.toml"
    claims.write_text("[[property]]\nformula = 'angle + speed == 0.1 implies acts(pole) in [left, right, none]'\n")
    (result,) = verify_world(pole("float64"), VerifyOptions(file=claims)).results
    assert result.verdict is Verdict.UNKNOWN and "angle + speed == 0.1" in result.reason


def test_the_certificate_states_left_sides_and_the_checker_asks_their_states(tmp_path):
    profile = imported(tmp_path, DOSE)
    done = answered(profile, ["level == 0.1 implies acts(dose) == hold"])
    (name, text), path = *done.certificates.items(), tmp_path / "certificate.json"
    read = read_game(text)
    assert read.header.certificate == MET and len(read.claim.premises) == 1 and to_json(read) == text
    path.write_text(text)
    assert "some state meets each of its conditions: " in check_file(path).subject and name.endswith(".json")

    def fail(document):
        document["premises"][0]["state"] = {"level": "1/2"}

    path.write_text(resealed(text, fail))
    with pytest.raises(RefusedError, match="does not meet it"):
        check_file(path)

    def leave(document):
        document["premises"][0]["state"] = {"level": "1/10"}

    path.write_text(resealed(text, leave))
    with pytest.raises(RefusedError, match="not one of float64 numbers"):
        check_file(path)

    def age(document):
        document["certificate"] = FORM
        del document["premises"]

    path.write_text(resealed(text, age))
    assert "does not show that its left side can hold" in check_file(path).subject


SYSTEM = {
    "glucose < 80 implies out(pump).basal <= 0": "VIOLATED",
    "out(pump).basal > 0.1 implies glucose >= 80": "VIOLATED",
    "glucose < 90 implies out(pump).basal <= 0": "VIOLATED",
    "glucose <= 79.99999999999999 implies out(pump).basal <= 0": "PROVED",
    "glucose < 10 implies out(pump).basal <= 0": "VACUOUS",
    "out(pump).basal > 0.9 implies glucose >= 80": "VACUOUS",
    "not glucose < 10 or out(pump).basal > 5": "VACUOUS",
}


def test_claims_of_a_world_file(tmp_path):
    profile, world = imported(tmp_path, PUMP, "--outputs", "basal"), tmp_path / "world.toml"
    world.write_text(textwrap.dedent(WORLD))
    done = answered(profile, SYSTEM, world)
    assert dict(zip(SYSTEM, [result.verdict.value for result in done.results], strict=True)) == SYSTEM
    rounding = [result.evidence.rounding for result in done.results]
    moved = "fails only where glucose is rounded when it is observed: proved with glucose "
    assert rounding[0] == f"{moved}<= 79.99999999999999 in place of glucose < 80"
    assert rounding[1] == f"{moved}> 79.99999999999999 in place of glucose >= 80"
    assert not any(rounding[2:]) and moved in done.reports["report.txt"]
    assert done.results[4].reason == "no state meets the condition: glucose < 10"
    assert done.results[5].reason == "no state meets the condition: out(pump).basal > 0.9"


def test_the_certificate_of_a_system_states_left_sides(tmp_path):
    profile, world = imported(tmp_path, PUMP, "--outputs", "basal"), tmp_path / "world.toml"
    world.write_text(textwrap.dedent(WORLD))
    done = answered(profile, ["glucose <= 79 implies out(pump).basal <= 0"], world)
    (text,), path = done.certificates.values(), tmp_path / "certificate.json"
    path.write_text(text)
    assert "1 state in it shown to meet its conditions" in check_file(path).subject

    def fail(document):
        document["claim"]["premises"][0]["state"] = {"glucose": "80"}

    path.write_text(resealed(text, fail))
    with pytest.raises(RefusedError, match="does not meet it"):
        check_file(path)

    def age(document):
        del document["claim"]["premises"]

    path.write_text(resealed(text, age))
    assert "does not show that its left side can hold" in check_file(path).subject


def test_decimals_over_observations_of_agents_that_give_numbers(tmp_path):
    profile = imported(tmp_path, PUMP, "--outputs", "basal")
    (tmp_path / "region.toml").write_text("default = [0, 400]\n")
    claims = {
        "glucose < 80 implies out(pump).basal <= 0": "PROVED",
        "glucose <= 80 implies out(pump).basal <= 0": "VIOLATED",
        "glucose == exact(80.1) implies out(pump).basal <= 0": "VACUOUS",
        "glucose == 80.1 implies out(pump).basal > 0": "PROVED",
    }
    assert verdicts(profile, claims, region=str(tmp_path / "region.toml")) == list(claims.values())
