"""What several tests use of `test_generated`."""

from pathlib import Path

FOLDER = Path(__file__).parent.parent.parent / "generated" / "physical_deception"
