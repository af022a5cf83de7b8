"""What several tests use of `maviper.test_importing_page`."""

from pathlib import Path

ROOT = Path(__file__).parent.parent.parent
PAGE = "maviper/manual/importing.md"
EXACT, REFUSED = "exact", "refused"
