"""The page says of a state what a monitor made from the proof says of it."""

import lzma
from fractions import Fraction

import numpy as np
import pytest

from codegen.errors import InputError
from codegen.ir import act
from codegen.lowering.lower import lower
from maviper import load
from maviper.compilation.monitors import load_proof, lower_monitor
from maviper.episodes import measures
from maviper.page.document import Contents, Shown, usual_claims
from maviper.page.page import load_claim, page, with_proof, words
from maviper.worlds.stated.certified import read_certificate
from maviper.worlds.stated.environment import StatedEnv
from tests.maviper.page.browsers import in_chromium, in_node
from tests.support.monitors import LEAVING, OK, OUTSIDE, Twin, files, module_of
from tests.support.pages import GENERATED, STATE, committed

WORDS = {OK: "OK", LEAVING: "LEAVING", OUTSIDE: "OUTSIDE"}
ASKED = (
    STATE
    + """
  const word = Engine.monitor(game, data.claims[0].region);
  return given.map(([at, goal]) => word(stateIn(game)(at, goal)));
"""
)
SHOWN = "const word = document.getElementById('word'); return [word.hidden, word.textContent, word.className];"


def asked(profile, spec, count, seed):
    """States within a region, at its border and beside it, as coordinates by name with the goal's name, and as rows."""
    rng, names = np.random.default_rng(seed), list(profile.world.coordinates())
    w = rng.uniform(-1.0, 1.0, (count, len(names)))
    at_end = rng.random(w.shape) < 0.01
    w[at_end] = rng.choice([1.0, -1.0, np.nextafter(1.0, 2.0), np.nextafter(-1.0, -2.0)], at_end.sum())
    goals = rng.choice(spec.goals, count)
    for axis in "xy":
        w[:, names.index(f"goal.{axis}")] = w[np.arange(count), [names.index(f"{goal}.{axis}") for goal in goals]]
    return w, [(dict(zip(names, row, strict=True)), goal) for row, goal in zip(w.tolist(), goals, strict=True)]


def test_the_word_is_the_monitors(tmp_path):
    profile = committed("verdicts/physical_deception")
    certificate = GENERATED / "verdicts" / "physical_deception" / "certificate-1-distinct_targets.json"
    proof = load_proof(certificate, profile)
    spec = proof.region
    w, given = asked(profile, spec, 400, 2)
    _, watched = files(profile, spec, ["python"])
    twin, wanted = Twin(profile, spec, watched), []
    for row in w:
        twin.start()
        wanted.append(WORDS[twin.step(row, np.ones(len(row)), profile.world.dt)])
    assert set(wanted) == set(WORDS.values())
    shown = page(profile, Contents((load_claim(profile, certificate, proof),)))
    assert in_node(shown, ASKED, given, tmp_path) == wanted


def test_the_word_of_a_team_that_tests_sums_is_the_monitors(tmp_path):
    """The certificate is about a world file; the page is of the game, and judges the formula by the game's states."""
    folder, profile = GENERATED / "differences", committed("differences")
    certificate = folder / "certificate-1-decides.json"
    assert any(policy.tree.sums for policy in profile.agents)
    contents = with_proof(Contents(usual_claims(profile)), profile, certificate)
    shown, proved = contents.claims[0], load_proof(certificate, profile)
    assert shown.verdict == "PROVED in a region of its own" and shown.proved == proved.region
    assert not contents.told and contents.recorded is None
    w, given = asked(profile, proved.region, 300, 3)
    names = profile.world.coordinates()
    for name, (low, high) in proved.region.box.items():
        if (low, high) != ("-1", "1"):  # few states are in it by chance
            w[::2, names.index(name)] = np.random.default_rng(4).uniform(float(low), float(high), 150)
    goals = [goal for _, goal in given]
    w[:, names.index("goal.y")] = w[np.arange(300), [names.index(f"{goal}.y") for goal in goals]]
    given = [(dict(zip(names, row, strict=True)), goal) for row, goal in zip(w.tolist(), goals, strict=True)]
    twin, wanted = Twin(profile, proved.region, lower_monitor(profile, lower(profile), proved)), []
    for row in w:
        twin.start()
        wanted.append(WORDS[twin.step(row, np.ones(len(row)), profile.world.dt)])
    assert set(wanted) == set(WORDS.values())
    assert in_node(page(profile, contents), ASKED, given, tmp_path) == wanted


