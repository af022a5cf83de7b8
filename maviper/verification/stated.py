"""Claims about a system that a file states: asked, answered, written down, checked and replayed.

Does: joins world's files, engine, checker and the reference environment.
Assumes: a checked profile.
Does not: decide verdicts, print or write files.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import Any

import msgspec

from codegen.errors import InputError, RefusedError, UnknownNameError, shown
from codegen.ir import PolicyProfile, act
from codegen.json_layout import layout
from codegen.policy_json import content_hash, dumps
from maviper.files import runs
from maviper.files.profiles import loaded
from maviper.worlds.outside.deviation import deviation
from maviper.worlds.outside.reference import Reference, is_known
from maviper.worlds.outside.systems import read
from maviper.worlds.outside.written import episodes
from verify.checker import system_certificates
from verify.checker.certificates import MAX_BYTES
from verify.checker.enclosures import ensure_enclosed
from verify.checker.reading import RejectedError
from verify.claims.formula import holds
from verify.claims.formula_json import read_number
from verify.claims.region import Verdict
from verify.reach.decide import decide
from verify.reach.replay import Course, is_start, piece_of, replayed
from verify.reach.results import Budget, Counterexample, SystemResult
from verify.reports import systems as report
from verify.systems import documents
from verify.systems.claims import SystemClaim, spelled
from verify.systems.files import MAX_BYTES as MAX_WORLD_BYTES
from verify.systems.observing import chosen, observed
from verify.systems.pieces import curved
from verify.systems.properties import claims_in, claims_of
from verify.systems.statement import Statement
from verify.systems.system import System

WORLD_FILE = "world.toml"  # beside certificates and counterexamples
PROPERTY_FILE = "properties.toml"
FORM = "maviper-system-counterexample-1"
ENCLOSED = (
    "an episode breaks the claim with the error of enclosures, and none was found that does by the rules as they are"
    " written"
)
NARROWER = ("more `cuts` where rules are not affine", "a smaller start region", "fewer steps")
ADVICE = "make it again with `maviper verify --world -o`"


@dataclass(frozen=True)
class StatedOptions:
    """What is asked of a profile in a world's file."""

    world: Path
    file: Path | None = None  # a property file; None: the properties of the world's file
    max_states: int | None = None
    run_reference: bool = False  # also where the file names code of somebody's own
    verdict_only: bool = False  # the environment is neither measured nor asked

    @property
    def command(self) -> str:
        """What asks the same again, in the folder of the report."""
        words = ["maviper", "verify", runs.PROFILE_FILE, "--world", WORLD_FILE]
        words += [] if self.file is None else ["--properties", PROPERTY_FILE]
        words += [] if self.max_states is None else ["--max-states", str(self.max_states)]
        return " ".join([*words, *(["--run-reference"] if self.run_reference else [])])


@dataclass(frozen=True)
class StatedVerified:
    """The results, and the files that belong to them, name -> text."""

    profile: PolicyProfile
    statement: Statement
    source: str  # of the world's file
    properties: str | None  # the property file's text, where one was asked
    options: StatedOptions
    results: tuple[SystemResult, ...]
    reference: Mapping[str, Any]
    replays: tuple[str, ...]  # of each result: what the environment says of its counterexample

    @cached_property
    def document(self) -> dict[str, Any]:
        """The report as plain data."""
        command = self.options.command
        return report.document(self.profile, self.statement, self.results, self.reference, self.replays, command)

    @property
    def certificates(self) -> dict[str, str]:
        """A certificate for each claim that is proved."""
        return {
            report.certificate_name(place, result.claim): system_certificates.to_json(result.certificate)
            for place, result in enumerate(self.results, 1)
            if result.certificate is not None
        }

    @property
    def counterexamples(self) -> dict[str, str]:
        """A counterexample for each claim that is violated."""
        return {
            report.counterexample_name(place, result.claim): self._counterexample(result, result.counterexample)
            for place, result in enumerate(self.results, 1)
            if result.counterexample is not None
        }

    def _counterexample(self, result: SystemResult, found: Counterexample) -> str:
        told = report.counterexample(found)
        body = {
            "counterexample": FORM,
            "profile": content_hash(self.profile),
            "system": documents.content_hash(self.statement.system),
            "claim": system_certificates.claim_document(result.claim),
            **{key: told[key] for key in ("step", "start", "errors", "pieces", "actions")},
        }
        return layout(body) + "\n"

    @property
    def files(self) -> dict[str, str]:
        """All of them, with the profile, the world's file and the property file."""
        told = self.document
        reports = {
            "report.json": report.as_json(told),
            "report.txt": report.as_text(told),
            "report.html": report.as_html(told),
        }
        stated = {WORLD_FILE: self.source} | ({} if self.properties is None else {PROPERTY_FILE: self.properties})
        return reports | self.certificates | self.counterexamples | {runs.PROFILE_FILE: dumps(self.profile)} | stated


