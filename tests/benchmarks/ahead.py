"""Whether the time left that commands show is right: what each stage said after a tenth of its work, over what it took.

    python -m tests.benchmarks.ahead [--json] [CASE ...]

Each command runs in a process of its own whose live lines go by its CPU time, so that a busy machine changes nothing.
A stage counts if it takes at least a second. Said over real: the worst of all that was said from a tenth of the
stage's steps on until half of a second was left. The clock of `extract` covers all stages, so there until the end.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

from codegen.policy_json import dumps
from tests.benchmarks.common import figure, reader, tell
from tests.benchmarks.large import full

WORLDS = Path(__file__).parents[2] / "generated" / "worlds"
PROVED = Path(__file__).parents[2] / "generated" / "proved_defenders" / "profile.json"
WALKING = "tests.support.environments:walking_expert"
CASES = {
    "extract deception": ["extract", "physical-deception", "--max-episodes", "4000", "-o", "{out}/a.json"],
    "extract 6 agents": ["extract", "cooperative-navigation,agents=6", "--max-episodes", "200", "-o", "{out}/a.json"],
    "extract own game": ["extract", WALKING, "--critic", "none", "--max-episodes", "20000", "-o", "{out}/a.json"],
    "evaluate": ["evaluate", str(PROVED), "--episodes", "20000"],
    "compile 12 agents": ["compile", "{out}/twelve.json", "-o", "{out}/code"],
    "verify a system": ["verify", str(WORLDS / "crossing.json"), "--system", str(WORLDS / "crossing.toml")],
    "verify episodes": ["verify", str(PROVED), "--claim", "reaches"],
}
LEAST, TENTH, LAST = 1.0, 0.1, 0.5
CHILD = """
import json, sys, time
time.monotonic = time.process_time
from maviper import console
told, line, show = [], console.LiveLine, console.LiveLine.show
def kept(self, done, text, left):
    told.append([id(self), self.label, done, self.total, self.elapsed, left, time.monotonic()])
    show(self, done, text, left)
line.show = kept
from maviper.cli import main
main.run(sys.argv[2:])
open(sys.argv[1], "w").write(json.dumps(told))
"""


def run(words: list[str], folder: str) -> dict[str, float]:
    """A command's stages: the worst of said over real, above or below 1."""
    place = Path(folder) / "told.json"
    given = [word.format(out=folder) for word in words]
    subprocess.run([sys.executable, "-c", CHILD, str(place), *given], check=True, capture_output=True)
    stages: dict[tuple[int, str], list[tuple[float, float, float | None, float]]] = {}
    for key, label, done, total, elapsed, said, at in json.loads(place.read_text()):
        stages.setdefault((key, label), []).append((done / total, elapsed, said, at))
    found: dict[str, float] = {}
    last = max((lines[-1][3] for lines in stages.values()), default=0.0)
    for (_, label), lines in stages.items():
        end = last if words[0] == "extract" else lines[-1][3]
        ratios = [
            said / (end - at)
            for share, _, said, at in lines
            if said is not None and lines[-1][1] >= LEAST and share >= TENTH and end - at >= LAST
        ]
        if ratios:
            found[label] = max(ratios, key=lambda ratio: max(ratio, 1 / max(ratio, 1e-9)))
    return found


def main() -> None:
    """The table, or its figures."""
    parser = reader(__doc__)
    parser.add_argument("cases", nargs="*", metavar="CASE", help=f"some of: {'; '.join(CASES)}")
    options = parser.parse_args()
    figures = []
    for name in options.cases or CASES:
        with tempfile.TemporaryDirectory() as folder:
            if "twelve" in str(CASES[name]):
                team = full("cooperative-navigation,agents=12", 6, "agents")
                (Path(folder) / "twelve.json").write_text(dumps(team))
            found = run(CASES[name], folder)
        if not found and not options.json:
            print(f"{name:20} shows no time left, or takes less than a second")
        for stage, ratio in found.items():
            off = max(ratio, 1 / max(ratio, 1e-9))
            figures.append(figure(f"{name}, {stage}", off, 2, 1.5))
    tell(figures, options.json)


if __name__ == "__main__":
    main()
