"""The report about a stated system: one set of facts, shown as JSON, text and one self-contained HTML page.

Does: collects what is stated and claimed, the verdicts and their evidence; words them, also of continuous time, with
  errors rounded so that a bound stays one.
Assumes: results of verify/reach; commands and what was measured are given by the caller.
Does not: decide or measure. It holds no times, paths or facts about the machine.
"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from decimal import ROUND_CEILING, ROUND_FLOOR, Context, Decimal
from fractions import Fraction
from typing import Any

from codegen.deciding import name_with_updates
from codegen.form import layout
from codegen.ir import PolicyProfile
from codegen.lowering.render import brief, render
from codegen.policy_json import content_hash
from codegen.wording import format_count, visible
from verify.certificates.proofs import count_bytes
from verify.certificates.proofs import plain as as_plain
from verify.checker.systems.proofs import Cover, FlowSets, Invariant, SystemProof, Walks
from verify.claims.wording import spell_rounded
from verify.decimals import plain
from verify.language.units import unit_of
from verify.reports.courses import (
    DECISIONS,
    counterexample,
    draw_courses,
    in_modes,
    is_still,
    list_taken,
    moment,
    nearness,
    number,
    runs,
    tell_closely,
    tell_end,
    tell_start,
    within,
)
from verify.reports.report import NOWHERE, WEAK, Telling, describe_sets, readers, rests_on, sets
from verify.result import Result, Verdict
from verify.subjects import ClosedLoop, Subject
from verify.systems import documents
from verify.systems.claims import Pattern, SystemClaim
from verify.systems.enclosures import list_curved
from verify.systems.expressions import Number
from verify.systems.statement import Statement
from verify.systems.system import Flow, HalfSpace, Interval, Polytope, System, bounds_of

FORM = "maviper-system-verification-1"
SHOWN = 8  # variables of a state in a line
MEANINGS = {
    Verdict.PROVED: "holds in every episode, from every start and for all errors within their bounds",
    Verdict.VIOLATED: "fails in the episode shown, which was replayed in exact numbers",
    Verdict.VACUOUS: "the claim applies to no state",
    Verdict.UNKNOWN: "no answer",
}
OF_DECISIONS = {
    Verdict.PROVED: "holds in every such state",
    Verdict.VIOLATED: "fails in the state shown, which was judged in exact numbers",
}
SEMANTICS = (
    "A state is an exact number for each variable. In a step, the next value of a variable is what the rule of the "
    "world file gives for the state and the actions, and an error anywhere within its bounds is added. An agent "
    "observes the exact value of each feature, rounded once to what it compares, float32 or float64. A split goes left "
    "iff x <= threshold. The engines use the exact end of the half line on which this is true after rounding."
)
ENCLOSED = (
    "Rules that are not affine are enclosed: over parts of the ranges, an affine form stands for them, and the proved "
    "bound of what it leaves out is part of the error."
)
GIVEN = (
    "What an agent adds in floats is its exact value and a rounding within proved bounds, which is a variable of its "
    "own (AGENT.rounding_of_...) and may be another one at each step. A leaf that gives numbers is an action."
)
STATEMENT = "Verdicts are about the statement. Nothing is proved about a system that moves differently."
SAMPLED = "Steps of {name} were compared with the statement, from states {where}. At others it may be off by more."
ANYWHERE = {True: "all over the ranges", False: "that its own episodes come to"}
STEPS = "A claim about episodes covers only the steps that it names{ever}."
EVER = "; one for ever covers any number of them"
OUTSIDE = "Outside the boxes of all pieces nothing is stated. A claim is not proved if an episode may leave the boxes."
SINGLE = "A claim about single decisions does not say that an episode gets into such a state."


def certificate_name(place: int, claim: SystemClaim) -> str:
    """The file of a claim's certificate; claims are counted from 1."""
    return f"certificate-{place}-{claim.name}.json"


def counterexample_name(place: int, claim: SystemClaim) -> str:
    """The file of a claim's counterexample; claims are counted from 1."""
    return f"counterexample-{place}-{claim.name}.json"


