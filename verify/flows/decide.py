"""Decides claims about a team in continuous time: PROVED with a certificate, VIOLATED with an episode, or UNKNOWN.

Does: the order in which episodes and plans are looked for; says which derivatives may not be defined where episodes go.
Assumes: a checked profile; a system with a flow, whose names, units and shapes were checked.
Does not: read or write files.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np

from codegen.errors import InputError
from verify.checker.covers.boxes import StartBox
from verify.checker.covers.rounding import ceiling, floor
from verify.checker.flows.intervals import Spans, finite, hull
from verify.checker.flows.series import FlowReading, Stepping, StepPrograms
from verify.checker.flows.sweep import NOT_SHOWN, FlowSweep, Plan, SeenStep
from verify.checker.reading import RejectedError
from verify.flows.episodes import FlowPlay, FlowReplay
from verify.flows.search import PlanSearch
from verify.question import Question
from verify.reach.decide import ensure_stated
from verify.reach.programs import prove
from verify.reach.results import OpenState, ReachOutcome
from verify.result import Verdict
from verify.spending import SET
from verify.subjects import ClosedLoop
from verify.systems.claims import SystemClaim
from verify.systems.system import System

MOST = 10_000  # sets that are followed for this
BEYOND = 1.0  # of its width, by which a set is looked at further


def find_undefined(system: System, sweep: FlowSweep, parts: Sequence[StartBox], plan: Plan) -> list[str]:
    """The variables whose derivatives may not be defined over a part, or over what was followed of it last."""
    assert system.flow is not None
    names = [one.name for one in system.variables]
    once = Stepping(1, system.flow.period)
    rates = [StepPrograms(FlowReading(each, names), once, ()).rates for each in system.flow.each]
    ends: dict[str, list[float]] = {}
    for values in system.flow.held.values():
        for name, value in values.items():
            ends.setdefault(name, []).extend((floor(value), ceiling(value)))
    seen = [Spans(np.array([part.low]), np.array([part.high])) for part in parts]

    def see(told: SeenStep) -> None:
        if told.tube.low.size:
            seen[len(parts) :] = [hull(told.tube, told.after)]

    sweep.watch, sweep.most = see, sweep.spent + MOST
    try:
        sweep.follow(parts, plan)
    except RejectedError:
        pass
    finally:
        sweep.watch = None
    undefined_names: dict[str, None] = {}
    for span in seen:
        by = BEYOND * (span.high - span.low)
        wide = Spans(span.low - by, span.high + by)
        held = {name: Spans(*(np.full(len(by), end) for end in (min(of), max(of)))) for name, of in ends.items()}
        given = held | {name: wide.at((slice(None), column)) for column, name in enumerate(names)}
        with np.errstate(all="ignore"):
            defined = [finite(each.run(given, len(by))) for each in rates]
        for row in defined:
            undefined_names |= {name: None for place, name in enumerate(names) if not row[place].all()}
    return list(undefined_names)


STEP, LEAST_STEPS = 6_000, 400  # boxes of the budget that a step of a replay takes as long as; and how many at least
FIRST_SAMPLES = 256
MIDDLES = 64  # parts left open whose middles are played
LEFT_OPEN = "some episodes may break the claim: none was found that surely does, nor a proof that none does"


def decide_control(question: Question[SystemClaim]) -> ReachOutcome:
    """The same about shuffled leaves, where nobody asks which episode breaks the claim: short ones are replayed first,
    which takes less time.
    """
    return decide(question, soonest=True)


def decide(question: Question[SystemClaim], soonest: bool = False) -> ReachOutcome:
    """The answer to a question. InputError for agents or features that the system does not state. `soonest`: of the
    episodes that break the claim, the one that does so first is replayed first.
    """
    assert isinstance(question.subject, ClosedLoop)
    profile, system, claim = question.profile, question.subject.system, question.claim
    ensure_stated(profile, system)
    claim.ensure()
    if claim.at_samples is None:
        what = "the claim does not say whether it is about samples or about all times"
        raise InputError(what, f"claim {claim.shown}", "set at_samples")
    play = FlowPlay(profile, system, claim)
    replay = FlowReplay(profile, system, claim, max(LEAST_STEPS, question.budgets.max_boxes // STEP))
    for course in play.breaking(min(question.budgets.samples, FIRST_SAMPLES), soonest):
        counterexample = replay.follow_course(course)
        if counterexample is not None:
            return ReachOutcome(Verdict.VIOLATED, counterexample=counterexample)
    search = PlanSearch(profile, system, claim, question.budgets.max_boxes // SET)
    for proof in search.plans():
        with suppress(RejectedError):  # the first plan whose certificate the checker accepts
            return replace(prove(profile, system, claim, proof), boxes=search.spent)

    # more random episodes, and the middles of parts that were left open
    names = [one.name for one in system.variables]
    middles = [0.5 * one.low + 0.5 * one.high for one in search.open[:MIDDLES]]
    starts = [dict(zip(names, middle.tolist(), strict=True)) for middle in middles]
    for course in (*play.breaking(question.budgets.samples), *play.from_starts(starts)):
        counterexample = replay.follow_course(course)
        if counterexample is not None:
            return ReachOutcome(Verdict.VIOLATED, counterexample=counterexample, boxes=search.spent)

    # no answer, with what is left open and what may help
    helps = [*search.helps(), "a smaller start region", *(["fewer steps"] if claim.steps > 1 else [])]
    left = None
    if search.open:
        one = search.open[0]
        left = OpenState(0, {n: (float(a), float(b)) for n, a, b in zip(names, one.low, one.high, strict=True)})
    reason = f"{LEFT_OPEN} ({search.why})" if search.why else LEFT_OPEN
    if search.why == NOT_SHOWN and search.open:
        plan = Plan((), *search.how)
        places = [f"dynamics.flow.{name}" for name in find_undefined(system, search.sweep, search.open[:1], plan)]
        reason += f"; {' and '.join(places)} may not be defined near there" if places else ""
    return ReachOutcome(Verdict.UNKNOWN, reason, left, tuple(helps), boxes=search.spent)
