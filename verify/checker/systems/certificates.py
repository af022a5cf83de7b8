"""Whether a certificate about a stated system is accepted, where its proof follows symbolic states.

Does: whether one of any form asks something of a profile and a system, and one of this form passes the checker.
Assumes: a profile and a system that were read and checked; proofs of the form that README.md specifies, made by anyone.
Does not: prove, read (proofs.py) or write (verify/certificates).
"""

from __future__ import annotations

from codegen.errors import InputError, escape_text
from codegen.ir import ROOT, PolicyProfile
from codegen.policy_json import content_hash
from verify.checker.certificate import REMAKE, ensure_about, numbers
from verify.checker.reading import RejectedError
from verify.checker.systems.cases import ensure_cases
from verify.checker.systems.proofs import FollowedPart, SystemCertificate, Walks
from verify.checker.systems.trees import sides_of
from verify.checker.systems.walk import Proof, SystemQuestions, ways
from verify.claims.formula import Acts, agents, atoms, coordinates, holds
from verify.systems import documents
from verify.systems.claims import SystemClaim, SystemPremise
from verify.systems.system import State, System, ensure_in_steps

BITS = 7 * 1_000  # of the largest number in a proof


def check_certificate(certificate: SystemCertificate, proof: Walks, profile: PolicyProfile, system: System) -> int:
    """Checks a certificate with this proof; the number of branches that its proofs close by sums of rows.

    InputError when it is about another profile or system, or names what they do not have; RejectedError when a proof is
    missing or does not hold.
    """
    if not certificate.claim.about_decisions:
        ensure_in_steps(system, "this form of certificate")
    named = {name for part in proof.parts for name in part.followed}
    hulls = [hull for part in proof.parts for hull in part.hulls]
    named |= {name for hull in hulls for half in hull.region for name, _ in half.form.terms}
    ensure_asked(certificate, named, profile, system)
    _ensure_all_shown(certificate.claim, proof, system)
    closed = 0
    for number, part in enumerate(proof.parts):
        _ensure_closed(system, part)
        try:
            closed += close_branches(profile, system, certificate.claim, part, part.proof)
        except RejectedError as error:
            raise RejectedError(f"part {number}: {error}") from None
    return closed


def close_branches(
    profile: PolicyProfile, system: System, claim: SystemClaim, part: FollowedPart, walked: bytes
) -> int:
    """Checks the proof of a part; counts the branches that it closes. RejectedError where it does not hold."""
    proof = Proof(numbers(walked, BITS))
    SystemQuestions(profile, system, claim, part, proof).run()
    proof.ensure_read()
    return proof.closed


def ensure_asked(
    certificate: SystemCertificate, named: set[str], profile: PolicyProfile, system: System, ever: bool = False
) -> None:
    """That a certificate asks something of this profile and system. `named`: variables that its proof names; `ever`:
    whether it can show what holds at all steps, and nothing else.

    InputError when it is about others, or names what they do not have; RejectedError where its claim is about nothing.
    """
    ensure_about(certificate.header.profile, content_hash(profile), "profile")
    ensure_about(certificate.header.system, documents.content_hash(system), "system")
    _ensure_known(certificate, named, profile, system)
    certificate.claim.ensure()
    if certificate.claim.says.ever != ever:
        raise RejectedError("the claim is about all steps, or this form of certificate is about nothing else")
    if not _is_state(certificate.claim, certificate.header.inhabitant, system):
        raise RejectedError("its inhabitant is not a state that the claim is about, so the claim may be vacuous")
    for premise in certificate.claim.premises:
        _check_premise(premise, certificate.claim, profile, system)
    if certificate.claim.at_samples is not None and system.flow is None:
        raise RejectedError("the claim is about continuous time, and the system moves in steps")
    moving = certificate.claim.steps or certificate.claim.says.ever
    if moving and not system.pieces and system.flow is None and not certificate.claim.about_decisions:
        raise RejectedError("the system states no dynamics, so nothing is known of its episodes")
    ensure_cases(system)
    if any(low > high for piece in system.pieces for low, high in piece.error.values()):
        raise RejectedError("an error of the system has its low end above its high end, so there is none")


def needs_stated(claim: SystemClaim, system: System) -> bool:
    """Returns True if an episode may leave what is stated: then it is to be shown that none does."""
    return not claim.about_decisions and claim.steps > 0 and all(piece.where for piece in system.pieces)


