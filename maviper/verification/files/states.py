"""Where a team fails a claim, as files that extraction learns from; and where claims hold, as files.

Does: writes further states beside a counterexample; reads counterexamples and such states for the world that is
  extracted, from files or from the folder that `maviper verify -o` wrote; the files of failing cells and of the regions
  found, which are kept from being written over a region asked about.
Assumes: states are of a world of ours; claims about single decisions.
Does not: learn (extraction/refitting.py), or replay (counterexamples.py).
"""

from __future__ import annotations

import hashlib
import json
import math
import re
import shlex
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from codegen.errors import InputError, escape_text
from codegen.form import layout
from codegen.ir import GrownTree, PolicyProfile, Provenance
from codegen.policy_json import content_hash
from maviper.episodes.trees import agent_policies
from maviper.files import kinds, outputs, runs
from maviper.files.profiles import load
from maviper.verification.ask import MAX_FILE_BYTES, Asked, VerifyOptions, list_calls, usual_of
from maviper.verification.files import counterexamples
from maviper.worlds import ParticleWorld
from maviper.worlds.world import plain_name, world_name
from verify.claims.catalogue import read_call
from verify.claims.claim import check_range
from verify.claims.decisions import DecisionClaim, formula
from verify.claims.files import properties
from verify.claims.formula import Formula, Linear, atoms
from verify.claims.region import Region, goal_of, goal_text
from verify.claims.region_files import find_observed_velocities, name_region, read_region, region_toml
from verify.claims.wording import OwnFormula, formula_document
from verify.exact import read_number
from verify.kinds import MACHINE
from verify.question import AnyClaim, Question
from verify.result import AnyResult
from verify.states.shares import failures
from verify.states.state import State, violates
from verify.subjects import Game
from verify.toml_places import parse
from verify.verdicts.decisions import DecisionResult

FORM = "maviper-states-1"
MAX_STATES = 100_000  # of one file
LARGEST = 10**100  # number in a formula
PATTERNS = ("counterexample-*.json", "states-*.json")
ADVICE = "make it again with `maviper verify -o`"
ONLY_REAL = "is one of real arithmetic only: trees learn what the deployed arithmetic decides"
ADVICE_REAL = "ask `maviper verify -o` without --set semantics=real"


class StatesJson(msgspec.Struct, forbid_unknown_fields=True):
    """The members of a file of states."""

    states: str
    world: str
    profile: str  # content hash
    property: str
    team: str
    formula: dict[str, Any]
    eps: str
    region: str  # its name
    bounds: str  # the region, as a region file states it
    command: str
    coordinates: list[str]
    positions: list[list[float]]  # [n, n_coordinates]
    goals: list[str]  # [n]
    errors: list[dict[str, float]]  # [n], as in a counterexample; empty where no feature is off anywhere


@dataclass(frozen=True)
class Failing:
    """World states in which a team failed a claim; of one claim and team all that were given."""

    claim: OwnFormula  # under the name of the claim
    states: tuple[State, ...]
    profiles: tuple[str, ...]  # hashes of the policies that failed, in the order given
    folders: tuple[Path, ...]  # where files of theirs lie
    region: Region | None = None  # what the claim is about, where a file says it
    command: str = ""  # that asks about the claim, where a file says it

    @property
    def digest(self) -> str:
        """SHA-256 of what is learned from."""
        states = [[dict(state.position), goal_text(state.goal), dict(state.errors)] for state in self.states]
        content = [self.claim.team, formula_document(self.claim.statement), states]
        return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()

    def before(self) -> PolicyProfile | None:
        """The policy that failed last, where it lies beside a file; None where another one or none does."""
        for folder in reversed(self.folders):
            with suppress(InputError):
                profile = load(folder / runs.PROFILE_FILE)
                if content_hash(profile) == self.profiles[-1]:
                    return profile
        return None


def states_files(profile: PolicyProfile, asked: Sequence[Asked], results: Sequence[AnyResult]) -> dict[str, str]:
    """For each violated claim about single decisions a file of sampled states in which it fails, where any is found: in
    the deployed arithmetic, which is what extraction mends, and in the one asked about.
    """
    files: dict[str, str] = {}
    for place, (one, result) in enumerate(zip(asked, results, strict=True), 1):
        claim, region = result.claim, result.region
        failed = claim.per_state and result.evidence.failing_state is not None
        if not failed or result.viewed is not None:  # extraction learns from world states
            continue
        question = Question(Game(profile), claim, region, result.semantics)
        states = failures(question)
        if result.semantics != MACHINE:
            states = [state for state in states if violates(question, state)]
        if states:
            files[f"states-{place}-{claim.name}.json"] = document_of(profile, claim, region, states, one.command)
    return files


