"""World states in which a team fails a claim, as files that extraction learns from.

Does: writes further states beside a counterexample; reads counterexamples and such states for the world that is
  extracted, from files or from the folder that `maviper verify -o` wrote.
Assumes: a world of ours; claims about single decisions.
Does not: learn (refitting.py), or replay (replaying.py).
"""

import hashlib
import json
import math
import shlex
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from codegen.errors import InputError
from codegen.ir import GrownTree, PolicyProfile, Provenance
from codegen.policy_json import content_hash, layout
from maviper import load, replaying, runs
from maviper.experts.finding import plain_name
from maviper.extract.outcome import agent_policies
from maviper.questions import Asked
from maviper.worlds import ParticleWorld
from maviper.worlds.world import world_name
from verify.closed_loop import LoopResult
from verify.engine import Result
from verify.failures import failures
from verify.formula import Formula, Linear, atoms
from verify.formula_json import formula_document, read_number
from verify.properties import OWN, Property, check_range, formula
from verify.spec import Region, read_region
from verify.world import Point, observed_velocities

FORM = "maviper-states-1"
MOST_STATES = 100_000  # of one file
LARGEST = 10**100  # number in a formula
PATTERNS = ("counterexample-*.json", "states-*.json")
ADVICE = "make it again with `maviper verify -o`"


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


class _HeadJson(msgspec.Struct):
    """What tells one kind of file from another."""

    states: Any = None
    counterexample: Any = None


@dataclass(frozen=True)
class Failing:
    """World states in which a team failed a claim; of one claim and team all that were given."""

    claim: Property  # as a formula of a user's, under its own name
    points: tuple[Point, ...]
    profiles: tuple[str, ...]  # hashes of the policies that failed, in the order given
    folders: tuple[Path, ...]  # where files of theirs lie
    region: Region | None = None  # what the claim is about, where a file says it
    command: str = ""  # that asks about the claim, where a file says it

    @property
    def digest(self) -> str:
        """SHA-256 of what is learned from."""
        assert self.claim.statement is not None
        states = [[dict(point.position), point.goal, dict(point.errors)] for point in self.points]
        content = [self.claim.team, formula_document(self.claim.statement), states]
        return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()

    def before(self) -> PolicyProfile | None:
        """The policy that failed last, where it lies beside a file; None where another one or none does."""
        for folder in reversed(self.folders):
            with suppress(InputError):
                found = load(folder / runs.PROFILE_FILE)
                if content_hash(found) == self.profiles[-1]:
                    return found
        return None


def states_files(
    profile: PolicyProfile, asked: Sequence[Asked], results: Sequence[Result | LoopResult]
) -> dict[str, str]:
    """For each violated claim about single decisions a file of sampled states in which it fails, where any is found."""
    files: dict[str, str] = {}
    for place, (one, result) in enumerate(zip(asked, results, strict=True), 1):
        if not isinstance(result, Result) or result.counterexample is None:
            continue
        claim, region = result.claim, result.region
        points = failures(profile, claim, region)
        if points:
            files[f"states-{place}-{claim.name}.json"] = document_of(profile, claim, region, points, one.command)
    return files


def document_of(profile: PolicyProfile, claim: Property, region: Region, points: Sequence[Point], command: str) -> str:
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
        "bounds": region.toml(),
        "command": shlex.join(["maviper", "verify", runs.PROFILE_FILE, *shlex.split(command)[3:]]),
        "coordinates": list(points[0].position),
        "positions": [list(point.position.values()) for point in points],
        "goals": [point.goal for point in points],
        "errors": [dict(point.errors) for point in points] if any(point.errors for point in points) else [],
    }
    return layout(document) + "\n"


def read_failing(paths: Sequence[Path], world: ParticleWorld) -> tuple[list[Failing], list[str]]:
    """What files and folders hold, one entry a claim and team, for the world that is extracted; and the names of files
    in folders that are about whole episodes, which teach no single decision.

    InputError for a file that is damaged or about another world, and where there is none.
    """
    found: dict[tuple[str, Formula], Failing] = {}
    skipped: list[str] = []
    policies = blank(world)
    for path in paths:
        inside = path.is_dir()
        files = sorted(each for pattern in PATTERNS for each in path.glob(pattern)) if inside else [path]
        if not files:
            raise InputError("the folder holds no counterexamples", str(path), ADVICE)
        for file in files:
            if inside and _of_episodes(file):
                skipped.append(file.name)
                continue
            new = _read(file, policies)
            assert new.claim.statement is not None
            key = new.claim.team, new.claim.statement
            found[key] = _joined(found[key], new) if key in found else new
    if not found:
        what = "claims about whole episodes do not say which decision is wrong"
        raise InputError(what, ", ".join(map(str, paths)), "give counterexamples of claims about single decisions")
    return list(found.values()), skipped


