"""The part of a report that is about single decisions.

Does: collects what was claimed of world states or observations, the verdict and its evidence; draws counterexamples.
Assumes: results of `verdicts.decisions.verify`.
Does not: contain times, paths or facts about the machine.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from fractions import Fraction
from typing import Any

from codegen.boxes import leaves_below
from codegen.intervals import format_share, percent
from codegen.ir import PolicyProfile, Tree
from verify.certificates.proofs import count_bytes
from verify.claims.claim import Parameter
from verify.claims.decisions import OWN, formula
from verify.claims.region import goal_text
from verify.claims.region_files import name_region
from verify.claims.views import describe_view
from verify.claims.wording import formula_document, region_document, spell_decisions, spell_rounded
from verify.counterexamples.search import AgentView, Counterexample
from verify.decimals import plain
from verify.decimals import text as decimal
from verify.kinds import MACHINE, REAL
from verify.reports.drawing import MARK, VIEW, around, label_place
from verify.reports.report import POSITIONS, SHARES, WITH_CERTIFICATE, WITHOUT_CERTIFICATE, Telling
from verify.result import Margin, Verdict
from verify.solver.solve import LeafFinding
from verify.states import shares
from verify.states.real import write_value, write_values
from verify.verdicts.decisions import DecisionEvidence, DecisionResult, of_states

SINGLE = "The claim is about single decisions in world states of the region: it does not say that agents arrive."
REAL_POSITIONS = "Positions are real numbers. Agents may leave the region during an episode (see the on-policy states)."
REAL_SHARES = (
    "In real arithmetic, shares are estimated from float64 states in which agents decide by exact measurements. "
    "States within a rounding error of the bounds of region or claim may be misjudged."
)
OBSERVED_STATES = (
    "Every combination of numbers of the region is a state, whether the environment can show it or not. The claim is "
    "about single decisions: nothing is said of what comes next. NaN and infinity are left out."
)
ASSUMING = "If a claim has an assumption, shares are those among the states that meet it."
NOISE = (
    "Each feature of each agent has its own error, independent of all others. It is added to the exact coordinate or "
    "difference before rounding. Constants and features that test for equality have no error."
)
LEAVES_MEANINGS = {
    Verdict.PROVED: "every leaf is reached in some world state",
    Verdict.VIOLATED: "no world state of the region reaches the dead leaves",
}
REAL_MEANINGS = {
    Verdict.PROVED: "holds in every world state of the region, in real arithmetic",
    Verdict.VIOLATED: "fails in the world state shown, in real arithmetic",
}
ALONE = "Z3 decides alone, without a second engine or a certificate: {}"
OF_PLACES = ("margin", "radius")  # parameters that no formula over observations reads
WORLD_MARGIN = 0.25
NEAREST = 0.25  # least half side of what a picture shows, its margin aside: length units
ARROW = 34  # picture units
MEANINGS = {
    Verdict.PROVED: "holds in every world state of the region",
    Verdict.VIOLATED: "fails in the world state shown, which was replayed",
    Verdict.VACUOUS: "no world state of the region meets what the claim assumes, so nothing was claimed",
    Verdict.UNKNOWN: "no answer",
    Verdict.SKIPPED: "not asked",
}


def limits(profile: PolicyProfile, results: Sequence[DecisionResult]) -> list[str]:
    """Lists what these verdicts do not say."""
    real = any(result.semantics == REAL for result in results)
    if any(result.viewed is not None for result in results):
        lines = [OBSERVED_STATES, *SHARES]
    else:
        lines = [SINGLE, REAL_POSITIONS if real else POSITIONS, *SHARES]
    lines += [REAL_SHARES] if real else []
    if any(result.claim.assumption for result in results):
        lines.append(ASSUMING)
    if any(result.claim.eps for result in results):
        lines.append(NOISE)
    return lines


def facts(given: PolicyProfile, result: DecisionResult, command: str) -> dict[str, Any]:
    """A result as plain data."""
    profile, claim, evidence = result.question.profile, result.claim, result.evidence
    measured, counterexample = evidence.shares, evidence.counterexample
    unread = OF_PLACES if claim.of == OWN and result.viewed is not None else ()
    meanings = MEANINGS | (REAL_MEANINGS if result.semantics == REAL else {})
    meanings = meanings if claim.per_state else MEANINGS | LEAVES_MEANINGS
    return {
        "kind": claim.kind.value,
        "property": claim.name,
        "label": claim.label,
        "team": claim.team,
        **({} if result.viewed is None else {"observations": describe_view(result.viewed.view)}),
        "claim": of_states(result.question, spell_decisions(claim)),
        "landmarks": shares.about_landmarks(profile, formula(profile, claim)),
        "formula": claim.written.strip(),
        "data": formula_document(formula(profile, claim)) if claim.per_state else None,
        "assumption": claim.assumption.strip(),
        **({"numbers": spell_rounded(claim.rounded)} if claim.rounded else {}),
        "parameters": {
            name: _format_parameter(value, name) for name, value in claim.parameters.items() if name not in unread
        },
        "semantics": result.semantics,
        "region_name": name_region(profile, result.region),
        "region": region_document(result.region),
        "verdict": result.verdict.value,
        "meaning": of_states(result.question, meanings[result.verdict]),
        "reason": result.reason,
        "conflict": None if measured.conflict is None else measured.conflict.document(),
        "contested": None if measured.contested is None else measured.contested.document(),
        "violating": None if measured.violating is None else measured.violating.document(),
        "changing": None if measured.changing is None else measured.changing.document(),
        **({"unmeasured": measured.unmeasured} if measured.unmeasured else {}),
        "largest_margin": None if evidence.largest is None else _margin(evidence.largest),
        **({} if evidence.steady_up_to is None else {"largest_eps": _margin(evidence.steady_up_to)}),
        "leaves": [_leaf(finding) for finding in evidence.leaves],
        "visited": None if evidence.visited is None else asdict(evidence.visited),
        "shuffled_control": evidence.control.verdict.value,
        "shuffled_leaves": evidence.control.words,
        "replays": ["reference", *evidence.replays],
        "replays_skipped": list(evidence.skipped),
        "solver": evidence.solver,
        "resources": result.cost.spent,
        "budget": result.cost.budget,
        "engines": [opinion.document() for opinion in evidence.opinions],
        **({"alone": ALONE.format(evidence.alone)} if evidence.alone else {}),
        "certificate": None if evidence.certificate is None else _certificate(evidence),
        "counterexample": None if counterexample is None else _counterexample(profile, result, counterexample),
        "command": command,
    } | ({} if evidence.where is None else _where(profile, result))


def _where(profile: PolicyProfile, result: DecisionResult) -> dict[str, Any]:
    from verify.reports.where import where_facts  # imported here, as few ask where

    return {"where": where_facts(profile, result)}


def _format_parameter(value: Parameter, name: str) -> str:
    """A parameter as text."""
    if isinstance(value, Fraction):
        return plain(value)
    usual = "in the profile's order" if name == "order" else "in the world's order"
    return (", ".join(value) or usual) if isinstance(value, tuple) else str(value)


def _margin(margin: Margin) -> dict[str, Any]:
    failed = None if margin.failed is None else decimal(margin.failed)
    return {"proved": decimal(margin.proved), "not_proved": failed, "questions": margin.questions}


def _leaf(finding: LeafFinding) -> dict[str, Any]:
    witness = finding.witness
    state = None if witness is None else {"goal": goal_text(witness.goal), "position": write_values(witness.position)}
    verdict = finding.verdict.value
    return {"agent": finding.agent, "leaf": finding.leaf, "action": finding.action, "verdict": verdict, "state": state}


def _certificate(evidence: DecisionEvidence) -> dict[str, Any]:
    assert evidence.certificate is not None
    return {"bytes": count_bytes(evidence.certificate.proof), "branches": evidence.branches, "checker": "accepted"}


def _counterexample(profile: PolicyProfile, result: DecisionResult, example: Counterexample) -> dict[str, Any]:
    explanation = result.evidence.explanation
    real = {} if result.semantics == MACHINE else {"judged": example.says, "deployed": deployed_facts(example)}
    return {
        "goal": goal_text(example.state.goal),
        "position": write_values(example.state.position),
        "agents": [
            _view(view, profile.policy(view.agent).tree) | {"code": _code(profile, result, view)}
            for view in example.agents
        ],
        "replayed_by": list(example.replayed),
        **real,
        "explanation": None if explanation is None else explanation.document(),
        "picture": picture(profile, example) if profile.world.agents else None,
    }


def deployed_facts(example: Counterexample) -> dict[str, Any] | None:
    """Returns what the deployed arithmetic does in a real counterexample; None where it is no float64 state."""
    return None if example.deployed is None else asdict(example.deployed)


def _code(profile: PolicyProfile, result: DecisionResult, view: AgentView) -> dict[str, Any] | None:
    """The lines of a decision in the header of the profile that is compiled, which is never a view."""
    from verify.reports.code import code_of  # which imports the compiler

    nodes = [*(step.node for step in view.path), view.leaf]
    if result.viewed is None:
        return code_of(profile, view.agent, nodes)
    return code_of(result.viewed.origin, result.viewed.view.original(view.agent), nodes)


def _view(view: AgentView, tree: Tree) -> dict[str, Any]:
    steps = [
        {
            "node": step.node,
            "test": str(step),
            "feature": step.feature,
            "others": len(leaves_below(tree, int((tree.right if step.left else tree.left)[step.node]))),
            "value": write_value(step.value),
            "threshold": step.threshold,
            "left": step.left,
        }
        for step in view.path
    ]
    return {
        "agent": view.agent,
        "action": view.action,
        "leaf": view.leaf,
        "engaged_with": list(view.engaged_with),
        "errors": write_values(dict(view.errors)),
        "path": steps,
    }


def picture(profile: PolicyProfile, example: Counterexample) -> dict[str, Any]:
    """Returns what to draw, in picture coordinates: landmarks, agents, and an arrow for each chosen action."""
    state = {name: float(value) for name, value in example.state.position.items()}
    entities = [entity.name for entity in profile.world.agents + profile.world.landmarks]
    ends = [[min(values), max(values)] for values in ([state[f"{name}.{axis}"] for name in entities] for axis in "xy")]
    middle_x, middle_y = ((low + high) / 2 for low, high in ends)
    reach = max(NEAREST, *((high - low) / 2 for low, high in ends)) + WORLD_MARGIN
    scale = VIEW / (2 * reach)

    def place(name: str) -> tuple[float, float]:
        x, y = state[f"{name}.x"] - middle_x, state[f"{name}.y"] - middle_y
        return round((x + reach) * scale, 2), round((reach - y) * scale, 2)

    team = {view.agent: view for view in example.agents}
    taken: list[tuple[float, float, float, float]] = []  # rectangles of marks, arrows and labels
    agents: list[dict[str, Any]] = []
    for entity in profile.world.agents:
        x, y = place(entity.name)
        mark: dict[str, Any] = {"name": entity.name, "x": x, "y": y, "ours": entity.name in team, "arrow": None}
        if entity.name in team:
            chosen = team[entity.name].action
            effect = next(action.effect for action in profile.policy(entity.name).actions if action.name == chosen)
            if effect is not None and any(effect):
                tip_x, tip_y = x + effect[0] * ARROW, y - effect[1] * ARROW
                mark["arrow"] = [round(tip_x, 2), round(tip_y, 2)]
                taken += [around(tip_x, tip_y, MARK), around((x + tip_x) / 2, (y + tip_y) / 2, MARK)]
        agents.append(mark)
        taken.append(around(x, y, MARK))
    landmarks: list[dict[str, Any]] = []
    for entity in profile.world.landmarks:
        x, y = place(entity.name)
        landmarks.append({"name": entity.name, "x": x, "y": y, "goal": entity.name == example.state.goal})
        taken.append(around(x, y, MARK))
    for mark in (*agents, *landmarks):
        mark["label"] = mark["name"] + (" (goal)" if mark.get("goal") else "")
        mark["label_x"], mark["label_y"] = label_place(mark, taken)
    return {"size": VIEW, "agents": agents, "landmarks": landmarks}


LEAF_WORDS = {"PROVED": "reached", "VIOLATED": "dead", "UNKNOWN": "open"}


def words(result: DecisionResult, told: Mapping[str, Any]) -> list[str]:
    """The first lines of a result for a terminal, from its facts."""
    if not result.claim.per_state:
        return [*_tell_leaves(told["leaves"]), told["reason"]]
    return [
        f"{_tell_shares(told)}, shuffled leaves: {told.get('shuffled_leaves') or 'SKIPPED'}",
        told["reason"],
        told.get("alone", ""),
        *([f"errors can change an action in {format_share(told['changing'])}"] if told.get("changing") else []),
        *([f"stays proved up to margin {told['largest_margin']['proved']}"] if told.get("largest_margin") else []),
        *([f"stays proved up to eps {told['largest_eps']['proved']}"] if "largest_eps" in told else []),
        *([f"counterexample: {_tell_agents(told)}"] if told.get("counterexample") else []),
    ]


def _tell_leaves(leaves: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    for verdict, said in LEAF_WORDS.items():
        found = [f"{leaf['agent']} leaf {leaf['leaf']}" for leaf in leaves if leaf["verdict"] == verdict]
        named = f": {', '.join(found)}" if verdict != "PROVED" else ""
        yield from [f"{len(found)} of {len(leaves)} leaves {said}{named}"] if found else []


def _tell_shares(told: Mapping[str, Any]) -> str:
    if "unmeasured" in told:
        return f"no shares: {told['unmeasured']}"
    conflict = format_share(told["conflict"]) if told["conflict"] else "not measured (too many joint actions)"
    exact = told.get("where", {}).get("exact")
    violating = f"{percent(exact['share'])} exactly" if exact else format_share(told["violating"])
    return f"conflict share {conflict}, violating {violating}"


def _tell_agents(told: Mapping[str, Any]) -> str:
    """Who does what in the counterexample."""
    does = "takes" if "observations" in told else "goes"
    acts = [f"{agent['agent']} {does} {agent['action']}" for agent in told["counterexample"]["agents"]]
    if told["landmarks"]:
        near = [", ".join(agent["engaged_with"]) or "no landmark" for agent in told["counterexample"]["agents"]]
        acts = [f"{act}, engaged with {marks}" for act, marks in zip(acts, near, strict=True)]
    return "; ".join(acts)


TELLING = Telling(facts, limits, (WITH_CERTIFICATE, WITHOUT_CERTIFICATE), words=words)
