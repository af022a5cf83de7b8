"""The page decides, plays and judges as the simulator does and as the judge of the hunt says, which shares nothing with
the verifier.
"""

import functools
import itertools
import json
import shutil
from fractions import Fraction
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from codegen import profiles
from maviper.cli.main import run as run_command
from maviper.episodes.play import play, tree_policies
from maviper.page.document import Contents, Shown, document, usual_claims
from maviper.page.page import contents_of, page
from maviper.worlds.matching import matching_world
from tests.hunting import meaning, places, questions
from tests.hunting.reading import MACHINE, acting, fractions, measured
from tests.maviper.page.browsers import RUNNERS
from tests.support.pages import GENERATED, STATE, committed, starts
from tests.support.tiers import first_of
from verify.claims.catalogue import find_claim
from verify.claims.wording import account_of
from verify.kinds import Kind

POLICIES = ("physical_deception", "proved_defenders", "proved_navigation", "verdicts/predator_prey")
JUDGED = (
    STATE + "const stateOf = stateIn(game); return given.map(([at, goal, claim]) => judges[claim](stateOf(at, goal)));"
)
# questions about other profiles than the page's: one browser for all
ASKED = (
    STATE
    + """
  return given.map(([other, states]) => {
    const game = Engine.prepared(other);
    const judge = Engine.judge(game, other.claims[0]);
    return states.map(([at, goal]) => judge(stateIn(game)(at, goal)));
  });
"""
)
PLAYED = (
    STATE
    + """
  const stateOf = stateIn(game);
  return given.map(([at, goal]) => Engine.episode(game, stateOf(at, goal), game.world.steps, (t, at) => {
    const found = Engine.actions(game, at);
    game.agents.forEach((agent, i) => {
      if (Policy.ACT[agent.name](Engine.observe(game, i, at)) !== found[i]) throw new Error(agent.name);
    });
    return found;
  }).actions);
"""
)


@pytest.fixture(params=RUNNERS)
def run(request, tmp_path):
    return lambda html, script, given: RUNNERS[request.param](html, script, given, tmp_path)


# --- claims about decisions


@functools.cache
def drawn(seed):
    return questions.drawn(seed)


@functools.cache
def plain_questions(count):
    """Drawn questions about decisions in the deployed arithmetic, without errors of features."""
    kinds = (Kind.DECISIONS,)
    fitting = (one for one in map(drawn, itertools.count()) if one.case.semantics == MACHINE and not one.case.eps)
    return [*itertools.islice((one for one in fitting if one.question.claim.kind in kinds), count)]


def judged_states(asked, seed):
    """(state, goal, whether the claim holds there, exactly) at and beside the edges of tests, claims and region."""
    case = asked.case
    for goal in case.goals:
        states = places.sampled(case, goal, np.random.default_rng(seed))
        if not len(states):
            continue
        exact, scale = places.scaled(states, case.denominator)
        actions = acting(case.team, case.at(states, goal), MACHINE)
        holds = meaning.holds(
            case.claim, meaning.Scene(case.profile, case.at(exact, goal), goal, actions, scale)
        ).surely
        for row, good in zip(states.tolist(), holds.tolist(), strict=True):
            yield places.described(row, case.names), goal, good


@pytest.mark.parametrize("part", range(2))
def test_the_badge_says_what_an_independent_judge_says(part, run):
    asked, states = judged(part, 2, 60)
    told, expected = badges(asked, states, run)
    for one, said, right in zip(asked, told, expected, strict=True):
        assert said == right, (one.seed, one.source)
    said = list(itertools.chain.from_iterable(told))
    assert len(said) > 10_000 and 100 < said.count(False) < 0.9 * len(said)
    assert len({one.question.claim.name for one in asked}) >= 3


@functools.cache
def judged(number, step, count):
    """Every `step`-th of the questions from `number` on, and the states of each as they are judged."""
    asked = plain_questions(count)[number::step]
    return asked, [list(judged_states(one, seed)) for seed, one in enumerate(asked)]


def badges(asked, states, run, changed=lambda html: html):
    """What the page says in the states of each question, and what the judge does."""
    given = [
        (document(one.question.profile, Contents((Shown(one.question.claim),))), [(at, goal) for at, goal, _ in some])
        for one, some in zip(asked, states, strict=True)
    ]
    told = run(changed(page(asked[0].question.profile, Contents())), ASKED, given)
    return told, [[good for *_, good in some] for some in states]


@pytest.mark.parametrize(
    ("right", "wrong"),
    [
        ("compare(at) <= 0", "compare(at) < 0"),
        ("const doubt = (terms.length + 8) * Number.EPSILON", "const doubt = -1"),
        ("return rounded(game.agents[number])(total)", "return total * (1 + 1e-7)"),
    ],
)
def test_a_page_that_rounds_at_a_boundary_is_found_out(right, wrong, tmp_path):
    def changed(html):
        assert right in html
        return html.replace(right, wrong)

    told, expected = badges(*judged(0, 3, 60), lambda *given: RUNNERS["node"](*given, tmp_path), changed)
    assert told != expected


