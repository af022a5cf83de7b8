"""The part of a report that is about whole episodes.

Does: collects what was claimed of episodes, the verdict and its evidence; draws the courses of a counterexample.
Assumes: results of `episodes.verify_episodes`.
Does not: contain times, paths or facts about the machine.
"""

from collections.abc import Mapping, Sequence
from typing import Any

from codegen.dynamics import partners
from codegen.intervals import format_share
from codegen.ir import PolicyProfile
from verify.certificates.proofs import count_bytes
from verify.checker.episodes.unbounded import Edges
from verify.claims.catalogue import COINCIDING, sentence
from verify.claims.episodes import PLAYED
from verify.claims.region import goal_text
from verify.claims.region_files import name_region
from verify.claims.wording import account_of, region_document
from verify.decimals import plain
from verify.kinds import MACHINE
from verify.reports.drawing import VIEW
from verify.reports.report import EPISODES_WITH_CERTIFICATE, EPISODES_WITHOUT_CERTIFICATE, POSITIONS, SHARES, Telling
from verify.result import Verdict
from verify.verdicts.episodes import EpisodeEvidence, EpisodeResult

MEANINGS = {
    Verdict.PROVED: "holds in every episode that starts in the region",
    Verdict.VIOLATED: "fails in the episode shown, which was replayed",
    Verdict.VACUOUS: "no start at rest lies in the region, so nothing was claimed",
    Verdict.UNKNOWN: "no answer",
    Verdict.SKIPPED: "not asked",
}
LIMITS = (
    "In claims about episodes, agents start at rest. Proofs relax the tests of the trees by 2^-30. This covers the "
    "rounding of positions, so a proof holds for the deployed arithmetic.",
)
EDGES = (
    "A claim for ever is proved by edges that agents never cross: no tree pushes an agent outwards where it could not "
    "stop before its edge. The proof holds for any number of steps, rounding included. Counterexamples are looked for "
    f"in {PLAYED} steps."
)
CONTACTS = (
    "Where entities may touch, contact forces are over-approximated: they may be anything within the bounds that the "
    "zone gives.",
    f"Claims about episodes are {COINCIDING}; a region can keep starts apart.",
)
EDGE = 0.25  # margin of the picture: length units
NEAREST = 0.5  # least half side of what a picture shows, its margin aside: length units


def facts(profile: PolicyProfile, result: EpisodeResult, command: str) -> dict[str, Any]:
    """A result as plain data."""
    claim, evidence = result.claim, result.evidence
    others = evidence.opponents_words
    return {
        "kind": "episodes",
        "property": claim.name,
        "label": claim.label,
        "team": claim.team,
        "claim": sentence(claim, profile.world),
        "formula": "",
        "assumption": "",
        "steps": claim.parameters["steps"],
        "parameters": {
            "steps": str(claim.parameters["steps"]),
            "radius": plain(claim.radius),
            **({claim.whom: ", ".join(claim.named) or account_of(claim).nobody_named} if claim.whom else {}),
        },
        "semantics": MACHINE,
        "region_name": name_region(profile, result.region),
        "region": region_document(result.region),
        "verdict": result.verdict.value,
        "meaning": MEANINGS[result.verdict] + (f", {others}" if result.verdict is Verdict.PROVED else ""),
        "reason": result.reason,
        "violating": evidence.violating.document(),
        "idle": evidence.idle.document(),
        "shuffled_control": evidence.control.verdict.value,
        "shuffled_leaves": evidence.control.words,
        "replays": ["reference", *evidence.replays],
        "replays_skipped": list(evidence.skipped),
        "followed": [list(agents) for agents in evidence.followed],
        "whatever": others,
        "contacts": evidence.contacts,
        "zones": result.cost.spent,
        "budget": result.cost.budget,
        "certificate": None if evidence.certificate is None else _certificate(evidence),
        "uncertified": evidence.uncertified,
        "counterexample": None if evidence.state is None else _counterexample(profile, result),
        "command": command,
    }


def limits(profile: PolicyProfile, results: Sequence[EpisodeResult]) -> list[str]:
    """Lists what these verdicts do not say."""
    edged = [EDGES] if any(result.claim.by_edges for result in results) else []
    return [POSITIONS, *SHARES, *LIMITS, *edged, *(CONTACTS if partners(profile.world) else ())]


def _certificate(evidence: EpisodeEvidence) -> dict[str, Any]:
    assert evidence.certificate is not None
    proof = evidence.certificate.proof
    told = {"bytes": count_bytes(proof), "branches": evidence.branches, "checker": "accepted"}
    if not isinstance(proof, Edges):
        return told
    return told | {"edges": {name: [plain(edge) for edge in both] for name, both in proof.edges.items()}}


