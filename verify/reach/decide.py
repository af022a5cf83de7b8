"""Decides claims about a team in a stated system: PROVED with a certificate, VIOLATED with an episode, or UNKNOWN.

Does: asks whether claims can be decided, and has them decided together.
Assumes: a checked profile; a system whose names, units and shapes were checked.
Does not: choose what is tried (together.py).
"""

from __future__ import annotations

from collections.abc import Sequence

from codegen.errors import InputError, UnknownNameError
from codegen.ir import PolicyProfile
from verify.checker.systems.certificates import acting
from verify.claims.formula import agents
from verify.question import Question
from verify.reach.results import ReachOutcome
from verify.reach.together import Together
from verify.subjects import ClosedLoop
from verify.systems.claims import SystemClaim
from verify.systems.system import System, ensure_in_steps


def decide(question: Question[SystemClaim]) -> ReachOutcome:
    """The answer to a question. InputError for agents or features that the system does not state."""
    return together([question]).outcome(0)


def together(questions: Sequence[Question[SystemClaim]]) -> Together:
    """Questions about one profile and system, to be decided by one search with the budgets of the first. InputError as
    for `decide`.
    """
    first = questions[0]
    assert isinstance(first.subject, ClosedLoop)
    profile, system = first.profile, first.subject.system
    ensure_stated(profile, system)
    for question in questions:
        _ensure_asked(profile, system, question.claim)
    return Together(profile, system, [question.claim for question in questions], first.budgets)


def ensure_stated(profile: PolicyProfile, system: System) -> None:
    """UnknownNameError for agents or features that the system does not state; InputError for one without a tree."""
    where = f"system {system.name}"
    for policy in profile.agents:
        if policy.agent not in system.features:
            raise UnknownNameError("agent", policy.agent, system.features, where)
        for feature in policy.features:
            known = system.features[policy.agent]
            if feature.name not in known:
                raise UnknownNameError("feature", feature.name, known, f"{where}, agent {policy.agent}")
    silent = sorted(acting(system) - {policy.agent for policy in profile.agents})
    if silent:
        what = f"the profile has no tree for {', '.join(silent)}"
        raise InputError(what, where, "name the profile of all agents that move the system")


def _ensure_asked(profile: PolicyProfile, system: System, claim: SystemClaim) -> None:
    claim.ensure()
    strange = agents(claim.formula) - {policy.agent for policy in profile.agents}
    if strange:
        raise UnknownNameError("agent", min(strange), [policy.agent for policy in profile.agents], claim.shown)
    if not claim.about_decisions:
        ensure_in_steps(system, "the engine of steps")
    if claim.steps and not claim.about_decisions and not system.pieces:
        what = f"system {system.name} states no dynamics, so nothing can be said of episodes"
        raise InputError(what, f"claim {claim.shown}", "state how it moves, or claim something about decisions")
