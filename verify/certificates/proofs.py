"""Certificates as text: the bytes of a proof, and a document of header, claim and proof with its hash.

Does: writes what the checker reads, in the classes that it reads it with.
Assumes: what claims are as plain data is registered beside (games.py, systems.py): import `to_json` from there.
Does not: check what it writes.
"""

import base64
from collections.abc import Iterable, Iterator, Mapping
from fractions import Fraction
from functools import singledispatch
from typing import Any, cast

import msgspec

from codegen.floats import rational_literal
from codegen.form import layout
from verify.checker.certificate import Certificate, Members, body_hash

LINE = 96  # characters of a proof on a line
ORDER = (
    *("certificate", "profile", "against", "system", "claim", "property", "team", "steps", "radius", "landmarks"),
    *("others", "semantics", "eps", "view", "region", "formula", "inhabitant", "at_samples", "premises"),
)  # of the members beside the proof


def varint(number: int) -> bytes:
    """A natural number in groups of seven bits, low ones first; all bytes but the last have the high bit."""
    if number < 128:
        return bytes((number,))
    encoded = bytearray()
    while number > 127:
        encoded.append(number & 127 | 128)
        number >>= 7
    encoded.append(number)
    return bytes(encoded)


def encode_numbers(numbers: Iterable[int]) -> bytes:
    """Natural numbers as a proof has them."""
    return b"".join(map(varint, numbers))


def proof_lines(proof: bytes) -> list[str]:
    """A proof as base64."""
    text = base64.b64encode(proof).decode()
    return [text[start : start + LINE] for start in range(0, len(text), LINE)]


@singledispatch
def plain(value: Any) -> Any:
    """A value of a certificate as plain data; numbers are exact texts."""
    return value


@plain.register
def _(value: msgspec.Struct) -> dict[str, Any]:
    return {name: plain(each) for name, each in _list_stated(value)}


@plain.register(Mapping)
def _(value: Mapping[str, Any]) -> dict[str, Any]:
    return {name: plain(each) for name, each in value.items()}


@plain.register(tuple)
def _(value: tuple[Any, ...]) -> list[Any]:
    return list(map(plain, value))


@plain.register
def _(value: bytes) -> list[str]:
    return proof_lines(value)


@plain.register
def _(value: Fraction) -> str:
    return rational_literal(value)


def _list_stated(members: msgspec.Struct) -> Iterator[tuple[str, Any]]:
    """The members that a document states: all but those that are as usual."""
    for each in msgspec.structs.fields(members):
        factory: Any = each.default_factory
        usual = each.default if factory is msgspec.NODEFAULT else factory()
        if (value := getattr(members, each.name)) != usual:
            yield each.name, value


def count_bytes(value: Any) -> int:
    """The bytes of a proof, or of a part of one."""
    match value:
        case bytes():
            return len(value)
        case msgspec.Struct():
            return sum(count_bytes(each) for _, each in _list_stated(value))
        case Mapping():
            return sum(map(count_bytes, cast("Mapping[str, Any]", value).values()))
        case tuple():
            return sum(map(count_bytes, cast("tuple[Any, ...]", value)))
        case _:
            return 0


@singledispatch
def state_claim(claim: Any, proof: object) -> dict[str, Any]:
    """The members of a document that say what is claimed, in any order."""
    return plain(claim)


def to_json(certificate: Certificate[Any, Any, Members]) -> str:
    """The text of a certificate; equal certificates give equal bytes."""
    stated = plain(certificate.header) | state_claim(certificate.claim, certificate.proof)
    body = {name: stated[name] for name in ORDER if name in stated} | plain(certificate.proof)
    return layout({**body, "content_hash": body_hash(body)}) + "\n"