def document(
    profile: PolicyProfile,
    statement: Statement,
    results: Sequence[Result[SystemClaim, Any]],
    reference: Mapping[str, Any],
    command: str,
) -> dict[str, Any]:
    """All that is known. `reference`: what was measured of the environment that the statement is about, if one was;
    `command`: what asks the same again.
    """
    system, made = statement.system, profile.provenance
    enclosed = any(map(list_curved, statement.rules)) or any(result.claim.curved for result in results)
    semantics = f"{SEMANTICS} {ENCLOSED}" if enclosed else SEMANTICS
    semantics = f"{semantics} {GIVEN}" if statement.acting else semantics
    certificates = [result.evidence.certificate for result in results]
    counted = {name_units(certificate.proof)[1] for certificate in certificates if certificate}
    errors, claims = _errors(system), [result.claim for result in results]
    limits, kinds = [STATEMENT], {claim.about_decisions for claim in claims}
    if reference.get("steps"):
        limits.append(SAMPLED.format(name=reference["name"], where=ANYWHERE[reference["anywhere"]]))
    ever = EVER if any(claim.says.ever for claim in claims) else ""
    limits += [STEPS.format(ever=ever) if system.flow is None else PERIODS] if False in kinds else []
    limits += [] if system.flow is None else [ONE_READING]
    limits += [OUTSIDE] if False in kinds and system.pieces and all(piece.where for piece in system.pieces) else []
    limits += [SINGLE] if True in kinds else []
    return {
        "report": FORM,
        "profile": content_hash(profile),
        "system": documents.content_hash(system),
        "name": system.name,
        "of": sentence(system),
        "provenance": {name: getattr(made, name) for name in ("algorithm", "preset", "seed", "expert", "tool")},
        "agents": [policy.agent for policy in profile.agents],
        "steps": system.steps,
        "dt": period(statement),
        "pieces": len(system.pieces),
        "variables": [
            {
                "name": each.name,
                "unit": each.unit,
                "range": list(map(plain, each.range)),
                **({"modes": list(each.modes)} if each.modes else {}),
                "error": list(map(plain, errors[each.name])),
            }
            for each in system.variables
        ],
        "start": region_facts(system.start),
        "reference": dict(reference),
        "results": [facts(result, place) for place, result in enumerate(results, 1)],
        "command": command,
        "semantics": semantics if system.flow is None else OF_FLOWS,
        "trusted": [*rests_on(enclosed, counted, system.flow is not None), *readers(profile)],
        "limits": limits,
    }


def name_units(proof: SystemProof) -> tuple[str, str]:
    """Names the units that are counted when a proof is checked: one of these, and many."""
    match proof:
        case Walks():
            return "branch", "branches"
        case Cover(sets="forms"):
            return "form", "forms"
        case Cover():
            return "box", "boxes"
        case FlowSets():
            return "set", "sets"
        case Invariant():
            return "cell", "cells"


def _tell_proof(proof: SystemProof) -> dict[str, Any]:
    """Returns the facts that a report gives of a proof beside its size."""
    match proof:
        case Walks(parts):
            return {"parts": [list(part.followed) for part in parts]}
        case Cover(sets="forms"):
            return {}
        case Cover(cells):
            return {"cells": as_plain(cells)}
        case FlowSets(order, steps, cells):
            levels = {"joined_every": proof.joined_every, "levels": proof.levels} if proof.levels else {}
            return {"order": order, "steps_of_a_period": steps, "cells": as_plain(cells), **levels}
        case Invariant(parts):
            return {"parts": [part.followed for part in parts], "steps": [part.steps for part in parts]}


def period(statement: Statement) -> str | None:
    """The seconds of a step as an exact text, where the file states them as `dt` or as the period of a flow."""
    if statement.system.flow is not None:
        return plain(statement.system.flow.period)
    stated = statement.names.meant.get("dt")
    if stated is None or stated.unit != unit_of("s", "") or not isinstance(stated.value, Number):
        return None
    return plain(stated.value.value)


def sentence(system: System) -> str:
    """Describes what verdicts are about."""
    if system.flow is not None:
        return flow_sentence(system.flow)
    if not system.pieces:
        return "of single decisions; no dynamics are stated"
    errors = {name: max(map(abs, bounds)) for name, bounds in _errors(system).items()}
    if not any(errors.values()):
        return "of the stated dynamics, exactly"
    told = ", ".join(f"{name} {upwards(error)}" for name, error in errors.items() if error)
    return f"of the stated dynamics, with a per-step error of at most {told}"


def _errors(system: System) -> dict[str, Interval]:
    """By how much each variable may be off in a step, enclosures included."""
    errors: dict[str, Interval] = {}
    for each in system.variables:
        bounds = [piece.error.get(each.name, (Fraction(0), Fraction(0))) for piece in system.pieces]
        lows, highs = [low for low, _ in bounds], [high for _, high in bounds]
        errors[each.name] = min(lows, default=Fraction(0)), max(highs, default=Fraction(0))
    return errors


