"""What several tests use of `verify.zones.test_steady`."""

from itertools import product

from tests.support.zone_cases import (
    actions_with_errors,
)
from verify.claims.decisions import formula
from verify.claims.formula import for_goal, holds


def stands(profile, claim, state, goal, machine=True):
    """Whether no errors make the team violate the claim at a rational point."""
    asked = for_goal(formula(profile, claim), goal)
    ways = actions_with_errors(profile, state, goal, claim.eps, machine)
    return all(
        holds(asked, state, dict(zip(ways, joint, strict=True)))
        for joint in product(*(sorted(actions) for actions in ways.values()))
    )
