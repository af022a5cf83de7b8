"""How long a user waits for the first words: `maviper --help` beside an empty Python, interleaved, whole processes.

python tests/benchmarks/startup.py [--rounds 20] [--json]
"""

import argparse
import json
import statistics
import subprocess
import sys
import time

REACH_SECONDS = 0.3


def seconds(*command: str) -> float:
    started = time.perf_counter()
    subprocess.run([sys.executable, *command], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return time.perf_counter() - started


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=20)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    rows = [(seconds("-m", "maviper", "--help"), seconds("-c", "pass")) for _ in range(options.rounds)]
    ours, empty = (statistics.median(column) for column in zip(*rows, strict=True))
    ratio = statistics.median(ours / empty for ours, empty in rows)
    figures = [
        {"name": "maviper --help, seconds", "value": ours, "reach": REACH_SECONDS, "better": "lower"},
        {"name": "maviper --help over an empty Python", "value": ratio, "better": "lower"},
    ]
    if options.json:
        print(json.dumps({"figures": figures}))
    else:
        print(f"maviper --help {ours:.3f} s (reach {REACH_SECONDS} s), empty Python {empty:.3f} s, ratio {ratio:.1f}")


if __name__ == "__main__":
    main()
