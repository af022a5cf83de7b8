"""The checker's reading of episodes with contacts: what the machine does is within its bounds and among its answers."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from tests.support.contact_readings import SPREAD, strays
from tests.support.contacts import around, random_team
from verify.checker.episodes.contacts import ContactReading
from verify.checker.reading import RejectedError
from verify.claims.catalogue import find_claim

pytestmark = pytest.mark.solver


def test_what_the_machine_does_is_always_within_bounds():
    found = [strays(seed) for seed in range(20)]
    assert [stray for stray, _ in found] == [[]] * len(found)
    assert sum(touched > 0 for _, touched in found) >= 12


@pytest.mark.parametrize("change", [{"contact_force": 1e6}, {"dt": 1e4}, {"dt": 0.0}, {"damping": 1.5}])
def test_what_numbers_do_not_cover_is_refused(change):
    """Pushes so strong, or steps so long, that roundings are larger than what proofs allow for."""
    profile = random_team(f"{SPREAD},agents=2", 1, 0)
    claim = find_claim("keeps_apart", profile, steps=5)
    region = around(profile, Fraction(1, 50), np.zeros((4, 2)))
    pairs = [(("agent_0", "agent_1"),)]
    assert ContactReading(profile, claim, region, None, ["agent_0"], pairs).contacts
    other = replace(profile, world=replace(profile.world, **change))
    with pytest.raises(RejectedError, match=r"rounding|does not say"):
        ContactReading(other, claim, region, None, ["agent_0"], pairs)
