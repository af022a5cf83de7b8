"""Claims about decisions that no certificate names: that every leaf is reached, and formulas of users' own.

Does: one class each; the built-in properties by name.
Assumes: decisions.py, which says what every claim about decisions has.
Does not: belong to what proofs rest on, which state such a formula itself.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import ClassVar

from codegen.ir import PolicyProfile
from verify.claims.claim import Parameter
from verify.claims.decisions import BY_NAME, OWN, PLAIN, STEADY, DecisionClaim
from verify.claims.formula import TRUE, Formula
from verify.kinds import Kind


@dataclass(frozen=True)
class AliveLeaves(DecisionClaim):
    """That every leaf is reached: no formula over world states, so nothing is claimed of any one of them."""

    kind: ClassVar[Kind] = Kind.LEAVES
    per_state: ClassVar[bool] = False
    of = "alive_leaves"
    reads = ()
    hardens = landmark_each = False

    def states(self, profile: PolicyProfile) -> Formula:
        """What is claimed of a world state: nothing."""
        return TRUE


@dataclass(frozen=True)
class OwnFormula(DecisionClaim):
    """A formula of the user's own."""

    of = OWN
    hardens = landmark_each = False

    statement: Formula = field(kw_only=True)

    @property
    def name(self) -> str:
        """`formula`, whatever errors are allowed."""
        return OWN

    @property
    def parameters(self) -> Mapping[str, Parameter]:
        """What the claim reads beside its team."""
        return {"margin": self.margin, "radius": self.radius} | ({"eps": self.eps} if self.eps else {})

    def states(self, profile: PolicyProfile) -> Formula:
        """What is claimed where the assumption holds."""
        return self.statement


BUILT_IN: dict[str, type[DecisionClaim]] = {**BY_NAME, AliveLeaves.of: AliveLeaves}
PROPERTIES = (*PLAIN, STEADY, AliveLeaves.of)
