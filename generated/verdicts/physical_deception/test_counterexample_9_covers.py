"""The claim of counterexample-9-covers.json must hold from its start.

Run with pytest, beside that file and profile.json.
"""

from pathlib import Path

import maviper

HERE = Path(__file__).parent


def test_counterexample_9():
    found = maviper.replay(HERE / "counterexample-9-covers.json", HERE / "profile.json")
    assert not found.violated, f"{found.property} fails: {dict(found.actions)}"
