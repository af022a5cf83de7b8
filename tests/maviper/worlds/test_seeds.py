import numpy as np

from maviper.worlds import seeds


def test_generators_are_those_that_numpy_makes_of_each_seed():
    some = [0, 1, 7, 2**31 - 1, 2**32 - 1, 2**32, 2**32 + 5, 3 * 10**15 + 11, 2**63, 2**64 - 1]
    some += np.random.default_rng(3).integers(2**63, size=200).tolist()
    for seed, rng in zip(some, seeds.generators(some), strict=True):
        assert rng.bit_generator.state == np.random.default_rng(seed).bit_generator.state
    for numbers in (range(40), np.arange(40), np.arange(40, dtype=np.int32)):
        states = [rng.bit_generator.state for rng in seeds.generators(numbers)]
        assert states == [np.random.default_rng(seed).bit_generator.state for seed in range(40)]