def region_facts(region: Polytope) -> dict[str, Any]:
    """A polytope: bounds of single variables, and all else as conditions; numbers are exact texts."""
    box: dict[str, list[Fraction | None]] = {}
    conditions: list[str] = []
    for half in region:
        if len(half.form.terms) != 1 or half.strict:
            conditions.append(_condition(half))
            continue
        ((name, factor),) = half.form.terms
        end, side = -half.form.constant / factor, int(factor > 0)
        ends = box.setdefault(name, [None, None])
        known = ends[side]
        ends[side] = end if known is None else min(known, end) if side else max(known, end)
    bounds = {name: [None if end is None else plain(end) for end in ends] for name, ends in box.items()}
    return {"box": bounds, "conditions": conditions}


def _condition(half: HalfSpace) -> str:
    """An inequality between variables in words."""
    told = ""
    for name, factor in half.form.terms:
        times = "" if abs(factor) == 1 else f"{plain(abs(factor))}*"
        sign = (" - " if told else "-") if factor < 0 else " + " if told else ""
        told += f"{sign}{times}{name}"
    return f"{told or '0'} {'<' if half.strict else '<='} {plain(-half.form.constant)}"


def facts(result: Result[SystemClaim, Any], place: int) -> dict[str, Any]:
    """One result; claims are counted from 1."""
    claim, evidence = result.claim, result.evidence
    certificate = evidence.certificate
    meanings = MEANINGS | (OF_DECISIONS if claim.about_decisions else {})
    meanings |= {Verdict.VIOLATED: FOLLOWED} if claim.at_samples is not None else {}
    document: dict[str, Any] = {
        "kind": DECISIONS if claim.about_decisions else "episodes",
        "property": claim.shown,
        "name": claim.name,
        "label": claim.label,
        "sentence": claim.sentence,
        "formula": claim.written.strip(),
        **({"numbers": spell_rounded(claim.rounded)} if claim.rounded else {}),
        "regions": list(map(region_facts, claim.regions)),
        "steps": claim.steps,
        "by": claim.by,
        **({"assuming": list(map(region_facts, claim.assuming))} if claim.assuming else {}),
        **({"invariant": list(map(region_facts, claim.invariant))} if claim.invariant else {}),
        "verdict": result.verdict.value,
        **({"note": NOWHERE} if result.verdict is Verdict.PROVED and _avoids_nothing(result) else {}),
        "meaning": meanings[result.verdict],
        "reason": result.reason,
        "boxes": evidence.boxes,
        "symbolic_states": result.cost.spent,
        "linear_programs": evidence.programs,
        "shuffled_control": evidence.control.verdict.value,
        "shuffled_leaves": evidence.control.words,
        "engines": [opinion.document() for opinion in evidence.opinions],
    }
    if evidence.open is not None:
        document["open"] = {
            "step": evidence.open.step,
            "bounds": {name: [number(end) for end in ends] for name, ends in evidence.open.bounds.items()},
        }
    if evidence.approach is not None:
        approach = asdict(evidence.approach)
        document["approach"] = {name: value for name, value in approach.items() if name != "played" or value}
    if evidence.helps:
        document["helps"] = list(evidence.helps)
    if certificate is not None:
        document["certificate"] = {
            "file": certificate_name(place, claim),
            "bytes": count_bytes(certificate.proof),
            **_tell_proof(certificate.proof),
            name_units(certificate.proof)[1]: evidence.branches,
            "checker": "accepted",
        }
    if evidence.counterexample is not None:
        shown = evidence.counterexample
        closely = tell_closely(result.question.subject, claim, shown)
        document["counterexample"] = {"file": counterexample_name(place, claim)} | counterexample(shown) | closely
    return (
        document
        | _modes(result.question.subject, document)
        | _updates(result.question.subject, document)
        | {
            key: said
            for key, said in (
                ("replay", evidence.environment),
                ("rounding", evidence.rounding),
                ("reused", evidence.reused),
            )
            if said
        }
    )


def _avoids_nothing(result: Result[SystemClaim, Any]) -> bool:
    """Returns True if a claim avoids regions that are, by their bounds alone, outside the ranges of the variables."""
    assert isinstance(result.question.subject, ClosedLoop)
    ranges = {each.name: each.range for each in result.question.subject.system.variables}
    bounds = [bounds_of(region, ranges).values() for region in result.claim.regions]
    return result.claim.says.avoided and all(any(low > high for low, high in each) for each in bounds)


