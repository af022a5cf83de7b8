"""A mountain car as a stated system: the whole command, beside forty lines of numpy (mountain_direct.py).

    python -m tests.benchmarks.mountain_car [--rounds N] [--json]

The controller is the one of Gymnasium's tutorial: it pushes in the direction in which the car moves. The claim: within
200 steps the car is on the hill. The command also starts, shows enclosures again, checks its certificate, and asks
teams with shuffled leaves.
"""

import statistics
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from tests.benchmarks.common import figure, reader, spent, spent_by, tell, turns

HERE = Path(__file__).parent
CONTROLLER = """
def agent(obs):
    position, velocity = obs
    if velocity > 0:
        return "accelerate_right"
    elif velocity < 0:
        return "accelerate_left"
    return "coast"
"""


def measure(place, rounds):
    """The median ratio of the command's seconds to those of the lines, in turns."""
    (place / "agent.py").write_text(CONTROLLER)
    assert spent("import", "--agents", f"agent={place}/agent.py", "-o", place / "car.json").code == 0
    ways = {
        "command": lambda: spent("-q", "verify", place / "car.json", "--system", HERE / "mountain_car.toml"),
        "lines": lambda: spent_by(sys.executable, HERE / "mountain_direct.py"),
    }
    took = {name: [] for name in ways}
    for order in turns(list(ways), rounds):
        for name in order:
            ended = ways[name]()
            assert ended.code == 0, name
            took[name].append(ended.seconds)
    return statistics.median(ours / theirs for ours, theirs in zip(took["command"], took["lines"], strict=True))


def main():
    parser = reader(__doc__)
    parser.add_argument("--rounds", type=int, default=5)
    options = parser.parse_args()
    with TemporaryDirectory() as place:
        ratio = measure(Path(place), options.rounds)
    tell([figure("mountain car, whole command over forty lines of numpy", ratio, 15.0, 5.0)], options.json)


if __name__ == "__main__":
    main()
