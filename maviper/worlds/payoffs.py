"""The rules by which coordination games pay, and the payoffs of pairs of roles.

Does: states the climbing game and the penalty game of Claus and Boutilier (1998), the latter with k = -10.
Assumes: role 0 is what the hidden state demands.
Does not: play.
"""

from collections.abc import Mapping

import numpy as np

from codegen.ir import Float64

MATCHING = "matching"
# the earlier agent's role in rows
PAIRS: Mapping[str, Float64] = {
    "climbing": np.array([[11.0, -30.0, 0.0], [-30.0, 7.0, 6.0], [0.0, 0.0, 5.0]]),
    "penalty": np.array([[10.0, 0.0, -10.0], [0.0, 2.0, 0.0], [-10.0, 0.0, 10.0]]),
}
RULES = (MATCHING, *PAIRS)
