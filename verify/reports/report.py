"""The report of a verification: one set of facts, shown as JSON, text and one self-contained HTML page.

Does: collects what was claimed, where, the verdicts and their evidence; draws counterexamples.
Assumes: results of `engine.verify`; commands and hashes of other files are given by the caller.
Does not: contain times, paths or facts about the machine, so equal questions give equal reports.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from codegen.dynamics import partners
from codegen.errors import visible
from codegen.floats import FLOAT32
from codegen.ir import NO_FEATURE, PolicyProfile, Tree
from codegen.json_layout import layout
from codegen.lowering.render import render
from codegen.paths import leaves_below
from codegen.policy_json import content_hash
from verify.checker.thresholds import AT_ONCE
from verify.claims.decisions import formula
from verify.claims.formula_json import formula_document
from verify.claims.region import MACHINE, REAL, Kind, Parameter, Verdict, called, goal_text, plain
from verify.claims.region import text as decimal
from verify.counterexamples.search import AgentView, Counterexample
from verify.reports import trusted
from verify.reports.drawing import MARK, VIEW, around, drawn, label_place
from verify.solver.leaves import LeafFinding
from verify.states import shares
from verify.states.real import written, written_all
from verify.verdicts.decisions import Result
from verify.verdicts.margins import Margin

if TYPE_CHECKING:
    from verify.verdicts.episodes import EpisodeResult

NO_PAGE = "no page plays them: agents compare float64 numbers"
SEMANTICS = (
    "Verdicts are about the deployed arithmetic. Each observation is a float32, made from float64 positions by one "
    "subtraction and one rounding. A split goes left iff x <= threshold. With the rounding, this is true exactly on a "
    "half line of the unrounded difference. The engines use the exact end of this half line in place of the threshold. "
    "So a proof over real positions is a proof for the deployed arithmetic. A counterexample is a float64 world state "
    "that was replayed."
)
DOUBLES = "Agents that compare float64 ({agents}): what they observe is not rounded to float32."
LONG_SUMS = (
    "A sum of more than two coordinates is rounded after each addition. For such tests Z3 takes the exact sum and an "
    "unknown of bounded size, so a proof covers every rounding."
)
REAL_SEMANTICS = (
    "Verdicts are about real arithmetic, not the deployed one: a split compares the exact coordinate or difference "
    "with the threshold as it is written. A proof says nothing about what rounding does at thresholds. A "
    "counterexample is judged in exact arithmetic. It is a float64 world state if one was found, preferably one in "
    "which the claim fails in the deployed arithmetic too. Otherwise its coordinates are rationals, written as "
    "fractions. The report says what the deployed arithmetic does there."
)
SINGLE = "The claim is about single decisions in world states of the region: it does not say that agents arrive."
POSITIONS = "Positions are finite float64. Agents may leave the region during an episode (see the on-policy states)."
REAL_POSITIONS = "Positions are real numbers. Agents may leave the region during an episode (see the on-policy states)."
LIMITS = (
    "Shares are estimated from uniform samples, with 95 % Wilson intervals. The verdict does not depend on them.",
)
REAL_SHARES = (
    "In real arithmetic, shares are estimated from float64 states in which agents decide by exact measurements. "
    "States within a rounding error of the bounds of region or claim may be misjudged."
)
OBSERVED = (
    "Claims are over observations. Each observed number is a finite float64 number of the region. The agent reads it "
    "after rounding to float32; in real arithmetic it is read as it is. Observations that are given as float32 are "
    "among these. A split goes left iff x <= threshold. The engines use the exact end of the half line on which this "
    "is true after rounding."
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
WORLD_MARGIN = 0.25
NEAREST = 0.25  # least half side of what a picture shows, its margin aside: length units
ARROW = 34  # picture units
MEANINGS = {
    Verdict.PROVED: "holds in every world state of the region",
    Verdict.VIOLATED: "fails in the world state shown, which was replayed",
    Verdict.VACUOUS: "no world state lies in the region and meets the assumptions, so nothing was claimed",
    Verdict.UNKNOWN: "no answer",
    Verdict.SKIPPED: "not asked",
}


def document(
    profile: PolicyProfile,
    results: Sequence[Result | EpisodeResult],
    commands: Sequence[str],
    files: Mapping[str, str] | None = None,
) -> dict[str, Any]:
    """All facts as plain data. `commands`: what repeats each result; `files`: name -> SHA-256 of files made with it."""
    single = [result for result in results if result.kind is not Kind.EPISODES]
    observing = any(result.viewed is not None for result in results)
    episodes = [result for result in results if result.kind is Kind.EPISODES]
    known = all(result.visited is not None for result in single) and all(result.replays for result in episodes)
    kinds = [REAL] if single and all(one.semantics == REAL for one in single) else [MACHINE]
    if kinds == [REAL] and episodes:  # of episodes nothing is asked in real arithmetic
        kinds = [MACHINE, REAL]
    touching = bool(partners(profile.world))
    limits = [*_limits(single), *(_loop_limits(touching) if episodes else ())]
    double = ", ".join(policy.agent for policy in profile.agents if policy.numbers != FLOAT32)
    doubled = [DOUBLES.format(agents=double)] if double and MACHINE in kinds else []
    replayed = [{MACHINE: trusted.REPLAYED, REAL: trusted.REFEREED}[kind] for kind in kinds]
    return {
        "report": "maviper-verification-1",
        "profile": content_hash(profile),
        "world": {"name": profile.world.name, "reference": profile.world.reference},
        **({"no_page": NO_PAGE} if any(policy.numbers != FLOAT32 for policy in profile.agents) else {}),
        "provenance": {
            "algorithm": profile.provenance.algorithm,
            "preset": profile.provenance.preset,
            "seed": profile.provenance.seed,
            "expert": profile.provenance.expert,
            "tool": profile.provenance.tool,
        },
        "evaluation": dict(profile.provenance.evaluation),
        "files": dict(files or {}),
        "results": [result_facts(profile, result, command) for result, command in zip(results, commands, strict=True)],
        "semantics": " ".join(
            [*([OBSERVED] if observing else [_semantics(profile, kind) for kind in kinds]), *doubled]
        ),
        "trusted": trusted.texts(None if observing else known, bool(single), bool(episodes), replayed),
        "limits": limits,
    }


def result_facts(profile: PolicyProfile, result: Result | EpisodeResult, command: str) -> dict[str, Any]:
    """One result as plain data, as it stands in the document."""
    about = profile if result.viewed is None else result.viewed.profile
    of_start = {"of_start": shares.of_start(about, result.region)}
    if result.kind is Kind.EPISODES:
        from verify.reports import episodes as loop_report

        return loop_report.result_facts(profile, result, command) | of_start
    return _result(about, result, command) | of_start


def _loop_limits(touching: bool) -> list[str]:
    from verify.reports import episodes as loop_report

    return [*loop_report.LIMITS, *(loop_report.CONTACTS if touching else ())]


def _semantics(profile: PolicyProfile, kind: str) -> str:
    """What an arithmetic means for a profile's tests."""
    if kind == REAL:
        return REAL_SEMANTICS
    tested = [p.features[int(place)].meaning for p in profile.agents for place in p.tree.feature if place != NO_FEATURE]
    long = any(meaning is not None and len(meaning.terms) > AT_ONCE for meaning in tested)
    return f"{SEMANTICS} {LONG_SUMS}" if long else SEMANTICS


