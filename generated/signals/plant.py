"""World files for proofs about signals: `python plant.py NETWORK FOLDER` writes one for each signal of a network.

Does: states phase, clocks and mask of a signal as `signals.py` moves them, and traffic that may be anything in each
  step; claims that hold for ever; says which phases of a program show a full green to two links that cross.
Assumes: the environment of `signals.py`, at decisions, which are 5 s apart. Clocks count such steps.
Does not: know vehicles. What counts is green, also one that yields ("g"). Clearance is the environment's: each switch
  takes a step of yellow and all red, before which conflicts are those of the program's own states.
"""

import sys
from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations, product
from pathlib import Path
from typing import Any

import signals
import sumolib
from junctions import CLOCK, STEP, Signal
from signals import MIN_GREEN

MAX_RED = 120  # seconds
LONG = 100_000  # steps: more than any red


def world(agent: str, signal: Signal, network: str, jumping: bool = False) -> str:
    """The text of a world file. `jumping`: clocks of phases that no link needs may be anything in each step, too, so
    that proofs about trees that test them end. What is proved holds of the true ones; a counterexample may not.
    """
    phases, clocks = range(len(signal.states)), [f"red_{k}" for k in range(len(signal.states))]
    free = {each.name: f"[0, {each.high:g}]" for each in signal.features if each.unit == "vehicles"}
    needed = set[int]().union(*least_sets(signal)) if jumping else set(phases)
    loose = {f"red_{k}": f"[0, {CLOCK // STEP}]" for k in phases if k not in needed}
    ranges = {"green": CLOCK // STEP + 2, "ended": CLOCK // STEP + 2, **dict.fromkeys(clocks, LONG)}
    zero = dict.fromkeys(("green", *clocks), 0)
    lines = [f"# Signal {signal.place} of {network}, in steps of {STEP} s. Traffic may be anything in each step."]
    lines += [f'name = "{network}_{agent}"', "steps = 60", "", "[variables]"]
    lines += ["on = { modes = [" + ", ".join(f'"green_{k}"' for k in phases) + "] }"]
    lines += [f'{name} = {{ unit = "steps", range = [-1, {most}] }}' for name, most in ranges.items()]
    lines += [f'{name} = {{ unit = "vehicles", range = {span} }}' for name, span in free.items()]
    lines += ["", f"[agents.{agent}.features]", *(f'on_{k} = "on == green_{k}"' for k in phases)]
    lines += [f'{name} = "{STEP}[s/steps]*{name}"' for name in ("green", *clocks)]
    lines += [f'{name} = "{name}"' for name in free]
    lines += ["", f"[agents.{agent}.actions]"]
    lines += [f"green_{k} = {table({name: int(j != k) for j, name in enumerate(clocks)})}" for k in phases]
    started = {"on": "'green_0'", **zero, "ended": MIN_GREEN // STEP, **free, **loose}
    lines += ["", "[start]", f"box = {table(started)}"]
    lines += ["", "[dynamics.error]", *(f"{name} = {span}" for name, span in {**free, **loose}.items())]
    lines += ["", "[dynamics.next]", *(f'{name} = "0[vehicles]"' for name in free)]
    lines += [f'{name} = "0[steps]"' for name in loose]
    for k in phases:
        lines += moves(agent, k, [name for name in clocks if name not in loose])
    return "\n".join([*lines, *claims(signal), ""])


def table(values: Mapping[str, object]) -> str:
    """A table of TOML in one line."""
    return "{ " + ", ".join(f"{name} = {value}" for name, value in values.items()) + " }"


def moves(agent: str, on: int, clocks: Sequence[str]) -> Iterator[str]:
    """What a step does while phase `on` has green: before its least green it stays, whatever the agent does."""
    least, most = MIN_GREEN // STEP, CLOCK // STEP
    kept = {name: "0[steps]" if name == f"red_{on}" else f"{name} + 1[steps]" for name in clocks}
    yield from piece(
        f"on == green_{on} and green < {least}[steps]",
        {"on": "on", "green": "green + 1[steps]", "ended": "ended", **kept},
    )
    left = f"{agent}.red_{on}"
    counted = {name: f"{agent}.{name}*({name} + 1[steps])" for name in clocks}
    ended = {"ended": f"{left}*green + (1 - {left})*ended"}
    for when, green in (
        (f"green >= {least}[steps] and green < {most}[steps]", "green + 1[steps]"),
        (f"green >= {most}[steps]", "green"),
    ):
        yield from piece(f"on == green_{on} and {when}", {
            "on": f"acts({agent})", "green": f"(1 - {left})*({green})", **ended, **counted
        })  # fmt: skip


def piece(when: str, moved: dict[str, str]) -> Iterator[str]:
    """A case of the dynamics."""
    yield from ("", "[[dynamics.piece]]", f'when = "{when}"', "[dynamics.piece.next]")
    yield from (f'{name} = "{form}"' for name, form in moved.items())


def claims(signal: Signal) -> Iterator[str]:
    """Least green; and that each link soon has green again, in one of its phases."""
    yield from ("", "[[claim]]", f'label = "no green is shorter than {MIN_GREEN} s"', 'name = "always"')
    least, most = MIN_GREEN // STEP, CLOCK // STEP + 1
    yield f"region = {{ box = {{ ended = [{least}, {most}] }} }}"
    boxes = (f'on = "green_{k}", green = [0, {most}], ended = [{least}, {most}]' for k in range(len(signal.states)))
    yield f"invariant = [{', '.join(f'{{ box = {{ {box} }} }}' for box in boxes)}]"
    last = MAX_RED / STEP - 0.5  # the step that gives green takes time, too; clocks are whole, sets of states are not
    boxes = ({f"red_{k}": [0, last] for k in chosen} for chosen in product(*least_sets(signal)))
    yield from ("", "[[claim]]", f'label = "every approach has green again within {MAX_RED} s"', 'name = "always"')
    yield f"region = [{', '.join(f'{{ box = {table(box)} }}' for box in boxes)}]"


def least_sets(signal: Signal) -> list[frozenset[int]]:
    """Sets of phases in which some link has green, but for those that hold another one."""
    shown = zip(*signal.states, strict=True)  # of each link, by phase
    known = {frozenset(k for k, letter in enumerate(link) if letter in "Gg") for link in shown} - {frozenset()}
    return sorted((each for each in known if not any(other < each for other in known)), key=sorted)


def conflicts(tls: Any) -> list[tuple[str, int, int]]:
    """States of a signal's program, with two links that cross at one node and both have full green."""
    links = {
        number: (way, origin.getEdge().getToNode())
        for origin, target, number in tls.getConnections()
        for way in origin.getOutgoing()
        if way.getToLane() == target
    }
    crossing = [
        (i, j)
        for (i, (one, node)), (j, (other, at)) in combinations(sorted(links.items(), key=lambda link: link[0]), 2)
        if node is at and node.areFoes(one.getJunctionIndex(), other.getJunctionIndex())
    ]
    states = [phase.state for program in tls.getPrograms().values() for phase in program.getPhases()]
    return [(state, i, j) for state in states for i, j in crossing if state[i] == state[j] == "G"]


def main(network: str, folder: str) -> None:
    """Writes the files, and prints which links that cross the program itself gives full green at once."""
    net = sumolib.net.readNet(signals.network_file(network).replace(".sumocfg", ".net.xml"), withPrograms=True)
    for agent, signal in signals.make(network).signals.items():
        Path(folder, f"{network}-{agent}.toml").write_text(world(agent, signal, network), encoding="utf-8")
        print(network, agent, signal.place, "conflicts:", conflicts(net.getTLS(signal.place)) or "none")


if __name__ == "__main__":
    main(*sys.argv[1:])
