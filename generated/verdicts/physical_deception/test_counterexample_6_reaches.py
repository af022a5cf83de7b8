"""The claim of counterexample-6-reaches.json must hold from its start.

Run with pytest, beside that file and profile.json.
"""

from pathlib import Path

import maviper

HERE = Path(__file__).parent


def test_counterexample_6():
    found = maviper.replay(HERE / "counterexample-6-reaches.json", HERE / "profile.json")
    assert not found.violated, f"{found.property} fails: {dict(found.actions)}"
