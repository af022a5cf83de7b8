"""Counterexamples as files, and their replay.

Does: writes a counterexample with its claim and a test of it; replays one by reference, compiled C and environment.
Assumes: results of `verify.engine.verify`; a profile of the same world, the same policy or a better one.
Does not: look for counterexamples; the files of those about whole episodes are in episode_files.py.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

import msgspec

from codegen.errors import DisagreementError, ExitCode, InputError
from codegen.ir import PolicyProfile, act
from codegen.policy_json import content_hash, layout
from codegen.render import render
from maviper import episode_files, load, runs
from maviper.claims import replayed
from maviper.console import Console
from verify.closed_loop import LoopResult
from verify.counterexample import Counterexample
from verify.engine import Result
from verify.formula import Acts, Formula, Goal, agents, atoms, coordinates, for_goal, holds
from verify.formula_json import formula_document, read_formula
from verify.properties import formula
from verify.spec import MOST
from verify.world import Point, error_name, observed

FORM = "maviper-counterexample-1"
MAX_BYTES = 1 << 24
ADVICE = "make it again with `maviper verify -o`"


class CounterexampleJson(msgspec.Struct, forbid_unknown_fields=True):
    """The members of the file."""

    counterexample: str
    profile: str  # content hash
    property: str
    team: str
    formula: dict[str, Any]
    goal: str
    position: dict[str, float]  # every coordinate that the region bounds
    errors: dict[str, float]  # of features, as `verify.world.error_name` names them
    actions: dict[str, str]  # agent -> what it did
    explanation: dict[str, Any] = {}  # as in the report; replays do not read it


@dataclass(frozen=True)
class Replayed:
    """What the team does in the world state, and whether the claim fails there; of an episode, what all agents do, step
    by step, and whether the claim fails in it.
    """

    property: str
    violated: bool
    actions: Mapping[str, str]  # of an episode: in order, with spaces between
    before: Mapping[str, str]  # what the file says that it did
    by: tuple[str, ...]  # what gave the same actions
    same_policy: bool


def counterexample_files(profile: PolicyProfile, results: Sequence[Result | LoopResult]) -> dict[str, str]:
    """For each violated claim a file, and a test that fails until a policy holds there."""
    files: dict[str, str] = {}
    for place, result in enumerate(results, 1):
        if isinstance(result, LoopResult):
            document = None if result.point is None else episode_files.document(profile, result)
        else:
            document = None if result.counterexample is None else _document(profile, result, result.counterexample)
        if document is None:
            continue
        stem = f"counterexample-{place}-{result.claim.name}"
        files[f"{stem}.json"] = layout(document) + "\n"
        where = "from its start" if isinstance(result, LoopResult) else "in its world state"
        named = {"name": f"{stem}.json", "place": place, "where": where}
        files[f"test_{stem.replace('-', '_')}.py"] = render("tests/counterexample.py.j2", **named)
    return files


def _document(profile: PolicyProfile, result: Result, found: Counterexample) -> dict[str, Any]:
    claim = result.claim
    return {
        "counterexample": FORM,
        "profile": content_hash(profile),
        "property": claim.shown,
        "team": claim.team,
        "formula": formula_document(formula(profile, claim)),
        "goal": found.point.goal,
        "position": dict(found.point.position),
        "errors": dict(found.point.errors),
        "actions": {view.agent: view.action for view in found.agents},
        "explanation": {} if result.explanation is None else result.explanation.document(),
    }


def replay(path: Path, profile: PolicyProfile) -> Replayed:
    """The counterexample of a file, replayed with a profile: the one that it is about, or another of its world.

    InputError when the file is damaged or speaks of what the profile does not have; DisagreementError when compiled C
    or environment act differently from the reference.
    """
    if episode_files.holds_episode(path):
        return _replayed_episode(path, profile)
    found, claim = read_counterexample(path, profile)
    strange = sorted(set(found.actions) - {policy.agent for policy in profile.team(found.team)})
    if strange:
        raise InputError("the counterexample is about another world", f"{path}: {', '.join(strange[:5])}", ADVICE)
    point = Point(found.position, found.goal, found.errors)
    team = profile.team(found.team)
    taken = {policy.agent: int(act(policy, observed(profile, policy, point))[0]) for policy in team}
    by = replayed(profile, found.team, point)
    for name, actions in by.items():
        if list(taken.values()) != actions:
            raise DisagreementError(f"{name} acts differently", f"reference {taken}, {name} {actions}", "this is a bug")
    at = dict(zip(profile.world.coordinates(), point.coordinates(profile)[0], strict=True))
    exact = {name: Fraction(float(value)) for name, value in at.items()}
    names = {policy.agent: policy.actions[taken[policy.agent]].name for policy in team}
    return Replayed(
        property=found.property,
        violated=not holds(for_goal(claim, found.goal), exact, taken),
        actions=names,
        before=found.actions,
        by=("reference", *by),
        same_policy=content_hash(profile) == found.profile,
    )


def _replayed_episode(path: Path, profile: PolicyProfile) -> Replayed:
    episode = episode_files.replay(path, profile)
    found = episode.file
    return Replayed(
        property=found.property,
        violated=episode.violated,
        actions=episode.actions,
        before=found.actions,
        by=("reference", *episode.by),
        same_policy=content_hash(profile) == found.profile,
    )


def replay_command(path: Path, profile: Path | None, console: Console) -> int:
    """The command `maviper replay`: 1 when the claim fails in the world state or episode, else 0."""
    found = replay(path, load(path.parent / runs.PROFILE_FILE if profile is None else profile))
    if not found.same_policy:
        console.line("policy", "not the one that the counterexample is about")
    for agent, action in found.actions.items():
        changed = "" if action == found.before.get(agent) else f" (was {found.before.get(agent)})"
        console.line(agent, f"{action}{changed}")
    console.line("replayed", f"by {', '.join(found.by)}, which act alike")
    console.line("VIOLATED" if found.violated else "holds", found.property)
    return ExitCode.VIOLATED if found.violated else ExitCode.DONE


def _strange_parts(claim: Formula, team: str, profile: PolicyProfile) -> list[str]:
    """Goals and actions of a formula that the profile does not have; its agents are known."""
    actions, parts = {policy.agent: policy.actions for policy in profile.team(team)}, list(atoms(claim))
    acts = sorted({(atom.agent, atom.action) for atom in parts if isinstance(atom, Acts)})
    return [
        *sorted({atom.landmark for atom in parts if isinstance(atom, Goal)} - set(profile.world.goals)),
        *(f"action {number} of {agent}" for agent, number in acts if not 0 <= number < len(actions[agent])),
    ]


def _read(path: Path) -> CounterexampleJson:
    found = runs.decoded(path, MAX_BYTES, CounterexampleJson, "not a counterexample", ADVICE)
    if found.counterexample != FORM:
        raise InputError("a counterexample of another version", f"{path}: {found.counterexample[:40]!r}", ADVICE)
    return found


def read_counterexample(path: Path, profile: PolicyProfile) -> tuple[CounterexampleJson, Formula]:
    """A file and the formula in it, both known to a profile's world. InputError otherwise."""
    found = _read(path)
    point = Point(found.position, found.goal, found.errors)
    return found, known_formula(found.formula, found.team, [point], profile, path)


