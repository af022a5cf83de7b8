"""Claims about single decisions of teams that test sums, in the states of their game, roundings included."""

import tomllib
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest

from codegen.errors import InputError, RefusedError
from codegen.policy_json import dumps
from codegen.sums import FLOAT32_STEPS
from maviper import verify, verify_file
from maviper.cli import main
from maviper.files.profiles import load
from maviper.verification.ask import Posed, VerifyOptions
from maviper.verification.files.certificates import check_file
from maviper.verification.run import results
from maviper.verification.stated import StatedWorld
from maviper.verification.worlds import state_decisions
from maviper.worlds.stated.observing import call_in_file, ensure_observed, list_observed, with_noise
from tests.support.game_sums import draw_region, team
from tests.support.games import random_profile
from tests.support.generated import FOLDER
from tests.support.zone_cases import random_tree
from verify.claims.catalogue import find_claim
from verify.claims.decisions import formula
from verify.claims.formula import Linear, holds
from verify.claims.region import Region
from verify.claims.region_files import region_toml, start_region
from verify.result import Verdict
from verify.systems.claims import SystemClaim
from verify.systems.files import statement_of
from verify.systems.properties import spell_formula


@pytest.fixture(scope="module")
def proof(tmp_path_factory):
    """A folder with a proof about a team, and the verdict's files."""
    folder = tmp_path_factory.mktemp("game")
    profile, region = team(5), draw_region(team(5), 5)
    (folder / "team.json").write_text(dumps(profile))
    (folder / "region.toml").write_text(region_toml(region))
    words = ["verify", str(folder / "team.json"), "--claim", "no_double", "--claim", "own_target"]
    code = main.run([*words, "--region", str(folder / "region.toml"), "-o", str(folder / "out")])
    assert code == 1
    return folder


def test_a_proof_is_checked_and_a_counterexample_replayed(proof, capsys):
    assert main.run(["check", str(proof / "out" / "certificate-1-decides.json")]) == 0
    assert "no_double of the defenders, region region.toml" in capsys.readouterr().out
    assert main.run(["replay", str(proof / "out" / "counterexample-2-decides.json")]) == 1
    # the folder says all that was asked
    folder = proof / "out"
    asked = ["verify", str(folder / "profile.json"), "--system", str(folder / "world.toml"), "--verdict-only"]
    assert main.run(asked) == 1
    said = capsys.readouterr().out
    assert "PROVED" in said and "VIOLATED" in said


def test_a_proof_is_of_its_world_file_alone(proof):
    """Without a rounding it is another file. What is claimed stands in the certificate, and is told."""
    world = proof / "out" / "world.toml"
    source = world.read_text()
    try:
        assert " + agent_0.rounding_goal_dx" in source
        world.write_text(source.replace(" + agent_0.rounding_goal_dx", ""))
        with pytest.raises((InputError, RefusedError)):
            check_file(proof / "out" / "certificate-1-decides.json", None, None)
    finally:
        world.write_text(source)


def test_a_file_says_what_the_game_shows():
    """Within the bounds that it states for roundings, at states of every size, and the formula is the claim's."""
    profile, rng = team(8), np.random.default_rng(2)
    region = start_region(profile.world)
    for name in ("distinct_targets", "own_target", "no_double", "aligned", "assignment"):
        claim = find_claim(name, profile, None)
        world, (where,) = state_decisions(profile, [Posed(claim, region, None, by_file=False)])
        source = world.source
        assert world.statement == statement_of(source, "world.toml")  # its tables mean what its text says
        stated = StatedWorld.of_game(profile, VerifyOptions(names=(name,)))
        assert stated.beside["world.toml"] == source and where == "region start"
        assert tomllib.loads(source)["property"][0]["label"] == f"{name} of the defenders, region start"
        (system_claim,) = stated.claims
        assert isinstance(system_claim, SystemClaim)
        ranges = {one.name: one.range for one in stated.statement.system.variables}
        for _ in range(8):
            numbers = rng.uniform(-1, 1, len(profile.world.coordinates())) * 2.0 ** -rng.integers(0, 60, 1)
            at = dict(zip(profile.world.coordinates(), map(Fraction, numbers.tolist()), strict=True))
            goal = profile.world.landmarks[int(rng.integers(2))].name
            at |= {f"goal.{axis}": at[f"{goal}.{axis}"] for axis in "xy"}
            state = with_noise(profile, stated.statement, {call_in_file(each): value for each, value in at.items()})
            assert all(
                ranges[each][0] <= state[each] <= ranges[each][1] for each in ranges if "rounding_of" not in each
            )
            ensure_observed(profile, stated.statement, state)
            actions = {each.agent: int(rng.integers(5)) for each in profile.agents}
            assert holds(system_claim.formula, state, actions) is holds(formula(profile, claim), at, actions)


