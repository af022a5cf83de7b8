"""Certificates about stated systems as documents: header, claim, and proofs of four kinds, the classes of which have
the members that files have.

Does: the data of each; reads a certificate of any of the four forms.
Assumes: a document that anyone made.
Does not: say whether a certificate is accepted (branch_proofs.py, ../covers and ../flows).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING, Any, Literal

from msgspec import field

from verify.checker import certificate
from verify.checker.certificate import Bytes, Certificate, Forms, Header, Members, stated_as
from verify.claims.formula import Linear, read_formula
from verify.exact import read_number
from verify.systems.claims import Pattern, SystemClaim, SystemPremise
from verify.systems.system import Affine, HalfSpace, Polytope

WHOLE = bytes(1)  # cuts of a set that is not cut


def read_region(halves: Sequence[Mapping[str, Any]]) -> Polytope:
    """A polytope in a file. ValueError for what is none."""
    polytope: list[HalfSpace] = []
    for document in halves:
        formula = read_formula(document)
        if not isinstance(formula, Linear):
            raise ValueError(f"not an inequality: {str(document)[:80]}")
        form = Affine.of({name: weight for weight, name in formula.terms}, -formula.bound)
        polytope.append(HalfSpace(form, formula.strict))
    return tuple(polytope)


if TYPE_CHECKING:
    StatedRegion = Polytope
else:
    StatedRegion = stated_as(read_region, tuple)  # inequalities in a document


# --- symbolic states


class Hull(Members, frozen=True):
    """States at a step, all of which are followed from there on in place of the symbolic states that lie in it."""

    step: int
    region: StatedRegion


class FollowedPart(Members, frozen=True):
    """The variables that a proof follows, and what is shown by them alone."""

    followed: tuple[str, ...]
    shows: tuple[int, ...]  # which ways to break the claim do not happen (see `ways`); the number after them: unstated
    hulls: tuple[Hull, ...]
    proof: Bytes


class Walks(Members, frozen=True):
    """Proofs that are walked, one of each part of the claim."""

    parts: tuple[FollowedPart, ...]


# --- sets of which each is made from the one before


class Cover(Members, frozen=True):
    """The parameters of a cover's sets: the widths of cells by variable, and how the start is cut; or that its sets
    are affine forms, which are not joined.
    """

    cells: Mapping[str, Fraction]
    cuts: Bytes
    sets: Literal["boxes", "forms"] = "boxes"


class FlowSets(Members, frozen=True):
    """The parameters of a flow's sets. Without cells sets are not joined."""

    order: int  # of the series
    steps: int  # of a period
    cells: Mapping[str, Fraction]  # widths by variable
    cuts: Bytes  # of the start
    joined_every: int = 1  # so many samples sets are joined, by levels
    levels: int = 0  # of cells, each half as wide as those before; 0: cells of one width


# --- invariants


class InvariantRegion(Members, frozen=True):
    """A region of an invariant, and how it is cut. `walk`: the proof of one step from it; None: boxes show it."""

    region: StatedRegion
    cuts: Bytes
    walk: Bytes | None = None


class InvariantPart(Members, frozen=True):
    """An invariant of some variables. Cells: their `widths` by variable, within how many `steps` each comes back, and
    the cells. Or regions: how many `steps` in a row lead to another state in them. `cuts` of the start, and the widths
    of the cells in which boxes are joined, lead to the first step of which the claim speaks.
    """

    widths: Mapping[str, Fraction]
    steps: int
    cells: Bytes
    regions: tuple[InvariantRegion, ...] = ()
    cuts: Bytes = WHOLE
    joined: Mapping[str, Fraction] = field(default_factory=dict[str, Fraction])

    @property
    def followed(self) -> list[str]:
        """The variables."""
        halves = [half for each in self.regions for half in each.region]
        return list(self.widths) or list(dict.fromkeys(name for half in halves for name, _ in half.form.terms))


class Invariant(Members, frozen=True):
    """Invariants of some variables each, all of which hold at once."""

    parts: tuple[InvariantPart, ...]


# --- certificates


class SystemHeader(Header, frozen=True):
    """The header of a certificate about a stated system."""

    system: str  # content hash


class SystemPremiseJson(Members, frozen=True):
    """The left side of an implication, and a state that meets it."""

    formula: dict[str, Any]
    state: dict[str, str]


class SystemClaimJson(Members, frozen=True):
    """A claim in a file."""

    name: str
    kind: str
    regions: list[list[dict[str, Any]]]
    steps: int
    by: int
    formula: dict[str, Any]
    label: str
    region: str
    assuming: list[list[dict[str, Any]]] = field(default_factory=list[list[dict[str, Any]]])
    assumed: str = ""
    premises: list[SystemPremiseJson] = field(default_factory=list[SystemPremiseJson])


class _Claim(Members, frozen=True):
    claim: SystemClaimJson
    at_samples: bool | None = None  # of a flow: whether the claim is about samples only

    def read(self, header: Header) -> SystemClaim:
        kind, claim = PROOFS[header.certificate], replace(read_claim(self.claim), at_samples=self.at_samples)
        if (self.at_samples is None) == (kind is FlowSets):
            raise ValueError("$.at_samples: stated of flows, and of nothing else")
        if (kind is Cover and claim.about_decisions) or (kind is Invariant and not claim.says.ever):
            raise ValueError("$.claim: one that no proof of this form shows")
        return claim


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
        premises=tuple(
            SystemPremise(read_formula(each.formula), {name: read_number(value) for name, value in each.state.items()})
            for each in raw.premises
        ),
    )


SystemProof = Walks | Cover | FlowSets | Invariant
SystemCertificate = Certificate[SystemHeader, SystemClaim, SystemProof]
PROOFS: Mapping[str, type[SystemProof]] = {
    "maviper-system-certificate-1": Walks,
    "maviper-system-certificate-2": Cover,
    "maviper-system-certificate-3": FlowSets,
    "maviper-system-certificate-4": Invariant,
}
FORMS = Forms(SystemHeader, _Claim, PROOFS)


def from_json(
    text: str | bytes, where: str = "certificate", followed: Callable[[bytes], bytes] = Bytes
) -> SystemCertificate:
    """The certificate in a text, of any form, its proofs given to `followed`. InputError when it is damaged, of another
    version, or edited.
    """
    return certificate.read(text, where, FORMS, followed)
