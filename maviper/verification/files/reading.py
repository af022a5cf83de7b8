"""How far the reading of a certificate is, told to whoever listens.

Does: tells the bytes of a proof that the checker has read, and the pieces of a system that it has shown again.
Assumes: the checker reads a proof byte by byte, once.
Does not: check, or change what is checked.
"""

from collections.abc import Iterator

from verify.checker.certificate import Bytes
from verify.progress import tell

STEP = 2**14  # bytes of proof; a second or less


class FollowedProof(Bytes):
    """A proof that tells how much of it has been read."""

    def __iter__(self) -> Iterator[int]:
        for low in range(0, len(self), STEP):
            if low:
                tell(low, len(self), "bytes of proof read")
            yield from memoryview(self)[low : low + STEP]


def tell_shown(done: int, most: int) -> None:
    """That so many of the pieces of a system are shown again."""
    tell(done, most, "pieces shown again by the checker")