def blank(world: ParticleWorld) -> PolicyProfile:
    """A profile of the world whose agents do nothing: names, features and actions for those that read claims."""
    leaf = GrownTree(*(np.array([value]) for value in (-1, 0.0, -1, -1, 0)))
    return PolicyProfile(world.spec, agent_policies(world, [leaf] * len(world.agents)), Provenance("", "", 0, "", ""))


def _of_episodes(path: Path) -> bool:
    head = _head(path)
    return head.states is None and head.counterexample not in (None, replaying.FORM)


def _head(path: Path) -> _HeadJson:
    return runs.decoded(path, replaying.MAX_BYTES, _HeadJson, "not a counterexample", ADVICE)


def _read(path: Path, policies: PolicyProfile) -> Failing:
    """One file of either kind."""
    head = _head(path)
    if head.states is None:
        if head.counterexample not in (None, replaying.FORM):
            what = "not a counterexample to a claim about single decisions"
            raise InputError(what, f"{path}: {str(head.counterexample)[:40]}", ADVICE)
        found, statement = replaying.read_counterexample(path, policies)
        _ensure_floats(statement, path)
        point = Point(found.position, found.goal, found.errors)
        eps = max((abs(Fraction(error)) for error in found.errors.values()), default=Fraction(0))
        claim = Property(OWN, found.team, statement=statement, eps=eps, label=found.property)
        return Failing(claim, (point,), (found.profile,), (path.parent,))
    states = runs.decoded(path, replaying.MAX_BYTES, StatesJson, "not a file of states", ADVICE)
    try:
        eps, words = read_number(states.eps), shlex.split(states.command)
    except ValueError as error:
        raise InputError("not a file of states", f"{path}: {error}", ADVICE) from None
    if states.states != FORM:
        raise InputError("a file of states of another version", f"{path}: {states.states[:40]!r}", ADVICE)
    check_range("eps", eps)
    if words and words[:2] != ["maviper", "verify"]:
        raise InputError("not a file of states", f"{path}: command is no maviper verify", ADVICE)
    ours, theirs = (plain_name(name)[0] for name in (world_name(policies.world), states.world))
    if ours != theirs:
        raise InputError("the states are of another world", f"{path}: {theirs[:80]}, not {ours}", ADVICE)
    points = _points(states, path)
    statement = replaying.known_formula(states.formula, states.team, points, policies, path)
    _ensure_floats(statement, path)
    region = read_region(states.bounds, policies.world, f"{path}: bounds", observed_velocities(policies))
    claim = Property(OWN, states.team, statement=statement, eps=eps, label=states.property)
    region = replace(region, name=states.region)
    return Failing(claim, points, (states.profile,), (path.parent,), region, states.command)


def _ensure_floats(statement: Formula, path: Path) -> None:
    """InputError for numbers that no float64 comes near."""
    parts = [part for part in atoms(statement) if isinstance(part, Linear)]
    if any(abs(number) > LARGEST for part in parts for number in (part.bound, *(weight for weight, _ in part.terms))):
        raise InputError("the formula has numbers that are too large", str(path), ADVICE)


def _points(states: StatesJson, path: Path) -> tuple[Point, ...]:
    n = len(states.positions)
    errors = states.errors or [{}] * n
    if not 1 <= n <= MOST_STATES or not n == len(states.goals) == len(errors):
        what = f"{n} positions, {len(states.goals)} goals, {len(errors)} errors"
        raise InputError("not a file of states", f"{path}: {what}", ADVICE)
    if any(len(row) != len(states.coordinates) for row in states.positions):
        raise InputError("not a file of states", f"{path}: not {len(states.coordinates)} numbers in each row", ADVICE)
    if not all(math.isfinite(value) for row in states.positions for value in row):
        raise InputError("not a file of states", f"{path}: a position is not finite", ADVICE)
    return tuple(
        Point(dict(zip(states.coordinates, row, strict=True)), goal, wrong)
        for row, goal, wrong in zip(states.positions, states.goals, errors, strict=True)
    )


def _joined(a: Failing, b: Failing) -> Failing:
    """Both, each state once."""
    known = {(tuple(point.position.items()), point.goal, tuple(point.errors.items())) for point in a.points}
    further = [p for p in b.points if (tuple(p.position.items()), p.goal, tuple(p.errors.items())) not in known]
    claim = replace(a.claim, eps=max(a.claim.eps, b.claim.eps))
    return Failing(
        claim,
        (*a.points, *further),
        (*a.profiles, *b.profiles),
        (*a.folders, *b.folders),
        b.region or a.region,
        b.command or a.command,
    )
