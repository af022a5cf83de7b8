"""Counterexamples as files, and their replay.

Does: writes a counterexample with its claim, of whole episodes the start and the actions; replays one by reference,
  compiled C and environment, and judges one of real arithmetic by exact measurements.
Assumes: results of `verify.verdicts`; a profile of the same world, the same policy or a better one.
Does not: look for counterexamples.
"""

from __future__ import annotations

import builtins
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec

from codegen.deciding import ensure_plain, name_with_updates
from codegen.errors import InputError, UnknownNameError, escape_text
from codegen.ir import PolicyProfile, WorldSpec
from codegen.policy_json import content_hash
from codegen.rows import Shown
from maviper.files import kinds, runs
from maviper.files.profiles import READER
from maviper.verification.bench import replay_course, replay_state
from verify.claims.catalogue import ZONES, find_episode_claim, readable
from verify.claims.claim import Parameter
from verify.claims.decisions import OWN, PLAIN, formula
from verify.claims.episodes import EPISODE_CLAIMS, EpisodeClaim
from verify.claims.formula import Acts, Formula, Goal, agents, atoms, coordinates, read_formula
from verify.claims.observed import over, view_from
from verify.claims.region import goal_of, goal_text
from verify.claims.region_files import positions
from verify.claims.wording import BUILT_IN, formula_document, region_document, view_document
from verify.counterexamples.search import Counterexample
from verify.exact import MAX_NUMBER, read_number
from verify.kinds import MACHINE, REAL
from verify.reports.courses import counterexample
from verify.reports.decisions import deployed_facts
from verify.states.episodes import Episode, fails, playable
from verify.states.real import Value, value_of, write_values
from verify.states.state import REFERENCE, State, error_name, true_at
from verify.verdicts.decisions import DecisionResult

if TYPE_CHECKING:
    from verify.verdicts.episodes import EpisodeResult

EPISODE_FORM = "maviper-episode-counterexample-1"
FORM, REAL_FORM = "maviper-counterexample-1", "maviper-counterexample-2"  # of deployed, of real arithmetic
FORMS = (FORM, REAL_FORM)
MAX_BYTES = 1 << 24
PLAYED = "played in exact numbers, by the dynamics and the errors that are stated"
FOLLOWED = "followed in enclosures of the flow that is stated, which leave no doubt"
OTHER_SYSTEM = "; the world file is not the one that the counterexample was made from"
ADVICE = "make it again with `maviper verify -o`"


class DeployedJson(msgspec.Struct, forbid_unknown_fields=True):
    """The deployed arithmetic's actions and verdict in the state of a counterexample in real arithmetic."""

    actions: dict[str, str]
    violated: bool


class CounterexampleJson(msgspec.Struct, forbid_unknown_fields=True):
    """The members of the file. Texts are fractions that are no float64 numbers, in real arithmetic only."""

    counterexample: str
    profile: str  # content hash
    property: str
    team: str
    formula: dict[str, Any]
    goal: str
    position: dict[str, float | str]  # every coordinate that the region bounds
    errors: dict[str, float | str]  # of features, as `verify.states.state.error_name` names them
    actions: dict[str, str]  # agent -> what it did
    explanation: dict[str, Any] = {}  # as in the report; replays do not read it
    semantics: str = MACHINE
    deployed: DeployedJson | None = None  # of real arithmetic; None where the state is no float64 state
    view: dict[str, list[str]] | None = None  # of claims over observations: how these are put together


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


@dataclass(frozen=True, repr=False)
class Replayed(Shown):
    """Says what the team does in the world state, and whether the claim fails there; of an episode, what all agents do,
    step by step, and whether the claim fails in it.

        maviper.replay("found/counterexample-1-distinct_targets.json", team).actions
    """

    property: str  #: the name of the built-in claim where the formula is sure to be that one
    violated: bool
    actions: Mapping[str, str]  #: of an episode: in order, with spaces between
    before: Mapping[str, str]  #: what the file says that it did
    by: tuple[str, ...]  #: what replays gave the same actions
    same_policy: bool
    says: str  #: what judged the actions and who replayed them, in words

    @builtins.property  # `property` is a field
    def rows(self) -> list[dict[str, Any]]:
        """A row for each agent: what it does, and what the file says that it did."""
        acts = self.actions.items()
        return [{"agent": agent, "does": does, "did": self.before.get(agent)} for agent, does in acts]