def test_a_file_that_forgets_roundings_shows_another_number(monkeypatch):
    """0.5 + 2^-25 + 2^-61 is nearer to the float32 above; rounded to float64 it is a tie, and the even one is below."""
    profile = team(8)
    stated = StatedWorld.of_game(profile, VerifyOptions(names=("own_target",)))
    policy_ = profile.policy("agent_0")
    (tested, *_) = [each for each in list_observed(policy_) if len(each.meaning.terms) == 2]
    at = dict.fromkeys(map(call_in_file, profile.world.coordinates()), Fraction(0))
    for weight, name in tested.meaning.terms:
        at[call_in_file(name)] = Fraction(1, 2) + Fraction(1, 2**25) if weight > 0 else Fraction(-1, 2**61)
    state = with_noise(profile, stated.statement, at)
    ensure_observed(profile, stated.statement, state)
    name = tested.rounding
    assert state[name] == Fraction(-1, 2**61)
    with pytest.raises(AssertionError, match="observes"):
        ensure_observed(profile, stated.statement, {**state, name: Fraction(0)})


@pytest.mark.parametrize(
    ("asked_for", "message"),
    [
        (["--claim", "alive_leaves"], "alive_leaves is not about single states"),
        (["--where"], "--where has no effect"),
        (["--set", "semantics=real"], "--set semantics has no effect"),
        (["--region", "{folder}/apart.toml"], "keeps pairs apart"),
    ],
)
def test_what_is_not_decided_is_refused(proof, asked_for, message, capsys):
    apart = replace(
        start_region(load(proof / "team.json", sums=True).world), apart=(("agent_0", "agent_1", Fraction(1, 8)),)
    )
    (proof / "apart.toml").write_text(region_toml(apart))
    words = [each.format(folder=proof) for each in asked_for]
    assert main.run(["verify", str(proof / "team.json"), *words]) == 2
    assert message in capsys.readouterr().err


def test_a_property_file_is_about_states_of_the_game(proof, capsys):
    """Formulas over coordinates, and one that asks which landmark is the goal."""
    (proof / "claims.toml").write_text(
        '[[property]]\nlabel = "the same"\nformula = "acts(agent_0) == left or not acts(agent_0) == left"\n'
        '[[property]]\nlabel = "by goal"\nformula = "goal == landmark_0 or acts(agent_0) == up or agent_0.x <= 1"\n'
    )
    words = ["verify", str(proof / "team.json"), "--claims", str(proof / "claims.toml"), "--verdict-only"]
    assert main.run(words) == 0
    said = capsys.readouterr().out
    assert said.count("PROVED") == 3 and "by goal, region start, goal landmark_1" in said


ERRORS = Fraction(1, 8), Fraction(1, 64), Fraction(1, 1024)


def plain_team(seed):
    """The shipped team of deception with random trees that test single features."""
    plain, rng = load(FOLDER / "profile.json"), np.random.default_rng(seed)
    made = [replace(each, tree=random_tree(rng, len(each.features), 4), grown=None) for each in plain.agents]
    return replace(plain, agents=tuple(made), region=None)


@pytest.mark.parametrize(
    "seeds",
    [
        range(1, 2),
        pytest.param(range(2, 10), marks=pytest.mark.slow),
        pytest.param(range(10, 60), marks=pytest.mark.nightly),
    ],
    ids=["one", "some", "many"],
)
def test_the_world_file_of_a_game_and_the_engine_for_games_agree(seeds, tmp_path):
    """Of trees without sums, which both decide: with errors and without."""
    for seed in seeds:
        profile, region = plain_team(seed), draw_region(plain_team(seed), seed)
        (tmp_path / "drawn.toml").write_text(region_toml(region))
        of = ("distinct_targets", "no_double", "own_target")[seed % 3]
        options = {"of": of, "eps": ERRORS[seed % 3]} if seed % 2 else {}
        known = verify(profile, "steady" if options else of, region=str(tmp_path / "drawn.toml"), **options)
        asked_for = VerifyOptions.about("steady" if options else of, str(tmp_path / "drawn.toml"), options)
        stated = StatedWorld.of_game(profile, asked_for.ensure_usable())
        other = stated.answer(stated.asked[0].question, beside=False)
        assert other.verdict is known.verdict, (seed, of, options)


