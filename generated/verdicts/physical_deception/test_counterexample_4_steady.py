"""The claim of counterexample-4-steady.json must hold in its world state.

Run with pytest, beside that file and profile.json.
"""

from pathlib import Path

import maviper

HERE = Path(__file__).parent


def test_counterexample_4():
    found = maviper.replay(HERE / "counterexample-4-steady.json", HERE / "profile.json")
    assert not found.violated, f"{found.property} fails: {dict(found.actions)}"
