"""Claims over observations about agents that give numbers or test sums: no world file, the same evidence."""

import json
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import maviper
from codegen import ir
from codegen.errors import InputError, RefusedError
from codegen.policy_json import dumps
from maviper.cli.main import run
from maviper.files.profiles import load
from maviper.verification.files.certificates import check_file
from maviper.verification.files.counterexamples import replay
from tests.support import summed
from tests.support.giving import CART, tree
from verify.result import Verdict
from verify.systems import lowered

REGION = "default = [-5, 5]\n"
BOUNDED, LESS, PUSHES, HARDER, OFF, JUMPS = (
    'label = "bounded"\nformula = "out(cart).push <= 2 and out(cart).push >= -2"',
    'formula = "out(cart).push < 2"',
    'formula = "x >= 1 and v >= 0 implies out(cart).push <= -1.24"',
    'formula = "x >= 1 and v >= 0 implies out(cart).push <= -1.2500001"',
    'name = "robust"\nagent = "cart"\noutput = "push"\neps = 0.01\nmost = 0.0275001\n'
    "region = { box = { x = [0, 1], v = [0, 1] } }",
    'name = "robust"\nagent = "cart"\noutput = "push"\neps = { x = 0.01 }\nmost = 0.0275001',
)
VERDICTS = {BOUNDED: "PROVED", LESS: "VIOLATED", PUSHES: "PROVED", HARDER: "VIOLATED", OFF: "PROVED", JUMPS: "VIOLATED"}


def written(folder, *claims):
    file = folder / "claims.toml"
    file.write_text("".join(f"[[property]]\n{claim}\n" for claim in claims))
    return file


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """A folder with the report of a linear controller, of which no world is stated."""
    folder = tmp_path_factory.mktemp("observed")
    (folder / "cart.py").write_text(CART)
    (folder / "region.toml").write_text(REGION)
    given = ["import", "--agents", f"cart={folder / 'cart.py'}", "--arrays", "float64", "--outputs", "push"]
    assert run([*given, "-o", str(folder / "cart.json")]) == 0
    claims = written(folder, *VERDICTS)
    asked = ["verify", str(folder / "cart.json"), "--claims", str(claims), "--region", str(folder / "region.toml")]
    assert run([*asked, "-o", str(folder / "out")]) == 1
    return folder


@pytest.mark.parametrize(("region", "named"), [("region.toml", "region.toml"), (None, "seen"), ("ranges", "ranges")])
def test_the_command_says_which_region_the_ranges_are(place, tmp_path, capsys, region, named):
    """What was seen may be so little that no claim speaks of it: then each is VACUOUS."""
    profile = load(place / "cart.json", sums=True)
    seen = tuple((-0.1, -0.1, 0.1, 0.1) for _ in profile.agents[0].features)
    (tmp_path / "cart.json").write_text(dumps(replace(profile, agents=(replace(profile.agents[0], seen=seen),))))
    asked = ["verify", str(tmp_path / "cart.json"), "--claims", str(written(tmp_path, HARDER))]
    within = [] if region is None else ["--region", str(place / region) if region.endswith("toml") else region]
    assert run([*asked, *within]) == (3 if named == "seen" else 1)
    assert f"over observations, region {named}: " in capsys.readouterr().err


def test_a_copy_observes_what_it_copies(place, tmp_path, capsys):
    """The words name the features that are off: all others are the agent's own."""
    claims = written(tmp_path, JUMPS)
    asked = ["verify", str(place / "cart.json"), "-o", str(tmp_path / "out")]
    assert run([*asked, "--claims", str(claims), "--region", str(place / "region.toml")]) == 1
    world = tmp_path / "world.toml"
    source = (tmp_path / "out" / "world.toml").read_text() + claims.read_text()
    world.write_text(source)
    assert run([*asked, "--system", str(world)]) == 1
    of_cart, of_copy = source.split("[agents.cart_off.features]")
    world.write_text("[agents.cart_off.features]".join((of_cart, of_copy.replace('v = "v"', 'v = "v + 1"', 1))))
    capsys.readouterr()
    assert run([*asked, "--system", str(world)]) == 2
    assert "cart_off does not observe v as cart does" in capsys.readouterr().err


def test_verdicts_and_their_certificates(place):
    report = json.loads((place / "out" / "report.json").read_text())
    assert [result["verdict"] for result in report["results"]] == list(VERDICTS.values())
    for number, verdict in enumerate(VERDICTS.values(), 1):
        file = place / "out" / f"certificate-{number}-decides.json"
        assert file.exists() == (verdict == "PROVED")
        if file.exists():
            assert check_file(file).size > 0