def known_formula(
    document: dict[str, Any], team: str, points: Sequence[Point], profile: PolicyProfile, path: Path
) -> Formula:
    """The formula of a file, if it and the world states are about what the profile's world has; else InputError."""
    try:
        claim = read_formula(document)
    except (ValueError, LookupError, TypeError, AttributeError, RecursionError) as error:
        raise InputError("the counterexample's formula cannot be read", f"{path}: {error}"[:200], ADVICE) from None
    world = profile.world
    needed = {f"{entity.name}.{axis}" for entity in world.agents + world.landmarks for axis in "xy"}
    members = {policy.agent for policy in profile.team(team)}
    positions = {name for point in points for name in point.position}
    features = {error_name(policy.agent, feature.name) for policy in profile.agents for feature in policy.features}
    strange = [
        *sorted((coordinates(claim) | positions) - set(world.coordinates())),
        *sorted(agents(claim) - members),
        *sorted({name for point in points for name in point.errors} - features),
        *sorted(f"goal {goal or 'none'}" for goal in {point.goal for point in points} - set(world.goals or ("",))),
        *sorted({f"no {name}" for point in points for name in needed - set(point.position)}),
    ]
    strange = strange or _strange_parts(claim, team, profile)
    if strange or not members:
        what = ", ".join(strange[:5]) or f"no team {team}"
        raise InputError("the counterexample is about another world", f"{path}: {what}", "give its profile")
    for name, value in (pair for point in points for pair in (*point.position.items(), *point.errors.items())):
        if abs(value) > MOST:
            raise InputError("not a counterexample", f"{path}: {name} is beyond {MOST}", ADVICE)
    return claim
