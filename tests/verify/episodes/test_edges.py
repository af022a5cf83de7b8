"""Claims for ever, decided: against episodes of random trees, in property files, and as whole answers."""

from dataclasses import replace
from fractions import Fraction as F

import numpy as np
import pytest

from codegen.errors import InputError
from tests.support.teams import DOWN, LEFT, RIGHT, STAY, UP, nested, team, tree
from verify.checker.episodes.certificates import check_certificate
from verify.claims.catalogue import find_claim, in_general, usual
from verify.claims.episodes import KeepsApart, StaysIn
from verify.claims.files import read_properties
from verify.claims.region_files import everywhere
from verify.claims.wording import account_of
from verify.episodes.unbounded import decide
from verify.question import Question
from verify.result import Verdict
from verify.states.episodes import play
from verify.states.shares import SAMPLE_SEED
from verify.states.state import sample
from verify.subjects import Game
from verify.verdicts.episodes import verify_episodes

THRESHOLDS = (-1.5, -0.5, 0.0, 0.25, 1.0)


def grown(rng, policy):
    """A random tree of a few tests, most of which turn an agent back."""

    def grow(left):
        if not left or rng.random() < 0.15:
            return int(rng.integers(5))
        feature, at = int(rng.integers(len(policy.features))), float(rng.choice(THRESHOLDS))
        return feature, at, grow(left - 1), grow(left - 1)

    return nested(grow(3))


def boxed(rng, policy):
    """As `grown` between walls: far beyond landmark 0 on some sides the agent is turned back."""
    names = [feature.name for feature in policy.features]
    dx, dy = names.index("landmark_0_dx"), names.index("landmark_0_dy")
    turn = [LEFT, RIGHT, DOWN, UP] if rng.random() < 0.7 else [int(rng.integers(5)) for _ in range(4)]
    inner = int(rng.integers(5))
    return tree((dx, -1.5, 1, 2), turn[0], (dx, 1.5, 3, 8), (dy, -1.5, 4, 5), turn[2], (dy, 1.5, 6, 7), inner, turn[3],
                turn[1])  # fmt: skip


def disagreements(profile, seed, count):
    """Verdicts of random teams that their episodes refute, and how many claims were proved."""
    rng, wrong, proved = np.random.default_rng(seed), [], 0
    names = profile.world.coordinates()
    for number in range(count):
        make = boxed if number % 3 else grown
        one = team(profile, *(make(rng, profile.policy(f"agent_{place}")) for place in range(2)))
        radius = F(int(rng.integers(8, 24)), 4)
        claim = find_claim("stays_in", one, radius=radius)
        found = decide(Question(Game(one), claim, everywhere(one)))
        if found.verdict is not Verdict.PROVED:
            continue
        proved += check_certificate(found.certificate, one) > 0
        starts, _ = sample(everywhere(one), one.world, 100, SAMPLE_SEED + number)
        episode, _ = play(one, np.concatenate([starts, np.sign(starts[:50])]), 120)
        ours = [names.index(f"agent_{place}.{axis}") for place in range(2) for axis in "xy"]
        if np.abs(episode[..., ours]).max() > float(radius):
            wrong.append((number, radius))
    return wrong, proved


@pytest.mark.parametrize(
    ("seed", "count"),
    [(1, 6), pytest.param(2, 80, marks=pytest.mark.slow), pytest.param(3, 2_000, marks=pytest.mark.nightly)],
)
def test_what_is_proved_is_true_of_episodes(profile, seed, count):
    wrong, proved = disagreements(profile, seed, count)
    assert wrong == [] and proved > count / 8


def read(profile, lines):
    text = "[[property]]\n" + "\n".join(lines)
    return read_properties(text, profile, "p.toml", lambda _: everywhere(profile))[0].claim


def test_a_file_says_always(profile):
    claim = read(profile, ['name = "keeps_apart"', 'steps = "always"', 'team = "defenders"', "radius = 0.5"])
    assert isinstance(claim, KeepsApart) and claim.ever and claim.parameters["steps"] == "always"
    assert account_of(claim).sentence.endswith("stays at least 1/2 (L-infinity) away from all others of them for ever")
    assert claim != replace(claim, ever=False) and claim.by_edges and not replace(claim, ever=False).by_edges
    stays = read(profile, ['name = "stays_in"', "radius = 2"])
    assert isinstance(stays, StaysIn) and stays.ever and read(profile, ['name = "stays_in"', "steps = 9"]).steps == 9
    assert usual("stays_in") == {"steps": "always", "radius": 3} and "or for ever" in in_general("keeps_apart")
    for steps, said in (('"alway"', "whole number"), ("true", "whole number"), ("2.5", "whole number")):
        with pytest.raises(InputError, match=said) as refused:
            read(profile, ['name = "stays_in"', f"steps = {steps}"])
        assert 'steps = "always"' in refused.value.next_step
    with pytest.raises(InputError, match="not about all steps") as refused:
        read(profile, ['name = "covers"', 'steps = "always"'])
    assert "keeps_apart and stays_in" in refused.value.next_step and "line 3" in str(refused.value.where)


def test_whole_answers(profile, few_states):
    """A counterexample for ever has the steps that it takes; some steps are proved as all are; contacts are unknown."""
    runaway, start = team(profile, tree(RIGHT), tree(STAY)), everywhere(profile)
    question = Question(Game(runaway), find_claim("stays_in", runaway), start)
    found = verify_episodes(question, {})
    assert found.verdict is Verdict.VIOLATED and found.claim.ever and 10 < found.claim.steps < 40
    places = [place[0] for way in found.evidence.ways if way.agent == "agent_0" for place in way.places]
    assert max(places[:-1]) <= 3 < places[-1] and "from the origin at step" in str(found.evidence.ways[0])
    still = team(profile, tree(STAY), tree(STAY))
    some = verify_episodes(Question(Game(still), find_claim("stays_in", still, steps=5, radius=2), start), {})
    assert some.verdict is Verdict.PROVED and check_certificate(some.certificate, still) >= 0 and not some.claim.ever
    hard = tuple(replace(agent, collides=True) for agent in still.world.agents)
    pushed = replace(still, world=replace(still.world, agents=hard, contact_force=100.0))
    unknown = decide(Question(Game(pushed), find_claim("stays_in", pushed), start))
    assert unknown.verdict is Verdict.UNKNOWN and "contacts" in unknown.reason
