"""Claims of either kind by name: about single decisions (properties.py) and about whole episodes (closed_loop.py).

Does: finds a claim, tells which parameters it reads and which of them a user must state to ask it again.
Assumes: parameters have their types; their ranges are checked here.
Does not: read files or decide.
"""

from typing import Any

from codegen.errors import UnknownNameError
from codegen.ir import PolicyProfile
from verify import closed_loop, properties
from verify.closed_loop import CLOSED_LOOP
from verify.episodes import ClosedLoop
from verify.properties import BUILT_IN, PLAIN, Property, check_read

Claim = Property | ClosedLoop
NAMES = (*BUILT_IN, *CLOSED_LOOP)


def find_claim(name: str, profile: PolicyProfile, team: str | None = None, **given: Any) -> Claim:
    """The named claim for a team of `profile`, see `find_property` and `closed_loop.find_claim` for the parameters.

    InputError for one that the claim does not read, UnknownNameError for a name of neither kind.
    """
    if name in CLOSED_LOOP:
        check_read(name, tuple(given), closed_loop.parameters(name))
        return closed_loop.find_claim(name, profile, team, **given)
    if name not in BUILT_IN:
        raise UnknownNameError("property", name, NAMES)
    return properties.find_property(name, profile, team, **given)


def parameters(name: str, of: str = "") -> tuple[str, ...] | None:
    """What the named claim reads beside its team, of `steady` also what `of` reads; None for unknown names."""
    if name in CLOSED_LOOP:
        return closed_loop.parameters(name)
    if name not in BUILT_IN or (of and of not in PLAIN):
        return None
    return properties.reads(Property(name, "", of=of))


def stated(claim: Claim) -> dict[str, Any]:
    """The parameters of a claim that differ from the usual ones; the steps of episodes are always stated."""
    if isinstance(claim, ClosedLoop):
        read, usual = closed_loop.parameters(claim.name), ClosedLoop("", "", -1)
    else:
        read, usual = properties.reads(claim), Property("", "")
    return {key: getattr(claim, key) for key in read if getattr(claim, key) != getattr(usual, key)}
