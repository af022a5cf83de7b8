"""Monitors: from a certificate to code that says whether a state is one for which its claim is proved.

Does: checks the certificate against the profile that is compiled; takes its region, rounds its bounds inward, emits.
Assumes: a build of the profile; certificates that anyone wrote.
Does not: trust a proof that the checker refuses; watch what a certificate has no region for.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path

import msgspec

from codegen.agreement.compiled import Build
from codegen.deciding import ensure_forgets, sums_in
from codegen.errors import InputError, RefusedError, escape_text
from codegen.ir import PolicyProfile
from codegen.lowering.covering import Cover
from codegen.lowering.model import Model
from codegen.lowering.tracking import MAX_NOISE, Edges, Start, ensure_followed
from codegen.lowering.watching import Watch, watch, watch_inputs
from codegen.numbers import decimal_literal, nearest_double
from codegen.targets.rendered import emit_monitors
from codegen.world import RegionSpec
from maviper.files import kinds, runs
from verify.checker import certificate as certificates
from verify.checker import decisions
from verify.checker.episodes import certificates as episodes
from verify.checker.episodes.unbounded import EdgeReading
from verify.checker.episodes.unbounded import Edges as EdgesProof
from verify.checker.reading import RejectedError
from verify.claims.parameters import Number
from verify.claims.region import Region
from verify.decimals import exact, plain
from verify.kinds import MACHINE


@dataclass(frozen=True)
class Proved:
    """The content of an accepted certificate: in which states its claim is proved."""

    region: RegionSpec | Cover | Start | Edges
    certificate: str  # content hash
    claim: str  # in words
    stated: bool = False  # whether the certificate is about a world file


def load_proof(certificate: Path, profile: PolicyProfile) -> Proved:
    """Returns what a certificate proves of a profile.

    InputError for a certificate of another profile, of two profiles, or of a kind that has no region for each step;
    RefusedError where its proof does not hold.
    """
    text = runs.read_unpacked(certificate, certificates.MAX_BYTES)
    kind = kinds.kind_of(text)
    if kind not in (kinds.SYSTEM_CERTIFICATE, kinds.EPISODE_CERTIFICATE):
        kinds.ensure(text, str(certificate), kinds.CERTIFICATE.called, kinds.CERTIFICATE)
    if kind is kinds.SYSTEM_CERTIFICATE:
        from maviper.compilation.covers import load_cover  # here, since most profiles are of games

        region, claim = load_cover(certificate, profile)
        return Proved(region, _hash(text), claim, stated=True)
    if sums_in(profile):
        what = "the certificate is about tests of single features, and this profile tests sums or gives numbers"
        advice = "give one with a world file beside it, or leave it out: then inputs and outputs are watched"
        raise InputError(what, str(certificate), advice)
    ensure_forgets(profile, "a certificate about a game")
    if kind is kinds.EPISODE_CERTIFICATE:
        return _episodes(text, certificate, profile)
    try:
        proof = certificates.read(text, str(certificate), decisions.FORMS)
        header = proof.header
        if header.against:
            raise InputError("the certificate compares two profiles, and a monitor watches one", str(certificate))
        if header.view is not None:
            what = "the certificate is about observations, and a monitor watches world states"
            raise InputError(what, str(certificate), "verify the claim for a profile whose features have meanings")
        if header.semantics != MACHINE:
            what = "the certificate is about exact arithmetic, and the code decides in floats"
            raise InputError(what, str(certificate), f"verify the claim with --semantics {MACHINE}")
        decisions.check_certificate(proof, profile)
    except RejectedError as error:
        advice = "do not rely on it; run `maviper verify` again"
        raise RefusedError("the certificate is refused", f"{certificate}: {escape_text(error)}", advice) from None
    named = proof.claim.property
    claim = "a formula" if named is None else f"{named.name} of the {named.team}"
    return Proved(spec_of(header.region), _hash(text), claim)


def _episodes(text: bytes, where: Path, profile: PolicyProfile) -> Proved:
    """Returns what a certificate about episodes proves: where they start, and whose actions it is about."""
    try:
        proof = certificates.read(text, str(where), episodes.FORMS)
        claim, region, followed = proof.claim, proof.header.region, proof.proof.followed
        if not isinstance(proof.proof, EdgesProof):
            ensure_followed(profile.world, claim.steps)  # first: to check a proof about contacts takes seconds
        episodes.check_certificate(proof, profile)
    except RejectedError as error:
        advice = "do not rely on it; run `maviper verify` again"
        raise RefusedError("the certificate is refused", f"{where}: {escape_text(error)}", advice) from None
    names = [name for group in followed for name in group]
    said = f"{claim.name} of the {claim.team}"
    if isinstance(proof.proof, EdgesProof):
        lasting = f"{said} for ever, as long as {' and '.join(names)} act by their trees"
        return Proved(_find_edges(proof.proof, region, profile), _hash(text), lasting)
    start = Start(spec_of(region), claim.steps, frozenset(names))
    return Proved(start, _hash(text), f"{said} in {claim.steps} steps")


ROOM = Fraction(1, 1 << 48)  # of what rounding hides of where an agent comes to rest: three roundings of 2^-53


def _find_edges(proof: EdgesProof, region: Region, profile: PolicyProfile) -> Edges:
    """The states from which agents never cross the edges of a proof: those that its induction over steps holds of."""
    axes = EdgeReading(profile, region).axes
    coasting = nearest_double(next(iter(axes.values())).coasting)  # the same for all
    box = {name: ends for name, ends in region.box.items() if not name.endswith((".vx", ".vy")) and name not in axes}
    for name, axis in axes.items():
        entity, _, direction = name.rpartition(".")
        fastest = axis.fastest(-1), axis.fastest(1)
        box[f"{entity}.v{direction}"] = -fastest[0], fastest[1]
        if name in proof.edges:
            low, high = proof.edges[name]
            room = ROOM * (1 + max(abs(low), abs(high)) + axis.coasting * max(fastest))
            box[name] = low + room, high - room
    return Edges(spec_of(Region(box, region.goals)), coasting)


def noisy(proved: Proved, noise: Number | None) -> Proved:
    """Returns what is proved for numbers that are off by so much at most.

    Then the monitor follows the episode of the proof that is near what it is given. InputError where it compares single
    states, and for a noise that is none.
    """
    if noise is None:
        return proved
    if not isinstance(proved.region, Start):
        what = "the monitor compares single states with sets, which leave no room for noise"
        raise InputError(what, "--noise", "give it for the certificate of a claim about episodes of a game")
    given = exact(str(noise), "--noise")
    if not 0 < given <= MAX_NOISE:
        raise InputError(f"the noise is {noise}", "--noise", f"give a number above 0 and at most {MAX_NOISE:g}")
    off = nearest_double(given)
    claim = f"{proved.claim}, of an episode near the true one: each number within {decimal_literal(3.0 * off)} of it"
    return replace(proved, region=replace(proved.region, noise=off), claim=claim)


def files_of(build: Build, proved: Proved | None, targets: Sequence[str]) -> dict[str, str]:
    """The monitors of a build by file name, one for each language among its targets: of what is proved, else of inputs
    and outputs. InputError as `watch`.
    """
    profile, model = build.profile, build.model
    return emit_monitors(lower_monitor(profile, model, proved) if proved else watch_inputs(profile, model), targets)


def lower_monitor(profile: PolicyProfile, model: Model, proved: Proved) -> Watch:
    """The lowered monitor of what is proved. InputError as `watch`."""
    return watch(profile, model, proved.region, proved.certificate, proved.claim)


def spec_of(region: Region) -> RegionSpec:
    """A region as profiles and code have it, its numbers as exact text."""
    return RegionSpec(
        region.goals,
        {name: (plain(low), plain(high)) for name, (low, high) in region.box.items()},
        {f"{a} - {b}": (plain(low), plain(high)) for a, b, (low, high) in region.differences},
        {f"{a} - {b}": plain(least) for a, b, least in region.apart},
    )


def _hash(text: bytes) -> str:
    """The content hash that a certificate states, which reading it has compared."""
    return str(msgspec.json.decode(text)["content_hash"])
