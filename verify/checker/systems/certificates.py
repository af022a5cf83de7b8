"""Certificates of claims about stated systems: the document with its proofs, and whether it is accepted.

Does: reads the document; whether a certificate fits a profile and a system and passes the checker.
Assumes: a profile and a system that were read and checked; proofs of the form that README.md specifies, made by anyone.
Does not: prove, or write (verify/certificates).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any, ClassVar, Protocol

import msgspec

from codegen.errors import InputError, escape_text
from codegen.ir import ROOT, PolicyProfile
from codegen.policy_json import content_hash
from verify.checker.envelope import (
    REMAKE,
    ensure_about,
    ensure_readable,
    ensure_whole,
    numbers,
    read_proof,
)
from verify.checker.reading import RejectedError
from verify.checker.systems.cases import ensure_cases
from verify.checker.systems.trees import sides_of
from verify.checker.systems.walk import FollowedPart, Hull, Proof, SystemQuestions, ways
from verify.claims.formula import Acts, Linear, agents, atoms, coordinates, holds
from verify.claims.formula_json import read_formula
from verify.exact import read_number
from verify.systems import documents
from verify.systems.claims import Pattern, SystemClaim, SystemPremise
from verify.systems.system import Affine, HalfSpace, Polytope, State, System, ensure_in_steps

FORM = "maviper-system-certificate-1"
BITS = 7 * 1_000  # of the largest number in a proof


class Certified(Protocol):
    """What certificates about stated systems share, whatever their proofs are."""

    @property
    def profile(self) -> str:
        """Content hash of the profile."""
        ...

    @property
    def system(self) -> str:
        """Content hash of the system."""
        ...

    @property
    def claim(self) -> SystemClaim:
        """What is claimed."""
        ...

    @property
    def inhabitant(self) -> Mapping[str, Fraction]:
        """A state that the claim is about."""
        ...


@dataclass(frozen=True)
class SystemCertificate:
    """A claim about a profile in a stated system, with proofs of its parts."""

    profile: str  # content hash
    system: str  # content hash
    claim: SystemClaim
    inhabitant: Mapping[str, Fraction]  # a state that the claim is about, which shows that there is one
    parts: tuple[FollowedPart, ...]

    counted: ClassVar[str] = "branches"
    unit: ClassVar[str] = "branch"

    @property
    def size(self) -> int:
        """Bytes of all proofs."""
        return sum(len(part.proof) for part in self.parts)

    @property
    def made_of(self) -> dict[str, Any]:
        """What a report says of its proofs beside their size."""
        return {"parts": [list(part.followed) for part in self.parts]}

    def reading(self, reader: Callable[[bytes], bytes]) -> SystemCertificate:
        """The same with its proofs given to a reader."""
        return replace(self, parts=tuple(part._replace(proof=reader(part.proof)) for part in self.parts))

    def check(self, profile: PolicyProfile, system: System, watch: object = None) -> int:
        """As the function. `watch` hears nothing: there are no boxes."""
        return check_certificate(self, profile, system)


def check_certificate(certificate: SystemCertificate, profile: PolicyProfile, system: System) -> int:
    """Checks a certificate; the number of branches that its proofs close by sums of rows.

    InputError when it is about another profile or system, or names what they do not have; RejectedError when a proof is
    missing or does not hold.
    """
    if not certificate.claim.about_decisions:
        ensure_in_steps(system, "this form of certificate")
    named = {name for part in certificate.parts for name in part.followed}
    hulls = [hull for part in certificate.parts for hull in part.hulls]
    named |= {name for hull in hulls for half in hull.region for name, _ in half.form.terms}
    ensure_asked(certificate, named, profile, system)
    _ensure_all_shown(certificate, system)
    closed = 0
    for number, part in enumerate(certificate.parts):
        _ensure_closed(system, part)
        proof = Proof(numbers(part.proof, BITS))
        try:
            SystemQuestions(profile, system, certificate.claim, part, proof).run()
            proof.ensure_read()
        except RejectedError as error:
            raise RejectedError(f"part {number}: {error}") from None
        closed += proof.closed
    return closed


def ensure_asked(
    certificate: Certified, named: set[str], profile: PolicyProfile, system: System, ever: bool = False
) -> None:
    """That a certificate asks something of this profile and system. `named`: variables that its proof names; `ever`:
    whether it can show what holds at all steps, and nothing else.

    InputError when it is about others, or names what they do not have; RejectedError where its claim is about nothing.
    """
    ensure_about(certificate.profile, content_hash(profile), "profile")
    ensure_about(certificate.system, documents.content_hash(system), "system")
    _ensure_known(certificate, named, profile, system)
    certificate.claim.ensure()
    if certificate.claim.says.ever != ever:
        raise RejectedError("the claim is about all steps, or this form of certificate is about nothing else")
    if not _is_state(certificate.claim, certificate.inhabitant, system):
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
    """Whether an episode may leave what is stated: then it is to be shown that none does."""
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


def _ensure_known(certificate: Certified, named: set[str], profile: PolicyProfile, system: System) -> None:
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
    states = [certificate.inhabitant, *(premise.state for premise in claim.premises)]
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


def _ensure_all_shown(certificate: SystemCertificate, system: System) -> None:
    claim = certificate.claim
    asked = set(range(ways(claim) + needs_stated(claim, system)))
    missing = asked - {way for part in certificate.parts for way in part.shows}
    if missing:
        raise RejectedError(f"no part shows that the claim is not broken in the ways {sorted(missing)}")


def _ensure_closed(system: System, part: FollowedPart) -> None:
    """RejectedError where a variable that is followed depends on one that is not."""
    depends = depends_on(system)
    for name in part.followed:
        unknown = depends[name] - set(part.followed)
        if unknown:
            raise RejectedError(f"{name} is followed, but not {', '.join(sorted(unknown))}, on which it depends")


# --- the text


class HullJson(msgspec.Struct, forbid_unknown_fields=True):
    """States at a step, as inequalities that all hold."""

    step: int
    region: list[dict[str, Any]]


class FollowedPartJson(msgspec.Struct, forbid_unknown_fields=True):
    """A proof in the file."""

    followed: list[str]
    shows: list[int]
    hulls: list[HullJson]
    proof: list[str]


class SystemPremiseJson(msgspec.Struct, forbid_unknown_fields=True):
    """The left side of an implication, and a state that meets it."""

    formula: dict[str, Any]
    state: dict[str, str]


class SystemClaimJson(msgspec.Struct, forbid_unknown_fields=True, omit_defaults=True):
    """A claim in a file."""

    name: str
    kind: str
    regions: list[list[dict[str, Any]]]
    steps: int
    by: int
    formula: dict[str, Any]
    label: str
    region: str
    assuming: list[list[dict[str, Any]]] = []
    assumed: str = ""
    premises: list[SystemPremiseJson] = []


class SystemCertificateJson(msgspec.Struct, forbid_unknown_fields=True):
    """The members of the file; numbers are exact texts."""

    certificate: str
    profile: str
    system: str
    claim: SystemClaimJson
    inhabitant: dict[str, str]
    parts: list[FollowedPartJson]
    content_hash: str


def from_json(text: str | bytes, where: str = "certificate") -> SystemCertificate:
    """The certificate in a text. InputError when it is damaged, of another version, or edited."""
    with ensure_readable(where):
        raw = msgspec.json.decode(text, type=SystemCertificateJson)
        ensure_whole(raw, FORM, where)
        parts = [_part(part, f"$.parts.{number}") for number, part in enumerate(raw.parts)]
        inhabitant = {name: read_number(value) for name, value in raw.inhabitant.items()}
        return SystemCertificate(raw.profile, raw.system, read_claim(raw.claim), inhabitant, tuple(parts))


def _part(raw: FollowedPartJson, where: str) -> FollowedPart:
    hulls = tuple(Hull(hull.step, read_region(hull.region)) for hull in raw.hulls)
    return FollowedPart(tuple(raw.followed), tuple(raw.shows), hulls, read_proof(raw.proof, where))


def read_claim(raw: SystemClaimJson) -> SystemClaim:
    """The claim in a file. ValueError, LookupError or TypeError for one that there is not."""
    if raw.name != raw.kind:
        raise ValueError(f"$.claim: a claim of kind {raw.kind} that is called {raw.name}")
    return SystemClaim(
        pattern=Pattern(raw.kind),
        regions=tuple(map(read_region, raw.regions)),
        steps=raw.steps,
        by=raw.by,
        formula=read_formula(raw.formula),
        assuming=tuple(map(read_region, raw.assuming)),
        label=raw.label,
        region=raw.region,
        assumed=raw.assumed,
        premises=tuple(map(_read_premise, raw.premises)),
    )


def _read_premise(raw: SystemPremiseJson) -> SystemPremise:
    return SystemPremise(read_formula(raw.formula), {name: read_number(value) for name, value in raw.state.items()})


def read_region(halves: Sequence[Mapping[str, Any]]) -> Polytope:
    """A polytope in a file. ValueError for what is none."""
    return tuple(map(_read_half, halves))


def _read_half(document: Mapping[str, Any]) -> HalfSpace:
    formula = read_formula(document)
    if not isinstance(formula, Linear):
        raise ValueError(f"not an inequality: {str(document)[:80]}")
    return HalfSpace(Affine.of({name: weight for weight, name in formula.terms}, -formula.bound), formula.strict)
