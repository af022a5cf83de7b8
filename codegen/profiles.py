"""Policy profiles as others hand them in: read from a text, and judged by all rules.

Does: reads and checks a text; tells where it is damaged, and whether it was edited; yields every broken rule: beside
  those of check.py those of texts, labels, evidence and the region.
Assumes: UTF-8 text in the shape of form.py; `check` and `policy_json`, on which it rests what a profile means.
Does not: touch files, or judge whether a policy is any good.
"""

import json
import math
import re
import sys
from collections.abc import Iterator, Sequence
from contextlib import suppress
from fractions import Fraction
from typing import Any
from unicodedata import category

import msgspec

from codegen import check as meaning
from codegen.check import Violation
from codegen.errors import STEERING, ProfileError, escape_text, suggestion
from codegen.form import ProfileJson, make_fault, place
from codegen.ir import AgentPolicy, PolicyProfile, WorldSpec
from codegen.policy_json import content_hash, decode
from codegen.world import RegionSpec, round_up

MAX_BYTES = 256 * 2**20  # a profile beyond this is not one of ours
RESTORE = "the file is truncated or not a profile; restore it or extract it again"


def loads(text: str | bytes, where: str = "profile") -> PolicyProfile:
    """The profile in a JSON text. ProfileError with the path of the fault when it is damaged or breaks a rule."""
    if len(text) > MAX_BYTES:
        raise ProfileError(
            "the file is too large for a policy profile", where, f"profiles have at most {MAX_BYTES} bytes"
        )
    try:
        raw = msgspec.json.decode(text, type=ProfileJson)
    except msgspec.ValidationError as error:
        _ensure_whole(text, where)  # a field may be found wrong before the text is found to break off
        message, _, path = str(error).partition(" - at `")
        raise make_fault(f"{where}: {escape_text(path.rstrip('`') or '$')}: {escape_text(message)}") from None
    except (msgspec.DecodeError, RecursionError, UnicodeDecodeError) as error:
        data = text.encode() if isinstance(text, str) else text
        offset = re.search(r"\(byte (\d+)\)", str(error))
        path = place(data[: int(offset[1]) if offset else None].decode(errors="replace"))
        raise ProfileError("not readable as JSON", f"{where}: {escape_text(f'{path}: {error}')}", RESTORE) from None
    profile = decode(raw, where, find_besides)
    expected = content_hash(profile)
    if raw.content_hash is not None and raw.content_hash != expected:
        raise ProfileError(
            "the profile was edited after it was written",
            f"{where}: $.content_hash: states {escape_text(raw.content_hash[:16])}..., "
            f"but the content hashes to {expected[:16]}...",
            "restore the file; if the edit was on purpose, delete the content_hash line",
        )
    return profile


def _ensure_whole(text: str | bytes, where: str) -> None:
    """ProfileError for a text that is no JSON."""
    with suppress(RecursionError, UnicodeDecodeError):
        try:
            json.loads(text)
        except json.JSONDecodeError as error:
            raise ProfileError("not readable as JSON", f"{where}: {escape_text(str(error))}", RESTORE) from None


def schema() -> dict[str, Any]:
    """The JSON schema (draft 2020-12) of a profile."""
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **msgspec.json.schema(ProfileJson)}


NUMBER = re.compile(r"-?\d{1,30}(\.\d{1,60})?|-?\d{1,99}/[1-9]\d{0,99}")  # as the verifier writes bounds
UNSEEN = STEERING | {"Cs"}  # also halves of pairs
MAX_LABEL = 2_000  # letters of one


def violations(profile: PolicyProfile) -> Iterator[Violation]:
    """Every broken rule of `profile`."""
    yield from meaning.violations(profile)
    yield from find_besides(profile)


def find_besides(profile: PolicyProfile) -> Iterator[Violation]:
    """The broken rules on which it does not rest what a profile decides."""
    for index, policy in enumerate(profile.agents):
        yield from _evidence(f"$.agents[{index}]", policy)
    if profile.region is not None:
        yield from _region(profile.region, profile.world)
    yield from _texts(profile)
    for group, values in (("training", profile.provenance.training), ("evaluation", profile.provenance.evaluation)):
        for key, value in values.items():
            if isinstance(value, float) and not math.isfinite(value):
                yield Violation(f"$.provenance.{group}.{key}", "must be finite")


def _evidence(path: str, policy: AgentPolicy) -> Iterator[Violation]:
    """Yields the faults of what was seen and counted in episodes, and of the labels of actions."""
    if policy.seen and len(policy.seen) != len(policy.features):
        yield Violation(f"{path}.features", "all of them have been seen, or none has")
    for index, ends in enumerate(policy.seen):
        if not all(abs(end) <= sys.float_info.max for end in ends) or list(ends) != sorted(ends):
            yield Violation(f"{path}.features[{index}].seen", "are finite numbers in ascending order")
    yield from _labels(f"{path}.actions", [action.label for action in policy.actions if not action.acts])
    visits = policy.tree.visits
    if len(visits) and (len(visits) != len(policy.tree.feature) or (visits < 0).any()):
        yield Violation(f"{path}.tree", "visits are one number for each node, from 0")