@pytest.mark.parametrize("proved", [True, False])
def test_the_word_stands_beside_a_claim_that_is_proved(proved, tmp_path):
    folder, profile = GENERATED / "proved_defenders", committed("proved_defenders")
    spec = load_proof(folder / "certificate-1-distinct_targets.json", profile).region
    (claim, *_) = usual_claims(profile)
    html = page(profile, Contents((Shown(claim.claim, "PROVED", spec if proved else None),)))
    hidden, text, name = in_chromium(html, SHOWN, [], tmp_path)
    assert hidden is not proved
    assert (text, name) == (("monitor: OK", "badge holds") if proved else ("", "badge other"))


@pytest.mark.parametrize("name", ["1-formula.json", "7-keeps_apart.json.xz"])
def test_play_shows_the_claim_of_a_certificate(name):
    profile = committed("verdicts/predator_prey")
    certificate = GENERATED / "verdicts" / "predator_prey" / f"certificate-{name}"
    if name == "7-keeps_apart.json.xz":
        with pytest.raises(InputError, match="push each other"):
            load_claim(profile, certificate, load_proof(certificate, profile))
        return
    shown = load_claim(profile, certificate, load_proof(certificate, profile))
    assert shown.verdict == "PROVED in a region of its own" and shown.proved is not None
    text = page(profile, Contents((shown,)))
    assert '"region":{"bounds":[["' in text and "PROVED in a region" in text


def test_a_packed_proof_of_episodes_is_shown_as_the_plain_one(tmp_path):
    profile = committed("verdicts/physical_deception")
    plain = GENERATED / "verdicts" / "physical_deception" / "certificate-8-reaches.json"
    packed = tmp_path / "certificate.json.xz"
    packed.write_bytes(lzma.compress(plain.read_bytes()))
    first, second = (load_claim(profile, each, load_proof(each, profile)) for each in (packed, plain))
    assert first == second


@pytest.mark.parametrize("folder", ["physical_deception", "proved_defenders", "proved_navigation"])
def test_committed_pages_have_the_regions_of_their_proofs(folder):
    text = (GENERATED / folder / "play.html").read_text(encoding="utf-8")
    assert text.count('"region":{"bounds":[["') == 1


@pytest.mark.parametrize(
    "name", ["pendulum/certificate-1-stays_in", pytest.param("tanks/certificate-2-always", marks=pytest.mark.slow)]
)
def test_the_word_of_a_stated_system_is_the_monitors_at_each_step(name, tmp_path):
    """The page has the words of a recorded episode: those of the generated monitor, which is given its states."""
    certificate = GENERATED / "worlds" / f"{name}.json"
    profile = load(certificate.parent / "profile.json")
    contents = with_proof(Contents(), profile, certificate)
    ((claim,), episode) = contents.told, contents.recorded
    proved, (_, statement) = load_proof(certificate, profile), read_certificate(certificate)
    env = StatedEnv(statement, "again")
    observed, _ = env.reset(measures.ON_POLICY_SEEDS)
    space = module_of(lower_monitor(profile, lower(profile), proved))
    found, wanted = space["Monitor"](), []
    while env.agents:
        found.renew_all()
        wanted.append(found.step([env.state[one.name] for one in statement.system.variables], space["DT"]).name)
        seen = {policy.agent: episode.seen[place][len(wanted) - 1] for place, policy in enumerate(profile.agents)}
        assert all((observed[agent] == seen[agent]).all() for agent in seen)
        observed = env.step({policy.agent: int(act(policy, seen[policy.agent][None])[0]) for policy in profile.agents})[
            0
        ]
    assert list(claim.words) == wanted and wanted[0] == "OK" and len(wanted) == len(episode.seen[0])
    shown = in_chromium(page(profile, contents), SHOWN, [], tmp_path)
    assert shown == [False, "monitor: OK", "badge holds"]


