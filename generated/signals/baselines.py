"""Controllers that traffic engineers know, as experts, and what they reach: `python baselines.py NETWORK ...`.

Does: longest queue, greedy and max pressure, which give green to the phase with the largest sum over its approaches;
  alternate, which looks at no vehicle; a table of RESCO's measures, with the network's own program (`fixed`).
Assumes: the environment of `signals.py`, whose features tell all that a rule needs.
Does not: learn, or switch for ties: the phase that is on wins them.
"""

import sys
from collections.abc import Callable, Mapping, Sequence
from itertools import product
from typing import Any

import numpy as np
import signals
from junctions import Signal

from maviper.worlds import find

SEEDS = range(3_000_000, 3_000_005)  # the first held-out ones of `maviper evaluate`
HOLD = 20  # seconds of green that `alternate` gives
Floats = Any  # arrays of numpy
WEIGHTS: Mapping[str, Mapping[str, float]] = {
    "longest_queue": {"halting": 1},
    "greedy": {"cars": 1},
    "max_pressure": {"cars": 1, "ahead": -1},
}


class Rule:
    """An expert for the world `name`: `phase(signal, seen)` says who gets green, [n], from [n, n_features]."""

    hash, centralized = "", False

    def __init__(self, network: str, options: Mapping[str, Any], phase: Callable[[Signal, Floats], Floats]) -> None:
        said = ",".join(f"{key}={value}" for key, value in {"network": network, **options}.items())
        self.world = find(f"signals:make,{said}")
        self.agents, self.phase = self.world.agents, phase
        self.card = {"algorithm": phase.__name__}
        self.signals = signals.make(network).signals

    def act(self, agents: Sequence[int], observations: Sequence[Floats], state: Any) -> Floats:
        """The actions of some agents, [batch, len(agents)]."""
        return np.stack([self.phase(self.signals[self.agents[k]], observations[k]) for k in agents], axis=1)


def _heaviest(weights: Mapping[str, float]) -> Callable[[Signal, Floats], Floats]:
    def phase(signal: Signal, seen: Floats) -> Floats:
        names = [each.name for each in signal.features]
        scores = seen[:, : len(signal.states)] * 0.5  # less than a vehicle: for the phase that is on
        for approach, (kind, weight) in product(signal.approaches, weights.items()):
            scores[:, list(approach.phases)] += weight * seen[:, [names.index(f"{approach.name}_{kind}")]]
        return scores.argmax(axis=1)

    return phase


def _alternate(signal: Signal, seen: Floats) -> Floats:
    """The next phase in turn of those that serve what no other one serves as well."""
    served = [{each.name for each in signal.approaches if k in each.phases} for k in range(len(signal.states))]
    turn = [k for k, mine in enumerate(served) if not any(mine < other for other in served)]
    after = [min((each for each in turn if each > k), default=turn[0]) for k in range(len(served))]
    on, green = seen[:, : len(served)].argmax(axis=1), seen[:, len(served)]
    return np.where(green < HOLD, on, np.array(after)[on])


RULES = {name: _heaviest(weights) for name, weights in WEIGHTS.items()} | {"alternate": _alternate}


def longest_queue(network: str = "cologne3", **options: Any) -> Rule:
    """Green for most vehicles that stand."""
    return Rule(network, options, RULES["longest_queue"])


def greedy(network: str = "cologne3", **options: Any) -> Rule:
    """Green for most vehicles."""
    return Rule(network, options, RULES["greedy"])


def max_pressure(network: str = "cologne3", **options: Any) -> Rule:
    """Green for most vehicles, less those in the lanes that they go to."""
    return Rule(network, options, RULES["max_pressure"])


def alternate(network: str = "cologne3", **options: Any) -> Rule:
    """Green for each phase in turn, whatever the traffic."""
    return Rule(network, options, RULES["alternate"])


def play(env: signals.Signals, phase: Callable[[Signal, Floats], Floats], seed: int) -> dict[str, float]:
    """An episode's delay, waiting and mean queue."""
    seen, _ = env.reset(seed)
    infos = {}
    while env.agents:
        seen, *_, infos = env.step({a: int(phase(env.signals[a], seen[a][None])[0]) for a in env.acting})
    return infos[env.possible_agents[0]]


def main(networks: Sequence[str]) -> None:
    """Prints a row for each network and controller: means over SEEDS, and their deviation."""
    print("network        controller       delay s        waiting s      queue")
    for network, (name, phase) in product(networks, {"fixed": _alternate, **RULES}.items()):
        env = signals.make(network, own=name == "fixed")
        found = [play(env, phase, seed) for seed in SEEDS]
        cells = [[each[key] for each in found] for key in ("delay", "waiting", "queue")]
        shown = "".join(f"{np.mean(cell):7.1f} +-{np.std(cell, ddof=1):5.1f}" for cell in cells)
        print(f"{network:<14} {name:<14} {shown}", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:] or signals.NETWORKS)
