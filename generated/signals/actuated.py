"""A controller with gaps and longest reds as if/else Python: `python actuated.py NETWORK FILE [RED]`.

Does: keeps a phase while more than GAP vehicles come to it from one approach, then gives green to a phase for which
  somebody stands; gives green to each phase that some link needs once it was red for RED seconds.
Assumes: the environment of `signals.py`. Without RED a phase may wait for ever: `maviper verify` shows by whom.
Does not: compare sums, so that `maviper import` makes small trees of it.
"""

import sys
from collections.abc import Iterator
from pathlib import Path

import plant
import signals
from junctions import Signal

GAP = 2.5  # vehicles


def rule(agent: str, signal: Signal, red: float | None) -> Iterator[str]:
    """The lines of a function."""
    yield f"def {agent}({', '.join(each.name for each in signal.features)}):"
    needed = sorted(set().union(*plant.least_sets(signal)))
    for k in needed if red is not None else ():
        yield f'    if red_{k} > {red}:\n        return "green_{k}"'
    for on in range(len(signal.states)):
        yield f"    if on_{on} > 0.5:"
        for each in signal.approaches:
            if on in each.phases and not each.phases & {*needed} - {on}:
                yield f'        if {each.name}_cars > {GAP}:\n            return "green_{on}"'
        for each in signal.approaches:
            if on not in each.phases and each.phases:
                to = min(each.phases, key=lambda k: (k not in needed, (k - on) % len(signal.states)))
                yield f'        if {each.name}_halting > 0.5:\n            return "green_{to}"'
        yield f'        return "green_{on}"'
    yield '    return "green_0"\n'


def main(network: str, file: str, red: str | None = None) -> None:
    """Writes the file."""
    rules = signals.make(network).signals.items()
    lines = [line for agent, signal in rules for line in rule(agent, signal, None if red is None else float(red))]
    Path(file).write_text("\n".join(lines), encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])
