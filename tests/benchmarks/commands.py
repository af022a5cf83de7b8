"""What whole commands cost beside the least process that could answer, in CPU seconds of one interleaved run.

    python -m tests.benchmarks.commands [--rounds 5] [--json] [NAME ...]

Help: `maviper --help`, and `import maviper`, over a Python that starts and ends. Proved: `maviper verify` of the
demo's team over a process that imports numpy. Refuted: `maviper verify` of teams of two trees over a process that
decides the claim by one query of Z3 (direct.py). Half of these teams have fixed roles, half choose the nearer of two
matchings; their trees are fitted to states drawn with a seed.
"""

import statistics
import sys
import tempfile
from pathlib import Path

from codegen.policy_json import dumps
from tests.benchmarks.common import interleave_commands, listed, reader, tell
from tests.benchmarks.verifier import Played, deception_team

PYTHON = sys.executable
MAVIPER = (PYTHON, "-m", "maviper")
DEMO = "generated/physical_deception/profile.json"
REFUTED = [("roles", 8), ("roles", 10), ("nearer", 4), ("nearer", 8), ("nearer", 10)]
TARGETS = {
    "--help over bare Python": (4.0, 3.0, "lower"),
    "import maviper over bare Python": (4.0, 3.0, "lower"),
    "verify of the demo's team over import numpy": (5.0, 3.0, "lower"),
    **{f"refuted, {kind} {depth}, over a process of Z3": (3.0, 2.0, "lower") for kind, depth in REFUTED},
}


def main():
    parser = reader(__doc__)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("names", nargs="*", metavar="NAME", help="figures whose names hold one of these words")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        pairs = {
            name: pair
            for name, pair in pairs_in(Path(folder)).items()
            if not options.names or any(word in name for word in options.names)
        }
        values = {name: measured(*pair, options.rounds, not options.json) for name, pair in pairs.items()}
    tell(listed(values, TARGETS), options.json)


def pairs_in(folder):
    """Name of a figure -> the command and the process that it is compared with."""
    bare = (PYTHON, "-c", "pass")
    pairs = {
        "--help over bare Python": ((*MAVIPER, "--help"), bare),
        "import maviper over bare Python": ((PYTHON, "-c", "import maviper"), bare),
        "verify of the demo's team over import numpy": ((*MAVIPER, "verify", DEMO), (PYTHON, "-c", "import numpy")),
    }
    game = Played("physical-deception")
    for kind, depth in REFUTED:
        path = folder / f"{kind}-{depth}.json"
        path.write_text(dumps(deception_team(game, kind, depth)))
        direct = (PYTHON, "-m", "tests.benchmarks.direct", path, "defenders")
        pairs[f"refuted, {kind} {depth}, over a process of Z3"] = (*MAVIPER, "verify", path, "--json"), direct
    return pairs


def measured(command, peer, rounds, shown):
    """The ratio of their median CPU seconds."""
    times = interleave_commands({"ours": command, "peer": peer}, rounds, (0, 1))
    ours, theirs = (statistics.median(times[name]) for name in ("ours", "peer"))
    if shown:
        print(f"{' '.join(map(str, command[2:]))}: {ours:.3f} s, {' '.join(map(str, peer[1:]))}: {theirs:.3f} s")
    return ours / theirs


if __name__ == "__main__":
    main()
