"""Modes in the sets of a proof: a state has one of their values, and of numbers between these nothing is proved.

Does: cuts boxes to the values of modes, the whole numbers from 0.
Assumes: boxes of all variables of a system, of which a proof holds where modes have their values.
Does not: know proofs, or whether a claim speaks of a mode.
"""

import numpy as np

from codegen.errors import InputError
from codegen.lowering.covering import MAX_GIVEN
from codegen.lowering.searching import Boxes
from verify.systems.statement import Statement


def split_modes(statement: Statement, boxes: Boxes, where: str) -> Boxes:
    """The boxes, one for each value of each mode that they bound. `where` is named in errors. InputError for too
    many.
    """
    low, high = boxes.low.copy(), boxes.high.copy()
    for at, one in enumerate(statement.system.variables):
        if one.modes:
            values = np.arange(float(len(one.modes)))
            met = (low[:, at, None] <= values) & (high[:, at, None] >= values)
            free = np.isinf(low[:, at]) & np.isinf(high[:, at])  # a proof that does not follow it holds of any number
            met[free] = values == 0.0
            rows, chosen = np.nonzero(met)
            if len(rows) > MAX_GIVEN:
                what = f"the proof's sets are more than {MAX_GIVEN:,} boxes, one for each value of its modes"
                raise InputError(what, where, "verify a claim about fewer of them")
            low, high = low[rows], high[rows]
            bound = ~free[rows]
            low[bound, at] = high[bound, at] = values[chosen][bound]
    return Boxes(low, high)
