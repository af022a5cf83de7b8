"""One question about episodes: drawn from its seed, asked of the verifier, every word of the answer judged.

Does: teams that go somewhere or stand, small regions of starts, the claims reaches, covers and keeps_apart; worlds of
  all kinds, or those in which agents push each other; verdicts, counterexamples, explanations and forged certificates
  against the judge's episodes in mpe2.
Assumes: the front door, with few sampled starts: so zones decide, and not samples.
Does not: keep records (record.py).
"""

import copy
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from codegen import policy_json
from codegen.errors import InputError
from codegen.ir import PolicyProfile
from tests.hunting import forging, playing, teams
from tests.hunting.asking import Told, ending
from tests.hunting.places import Case
from tests.hunting.reading import MACHINE, read
from tests.hunting.regions import value
from tests.support.altered import read_game, sealed
from tests.support.strategies import with_trees
from tests.support.teams import nested
from verify.certificates.games import to_json
from verify.checker.episodes.certificates import check_certificate
from verify.checker.reading import RejectedError
from verify.claims.catalogue import find_claim
from verify.claims.region import Region
from verify.claims.region_files import everywhere
from verify.question import Budgets, EpisodeQuestion, Question
from verify.subjects import Game
from verify.verdicts import episodes as front
from verify.verdicts.episodes import EpisodeResult, verify_episodes

WORLDS = {
    "physical-deception,defenders=1": 6,
    "physical-deception": 5,
    "physical-deception,features=signs": 3,
    "cooperative-navigation,agents=2": 1,
    "predator-prey": 1,
}
PUSHING = {
    "cooperative-navigation,agents=2": 3,
    "cooperative-navigation": 1,
    "predator-prey": 1,
    "predator-prey,predators=1,prey=1,obstacles=1": 3,
}
ZONES = 10_000
SAMPLES = 300
SIDES = (Fraction(1, 16), Fraction(1, 64), Fraction(1, 8), Fraction(0), Fraction(1, 2**30))
FORGING = 2  # of so many certificates one is forged


@dataclass(frozen=True)
class Asked:
    """A question about episodes, both ways."""

    seed: int
    case: Case
    question: EpisodeQuestion


def drawn(seed: int, worlds: Mapping[str, int] = WORLDS, doubled: bool = False) -> Asked:
    """The question of a seed, in one of some worlds, by their weights. `doubled`: some agents compare float64."""
    rng = np.random.default_rng([seed, 7])
    weights = np.array(list(worlds.values()), dtype=float)
    world = str(rng.choice(list(worlds), p=weights / weights.sum()))
    profile, team = teams.bare(world), teams.TEAMS[world.split(",")[0]]
    goes = bool(rng.random() < 0.92)
    profile, meeting = _team(rng, profile, team, goes)
    if doubled:
        (profile,) = teams.doubled(np.random.default_rng([seed, 64]), profile)
    start = everywhere(profile)
    claim = _claim(rng, profile, team, goes)
    box = _box(rng, start.box, claim)
    if meeting:
        box |= _touching(rng, box, meeting)
    region = {"box": box, "differences": [], "apart": [], "goals": _goals(rng, start.goals)}
    case = Case(read(policy_json.dumps(profile)), claim, region, MACHINE)
    given = {key: claim[key] for key in ("steps", "radius", "landmarks", "others") if claim[key]}
    stated = find_claim(claim["name"], profile, team, **given)
    where = Region(region["box"], tuple(region["goals"]))
    return Asked(seed, case, Question(Game(profile), stated, where, budgets=Budgets(max_zones=ZONES)))


def _team(rng: np.random.Generator, profile: PolicyProfile, team: str, goes: bool) -> tuple[PolicyProfile, list[str]]:
    """A team that goes to its landmarks, or does anything; and two coordinates whose sign one of them tests at -0.5 and
    at 0.5, doing another thing where they are equal.
    """
    policies, marks = profile.team(team), [mark.name for mark in profile.world.landmarks]
    nodes, meeting = [], []
    for number, one in enumerate(policies):
        if goes and len(marks) >= len(policies):
            nodes.append(teams.role(rng, one, marks[number], int(rng.integers(1, 3)), (0.1, 0.35)))
        else:
            nodes.append(teams.wild(rng, one, int(rng.integers(3, 6))))
    if rng.random() < 0.2:
        number = int(rng.integers(len(policies)))
        feature = len(policies[number].features) - 3  # the sign that teams.bare adds
        other = int(rng.integers(5))
        nodes[number] = teams.between(feature, nodes[number], other)
        meaning = policies[number].features[feature].meaning
        meeting = [name for _, name in meaning.terms] if meaning else []
    trees = {one.agent: nested(node) for one, node in zip(policies, nodes, strict=True)}
    if rng.random() < 0.3:
        one = policies[int(rng.integers(len(policies)))]
        trees[one.agent] = teams.changed(rng, trees[one.agent], len(one.actions))
    return with_trees(trees, profile), meeting


