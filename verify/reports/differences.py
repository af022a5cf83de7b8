"""The report of a comparison of two profiles: where they act differently, as data and as lines.

Does: collects verdicts, shares, zones in words and with exact bounds, and examples.
Assumes: a result of `verify.verdicts.differences.difference`; shares of states met are given by the caller.
Does not: contain times, paths or facts about the machine.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from codegen.deciding import describe_action
from codegen.floats import rational_literal
from codegen.form import layout
from codegen.intervals import Share
from codegen.policy_json import content_hash
from verify.certificates.proofs import count_bytes
from verify.claims.region import goal_text
from verify.claims.region_files import name_region
from verify.claims.wording import region_document
from verify.reports.where import FIRST, describe_bounds, zone_facts
from verify.states.real import write_values
from verify.states.shares import explain_unstated
from verify.states.state import State
from verify.verdicts.differences import AgentDifference, Difference, Span, Zone, differing_leaves, example

FORM = "maviper-difference-1"
SOME = "some agent"  # in place of a name: the share of states in which any of them acts differently


@dataclass(frozen=True)
class Estimates:
    """Shares by counting, by agent and for SOME. `met`: of the states that the first profile meets in play, which are
    of whole episodes and so not independent; None where its world cannot be played. `uniform`: of the region's states.
    """

    uniform: Mapping[str, Share]
    met: Mapping[str, Share] | None
    episodes: int = 0


def document(difference: Difference, counted: Estimates) -> dict[str, Any]:
    """All facts as plain data."""
    question = difference.question
    return {
        "difference": FORM,
        "profiles": [content_hash(difference.first), content_hash(difference.second)],
        "world": {"name": difference.first.world.name, "reference": difference.first.world.reference},
        "semantics": question.semantics,
        "region_name": name_region(difference.first, question.region),
        "region": region_document(question.region),
        "verdict": difference.verdict.value,
        "share": _share(difference.together),
        **_uniform(difference.unmeasured or explain_unstated(question), counted.uniform[SOME]),
        "met": None if counted.met is None else counted.met[SOME].document(),
        "episodes": counted.episodes,
        "agents": [_agent(difference, one, counted) for one in difference.agents],
        "certificate": None
        if difference.certificate is None
        else {
            "bytes": count_bytes(difference.certificate.proof),
            "branches": difference.branches,
            "checker": "accepted",
        },
    }


def _uniform(unmeasured: str, share: Share) -> dict[str, Any]:
    """The share of sampled states of the region, or why there is none."""
    return {"uniform": None, "unmeasured": unmeasured} if unmeasured else {"uniform": share.document()}


def _share(span: Span) -> dict[str, Any]:
    least, most = span
    exact = {"fraction": rational_literal(least)} if least == most else {}
    return {"least": float(least), "most": float(most), **exact}


def _agent(difference: Difference, one: AgentDifference, counted: Estimates) -> dict[str, Any]:
    zones = _merge_zones([_zone(difference, one, zone) for zone in one.zones[:FIRST]])
    state = None if one.example is None else _state(one.example)
    goals: dict[str, dict[str, Any]] = {}  # goal -> its zones, and their share of the region's states with it
    for place, failing in enumerate(one.failing):
        if failing.goal is not None:
            share = None if one.share is None else sum(one.share.zones[place]) * len(one.failing) / one.share.region
            goals[failing.goal] = {"zones": len(failing.zones), "share": share}
    return {
        "agent": one.agent,
        "verdict": one.verdict.value,
        "reason": one.reason,
        "share": _share(one.span),
        "goals": goals,
        **_uniform(one.unmeasured, counted.uniform[one.agent]),
        "met": None if counted.met is None else counted.met[one.agent].document(),
        "found": len(one.zones),
        "complete": one.complete,
        "example": next((zone["example"] for zone in zones if zone["example"]), state),
        "zones": zones,
    }


def _merge_zones(zones: Iterable[dict[str, Any]]) -> list[dict[str, Any]]:
    """Zones that are the same for several goals as one, the largest first."""
    merged: dict[str, dict[str, Any]] = {}
    for zone in zones:
        same = merged.setdefault(str([zone[key] for key in ("leaves", "box", "difference")]), zone)
        if same is not zone:
            same["goals"] += zone["goals"]
            same["share"] = None if same["share"] is None else same["share"] + zone["share"]
    return sorted(merged.values(), key=lambda zone: -(zone["share"] or 0))


def _zone(difference: Difference, one: AgentDifference, zone: Zone) -> dict[str, Any]:
    leaves = differing_leaves(difference, zone)
    policies = difference.first.policy(one.agent), difference.second.policy(one.agent)
    region = difference.question.region
    facts = zone_facts(difference.question.profile, region, zone.failing, zone.branch, None)
    state = example(difference.question, zone)
    return {
        "goals": [] if zone.failing.goal is None else [zone.failing.goal],
        "leaves": list(leaves),
        "actions": [
            describe_action(policy.actions[int(policy.tree.action[leaf])])
            for policy, leaf in zip(policies, leaves, strict=True)
        ],
        "share": None if one.share is None or zone.volume is None else zone.volume / one.share.region,
        "words": describe_bounds(zone.failing, zone.branch, region),
        "box": facts["box"],
        "difference": facts["difference"],
        "example": None if state is None else _state(state),
    }


def _state(state: State) -> dict[str, Any]:
    return {"goal": goal_text(state.goal), "position": write_values(state.position)}


def as_json(facts: Mapping[str, Any]) -> str:
    """The text of difference.json."""
    return layout(dict(facts)) + "\n"