def depends_on(system: System) -> dict[str, frozenset[str]]:
    """The variables that the next value of each variable is made of."""
    sources: dict[str, set[str]] = {one.name: set() for one in system.variables}
    for piece in system.pieces:
        for forms in (piece.move, *piece.effect.values()):
            for name, form in forms.items():
                sources[name] |= {read for read, _ in form.terms}
    return {name: frozenset(read) for name, read in sources.items()}


def acting(system: System) -> set[str]:
    """The agents of a system. One without a tree may do anything, of which no proof speaks."""
    return {*system.features, *(agent for piece in system.pieces for agent, _ in piece.effect)}


def _ensure_known(certificate: SystemCertificate, named: set[str], profile: PolicyProfile, system: System) -> None:
    """InputError where a certificate speaks of what its profile and system do not have."""
    claim, names = certificate.claim, {one.name for one in system.variables}
    used = {name for region in claim.regions + claim.assuming for half in region for name, _ in half.form.terms}
    stated = [claim.formula, *(premise.formula for premise in claim.premises)]
    used |= named.union(*map(coordinates, stated))
    speaking = frozenset[str]().union(*map(agents, stated))
    strange = sorted(used - names) + sorted(speaking - {policy.agent for policy in profile.agents})
    silent = sorted(acting(system) - {policy.agent for policy in profile.agents})
    if silent:
        raise InputError(
            "the profile has no tree for agents that move the system", ", ".join(map(escape_text, silent)), REMAKE
        )
    strange = strange or _strange_actions(claim, profile)
    states = [certificate.header.inhabitant, *(premise.state for premise in claim.premises)]
    if strange or any(set(state) != names for state in states):
        what = "the certificate names what the profile and the system do not have"
        raise InputError(what, ", ".join(map(escape_text, strange)) or "$.inhabitant", REMAKE)


def _strange_actions(claim: SystemClaim, profile: PolicyProfile) -> list[str]:
    """Actions that a claim speaks of, and that its agents do not have."""
    known = {policy.agent: len(policy.actions) for policy in profile.agents}
    said = {(part.agent, part.action) for part in atoms(claim.formula) if isinstance(part, Acts)}
    return [f"action {action} of {agent}" for agent, action in sorted(said) if not 0 <= action < known[agent]]


def _is_state(claim: SystemClaim, state: State, system: System) -> bool:
    if not all(one.range[0] <= state[one.name] <= one.range[1] for one in system.variables):
        return False
    if any(one.modes and state[one.name].denominator != 1 for one in system.variables):
        return False
    if claim.about_decisions:
        return not claim.regions or holds(claim.inside, state, {})
    return all(half.holds(state) for half in system.start) and holds(claim.spoken_of, state, {})


def _check_premise(premise: SystemPremise, claim: SystemClaim, profile: PolicyProfile, system: System) -> None:
    """RejectedError where the state of a left side is none that the claim is about, or does not meet the left side."""
    state, actions = premise.state, dict[str, int]()
    if not claim.about_decisions or not _is_state(claim, state, system):
        raise RejectedError("the state of a left side is not one that the claim is about")
    for agent in agents(premise.formula):
        policy, node = profile.policy(agent), ROOT
        sides = sides_of(system, policy)
        while node in sides:
            node = int((policy.tree.left if holds(sides[node], state, {}) else policy.tree.right)[node])
        actions[agent] = int(policy.tree.action[node])
    if not holds(premise.formula, state, actions):
        raise RejectedError("the state of a left side does not meet it")


def _ensure_all_shown(claim: SystemClaim, proof: Walks, system: System) -> None:
    asked = set(range(ways(claim) + needs_stated(claim, system)))
    missing = asked - {way for part in proof.parts for way in part.shows}
    if missing:
        raise RejectedError(f"no part shows that the claim is not broken in the ways {sorted(missing)}")


def _ensure_closed(system: System, part: FollowedPart) -> None:
    """RejectedError where a variable that is followed depends on one that is not."""
    depends = depends_on(system)
    for name in part.followed:
        unknown = depends[name] - set(part.followed)
        if unknown:
            raise RejectedError(f"{name} is followed, but not {', '.join(sorted(unknown))}, on which it depends")
