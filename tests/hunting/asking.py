"""One question about decisions, asked of the verifier as the command asks it, and every word of the answer judged.

Does: the verdict of the zones with its checked certificate, Z3's where these cannot, both on some questions, the whole
  front door on some; counterexamples, explanations, margins and forged certificates against the judge.
Assumes: questions as questions.py draws them.
Does not: keep records (record.py).
"""

import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import Any

import numpy as np

from codegen.errors import InputError
from codegen.policy_json import content_hash
from tests.hunting import forging, judge
from tests.hunting.places import Case
from tests.hunting.questions import Asked, of_twin
from tests.hunting.reading import MACHINE, REAL
from tests.support.altered import altered, read_game
from verify.certificates.games import to_json
from verify.checker.decisions import DecisionCertificate, check_certificate
from verify.checker.reading import RejectedError
from verify.claims.wording import formula_document
from verify.counterexamples import search
from verify.counterexamples.explanation import Explanation
from verify.counterexamples.uniqueness import Unique
from verify.kinds import Kind
from verify.result import Verdict
from verify.solver.solve import Answer, decide
from verify.states.state import State
from verify.verdicts.decisions import Result, Zoned, by_zones, verify

SECOND = 60  # of so many questions one is also asked of the other engine
FRONT = 300  # and one of the whole front door
CONFIRMING = {MACHINE: 40, REAL: 1}  # of so many violated ones one has its counterexample made
UNSETTLED = 6  # of those whose violation nobody saw so many are taken to the front door
FORGING = 4  # of so many certificates one is forged


@dataclass
class Told:
    """What was answered, and what is wrong with it."""

    seed: int
    verdict: str = ""
    kind: str = ""
    depth: int = 0
    conflict: bool = False
    whole: bool = False
    judged: str = ""  # "violated" where the judge found a violation, "holds" where it looked everywhere
    front: bool = False
    second: bool = False
    forged: int = 0
    refused: int = 0  # of these
    close: bool = False  # whether the claim's bound lies within 2 % of the extreme that the judge has sampled
    wrong: list[str] = field(default_factory=list)

    def tally(self) -> dict[str, int]:
        """What a record counts."""
        return {
            "proved, not vacuous": self.verdict == "PROVED" and self.conflict,
            "proved, looked through entirely": self.verdict == "PROVED" and self.judged == "holds",
            "violated, seen by the judge": self.verdict == "VIOLATED" and self.judged == "violated",
            "asked of both engines": self.second,
            "asked of the whole front door": self.front,
            "certificates forged": self.forged,
            "certificates forged, refused": self.refused,
            "bound within 2 % of the extreme": self.close,
        }


def ask(asked: Asked, thorough: bool = False) -> Told:
    """Asks a question and judges the answer. `thorough`: with every check that is else made of some questions only."""
    rng = np.random.default_rng([asked.seed, 2])
    told = Told(asked.seed, kind=asked.case.claim["name"], depth=asked.depth)
    with ending(told):
        if asked.question.claim.kind is Kind.LEAVES:
            _leaves(asked, told)
        else:
            _decisions(asked, told, rng, thorough)
    return told


@contextmanager
def ending(told: Told) -> Iterator[None]:
    """Notes what ends a question: it may be refused, and whatever else does is wrong."""
    try:
        yield
    except InputError as error:
        told.verdict = f"refused: {error.what}"
    except Exception as error:
        last = traceback.extract_tb(error.__traceback__)[-1]
        told.verdict = told.verdict or "none"
        told.wrong.append(f"{type(error).__name__}: {error} ({last.name}, line {last.lineno})")


