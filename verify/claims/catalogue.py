"""Claims of either kind by name: about single decisions (decisions.py) and about whole episodes (verdicts/episodes.py).

Does: finds a claim, tells which parameters it reads and which of them a user must state to ask it again.
Assumes: parameters have their types; their ranges are checked here.
Does not: read files or decide.
"""

from typing import Any

from codegen.errors import UnknownNameError
from codegen.ir import PolicyProfile
from verify.claims import decisions, episode_properties
from verify.claims.decisions import BUILT_IN, PLAIN, DecisionClaim, check_read
from verify.claims.episode_properties import EPISODE_CLAIMS
from verify.claims.episodes import EpisodeClaim

Claim = DecisionClaim | EpisodeClaim
NAMES = (*BUILT_IN, *EPISODE_CLAIMS)


def find_claim(name: str, profile: PolicyProfile, team: str | None = None, **given: Any) -> Claim:
    """The named claim for a team of `profile`, see `find_property` and `closed_loop.find_claim` for the parameters.

    InputError for one that the claim does not read, UnknownNameError for a name of neither kind.
    """
    if name in EPISODE_CLAIMS:
        check_read(name, tuple(given), episode_properties.parameters(name))
        return episode_properties.find_claim(name, profile, team, **given)
    if name not in BUILT_IN:
        raise UnknownNameError("property", name, NAMES)
    return decisions.find_property(name, profile, team, **given)


def parameters(name: str, of: str = "") -> tuple[str, ...] | None:
    """What the named claim reads beside its team, of `steady` also what `of` reads; None for unknown names."""
    if name in EPISODE_CLAIMS:
        return episode_properties.parameters(name)
    if name not in BUILT_IN or (of and of not in PLAIN):
        return None
    return decisions.reads(DecisionClaim(name, "", of=of))


def stated(claim: Claim) -> dict[str, Any]:
    """The parameters of a claim that differ from the usual ones; the steps of episodes are always stated."""
    if isinstance(claim, EpisodeClaim):
        read, usual = episode_properties.parameters(claim.name), EpisodeClaim("", "", -1)
    else:
        read, usual = decisions.reads(claim), DecisionClaim("", "")
    return {key: getattr(claim, key) for key in read if getattr(claim, key) != getattr(usual, key)}
