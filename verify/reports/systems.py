"""Verdicts about a stated system, as plain data and as text.

Does: the document of a report, and its lines.
Assumes: results of verify/reach.
Does not: decide or measure.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from math import isfinite
from typing import Any

from codegen.floats import nearest_double, rational_literal
from codegen.ir import PolicyProfile
from codegen.lowering.render import brief
from codegen.policy_json import content_hash
from verify.claims.region import Verdict
from verify.reach.results import Counterexample, SystemResult
from verify.systems import documents
from verify.systems.system import System

FORM = "maviper-system-verification-1"
SHOWN = 8  # variables of a state in a line


def document(
    profile: PolicyProfile, system: System, results: Sequence[SystemResult], reference: Mapping[str, Any]
) -> dict[str, Any]:
    """All that is known. `reference`: what was measured of the environment that the statement is about, if one was."""
    return {
        "report": FORM,
        "profile": content_hash(profile),
        "system": documents.content_hash(system),
        "name": system.name,
        "of": sentence(system),
        "errors": {name: brief(error) for name, error in largest_errors(system).items()},
        "reference": dict(reference),
        "results": [facts(result) for result in results],
    }


def sentence(system: System) -> str:
    """What verdicts are about."""
    if not system.pieces:
        return "of single decisions; no dynamics are stated"
    errors = largest_errors(system)
    if not any(errors.values()):
        return "of the stated dynamics, exactly"
    told = ", ".join(f"{name} {brief(error)}" for name, error in errors.items() if error)
    return f"of the stated dynamics, with an error of at most e a step: {told}"


def largest_errors(system: System) -> dict[str, float]:
    """By how much each variable may be off in a step at most, enclosures included."""
    return {
        each.name: max((float(max(map(abs, piece.error.get(each.name, (0, 0))))) for piece in system.pieces), default=0)
        for each in system.variables
    }


def facts(result: SystemResult) -> dict[str, Any]:
    """One result."""
    found: dict[str, Any] = {
        "property": result.claim.shown,
        "name": result.claim.name,
        "sentence": result.claim.sentence,
        "verdict": result.verdict.value,
        "reason": result.reason,
        "symbolic_states": result.states,
        "linear_programs": result.programs,
    }
    if result.certificate is not None:
        found["proof_bytes"] = result.certificate.size
    if result.counterexample is not None:
        found["counterexample"] = counterexample(result.counterexample)
    return found


def counterexample(found: Counterexample) -> dict[str, Any]:
    """An episode as plain data: exact numbers as texts, the start as float64 numbers too."""
    agents = list(found.actions[0]) if found.actions else []
    return {
        "step": found.step,
        "start": {name: rational_literal(value) for name, value in found.start.items()},
        "start_float64": found.start_as_doubles,
        "broken": {name: _number(value) for name, value in found.states[-1].items()},
        "actions": {agent: [joint[agent] for joint in found.actions] for agent in agents},
        "errors": [{name: rational_literal(value) for name, value in each.items()} for each in found.errors],
        "pieces": list(found.pieces),
    }


def _number(exact: Fraction) -> float | str:
    """The nearest float64, or in words that there is none near."""
    found = nearest_double(exact)
    return found if isfinite(found) else "above 1.79e308" if found > 0 else "below -1.79e308"


def lines(told: Mapping[str, Any]) -> list[str]:
    """What a person reads of one result, below its verdict."""
    found = [told["sentence"]]
    if told["reason"]:
        found.append(told["reason"])
    if "counterexample" in told:
        broken = told["counterexample"]
        found.append(f"from {_state(broken['start_float64'])}")
        if broken["actions"]:
            found += [f"{agent}: {' '.join(actions)}" for agent, actions in broken["actions"].items()]
            found.append(f"at step {broken['step']}: {_state(broken['broken'])}")
        if "replay" in broken:
            found.append(broken["replay"])
    if told["verdict"] == Verdict.PROVED.value:
        found.append(f"{told['symbolic_states']} symbolic states, {told['proof_bytes']} bytes of proof")
    return found


def _state(state: Mapping[str, float | str]) -> str:
    shown = [f"{name} {brief(value)}" for name, value in state.items()]
    return ", ".join(shown[:SHOWN]) + (", ..." if len(shown) > SHOWN else "")


def as_text(told: Mapping[str, Any]) -> str:
    """The report as text."""
    found = [f"{told['name']}: verdicts {told['of']}", *told["reference"].get("said", [])]
    for number, each in enumerate(told["results"], 1):
        found += ["", f"{number}. {each['verdict']}  {each['property']}", *(f"   {line}" for line in lines(each))]
    return "\n".join(found) + "\n"