def _limits(results: Sequence[Result]) -> list[str]:
    real = any(result.semantics == REAL for result in results)
    if any(result.viewed is not None for result in results):
        found = [OBSERVED_STATES, *LIMITS]
    else:
        found = [*([SINGLE] if results else []), REAL_POSITIONS if real else POSITIONS, *LIMITS]
    found += [REAL_SHARES] if real else []
    if any(result.claim.assumption for result in results):
        found.append(ASSUMING)
    if any(result.claim.eps for result in results):
        found.append(NOISE)
    return found


def _result(profile: PolicyProfile, result: Result, command: str) -> dict[str, Any]:
    claim, measured = result.claim, result.shares
    found = result.counterexample
    return {
        "kind": claim.kind.value,
        "property": claim.name,
        "label": claim.label,
        "team": claim.team,
        **({} if result.viewed is None else {"observations": str(result.viewed.view)}),
        "claim": _told(result, claim.sentence),
        "landmarks": shares.about_landmarks(profile, formula(profile, claim)),
        "formula": claim.written.strip(),
        "data": None if result.kind is Kind.LEAVES else formula_document(formula(profile, claim)),
        "assumption": claim.assumption.strip(),
        "parameters": {name: _shown(value, name) for name, value in claim.parameters.items()},
        "semantics": result.semantics,
        "region_name": called(profile, result.region),
        "region": result.region.document(),
        "verdict": result.verdict.value,
        "meaning": _told(result, _meaning(result)),
        "reason": result.reason,
        "conflict": None if measured.conflict is None else measured.conflict.document(),
        "contested": None if measured.contested is None else measured.contested.document(),
        "violating": measured.violating.document(),
        "changing": None if measured.changing is None else measured.changing.document(),
        "largest_margin": None if result.largest is None else _margin(result.largest),
        **({} if result.steady_up_to is None else {"largest_eps": _margin(result.steady_up_to)}),
        "leaves": [_leaf(finding) for finding in result.leaves],
        "visited": None if result.visited is None else asdict(result.visited),
        "shuffled_control": result.control.value,
        "replays": ["reference", *result.replays],
        "replays_skipped": list(result.skipped),
        "solver": result.solver,
        "resources": result.resources,
        "budget": result.budget,
        "engines": [asdict(opinion) | {"verdict": opinion.verdict.value} for opinion in result.engines],
        **({"alone": _alone(result.alone)} if result.alone else {}),
        "certificate": None if result.certificate is None else _certificate(result),
        "counterexample": None if found is None else _counterexample(profile, result, found),
        "command": command,
    } | ({} if result.where is None else _where(profile, result))


