"""The JSON form of a policy profile, with its content hash.

Does: encodes a profile to text that people and other programs can read; decodes and checks it, naming the fault's path.
Assumes: objects in the shape of form.py.
Does not: read a text (profiles.py), or touch files.

A split of an agent that compares float32 states its threshold twice: `threshold` is the double that decides for doubles
and float32 alike, `float32` is the float32 itself, exactly, in hexadecimal. They must agree. Of an agent that compares
float64 or whole numbers, `threshold` is the threshold itself.
"""

import hashlib
import json
import re
from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Any, cast

import msgspec
import numpy as np

from codegen.check import Besides, ensure
from codegen.errors import ProfileError, escape_text
from codegen.floats import FLOAT32, FLOAT64, WHOLE
from codegen.form import (
    ADVICE,
    DIVIDING_VERSION,
    INNER_VERSION,
    MEMORY_VERSION,
    SCHEMA_VERSION,
    SUMS_VERSION,
    WHOLE_VERSION,
    AgentJson,
    GrownJson,
    ProfileJson,
    iterate_terms,
    layout,
    make_fault,
    nodes_of,
    tree_of,
)
from codegen.ir import (
    FUNCTIONS,
    UNSCALED,
    ActionSpec,
    AgentPolicy,
    EntitySpec,
    FeatureSpec,
    GrownTree,
    Meaning,
    OutputSpec,
    PolicyProfile,
    Provenance,
    Update,
    VariableSpec,
    WorldSpec,
)
from codegen.world import RegionSpec

SEMANTICS = (
    "float32 observations; left iff x[feature] <= threshold; NaN goes right; a node's id is its place in the list; "
    "threshold decides for doubles and float32 alike, float32 is the exact threshold"
)
WITH_SUMS = (
    "; a sum of [weight, feature] and [constant, null] is added left to right, beginning with its first term, in the "
    "agent's arithmetic, and its threshold is exact; outputs are clipped to low and high, then rounded to what it gives"
)
WITH_INNER = "; [weight, sum] weighs a sum that is computed by itself first"
WITH_QUOTIENTS = "; a weight that is a text, / and a number, divides by that number"
WITH_MEMORY = (
    "; features with an initial value are remembered, and have it after a reset; after each decision the leaf's action "
    "updates them, all at once, and acts is the action that is taken; all else is kept, also where no decision is asked"
)
WITH_WHOLE = (
    "; of agents whose numbers are int8 to uint32: observations are whole numbers of that type, threshold is exact"
)
WITH_FLOAT64 = f"{SEMANTICS}; of agents whose numbers are float64: float64 observations, threshold is exact"


@lru_cache(maxsize=8)  # a profile is frozen, its arrays too, and asked for its hash by everyone who writes a file
def content_hash(profile: PolicyProfile) -> str:
    """SHA-256 of everything in the profile, in hexadecimal."""
    return _hash(_document(profile))


def dumps(profile: PolicyProfile) -> str:
    """The JSON text of a profile; equal profiles give equal bytes."""
    document = _document(profile)
    return layout(document | {"content_hash": _hash(document)}) + "\n"


def _semantics(
    numbers: Sequence[str], *, summing: bool, nesting: bool, dividing: bool, remembering: bool
) -> tuple[int, str]:
    """Returns a profile's schema version and its text on its meaning; `numbers`: what its agents compare; `summing`,
    `nesting` (sums weigh sums), `dividing`, `remembering`: whether any does.
    """
    whole = any(each in WHOLE for each in numbers)
    version = MEMORY_VERSION if remembering else SUMS_VERSION if summing else SCHEMA_VERSION
    version = DIVIDING_VERSION if dividing else INNER_VERSION if nesting else WHOLE_VERSION if whole else version
    added = (WITH_SUMS if summing else "") + (WITH_INNER if nesting else "") + (WITH_QUOTIENTS if dividing else "")
    added += (WITH_MEMORY if remembering else "") + (WITH_WHOLE if whole else "")
    return version, (WITH_FLOAT64 if FLOAT64 in numbers else SEMANTICS) + added


