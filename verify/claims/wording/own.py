"""Claims about decisions that no certificate names, and words and plain data of all claims about single decisions.

Does: every leaf is reached, and formulas of users' own; the built-in properties by name; what each says, in general and
  of a claim; formulas, regions and views as data that the checker reads.
Assumes: claims of decisions.py and relations.py, each by the name of its property.
Does not: belong to what proofs rest on, or touch files.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar

from codegen.floats import rational_literal
from codegen.ir import PolicyProfile
from verify.claims.claim import Parameter
from verify.claims.decisions import BY_NAME, OWN, PLAIN, STEADY, DecisionClaim
from verify.claims.formula import TRUE, Acts, And, Formula, Goal, Linear, Not
from verify.claims.observed import View
from verify.claims.region import Region
from verify.decimals import text
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
        """Returns TRUE: nothing is claimed of a world state."""
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
        """The parameters that the claim reads beside its team."""
        return {"margin": self.margin, "radius": self.radius} | ({"eps": self.eps} if self.eps else {})

    def states(self, profile: PolicyProfile) -> Formula:
        """Returns the formula that is claimed where the assumption holds."""
        return self.statement


BUILT_IN: dict[str, type[DecisionClaim]] = {**BY_NAME, AliveLeaves.of: AliveLeaves}
PROPERTIES = (*PLAIN, STEADY, AliveLeaves.of)


WITH_ERRORS = ", even when every feature{who} is off by up to eps, each by an error of its own"
OF_ALL = " of each of the {team}"  # whose features may be off
WHOSE = {OWN: ""}  # the same, where it is not said
WORDS = {
    "distinct_targets": (
        "in every world state of the region, the {team} can be matched one-to-one to the landmarks so that each closes "
        "on its own landmark or is at it"
    ),
    "own_target": "in every world state of the region, each of the {team} closes on its fixed landmark or is at it",
    "no_double": "in no world state of the region do two of the {team} close on exactly the same single landmark",
    "aligned": (
        "in every world state of the region, the {team} can be matched one-to-one to the landmarks so that each is at "
        "its own landmark, or closes on it and is ahead by at least kappa times the sideways offset"
    ),
    "assignment": (
        "in every world state of the region, each of the {team} closes on or is at its landmark in a matching of least "
        "summed L1 distance"
    ),
    "agree": "in every state of the region, the two agents take the action of the same name",
    "differ": "in no state of the region do the two agents take the action of the same name",
    "monotone": (
        "if the feature of the agent is raised and all others stay, its action does not move against the direction"
    ),
    "ignores": (
        "whatever value the feature of the agent takes while all others stay, it takes the same action "
        "(or, where actions are named, either one of these or none)"
    ),
    "symmetric": "where the mirrored features have the opposite sign, the agent takes the action opposite in the order",
    "alive_leaves": "every leaf of every agent of the {team} is reached in some world state of the region",
    OWN: "in every world state of the region, the formula holds for what the {team} do",
}


def spell_rounded(rounded: Iterable[tuple[str, str]]) -> list[str]:
    """The floats that decimals beside features are read as."""
    return [f"{written}, read as {near}" for written, near in rounded]


def spell_decisions(claim: DecisionClaim) -> str:
    """The claim in words, without its assumption."""
    errors = WITH_ERRORS.format(who=WHOSE.get(claim.of, OF_ALL)) if claim.eps else ""
    return (WORDS[claim.of] + errors).format(team=claim.team)


def formula_document(node: Formula) -> dict[str, Any]:
    """The formula as plain data; numbers are exact texts."""
    if isinstance(node, Linear):
        terms = [[rational_literal(weight), name] for weight, name in node.terms]
        return {"sum": terms, "below" if node.strict else "most": rational_literal(node.bound)}
    if isinstance(node, Acts):
        return {"agent": node.agent, "takes": node.action}
    if isinstance(node, Goal):
        return {"goal": node.landmark}
    if isinstance(node, Not):
        return {"not": formula_document(node.part)}
    return {"all" if isinstance(node, And) else "any": [formula_document(part) for part in node.parts]}


def region_document(region: Region) -> dict[str, Any]:
    """The region as plain data, numbers as exact text."""
    return {
        "goals": list(region.goals),
        "box": {name: [text(bound) for bound in bounds] for name, bounds in region.box.items()},
        "difference": {f"{a} - {b}": [text(bound) for bound in bounds] for a, b, bounds in region.differences},
        "apart": {f"{a} - {b}": text(least) for a, b, least in region.apart},
    }


def view_document(view: View) -> dict[str, list[str]]:
    """The view as plain data, which `view_from` reads."""
    mirrored = {} if view.mirrored is None else {"mirrored": [view.mirrored.agent, *view.mirrored.features]}
    return {"shared": list(view.shared), "raised": list(view.raised or ()), **mirrored}