def _touching(rng: np.random.Generator, box: Mapping[str, Any], names: list[str]) -> dict[str, Any]:
    """Intervals of coordinates that meet in one number, or in many."""
    center, side = box[names[0]][0], SIDES[int(rng.integers(len(SIDES)))]
    ends = [(center, center + side), (center - side, center), (center, center)]
    return {name: ends[int(rng.integers(3))] for name in names}


def _claim(rng: np.random.Generator, profile: PolicyProfile, team: str, goes: bool) -> dict[str, Any]:
    marks = [mark.name for mark in profile.world.landmarks]
    agents = [one.agent for one in profile.team(team)]
    name = str(rng.choice(["reaches", "covers", "keeps_apart"], p=[0.66, 0.2, 0.14]))
    claim: dict[str, Any] = {"name": name, "team": team, "landmarks": (), "others": (), "eps": Fraction(0)}
    claim["steps"] = int(rng.choice([2, 8, 10, 12, 12, 14] if goes else [1, 2, 4, 6]))
    claim["radius"] = Fraction(str(rng.choice(["2/5", "2/5", "3/10", "1/2", "1/2"])))
    if name == "reaches":
        claim["landmarks"] = tuple(marks[: len(agents)])
    if name == "keeps_apart":
        others = [policy.agent for policy in profile.agents if policy.team != team] or marks
        claim["others"] = (str(rng.choice([*others, *marks])),)
        claim["radius"] = Fraction(str(rng.choice(["1/10", "3/20", "1/4", "1/64"])))
    return claim


def _goals(rng: np.random.Generator, goals: tuple[str, ...]) -> list[str]:
    return [str(rng.choice(goals))] if goals and rng.random() < 0.6 else list(goals)


def _box(rng: np.random.Generator, box: Mapping[str, Any], claim: Mapping[str, Any]) -> dict[str, Any]:
    """Small intervals around points, the landmarks a way off from the agents that are to reach them, some with
    an end where a feature is 0; velocities as they may be.
    """
    middle = {axis: Fraction(round(float(value(rng)) * 2**20), 2**20) * int(rng.integers(2)) for axis in "xy"}
    middles = {name: middle[name[-1]] + Fraction(int(rng.integers(-4, 5)), 16) for name in box if name[-2] == "."}
    if rng.random() < (0.05 if claim["name"] == "reaches" else 0.3):  # all at one place
        middles = {name: middle[name[-1]] for name in middles}
    elif rng.random() < 0.9:
        far = sorted(middles)[int(rng.integers(len(middles)))][-1]
        near = Fraction(math.ceil(claim["radius"] * 16), 16)
        for name in [name for name in middles if name[-1] == far and not name.startswith("a")]:
            middles[name] += int(rng.choice([-1, 1])) * (near + Fraction(int(rng.integers(0, 4)), 8))
    found, widest = dict(box), SIDES[int(rng.integers(len(SIDES)))]
    for name, center in middles.items():
        side = widest if rng.random() < 0.6 else Fraction(0)
        ends = [(center, center), (center, center + side), (center - side, center), (center - side, center + side)]
        found[name] = ends[int(rng.integers(4))]
    return found


# --- asking


def ask(asked: Asked, thorough: bool = False) -> Told:
    """Asks a question and judges the answer."""
    rng = np.random.default_rng([asked.seed, 8])
    claim = asked.case.claim
    told = Told(asked.seed, kind=claim["name"], depth=max(agent.depth for agent in asked.case.team), front=True)
    with ending(told):
        result = few_samples(asked.question)
        told.verdict = result.verdict.value
        violation, told.conflict = playing.look(asked.case, asked.seed)
        told.judged = "violated" if violation else ""
        case = asked.case
        if told.verdict == "PROVED" and violation is not None:
            told.wrong.append(f"proved, but fails at {violation}")
        if told.verdict == "VACUOUS" and violation is not None:
            told.wrong.append(f"vacuous, but fails at {violation}")
        if told.verdict == "VIOLATED":
            state = result.evidence.state
            assert state is not None
            told.judged = "violated"
            if not playing.violates(case, state.position, state.goal):
                told.wrong.append(f"shows {state}, from where the claim holds")
            elif result.evidence.explanation is not None:
                _explained(case, result, told)
        if result.evidence.certificate is not None:
            told.second = True  # the second reading closed every branch
            if thorough or rng.integers(FORGING) == 0:
                _forged(asked, to_json(result.evidence.certificate), told, rng)
    return told


def few_samples(question: EpisodeQuestion) -> EpisodeResult:
    """The front door, with so few sampled starts that zones have to decide."""
    usual, front.SAMPLES = front.SAMPLES, SAMPLES
    try:
        return verify_episodes(question, {})
    finally:
        front.SAMPLES = usual