def document_of(
    profile: PolicyProfile, claim: DecisionClaim, region: Region, states: Sequence[State], command: str
) -> str:
    """States of a region in which a team fails a claim, as a file's text. `command`: the line that asked."""
    document = {
        "states": FORM,
        "world": world_name(profile.world),
        "profile": content_hash(profile),
        "property": claim.shown,
        "team": claim.team,
        "formula": formula_document(formula(profile, claim)),
        "eps": str(claim.eps),
        "region": region.name,
        "bounds": region_toml(region),
        "command": shlex.join(["maviper", "verify", runs.PROFILE_FILE, *shlex.split(command)[3:]]),
        "coordinates": list(states[0].position),
        "positions": [list(state.position.values()) for state in states],
        "goals": [goal_text(state.goal) for state in states],
        "errors": [dict(state.errors) for state in states] if any(state.errors for state in states) else [],
    }
    return layout(document) + "\n"


def read_failing(paths: Sequence[Path], world: ParticleWorld) -> tuple[list[Failing], list[str]]:
    """Reads what files and folders hold, one entry per claim and team, for the world that is extracted; and, in words,
    which files in folders teach no single decision.

    InputError for a file that is damaged or about another world, and where there is none.
    """
    failing: dict[tuple[str, Formula], Failing] = {}
    skipped: list[str] = []
    policies = blank(world)
    for path in paths:
        inside = path.is_dir()
        files = sorted(each for pattern in PATTERNS for each in path.glob(pattern)) if inside else [path]
        if not files:
            raise InputError("the folder holds no counterexamples", str(path), ADVICE)
        for file in files:
            if inside and kinds.kind_of(runs.read(file, counterexamples.MAX_BYTES)) is kinds.EPISODE_COUNTEREXAMPLE:
                skipped.append(f"{file.name} is about a whole episode, which does not say which decision to learn")
                continue
            new = _read(file, policies)
            if new is None and inside:
                skipped.append(f"{file.name} {ONLY_REAL}")
                continue
            if new is None:
                raise InputError(f"the counterexample {ONLY_REAL}", str(file), ADVICE_REAL)
            key = new.claim.team, new.claim.statement
            failing[key] = _join_failing(failing[key], new) if key in failing else new
    if not failing:
        what = "claims about whole episodes or in real arithmetic do not say which deployed decision is wrong"
        raise InputError(what, "; ".join(skipped), "give counterexamples of claims about single decisions")
    return list(failing.values()), skipped


def blank(world: ParticleWorld) -> PolicyProfile:
    """A profile of the world whose agents do nothing: names, features and actions for those that read claims."""
    leaf = GrownTree(*(np.array([value]) for value in (-1, 0.0, -1, -1, 0)))
    return PolicyProfile(world.spec, agent_policies(world, [leaf] * len(world.agents)), Provenance("", "", 0, "", ""))


def _read(path: Path, policies: PolicyProfile) -> Failing | None:
    """One file of either kind; None for a counterexample of real arithmetic alone."""
    data = runs.read(path, counterexamples.MAX_BYTES)
    what = "a counterexample to a claim about single decisions"
    kinds.ensure(data, str(path), what, kinds.COUNTEREXAMPLE, kinds.STATES)
    if kinds.kind_of(data) is not kinds.STATES:
        stored, state, statement = counterexamples.read_counterexample(path, policies)
        if stored.view is not None:
            raise InputError("a counterexample over observations", str(path), "extraction learns from world states")
        _ensure_floats(statement, path)
        if stored.semantics != MACHINE and (
            not state.floats or stored.deployed is None or not stored.deployed.violated
        ):
            return None
        eps = max((abs(Fraction(error)) for error in state.errors.values()), default=Fraction(0))
        label = counterexamples.name_formula(stored.property, statement, stored.team, policies)
        claim = OwnFormula(stored.team, statement=statement, eps=eps, label=label)
        return Failing(claim, (state,), (stored.profile,), (path.parent,))
    written = runs.decode_file(path, counterexamples.MAX_BYTES, StatesJson, "not a file of states", ADVICE)
    try:
        eps, words = read_number(written.eps), shlex.split(written.command)
    except ValueError as error:
        raise InputError("not a file of states", f"{path}: {escape_text(error)}", ADVICE) from None
    if written.states != FORM:
        raise InputError("a file of states of another version", f"{path}: '{escape_text(written.states[:40])}'", ADVICE)
    check_range("eps", eps)
    if words and words[:2] != ["maviper", "verify"]:
        raise InputError("not a file of states", f"{path}: its command is not `maviper verify`", ADVICE)
    ours, theirs = (plain_name(name)[0] for name in (world_name(policies.world), written.world))
    if ours != theirs:
        raise InputError("the states are of another world", f"{path}: {escape_text(theirs[:80])}, not {ours}", ADVICE)
    states = _points(written, path)
    statement = counterexamples.resolve_formula(written.formula, written.team, states, policies, path)
    _ensure_floats(statement, path)
    region = read_region(written.bounds, policies.world, f"{path}: bounds", find_observed_velocities(policies))
    label = counterexamples.name_formula(written.property, statement, written.team, policies)
    claim = OwnFormula(written.team, statement=statement, eps=eps, label=label)
    region = replace(region, name=written.region)
    region = replace(region, name=escape_text(name_region(policies, region)) or "given")
    return Failing(claim, states, (written.profile,), (path.parent,), region, written.command)