def verified(profile: PolicyProfile, options: StatedOptions) -> StatedVerified:
    """The verdicts on all claims. InputError for files that cannot be used, for a profile that is none of this world's,
    and for a statement that is further from its reference than it says.
    """
    source = _source(options.world)
    statement = read(options.world)
    ensure_plays(profile, statement)
    properties = None if options.file is None else _source(options.file)
    if options.file is None or properties is None:
        claims = claims_of(statement, profile, options.world.name)
    else:
        claims = claims_in(properties, statement, profile, options.file.name)
    reference = {} if options.verdict_only else _measured(statement, options.run_reference)
    decided = decide(profile, statement.system, claims, Budget.of(options.max_states))
    results = tuple(as_written(statement, profile, each) for each in decided)
    if any(result.certificate is not None for result in results):
        _ensure_enclosed(statement)
    playable = bool(reference.get("steps"))
    replays = tuple(_replay_words(statement, profile, result) if playable else "" for result in results)
    return StatedVerified(profile, statement, source, properties, options, results, reference, replays)


def _source(path: Path) -> str:
    return runs.read(path, MAX_WORLD_BYTES).decode(errors="replace")


def ensure_plays(profile: PolicyProfile, statement: Statement) -> None:
    """InputError for agents, features or actions that the file does not state."""
    actions = {agent.name: tuple(agent.actions) for agent in statement.agents}
    for policy in profile.agents:
        where = f"{statement.system.name}: {policy.agent}"
        if policy.agent not in actions:
            raise UnknownNameError("agent", policy.agent, actions, statement.system.name)
        for kind, names, known in (
            ("feature", [each.name for each in policy.features], statement.system.features[policy.agent]),
            ("action", [each.name for each in policy.actions], actions[policy.agent]),
        ):
            for name in names:
                if name not in known:
                    raise UnknownNameError(kind, name, known, where)
    missing = sorted(actions.keys() - {policy.agent for policy in profile.agents})
    if missing:
        raise InputError(f"the profile has no {', '.join(missing)}", statement.system.name, "name the file it plays in")


# --- rules that are not affine


def _ensure_enclosed(statement: Statement) -> None:
    """InputError where the checker does not show again that pieces hold what the rules say: then nothing is proved."""
    try:
        ensure_enclosed(statement)
    except RejectedError as error:
        advice = "cut the ranges of more variables, or into more parts"
        raise InputError("an enclosure was not shown again", f"{statement.system.name}: {error}", advice) from None


def as_written(statement: Statement, profile: PolicyProfile, result: SystemResult) -> SystemResult:
    """The result, unless only the error of enclosures breaks the claim: then nothing is known of the rules themselves.

    Where rules are not affine, an episode by them as they are written, with errors that the file states, must break the
    claim too.
    """
    found, claim, system = result.counterexample, result.claim, statement.system
    if found is None or claim.about_decisions or not any(map(curved, statement.rules)):
        return result
    for states in episodes(statement, profile, claim.steps, found.states):
        if _breaks(claim, states):
            again = replayed(profile, system, claim, _course(system, profile, states))
            if again is not None:
                return replace(result, counterexample=again)
    return replace(result, verdict=Verdict.UNKNOWN, reason=ENCLOSED, helps=NARROWER, counterexample=None)


def _breaks(claim: SystemClaim, states: Sequence[Mapping[str, Fraction]]) -> bool:
    for step, state in enumerate(states):
        if holds(claim.broken(step), state, {}):
            return True
        if holds(claim.fulfilled(step), state, {}):
            return False
    return False


def _course(system: System, profile: PolicyProfile, states: Sequence[Mapping[str, Fraction]]) -> Course:
    """How an episode of the pieces goes through given states, as far as their errors allow."""
    errors: list[Mapping[str, Fraction]] = []
    for state, after in pairwise(states):
        number = piece_of(system, state)
        if number is None:
            break
        piece, actions = system.pieces[number], chosen(system, profile, state)
        joint = {policy.agent: policy.actions[actions[policy.agent]].name for policy in profile.agents}
        exact = piece.step(state, joint, {})
        errors.append({name: after[name] - exact[name] for name in piece.error})
    return Course(states[0], errors)


# --- the environment that a statement is about


def _measured(statement: Statement, run: bool) -> dict[str, Any]:
    """How far the statement is from its reference, over 100,000 steps. InputError where it is farther than it says."""
    name = statement.system.reference
    if not name or not statement.rules:
        return {}
    if not (run or is_known(name)):
        said = f"{name} is code that the file names; it was not run, so nothing was measured (--run-reference runs it)"
        return {"name": name, "said": [said]}
    found = deviation(statement)
    if found.beyond:
        what = f"the statement is not that of {name}: {found.beyond} of {found.steps} steps are beyond its error"
        raise InputError(what, found.worst, "widen the error of the variable, narrow its range, or mend the rule")
    off = {variable: list(bounds) for variable, bounds in found.off.items()}
    reach = ", ".join(f"{variable} {report.upwards(max(map(abs, bounds)), 2)}" for variable, bounds in off.items())
    said = f"{name}: {found.steps} steps were measured, off by at most {reach}"
    return {"name": name, "steps": found.steps, "anywhere": found.placed, "off": off, "said": [said]}


