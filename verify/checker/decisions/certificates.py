"""Certificates of claims about single decisions: the document with its proof, and whether it is accepted.

Does: reads the document; whether a certificate fits a profile and passes the checker.
Assumes: a profile that was read and checked; proofs of the form that README.md specifies, made by anyone.
Does not: prove, or write (verify/certificates).
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from fractions import Fraction
from typing import Any, NamedTuple

import msgspec

from codegen.errors import InputError, escape_text
from codegen.ir import GOAL, NO_FEATURE, ROOT, AgentPolicy, PolicyProfile
from codegen.policy_json import content_hash
from verify.checker.decisions import walk as decisions
from verify.checker.envelope import REMAKE, ensure_about, ensure_readable, ensure_whole, numbers, read_proof
from verify.checker.reading import RejectedError, region_formula
from verify.checker.thresholds import NO_ERROR, sides
from verify.claims.claim import check_range, read_by, verifiable
from verify.claims.decisions import BY_NAME, KAPPA, PLAIN, STEADY, DecisionClaim, ensure_askable, ensure_steady, formula
from verify.claims.formula import Formula, agents, conjuncts, coordinates, for_goal, holds, names_goal, read_formula
from verify.claims.observed import View, over, view_from
from verify.claims.pairs import alike, ensure_comparable, pair_profiles
from verify.claims.region import Region, goal_of, goal_text
from verify.claims.relations import RELATIONS
from verify.exact import read_number
from verify.semantics import MACHINE, SEMANTICS, Semantics

FORM = "maviper-certificate-1"
PARTED = "maviper-certificate-2"  # its proofs are those of the conjuncts, one after the other
MET, MET_PARTED = "maviper-certificate-3", "maviper-certificate-4"  # the same, with the left sides of implications
FORMS = (FORM, PARTED, MET, MET_PARTED)
MAX_BYTES = 1 << 30
STATED = {"name", "goals", "box", "difference", "apart"}  # of a region
NAMED = ("name", "team", "margin", "radius", "kappa", "landmarks")  # of a property, what a certificate states
NOISY = ("eps", "of")  # and of steady
COMPARED = tuple(dict.fromkeys(name for kind in RELATIONS.values() for name in kind.reads))  # of those that compare
TYPES = {each.name: each.type for kind in (*BY_NAME.values(), *RELATIONS.values()) for each in fields(kind)}
LARGEST = 2**1000  # more than any place of a world
UNREAD = {"kappa": KAPPA, "landmarks": ()}  # what it states of a property that does not read them


class Premise(NamedTuple):
    """The left side of an implication, with a state that meets it."""

    formula: Formula
    goal: str | None
    state: Mapping[str, Fraction]


@dataclass(frozen=True)
class Certificate:
    """A claim about a profile in a region, with a proof for each goal."""

    profile: str  # content hash
    claim: DecisionClaim | None  # the named property; None for a formula without a name
    formula: Formula
    region: Region
    semantics: str  # see thresholds.py
    inhabitant: Mapping[str, Fraction]  # a point of the region, which shows that it is not empty
    proofs: Mapping[str | None, bytes]  # goal (None without goals) -> proof
    eps: Fraction = NO_ERROR  # by how much each measured feature may be off
    region_said: str = field(default="", compare=False)  # what a file that was read calls its region; says nothing
    form: str = FORM  # by which the proofs are to be read
    against: str = ""  # content hash of a second profile: the claim is that agents act alike in both
    view: View | None = None  # where the claim is over observations: how they are put together
    premises: tuple[Premise, ...] = ()  # the left sides of its implications

    @property
    def says_left_sides(self) -> bool:
        """True if the certificate states the left sides of its claim, of which each can hold."""
        return self.form in (MET, MET_PARTED)

    @property
    def size(self) -> int:
        """Bytes of all proofs."""
        return sum(map(len, self.proofs.values()))


def check_certificate(certificate: Certificate, profile: PolicyProfile, against: PolicyProfile | None = None) -> int:
    """Checks a certificate; the number of branches that its proofs close. `against`: the second profile, where it is
    about two.

    InputError when it is about another policy or names what the profile does not have; RejectedError when a proof is
    missing or does not hold, or the formula is not the property's.
    """
    ensure_about(certificate.profile, content_hash(profile), "profile", "--profile")
    if certificate.against:
        profile = _pair(certificate, profile, against)
    profile = profile if certificate.view is None else over(profile, certificate.view)
    claim = certificate.claim
    ensure_known_names(certificate, profile, None if claim is None else claim.team)
    if claim is not None:
        verifiable(profile, claim.team)
        try:
            same = formula(profile, claim) == certificate.formula
        except (LookupError, ValueError):  # a property of other agents or landmarks
            same = False
        if not same:
            raise RejectedError(f"the formula is not the one that {claim.name} has for this profile")
        view = certificate.view or View()
        if claim.of_view(view) != view:  # a formula need not name the features in which a copy differs
            raise RejectedError(f"the view is not the one that {claim.name} is about")
        ensure_askable(profile, claim)
        if claim.eps != certificate.eps:
            raise RejectedError(
                f"{claim.name} is about errors up to {claim.eps}, but the proof about errors up to {certificate.eps}"
            )
    check_range("eps", certificate.eps)
    region = certificate.region
    if not holds(region_formula(region), certificate.inhabitant, {}):
        raise RejectedError("its inhabitant is not a state of the region, so the claim may be vacuous")
    for premise in certificate.premises:
        check_premise(premise, profile, region, certificate.semantics)
    goals = region.goal_cases
    if set(goals) != set(certificate.proofs):
        proved, stated = (
            sorted(escape_text(goal_text(goal)) for goal in certificate.proofs),
            sorted(map(goal_text, goals)),
        )
        raise RejectedError(f"the proofs are for the goals {proved}, but the region has {stated}")
    closed, semantics = list[int](), Semantics(certificate.semantics, certificate.eps)
    parts = conjuncts(certificate.formula) if certificate.form in (PARTED, MET_PARTED) else (certificate.formula,)
    for_any_goal = not _names_goal(certificate.formula, profile)
    for goal in goals:
        if for_any_goal and closed and certificate.proofs[goal] == certificate.proofs[goals[0]]:
            closed.append(closed[0])  # the same question, and the same proof
            continue
        try:
            asked, proof = [for_goal(part, goal) for part in parts], numbers(certificate.proofs[goal])
            closed.append(decisions.check_all(profile, asked, region, goal, semantics, proof))
        except RejectedError as error:
            raise RejectedError(f"goal {goal or 'none'}: {error}") from None
    return sum(closed)


def check_premise(premise: Premise, profile: PolicyProfile, region: Region, semantics: str) -> None:
    """RejectedError where the state of a left side does not meet it."""
    formula, goal, state = premise
    if set(state) != set(region.box) or goal not in region.goal_cases:
        raise RejectedError("the state of a left side is not one of the region's")
    if not holds(region_formula(region), state, {}):
        raise RejectedError("the state of a left side does not lie in the region")
    if semantics == MACHINE and not all(map(_is_float64, state.values())):
        raise RejectedError("the state of a left side is not one of float64 numbers")
    at = state if goal is None else {**state, **{f"{GOAL}.{axis}": state[f"{goal}.{axis}"] for axis in "xy"}}
    actions = {agent: _act(profile.policy(agent), at, semantics) for agent in agents(formula)}
    if not holds(for_goal(formula, goal), at, actions):
        raise RejectedError("the state of a left side does not meet it")


def _is_float64(value: Fraction) -> bool:
    return abs(value) < LARGEST and Fraction(float(value)) == value


def _act(policy: AgentPolicy, at: Mapping[str, Fraction], semantics: str) -> int:
    """The action that an agent takes in a state."""
    tree, node = policy.tree, ROOT
    while tree.feature[node] != NO_FEATURE:
        feature, threshold = policy.features[int(tree.feature[node])], float(tree.threshold[node])
        try:
            left = sides(feature, threshold, policy.numbers, semantics)[0]
        except InputError as error:
            raise RejectedError(error.what) from None
        node = int(tree.left[node] if holds(left, at, {}) else tree.right[node])
    return int(tree.action[node])


def _names_goal(claim: Formula, profile: PolicyProfile) -> bool:
    """Returns True if a formula, or a test of an agent in it, names the goal: else all goals are one question."""
    acting = agents(claim)
    return names_goal(claim) or any(GOAL in read_by(profile.policy(agent)) for agent in acting)


def _pair(certificate: Certificate, first: PolicyProfile, second: PolicyProfile | None) -> PolicyProfile:
    """Both profiles of a certificate about two as one; RejectedError where it claims anything but that agents act
    alike in them.
    """
    if second is None:
        raise InputError("the certificate is about two profiles", "", "name the second one with --against")
    ensure_about(certificate.against, content_hash(second), "profile", "--against")
    compared = find_compared_agents(certificate, first)
    ensure_comparable(first, second, compared)
    other = certificate.claim is not None or certificate.eps or certificate.view is not None
    if other or certificate.formula != alike(first, compared):
        raise RejectedError("the formula is not that agents act alike in both profiles")
    return pair_profiles(first, second)


def find_compared_agents(certificate: Certificate, first: PolicyProfile) -> list[str]:
    """The agents that a certificate about two profiles compares, in the order of the first."""
    speaking = agents(certificate.formula)
    return [policy.agent for policy in first.agents if policy.agent in speaking]


def ensure_known_names(certificate: Certificate, profile: PolicyProfile, team: str | None) -> None:
    """InputError when a certificate, or the team of its claim, speaks of what the profile does not have."""
    region, world = certificate.region, profile.world
    entities = [entity.name for entity in world.agents + world.landmarks]
    stated = (certificate.formula, *(premise.formula for premise in certificate.premises))
    used = {*region.box, *(name for each in stated for name in coordinates(each))}
    used |= {name for a, b, _ in region.differences for name in (a, b)}
    bounded = {name for name in region.box if not name.startswith(f"{GOAL}.")}  # the goal's place is its landmark's
    compared = {f"{name}.{axis}" for a, b, _ in region.apart for name in (a, b) for axis in "xy"}
    compared |= {name for a, b, _ in region.differences for name in (a, b)}
    strange = [
        *sorted(set(region.box) - bounded),
        *sorted(compared - bounded),
        *sorted(used - set(world.coordinates())),
        *sorted({name for a, b, _ in region.apart for name in (a, b)} - set(entities)),
        *sorted(set(region.goals) - set(world.goals)),
        *sorted({name for each in stated for name in agents(each)} - {policy.agent for policy in profile.agents}),
        *([f"the profile has no team {team}"] if team is not None and not profile.team(team) else []),
    ]
    if strange:
        what = "the certificate names what the profile does not have"
        raise InputError(what, ", ".join(map(escape_text, strange)), REMAKE)
    if set(certificate.inhabitant) != set(region.box) or (world.goals and not region.goals):
        raise InputError("the certificate's region and inhabitant do not fit together", "$.inhabitant", REMAKE)


# --- the text


class PremiseJson(msgspec.Struct, forbid_unknown_fields=True):
    """A left side, the goal, and a state that meets it."""

    formula: dict[str, Any]
    goal: str
    state: dict[str, str]


class CertificateJson(msgspec.Struct, forbid_unknown_fields=True):
    """The members of the file; numbers are exact texts."""

    certificate: str
    profile: str
    property: dict[str, str | list[str]] | None
    semantics: str
    region: dict[str, Any]
    formula: dict[str, Any]
    inhabitant: dict[str, str]
    proofs: dict[str, list[str]]
    content_hash: str
    eps: str | msgspec.UnsetType = msgspec.UNSET  # stated where features may be off
    against: str | msgspec.UnsetType = msgspec.UNSET  # stated where it is about two profiles
    view: dict[str, list[str]] | msgspec.UnsetType = msgspec.UNSET  # stated of claims over observations
    premises: list[PremiseJson] | msgspec.UnsetType = msgspec.UNSET  # stated since the third form


def from_json(text: str | bytes, where: str = "certificate") -> Certificate:
    """The certificate in a text. InputError when it is damaged, of another version, or edited."""
    with ensure_readable(where):
        raw = msgspec.json.decode(text, type=CertificateJson)
        ensure_whole(raw, raw.certificate if raw.certificate in FORMS else FORM, where)
        return _certificate(raw)


def _certificate(raw: CertificateJson) -> Certificate:
    if raw.semantics not in SEMANTICS:
        raise ValueError(f"$.semantics: {raw.semantics[:40]!r}")
    eps = NO_ERROR if isinstance(raw.eps, msgspec.UnsetType) else read_number(raw.eps)
    if not isinstance(raw.eps, msgspec.UnsetType) and eps <= 0:
        raise ValueError(f"$.eps: {raw.eps[:40]!r}")
    premises = () if isinstance(raw.premises, msgspec.UnsetType) else tuple(map(_premise, raw.premises))
    if isinstance(raw.premises, msgspec.UnsetType) == (raw.certificate in (MET, MET_PARTED)):
        raise ValueError(f"$.premises: stated by {MET} and {MET_PARTED}, and by no other")
    return Certificate(
        profile=raw.profile,
        claim=None if raw.property is None else _property(raw.property),
        formula=read_formula(raw.formula),
        region=region_from(raw.region),
        semantics=raw.semantics,
        inhabitant={name: read_number(value) for name, value in raw.inhabitant.items()},
        proofs={goal_of(goal): read_proof(lines, f"$.proofs.{goal}") for goal, lines in raw.proofs.items()},
        eps=eps,
        region_said=str(raw.region["name"]),
        form=raw.certificate,
        against="" if isinstance(raw.against, msgspec.UnsetType) else raw.against,
        view=None if isinstance(raw.view, msgspec.UnsetType) else view_from(raw.view),
        premises=premises,
    )


def _premise(raw: PremiseJson) -> Premise:
    state = {name: read_number(value) for name, value in raw.state.items()}
    return Premise(read_formula(raw.formula), goal_of(raw.goal), state)


def _property(document: Mapping[str, str | list[str]]) -> DecisionClaim:
    """The named property. ValueError for a name whose formula is not all that it claims, or another parameter."""
    steady = document["name"] == STEADY
    named, key = (NAMED + NOISY, "of") if steady else (NAMED, "name")
    kind = document.get(key, "")
    named += () if kind in PLAIN else COMPARED
    if kind not in (*PLAIN, *RELATIONS):  # the formula of others is not all that they claim
        raise ValueError(f"$.property.{key}: {kind[:40]!r}")
    given: dict[str, Any] = {}
    for name, value in document.items():
        if name not in named:
            raise ValueError(f"$.property.{name}: a certificate states {', '.join(named)}")
        if isinstance(value, str) == (TYPES.get(name) == tuple[str, ...]):
            raise ValueError(f"$.property.{name}: {value}")
        if name not in ("name", "of"):
            text = TYPES[name] is str
            given[name] = value if text else tuple(value) if isinstance(value, list) else read_number(value)
    made = (BY_NAME | RELATIONS)[str(kind)]
    for name, usual in UNREAD.items():
        if name not in made.reads and given.pop(name, usual) != usual:
            raise ValueError(f"$.property.{name}: {kind} does not read it")
    claim = made(**given)
    ensure_steady(STEADY if steady else claim.name, claim)
    return claim


def region_from(document: Mapping[str, Any]) -> Region:
    """The region of a certificate, without its name: by that anybody could call any region the start."""

    def pair(text: str) -> tuple[str, str]:
        first, second = text.split(" - ")
        return first, second

    def interval(bounds: Any) -> tuple[Fraction, Fraction]:
        low, high = map(read_number, bounds)
        return low, high

    if strange := document.keys() - STATED:
        raise ValueError(f"$.region.{min(strange)[:40]}: a region does not state it")
    box = {name: interval(bounds) for name, bounds in document["box"].items()}
    differences = tuple((*pair(text), interval(bounds)) for text, bounds in document["difference"].items())
    apart = tuple((*pair(text), read_number(least)) for text, least in document["apart"].items())
    return Region(box, tuple(map(str, document["goals"])), differences, apart)
