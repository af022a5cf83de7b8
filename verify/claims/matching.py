"""One-to-one matchings between a team and the landmarks.

Does: lists them.
Assumes: nothing.
Does not: know claims, or decide whether one exists (uncertified/matched.py).
"""

import math
from itertools import permutations

from codegen.errors import InputError

MAX_MATCHINGS = 720  # six agents and six landmarks: formulas that name every matching stay readable to the engines


def matchings(n_agents: int, n_landmarks: int) -> list[tuple[int, ...]]:
    """Every way to give each agent a landmark of its own, as landmark numbers in the agents' order.

    InputError when there are more than MAX_MATCHINGS.
    """
    count = math.perm(n_landmarks, n_agents)
    if count > MAX_MATCHINGS:
        raise InputError(
            f"{n_agents} agents and {n_landmarks} landmarks have {count:,} matchings, more than {MAX_MATCHINGS}",
            "",
            "claim own_target (in episodes: name the landmarks), which fixes one of them",
        )
    return list(permutations(range(n_landmarks), n_agents))
