"""Every planted fault is caught by its guard; without a fault no guard speaks."""

import numpy as np
import pytest

from codegen import policy_json, profiles
from codegen.agreement import selfcheck
from codegen.lowering.lower import lower
from codegen.targets import emit
from maviper.extraction.settings import EXACT
from tests import faults
from tests.conftest import extracted_quickly

pytestmark = [pytest.mark.compile, pytest.mark.solver, pytest.mark.usefixtures("few_observations")]


@pytest.fixture(scope="module")
def profile(world, clone):
    """Trees that test many features, one as many as are copied in tiles: of the script's clone, as those of the shipped
    expert are smaller, and by every threshold.
    """
    found = extracted_quickly(world, clone, splits=EXACT)
    assert lower(found).tiled
    return found


@pytest.mark.parametrize("fault", faults.ALL, ids=lambda fault: fault.name)
def test_the_fault_is_caught(fault, profile, monkeypatch):
    assert fault.plant(profile, monkeypatch), f"{fault.name} went unnoticed by {fault.guard}"


def test_without_a_fault_no_guard_speaks(profile):
    assert not any(item.differences for item in selfcheck.check_files(profile, emit(profile), random=1_000).agreements)
    for policy in profile.agents:
        nothing = np.zeros((0, len(policy.features)), dtype=np.float32)
        assert selfcheck.check_grown(policy, nothing).differences == 0
    profiles.loads(policy_json.dumps(profile))
    assert not faults.encoder_wrong(profile)
    assert not faults.verdicts_wrong(profile)
    assert not faults.steady_wrong(profile)
    assert not faults.assuming_wrong(profile)
    assert not faults.starts_lost(profile)
    assert not faults.episode_cases.verdicts_wrong(profile)
    assert not faults.episode_cases.signs_wrong(profile)
    assert not faults.courses_stray(profile)


def test_the_list(capsys):
    assert len({fault.name for fault in faults.ALL}) == len(faults.ALL) >= 50
    with capsys.disabled():
        print(f"\n{len(faults.ALL)} planted faults, each caught:")
        for fault in faults.ALL:
            print(f"  {fault.name:<55} {fault.guard}")