# --- claims with errors of features


def reachable(agent, at, eps):
    """The actions that errors can cause in each state: each float32 number between the extremes can be observed."""
    count = len(next(iter(at.values())))
    sides = {sign: np.zeros((len(agent.features), count), np.float32) for sign in (-1, 1)}
    for number, feature in enumerate(agent.features):
        for sign, seen in sides.items():
            error = fractions([sign * eps] * count) if feature.measurable else None
            seen[number] = measured(feature, at, MACHINE, np.float32, error)
    found = [set() for _ in range(count)]
    waiting = [(0, {})]
    while waiting:
        node, bounds = waiting.pop()
        feature = agent.feature[node]
        if feature >= 0:
            low, high = bounds.get(feature, (-np.inf, np.inf))
            cut = agent.threshold[node]
            waiting.append((agent.left[node], {**bounds, feature: (low, min(high, cut))}))
            waiting.append((agent.right[node], {**bounds, feature: (max(low, cut), high)}))
            continue
        for row in range(count):
            met = (
                sides[1][f, row] > low and sides[-1][f, row] <= high and low < high for f, (low, high) in bounds.items()
            )
            if all(met):
                found[row].add(int(agent.action[node]))
    return found


@functools.cache
def steady_questions():
    """(questions with errors of features, the page's documents of each with states, what holds there)."""
    fitting = (one for one in map(drawn, range(400)) if one.case.semantics == MACHINE and one.case.eps)
    asked, given, expected = list(itertools.islice(fitting, 25)), [], []
    for number, one in enumerate(asked):
        states, right = steady_states(one.case, np.random.default_rng(number))
        given.append((document(one.question.profile, Contents((Shown(one.question.claim),))), states))
        expected.append(right)
    return asked, given, expected


def test_steady_holds_where_no_error_makes_the_claim_fail(run):
    asked, given, expected = steady_questions()
    assert run(page(asked[0].question.profile, Contents()), ASKED, given) == expected
    said = list(itertools.chain.from_iterable(expected))
    assert len(said) > 500 and 20 < said.count(False) < 0.95 * len(said)


def steady_states(case, rng):
    """Some states at edges, and whether the claim holds in each, whatever errors there are."""
    goal = case.goals[0]
    states = places.sampled(case, goal, rng)[::9]
    if not len(states):
        return [], []
    ways = [reachable(agent, case.at(states, goal), case.eps) for agent in case.team]
    holds = [holds_for_all(case, states[row : row + 1], goal, [way[row] for way in ways]) for row in range(len(states))]
    return [(places.described(row, case.names), goal) for row in states.tolist()], holds


def holds_for_all(case, state, goal, ways):
    exact, scale = places.scaled(state, case.denominator)
    for joint in itertools.product(*ways):
        actions = {agent.name: np.array([action]) for agent, action in zip(case.team, joint, strict=True)}
        scene = meaning.Scene(case.profile, case.at(exact, goal), goal, actions, scale)
        if not meaning.holds(case.claim, scene).surely[0]:
            return False
    return True


# --- episodes


def exact(world):
    """The world without the haste of its simulator: pages play as mpe2 does, and leave no push out."""
    world.step = partial(world.step, exact=True)
    return world


@functools.cache
def played(name, count):
    """A committed profile, and the starts and episodes of the first seeds."""
    profile = committed(name)
    world = exact(matching_world(profile))
    trees = [tree_policies(profile.agents)] * len(profile.agents)
    return profile, list(starts(world, count)), play(world, trees, world.start_from_seeds(range(count)))


@pytest.mark.parametrize("name", first_of(2, POLICIES))
def test_episodes_are_the_simulators_action_for_action(name, run):
    profile, given, episodes = played(name, 200)
    ours, told = episodes.actions, np.array(run(page(profile, Contents()), PLAYED, given))
    assert (told == ours.transpose(1, 0, 2)).all()


@pytest.mark.parametrize("name", first_of(2, POLICIES))
def test_episode_claims_are_judged_by_the_episode(name, run):
    profile, given, episodes = played(name, 400)
    team = {"physical": "defenders", "proved_d": "defenders", "proved_n": "agents", "verdicts": "prey"}[name[:8]]
    others = {"others": ("adversary_0",)} if team != "agents" else {}
    wide = Fraction(2) if team == "prey" else Fraction(2, 5)  # prey do not go to obstacles
    claims = [
        find_claim("reaches", profile, team, radius=Fraction(1, 5)),
        find_claim("covers", profile, team, radius=wide),
        find_claim("keeps_apart", profile, team, radius=Fraction(3, 20), **others),
    ]
    asked = [(*start, place) for place in range(len(claims)) for start in given]
    told = np.reshape(run(page(profile, Contents(tuple(map(Shown, claims)))), JUDGED, asked), (len(claims), 400))
    for claim, said in zip(claims, told.tolist(), strict=True):
        assert said == expected_of(profile, claim, episodes), claim.name
        assert 0 < sum(said) < 400, claim.name


