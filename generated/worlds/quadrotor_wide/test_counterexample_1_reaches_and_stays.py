"""The claim of counterexample-1-reaches_and_stays.json must hold from its start, in world.toml.

Run with pytest, beside that file and profile.json.
"""

from pathlib import Path

import maviper

HERE = Path(__file__).parent


def test_counterexample_1():
    found = maviper.replay(HERE / "counterexample-1-reaches_and_stays.json", HERE / "profile.json")
    assert not found.violated, f"{found.property} fails: {dict(found.actions)}"