def test_the_word_of_a_system_stays_where_a_state_is_not_vouched_for():
    certificate = GENERATED / "worlds" / "pendulum" / "certificate-1-stays_in.json"
    cover = load_proof(certificate, load(certificate.parent / "profile.json")).region
    still = np.zeros((len(cover.steps) + 1, 4))
    assert words(cover, still) == ("OK",) * (len(cover.steps) - 1) + ("LEAVING", "OUTSIDE")
    fallen = still.copy()
    fallen[2, 2], fallen[5, 2] = 0.9, np.nan
    assert words(cover, fallen)[:5] == ("OK", "OK", "OUTSIDE", "OUTSIDE", "OUTSIDE")
    assert words(cover, fallen[5:])[:2] == ("INVALID", "INVALID")


# --- episodes of games

FOLLOWED = (
    STATE
    + """
  const word = Engine.follower(game, data.claims[0].follows);
  return given.map(([at, goal, speed, own, [moved, kind, entity, axis, size]]) => {
    const start = stateIn(game)(at, goal);
    start.velocity[0][0] = speed;
    const states = [start], acted = [];
    while (states.length < 28) {
      const here = Engine.coordinates(game, states.at(-1));
      const chosen = Engine.actions(game, here);
      acted.push([...chosen]);
      if (own[0] === states.length) chosen[own[1]] = (chosen[own[1]] + 1) % 5;
      states.push(Engine.step(game, states.at(-1), chosen));
      if (moved === states.length) states.at(-1)[kind][entity][axis] += size;
    }
    const words = states.map((_, last) => word(states.slice(0, last + 1)));
    return [states.map((state) => [...Engine.coordinates(game, state)]), acted, words];
  });
"""
)


def test_the_word_of_an_episode_of_a_game_is_the_monitors_at_each_step(tmp_path):
    """Episodes that nobody disturbs, one from a start that moves, some in which an agent is steered, or a number is off
    by a little: the page says of each state what the generated monitor says that is given the states and what the
    trees decide.
    """
    profile = committed("verdicts/physical_deception")
    certificate = GENERATED / "verdicts" / "physical_deception" / "certificate-8-reaches.json"
    contents = with_proof(Contents(), profile, certificate)
    proved = load_proof(certificate, profile)
    names = [policy.agent for policy in profile.agents]
    others = [at for at, name in enumerate(names) if name not in proved.region.followed]
    followed = names.index(min(proved.region.followed))
    assert contents.claims[0].verdict == "PROVED in a region of its own" and others
    spec, rng = proved.region.region, np.random.default_rng(5)
    box = {name: (float(Fraction(low)), float(Fraction(high))) for name, (low, high) in spec.box.items()}
    at = [{name: rng.uniform(*ends) for name, ends in box.items()} for _ in range(6)]
    none, less = (0, "velocity", 1, 0, 0.0), 2.0**-41
    ways = [(0.0, [0, 0], none), (0.25, [0, 0], none), (0.0, [4, others[0]], none), (0.0, [4, followed], none)]
    ways += [(0.0, [0, 0], (7, "velocity", 1, 0, 2.0**-39)), ways[0]]
    who, landmark = followed, len(names)
    places = ((2, "position", who), (2, "velocity", who), (9, "position", who), (4, "position", landmark))
    ways += [(0.0, [0, 0], (*place, axis, less)) for place in places for axis in range(2)]
    given = [[state, spec.goals[0], *way] for state, way in zip([*at, *[at[0]] * 8], ways, strict=True)]
    given[5][0]["agent_0.x"] = float(np.nextafter(box["agent_0.x"][1], np.inf))  # no start of the proof
    told = in_node(page(profile, contents), FOLLOWED, given, tmp_path)
    space = module_of(lower_monitor(profile, lower(profile), proved))
    for states, acted, words_shown in told:
        found, wanted = space["Monitor"](), []
        for state, actions in zip(states, [*acted, [0] * len(names)], strict=True):
            found.renew_all()
            wanted.append(found.step(state, space["DT"]).name)
            for name, action in zip(names, actions, strict=True):
                found.act(name, action)
        assert words_shown == wanted
    counts = [words_shown.count("OK") for _, _, words_shown in told]
    assert counts[0] == counts[2] == proved.region.steps and counts[1] == counts[5] == 0
    assert counts[3] == 4 and counts[4] == 6
    assert counts[6:8] == [1, 1] and min(counts[8:10]) == 1  # an action pushes along one axis at most
    assert max(counts[10:12]) == proved.region.steps and counts[12:] == [3, 3]  # who moves may be off by a rounding
