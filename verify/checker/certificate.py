"""A certificate: a header, a claim and a proof; one reader for all forms, and what each proof is read by.

Does: reads a document by the table of a room; refuses one that is damaged, of another version, edited, or about
  something else; reads the numbers of a proof, and formulas.
Assumes: tables that say which members a form has (`Forms`), whose classes are those of the document.
Does not: know what is claimed, whether a proof holds, or how certificates are written (verify/certificates).
"""

from __future__ import annotations

import base64
import binascii
import hashlib
import json
from abc import ABCMeta
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, Any, Generic, Protocol, TypeVar

import msgspec

from codegen.errors import InputError, escape_text
from verify.checker.reading import RejectedError
from verify.exact import read_number

BITS = 64  # of the largest number in a proof about decisions or episodes
MAX_BYTES = 1 << 30  # of a file
REMAKE = "make it again with `maviper verify -o`"


class Members(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Members of a document, or of a part of it, under the names that they have there."""


if TYPE_CHECKING:
    Bytes = bytes
else:

    class Bytes(bytes):
        """The bytes of a proof; lines of base64 in a document."""


def stated_as(read: Callable[[Any], object], *kinds: type) -> Any:
    """The type of members that are of these kinds, as `read` makes them of what a document states."""
    made: Any = ABCMeta("Stated", (), {"read": staticmethod(read)})
    for kind in kinds:
        made.register(kind)
    return made


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
            lines = msgspec.convert(value, list[str])
            try:
                proof = base64.b64decode("".join(lines), validate=True)
            except binascii.Error as error:
                raise ValueError(f"a proof: {error}") from None
            return followed(proof)
        return read_number(value) if kind is Fraction else kind.read(value)

    what = "the certificate does not hold what it should"
    try:
        document = msgspec.json.decode(text, type=dict[str, Any])
        form, first, parts = document.get("certificate", ""), next(iter(forms.proofs)), list[Any]()
        stated = document.pop("content_hash", None)
        left = dict(document)
        kinds: list[Any] = [forms.proofs.get(form, forms.proofs[first]), forms.claim]
        for kind in kinds:
            own = {name: left.pop(name) for name in kind.__struct_fields__ if name in left}
            parts.append(msgspec.convert(own, kind, dec_hook=convert))
        proof, claim, header = *parts, msgspec.convert(left, forms.header, dec_hook=convert)
        if header.certificate not in forms.proofs:
            said = f"{where}: '{escape_text(header.certificate[:40])}', not {first}"
            raise InputError("a certificate of another version", said, REMAKE)
        if body_hash(document) != stated:
            raise InputError("the certificate was edited after it was written", f"{where}: $.content_hash", REMAKE)
        return Certificate(header, claim.read(header), proof)
    except msgspec.ValidationError as error:  # with a cause: of a member that stands for something else
        what = what if error.__cause__ else "not a certificate"
        raise InputError(what, f"{where}: {escape_text(error)}", REMAKE) from None
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise InputError("the certificate is truncated or not JSON", f"{where}: {error}", REMAKE) from None
    except (ValueError, LookupError, TypeError, AttributeError, ZeroDivisionError, RecursionError) as error:
        raise InputError(what, f"{where}: {escape_text(error)}"[:200], REMAKE) from None


# --- what is read, and refused


def numbers(proof: bytes, bits: int = BITS) -> Iterator[int]:
    """The numbers of a proof, in groups of seven bits, low ones first. RejectedError for one beyond `bits`, and for a
    proof that ends within a number.
    """
    value = shift = 0
    for byte in proof:
        if byte < 128 and not shift:
            yield byte
            continue
        value |= (byte & 127) << shift
        shift += 7
        if shift > bits + 6:
            raise RejectedError(f"the proof contains a number beyond {bits} bits")
        if byte < 128:
            yield value
            value = shift = 0
    if shift:
        raise RejectedError("the proof ends within a number")


def ensure_about(stated: str, actual: str, what: str, option: str = "") -> None:
    """InputError unless a profile or system, by its hash, is the one that a certificate names."""
    if actual != stated:
        raise InputError(
            f"the certificate is about another {what}",
            f"it names {escape_text(stated[:16])}..., the {what} is {actual[:16]}...",
            f"give the {what} that it was made for" + (f" (`maviper check {option} FILE`)" if option else ""),
        )


def body_hash(body: Mapping[str, Any]) -> str:
    """SHA-256 of a document without its hash."""
    return hashlib.sha256(json.dumps(body, ensure_ascii=False, sort_keys=True).encode()).hexdigest()