def _replay_words(statement: Statement, profile: PolicyProfile, result: SystemResult) -> str:
    """What the environment says of a counterexample."""
    if result.counterexample is None or result.claim.about_decisions:
        return ""
    name = statement.system.reference
    broken = broken_in_reference(statement, profile, result.claim, result.counterexample.start_as_doubles)
    if broken is None:
        return f"{name} cannot be put into this start, so this is a counterexample of the statement only"
    if broken:
        return f"{name} breaks the claim from there too"
    return f"{name} does not break the claim from there: this is a counterexample of the statement only"


def broken_in_reference(
    statement: Statement, profile: PolicyProfile, claim: SystemClaim, start: Mapping[str, float]
) -> bool | None:
    """Whether an episode of the reference from a start breaks a claim; None where it cannot be put there."""
    reference = Reference(statement)
    reference.reset(0)
    if not reference.placeable or not reference.place(dict(start)):
        return None
    for step in range(claim.steps + 1):
        state = {name: Fraction(number) for name, number in reference.state().items()}
        if holds(claim.broken(step), state, {}):
            return True
        if step == claim.steps or holds(claim.fulfilled(step), state, {}) or not reference.playing:
            return False
        seen = {policy.agent: observed(statement.system, policy, state) for policy in profile.agents}
        reference.step(
            {policy.agent: policy.actions[int(act(policy, seen[policy.agent])[0])].name for policy in profile.agents}
        )
    return False


# --- files that anyone wrote


class CounterexampleJson(msgspec.Struct, forbid_unknown_fields=True):
    """The members of the file; numbers are exact texts."""

    counterexample: str
    profile: str
    system: str
    claim: dict[str, Any]
    step: int
    start: dict[str, str]
    errors: list[dict[str, str]]
    pieces: list[int]
    actions: dict[str, list[str]]


def checked(path: Path, profile: PolicyProfile | Path | None, world: Path | None) -> tuple[str, int, int]:
    """What the certificate in a file proves, in words, its branches, and its bytes. RefusedError when it does not hold.

    The pieces of the system are shown again from the rules of the file, then the proof is followed.
    """
    text = runs.read(path, MAX_BYTES)
    statement = read(world or path.parent / WORLD_FILE)
    try:
        found, about = system_certificates.from_json(text, str(path)), loaded(profile, beside=path)
        ensure_plays(about, statement)
        ensure_enclosed(statement)
        closed = system_certificates.accepted(found, about, statement.system)
    except RejectedError as error:
        advice = "do not rely on it; run `maviper verify` again"
        raise RefusedError("the certificate is refused", f"{path}: {shown(error)}", advice) from None
    actions = {policy.agent: [action.name for action in policy.actions] for policy in about.agents}
    said = f"{spelled(found.claim, actions)}, {report.sentence(statement.system)}"
    return f"{called(found.claim)}: {said}", closed, found.size


def called(claim: SystemClaim) -> str:
    """What a claim in a file is called: its kind, and its label as the file's word."""
    return claim.kind.value + (f" (in the file: '{shown(claim.label)}')" if claim.label else "")


def replay(path: Path, profile: PolicyProfile, world: Path | None) -> tuple[CounterexampleJson, SystemClaim, Any, bool]:
    """A counterexample of a file, the claim in it, the episode that breaks it again (None where none does), and whether
    the system is the one that it was made of.
    """
    found = runs.decoded(path, MAX_BYTES, CounterexampleJson, "not a readable counterexample", ADVICE)
    statement = read(world or path.parent / WORLD_FILE)
    ensure_plays(profile, statement)
    try:
        claim = system_certificates.read_claim(found.claim)
        start = {name: read_number(value) for name, value in found.start.items()}
        errors = [{name: read_number(value) for name, value in each.items()} for each in found.errors]
        if set(start) != {each.name for each in statement.system.variables}:
            raise ValueError("its start names other variables than the world's file")
        claim.ensure()
        if not is_start(statement.system, claim, start):
            where = f"{path}: $.start: {statement.system.name}"
            raise InputError("the counterexample does not start where the world's file has starts", where, ADVICE)
        again = replayed(profile, statement.system, claim, Course(start, errors, found.pieces))
    except (ValueError, LookupError, TypeError, ZeroDivisionError) as error:
        raise InputError("not a readable counterexample", f"{path}: {shown(error)}", ADVICE) from None
    return found, claim, again, found.system == documents.content_hash(statement.system)
