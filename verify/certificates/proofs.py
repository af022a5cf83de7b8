"""The bytes of a proof: natural numbers in groups of seven bits, and their lines in a file.

Does: writes what the checker's envelope reads.
Assumes: nothing.
Does not: know what the numbers say.
"""

import base64
from collections.abc import Iterable

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