def expected_of(profile, claim, episodes):
    """Whether the claim holds in each episode, by the simulator's distances; none is at the radius itself."""
    places_of = np.array([state.position for state in episodes.states])  # [steps + 1, batch, entities, 2]
    names = [one.name for one in profile.world.agents + profile.world.landmarks]
    team = [names.index(policy.agent) for policy in profile.team(claim.team)]
    marks = [names.index(name) for name in account_of(claim).marks(profile)]
    gaps = np.abs(places_of[:, :, team, None] - places_of[:, :, None, marks]).max(axis=-1)
    radius = float(claim.radius)
    if claim.name == "keeps_apart":
        same = np.array([[a == b for b in marks] for a in team])
        return ((gaps >= radius) | same).all(axis=(0, 2, 3)).tolist()
    near = (gaps <= radius).any(axis=0) if claim.name == "reaches" else gaps[-1] <= radius
    if claim.name == "reaches":
        return np.logical_and.reduce([near[:, i, i] for i in range(len(team))]).tolist()
    ways = itertools.permutations(range(len(marks)), len(team))
    return np.logical_or.reduce(
        [np.logical_and.reduce([near[:, i, k] for i, k in enumerate(way)]) for way in ways]
    ).tolist()


# --- what is committed


def counterexamples():
    """Folder -> those whose claim fails by the state alone; a page knows no errors that a file names."""
    found = {}
    for file in sorted(GENERATED.glob("verdicts/*/counterexample-*.json")):
        stored = json.loads(file.read_text(encoding="utf-8"))
        if not stored.get("errors"):
            found.setdefault(file.parent, {})[file.name] = stored
    return found


WITH_FORMULAS = (
    STATE
    + """
  const judge = (asked) => Number.isInteger(asked) ? judges[asked]
    : Engine.judge(game, { formula: asked, eps: null, episode: null });
  return given.map(([at, goal, asked]) => judge(asked)(stateIn(game)(at, goal)));
"""
)


@pytest.mark.parametrize("folder", first_of(2, counterexamples()), ids=lambda folder: folder.name)
def test_committed_counterexamples_fail_on_the_page(folder, run):
    profile = profiles.loads((folder / "profile.json").read_text(encoding="utf-8"))
    claims, given = [], {}
    for name, stored in counterexamples()[folder].items():
        asked = stored.get("formula")
        if asked is None:
            asked = len(claims)
            claims.append(find_claim(stored["claim"], profile, stored["team"], **parameters_of(stored)))
        given[name] = stored["position"], stored["goal"], asked
    html = page(profile, Contents(tuple(map(Shown, claims)) or usual_claims(profile)))
    told = run(html, WITH_FORMULAS, list(given.values()))
    assert dict(zip(given, told, strict=True)) == dict.fromkeys(given, False)


def parameters_of(stored):
    given = dict(stored["parameters"])
    return {**given, "radius": Fraction(str(given["radius"])), "steps": int(given["steps"])}


@pytest.mark.parametrize("name", POLICIES)
@pytest.mark.smoke
def test_a_page_shows_a_claim_and_is_small_and_needs_no_network(name):
    profile = committed(name)
    html = page(profile, contents_of(profile, usual_claims(profile)))
    assert usual_claims(profile)
    assert len(html.encode()) < 300_000
    assert page(profile, contents_of(profile, usual_claims(profile))) == html
    for outside in ("http://", "https://", "import(", "fetch(", "XMLHttpRequest", "src="):
        assert outside not in html.replace("http://www.w3.org/2000/svg", ""), outside


# --- the command


def test_playing_leaves_the_page_of_another_verb_as_it_is(tmp_path, monkeypatch, capsys):
    """Pages of `demo` have verdicts, and their manifest their hashes: the page is opened, not written again."""
    opened: list[str] = []
    monkeypatch.setattr("webbrowser.open", lambda url: opened.append(Path(url.removeprefix("file://")).name) or True)
    folder = Path(shutil.copytree(GENERATED / "physical_deception", tmp_path / "demo"))
    before = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    assert "PROVED in the start region" in (folder / "play.html").read_text()
    asked = ["play", str(folder / "profile.json")]
    assert run_command(asked) == run_command(["play", str(folder / "extracted" / "profile.json")]) == 0
    assert opened == ["play.html"] * 2 and {path for path in folder.rglob("*") if path.is_file()} == {*before}
    assert run_command([*asked, "--certificate", str(folder / "certificate-1-distinct_targets.json")]) == 0
    other = Path(shutil.copy(folder / "extracted" / "profile.json", folder / "other.json"))
    assert run_command(["play", str(other)]) == 0
    assert opened[2:] == ["profile.play.html", "other.play.html"]
    (folder / "profile.play.html").unlink()
    assert run_command(["show", str(folder / "profile.json"), "--format", "html"]) == 0
    assert (folder / "profile.play.html").exists()
    assert all(path.read_bytes() == content for path, content in before.items())
