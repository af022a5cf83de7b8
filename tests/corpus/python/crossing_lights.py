#!/usr/bin/env python3
import argparse
import sys
from typing import Final, Literal, NamedTuple

Phase = Literal["NS_GREEN", "EW_GREEN", "ALL_RED"]


class Obs(NamedTuple):
    queue_ns: float
    queue_ew: float
    elapsed: float
    pedestrian: float


MIN_GREEN: Final = 8
MAX_GREEN: Final = 45
WEIGHTS: Final[dict[str, float]] = {"ns": 1.0, "ew": 1.25}


def score(queue: float, axis: str) -> float:
    return WEIGHTS[axis] * queue


def decide(obs: Obs) -> Phase:
    if (waiting := obs.pedestrian >= 1) and obs.elapsed >= MIN_GREEN:
        return "ALL_RED"
    if obs.elapsed < MIN_GREEN:
        return "NS_GREEN"
    options = [("NS_GREEN", score(obs.queue_ns, "ns")), ("EW_GREEN", score(obs.queue_ew, "ew"))]
    if all(s < 2 for _, s in options):
        return "NS_GREEN" if not waiting else "ALL_RED"
    if obs.elapsed > MAX_GREEN or score(obs.queue_ew, "ew") > 10:
        return "EW_GREEN"
    return "NS_GREEN"


def main(argv=None):
    parser = argparse.ArgumentParser()
    parser.add_argument("values", nargs=4, type=float)
    args = parser.parse_args(argv)
    print(decide(Obs(*args.values)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