def document(profile: PolicyProfile, result: DecisionResult, example: Counterexample) -> dict[str, Any]:
    """Returns the contents of the file of a violated claim about single decisions."""
    claim, explanation = result.claim, result.evidence.explanation
    real = {} if result.semantics == MACHINE else {"semantics": result.semantics, "deployed": deployed_facts(example)}
    view = {} if result.viewed is None else {"view": view_document(result.viewed.view)}
    return {
        "counterexample": REAL_FORM if real else FORM,
        "profile": content_hash(profile),
        "property": claim.shown,
        "team": claim.team,
        **view,
        "formula": formula_document(formula(result.question.profile, claim)),
        "goal": goal_text(example.state.goal),
        "position": write_values(example.state.position),
        "errors": write_values(example.state.errors),
        "actions": {view.agent: view.action for view in example.agents},
        **real,
        "explanation": {} if explanation is None else explanation.document(),
    }


def episode_document(profile: PolicyProfile, result: EpisodeResult) -> dict[str, Any]:
    """Returns the contents of the file of a violated claim."""
    claim, evidence = result.claim, result.evidence
    assert evidence.state is not None and evidence.episode is not None
    broken = {**claim.parameters, "steps": claim.steps}  # of a claim for ever, as many steps as it takes
    return {
        "counterexample": EPISODE_FORM,
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


def ensure_counterexample(path: Path) -> None:
    """InputError for a file that is known to be something else, or nothing."""
    any_ = (kinds.COUNTEREXAMPLE, kinds.EPISODE_COUNTEREXAMPLE, kinds.SYSTEM_COUNTEREXAMPLE)
    kinds.ensure(runs.read(path, MAX_BYTES), str(path), kinds.COUNTEREXAMPLE.called, *any_)
    runs.decode_file(path, MAX_BYTES, dict[str, Any], "not a counterexample", ADVICE)


def replay(path: Path, profile: PolicyProfile, world: Path | None = None) -> Replayed:
    """The counterexample of a file, replayed with a profile: the one that it is about, or another of its world.

    `world`: the world file of one in a stated system (None: world.toml beside it).

    InputError when the file is damaged or speaks of what the profile does not have; DisagreementError when compiled C
    or environment act differently from the reference.
    """
    data = runs.read(path, MAX_BYTES)
    if kinds.kind_of(data) is kinds.SYSTEM_COUNTEREXAMPLE:
        from maviper.verification.files import systems

        original, claim, again, same, by_same = systems.replay(path, profile, world)
        actions: dict[str, list[str]] = {} if again is None else counterexample(again)["actions"]
        words = {each.agent: {one.name: name_with_updates(one) for one in each.actions} for each in profile.agents}

        def tell(taken: Mapping[str, Sequence[str]]) -> dict[str, str]:
            return {
                agent: " ".join(words.get(agent, {}).get(name, name) for name in row) for agent, row in taken.items()
            }

        return Replayed(
            property=systems.name_claim(claim),
            violated=again is not None,
            actions=tell(actions),
            before=tell(original.actions),
            by=(),
            same_policy=by_same,
            says=(PLAYED if again is None or again.seconds is None else FOLLOWED) + ("" if same else OTHER_SYSTEM),
        )
    ensure_plain(profile, READER)
    called = kinds.COUNTEREXAMPLE.called
    kinds.ensure(data, str(path), called, kinds.COUNTEREXAMPLE, kinds.EPISODE_COUNTEREXAMPLE)
    about_episode = kinds.kind_of(data) is kinds.EPISODE_COUNTEREXAMPLE
    played = (_replay_episode if about_episode else _replay_state)(path, profile)
    wrong = [agent for agent, action in played.actions.items() if played.before.get(agent, action) != action]
    if played.same_policy and wrong:
        where = f"{path}: $.actions.{wrong[0]}: the policy takes {played.actions[wrong[0]][:40]}"
        raise InputError("the counterexample was edited after it was written", where, ADVICE)
    return played


def _replay_state(path: Path, profile: PolicyProfile) -> Replayed:
    document, state, claim = read_counterexample(path, profile)
    origin, view = profile, None if document.view is None else view_from(document.view)
    profile = origin if view is None else over(origin, view)
    strange = sorted(set(document.actions) - {policy.agent for policy in profile.team(document.team)})
    if strange:
        what = "the counterexample is about another world"
        raise InputError(what, f"{path}: {', '.join(map(escape_text, strange[:5]))}", ADVICE)
    did = replay_state(origin, view, claim, document.team, state, document.semantics)
    return Replayed(
        property=name_formula(document.property, claim, document.team, profile),
        violated=not true_at(profile, claim, state, did.actions),
        actions={
            policy.agent: policy.actions[did.actions[policy.agent]].name for policy in profile.team(document.team)
        },
        before=document.actions,
        by=did.by,
        same_policy=content_hash(origin) == document.profile,
        says=did.says,
    )


def _replay_episode(path: Path, profile: PolicyProfile) -> Replayed:
    """The episode of a file. DisagreementError when compiled C or environment take another course."""
    stored = runs.decode_file(path, MAX_BYTES, EpisodeJson, "not a counterexample", ADVICE)
    _ensure_version(stored.counterexample, (EPISODE_FORM,), path)
    claim = _read_claim(stored, profile, path)
    strange = sorted(set(stored.actions) - {entity.name for entity in profile.world.agents})
    start = State(stored.position, goal_of(stored.goal))
    _ensure_of_world(profile.world, [start], strange, path)
    for name, value in stored.position.items():
        if value and name.endswith((".vx", ".vy")):
            raise InputError("not a counterexample", f"{path}: {name} is not 0, but episodes start at rest", ADVICE)
    playable(profile)
    episode, by = replay_course(profile, start, claim.steps)
    return Replayed(
        property=_words(stored.claim, stored.property),
        violated=fails(profile, claim, episode.coordinates),
        actions=_name_actions(profile, episode),
        before=stored.actions,
        by=(REFERENCE, *by),
        same_policy=content_hash(profile) == stored.profile,
        says=f"replayed by {', '.join((REFERENCE, *by))}",
    )


def _ensure_version(form: str, known: Sequence[str], path: Path) -> None:
    if form not in known:
        raise InputError("a counterexample of another version", f"{path}: '{escape_text(form[:40])}'", ADVICE)


def _read_claim(stored: EpisodeJson, profile: PolicyProfile, path: Path) -> EpisodeClaim:
    """The claim of the file; InputError for a name or a parameter that there is not, or out of its range."""
    if stored.claim not in EPISODE_CLAIMS:
        raise UnknownNameError("claim", stored.claim, EPISODE_CLAIMS, str(path))
    read = readable(stored.claim)
    for name in stored.parameters:
        if name not in read:
            raise UnknownNameError("parameter", name, read, str(path))
    try:
        given = {name: _read_parameter(name, value) for name, value in stored.parameters.items() if name != ZONES}
        claim = find_episode_claim(stored.claim, profile, stored.team, **given)
    except InputError as error:
        error.where = f"{path}: {error.where}" if error.where else str(path)
        raise
    except ValueError as error:
        raise InputError("not a counterexample", f"{path}: {escape_text(error)}"[:200], ADVICE) from None
    return claim


def _read_parameter(name: str, value: int | str | list[str]) -> Any:
    """A parameter as claims take it. ValueError for one of another kind."""
    kind = {"steps": int, "radius": Fraction}.get(name, tuple)
    if kind is tuple and isinstance(value, list):
        return tuple(value)
    if kind is int and isinstance(value, int):
        return value
    if kind is Fraction and isinstance(value, str):
        return read_number(value)
    raise ValueError(f"{name} is {str(value)[:40]!r}")


def name_formula(stated: str, claim: Formula, team: str, profile: PolicyProfile) -> str:
    """Names the formula of a file: a property's name where it is what that says, for any other what the file calls it,
    as the file's word.
    """
    if stated in PLAIN:
        with suppress(InputError, ValueError):  # a property of other teams
            if formula(profile, BUILT_IN[stated](team)) == claim:
                return stated
    return _words(OWN, stated)


def _words(name: str, stated: str) -> str:
    return name if stated == name else f"{name} (in the file: '{escape_text(stated)}')"


def _strange_parts(claim: Formula, team: str, profile: PolicyProfile) -> list[str]:
    """Goals and actions of a formula that the profile does not have; its agents are known."""
    actions, parts = {policy.agent: policy.actions for policy in profile.team(team)}, list(atoms(claim))
    acts = sorted({(atom.agent, atom.action) for atom in parts if isinstance(atom, Acts)})
    return [
        *sorted({atom.landmark for atom in parts if isinstance(atom, Goal)} - set(profile.world.goals)),
        *(f"action {number} of {agent}" for agent, number in acts if not 0 <= number < len(actions[agent])),
    ]


def _value(stated: float | str) -> Value:
    if not isinstance(stated, str):
        return stated
    number = read_number(stated)
    if abs(number) > MAX_NUMBER:
        raise ValueError(f"a number beyond {MAX_NUMBER}")
    return value_of(number)


def read_counterexample(path: Path, profile: PolicyProfile) -> tuple[CounterexampleJson, State, Formula]:
    """A file, the state and the formula in it, both known to a profile's world or its view. InputError otherwise."""
    stored = runs.decode_file(path, MAX_BYTES, CounterexampleJson, "not a counterexample", ADVICE)
    _ensure_version(stored.counterexample, FORMS, path)
    try:
        position, errors = (
            {name: _value(value) for name, value in values.items()} for values in (stored.position, stored.errors)
        )
        _ = stored.view and view_from(stored.view)
    except ValueError as error:
        raise InputError("not a counterexample", f"{path}: {escape_text(error)}", ADVICE) from None
    state = State(position, goal_of(stored.goal), errors)
    semantics = MACHINE if stored.counterexample == FORM else REAL
    if stored.semantics != semantics or (semantics == MACHINE and (stored.deployed or not state.floats)):
        what = f"'{escape_text(stored.semantics[:20])}' where {stored.counterexample} is of {semantics} arithmetic"
        raise InputError("not a counterexample", f"{path}: {what}", ADVICE)
    if stored.view is not None:
        profile = over(profile, view_from(stored.view))
    return stored, state, resolve_formula(stored.formula, stored.team, [state], profile, path)


def resolve_formula(
    document: dict[str, Any], team: str, states: Sequence[State], profile: PolicyProfile, path: Path
) -> Formula:
    """The formula of a file, if it and the world states are about what the profile's world has; else InputError."""
    try:
        claim = read_formula(document)
    except (ValueError, LookupError, TypeError, AttributeError, RecursionError) as error:
        what = "the counterexample's formula cannot be read"
        raise InputError(what, f"{path}: {escape_text(error)}"[:200], ADVICE) from None
    members = {policy.agent for policy in profile.team(team)}
    features = {error_name(policy.agent, feature.name) for policy in profile.agents for feature in policy.features}
    strange = [
        *([] if members else [f"no team {team}"]),
        *sorted(coordinates(claim) - set(profile.world.coordinates())),
        *sorted(agents(claim) - members),
        *sorted({name for state in states for name in state.errors} - features),
    ]
    _ensure_of_world(profile.world, states, strange or _strange_parts(claim, team, profile), path)
    return claim


def _ensure_of_world(world: WorldSpec, states: Sequence[State], strange: Sequence[str], path: Path) -> None:
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
