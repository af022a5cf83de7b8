"""HiGHS without a word on standard output: it belongs to results.

Does: makes solvers that print nothing, each for one thread and with the same options.
Assumes: HiGHS prints its banner at most once per process, when the first solver is made (from 1.16 on).
Does not: state programs.
"""

import os
from collections.abc import Generator
from contextlib import contextmanager

import highspy

STDOUT = 1


def solver() -> highspy.Highs:
    """A solver that prints nothing, on one thread, with a seed."""
    made = highspy.Highs()
    made.silent()
    for option, value in (("presolve", "off"), ("threads", 1), ("random_seed", 0)):
        made.setOptionValue(option, value)
    return made


@contextmanager
def _without_stdout() -> Generator[None]:
    """Sends what the process writes to its standard output nowhere, Python's own buffered text aside."""
    try:
        before = os.dup(STDOUT)
    except OSError:  # there is none
        yield
        return
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, STDOUT)
        yield
    finally:
        os.dup2(before, STDOUT)
        os.close(before)
        os.close(nowhere)


with _without_stdout():  # no option is read before the banner; an import happens once, whatever the threads
    highspy.Highs()