def _modes(subject: Subject, document: Mapping[str, Any]) -> dict[str, Any]:
    """The names of modes, where the result tells states."""
    assert isinstance(subject, ClosedLoop)
    modes = {one.name: list(one.modes) for one in subject.system.variables if one.modes}
    return {"modes": modes} if modes and {"open", "counterexample"} & document.keys() else {}


def _updates(subject: Subject, document: Mapping[str, Any]) -> dict[str, Any]:
    """By agent, the words for actions that change what is remembered, where a counterexample tells them."""
    assert isinstance(subject, ClosedLoop)
    words = {
        policy.agent: {each.name: name_with_updates(each) for each in policy.actions if each.updates}
        for policy in subject.profile.agents
    }
    words = {agent: each for agent, each in words.items() if each}
    return {"updates": words} if words and "counterexample" in document else {}


# --- words


def lines(told: Mapping[str, Any]) -> list[str]:
    """Returns the lines that a person reads of one result, below its verdict."""
    written = [told["sentence"], *told["formula"].split("\n")] if told["formula"] else [told["sentence"]]
    if told["reason"]:
        written.append(told["reason"])
    written += [told["note"]] if "note" in told else []
    written += _open(told)
    if "counterexample" in told:
        broken = told["counterexample"]
        written.append(f"{'in' if is_still(told) else 'from'} {_state(tell_start(told), told)}")
        written += [f"{agent}: {taken}" for agent, taken in list_taken(told).items()]
        written += [f"choice of {name}: {runs(taken)}" for name, taken in broken.get("choices", {}).items()]
        if broken["step"]:
            last = tell_end(broken)
            when = f"{broken['seconds']} s" if "seconds" in broken else moment(broken["step"], told.get("dt"))
            written.append(f"at {when}: {_state(last, told)}")
        written += [told[key] for key in ("rounding", "replay") if key in told]
    if told["verdict"] == Verdict.PROVED.value:
        proof = told["certificate"]
        visited = format_count(told["symbolic_states"], "symbolic state")
        written.append(f"{sets(told) or visited}, {format_count(proof['bytes'], 'byte')} of proof")
        written += [told["reused"]] if "reused" in told else []
        if told["shuffled_leaves"] and not told["shuffled_leaves"].startswith("0 of "):
            written.append(_say_shuffled(told))
    return written


def _say_shuffled(told: Mapping[str, Any]) -> str:
    """Says how many shuffled leaves fulfil the claim too, and what a proof is worth that needs no particular leaves."""
    weak = told["shuffled_control"] == told["verdict"] == Verdict.PROVED.value
    return f"shuffled leaves: {told['shuffled_leaves']}{WEAK if weak else ''}"


def _open(told: Mapping[str, Any]) -> list[str]:
    """Describes what an answer lacks, and what may help."""
    texts: list[str] = []
    if "open" in told:
        step, ever = told["open"]["step"], told["name"] == Pattern.ALWAYS.value
        where = "" if is_still(told) or (ever and not step) else f" at step {step} of {told['steps']}"
        bounds = within(told)
        texts.append(
            f"open: a set of states{where}, within {', '.join(bounds[:SHOWN])}{', ...' * (len(bounds) > SHOWN)}"
        )
    return texts + ([f"may help: {'; '.join(told['helps'])}"] if "helps" in told else [])


def _state(state: Mapping[str, float | str], told: Mapping[str, Any]) -> str:
    named = in_modes(state, told)
    shown = [f"{name} {named[name] if name in named else brief(value)}" for name, value in state.items()]
    return ", ".join(shown[:SHOWN]) + (", ..." if len(shown) > SHOWN else "")


def _rows(told: Mapping[str, Any]) -> list[dict[str, str]]:
    """Each variable in words: its range, where it starts, by how much a step may be off, and what was measured."""
    off = told["reference"].get("off", {})
    return [
        {
            "name": each["name"],
            "unit": "" if each["unit"] == "1" else each["unit"],
            "range": ", ".join(each["modes"]) if "modes" in each else _bounds(each["range"]),
            "start": _start(each, told["start"]["box"].get(each["name"])),
            "error": _error(each["error"]),
            "measured": upwards(max(map(abs, off[each["name"]])), 2) if each["name"] in off else "",
        }
        for each in told["variables"]
    ]


def _start(variable: Mapping[str, Any], ends: Sequence[str] | None) -> str:
    """Where a variable starts: a mode by its name. What keeps earlier values has no bounds of its own."""
    if ends is None:
        return "as the conditions say"
    return variable["modes"][int(ends[0])] if "modes" in variable else _bounds(ends)


