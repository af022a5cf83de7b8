"""A certificate: a header, a claim and a proof; one reader for all forms.

Does: reads a document by the table of a room.
Assumes: tables that say which members a form has (`Forms`), whose classes are those of the document.
Does not: know what is claimed, whether a proof holds, or how certificates are written (verify/certificates).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, Any, Generic, Protocol, TypeVar, cast

import msgspec

from verify.checker.envelope import ensure_readable, ensure_whole, read_proof
from verify.exact import read_number

MAX_BYTES = 1 << 30  # of a file


class Members(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Members of a document, or of a part of it, under the names that they have there."""


if TYPE_CHECKING:
    Bytes = bytes
else:

    class Bytes(bytes):
        """The bytes of a proof; lines of base64 in a document."""


class Header(Members, frozen=True):
    """The form and the subject of a certificate, and a state that shows that its claim is about something."""

    certificate: str  # the form
    profile: str  # content hash
    inhabitant: Mapping[str, Fraction]


H = TypeVar("H", bound=Header, covariant=True)
C = TypeVar("C", covariant=True)
P = TypeVar("P", bound=Members, covariant=True)


@dataclass(frozen=True)
class Certificate(Generic[H, C, P]):
    """A claim about a profile, with a proof that anyone may have made."""

    header: H
    claim: C
    proof: P

    @property
    def size(self) -> int:
        """Bytes of the proof."""
        return sum(map(len, _list_bytes(self.proof)))


def _list_bytes(value: Any) -> list[bytes]:
    """All bytes in a value that a document states."""
    match value:
        case bytes():
            return [value]
        case msgspec.Struct():
            parts = list(list_stated(value).values())
        case Mapping():
            parts: list[Any] = [*value.values()]
        case tuple():
            parts = list(cast("tuple[Any, ...]", value))
        case _:
            parts = []
    return [each for part in parts for each in _list_bytes(part)]


def list_stated(members: msgspec.Struct) -> dict[str, Any]:
    """The members that a document states: all but those that are as usual."""
    kept: dict[str, Any] = {}
    for each in msgspec.structs.fields(members):
        factory: Any = each.default_factory
        usual = each.default if factory is msgspec.NODEFAULT else factory()
        if (value := getattr(members, each.name)) != usual:
            kept[each.name] = value
    return kept


# --- reading


class ClaimMembers(Protocol[C]):
    """The members of a document that are its claim."""

    def read(self, header: Any) -> C:
        """The claim. ValueError for what is none."""
        ...


@dataclass(frozen=True)
class Forms(Generic[H, C, P]):
    """The certificates of one room: their members beside the proof, and by form those that are the proof."""

    header: type[H]
    claim: type[ClaimMembers[C]]
    proofs: Mapping[str, type[P]]


def read(
    text: str | bytes, where: str, forms: Forms[H, C, P], followed: Callable[[bytes], bytes] = Bytes
) -> Certificate[H, C, P]:
    """The certificate in a text, its proofs given to `followed`. InputError when it is damaged, of another version, or
    edited.
    """

    def convert(kind: Any, value: Any) -> Any:
        if kind is Bytes:
            return followed(read_proof(msgspec.convert(value, list[str]), "a proof"))
        return read_number(value) if kind is Fraction else kind.read(value)

    with ensure_readable(where):
        document = msgspec.json.decode(text, type=dict[str, Any])
        first = next(iter(forms.proofs))
        proof = forms.proofs.get(document.get("certificate", ""), forms.proofs[first])
        parts: list[Any] = [forms.claim, proof]
        named = [{name: document[name] for name in part.__struct_fields__ if name in document} for part in parts]
        own = {name: document[name] for name in document if not any(name in each for each in named)}
        own.pop("content_hash", None)
        header = msgspec.convert(own, forms.header, dec_hook=convert)
        claim, made = (msgspec.convert(*each, dec_hook=convert) for each in zip(named, parts, strict=True))
        ensure_whole(document, header.certificate if header.certificate in forms.proofs else first, where)
        return Certificate(header, claim.read(header), made)
