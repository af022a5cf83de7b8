"""Any state of an environment that plays in this process, as copies that can be stepped on: for measured Q.

Does: remembers how each game got where it is; plays it there again and copies the environment.
Assumes: a seed and actions decide everything, as all of extraction does.
Does not: copy what cannot be copied (simulators written in C): that is refused.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from copy import deepcopy
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from codegen.errors import InputError
from maviper.worlds.outside.processes import Copy
from maviper.worlds.world import Outcome

ADVICE = "use --critic none, or an expert with Q"


@dataclass(frozen=True, slots=True)
class Past:
    """The path of a game to its state: by a seed at first, then by all agents' actions in a state before."""

    before: Past | None
    by: int | tuple[int, ...]


Pasts = npt.NDArray[np.object_]  # [batch] of Past


def start_pasts(seeds: Sequence[int]) -> Pasts:
    """The pasts of games that were just reset."""
    return _array([Past(None, int(seed)) for seed in seeds])


def continue_pasts(pasts: Pasts, actions: Sequence[Sequence[int]]) -> Pasts:
    """The pasts after one more step. `actions`: [batch][n_agents]."""
    return _array([Past(past, tuple(acted)) for past, acted in zip(pasts, actions, strict=True)])


def _array(pasts: list[Past]) -> Pasts:
    found = np.empty(len(pasts), dtype=object)
    found[:] = pasts
    return found


def copies_of(pasts: Pasts, make: Callable[[], Copy]) -> list[Copy]:
    """A copy of its own for each past. States of one episode in their order are played through only once."""
    walkers: dict[int, tuple[Copy, Past]] = {}  # by the past that an episode began with
    copies: list[Copy] = []
    for past in pasts:
        begun, missing = past, list[int | tuple[int, ...]]()
        at = walkers.get(id(_root(past)))
        while begun.before is not None and not (at and begun is at[1]):
            missing.append(begun.by)
            begun = begun.before
        if at and begun is at[1]:
            walker = at[0]
        else:
            walker = at[0] if at else make()
            walker.ask("reset", begun.by)
        for acted in reversed(missing):
            walker.ask("step", acted)
        walkers[id(_root(past))] = walker, past
        copies.append(deepcopy(walker))
    return copies


def _root(past: Past) -> Past:
    while past.before is not None:
        past = past.before
    return past


def ensure_copies(make: Callable[[], Copy], where: str) -> None:
    """InputError where an environment cannot be copied in play, or a copy goes on in another way."""
    walker = make()
    try:
        begun = walker.ask("reset", 0)
        twin = deepcopy(walker)
        stands = walker.lawful([0] * len(walker.names), begun)
        same = _alike(walker.ask("step", stands), twin.ask("step", stands))
    except (InputError, TypeError, RecursionError, NotImplementedError, AttributeError, RuntimeError) as error:
        said = " ".join(str(error).split())[:120]
        raise InputError("Q cannot be measured: the environment cannot be copied", f"{where}: {said}", ADVICE) from None
    if not same:
        raise InputError("Q cannot be measured: copies of the environment go on differently", where, ADVICE)


def _alike(one: Outcome, other: Outcome) -> bool:
    return one.bytes == other.bytes