def _bounds(ends: Sequence[str]) -> str:
    low, high = ends
    return low if low == high else f"[{low}, {high}]"


def _error(ends: Sequence[str]) -> str:
    low, high = map(Fraction, ends)
    if low == high == 0:
        return "0"
    if low == -high:
        return f"±{upwards(high)}"
    return f"[{short(low, DIGITS, ROUND_FLOOR)}, {upwards(high)}]"


def as_json(told: Mapping[str, Any]) -> str:
    """The report as JSON text."""
    return layout(dict(told)) + "\n"


def _ready(told: Mapping[str, Any]) -> dict[str, Any]:
    """The facts with what templates only place."""
    variables = told["variables"]
    dt = told["dt"]
    more = [
        {
            "within": within(result),
            "shuffled": _say_shuffled(result),
            "shown": describe_sets(result),
            "near": nearness(result, dt),
        }
        for result in told["results"]
    ]
    results = [draw_courses(result, variables, dt) | words for result, words in zip(told["results"], more, strict=True)]
    return {**told, "rows": _rows(told), "results": results}


def as_text(told: Mapping[str, Any]) -> str:
    """The report as text; what a terminal would not print as it stands is escaped."""
    return "\n".join(map(visible, render("systems/report.txt.j2", **_ready(told)).split("\n")))


def as_html(told: Mapping[str, Any]) -> str:
    """The report as one HTML page: inline styles and drawings, no scripts, nothing loaded from elsewhere."""
    return render("systems/report.html.j2", **_ready(told))


TELLING = Telling(
    facts=lambda profile, result, command: facts(result, 1) | {"command": command},
    limits=lambda profile, results: [],  # those of the whole system, which `document` knows
    trusted=(),
    lines=lambda result: (result.claim.shown, lines(facts(result, 1))),
)


DIGITS = 6  # of an error in words
OF_FLOWS = (
    "A state is an exact number for each variable. At the start and after each period an agent observes the exact "
    "value of each feature, rounded once to what it compares, float32 or float64. A split goes left iff x <= "
    "threshold. The engines use the exact end of the half line on which this is true after rounding. The action "
    "is held until the next of these samples. At every moment the derivative of a variable is what the world file "
    "gives for the state and the actions, and an error anywhere within its bounds is added, which may change at "
    "any time."
)
FOLLOWED = "fails in the episode shown, which was followed in enclosures that leave no doubt"
ONE_READING = (
    "The search tries its plans by the checker's own steps, so a proof has one reading of the flow. Episodes that "
    "other code played beside it broke no claim that is proved."
)
PERIODS = "A claim about episodes covers only the periods that it names. Its steps are periods."


def flow_sentence(flow: Flow) -> str:
    """Describes what verdicts about continuous time are about."""
    errors = {name: max(map(abs, bounds)) for name, bounds in flow.errors.items()}
    told = ", ".join(f"{name} {upwards(error)} a second" for name, error in errors.items())
    jumping = list(dict.fromkeys(name for each in flow.each for name in each.jumps if name not in flow.kept))
    jumps = f", jumps of {', '.join(jumping)} at samples" if jumping else ""
    cases = f" in {format_count(len(flow.cases), 'case')}" if flow.cases else ""
    often = f"of the stated flow{cases}, with actions held for {_periods(flow)}{_delays(flow)}{jumps}"
    return often + (f" and derivatives off by at most {told}" if told else ", exactly")


def _periods(flow: Flow) -> str:
    if not any(flow.jitter):
        return f"{plain(flow.period)} s"
    low, high = (flow.period + end for end in flow.jitter)
    return f"{plain(low)} to {plain(high)} s"


def _delays(flow: Flow) -> str:
    """Describes how late observations are."""
    if not flow.kept:
        return ""
    most = len(flow.kept) // len(set(flow.kept.values()))
    least = most + 1 - len(flow.seen)
    return f", observations late by {f'{least} to {most} periods' if least < most else format_count(most, 'period')}"


def upwards(number: Fraction | float, digits: int = DIGITS) -> str:
    """A number with so many digits at most, never below it."""
    return short(Fraction(number), digits, ROUND_CEILING)


def short(number: Fraction, digits: int, rounding: str) -> str:
    """A number with so many digits at most, rounded as decimal's modes say."""
    exact = Context(prec=digits, rounding=rounding).divide(Decimal(number.numerator), Decimal(number.denominator))
    near = float(exact)
    return f"{near:.{digits}g}" if near or not number else str(exact)
