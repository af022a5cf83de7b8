"""Episode seeds as a user's environment gets them: below 2**31, so that every kind of generator takes them.

Does: keeps seeds below that as they are, and folds the larger ones; says from which ones trainings draw.
Assumes: purposes start at multiples of 10**15, or far below 2**29 (evaluate/metrics.py).
Does not: tell apart all episodes of all extraction seeds, of which there are more. Those of one extraction never meet,
  nor do those of two purposes; another extraction seed may have some of the same ones.

    0 to 2**29          as they are: held-out episodes, each with the seed that is told
    2**29 to 2**30      what trainings draw from
    2**30 to 2**31      rollouts, selection and refinement, each folded into 2**28 seeds of its own
"""

WHOLE = 2**31  # smaller ones stay as they are
TRAINING = (2**29, 2**30)
FOLDED = 2**30
ROOM = 2**28  # more than there are episodes of one purpose in an extraction
PURPOSE = 10**15


def folded(seed: int) -> int:
    """The seed that the environment is reset with."""
    return seed if seed < WHOLE else FOLDED + min(seed // PURPOSE, 3) * ROOM + seed % ROOM
