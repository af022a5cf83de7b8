"""Counterexamples about whole episodes as files, and their replay.

Does: writes the start, the claim and the actions of an episode that fails; plays it again and judges it.
Assumes: results of `verify.verdicts.episodes.verify_episodes`; a profile of the same world, the same policy or a
  better one.
Does not: look for counterexamples.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec

from codegen.errors import InputError, UnknownNameError, escape_text
from codegen.ir import PolicyProfile, WorldSpec
from codegen.policy_json import content_hash
from maviper.files import runs
from maviper.verification.bench import replay_course
from verify.claims.catalogue import ZONES, find_episode_claim, readable
from verify.claims.claim import Parameter
from verify.claims.episodes import EPISODE_CLAIMS, EpisodeClaim
from verify.claims.region import goal_of, goal_text
from verify.claims.region_files import positions
from verify.claims.wording import region_document
from verify.exact import MAX_NUMBER, read_number
from verify.states.episodes import Episode, fails, playable
from verify.states.state import State

if TYPE_CHECKING:
    from verify.verdicts.episodes import EpisodeResult

FORM = "maviper-episode-counterexample-1"
MAX_BYTES = 1 << 24
ADVICE = "make it again with `maviper verify -o`"


class EpisodeJson(msgspec.Struct, forbid_unknown_fields=True):
    """The members of the file."""

    counterexample: str
    profile: str  # content hash
    property: str  # as it is shown
    claim: str  # its name
    team: str
    parameters: dict[str, int | str | list[str]]  # of the claim; exact numbers are texts
    region: dict[str, Any]  # in which it was found
    goal: str
    position: dict[str, float]  # of the start, at rest
    actions: dict[str, str]  # agent -> what it did, step by step, with spaces between
    explanation: dict[str, Any] = {}  # as in the report; replays do not read it


@dataclass(frozen=True)
class ReplayedEpisode:
    """An episode played again: whether the claim fails in it, what every agent does, and what played it alike."""

    file: EpisodeJson
    violated: bool
    actions: Mapping[str, str]
    by: tuple[str, ...]


def document(profile: PolicyProfile, result: EpisodeResult) -> dict[str, Any]:
    """Returns the contents of the file of a violated claim."""
    claim, evidence = result.claim, result.evidence
    assert evidence.state is not None and evidence.episode is not None
    broken = {**claim.parameters, "steps": claim.steps}  # of a claim for ever, as many steps as it takes
    return {
        "counterexample": FORM,
        "profile": content_hash(profile),
        "property": claim.shown,
        "claim": claim.name,
        "team": claim.team,
        "parameters": {name: _encode_parameter(value) for name, value in broken.items()},
        "region": region_document(result.region),
        "goal": goal_text(evidence.state.goal),
        "position": dict(evidence.state.position),
        "actions": _name_actions(profile, evidence.episode),
        "explanation": {} if evidence.explanation is None else evidence.explanation.document(),
    }


def _name_actions(profile: PolicyProfile, episode: Episode) -> dict[str, str]:
    """Agent -> its actions by name, in order."""
    return {
        entity.name: " ".join(
            profile.policy(entity.name).actions[int(action)].name for action in episode.actions[:, place]
        )
        for place, entity in enumerate(profile.world.agents)
    }


def _encode_parameter(value: Parameter) -> int | str | list[str]:
    if isinstance(value, tuple):
        return list(value)
    return value if isinstance(value, int) else str(value)


def replay(path: Path, profile: PolicyProfile) -> ReplayedEpisode:
    """The episode of a file, played with a profile: the one that it is about, or another of its world.

    InputError when the file is damaged or speaks of what the profile does not have; DisagreementError when compiled C
    or environment take another course.
    """
    stored = _read(path)
    claim = _claim(stored, profile, path)
    strange = sorted(set(stored.actions) - {entity.name for entity in profile.world.agents})
    start = State(stored.position, goal_of(stored.goal))
    ensure_of_world(profile.world, [start], strange, path)
    for name, value in stored.position.items():
        if value and name.endswith((".vx", ".vy")):
            raise InputError("not a counterexample", f"{path}: {name} is not 0, but episodes start at rest", ADVICE)
    playable(profile)
    episode, by = replay_course(profile, start, claim.steps)
    return ReplayedEpisode(stored, fails(profile, claim, episode.coordinates), _name_actions(profile, episode), by)


def _read(path: Path) -> EpisodeJson:
    stored = runs.decode_file(path, MAX_BYTES, EpisodeJson, "not a counterexample", ADVICE)
    if stored.counterexample != FORM:
        raise InputError(
            "a counterexample of another version", f"{path}: '{escape_text(stored.counterexample[:40])}'", ADVICE
        )
    return stored


def _claim(episode: EpisodeJson, profile: PolicyProfile, path: Path) -> EpisodeClaim:
    """The claim of the file; InputError for a name or a parameter that there is not, or out of its range."""
    if episode.claim not in EPISODE_CLAIMS:
        raise UnknownNameError("claim", episode.claim, EPISODE_CLAIMS, str(path))
    read = readable(episode.claim)
    for name in episode.parameters:
        if name not in read:
            raise UnknownNameError("parameter", name, read, str(path))
    try:
        given = {name: _value(name, value) for name, value in episode.parameters.items() if name != ZONES}
        claim = find_episode_claim(episode.claim, profile, episode.team, **given)
    except InputError as error:
        error.where = f"{path}: {error.where}" if error.where else str(path)
        raise
    except ValueError as error:
        raise InputError("not a counterexample", f"{path}: {escape_text(error)}"[:200], ADVICE) from None
    return claim


def _value(name: str, value: int | str | list[str]) -> Any:
    """A parameter as claims take it. ValueError for one of another kind."""
    kind = {"steps": int, "radius": Fraction}.get(name, tuple)
    if kind is tuple and isinstance(value, list):
        return tuple(value)
    if kind is int and isinstance(value, int):
        return value
    if kind is Fraction and isinstance(value, str):
        return read_number(value)
    raise ValueError(f"{name} is {str(value)[:40]!r}")


def ensure_of_world(world: WorldSpec, states: Sequence[State], strange: Sequence[str], path: Path) -> None:
    """InputError for states that name what a world does not have or leave places out, or that are too far away.
    `strange`: further names that nobody knows.
    """
    placed = {name for state in states for name in state.position}
    strange = [
        *sorted(placed - set(world.coordinates())),
        *strange,
        *sorted(f"goal {goal or 'none'}" for goal in {state.goal for state in states} - set(world.goals or (None,))),
        *sorted({f"no {name}" for state in states for name in set(positions(world)) - set(state.position)}),
    ]
    if strange:
        what = ", ".join(map(escape_text, strange[:5]))
        raise InputError("the counterexample is about another world", f"{path}: {what}", "give its profile")
    for name, value in (pair for state in states for pair in (*state.position.items(), *state.errors.items())):
        if abs(value) > MAX_NUMBER:
            raise InputError("not a counterexample", f"{path}: {escape_text(name)} is beyond {MAX_NUMBER}", ADVICE)
