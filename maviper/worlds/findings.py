"""What was found of a world: one line for each thing that was looked at.

Does: findings with their marks and words.
Assumes: whoever looks says what is to be done.
Does not: look.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

from codegen.wording import visible


class Mark(StrEnum):
    """The mark of a finding; only what is wrong prevents use."""

    OK = "ok"
    MISSING = "missing"
    WRONG = "wrong"


@dataclass(frozen=True)
class Finding:
    """One thing that was looked at, and what to do about it where something is to be done."""

    mark: Mark
    what: str
    next_step: str = ""

    def __str__(self) -> str:
        said = "; ".join(part for part in (self.what, self.next_step) if part)
        return visible(f"{self.mark:<8} {' '.join(said.split())}")


def usable(findings: Sequence[Finding]) -> bool:
    """Returns True if nothing was found that prevents use."""
    return all(finding.mark is not Mark.WRONG for finding in findings)
