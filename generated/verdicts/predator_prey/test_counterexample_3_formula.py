"""The claim of counterexample-3-formula.json must hold in its world state.

Run with pytest, beside that file and profile.json.
"""

from pathlib import Path

import maviper

HERE = Path(__file__).parent


def test_counterexample_3():
    found = maviper.replay(HERE / "counterexample-3-formula.json", HERE / "profile.json")
    assert not found.violated, f"{found.property} fails: {dict(found.actions)}"
