"""Questions about stated systems, recipes of covers for them, and what the checker of covers says."""

from dataclasses import replace

import numpy as np

from codegen.floats import FLOAT64
from tests.verify.reach import random_systems
from verify.checker.covers.sweep import BoxSweep, FormSweep
from verify.checker.reading import RejectedError


def recipe(random, system):
    """How a start may be cut, and cells: none, or of some variables."""
    columns, cuts = len(system.variables), []
    pending, left = 1, int(random.integers(1, 40))
    while pending:
        cut = left > 0 and random.random() < 0.6
        cuts.append(int(random.integers(1, columns + 1)) if cut else 0)
        pending += 1 if cut else -1
        left -= 1
    widths = {
        column: float(random.choice([2.0, 0.5, 0.3, 0.125, 1 / 64]))
        for column in range(columns)
        if random.random() < 0.4
    }
    return cuts, widths


def question(random):
    """A random system with its team and claim; some agents compare float64, some numbers are no floats."""
    system, profile, claim = random_systems.case(random)
    if random.random() < 0.3:
        policies = [
            replace(one, tree=replace(one.tree, threshold=np.array(one.tree.threshold, np.float64), numbers=FLOAT64))
            for one in profile.agents
        ]
        profile = replace(profile, agents=tuple(policies))
    return system, profile, claim


def shown(question, cells, forms=False):
    """Whether the checker takes a cover for a proof, of boxes in cells or of forms."""
    system, profile, claim = question
    try:
        if forms:
            FormSweep(profile, system, claim).run(cells[0])
        else:
            BoxSweep(profile, system, claim).run(*cells)
    except RejectedError:
        return False
    return True
