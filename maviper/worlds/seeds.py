"""Episode seeds as a user's environment gets them: below 2**31, so that every kind of generator takes them.

Does: keeps seeds below that as they are, and folds the larger ones; says from which ones trainings draw; draws numbers
  for many seeds at once, and makes numpy's own generators of many seeds.
Assumes: purposes start at multiples of 10**15, or far below 2**29 (evaluation/held_out.py).
Does not: tell apart all episodes of all extraction seeds, of which there are more. Those of one extraction never meet,
  nor do those of two purposes; another extraction seed may have some of the same ones.

    0 to 2**29          as they are: held-out episodes, each with the seed that is told
    2**29 to 2**30      what trainings draw from
    2**30 to 2**31      rollouts, selection and refinement, each folded into 2**28 seeds of its own
"""

from collections.abc import Callable, Iterator, Sequence
from typing import Any, cast

import numpy as np
import numpy.typing as npt

from codegen.ir import Float64

WHOLE = 2**31  # smaller ones stay as they are
TRAINING = (2**29, 2**30)
FOLDED = 2**30
ROOM = 2**28  # more than there are episodes of one purpose in an extraction
PURPOSE = 10**15
GAMMA = np.uint64(0x9E3779B97F4A7C15)  # SplitMix64's step


def fold_seed(seed: int) -> int:
    """The seed that the environment is reset with."""
    return seed if seed < WHOLE else FOLDED + min(seed // PURPOSE, 3) * ROOM + seed % ROOM


def uniforms(seeds: npt.NDArray[np.integer[Any]], count: int) -> Float64:
    """Numbers in [0, 1) that follow from each seed alone, [n_seeds, count]: SplitMix64 (Steele et al. 2014).

    The generator starts from its own first number after the seed, since neighbouring seeds would share theirs.
    """
    start = _mix_bits(seeds.astype(np.uint64)[:, None] + GAMMA)
    drawn = _mix_bits(start + GAMMA * np.arange(1, count + 1, dtype=np.uint64))
    return (drawn >> np.uint64(11)).astype(np.float64) * 2.0**-53


def _mix_bits(z: npt.NDArray[np.uint64]) -> npt.NDArray[np.uint64]:
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return z ^ (z >> np.uint64(31))


class _Drawn(np.random.bit_generator.ISeedSequence):
    """The words of one seed, of many that were made at once."""

    def __init__(self, words: npt.NDArray[np.uint64]) -> None:
        self._words = words

    def generate_state(self, n_words: int, dtype: Any = np.uint32) -> npt.NDArray[np.uint64]:
        """Returns the words that a generator of PCG64 asks for: four of 64 bits."""
        return self._words


def generators(seeds: Sequence[int] | npt.NDArray[np.integer[Any]]) -> Iterator[np.random.Generator]:
    """What `numpy.random.default_rng` gives for each seed below 2**64, in a tenth of the time: the words of
    `numpy.random.SeedSequence`, whose constants these are, are made of all seeds at once.
    """
    entropy = np.array(seeds, dtype=np.uint64)  # OverflowError for a negative one
    pool = [entropy.astype(np.uint32), (entropy >> np.uint64(32)).astype(np.uint32)]
    pool += [np.zeros(len(entropy), np.uint32)] * 2
    hashes = _scramble(0x43B0D7E5, 0x931E8875)
    pool = [hashes(word) for word in pool]
    for source in range(4):
        for place in {0, 1, 2, 3} - {source}:
            mixed = np.uint32(0xCA01F9DD) * pool[place] - np.uint32(0x4973F715) * hashes(pool[source])
            pool[place] = mixed ^ (mixed >> np.uint32(16))
    hashes = _scramble(0x8B51F9DD, 0x58F38DED)
    low_first = [hashes(pool[place % 4]).astype(np.uint64) for place in range(8)]
    words = np.stack([low_first[k] | low_first[k + 1] << np.uint64(32) for k in range(0, 8, 2)], axis=1)
    return (np.random.Generator(np.random.PCG64(cast("np.random.SeedSequence", _Drawn(each)))) for each in words)


def _scramble(constant: int, factor: int) -> Callable[[npt.NDArray[np.uint32]], npt.NDArray[np.uint32]]:
    """A hash of words that is another one at each call."""

    def scramble(words: npt.NDArray[np.uint32]) -> npt.NDArray[np.uint32]:
        nonlocal constant
        words, constant = words ^ np.uint32(constant), constant * factor % 2**32
        words = words * np.uint32(constant)
        return words ^ (words >> np.uint32(16))

    return scramble
