"""Claims about teams and agents that a profile does not have: errors wherever they are built, never true of nobody."""

import json
from dataclasses import replace
from fractions import Fraction

import pytest

import maviper
from codegen.errors import InputError, UnknownNameError
from codegen.policy_json import content_hash, dumps
from maviper.cli import main
from maviper.verification.ask import from_file
from maviper.verification.run import verify_claims
from tests.support.altered import altered, of_episodes, of_goals
from tests.support.small import small_profile
from tests.support.teams import team, towards
from verify import repair
from verify.certificates.games import to_json
from verify.checker import decisions as certificates
from verify.checker.episodes import certificates as episode_certificates
from verify.checker.episodes.certificates import Parts, ProofPart
from verify.checker.reading import RejectedError
from verify.claims.catalogue import find_claim, find_property
from verify.claims.claim import verifiable
from verify.claims.decisions import PLAIN, DistinctTargets, NoDouble, ensure_askable, formula
from verify.claims.episodes import EPISODE_CLAIMS, Covers, KeepsApart
from verify.claims.formula import TRUE
from verify.claims.region_files import everywhere
from verify.claims.wording import BUILT_IN, AliveLeaves, OwnFormula, account_of
from verify.episodes import composition
from verify.question import Question, from_start
from verify.solver.solve import decide, leaf_findings
from verify.states.episodes import at_rest, playable
from verify.states.state import State, violates
from verify.subjects import Game
from verify.verdicts import decisions, episodes

pytestmark = pytest.mark.solver

# all of them look like a team of the profile, or like nothing at all
STRANGERS = ["nobody", "", "defenders\u200b", "dеfenders", "defenders\r", "\x1b[2Kdefenders", "defenders\naccepted"]
PAIR = team(small_profile(), towards(0, 0), towards(1, 1))


@pytest.mark.parametrize("name", STRANGERS)
@pytest.mark.parametrize("property_name", [*PLAIN, "alive_leaves"])
def test_no_property_is_about_nobody(name, property_name):
    claim, start = BUILT_IN[property_name](name), everywhere(PAIR)
    with pytest.raises(UnknownNameError, match="unknown team"):
        find_property(property_name, PAIR, name)
    for ask in (
        lambda: formula(PAIR, claim),
        lambda: ensure_askable(PAIR, claim),
        lambda: verifiable(PAIR, name),
        lambda: decide(Question(Game(PAIR), claim, start)),
        lambda: decisions.verify(Question(Game(PAIR), claim, start), {}),
        lambda: verify_claims([Question(Game(PAIR), claim, start)]),
        lambda: leaf_findings(Question(Game(PAIR), AliveLeaves(name), start)),
    ):
        with pytest.raises(InputError, match="unknown team"):
            ask()


def test_no_formula_of_a_users_and_no_repair_is_about_nobody():
    own = OwnFormula("nobody", statement=TRUE)
    for ask in (
        lambda: ensure_askable(PAIR, own),
        lambda: decisions.verify(Question(Game(PAIR), own, everywhere(PAIR)), {}),
        lambda: repair.repair(Question(Game(PAIR), DistinctTargets("nobody"), everywhere(PAIR))),
        lambda: violates(from_start(PAIR, own), State({}, None)),
    ):
        with pytest.raises(UnknownNameError, match="unknown team 'nobody'"):
            ask()


@pytest.mark.parametrize("name", ["reaches", "covers", "keeps_apart"])
def test_no_claim_about_episodes_is_about_nobody(name):
    start = at_rest(everywhere(PAIR))
    for stranger in STRANGERS:
        claim = EPISODE_CLAIMS[name](stranger, 3, **({"landmarks": ("landmark_0",)} if name == "reaches" else {}))
        for ask in (
            lambda: find_claim(name, PAIR, stranger),  # noqa: B023
            lambda: episodes.verify_episodes(Question(Game(PAIR), claim, start), {}),  # noqa: B023
            lambda: composition.decide(Question(Game(PAIR), claim, start)),  # noqa: B023
        ):
            with pytest.raises(UnknownNameError, match="unknown team"):
                ask()
        with pytest.raises(InputError, match="the profile has no team"):
            episode_certificates.check_certificate(about_episodes(PAIR, claim), PAIR)


def test_nobody_keeps_apart_from_itself():
    alone = KeepsApart("adversaries", 3)
    for ask in (episodes.verify_episodes, composition.decide):
        given = ({},) if ask is episodes.verify_episodes else ()
        with pytest.raises(InputError, match="needs at least two"):
            ask(Question(Game(PAIR), alone, everywhere(PAIR)), *given)


def test_a_claim_needs_the_landmarks_that_it_speaks_of():
    """In a world without landmarks no two agents close on the same one."""
    bare = replace(PAIR.world, landmarks=(), goals=())
    policies = tuple(replace(one, features=one.features[:0]) for one in PAIR.agents)
    with pytest.raises(InputError, match="landmark for each agent"):
        ensure_askable(replace(PAIR, world=bare, agents=policies), NoDouble("defenders"))


