"""What certificates of all forms share: a document with its hash, a proof as text, and the numbers of a proof.

Does: refuses a document that is damaged, of another version, edited, or about something else; reads proofs and their
  numbers.
Assumes: documents of plain data, whose numbers are exact texts.
Does not: know what is claimed, or whether a proof holds.
"""

import base64
import binascii
import hashlib
import json
from collections.abc import Generator, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

import msgspec

from codegen.errors import InputError, escape_text
from verify.checker.reading import RejectedError

BITS = 64  # of the largest number in a proof about decisions or episodes
REMAKE = "make it again with `maviper verify -o`"


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


@contextmanager
def ensure_readable(where: str) -> Generator[None]:
    """InputError for what goes wrong when a damaged certificate is read."""
    try:
        yield
    except msgspec.ValidationError as error:
        raise InputError("not a certificate", f"{where}: {escape_text(error)}", REMAKE) from None
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise InputError("the certificate is truncated or not JSON", f"{where}: {error}", REMAKE) from None
    except (ValueError, LookupError, TypeError, AttributeError, ZeroDivisionError, RecursionError) as error:
        what = "the certificate does not hold what it should"
        raise InputError(what, f"{where}: {escape_text(error)}"[:200], REMAKE) from None


def ensure_whole(raw: msgspec.Struct | Mapping[str, Any], form: str, where: str) -> None:
    """InputError when a certificate is of another version, or was edited."""
    body = msgspec.to_builtins(raw)
    stated, actual_form = body.pop("content_hash"), body["certificate"]
    if actual_form != form:
        raise InputError(
            "a certificate of another version", f"{where}: '{escape_text(actual_form[:40])}', not {form}", REMAKE
        )
    if body_hash(body) != stated:
        raise InputError("the certificate was edited after it was written", f"{where}: $.content_hash", REMAKE)


def body_hash(body: Mapping[str, Any]) -> str:
    """SHA-256 of a document without its hash."""
    return hashlib.sha256(json.dumps(body, ensure_ascii=False, sort_keys=True).encode()).hexdigest()


def read_proof(lines: Sequence[str], where: str) -> bytes:
    """A proof from base64."""
    try:
        return base64.b64decode("".join(lines), validate=True)
    except binascii.Error as error:
        raise ValueError(f"{where}: {error}") from None