def _decisions(asked: Asked, told: Told, rng: np.random.Generator, thorough: bool) -> None:
    def one_of(count: int) -> bool:
        return bool(rng.integers(count) == 0) or thorough

    zoned = by_zones(asked.question)
    verdict = zoned.opinion.verdict
    if verdict in (Verdict.SKIPPED, Verdict.UNKNOWN):
        verdict = decide(asked.question).verdict
    elif one_of(SECOND):
        told.second = True
        second = decide(asked.question).verdict
        if second not in (Verdict.UNKNOWN, Verdict.VACUOUS, verdict):
            told.wrong.append(f"zones say {verdict.value}, Z3 {second.value}")
    told.verdict = verdict.value
    if verdict is Verdict.VIOLATED and _seen(asked.case, zoned, told):
        look = judge.Look(judge.Violation({}, None, {}), False, True)
        told.judged = "violated"
    else:
        look = judge.look(asked.case, asked.seed)
        told.conflict, told.whole = look.conflict, look.whole
        told.judged = "violated" if look.violation else "holds" if look.whole else ""
    if verdict is Verdict.PROVED:
        forging_too = one_of(FORGING)
        if look.violation is not None:
            told.wrong.append(f"proved, but fails at {look.violation}")
        if zoned.certificate is not None and forging_too:
            text = to_json(zoned.certificate)
            if read_game(text) != zoned.certificate:
                told.wrong.append("a certificate reads back as another one")
            for _ in range(2):
                _forged(asked, asked.case, asked.question.profile, text, told, rng)
    elif verdict is Verdict.VACUOUS and judge.inhabited(asked.case, asked.seed):
        told.wrong.append("vacuous, though there is a state")
    elif verdict is Verdict.VIOLATED:
        _violated(asked, zoned, told, one_of(CONFIRMING[asked.case.semantics]), one_of(UNSETTLED))
        if asked.twin is not asked.question.profile and one_of(FORGING):
            _of_the_twin(asked, told, rng)
    if one_of(FRONT):
        _front(asked, told)


def _of_the_twin(asked: Asked, told: Told, rng: np.random.Generator) -> None:
    """The certificate of the team before it was changed, offered for the changed one."""
    zoned = by_zones(of_twin(asked).question)
    if zoned.certificate is not None:
        theirs = altered(zoned.certificate, profile=content_hash(asked.question.profile))
        told.forged += 1
        if _accepts(theirs, asked.question.profile):
            told.wrong.append("the certificate of another team is accepted for a violated claim")
        else:
            told.refused += 1
        _forged(asked, asked.case, asked.question.profile, to_json(theirs), told, rng)


def _accepts(certificate: DecisionCertificate, profile: Any) -> bool:
    try:
        return check_certificate(certificate, profile) >= 0
    except (InputError, RejectedError):
        return False


def _forged(asked: Asked, case: Case, profile: Any, text: str, told: Told, rng: np.random.Generator) -> None:
    """A changed certificate must not be accepted for what the judge refutes."""
    how, document, changed = forging.forged(text, rng)
    told.forged += 1
    try:
        taken = _accepts(read_game(changed), profile)
    except (InputError, RejectedError):
        taken = False
    if not taken:
        told.refused += 1
        return
    claimed = forging.case_of(document, case.profile)
    if not claimed.team and claimed.claim["name"] != "formula":
        told.wrong.append(f"accepts a certificate about nobody ({how}: {claimed.claim['team']!r})")
        return
    look = judge.look(claimed, asked.seed)
    if look.violation is not None:
        told.wrong.append(f"accepts a forged certificate ({how}), the claim fails at {look.violation}")


# --- violated


def _seen(case: Case, zoned: Zoned, told: Told) -> bool:
    """Whether the zones' exact state, or a float64 state beside it, violates the claim; in real arithmetic it must."""
    if zoned.state is None or case.eps:
        return False
    if case.semantics == REAL:
        if not judge.violates(case, zoned.state, zoned.goal):
            told.wrong.append(f"zones show {dict(zoned.state)}, goal {zoned.goal}, where the claim holds")
        return True
    return judge.violates_beside(case, zoned.state, zoned.goal, told.seed)


def _violated(asked: Asked, zoned: Zoned, told: Told, confirm: bool, settle: bool) -> None:
    """The counterexample of a violated claim must be one; where nobody saw one, the front door is asked."""
    if zoned.state is not None and confirm:
        found, _ = search.confirm_point(asked.question, zoned.goal, Answer(True, dict(zoned.state), 0))
        if found is not None:
            told.judged = "violated"
            _shown(asked.case, found, told)
    if told.judged != "violated" and settle:
        _front(asked, told)
        if told.verdict not in ("VIOLATED", "UNKNOWN"):
            told.wrong.append(f"an engine says VIOLATED, the front door {told.verdict}")


def _shown(case: Case, state: State, told: Told) -> None:
    """A counterexample must be one."""
    if not judge.violates(case, state.position, state.goal, state.errors):
        told.wrong.append(f"shows {state}, where the claim holds")


# --- the front door