@pytest.mark.parametrize("name", ["own_target", "keeps_apart"])
def test_other_physics_are_refused(name):
    """Of episodes a world file would state another motion than the team's own."""
    profile = team(4, levels=1)
    other = replace(profile, world=replace(profile.world, options={"physics": "released"}))
    with pytest.raises(InputError, match="claims cover mpe2's motion"):
        StatedWorld.of_game(other, VerifyOptions(names=(name,)))


@pytest.mark.slow
def test_the_world_file_never_contradicts_the_solver_about_long_sums(tmp_path):
    """Of features that add four coordinates, which Z3 decides alone: the file's proofs have certificates."""
    verdicts = []
    for seed in range(6):
        profile, rng = random_profile("physical-deception,features=ahead", seed, depth=3), np.random.default_rng(seed)
        ends = {name: Fraction(int(rng.integers(-96, 96)), 128) for name in start_region(profile.world).box}
        box = {name: (low, low + Fraction(1, 8)) for name, low in ends.items()}
        (tmp_path / "drawn.toml").write_text(region_toml(Region(box, ("landmark_0",), name="drawn.toml")))
        asked_for = VerifyOptions.about(("no_double", "own_target")[seed % 2], str(tmp_path / "drawn.toml"), {})
        (known,) = results(profile, asked_for)
        stated = StatedWorld.of_game(profile, asked_for)
        other = stated.answer(stated.asked[0].question, beside=False)
        assert other.verdict in (known.verdict, Verdict.UNKNOWN), seed
        assert (other.evidence.certificate is not None) == (other.verdict is Verdict.PROVED)
        verdicts.append(other.verdict)
    assert verdicts.count(Verdict.UNKNOWN) <= 2 and {Verdict.PROVED, Verdict.VIOLATED} <= set(verdicts)


def test_a_bound_of_any_size_of_float64_is_spelled_so_that_it_is_read():
    """A fraction of numbers beyond 10^9 is none that a formula takes."""
    for bound in (Fraction(1, 10**70), Fraction(1, 2**1074), Fraction(-3, 2**90)):
        source = spell_formula(Linear(((Fraction(1), "agent_0.x"),), bound, False), {})
        (_, written) = source.split(" <= ")
        assert "/" not in written and Fraction(written) == bound
    profile = team(5)
    formula_text = 'formula = "acts(agent_0) == left implies agent_0.x <= 1e-70"'
    assert len(ask_of_game(profile, formula_text).claims) == 1


def ask_of_game(profile, claim):
    with TemporaryDirectory() as folder:
        file = Path(folder) / "claims.toml"
        file.write_text(f'[[property]]\nteam = "defenders"\n{claim}\n')
        return StatedWorld.of_game(profile, VerifyOptions(file=file))


def test_states_at_ends_of_bounds_are_drawn_where_the_others_break_nothing(tmp_path):
    """A sum comes near its largest value in few states of a box: of 16,384 that are drawn inside, in none."""
    (tmp_path / "asked.toml").write_text(
        '[[property]]\nformula = "acts(agent_0) == up and acts(agent_1) == right implies '
        'landmark_1.x - agent_0.x <= 0.9343"\n'
    )
    (tmp_path / "box.toml").write_text(
        "[box]\n"
        '"adversary_0.x" = [-0.75, 0.125]\n"adversary_0.y" = [-0.125, 0]\n"agent_0.x" = [-0.125, 0.75]\n'
        '"agent_0.y" = [0.75, 1]\n"agent_1.x" = [-0.5, 0.75]\n"agent_1.y" = [0, 0.125]\n'
        '"landmark_1.y" = [-0.75, 0.5]\n'
    )
    profile = team(40, FLOAT32_STEPS, levels=1)
    (answer,) = verify_file(profile, tmp_path / "asked.toml", region=str(tmp_path / "box.toml"))
    assert answer.verdict is Verdict.VIOLATED
    start = answer.evidence.counterexample.start
    assert start["landmark_1.x"] - start["agent_0.x"] > Fraction("0.9343")