def test_a_certificate_is_about_these_ranges_and_this_tree(place):
    file = place / "out" / "certificate-3-decides.json"
    world = place / "wider.toml"
    world.write_text((place / "out" / "world.toml").read_text().replace("[-5, 5]", "[-6, 6]"))
    with pytest.raises(InputError, match="another system"):
        check_file(file, world=world)
    other = place / "other.json"
    other.write_text((place / "cart.json").read_text().replace("-1.5", "-1.25"))
    with pytest.raises((InputError, RefusedError)):
        check_file(file, profile=other)


def test_counterexamples_are_floats_at_which_the_reference_breaks_the_claim(place):
    policy = maviper.load(place / "cart.json").policy("cart")
    for number, claim in enumerate(VERDICTS, 1):
        file = place / "out" / f"counterexample-{number}-decides.json"
        assert file.exists() == (VERDICTS[claim] == "VIOLATED")
        if not file.exists():
            continue
        assert replay(file, maviper.load(place / "cart.json"), None).violated
        start = {name: Fraction(value) for name, value in json.loads(file.read_text())["start"].items()}
        state = {name: value for name, value in start.items() if "rounding" not in name}
        assert all(Fraction(float(value)) == value for value in state.values())
        at = np.array([[float(state["x"]), float(state["v"])]])
        off = np.array([[float(state[name] + state[f"cart_off.{name}"]) for name in ("x", "v")]])
        given, moved = (Fraction(float(ir.outputs(policy, rows)[0, 0])) for rows in (at, off))
        assert {
            LESS: given >= 2,
            HARDER: state["x"] >= 1 and state["v"] >= 0 and given > Fraction("-1.2500001"),
            JUMPS: abs(moved - given) > Fraction("0.0275001") and state["cart_off.v"] == 0,
        }[claim]


def asked(profile, folder, *claims, **options):
    file, region = written(folder, *claims), folder / "region.toml"
    region.write_text("default = [-3, 3]\n")
    return [each.verdict.value for each in maviper.verify_file(profile, file, region, **options)]


ONE = "def one(x, v):\n    return [x + v, 1.0] if x - v <= 0.5 else [x - 0.5 * v, 0.5]\n"
OTHER = "def other(x, v):\n    return [x + v + 0.125, 1.0] if x <= 0 else [x + v, 0.5]\n"


def test_outputs_of_two_agents_are_compared_where_they_see_the_same(tmp_path):
    (tmp_path / "one.py").write_text(ONE)
    (tmp_path / "other.py").write_text(OTHER)
    both = f"one={tmp_path / 'one.py'},other={tmp_path / 'other.py'}"
    file = tmp_path / "two.json"
    assert run(["import", "--agents", both, "--arrays", "float32", "--outputs", "u,w", "-o", str(file)]) == 0
    near = 'formula = "x - v > 0.49 or |out(one).u - out(other).u| <= {}"'
    claims = [near.format("0.1251"), near.format("0.1249"), 'formula = "out(one).u + out(one).w <= out(other).w + 7"']
    profile = maviper.load(file)
    assert asked(profile, tmp_path, *claims, shared=["all"]) == ["PROVED", "VIOLATED", "PROVED"]
    own = near.format("0.1251").replace("x - v", "one.x - one.v")  # nothing relates observations of their own
    assert asked(profile, tmp_path, own) == ["VIOLATED"]


def test_actions_behind_tests_of_sums(tmp_path):
    profile = summed.profile(tree(4, "float64", 0))
    anything = " or ".join(f"acts(agent_0) == {name}" for name in ("left", "stay", "right"))
    taken = asked(profile, tmp_path, f'formula = "{anything}"', 'formula = "acts(agent_0) == left"')
    assert taken == ["PROVED", "VIOLATED"]


ROBUST = 'name = "robust"\nagent = "agent_0"\noutput = "u0"\n'


@pytest.mark.parametrize(
    ("claim", "says"),
    [
        ('name = "robust"\nagent = "nobody"\noutput = "u0"\neps = 1\nmost = 1', "unknown agent that gives numbers"),
        ('name = "robust"\nagent = "agent_0"\noutput = "u7"\neps = 1\nmost = 1', "unknown output 'u7'"),
        (ROBUST + "most = 1", "needs the largest error"),
        (ROBUST + "eps = 1", "needs the largest change"),
        (ROBUST + "eps = -1\nmost = 1", "is below 0"),
        (ROBUST + "eps = { x9 = 1 }\nmost = 1", "unknown feature 'x9'"),
        (ROBUST + 'eps = 1\nmost = 1\nformula = "x0 <= 1"', "unknown key 'formula'"),
        ('formula = "x0 <= 1"\neps = 1', "decides has no eps"),
        ('name = "distinct_targets"', "unknown claim"),
    ],
)
def test_what_cannot_be_claimed_is_refused_with_its_place(claim, says, tmp_path):
    with pytest.raises(InputError, match=says):
        asked(summed.profile(tree(1, "float64", 1)), tmp_path, claim)


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ([], "write a claim with formula = "),
        (["--claim", "alive_leaves"], "--claim has no effect"),
        (["--claims", "claims.toml", "--set", "semantics=real"], "--set semantics has no effect"),
        (["--claims", "claims.toml", "--region", "apart.toml"], "bounds of single variables"),
    ],
)
def test_options_of_other_claims_are_refused(options, says, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "profile.json").write_text(dumps(summed.profile(tree(1, "float64", 1))))
    written(tmp_path, 'formula = "out(agent_0).u0 <= 2"')
    (tmp_path / "apart.toml").write_text('default = [-1, 1]\n[difference]\n"x0 - x1" = [0, 1]\n')
    assert run(["verify", "profile.json", *options]) == 2
    assert says in capsys.readouterr().err


