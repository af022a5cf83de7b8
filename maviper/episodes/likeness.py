"""How like an expert's actions others are.

Does: the share of an action that is the expert's, for actions and for numbers.
Assumes: outputs with both bounds, as worlds have them.
Does not: play, or ask an expert.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from codegen.ir import Float64, OutputSpec
from maviper.worlds.world import bounds


def likeness(outputs: Sequence[OutputSpec], acted: Any, wanted: Any) -> Float64:
    """From 0 to 1, how like an agent's actions are to those that were `wanted`: whether they are the same.

    Of numbers, [..., n_outputs] and any zeros behind them: 1 less their mean distance in parts of their ranges.
    """
    if not outputs:
        return np.equal(acted, wanted).astype(np.float64)
    low, high = bounds(outputs)
    off = np.abs(np.asarray(acted, np.float64) - np.asarray(wanted, np.float64))[..., : len(outputs)]
    return 1 - (off / np.where(high > low, high - low, 1.0)).mean(axis=-1)
