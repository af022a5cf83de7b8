"""Observations of other people's environments as vectors with names, and the mask of legal actions among them.

Does: flattens spaces as `gymnasium.spaces.flatten` does, with a name and a unit for each number; takes a mask out of a
  dictionary and puts it at the end.
Assumes: Gymnasium's spaces; a mask is under the key `action_mask`, one number per action.
Does not: wrap environments (wrappers.py), or judge what is too large for a tree.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Sequence
from itertools import count, product
from typing import TYPE_CHECKING, Any

import numpy as np

from codegen.check import identifier
from codegen.errors import InputError
from codegen.ir import MAX_LENGTH, FeatureSpec
from maviper.worlds.outside.described import FLAG

if TYPE_CHECKING:
    from gymnasium import spaces

MASK = "action_mask"  # the key, in a dictionary of observations or in infos
MAX_NAME = 50
MAX_FEATURES = 1_024  # of a flattened observation: beyond it, it is a picture
WHOLE = 2**24  # up to which float32 has every whole number
OWN = "return it wrapped from a function of your own, and name that: mygame:make"
Named = tuple[str, str]  # a number's name and unit


def legal_names(names: Sequence[str], kind: str) -> tuple[str, ...]:
    """Names as a profile may have them, all different, each as much like the given one as it can be."""
    by_identifier: dict[str, str] = {}
    for name in names:
        legal = re.sub(r"[^A-Za-z0-9_-]+", "_", name)[:MAX_NAME]
        legal = legal if legal[:1].isalpha() else f"{kind}_{legal}"
        tries = (f"{legal}_{k}" if k > 1 else legal for k in count(1))
        chosen = next(each for each in tries if identifier(each) not in by_identifier)
        by_identifier[identifier(chosen)] = chosen
    return tuple(by_identifier.values())


def parts_of(space: spaces.Space, n_actions: int) -> tuple[spaces.Space, bool]:
    """Returns the part of a space that is observed beside a mask, and True if it has one."""
    from gymnasium.spaces import Dict

    if not isinstance(space, Dict) or MASK not in space.spaces or len(space.spaces) == 1:
        return space, False
    mask = space.spaces[MASK]
    if int(np.prod(mask.shape or ())) != n_actions:
        return space, False
    return Dict({key: part for key, part in space.spaces.items() if key != MASK}), True


def as_numbers(space: spaces.Space, where: str) -> spaces.Space:
    """The space whose whole numbers are shown as they are, not as one number per value. InputError for numbers that
    float32 cannot tell apart.
    """
    from gymnasium.spaces import Box, Dict, Discrete, MultiDiscrete, Tuple

    if isinstance(space, Dict):
        return Dict({key: as_numbers(part, where) for key, part in space.spaces.items()})
    if isinstance(space, Tuple):
        return Tuple([as_numbers(part, where) for part in space.spaces])
    if not isinstance(space, Discrete | MultiDiscrete):
        return space
    least = np.asarray(space.start)
    most = least + (space.n if isinstance(space, Discrete) else space.nvec) - 1
    if np.abs(np.stack([least, most])).max() > WHOLE:
        what = f"an observation has whole numbers beyond {WHOLE:,}, which float32 does not tell apart"
        raise InputError(what, where, f"observe smaller ones; {OWN}")
    return Box(least.astype(np.float32), most.astype(np.float32), dtype=np.float32)


def unreadable(space: spaces.Space) -> str:
    """The kind of a space, or of a part of it, that has no vector of a fixed length; "" where there is none."""
    from gymnasium.spaces import Box, Dict, Discrete, MultiBinary, MultiDiscrete, Tuple

    if isinstance(space, Dict | Tuple):
        inner: list[spaces.Space] = list(space.spaces.values() if isinstance(space, Dict) else space.spaces)
        kinds = [unreadable(part) for part in inner] or ["empty " + type(space).__name__]
        return next(filter(None, kinds), "")
    return "" if isinstance(space, Box | Discrete | MultiBinary | MultiDiscrete) else type(space).__name__


def ensure_small(space: spaces.Space, where: str) -> None:
    """InputError for a space of more numbers than a tree can be learned from."""
    size = _size(space)
    if not 1 <= size <= MAX_FEATURES:
        wrapper = "reduce it: gymnasium.wrappers.TransformObservation"
        raise InputError(
            f"an observation has {size:,} numbers, of at most {MAX_FEATURES:,}", where, f"{wrapper}; {OWN}"
        )


def _size(space: spaces.Space) -> int:
    """Counts the numbers of a flattened space; nothing of that size is made."""
    from gymnasium.spaces import Dict, Discrete, MultiDiscrete, Tuple

    if isinstance(space, Dict | Tuple):
        return sum(map(_size, space.spaces.values() if isinstance(space, Dict) else space.spaces))
    if isinstance(space, Discrete):
        return int(space.n)
    return int(space.nvec.sum(dtype=object)) if isinstance(space, MultiDiscrete) else math.prod(space.shape or ())


def vector_space(space: spaces.Space) -> spaces.Box:
    """The space of flattened observations, [n_features] float32."""
    from gymnasium.spaces import Box, flatten_space

    flat: Any = flatten_space(space)
    size = math.prod(flat.shape)
    low, high = (np.asarray(each, np.float32).reshape(size) for each in (flat.low, flat.high))
    return Box(low, high, dtype=np.float32)


def vector(space: spaces.Space, seen: Any) -> Any:
    """An observation as a vector, [n_features]."""
    from gymnasium.spaces import Box, MultiBinary, flatten

    return seen if isinstance(space, Box | MultiBinary) and _is_row(seen) else flatten(space, seen)


def _is_row(seen: object) -> bool:
    return isinstance(seen, np.ndarray) and seen.ndim == 1


def specs_of(names: Iterable[Named], box: spaces.Box) -> list[FeatureSpec]:
    """The features of a vector, as far as names, units and the bounds of its space tell them."""
    low, high = (np.clip(np.asarray(end, np.float64), -MAX_LENGTH, MAX_LENGTH).tolist() for end in (box.low, box.high))
    parts = zip(names, low, high, strict=True)
    return [FeatureSpec(name, unit, least, most, None) for (name, unit), least, most in parts]


def names_of(space: spaces.Space) -> list[Named]:
    """A legal name and a unit for each number of a flattened space, all names different."""
    found = list(_iterate_names(space, ""))
    names = legal_names([name for name, _ in found], "feature")
    return [(name, unit) for name, (_, unit) in zip(names, found, strict=True)]


def _iterate_names(space: spaces.Space, under: str) -> Iterator[Named]:
    """`under`: the keys that lead to the space, joined."""
    from gymnasium.spaces import Box, Dict, Discrete, MultiDiscrete, Tuple

    if isinstance(space, Dict | Tuple):
        inner = space.spaces.items() if isinstance(space, Dict) else enumerate(space.spaces)
        for key, part in inner:
            name = str(key) if isinstance(space, Dict) else f"part_{key}"
            yield from _iterate_names(part, f"{under}_{name}" if under else name)
        return
    if isinstance(space, Discrete):
        yield from ((f"{_before(under)}is_{spell_number(space.start + k)}", FLAG) for k in range(int(space.n)))
        return
    places = product(*map(range, space.shape or ()))
    if isinstance(space, MultiDiscrete):  # one number per value of each part, side by side
        sizes, starts = np.ravel(space.nvec), np.ravel(space.start)
        for place, size, first in zip(places, sizes, starts, strict=True):
            where = _before("_".join(filter(None, (under, *map(str, place)))))
            yield from ((f"{where}is_{spell_number(int(first) + k)}", FLAG) for k in range(int(size)))
        return
    kind, unit = ("feature", "none") if isinstance(space, Box) else ("bit", FLAG)
    single = bool(under) and int(np.prod(space.shape or ())) == 1
    yield from (("_".join([under or kind, *map(str, () if single else place)]), unit) for place in places)


def _before(under: str) -> str:
    return f"{under}_" if under else ""


def spell_number(number: int) -> str:
    """A whole number as names have it."""
    return f"{number}".replace("-", "minus_")
