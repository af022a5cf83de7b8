"""Whether a team can be matched one-to-one to the landmarks, in many states at once.

Does: decides, for a batch of relations, whether a matching exists; and whether a batch of choices can prevent any.
Assumes: at most about a dozen agents (the work doubles with each).
Does not: know claims, or belong to what proofs rest on, which name every matching.
"""

import math
from collections.abc import Sequence
from functools import reduce
from itertools import permutations

import numpy as np

from codegen.ir import Bool

MAX_TRIED = 6  # three agents and three landmarks: fewer operations than sets of landmarks take


def has_matching(related: Bool) -> Bool:
    """Tests where each agent can have a landmark of its own. `related`: [..., n_agents, n_landmarks]. Returns [...].

    After each agent, the sets of landmarks (as bits) that the agents so far can hold; few matchings are tried one by
    one.
    """
    n_agents, n_landmarks = map(int, related.shape[-2:])
    if math.perm(n_landmarks, n_agents) <= MAX_TRIED:
        matched = np.zeros(related.shape[:-2], dtype=bool)
        for way in permutations(range(n_landmarks), n_agents):
            matched |= reduce(np.logical_and, (related[..., agent, own] for agent, own in enumerate(way)), np.True_)
        return matched
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


def preventable(choices: Sequence[Sequence[tuple[Bool, Bool]]], n_landmarks: int) -> Bool:
    """Where some joint choice, one allowed choice of every agent, leaves no matching, [batch].

    `choices`: for each agent its choices as pairs (allowed [batch], landmarks it can then hold [batch, n_landmarks]).
    By Hall's theorem that is so iff more agents can choose to hold only landmarks of some set than the set has.
    """
    outside = 1 << np.arange(n_landmarks)
    masks = [[(allowed, related @ outside) for allowed, related in agent] for agent in choices]
    choosing = np.logical_and.reduce([np.logical_or.reduce([allowed for allowed, _ in agent]) for agent in choices])
    prevented = np.zeros_like(choosing)
    for kept in range(1 << n_landmarks):
        confined = np.zeros(len(prevented), dtype=np.int64)
        for agent in masks:
            confined += np.logical_or.reduce([allowed & (mask & ~kept == 0) for allowed, mask in agent])
        prevented |= confined > kept.bit_count()
    return np.asarray(prevented & choosing)
