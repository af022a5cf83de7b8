"""Claims about single decisions in words.

Does: what each built-in property says, in general and of a claim.
Assumes: claims of decisions.py, relations.py and own.py, each by the name of its property.
Does not: belong to what proofs rest on, which read formulas.
"""

from collections.abc import Iterable

from verify.claims.decisions import OWN, DecisionClaim

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