def _hash(document: dict[str, Any]) -> str:
    canonical = json.dumps(document, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(canonical.encode()).hexdigest()


# --- encoding

HOW = ("set", "add")


def _document(profile: PolicyProfile) -> dict[str, Any]:
    world, provenance, region = profile.world, profile.provenance, profile.region
    variables = [
        {"name": one.name, "unit": one.unit, "range": [float(one.low), float(one.high)]} for one in world.variables
    ]
    version, semantics = _semantics(
        [policy.whole or policy.numbers for policy in profile.agents],
        summing=any(policy.tree.arithmetic for policy in profile.agents),
        nesting=any(each.depth > 1 for policy in profile.agents for each in policy.tree.all_sums),
        dividing=any(each.divides for policy in profile.agents for each in policy.tree.all_sums),
        remembering=any(policy.memory for policy in profile.agents),
    )
    return {
        "schema_version": version,
        "semantics": semantics,
        "world": {
            "name": world.name,
            "reference": world.reference,
            "agents": [_entity(entity) for entity in world.agents],
            "landmarks": [_entity(entity) for entity in world.landmarks],
            "goals": list(world.goals),
            "dt": float(world.dt),
            "damping": float(world.damping),
            "start_box": [float(world.start_low), float(world.start_high)],
            "episode_steps": world.episode_steps,
            "contact_force": float(world.contact_force),
            "contact_margin": float(world.contact_margin),
            "options": dict(world.options),
            **({"variables": variables} if variables else {}),
        },
        "agents": [_agent(policy) for policy in profile.agents],
        "provenance": {
            "algorithm": provenance.algorithm,
            "preset": provenance.preset,
            "seed": provenance.seed,
            "expert": provenance.expert,
            "tool": provenance.tool,
            "training": dict(provenance.training),
            "evaluation": dict(provenance.evaluation),
        },
        **({} if region is None else {"region": _region(region)}),
    }


def _region(region: RegionSpec) -> dict[str, Any]:
    return {
        "goals": list(region.goals),
        "box": {name: list(bounds) for name, bounds in region.box.items()},
        "difference": {pair: list(bounds) for pair, bounds in region.difference.items()},
        "apart": dict(region.apart),
    }


def _entity(entity: EntitySpec) -> dict[str, Any]:
    return {
        "name": entity.name,
        "size": float(entity.size),
        "force": float(entity.force),
        "max_speed": None if entity.max_speed is None else float(entity.max_speed),
        "collides": entity.collides,
        "start_box": None if entity.start is None else [float(bound) for bound in entity.start],
    }


def _agent(policy: AgentPolicy) -> dict[str, Any]:
    features = [
        {
            "name": feature.name,
            "unit": feature.unit,
            "range": [float(feature.low), float(feature.high)],
            "meaning": None if feature.meaning is None else str(feature.meaning),
            **({"seen": list(policy.seen[place])} if policy.seen else {}),
            **({} if feature.initial is None else {"initial": feature.initial}),
            **({} if feature.scale == UNSCALED else {"scale": list(feature.scale)}),
        }
        for place, feature in enumerate(policy.features)
    ]
    actions = [
        {
            "name": action.name,
            "effect": None if action.effect is None else [float(part) for part in action.effect],
            **({"legal_if": action.legal_if} if action.legal_if else {}),
            **({} if action.label is None else {"label": action.label}),
            **({"acts": action.acts} if action.acts else {}),
            **({"updates": [[u.memory, HOW[u.adds], u.value] for u in action.updates]} if action.updates else {}),
        }
        for action in policy.actions
    ]
    tree, grown = policy.tree, policy.grown
    outputs = [{"name": each.name, "unit": each.unit, "low": each.low, "high": each.high} for each in policy.outputs]
    return {
        "agent": policy.agent,
        "team": policy.team,
        **({} if (numbers := policy.whole or policy.numbers) == FLOAT32 else {"numbers": numbers}),
        "features": features,
        "actions": actions,
        **({"arithmetic": tree.arithmetic} if tree.arithmetic else {}),
        **({"gives": tree.gives, "outputs": outputs} if outputs else {}),
        "tree": nodes_of(policy),
        "grown": None
        if grown is None
        else {name: getattr(grown, name).tolist() for name in GrownJson.__struct_fields__},
    }


# --- decoding


def decode(raw: ProfileJson, where: str, besides: Besides) -> PolicyProfile:
    """The profile that a file states. ProfileError with the path of what breaks a rule, one of `besides` included."""
    remembered = (each.initial is not None for agent in raw.agents for each in agent.features)
    terms = list(iterate_terms(raw))
    version, semantics = _semantics(
        [agent.numbers for agent in raw.agents],
        summing=any(agent.arithmetic for agent in raw.agents),
        nesting=any(isinstance(term.weighed, list) for term in terms),
        dividing=any(isinstance(term.weight, str) for term in terms),
        remembering=any(remembered),
    )
    if raw.schema_version != version:
        reads = f"{SCHEMA_VERSION}, {SUMS_VERSION} where an agent has sums or outputs, {MEMORY_VERSION} with memory"
        reads += f", {WHOLE_VERSION} with whole numbers, {INNER_VERSION} where a sum weighs another"
        reads += f", {DIVIDING_VERSION} where one divides"
        detail = f"{where}: $.schema_version: {raw.schema_version}; this version of maviper reads {reads}"
        raise ProfileError(
            "a policy profile with another schema version", detail, "extract it again or install a matching version"
        )
    if raw.semantics != semantics:
        detail = f"{where}: $.semantics: '{escape_text(raw.semantics[:80])}'"
        raise ProfileError("a policy profile with other semantics", detail, ADVICE)
    world = raw.world
    spec = WorldSpec(
        name=world.name,
        reference=world.reference,
        agents=tuple(EntitySpec(*msgspec.structs.astuple(entity)) for entity in world.agents),
        landmarks=tuple(EntitySpec(*msgspec.structs.astuple(entity)) for entity in world.landmarks),
        goals=tuple(world.goals),
        dt=world.dt,
        damping=world.damping,
        start_low=world.start_box[0],
        start_high=world.start_box[1],
        episode_steps=world.episode_steps,
        contact_force=world.contact_force,
        contact_margin=world.contact_margin,
        options=world.options,
        variables=tuple(VariableSpec(one.name, one.unit, *one.range) for one in world.variables),
    )
    agents = tuple(_policy(agent, f"{where}: $.agents[{index}]") for index, agent in enumerate(raw.agents))
    given = msgspec.structs.asdict(raw.provenance)
    region = raw.region and RegionSpec(tuple(raw.region.goals), raw.region.box, raw.region.difference, raw.region.apart)
    return ensure(PolicyProfile(spec, agents, Provenance(**cast(Mapping[str, Any], given)), region), where, besides)


def _policy(raw: AgentJson, path: str) -> AgentPolicy:
    features = tuple(
        FeatureSpec(
            item.name,
            item.unit,
            *item.range,
            _meaning(item.meaning, f"{path}.features[{index}].meaning"),
            item.initial,
            item.scale,
        )
        for index, item in enumerate(raw.features)
    )
    actions = tuple(
        ActionSpec(
            item.name,
            item.effect,
            item.legal_if,
            item.label,
            item.acts,
            tuple(Update(memory, how == HOW[True], value) for memory, how, value in item.updates),
        )
        for item in raw.actions
    )
    tree = tree_of(raw, path)
    grown = None
    if raw.grown is not None:
        columns: list[list[Any]] = list(msgspec.structs.astuple(raw.grown))
        if any(isinstance(number, int) and abs(number) >= 2**31 for column in columns for number in column):
            raise make_fault(f"{path}.grown: a number is out of range")
        grown = GrownTree(*(np.array(column) for column in columns))
    seen = tuple(item.seen for item in raw.features if item.seen is not None)
    outputs = tuple(OutputSpec(item.name, item.unit, item.low, item.high) for item in raw.outputs)
    whole = raw.numbers if raw.numbers in WHOLE else ""
    return AgentPolicy(raw.agent, raw.team, features, actions, tree, grown, seen, outputs, whole)


_TERM = re.compile(r"\s*([+-]?)\s*(?:(\d{1,3}(?:\.\d{1,9})?)\*)?([A-Za-z][\w-]*(?:\.[A-Za-z][\w-]*)?)")


def _meaning(text: str | None, path: str) -> Meaning | None:
    """`goal.x - agent_0.x`, `sign(...)` or another function of it, or `0` as a Meaning."""
    if text is None:
        return None
    if text == "0":
        return Meaning(())
    wrapped = re.fullmatch(rf"({'|'.join(FUNCTIONS)})\((.*)\)", text)
    function, body = wrapped.groups() if wrapped else ("", text)
    terms: list[tuple[float, str]] = []
    place = 0
    while place < len(body):
        match = _TERM.match(body, place)
        if match is None or (terms and not match[1]):
            known = ", ".join(f"`{name}(...)`" for name in FUNCTIONS)
            raise make_fault(f"{path}: cannot read '{escape_text(text[:80])}'", f"write `a.x - b.x`, {known} or `0`")
        size = float(match[2]) if match[2] else 1
        terms.append((-size if match[1] == "-" else size, match[3]))
        place = match.end()
    if not terms:
        raise make_fault(f"{path}: empty", "write `a.x - b.x`, or null")
    return Meaning(tuple(terms), function)
