"""Whether claims can be made about a team.

Does: refuses a team without members, and policies whose features, actions or thresholds claims have no meaning for.
Assumes: a checked profile.
Does not: read claims.
"""

import numpy as np

from codegen.errors import InputError
from codegen.ir import AgentPolicy, PolicyProfile
from verify.claims.decisions import ensure_team


def verifiable(profile: PolicyProfile, team: str) -> tuple[AgentPolicy, ...]:
    """The team's policies; InputError when a claim about world states cannot be made for them, or there are none."""
    ensure_team(profile, team)
    subnormal = np.finfo(np.float32).tiny
    for policy in profile.team(team):
        for feature in policy.features:
            if feature.meaning is None:
                raise InputError(
                    f"feature {feature.name} of {policy.agent} has no meaning", "", "claims need every meaning"
                )
        for action in policy.actions:
            if action.effect is None:
                raise InputError(
                    f"action {action.name} of {policy.agent} has no effect", "", "claims need every effect"
                )
        tiny = (policy.tree.threshold != 0) & (np.abs(policy.tree.threshold) < subnormal)
        for node in np.flatnonzero(tiny):
            raise InputError(
                f"node {node} of {policy.agent} has a subnormal threshold",
                "",
                "processors may flush such numbers to zero; round the threshold to 0 or to a normal number",
            )
    return profile.team(team)
