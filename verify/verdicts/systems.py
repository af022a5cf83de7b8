"""From a question about a stated system to a verdict that carries its evidence.

Does: has the system searched and a counterexample confirmed, asks the solver for a second opinion, runs the control;
  measures how near random episodes, or a counterexample, come to the border of the claim's regions, in a variable's
  unit.
Assumes: a checked profile; a system whose names, units and shapes were checked.
Does not: know the environment that a system is about, or read files; nothing is decided by how near episodes come,
  which is not measured in continuous time or of claims about single decisions.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from codegen.ir import Float64, Int64, PolicyProfile
from codegen.lowering.render import brief
from codegen.numbers import nearest_double
from verify.checker.systems.proofs import Walks
from verify.flows import decide as flows
from verify.question import Question
from verify.reach import decide as reach
from verify.reach.play import Planes, Play, Starts, random_starts, value
from verify.reach.renewal import renew
from verify.reach.results import ReachOutcome, SystemCounterexample
from verify.result import SETTLED, Control, Cost, Evidence, Opinion, Result, Verdict
from verify.solver import unrolled
from verify.spending import STATE
from verify.subjects import ClosedLoop
from verify.systems.claims import SystemClaim
from verify.systems.system import HalfSpace, System

if TYPE_CHECKING:
    from verify.checker.systems.proofs import SystemCertificate
    from verify.reach.results import OpenState


EPISODES, SEED = 1_000, 1
PLAYED, DIGITS = 6, 5  # of the random episodes that a report draws, for each variable of the claim; their digits
ROUNDED = 2.0**-40  # of the ranges: a state no farther beyond a border is on it, but for the rounding of float64


@dataclass(frozen=True)
class ClosestApproach:
    """The state that comes nearest to a border, or goes farthest beyond it."""

    border: str  # such as "T = 22.5"
    gap: float  # from there, in `unit`
    unit: str  # of the variable; "": the border is of a sum
    step: int
    episodes: int  # random ones; 0: it is the counterexample, whose state lies beyond
    short: bool = False  # or which falls short of its goal
    played: Mapping[str, list[list[float]]] = field(default_factory=dict[str, list[list[float]]])  # see `PLAYED`


class _MeasuredBorder(NamedTuple):
    """A half space, the number that `gap` counts in, and the one in which borders are compared."""

    half: HalfSpace
    factor: float
    width: float


def closest(profile: PolicyProfile, system: System, claim: SystemClaim) -> ClosestApproach | None:
    """Among random episodes; None for claims that an episode fulfils at a step of its own, where all that is played
    leaves what is stated, and where an episode goes beyond the border, by errors of enclosures that no rule has.
    """
    if claim.about_decisions or claim.says.once or system.flow is not None:
        return None
    random = np.random.default_rng(SEED)
    start = random_starts(system, claim, Starts(EPISODES), random)
    if start is None:
        return None
    count, approach, least = len(next(iter(start.values()))), None, np.inf
    named = {name for region in claim.regions for half in region for name, _ in half.form.terms}
    played = {one.name: [list[float]() for _ in range(PLAYED)] for one in system.variables if one.name in named}
    with np.errstate(over="ignore", invalid="ignore"):
        for step, state, alive in Play(profile, system).walk(start, random, claim.steps):
            for name, rows in played.items():
                for row, number, on in zip(rows, state[name].tolist(), alive.tolist(), strict=False):
                    row += [float(f"{number:.{DIGITS}g}")] if on else []
            if step < claim.by or not alive.any():
                continue
            levels, borders = _levels(system, claim, state)
            place = int(np.argmin(np.where(alive & np.isfinite(levels), levels, np.inf)))
            if alive[place] and levels[place] < -ROUNDED:
                return None
            if alive[place] and max(levels[place], 0.0) < least:
                least = max(levels[place], 0.0)
                approach = _approach(system, claim, int(borders[place]), float(least), step, count)
    return None if approach is None else replace(approach, played=played)


def beyond(system: System, claim: SystemClaim, shown: SystemCounterexample) -> ClosestApproach | None:
    """By how much a counterexample breaks its claim: at its last state, or where it comes nearest to a goal."""
    if claim.about_decisions or system.flow is not None:
        return None
    steps = range(len(shown.states)) if claim.says.once else [shown.step]
    states = [shown.states[step] for step in steps]
    planes = {name: np.array([nearest_double(state[name]) for state in states]) for name in shown.start}
    levels, borders = _levels(system, claim, planes)
    place = int(np.argmax(levels))
    approach = _approach(system, claim, int(borders[place]), -float(levels[place]), steps[place], 0)
    return replace(approach, short=claim.says.once)


def _borders(system: System, claim: SystemClaim) -> list[list[_MeasuredBorder]]:
    """Those of each region."""
    widths = {one.name: float(one.range[1] - one.range[0]) for one in system.variables}

    def border(half: HalfSpace) -> _MeasuredBorder:
        terms = half.form.terms
        factor = abs(float(terms[0][1])) if len(terms) == 1 else 1.0
        return _MeasuredBorder(half, factor, sum(abs(float(weight)) * widths[name] for name, weight in terms) or 1.0)

    return [[border(half) for half in polytope] for polytope in claim.regions]


def _levels(system: System, claim: SystemClaim, state: Planes) -> tuple[Float64, Int64]:
    """Returns how far each state is from being excluded, as a share of the ranges, negative where it is; and the place
    of the border that says so, counted through all regions.
    """
    sign, first = (1.0 if claim.says.avoided else -1.0), 0
    levels: list[Float64] = []
    places: list[Int64] = []
    for borders in _borders(system, claim):
        rows = np.stack([sign * value(each.half.form, state) / each.width for each in borders])
        chosen = rows.argmax(axis=0) if claim.says.avoided else rows.argmin(axis=0)
        levels.append(np.take_along_axis(rows, chosen[None], axis=0)[0])
        places.append(chosen + first)
        first += len(borders)
    regions = np.stack(levels)
    region = regions.argmin(axis=0) if claim.says.avoided else regions.argmax(axis=0)
    chosen = region[None]
    return np.take_along_axis(regions, chosen, axis=0)[0], np.take_along_axis(np.stack(places), chosen, axis=0)[0]


def _approach(
    system: System, claim: SystemClaim, place: int, level: float, step: int, episodes: int
) -> ClosestApproach:
    nearest = [each for borders in _borders(system, claim) for each in borders][place]
    terms, constant = nearest.half.form.terms, float(nearest.half.form.constant)
    gap = 0.0 + level * nearest.width / nearest.factor
    if len(terms) == 1:
        ((name, factor),) = terms
        unit = next(one.unit for one in system.variables if one.name == name)
        border = f"{name} = {brief(-constant / float(factor) + 0.0)}"
        return ClosestApproach(border, gap, "" if unit == "1" else unit, step, episodes)
    parts = (f"{'-' if weight < 0 else ''}{_times(abs(weight))}{name}" for name, weight in terms)
    told = " + ".join(parts).replace("+ -", "- ")
    return ClosestApproach(f"{told} = {brief(-constant + 0.0)}", gap, "", step, episodes)


def _times(weight: Fraction) -> str:
    return "" if weight == 1 else f"{brief(float(weight))}*"


ENGINE, UNIT, BOXES = "reach", "symbolic states", "boxes"
FLOWS, SETS = "flows", "sets of states"
CONTROLS, EACH = 2_000_000, 100_000  # boxes for all shuffled leaves together, and in steps for each: most fail at once
FEW = 256  # episodes of each that are played
ENCLOSED = "the claim fails within the enclosure error, but no violating episode of the exact rules was found"
NARROWER = ("more `cuts` where rules are not affine", "a smaller start region", "fewer steps")
Attempt = Callable[[], SystemCounterexample | None]
Confirm = Callable[[SystemCounterexample], SystemCounterexample | None]  # by the rules themselves; None: not broken


@dataclass(frozen=True, kw_only=True, repr=False)
class SystemEvidence(Evidence):
    """The evidence for a verdict about a stated system, and all else that a report says of it.

    For example:

        maviper.verify_system(team, "corridor.toml").results[0].evidence.boxes
    """

    open: OpenState | None = None  #: what an UNKNOWN leaves open, where that is a set of states
    helps: tuple[str, ...] = ()  #: what may give an answer
    certificate: SystemCertificate | None = None
    counterexample: SystemCounterexample | None = None
    #: how near episodes come to a border, or how far the counterexample goes beyond
    approach: ClosestApproach | None = None
    environment: str = ""  #: what the environment that the system is about says of the counterexample
    rounding: str = ""  #: where a counterexample exists only by rounding: from which bound on the claim is proved
    programs: int = 0  #: linear programs that were solved
    boxes: int = 0  #: boxes that were tried
    reused: str = ""  #: how much of an earlier proof holds as it was, where one was given


SystemResult = Result[SystemClaim, SystemEvidence]


def verify_system(
    question: Question[SystemClaim],
    confirm: Confirm | None = None,
    beside: bool = True,
    attempt: Attempt | None = None,
    known: SystemCounterexample | None = None,
) -> SystemResult:
    """The verdict on a question. `confirm`: finds a counterexample again by rules that the system encloses; `beside`:
    with the solver's opinion and the control; `attempt`: looks for a counterexample where nothing else has one;
    `known`: one that was confirmed, so that nothing is searched.
    """
    flowing = is_flow(question)
    if known is not None:
        outcome = ReachOutcome(Verdict.VIOLATED, counterexample=known)
    else:
        outcome = _confirm_outcome(renew(question, flows.decide if flowing else reach.decide), confirm)
    broken = attempt() if attempt is not None and outcome.verdict is Verdict.UNKNOWN else None
    if broken is not None:
        outcome = replace(outcome, verdict=Verdict.VIOLATED, reason="", counterexample=broken, open=None, helps=())
    settled = beside and outcome.verdict in SETTLED
    certificate = outcome.certificate
    by_boxes = not outcome.states and certificate is not None and not isinstance(certificate.proof, Walks)
    own = Opinion(ENGINE, outcome.verdict, outcome.states, UNIT)
    own = Opinion(BOXES, outcome.verdict, outcome.boxes, BOXES) if by_boxes else own
    own = Opinion(FLOWS, outcome.verdict, outcome.boxes, SETS) if flowing else own
    opinions = [own]
    if settled and not flowing:
        second = unrolled.opinion(question)
        if second.verdict in SETTLED and second.verdict is not outcome.verdict:
            said = f"{ENGINE} {outcome.verdict.value}, {second.engine} {second.verdict.value}"
            raise AssertionError(f"the engines disagree on {question.claim.name}: {said}")
        opinions.append(second)
    evidence = SystemEvidence(
        control=_ask_controls(question) if settled else Control(),
        opinions=tuple(opinions),
        certificate=certificate,
        branches=outcome.branches,
        counterexample=outcome.counterexample,
        approach=_find_approach(question, outcome) if beside else None,
        open=outcome.open,
        helps=outcome.helps,
        programs=outcome.programs,
        boxes=outcome.boxes,
        reused=outcome.reused,
    )
    cost = Cost(outcome.states, question.budgets.max_boxes // STATE, UNIT)
    return Result(question, outcome.verdict, outcome.reason, evidence, cost)


def _ask_controls(question: Question[SystemClaim]) -> Control:
    controls, flowing = question.controls, is_flow(question)
    most, engine = CONTROLS // max(len(controls), 1), flows if flowing else reach
    limits = {"max_boxes": most if flowing else min(most, EACH), "samples": FEW}
    return Control.of(engine.decide_control(control.spending(**limits)).verdict for control in controls)


def _find_approach(question: Question[SystemClaim], outcome: ReachOutcome) -> ClosestApproach | None:
    """Measures how near random episodes come to the claim's border, or how far beyond it the counterexample goes."""
    assert isinstance(question.subject, ClosedLoop)
    profile, system = question.subject.profile, question.subject.system
    if outcome.counterexample is not None:
        return beyond(system, question.claim, outcome.counterexample)
    return None if outcome.verdict is Verdict.VACUOUS else closest(profile, system, question.claim)


def is_flow(question: Question[SystemClaim]) -> bool:
    """Returns True if a question is about episodes in continuous time."""
    assert isinstance(question.subject, ClosedLoop)
    return question.subject.system.flow is not None and not question.claim.about_decisions


def _confirm_outcome(outcome: ReachOutcome, confirm: Confirm | None) -> ReachOutcome:
    """The outcome, unless only the error of enclosures breaks the claim: then nothing is known of the rules."""
    if outcome.counterexample is None or confirm is None:
        return outcome
    again = confirm(outcome.counterexample)
    if again is None:
        return replace(outcome, verdict=Verdict.UNKNOWN, reason=ENCLOSED, helps=NARROWER, counterexample=None)
    return replace(outcome, counterexample=again)