def _explained(case: Case, result: EpisodeResult, told: Told) -> None:
    """From the ends of the intervals that are told the claim fails by the same actions of the team."""
    state, explanation = result.evidence.state, result.evidence.explanation
    assert state is not None and explanation is not None
    names, steps = [f"{agent.name}!" for agent in case.team], case.claim["steps"]
    usual = playing.played(case.profile, state.position, state.goal, steps)
    for span in explanation.spans:
        for end in {span.low, span.high}:
            moved = {**state.position, span.name: end}
            course = playing.played(case.profile, moved, state.goal, steps)
            same = all(np.array_equal(course[name], usual[name]) for name in names if steps)
            if not case.profile.world["contact_force"] and not (same and playing.violates(case, moved, state.goal)):
                told.wrong.append(f"says that the start's {span.name} may be {end!r}")


# --- forging


def _forged(asked: Asked, text: str, told: Told, rng: np.random.Generator) -> None:
    if to_json(read_game(text)) != text:
        told.wrong.append("a certificate reads back as another one")
    for _ in range(3):
        document = copy.deepcopy(json.loads(text))
        change = CHANGES[int(rng.integers(len(CHANGES)))]
        change(document, rng)
        told.forged += 1
        try:
            check_certificate(read_game(sealed(document)), asked.question.profile)
        except (InputError, RejectedError):
            told.refused += 1
            continue
        claimed = _case_of(document, asked.case)
        if not claimed.team:
            told.wrong.append(f"accepts a certificate about nobody ({change.__name__})")
        elif (found := playing.look(claimed, asked.seed)[0]) is not None:
            told.wrong.append(f"accepts a forged certificate ({change.__name__}), the claim fails at {found}")


def _case_of(document: Mapping[str, Any], case: Case) -> Case:
    claim = {"name": document["property"], "team": document["team"], "steps": document["steps"]}
    claim |= {"radius": forging.number(document["radius"])}
    claim |= {names: tuple(document.get(names, ())) for names in ("landmarks", "others")}
    return Case(case.profile, claim, forging.region_of(document["region"]), document["semantics"])


def _parts(document: forging.Document, rng: np.random.Generator) -> None:
    """Proofs of parts emptied, changed, left out or exchanged."""
    parts = document["parts"]
    part = parts[int(rng.integers(len(parts)))]
    kind = int(rng.integers(4))
    if kind == 0:
        part["proof"] = []
    elif kind == 1 and len(parts) > 1:
        parts.remove(part)
    elif kind == 2 and len(parts) > 1:
        part["proof"] = parts[0]["proof"]
    else:
        box = {"proofs": {"": part["proof"]}}
        (forging.flipped if rng.random() < 0.5 else forging.cut)(box, rng)
        part["proof"] = box["proofs"][""]


def _stated(document: forging.Document, rng: np.random.Generator) -> None:
    """Another claim of the same proof."""
    kind, apart = int(rng.integers(5)), document["property"] == "keeps_apart"
    if kind == 0:
        document["steps"] = max(0, document["steps"] + int(rng.choice([-3, -1, 1, 5])))
    elif kind == 1:
        factor = Fraction(1, int(rng.integers(2, 6)))
        document["radius"] = str(forging.number(document["radius"]) * (1 / factor if apart else factor))
    elif kind == 2:
        document["property"] = "covers" if document["property"] == "reaches" else "reaches"
        document.setdefault("landmarks", document.pop("others", []))
    elif kind == 3 and apart:
        document["others"] = [] if document["others"] else ["landmark_0"]
    elif kind == 3:
        document["landmarks"] = document["landmarks"][::-1]
    else:
        document["team"] = forging.STRANGE[int(rng.integers(len(forging.STRANGE)))]


def _placed(document: forging.Document, rng: np.random.Generator) -> None:
    """Another region, goal, or other agents followed."""
    part = document["parts"][int(rng.integers(len(document["parts"])))]
    kind = int(rng.integers(3))
    if kind == 0:
        forging.wider(document, rng)
    elif kind == 1 and document["region"]["goals"]:
        other = {"landmark_0": "landmark_1", "landmark_1": "landmark_0"}
        document["region"]["goals"] = [other[goal] for goal in document["region"]["goals"]]
        for one in document["parts"]:
            one["goal"] = other.get(one["goal"], "")
    else:
        part["followed"] = part["followed"][::-1] if len(part["followed"]) > 1 else ["adversary_0"]


def _named(document: forging.Document, rng: np.random.Generator) -> None:
    """A part about another pair, or about all of them; another form of the same proof."""
    part, kind = document["parts"][int(rng.integers(len(document["parts"])))], int(rng.integers(3))
    if kind == 0:
        part["agent"] = part["landmark"] = ""
    elif kind == 1:
        part["agent"], part["landmark"] = part["landmark"], part["agent"]
    else:
        document["certificate"] = document["certificate"][:-1] + str(rng.integers(1, 4))


CHANGES = (_parts, _stated, _placed, _named)
