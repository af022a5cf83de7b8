"""Monitors of games whose teams test sums: they take states of the game, and vouch for what its arithmetic keeps."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from codegen.boxes import is_inside
from codegen.errors import InputError
from codegen.ir import act
from codegen.lowering.lower import lower
from codegen.observe import observe
from codegen.world import RegionSpec
from maviper.compilation.games import find_game, region_of, restate_formula
from maviper.compilation.monitors import load_proof, lower_monitor
from maviper.page.page import play_claim
from maviper.verification.ask import VerifyOptions
from maviper.verification.stated import StatedWorld
from maviper.worlds.stated import observing
from maviper.worlds.stated.certified import read_certificate
from tests.support import monitors
from tests.support.game_sums import draw_region, team
from tests.support.monitors import INVALID, LEAVING, OK, OUTSIDE, Twin
from verify.certificates.systems import to_json
from verify.claims.catalogue import find_claim
from verify.claims.decisions import formula
from verify.claims.formula import Linear, Not, Or
from verify.claims.region import Region
from verify.claims.region_files import region_toml, start_region
from verify.result import Verdict
from verify.states.episodes import play
from verify.states.state import sample
from verify.states.values import Batch
from verify.systems.files import statement_of
from verify.systems.system import Affine, HalfSpace

STEPS, RADIUS, HALF = 3, Fraction(4, 5), Fraction(1, 256)


def pose(folder, profile, name, region, **options):
    """The world of a claim about a region."""
    (folder / "drawn.toml").write_text(region_toml(region))
    asked = VerifyOptions.about(name, str(folder / "drawn.toml"), options)
    return StatedWorld.of_game(profile, replace(asked, verdict_only=True))


def certify(folder, profile, name, region, **options):
    """The certificate of a claim, with its world file beside it."""
    stated = pose(folder, profile, name, region, **options)
    result = stated.answer(stated.asked[0].question, beside=False)
    assert result.verdict is Verdict.PROVED
    for beside, text in stated.beside.items():
        (folder / beside).write_text(text)
    (folder / "certificate.json").write_text(to_json(result.evidence.certificate))
    return folder / "certificate.json"


@pytest.fixture(scope="module")
def decided(tmp_path_factory):
    """A team, the region of a claim about its decisions, and the certificate."""
    profile = team(5)
    region = draw_region(profile, 5)
    return profile, region, certify(tmp_path_factory.mktemp("decided"), profile, "no_double", region)


@pytest.fixture(scope="module")
def proof(decided):
    """What a monitor of the certificate watches."""
    profile, _, certificate = decided
    return load_proof(certificate, profile)


@pytest.fixture(scope="module")
def stated(decided):
    """The claim of the certificate, its world file, and what that says of the game."""
    profile, _, certificate = decided
    known, statement = read_certificate(certificate)
    return known.claim, statement, find_game(profile, statement)


def keeps(profile, name, w):
    """In which states [batch, coordinates] the game's agents keep a claim, by the game's own observations."""
    columns = dict(zip(profile.world.coordinates(), w.T, strict=True))
    actions = {each.agent: act(each, observe(each.features, w, profile.world, each.numbers)) for each in profile.agents}
    return Batch(columns, len(w)).holds(formula(profile, find_claim(name, profile, None)), actions)


def draw_rows(profile, region, count, seed):
    """States in a region and beside it, with the goal elsewhere, unknown or late: w, fresh, dt, start."""
    rng, names = np.random.default_rng(seed), profile.world.coordinates()
    w, _ = sample(region, profile.world, count, seed)
    w[:, [names.index(name) for name in names if ".v" in name]] = rng.uniform(-0.1, 0.1, (count, 6))
    for row in np.flatnonzero(rng.random(count) < 0.3):
        name = str(rng.choice(list(region.box)))
        ends = [float(end) for end in region.box[name]]
        beside = np.nextafter(ends, [-np.inf, np.inf])
        w[row, names.index(name)] = rng.choice([*ends, *beside, *rng.uniform(-1.0, 1.0, 4)])
    for row in np.flatnonzero(rng.random(count) < 0.1):
        w[row, names.index("goal.x")] = rng.choice([0.0, np.nan, w[row, names.index("landmark_0.x")]])
    fresh = (rng.random(w.shape) > 0.002).astype(np.int32)
    dt = rng.choice([profile.world.dt, 9.0], count, p=[0.98, 0.02])
    return w, fresh, dt, (rng.random(count) < 0.5).astype(np.int32)


@pytest.mark.compile
@pytest.mark.parametrize(
    ("languages", "count"),
    [(("python",), 400), pytest.param(monitors.LANGUAGES, 4_000, marks=pytest.mark.slow)],
    ids=["some", "all"],
)
def test_the_claim_holds_in_the_game_wherever_a_monitor_vouches(languages, count, decided, proof, tmp_path):
    """States are those that monitors of other teams take: the goal's place is a landmark's, and nothing is rounded."""
    profile, region, _ = decided
    assert isinstance(proof.region, RegionSpec) and proof.region.goals == region.goals
    watched = lower_monitor(profile, lower(profile), proof)
    assert [place.name for place in watched.places.values()] == list(profile.world.coordinates())
    rows = draw_rows(profile, region, count, 3)
    wanted = Twin(profile, proof.region, watched).said(rows)
    assert {OK, LEAVING, OUTSIDE, INVALID} == set(wanted)
    vouched = np.isin(wanted, [OK, LEAVING])
    assert vouched.sum() > count / 10 and keeps(profile, "no_double", rows[0][vouched]).all()
    monitors.ensure_alike(profile, watched, rows, wanted, tmp_path, languages)


def test_a_monitor_takes_the_whole_region_and_nothing_more(decided, proof):
    profile, region, _ = decided
    names = profile.world.coordinates()
    within, _ = sample(region, profile.world, 2_000, 1)
    anywhere, _ = sample(start_region(profile.world), profile.world, 20_000, 2)
    assert is_inside(proof.region, within, names).all() and keeps(profile, "no_double", within).all()
    assert not keeps(profile, "no_double", anywhere).all()  # so the region says something
    elsewhere = within.copy()
    elsewhere[:, names.index("goal.y")] += 2.0**-40
    assert not is_inside(proof.region, elsewhere, names).any()


def test_a_file_of_a_game_is_told_by_what_agents_observe(decided, stated):
    """Else its variables are what its user says, and all of them are asked for."""
    (profile, _, _), (_, statement, game) = decided, stated
    assert game.place == observing.PLACE and game.roundings and not game.errors
    (_, first), _ = next(each.meaning.terms for each in game.observed if len(each.meaning.terms) == 2)
    called = observing.call_in_file(first)
    for old, new in ((f"1*{called}", f"2*{called}"), (f" + {game.roundings[0]}", "")):
        assert old in statement.place.source
        assert find_game(profile, statement_of(statement.place.source.replace(old, new), "world.toml")) is None
    assert find_game(replace(profile, agents=profile.agents[1:]), statement) is None


def test_a_formula_of_a_file_is_one_over_states_of_the_game(decided, stated):
    """As long as it is about no rounding, which no state of the game has."""
    (profile, _, _), (claim, _, game) = decided, stated
    restated = restate_formula(claim.formula, profile, "here")
    assert restated == claim.formula  # where the goal is was said by the region
    inside = Linear(((Fraction(1), f"{observing.PLACE}.x"),), Fraction(0))
    assert restate_formula(Not(inside), profile, "here") == Not(Linear(((Fraction(1), "goal.x"),), Fraction(0)))
    rounding = Linear(((Fraction(1), game.roundings[0]),), Fraction(0))
    with pytest.raises(InputError, match="which no state of the game has"):
        restate_formula(Or((restated, rounding)), profile, "here")


def narrow_to(terms, most):
    """That a sum is at most a number."""
    return HalfSpace(Affine.of({name: Fraction(factor) for name, factor in terms.items()}, -most))


def test_what_is_not_shown_of_the_game_is_refused(decided, stated):
    (_, region, _), (claim, _, game) = decided, stated
    first, second = claim.regions
    low, high = region.box["agent_0.x"]
    middle = narrow_to({"agent_0.x": 1}, (low + high) / 2)
    rounding = game.roundings[0]
    smaller = replace(game, ranges={**game.ranges, rounding: tuple(end / 2 for end in game.ranges[rounding])})
    with pytest.raises(InputError, match=rf"some values of {rounding} only"):
        region_of(smaller, claim, "here")
    for regions, message in (
        ((first, (*second, middle)), "several regions"),
        ((first[1:], second), "several regions"),
        (((*first, narrow_to({"agent_0.x": 1, "agent_1.x": 1}, Fraction(0))),), "is no bound"),
        (((*first, narrow_to({rounding: 1}, Fraction(0))),), f"some values of {rounding} only"),
        (((*first, replace(middle, strict=True)),), "is no bound"),
    ):
        with pytest.raises(InputError, match=message):
            region_of(game, replace(claim, regions=regions), "here")
    ends = region_of(game, replace(claim, regions=((*first, middle),)), "here").box["agent_0.x"]
    assert tuple(map(Fraction, ends)) == (low, (low + high) / 2)
    loose = region_of(game, replace(claim, regions=(first[1:],)), "here")  # no landmark is the goal in all of it
    assert not loose.goals and "goal.x" in loose.box and "goal.x - landmark_0.x" in loose.difference


@pytest.mark.slow
def test_a_proof_of_smaller_roundings_has_no_monitor(tmp_path, monkeypatch):
    profile = team(5)
    with monkeypatch.context() as patched:
        patched.setattr(observing, "UNIT", observing.UNIT / 2)
        certificate = certify(tmp_path, profile, "no_double", draw_region(profile, 5))
    with pytest.raises(InputError, match=r"some values of \w+\.rounding_\w+ only"):
        load_proof(certificate, profile)


@pytest.mark.slow
def test_errors_of_features_are_not_asked_for(tmp_path):
    """The proof holds for all of them: also for none, which is what the game has."""
    profile = team(5)
    asked = pose(tmp_path, profile, "steady", draw_region(profile, 5), of="no_double", eps=Fraction(1, 64))
    (claim,), game = asked.claims, find_game(profile, statement_of(asked.beside["world.toml"], "world.toml"))
    assert game.errors and set(region_of(game, claim, "here").box) <= set(profile.world.coordinates())
    wrong = narrow_to({game.errors[0]: -1}, Fraction(-1, 4096))
    with pytest.raises(InputError, match="leaves out that"):
        region_of(game, replace(claim, regions=tuple((*each, wrong) for each in claim.regions)), "here")


# --- episodes


def starts_of(profile):
    """A small box of starts, with one goal."""
    whole, rng = start_region(profile.world), np.random.default_rng(0)
    middles = {name: Fraction(float(rng.uniform(-0.75, 0.75))) for name in whole.box}
    return Region({name: (at - HALF, at + HALF) for name, at in middles.items()}, whole.goals[:1], name="drawn.toml")


def test_a_monitor_of_episodes_takes_states_of_the_game(tmp_path):
    """It vouches for the game's own episodes, and the claim holds from wherever it vouches."""
    profile = team(5, levels=1)
    region = starts_of(profile)
    certificate = certify(tmp_path, profile, "stays_in", region, radius=RADIUS, steps=STEPS)
    proof = load_proof(certificate, profile)
    cover, names = proof.region, list(profile.world.coordinates())
    columns = [names.index(one.name) for one in cover.variables]
    assert proof.claim.endswith("where the goal is at landmark_0") and cover.dt == profile.world.dt
    assert cover.paced and not cover.ever and len(cover.steps) == STEPS + 1
    starts, _ = sample(region, profile.world, 200, 4)
    episodes, _ = play(profile, starts, STEPS)
    for step, w in enumerate(episodes):
        assert cover.holds(w[:, columns], step).all()
    watched = [names.index(f"{agent}.{axis}") for agent in ("agent_0", "agent_1") for axis in "xy"]
    rng = np.random.default_rng(5)
    for step, (part,) in enumerate(cover.steps):
        row = rng.integers(len(part.low), size=200)
        w = np.zeros((200, len(names)))
        w[:, columns] = rng.uniform(part.low[row], part.high[row])
        w[:, [names.index(f"goal.{axis}") for axis in "xy"]] = w[
            :, [names.index(f"landmark_0.{axis}") for axis in "xy"]
        ]
        assert cover.holds(w[:, columns], step).all()
        later, _ = play(profile, w, STEPS - step)
        assert all((np.abs(each[:, watched]) <= float(RADIUS)).all() for each in later)
    told, _ = play_claim(profile, certificate, proof)
    assert told.words[:STEPS] == ("OK",) * STEPS


@pytest.mark.slow
def test_a_proof_of_episodes_with_smaller_roundings_has_no_monitor(tmp_path, monkeypatch):
    profile = team(1, levels=2)
    with monkeypatch.context() as patched:
        patched.setattr(observing, "UNIT", observing.UNIT / 2)
        certificate = certify(tmp_path, profile, "stays_in", starts_of(profile), radius=RADIUS, steps=STEPS)
    with pytest.raises(InputError, match="other numbers than the game may round by"):
        load_proof(certificate, profile)