def _counterexample(profile: PolicyProfile, result: EpisodeResult) -> dict[str, Any]:
    evidence = result.evidence
    assert evidence.state is not None
    agents = [
        {
            "agent": way.agent,
            "landmark": way.landmark,
            "nearest": way.nearest,
            "step": way.step,
            "last": way.last,
            "says": str(way),
            "actions": list(way.actions),
            "places": [list(place) for place in way.places],
        }
        for way in evidence.ways
    ]
    return {
        "goal": goal_text(evidence.state.goal),
        "position": dict(evidence.state.position),
        "agents": agents,
        "replayed_by": ["reference", *evidence.replays],
        "explanation": None if evidence.explanation is None else evidence.explanation.document(),
        "picture": _picture(profile, result),
    }


def _picture(profile: PolicyProfile, result: EpisodeResult) -> dict[str, Any]:
    """All agents' courses, and the landmarks with the squares that count as arrived, in picture coordinates."""
    evidence = result.evidence
    assert evidence.state is not None and evidence.episode is not None
    state = {name: float(value) for name, value in evidence.state.position.items()}
    marks = {entity.name: (state[f"{entity.name}.x"], state[f"{entity.name}.y"]) for entity in profile.world.landmarks}
    ours = [way.agent for way in evidence.ways]
    names, course = profile.world.coordinates(), evidence.episode.coordinates
    ways: dict[str, list[tuple[float, float]]] = {}  # agent -> its places, step by step; our own agents come first
    for agent in (*ours, *(entity.name for entity in profile.world.agents)):
        ways[agent] = course[:, [names.index(f"{agent}.x"), names.index(f"{agent}.y")]].tolist()
    places = [*marks.values(), *(place for way in ways.values() for place in way)]
    ends = [(min(values), max(values)) for values in zip(*places, strict=True)]
    middle_x, middle_y = ((low + high) / 2 for low, high in ends)
    reach = max(NEAREST, *((high - low) / 2 for low, high in ends)) + EDGE
    scale = VIEW / (2 * reach)

    def draw(place: tuple[float, float]) -> tuple[float, float]:
        return round((place[0] - middle_x + reach) * scale, 2), round((reach - place[1] + middle_y) * scale, 2)

    half = round(float(result.claim.radius) * scale, 2) if account_of(result.claim).landmark_each else 0.0
    landmarks = [
        {"name": name, "x": draw(place)[0], "y": draw(place)[1], "half": half, "goal": name == evidence.state.goal}
        for name, place in marks.items()
    ]
    courses = [
        {
            "name": agent,
            "end": draw(way[-1]),
            "ours": agent in ours,
            "x": draw(way[0])[0],
            "y": draw(way[0])[1],
            "line": " ".join(f"{x},{y}" for x, y in map(draw, way)),
        }
        for agent, way in ways.items()
    ]
    meetings = [
        {
            "from": draw(ways[way.agent][way.step]),
            "to": draw(ways[way.landmark][way.step] if way.landmark in ways else marks[way.landmark]),
            "says": f"step {way.step}",
        }
        for way in evidence.ways
        if result.claim.apart and way.nearest < result.claim.radius
    ]
    return {"size": VIEW, "landmarks": landmarks, "courses": courses, "meetings": meetings}


def words(result: EpisodeResult, told: Mapping[str, Any]) -> list[str]:
    """The first lines of a result for a terminal, from its facts."""
    leaves = told["shuffled_leaves"] or "SKIPPED"
    lines = [
        f"violating {format_share(told['violating'])} of sampled starts, shuffled leaves: {leaves}",
        told["reason"],
    ]
    if result.verdict is Verdict.PROVED:
        followed = "; ".join(" with ".join(agents) for agents in told["followed"])
        lines += [f"{told['zones']:,} zones; followed: {followed}; {told['whatever']}", result.evidence.left_out]
    lines += [f"one reading, no certificate: {told['uncertified']}"] if told["uncertified"] else []
    lines += [f"contacts: {told['contacts']}"] if told["contacts"] else []
    if told["counterexample"]:
        lines.append(f"counterexample: {'; '.join(agent['says'] for agent in told['counterexample']['agents'])}")
    return lines


TELLING = Telling(facts, limits, (EPISODES_WITH_CERTIFICATE, EPISODES_WITHOUT_CERTIFICATE), words=words)
