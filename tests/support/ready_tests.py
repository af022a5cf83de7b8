"""Ready tests of counterexamples beside several policies, all in one run of pytest."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
WORDS = ("PASSED", "FAILED", "ERROR")


def outcomes(place, names, policies):
    """What becomes of ready tests beside each policy: the word that pytest says, by the policy's name.

    `names`: the files of a ready test; the policy stands for its profile.json. Copies are put into `place`.
    """
    for policy in policies:
        folder = place / policy.stem
        folder.mkdir()
        for path in names:
            (folder / path.name).write_bytes(path.read_bytes())
        (folder / "profile.json").write_bytes(policy.read_bytes())
    command = [sys.executable, "-m", "pytest", "-q", "-rA", "-p", "no:cacheprovider", "--import-mode=importlib", place]
    ran = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    said = [line.split() for line in ran.stdout.splitlines() if line.startswith(WORDS)]
    found = {Path(test.partition("::")[0]).parent.name: word for word, test, *_ in said}
    assert len(said) == len(found) == len(policies), ran.stdout
    return found