def _texts(profile: PolicyProfile) -> Iterator[Violation]:
    """Texts that are no names are shown to people, so they hold nothing that steers a terminal or cannot be seen."""
    world, origin = profile.world, profile.provenance
    texts = [("world.reference", world.reference)]
    texts += [("world.options", f"{key}={value}") for key, value in world.options.items()]
    texts += [(f"world.variables[{index}].unit", each.unit) for index, each in enumerate(world.variables)]
    for index, policy in enumerate(profile.agents):
        texts += [(f"agents[{index}].features[{k}].unit", each.unit) for k, each in enumerate(policy.features)]
        texts += [(f"agents[{index}].outputs[{k}].unit", each.unit) for k, each in enumerate(policy.outputs)]
    texts += [(f"provenance.{name}", getattr(origin, name)) for name in ("algorithm", "preset", "expert", "tool")]
    for group, values in (("training", origin.training), ("evaluation", origin.evaluation)):
        texts += [(f"provenance.{group}", f"{key}={value}") for key, value in values.items()]
    for path, text in texts:
        if not text.isprintable() and any(category(letter) in UNSEEN for letter in text):
            yield Violation(f"$.{path}", f"contains an invisible character: {escape_text(text[:40])}")


def _region(region: RegionSpec, world: WorldSpec) -> Iterator[Violation]:
    names = world.coordinates()
    entities = [entity.name for entity in world.agents + world.landmarks]
    readable = True
    if bool(region.goals) != bool(world.goals):
        yield Violation("$.region.goals", "must list the possible goals if the world has goals, and nothing otherwise")
    for goal in region.goals:
        if goal not in world.goals:
            yield Violation("$.region.goals", f"no goal '{goal}' in the world; {suggestion(goal, world.goals)}")
    for kind, pairs, known in (
        ("box", [(name, [name], bounds) for name, bounds in region.box.items()], names),
        ("difference", [(name, name.split(" - "), bounds) for name, bounds in region.difference.items()], names),
        ("apart", [(name, name.split(" - "), (least, least)) for name, least in region.apart.items()], entities),
    ):
        for name, parts, bounds in pairs:
            fault = _bounds_fault(kind, name, parts, bounds, known)
            if fault is not None:
                readable = False
                yield fault
    for name, (low, high) in region.box.items() if readable else ():
        if round_up(Fraction(low)) > -round_up(-Fraction(high)):
            yield Violation(f"$.region.box.{name}", "no double lies within the bounds")


def _bounds_fault(
    kind: str, name: str, parts: Sequence[str], bounds: Sequence[str], known: Sequence[str]
) -> Violation | None:
    """Returns what is wrong with an entry of a region, or None."""
    if len(parts) != (1 if kind == "box" else 2) or any(part not in known for part in parts):
        return Violation(f"$.region.{kind}", f"cannot read {name!r}")
    here = f"$.region.{kind}.{name}"
    if not all(NUMBER.fullmatch(text) for text in bounds):
        return Violation(here, f"not numbers: {bounds}")
    if len(set(parts)) < len(parts):
        return Violation(here, "compares a name with itself")
    if kind == "apart" and Fraction(bounds[0]) <= 0:
        return Violation(here, "a distance must be above 0")
    if Fraction(bounds[0]) > Fraction(bounds[1]):
        return Violation(here, f"the lower bound {bounds[0]} is above {bounds[1]}")
    return None


def _labels(path: str, labels: Sequence[int | float | str | None]) -> Iterator[Violation]:
    """Actions have labels of one kind, numbers or texts, or none has."""
    if not labels or all(each is None for each in labels):
        return
    texts = [each for each in labels if isinstance(each, str)]
    if len(texts) not in (0, len(labels)) or None in labels or len({*labels}) < len(labels):
        yield Violation(path, "labels are as many numbers or texts as there are actions, all different, or none")
    for each in labels:
        odd = isinstance(each, str) and (len(each) > MAX_LABEL or any(category(letter) in UNSEEN for letter in each))
        if odd or (isinstance(each, int | float) and not (math.isfinite(each) and abs(each) <= sys.float_info.max)):
            yield Violation(path, f"not a label: {escape_text(each)[:40]}")


def check(profile: PolicyProfile) -> tuple[Violation, ...]:
    """Every broken invariant of a profile, each with its path; empty when the profile is sound."""
    return tuple(violations(profile))


def ensure(profile: PolicyProfile, where: str = "profile") -> PolicyProfile:
    """The profile itself when it is sound; otherwise ProfileError with all broken rules."""
    return meaning.ensure(profile, where, find_besides)