def _ensure_floats(statement: Formula, path: Path) -> None:
    """InputError for numbers that no float64 comes near."""
    parts = [part for part in atoms(statement) if isinstance(part, Linear)]
    if any(abs(number) > LARGEST for part in parts for number in (part.bound, *(weight for weight, _ in part.terms))):
        raise InputError("the formula has numbers that are too large", str(path), ADVICE)


def _points(written: StatesJson, path: Path) -> tuple[State, ...]:
    n = len(written.positions)
    errors = written.errors or [{}] * n
    if not 1 <= n <= MAX_STATES or not n == len(written.goals) == len(errors):
        what = f"{n} positions, {len(written.goals)} goals, {len(errors)} errors"
        raise InputError("not a file of states", f"{path}: {what}", ADVICE)
    if any(len(row) != len(written.coordinates) for row in written.positions):
        raise InputError("not a file of states", f"{path}: not {len(written.coordinates)} numbers in each row", ADVICE)
    if not all(math.isfinite(value) for row in written.positions for value in row):
        raise InputError("not a file of states", f"{path}: a position is not finite", ADVICE)
    return tuple(
        State(dict(zip(written.coordinates, row, strict=True)), goal_of(goal), wrong)
        for row, goal, wrong in zip(written.positions, written.goals, errors, strict=True)
    )


def _join_failing(a: Failing, b: Failing) -> Failing:
    """Both, each state once."""
    known = {(tuple(state.position.items()), state.goal, tuple(state.errors.items())) for state in a.states}
    further = [p for p in b.states if (tuple(p.position.items()), p.goal, tuple(p.errors.items())) not in known]
    claim = replace(a.claim, eps=max(a.claim.eps, b.claim.eps))
    return Failing(
        claim,
        (*a.states, *further),
        (*a.profiles, *b.profiles),
        (*a.folders, *b.folders),
        b.region or a.region,
        b.command or a.command,
    )


def repeat_command(asked: Asked, wanted: int | None) -> str:
    """The command line that repeats a question."""
    if wanted is None:
        return asked.command
    limited = "max_cells" in asked.claim.limits and wanted != usual_of(asked.question.budgets).max_cells
    return f"{asked.command} --where" + (f" --set max_cells={wanted}" if limited else "")


def repeat_options(options: VerifyOptions) -> str:
    """The command line that asks the claims of options again, run beside `profile.json`, region and property file."""
    words = ["maviper", "verify", runs.PROFILE_FILE, "--region", Path(options.region).name]
    words += [] if options.file is None else ["--claims", options.file.name]
    words += [word for call in list_calls(options) for word in ("--claim", call)]
    return shlex.join(words)


def region_file(number: int, claim: AnyClaim) -> str:
    """The name of the file of the region that is found for a claim; claims are counted from 1."""
    return f"region-{number}-{claim.name}.toml"


def zones_and_region(profile: PolicyProfile, place: int, result: DecisionResult) -> dict[str, str]:
    """`zones-N-NAME.json` of the zones known, `region-N-NAME.toml` of the region found, where there are any."""
    from verify.reports.where import zones_json  # imported here, as few ask where

    where, claim = result.evidence.where, result.claim
    if where is None:
        return {}
    files = {f"zones-{place}-{claim.name}.json": zones_json(profile, result)} if where.count else {}
    if where.part is not None:
        told = f"{outputs.FOUND} {claim.shown} of the {claim.team} holds in it; profile {content_hash(profile)}"
        files[where.part.region.name] = f"{told}\n{region_toml(where.part.region)}"
    return files


def file_names(asked: Sequence[Asked], page: bool) -> str:
    """A pattern of the names that a run on these questions may write into its folder. `page`: one that plays too."""
    claims = "|".join(rf"{number}-{re.escape(one.claim.name)}" for number, one in enumerate(asked, 1))
    names = rf"report\.(html|txt)|(certificate|counterexample|zones|states)-({claims})(-[\w-]+)?\.(json|csv)"
    return rf"{names}|play\.html" if page else names


def list_given(options: VerifyOptions) -> list[Path]:
    """The files that claims and regions are read from: the region, the property file, and the regions that it names, as
    seen from its own folder.
    """
    given = [Path(options.region)]
    if options.file is not None:
        text = runs.read(options.file, MAX_FILE_BYTES).decode()
        named = [table.get("region") for table, _ in properties(*parse(text, options.file.name, "not readable", ""))]
        given += [options.file, *(options.file.parent / each for each in named if isinstance(each, str))]
    asked = [read_call(written).get("region") for written in options.claims]
    return [*map(runs.ensure_visible, (*given, *(Path(each) for each in asked if isinstance(each, str))))]


def ensure_free(output: Path, asked: Sequence[Asked], options: VerifyOptions) -> None:
    """InputError when a region found would be written over a region asked about, or a file that is no region found."""
    regions = {path.resolve() for path in list_given(options)}
    for number, one in enumerate(asked, 1):
        path = output / region_file(number, one.claim)
        if path.resolve() in regions or (path.is_file() and not path.read_bytes().startswith(outputs.FOUND.encode())):
            raise InputError("the region found would overwrite a file", str(path), "choose another folder with -o")
