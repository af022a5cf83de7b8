"""Proofs that are renewed after a change: what is kept of them, and that the answer is that of a fresh search."""

from dataclasses import replace
from fractions import Fraction as F

import numpy as np
import pytest

from tests.support.covers import question
from tests.support.system_cases import double_integrator, stays, switching
from verify.checker.accept import accept
from verify.checker.systems.proofs import FollowedPart, Walks
from verify.claims.region import UNBOUNDED
from verify.kinds import MACHINE
from verify.question import Budgets, Question
from verify.reach.decide import decide
from verify.reach.renewal import AFRESH, renew
from verify.result import SETTLED, Verdict
from verify.subjects import ClosedLoop

ENOUGH = Budgets(max_boxes=200_000, samples=256)


def asked(system, profile, claim, *since, budgets=ENOUGH):
    return Question(ClosedLoop(profile, system), claim, UNBOUNDED, MACHINE, budgets, since)


def moved(profile, by):
    """The profile with one threshold of its last tree elsewhere."""
    *others, last = profile.agents
    threshold = last.tree.threshold.copy()
    threshold[np.flatnonzero(last.tree.feature >= 0)[:1]] += by
    return replace(profile, agents=(*others, replace(last, tree=replace(last.tree, threshold=threshold))))


@pytest.mark.parametrize("covers", [True, False], ids=["covers", "walks"])
def test_an_answer_never_hangs_on_earlier_proofs(covers):
    """Of the same question before a tree was changed, or of any other one."""
    budgets, proofs, kept = replace(ENOUGH, covers=covers), [], 0
    for seed in range(24):
        system, profile, claim = question(np.random.default_rng([57, seed]))
        before = decide(asked(system, profile, claim, budgets=budgets))
        proofs += [before.certificate.proof] if before.certificate else []
        now = moved(profile, 0.25)
        fresh = decide(asked(system, now, claim, budgets=budgets))
        found = renew(asked(system, now, claim, *reversed(proofs[-3:]), budgets=budgets), decide)
        assert found.verdict is fresh.verdict or not {found.verdict, fresh.verdict} <= {*SETTLED}
        if found.verdict is Verdict.PROVED:
            assert accept(found.certificate, now, system) == found.branches
            kept += found.reused not in ("", AFRESH)
    assert len(proofs) >= 5 <= kept


def test_parts_of_a_claim_that_hold_are_not_walked_again():
    system, profile = double_integrator(axes=2), switching(2)
    claim = stays(system, 4, x=(F(-1), F(1)), y=(F(-1), F(1)))
    walked = decide(asked(system, profile, claim, budgets=replace(ENOUGH, covers=False))).certificate.proof
    assert len(walked.parts) == 2
    spoilt = FollowedPart(walked.parts[1].followed, walked.parts[1].shows, (), b"\1" + walked.parts[1].proof)
    found = renew(asked(system, profile, claim, Walks((walked.parts[0], spoilt))), decide)
    assert found.reused == "1 of 2 parts hold as they were; 1 proved again" and found.certificate.proof == walked
    assert renew(asked(system, profile, claim, Walks((spoilt, spoilt))), decide).reused == AFRESH
