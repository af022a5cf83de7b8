"""Claims about agents that give numbers, from a world file to certificates, counterexamples and refusals."""

import json
from dataclasses import replace

import pytest

import maviper
from codegen.errors import InputError
from codegen.sums import FLOAT64_SUMS
from maviper.cli import main
from maviper.files.profiles import load
from maviper.verification.files.certificates import check_file
from maviper.verification.files.counterexamples import replay
from tests.support import summed
from tests.support.giving import CART, integrator, tamed
from verify.result import Verdict

WORLD = (
    integrator("0.5")
    + """
[[property]]
label = "bounded"
formula = "out(cart).push <= 2 and out(cart).push >= -2[m/s^2]"
[[property]]
label = "bounded by less"
formula = "out(cart).push < 2"
[[property]]
label = "pushes back"
formula = "x >= 1 and v >= 0 implies out(cart).push <= -1.25"
[[property]]
label = "pushes back harder"
formula = "x >= 1 and v >= 0 implies out(cart).push <= -1.2500001"
[[property]]
label = "stays"
name = "stays_in"
region = { box = { x = [-1.5, 1.5], v = [-1.5, 1.5] } }
[[property]]
label = "hardly moves"
name = "stays_in"
region = { box = { x = [-1.04, 1.04] } }
"""
)
VERDICTS = ["PROVED", "VIOLATED", "UNKNOWN", "VIOLATED", "PROVED", "VIOLATED"]


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """A folder with the report of a linear controller."""
    folder = tmp_path_factory.mktemp("giving")
    (folder / "cart.py").write_text(CART)
    (folder / "world.toml").write_text(WORLD)
    given = ["import", "--agents", f"cart={folder / 'cart.py'}", "--arrays", "float64", "--outputs", "push"]
    assert main.run([*given, "-o", str(folder / "cart.json")]) == 0
    asked = ["verify", str(folder / "cart.json"), "--system", str(folder / "world.toml"), "-o", str(folder / "out")]
    assert main.run(asked) == 1
    return folder


def test_verdicts_are_about_the_sums_as_they_are_computed(place):
    report = json.loads((place / "out" / "report.json").read_text())
    assert [result["verdict"] for result in report["results"]] == VERDICTS
    # at x = 1, v = 0 the sum may be above -1.25 by its rounding alone; the agent itself gives -1.25
    assert "no state that breaks it" in report["results"][2]["reason"]  # it is about single decisions: no episodes
    assert not any("episode" in word or "step" in word for word in report["results"][2]["helps"])
    assert "AGENT.rounding_of_" in report["semantics"]


def test_certificates_are_accepted_and_say_what_was_asked(place):
    accepted = {path.name: check_file(path) for path in sorted((place / "out").glob("certificate-*.json"))}
    assert sorted(accepted) == ["certificate-1-decides.json", "certificate-5-stays_in.json"]
    said = [each.subject for each in accepted.values()]
    assert "out(cart).push <= 2" in said[0] and "for" not in said[0] and "12 steps" in said[1]


def test_counterexamples_are_played_by_the_agent_itself(place, tmp_path):
    profile = load(place / "cart.json", sums=True)
    found = sorted((place / "out").glob("counterexample-*.json"))
    assert [path.name[:16] for path in found] == [f"counterexample-{place}" for place in (2, 4, 6)]
    for path in found:
        again = replay(path, profile)
        assert again.violated and again.same_policy
    # with a rounding that the agent does not make, the claim is not known to be broken
    document = json.loads(found[1].read_text())
    (name,) = [name for name in document["start"] if "output" in name]
    document["start"][name] = "1/1000000000000000"
    moved = tmp_path / "moved.json"
    moved.write_text(json.dumps(document))
    assert replay(moved, profile, place / "world.toml").violated  # by the agent's own, all the same


def test_a_file_that_others_play_is_refused_by_name(place, capsys):
    assert main.run(["worlds", "check", f"system:{place / 'world.toml'}"]) == 0
    capsys.readouterr()
    world = f"system:{place / 'world.toml'}"
    assert main.run(["evaluate", "random", "--world", world]) == 2
    assert "cart gives numbers" in capsys.readouterr().err
    missing = place / "other.toml"
    missing.write_text(WORLD.replace("push", "pull"))
    assert main.run(["verify", str(place / "cart.json"), "--system", str(missing)]) == 2
    assert "cart gives push, and in the file pull" in capsys.readouterr().err