def just_above(folder):
    """Whether 0.1 + 0.2 in float64, which is above 0.3, is proved to be at most that."""
    one = tree(1, "float64", 1)
    split = ir.Tree(*map(np.array, ([ir.NO_FEATURE], [0.0], [ir.NO_CHILD], [ir.NO_CHILD], [0])), numbers="float64",
                    arithmetic="float64", vectors=((ir.Sum(((1.0, 0), (1.0, 1))),),), gives="float64")  # fmt: skip
    profile = summed.profile(replace(one, tree=split, outputs=(replace(one.outputs[0], low=None, high=None),)))
    sums = 'region = { box = { x0 = [0, 0.1], x1 = [0, 0.2] }, where = ["x0 + x1 <= 0.3"] }'
    return asked(profile, folder, f'formula = "out(agent_0).u0 <= 0.3"\n{sums}')[0] == Verdict.PROVED.value


def test_sums_are_proved_as_they_are_rounded(tmp_path, monkeypatch):
    """The exact sum is at most 0.3: only a proof that forgets the roundings takes that for the output."""
    assert not just_above(tmp_path)
    monkeypatch.setattr(lowered.Errors, "of", lambda errors, each: Fraction(0))
    monkeypatch.setattr(lowered, "_short", lambda bound: bound)
    assert just_above(tmp_path)


LIKE = """
[variables]
x = { range = [-3, 3] }
y = { range = [-3, 3] }
[agents.agent_0.features]
x0 = "x"
x1 = "y"
x2 = "x"
x3 = "y"
x4 = "x"
[agents.agent_0.actions]
left = {}
stay = {}
right = {}
[agents.other]
like = "agent_0"
[agents.other.features]
x0 = "x"
x1 = "y"
x2 = "x"
x3 = "y"
x4 = "x"
[agents.other.actions]
left = {}
stay = {}
right = {}
[start]
box = { x = [-1, 1], y = [-1, 1] }
[[property]]
formula = "acts(agent_0) == left implies acts(other) == left"
"""


def test_an_agent_of_a_world_file_may_act_by_the_tree_of_another(tmp_path):
    plain = summed.profile(replace(tree(4, "float64", 0), tree=ir.Tree(*map(np.array, (
        [0, -1, -1], [0.5, 0, 0], [1, -1, -1], [2, -1, -1], [-1, 0, 2])))))  # fmt: skip
    world = tmp_path / "world.toml"
    world.write_text(LIKE)
    found = maviper.verify_system(plain, world)
    assert [each.verdict for each in found.results] == [Verdict.PROVED]
    for name, text in found.files.items():
        (tmp_path / name).write_text(text)
    assert check_file(tmp_path / "certificate-1-decides.json").size > 0
    world.write_text(LIKE.replace('like = "agent_0"', 'like = "nobody"'))
    with pytest.raises(InputError, match="agent with a tree of its own"):
        maviper.verify_system(plain, world)
    world.write_text(LIKE)
    both = summed.profile(plain.agents[0], replace(plain.agents[0], agent="other"))
    with pytest.raises(InputError, match="which the file lets act like agent_0"):
        maviper.verify_system(both, world)


def test_a_state_that_only_rounding_makes_a_counterexample_hides_no_other(tmp_path):
    """At x = 0 a rounding breaks the claim that the agent gives a quarter, which it gives there; elsewhere it does
    not.
    """
    (tmp_path / "cart.py").write_text("def cart(x, v):\n    return 0.25 + x if v <= 1 else 1.0 * v\n")
    given = ["import", "--agents", f"cart={tmp_path / 'cart.py'}", "--arrays", "float64", "--outputs", "push"]
    assert run([*given, "-o", str(tmp_path / "cart.json")]) == 0
    (tmp_path / "region.toml").write_text("default = [0, 0.5]\n")
    claims = written(tmp_path, 'formula = "out(cart).push == 0.25"')
    profile = load(tmp_path / "cart.json", sums=True)
    (result,) = maviper.verify_file(profile, claims, str(tmp_path / "region.toml"))
    assert result.verdict is Verdict.VIOLATED
    assert 0.25 + float(result.evidence.counterexample.start["x"]) != 0.25