def test_every_agent_acts_in_an_episode():
    """A profile may hold the policies of some agents only."""
    some = replace(PAIR, agents=PAIR.agents[1:])
    with pytest.raises(InputError, match="adversary_0 has no policy"):
        playable(some)
    claim = find_claim("reaches", PAIR)
    made = about_episodes(some, claim)
    followed = altered(made, parts=(ProofPart("", "", "", ("adversary_0", "agent_0", "agent_1"), b""),))
    with pytest.raises(RejectedError, match="agents that the profile does not have"):
        episode_certificates.check_certificate(followed, some)


# --- files


def region_with_inhabitant():
    start = everywhere(PAIR)
    return start, dict.fromkeys(start.box, Fraction(0))


def about_nobody(name, property_name="distinct_targets"):
    """A certificate of a formula that says nothing, with a proof that shows it."""
    region, inhabitant = region_with_inhabitant()
    empty = dict.fromkeys(region.goals, b"\x00")
    return of_goals(content_hash(PAIR), BUILT_IN[property_name](name), TRUE, region, "machine", inhabitant, empty)


def test_reaches_is_about_named_landmarks():
    """Of any matching, an agent near another landmark at another step would count as one that arrived."""
    with pytest.raises(InputError, match="each agent's own landmark"):
        EPISODE_CLAIMS["reaches"]("defenders", 3)
    assert account_of(EPISODE_CLAIMS["covers"]("defenders", 3)).way(PAIR) is None


def about_episodes(profile, claim):
    region, inhabitant = region_with_inhabitant()
    part = ProofPart("", "", "", ("agent_0", "agent_1"), b"\x00")
    return of_episodes(content_hash(profile), claim, region, inhabitant, Parts((part,)))


@pytest.fixture
def place(tmp_path):
    (tmp_path / "profile.json").write_text(dumps(PAIR))
    return tmp_path


@pytest.mark.parametrize("name", STRANGERS)
@pytest.mark.parametrize("property_name", ["distinct_targets", "own_target", "no_double", "aligned"])
def test_no_certificate_is_about_nobody(place, capfd, name, property_name):
    made = about_nobody(name, property_name)
    with pytest.raises(InputError, match="the profile has no team"):
        certificates.check_certificate(made, PAIR)
    (place / "c.json").write_text(to_json(made))
    code, said = checked_file(place, capfd)
    assert code == 2 and "the profile has no team" in said


@pytest.mark.parametrize("name", STRANGERS)
def test_no_certificate_about_episodes_is_about_nobody(place, capfd, name):
    made = about_episodes(PAIR, Covers(name, 3))
    (place / "c.json").write_text(to_json(made))
    code, said = checked_file(place, capfd)
    assert code == 2 and "the profile has no team" in said


def checked_file(place, capfd):
    """Exit code and what was said: nothing on the standard output, three lines of printable ASCII on the other."""
    code = main.run(["-q", "check", str(place / "c.json")])
    out, err = capfd.readouterr()
    assert out == "" and err.count("\n") == 3 and all(" " <= letter <= "~" for letter in err.replace("\n", "")), err
    return code, err


def test_no_property_file_is_about_nobody(place):
    for name in STRANGERS:
        for table in ('name = "distinct_targets"', 'name = "covers"', 'formula = "agent_0.x <= 2"'):
            (place / "p.toml").write_text(f"[[property]]\n{table}\nteam = {json.dumps(name)}\n")
            with pytest.raises(InputError, match=r"unknown team|must be a text"):
                from_file(place / "p.toml", PAIR, everywhere(PAIR))


def test_no_counterexample_is_about_nobody(place):
    same = team(PAIR, towards(0, 0), towards(0, 1))
    (place / "profile.json").write_text(dumps(same))
    asked = ["verify", str(place / "profile.json"), "--claim", "distinct_targets", "--claim", "covers"]
    assert main.run(["-q", *asked, "-o", str(place)]) == 1
    for file in sorted(place.glob("counterexample-*.json")):
        document = json.loads(file.read_text())
        for name in STRANGERS:
            (place / "edited.json").write_text(json.dumps(document | {"team": name, "actions": {}}))
            with pytest.raises(InputError, match=r"no team|unknown team"):
                maviper.replay(place / "edited.json", place / "profile.json")
    states = json.loads((place / "states-1-distinct_targets.json").read_text())
    for name in STRANGERS:
        (place / "edited.json").write_text(json.dumps(states | {"team": name}))
        asked = ["extract", "physical-deception", "--counterexamples", str(place / "edited.json"), "-o"]
        assert main.run(["-q", *asked, str(place / "new.json")]) == 2
