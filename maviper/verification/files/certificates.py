"""Certificates as files: written beside a report, and checked by `maviper check`.

Does: names the files of certificates; reads one with its profile, checks it, says what it proves in words: its formula
  with its numbers, the bounds in which its region is not the start region.
Assumes: results of `verify.verdicts.decisions.verify`, or files that anyone wrote.
Does not: prove, or read property files and region files, which may have been changed since.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import msgspec

from codegen.errors import InputError, RefusedError, escape_text
from codegen.ir import PolicyProfile
from codegen.rows import Shown
from maviper.files import kinds, runs
from maviper.files.profiles import find_profile
from maviper.verification.files.systems import FollowedProof
from verify.certificates.proofs import count_bytes
from verify.checker import certificate, decisions
from verify.checker.decisions import DecisionCertificate, FormulaClaim, GameHeader
from verify.checker.episodes import certificates as episodes
from verify.checker.episodes.certificates import EpisodeCertificate
from verify.checker.reading import RejectedError
from verify.claims.catalogue import describe_left_out, opponents_words, select_stated
from verify.claims.claim import Parameter
from verify.claims.formula import Acts, And, Formula, Goal, Linear, Not, Or, agents
from verify.claims.observed import over
from verify.claims.region import Interval, Region
from verify.claims.region_files import everywhere, is_start
from verify.claims.views import describe_view
from verify.decimals import plain

MOST = 300  # characters of a formula or a region that are shown
LEFT_OUT = "... (whole in the certificate)"


def formula_words(formula: Formula, profile: PolicyProfile) -> str:
    """A formula as text, cut where it is long."""
    return _cut(_write_formula(formula, profile))


def region_words(region: Region, profile: PolicyProfile) -> str:
    """The bounds of a region that the start region does not have, cut where they are many."""
    return _cut(", ".join(_bounds(region, profile)))


def _cut(text: str) -> str:
    return text if len(text) <= MOST else f"{text[:MOST]}{LEFT_OUT}"


def _write_formula(formula: Formula, profile: PolicyProfile) -> str:
    match formula:
        case Linear(terms, bound, strict):
            parts = [name if weight == 1 else f"{plain(weight)} * {name}" for weight, name in terms]
            return f"{' + '.join(parts) or '0'} {'<' if strict else '<='} {plain(bound)}"
        case Acts(agent, action):
            return f"acts({agent}) == {profile.policy(agent).actions[action].name}"
        case Goal(landmark):
            return f"goal == {landmark}"
        case Not(part):
            return f"not ({_write_formula(part, profile)})"
        case And(parts) | Or(parts):
            both = isinstance(formula, And)
            written = [_write_formula(part, profile) for part in parts]
            joined = (" and " if both else " or ").join(written) or ("true" if both else "false")
            return f"({joined})" if len(written) > 1 else joined


def _bounds(region: Region, profile: PolicyProfile) -> Iterator[str]:
    usual: Mapping[str, Interval] = {}
    with suppress(InputError):  # no damping bounds the velocities
        usual = everywhere(profile).box
    for name, bounds in region.box.items():
        if usual.get(name) != bounds:
            yield f"{name} in {_interval(*bounds)}"
    yield from (f"{a} - {b} in {_interval(*bounds)}" for a, b, bounds in region.differences)
    yield from (f"{a} and {b} at least {plain(least)} apart" for a, b, least in region.apart)


def _interval(low: Fraction, high: Fraction) -> str:
    return f"[{plain(low)}, {plain(high)}]"


AGAINST_FILE = "against.json"  # the second profile, beside a certificate about two


@dataclass(frozen=True, repr=False)
class Checked(Shown):
    """A certificate whose proof holds.

    For example:

        maviper.check("found/certificate-1-distinct_targets.json").closed
    """

    subject: str  #: what it proves, from what was checked
    closed: int  #: branches of the proof, or its boxes
    size: int  #: bytes of proof; 0: a recipe, whose sets the checker makes again
    unit: str = "branch"  #: of what is counted


def check_file(
    path: Path,
    profile: PolicyProfile | Path | None = None,
    against: PolicyProfile | Path | None = None,
    world: Path | None = None,
) -> Checked:
    """What the certificate in a file proves of a profile (default: profile.json beside it), of a second one where it is
    about two (default: against.json beside it), or in the system of a world file (default: world.toml beside it).

    RefusedError when the proof does not hold.
    """
    text = runs.read_unpacked(path, certificate.MAX_BYTES)
    if kinds.kind_of(text) is kinds.SYSTEM_CERTIFICATE:
        if against is not None:
            raise InputError("the certificate is about one profile", "--against", "leave it out")
        from maviper.verification.files import systems

        return Checked(*systems.check_certificate(path, profile, world))
    if world is not None:
        raise InputError("the certificate is not about a stated system", "--system", "leave it out")
    try:
        kinds.ensure(text, str(path), kinds.CERTIFICATE.called, kinds.CERTIFICATE, kinds.EPISODE_CERTIFICATE)
        if kinds.kind_of(text) is kinds.EPISODE_CERTIFICATE:
            certified = certificate.read(text, str(path), episodes.FORMS, FollowedProof)
            about = find_profile(profile, beside=path)
            closed, subject = episodes.check_certificate(certified, about), _episodes(certified, about)
        else:  # also what says of neither that it is one
            certified = certificate.read(text, str(path), decisions.FORMS, FollowedProof)
            about = find_profile(profile, beside=path)
            other = None
            if certified.header.against:
                other = find_profile(path.parent / AGAINST_FILE if against is None else against, beside=path)
            elif against is not None:
                raise InputError("the certificate is about one profile", "--against", "leave it out")
            closed, subject = decisions.check_certificate(certified, about, other), _subject(certified, about)
    except RejectedError as error:
        raise RefusedError(
            "the certificate is refused",
            f"{path}: {escape_text(error)}",
            "do not rely on it; run `maviper verify` again",
        ) from None
    return Checked(subject, closed, count_bytes(certified.proof))


def _subject(proof: DecisionCertificate, profile: PolicyProfile) -> str:
    """Describes what was proved, from what was checked."""
    header, named, formula = proof.header, proof.claim.property, proof.claim.formula
    if header.against:
        compared = ", ".join(decisions.find_compared_agents(formula, profile))
        return f"{compared} act as in the second profile in {_place(header, profile)}"
    profile = profile if header.view is None else over(profile, header.view)
    claim = "a formula" if named is None else f"{named.name} of the {named.team}"
    if named is None and not agents(formula):
        claim += " that speaks of no agent's actions"
    if named is None and header.eps:
        claim += f", though every feature is off by up to {_format_parameter(header.eps)}"
    if named is not None:
        claim += "".join(f", {name} {_format_parameter(value)}" for name, value in select_stated(named).items())
    claim += "" if header.view is None else f", {describe_view(header.view)},"
    place = f"{claim} in {_place(header, profile)}"
    if named is not None:
        return place
    return f"{place}; the formula: {formula_words(formula, profile)}{_left_sides(proof.claim, profile)}"


def _left_sides(claim: FormulaClaim, profile: PolicyProfile) -> str:
    """Describes what the certificate of a formula shows of the left sides of implications."""
    if claim.premises is not msgspec.UNSET:
        met = [formula_words(premise.formula, profile) for premise in claim.premises]
        return f"; some state meets each of its conditions: {'; '.join(met)}" if met else ""
    parts = claim.formula.parts if isinstance(claim.formula, And) else (claim.formula,)
    implies = any(isinstance(part, Or) for part in parts)
    return "; if it is an implication, the certificate does not show that its left side can hold" if implies else ""


def _episodes(proof: EpisodeCertificate, profile: PolicyProfile) -> str:
    """Describes what was proved of episodes, and what others do."""
    claim, groups = proof.claim, proof.proof.followed
    own = f" {'from' if claim.apart else 'at'} {' '.join(claim.named)}" if claim.named else ""
    followed = sorted({" with ".join(group) for group in groups})
    steps = "for ever" if claim.ever else f"steps {claim.steps}"
    said = f"{claim.name} of the {claim.team}{own}, {steps}, radius {_format_parameter(claim.radius)}"
    opponents = any(profile.policy(agent).team != claim.team for group in groups for agent in group)
    others = f"followed: {', '.join(followed)}, {opponents_words(opponents)}"
    apart = describe_left_out(profile.world)
    about = f"{said}, from rest in {_place(proof.header, profile)}; {others}"
    return about + (f"; {apart}" if apart else "")


def _place(header: GameHeader, profile: PolicyProfile) -> str:
    """A region with its goals and the arithmetic in words: it is called `start` only where it is the start region."""
    region, arithmetic = header.region, f"{header.semantics} arithmetic"
    goals = f", goal {' or '.join(region.goals)}" if region.goals else ""
    if is_start(profile, region):
        return f"region start{goals}, {arithmetic}"
    bounds = region_words(region, profile)
    return f"{f'the region ({bounds})' if bounds else 'a region of its own'}{goals}, {arithmetic}"


def _format_parameter(value: Parameter) -> str:
    if isinstance(value, Fraction):
        return plain(value)
    return " ".join(value) if isinstance(value, tuple) else str(value)