MIXED = """
name = "two kinds"
steps = 2
[variables]
x = { range = [-4, 4] }
[agents.agent_0.features]
x0 = "x"
x1 = "2*x"
x2 = "0.5*x"
[agents.agent_0.outputs]
u0 = "1"
[agents.agent_1.features]
x0 = "x"
x1 = "x + 1"
x2 = "x - 1"
[agents.agent_1.actions]
left = { push = -1 }
stay = { push = "0.5*x" }
right = { push = 1 }
[start]
box = { x = [-1, 1] }
[dynamics.next]
x = "x"
[[property]]
formula = "out(agent_0).u0 + out(agent_1).push <= 4"
[[property]]
formula = "out(agent_0).u0 + out(agent_1).push <= -2"
"""


def test_a_formula_may_name_what_an_action_sets_beside_what_another_agent_gives(tmp_path):
    """Counterexamples too are judged by both."""
    gives = tamed(summed.policy(3, FLOAT64_SUMS, outputs=1, levels=2, n_features=3))
    gives = replace(gives, outputs=tuple(replace(each, unit="1") for each in gives.outputs))
    profile = summed.profile(gives, tamed(summed.policy(4, FLOAT64_SUMS, levels=2, n_features=3, agent="agent_1")))
    (tmp_path / "world.toml").write_text(MIXED)
    results = maviper.verify_system(profile, tmp_path / "world.toml").results
    assert [each.verdict for each in results] == [Verdict.PROVED, Verdict.VIOLATED]


@pytest.mark.parametrize(
    "formula", ["x <= 4 or acts(cart) == leaf_2", "acts( cart ) in [leaf_1]", "acts(cart) == acts(cart)"]
)
def test_an_agent_that_gives_numbers_takes_no_action_in_formulas(formula, place, tmp_path):
    """Its leaves are actions of proofs, whose names say nothing of what it gives."""
    world = tmp_path / "world.toml"
    world.write_text(f'{integrator("0.5")}[[property]]\nformula = "{formula}"\n')
    with pytest.raises(InputError, match="cart gives numbers, and takes no action") as error:
        maviper.verify_system(load(place / "cart.json", sums=True), world)
    assert f"column {formula.index('acts') + 1}" in str(error.value) and "out(cart).push" in str(error.value)


LAW = """#pragma STDC FP_CONTRACT OFF
float thrust(float z, float vz)
{
    const float kp = 2.5f, kd = 1.2f, ff = 0.4f, target = 1.0f;
    if (z < 0.05f) return 0.0f;
    float u = ff + kp * (target - z) - kd * vz;
    if (u > 1.0f) u = 1.0f;
    if (u < 0.0f) u = 0.0f;
    return u;
}
"""
HOVER = """name = "hover"
steps = 60
dt = "0.1 s"
[variables]
z = { unit = "m", range = [-1, 3] }
vz = { unit = "m/s", range = [-3, 3] }
[agents.thrust.features]
z = "z"
vz = "vz"
[agents.thrust.outputs]
u = "1"
[start]
box = { z = [0.4, 0.6], vz = [0, 0] }
[dynamics.next]
z = "z + dt*vz"
vz = "vz + dt*(10[m/s^2]*thrust.u - 5[m/s^2])"
[[property]]
name = "stays_in"
region = { box = { z = [0, 2] } }
[[property]]
name = "stays_in"
region = { box = { z = [0, 0.8] } }
"""


@pytest.mark.parametrize("law", ["kp * (target - z) - kd * vz", "(target - z) / 0.4f - vz / 0.83f"])
def test_the_law_that_flies_is_proved(law, tmp_path):
    """A sum within a sum, as people write control laws: its roundings are those of its own order."""
    (tmp_path / "law.c").write_text(LAW.replace("kp * (target - z) - kd * vz", law))
    (tmp_path / "hover.toml").write_text(HOVER)
    assert main.run(["import", str(tmp_path / "law.c"), "--outputs", "u", "-o", str(tmp_path / "law.json")]) == 0
    asked = ["verify", str(tmp_path / "law.json"), "--system", str(tmp_path / "hover.toml")]
    assert main.run([*asked, "-o", str(tmp_path / "out")]) == 1
    report = json.loads((tmp_path / "out" / "report.json").read_text())
    assert [result["verdict"] for result in report["results"]] == ["PROVED", "VIOLATED"]
    assert check_file(tmp_path / "out" / "certificate-1-stays_in.json")
    (found,) = (tmp_path / "out").glob("counterexample-*.json")
    assert replay(found, load(tmp_path / "law.json", sums=True)).violated
