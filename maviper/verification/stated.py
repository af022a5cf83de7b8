"""Claims about a system that a file states: asked, answered and written down.

Does: joins world files, engine, checker and the reference environment.
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

from codegen.errors import InputError
from codegen.ir import PolicyProfile
from codegen.policy_json import dumps
from maviper.files import runs
from maviper.verification.files.systems import WORLD_FILE, counterexample_file, ensure_plays
from maviper.verification.reference import measured, replay_words
from maviper.worlds.stated.systems import read
from maviper.worlds.stated.written import episodes
from verify.certificates.systems import to_json
from verify.checker.reading import RejectedError
from verify.checker.systems.enclosures import ensure_enclosed
from verify.claims.formula import holds
from verify.progress import tell
from verify.reach.decide import decide
from verify.reach.replay import Course, piece_of, replayed
from verify.reach.results import Budget, SystemResult
from verify.reports import systems as report
from verify.result import Verdict
from verify.systems.claims import SystemClaim
from verify.systems.files import MAX_BYTES as MAX_WORLD_BYTES
from verify.systems.observing import chosen
from verify.systems.pieces import curved
from verify.systems.properties import claims_in, claims_of
from verify.systems.statement import Statement
from verify.systems.system import System

PROPERTY_FILE = "properties.toml"
ENCLOSED = "the claim fails within the enclosure error, but no violating episode of the exact rules was found"
NARROWER = ("more `cuts` where rules are not affine", "a smaller start region", "fewer steps")


@dataclass(frozen=True)
class StatedOptions:
    """What is asked of a profile in a world file."""

    world: Path
    file: Path | None = None  # a property file; None: the properties of the world file
    max_states: int | None = None
    max_programs: int | None = None
    run_reference: bool = False  # also run user code that the file names
    verdict_only: bool = False  # the environment is neither measured nor asked

    @property
    def command(self) -> str:
        """What asks the same again, in the folder of the report."""
        words = ["maviper", "verify", runs.PROFILE_FILE, "--world", WORLD_FILE]
        words += [] if self.file is None else ["--properties", PROPERTY_FILE]
        words += [] if self.max_states is None else ["--max-states", str(self.max_states)]
        words += [] if self.max_programs is None else ["--max-programs", str(self.max_programs)]
        return " ".join([*words, *(["--run-reference"] if self.run_reference else [])])


@dataclass(frozen=True)
class StatedVerified:
    """The results, and the files that belong to them, name -> text."""

    profile: PolicyProfile
    statement: Statement
    source: str  # of the world file
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
            report.certificate_name(place, result.claim): to_json(result.certificate)
            for place, result in enumerate(self.results, 1)
            if result.certificate is not None
        }

    @property
    def counterexamples(self) -> dict[str, str]:
        """A counterexample for each claim that is violated."""
        return {
            report.counterexample_name(place, result.claim): counterexample_file(
                self.profile, self.statement.system, result.claim, result.counterexample
            )
            for place, result in enumerate(self.results, 1)
            if result.counterexample is not None
        }

    @property
    def files(self) -> dict[str, str]:
        """All of them, with the profile, the world file and the property file."""
        told = self.document
        reports = {
            "report.json": report.as_json(told),
            "report.txt": report.as_text(told),
            "report.html": report.as_html(told),
        }
        stated = {WORLD_FILE: self.source} | ({} if self.properties is None else {PROPERTY_FILE: self.properties})
        return reports | self.certificates | self.counterexamples | {runs.PROFILE_FILE: dumps(self.profile)} | stated


def verified(profile: PolicyProfile, options: StatedOptions) -> StatedVerified:
    """The verdicts on all claims. InputError for files that cannot be used, for a profile made for another world,
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
    reference = {} if options.verdict_only else measured(statement, options.run_reference)
    decided = decide(profile, statement.system, claims, Budget.of(options.max_states, options.max_programs))
    results = tuple(as_written(statement, profile, each) for each in decided)
    if any(result.certificate is not None for result in results):
        _ensure_enclosed(statement)
    playable = bool(reference.get("steps"))
    replays = tuple(replay_words(statement, profile, result) if playable else "" for result in results)
    return StatedVerified(profile, statement, source, properties, options, results, reference, replays)


def _source(path: Path) -> str:
    return runs.read(path, MAX_WORLD_BYTES).decode(errors="replace")


def _ensure_enclosed(statement: Statement) -> None:
    """InputError where the checker does not show again that pieces hold what the rules say: then nothing is proved."""
    try:
        ensure_enclosed(statement, _tell_shown)
    except RejectedError as error:
        advice = "cut the ranges of more variables, or into more parts"
        raise InputError("an enclosure was not shown again", f"{statement.system.name}: {error}", advice) from None


def _tell_shown(done: int, most: int) -> None:
    tell(done, most, "pieces shown again by the checker")


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