def _front(asked: Asked, told: Told) -> None:
    result, look = verify(asked.question, {}), judge.look(asked.case, asked.seed)
    told.front = True
    told.verdict = result.verdict.value
    if result.verdict is Verdict.PROVED and look.violation is not None:
        told.wrong.append("the front door proves what fails")
    if result.verdict is Verdict.VACUOUS and look.violation is not None:
        told.wrong.append("vacuous, though the claim fails somewhere")
    empty = result.verdict is Verdict.VACUOUS
    if empty and judge.inhabited(asked.case, asked.seed) and not judge.idle(asked.case, asked.seed):
        told.wrong.append("vacuous, though a state meets each left side")
    if result.verdict is Verdict.PROVED:
        # the states of a certificate must meet its left sides, by the judge
        certificate = result.evidence.certificate
        for premise in (certificate.claim.premises or ()) if certificate is not None else ():
            said = forging.formula_of(formula_document(premise.formula))
            claim = {**asked.case.claim, "name": "formula", "of": "", "landmarks": (), "formula": ("not", said)}
            claim |= {"assume": None, "eps": Fraction(0)}
            exact = asked.case.semantics == REAL
            state = {name: value if exact else float(value) for name, value in premise.state.items()}
            if not judge.violates(replace(asked.case, claim=claim), state, premise.goal or None):
                told.wrong.append(f"says that {premise.state} meets {premise.formula}")
    if result.evidence.counterexample is not None:
        told.judged = "violated"
        _shown(asked.case, result.evidence.counterexample.state, told)
        if result.evidence.explanation is not None:
            _explained(
                asked.case, result.evidence.counterexample.state, result.evidence.explanation, look, told, asked.seed
            )
    _room(asked, result, told)


def _room(asked: Asked, result: Result, told: Told) -> None:
    """What a proof says of larger margins and errors."""
    for key, margin in (("margin", result.evidence.largest), ("eps", result.evidence.steady_up_to)):
        if margin is not None and margin.proved > asked.case.claim[key]:
            case = replace(asked.case, claim={**asked.case.claim, key: margin.proved})
            if judge.look(case, asked.seed).violation is not None:
                told.wrong.append(f"proved up to {key} {margin.proved}, where it fails")


def _explained(case: Case, state: State, told_: Explanation, look: judge.Look, told: Told, seed: int) -> None:
    rng = np.random.default_rng([seed, 4])
    leaves = judge.leaves_at(case, state.position, state.goal, state.errors)

    def stands(name: str, value: Any) -> bool:
        moved = {**state.position, name: value}
        same = judge.violates(case, moved, state.goal, state.errors)
        return same and judge.leaves_at(case, moved, state.goal, state.errors) == leaves

    for span in told_.spans:
        kept = [end for end, out in ((span.low, "low"), (span.high, "high")) if out not in span.excluded]
        between = Fraction(span.low) + (Fraction(span.high) - Fraction(span.low)) * Fraction(float(rng.random()))
        kept.append(float(between) if case.semantics == MACHINE else between)
        for value in kept:
            if span.low <= value <= span.high and value not in span.excluded and not stands(span.name, value):
                told.wrong.append(f"says that {span.name} may be {value!r}")
        if case.semantics == MACHINE and span.low < span.high:
            outside = [float(np.nextafter(span.low, -np.inf)), float(np.nextafter(span.high, np.inf))]
            told.wrong += [
                f"says that {span.name} may not be {value!r}" for value in outside if stands(span.name, value)
            ]
    unique = told_.uniqueness
    if unique.answer is Unique.OTHERS and unique.other is not None:
        other = unique.other
        reached = judge.leaves_at(case, other.position, other.goal, other.errors)
        if not judge.violates(case, other.position, other.goal, other.errors) or reached != dict(unique.leaves):
            told.wrong.append(f"says that {other} fails elsewhere")
    if unique.answer is Unique.ONLY and look.violation is not None:
        one = look.violation
        if judge.leaves_at(case, one.state, one.goal, one.errors) != leaves:
            told.wrong.append(f"says that it is the only way to fail, but {one}")


def _leaves(asked: Asked, told: Told) -> None:
    """alive_leaves: reached leaves by their witnesses, dead ones by looking."""
    result = verify(asked.question, {})
    told.verdict, told.front = result.verdict.value, True
    reached = judge.reached(asked.case, asked.seed)
    for finding in result.evidence.leaves:
        if finding.witness is not None:
            position, goal = finding.witness.position, finding.witness.goal
            there = judge.leaves_at(asked.case, position, goal, {})[finding.agent]
            if there != finding.leaf or not judge.within(asked.case, position, goal):
                told.wrong.append(f"says that {position} reaches leaf {finding.leaf} of {finding.agent}")
        if finding.verdict is Verdict.VIOLATED and (finding.agent, finding.leaf) in reached:
            told.wrong.append(f"calls leaf {finding.leaf} of {finding.agent} dead")
