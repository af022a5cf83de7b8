"""One-to-one matchings between a team and the landmarks.

Does: decides, for a batch of relations, whether a perfect matching exists.
Assumes: at most about a dozen agents (the work doubles with each).
Does not: return the matching.
"""

import numpy as np

from codegen.ir import Bool


def matched(related: Bool) -> Bool:
    """Whether every agent can have a landmark of its own. `related`: [..., n_agents, n_landmarks]. Returns [...].

    After each agent, the sets of landmarks (as bits) that the agents so far can hold.
    """
    n_agents, n_landmarks = related.shape[-2:]
    holdable = np.zeros((*related.shape[:-2], 1 << n_landmarks), dtype=bool)
    holdable[..., 0] = True
    for agent in range(n_agents):
        following = np.zeros_like(holdable)
        for held in range(1 << n_landmarks):
            for landmark in range(n_landmarks):
                if not held >> landmark & 1:
                    following[..., held | 1 << landmark] |= holdable[..., held] & related[..., agent, landmark]
        holdable = following
    return np.asarray(holdable.any(axis=-1))