def _where(profile: PolicyProfile, result: Result) -> dict[str, Any]:
    from verify.reports.where import where_facts  # imported here, as few ask where

    return {"where": where_facts(profile, result)}


def _told(result: Result, text: str) -> str:
    """Words about a result: over observations, of these and of no world states."""
    return text if result.viewed is None else text.replace("world state", "observation")


def _alone(reason: str) -> str:
    return f"Z3 decides alone, without a second engine or a certificate: {reason}"


def _meaning(result: Result) -> str:
    """The verdict in words."""
    meanings = LEAVES_MEANINGS if result.kind is Kind.LEAVES else REAL_MEANINGS if result.semantics == REAL else {}
    return meanings.get(result.verdict, MEANINGS[result.verdict])


def _shown(value: Parameter, name: str) -> str:
    """A parameter as text."""
    if isinstance(value, Fraction):
        return plain(value)
    usual = "in the profile's order" if name == "order" else "in the world's order"
    return (", ".join(value) or usual) if isinstance(value, tuple) else str(value)


def _margin(found: Margin) -> dict[str, Any]:
    failed = None if found.failed is None else decimal(found.failed)
    return {"proved": decimal(found.proved), "not_proved": failed, "questions": found.questions}


def _leaf(finding: LeafFinding) -> dict[str, Any]:
    witness = finding.witness
    state = None if witness is None else {"goal": goal_text(witness.goal), "position": written_all(witness.position)}
    verdict = finding.verdict.value
    return {"agent": finding.agent, "leaf": finding.leaf, "action": finding.action, "verdict": verdict, "state": state}


def _certificate(result: Result) -> dict[str, Any]:
    assert result.certificate is not None
    return {"bytes": result.certificate.size, "branches": result.branches, "checker": "accepted"}


def _counterexample(profile: PolicyProfile, result: Result, found: Counterexample) -> dict[str, Any]:
    real = {} if result.semantics == MACHINE else {"judged": found.says, "deployed": deployed_facts(found)}
    return {
        "goal": goal_text(found.state.goal),
        "position": written_all(found.state.position),
        "agents": [
            _view(view, profile.policy(view.agent).tree) | {"code": _code(profile, result, view)}
            for view in found.agents
        ],
        "replayed_by": list(found.replayed),
        **real,
        "explanation": None if result.explanation is None else result.explanation.document(),
        "picture": picture(profile, found) if profile.world.agents else None,
    }


def deployed_facts(found: Counterexample) -> dict[str, Any] | None:
    """What the deployed arithmetic does in a counterexample of real arithmetic; None where it is no float64 state."""
    return None if found.deployed is None else asdict(found.deployed)


def _code(profile: PolicyProfile, result: Result, view: AgentView) -> dict[str, Any] | None:
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
            "value": written(step.value),
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
        "errors": written_all(dict(view.errors)),
        "path": steps,
    }


def picture(profile: PolicyProfile, found: Counterexample) -> dict[str, Any]:
    """What to draw, in picture coordinates: landmarks, agents, and an arrow for each chosen action."""
    state = {name: float(value) for name, value in found.state.position.items()}
    entities = [entity.name for entity in profile.world.agents + profile.world.landmarks]
    ends = [[min(values), max(values)] for values in ([state[f"{name}.{axis}"] for name in entities] for axis in "xy")]
    middle_x, middle_y = ((low + high) / 2 for low, high in ends)
    reach = max(NEAREST, *((high - low) / 2 for low, high in ends)) + WORLD_MARGIN
    scale = VIEW / (2 * reach)

    def place(name: str) -> tuple[float, float]:
        x, y = state[f"{name}.x"] - middle_x, state[f"{name}.y"] - middle_y
        return round((x + reach) * scale, 2), round((reach - y) * scale, 2)

    team = {view.agent: view for view in found.agents}
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
        landmarks.append({"name": entity.name, "x": x, "y": y, "goal": entity.name == found.state.goal})
        taken.append(around(x, y, MARK))
    for mark in (*agents, *landmarks):
        mark["label"] = mark["name"] + (" (goal)" if mark.get("goal") else "")
        mark["label_x"], mark["label_y"] = label_place(mark, taken)
    return {"size": VIEW, "agents": agents, "landmarks": landmarks}


def as_json(facts: Mapping[str, Any]) -> str:
    """The report as JSON text."""
    return layout(dict(facts)) + "\n"


def as_text(facts: Mapping[str, Any]) -> str:
    """The report as plain text; what a terminal would not print as it stands is escaped."""
    return "\n".join(map(visible, render("report/report.txt.j2", **facts).split("\n")))


def as_html(facts: Mapping[str, Any]) -> str:
    """The report as one HTML page: inline styles and drawings, no scripts, nothing loaded from elsewhere."""
    return render("report/report.html.j2", **{**facts, "results": [drawn(result) for result in facts["results"]]})
