"""Certificates as text: the bytes of a proof, and the members of a document with its hash.

Does: writes what the checker reads, in the classes that it reads it with.
Assumes: nothing.
Does not: know what the members say.
"""

import base64
from collections.abc import Iterable, Mapping
from fractions import Fraction
from functools import singledispatch
from typing import Any

import msgspec

from codegen.floats import rational_literal
from codegen.form import layout
from verify.checker.certificate import list_stated
from verify.checker.envelope import body_hash

LINE = 96  # characters of a proof on a line


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
    return {name: plain(each) for name, each in list_stated(value).items()}


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


def layout_certificate(body: Mapping[str, Any]) -> str:
    """The text of a document with its hash; equal documents give equal bytes."""
    return layout({**body, "content_hash": body_hash(body)}) + "\n"
