"""Traffic that waits for ever: `python routes.py NETWORK SIGNAL PROFILE FILE` writes SUMO's routes, and shows the wait.

Does: asks whether trees may keep a phase while somebody has stood before another one for two minutes; if so, sends as
  many vehicles to each approach as the counterexample has; prints the longest red with somebody before it, by approach.
Assumes: the environment of `signals.py`, and the world file of the signal in `worlds/`; an older FILE where none may.
Does not: follow the counterexample step by step: vehicles keep coming to an approach at a steady rate.
"""

import json
import sys
from collections.abc import Mapping
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory

import libsumo
import signals
from junctions import STEP, Signal
from plant import MAX_RED

import maviper

SPEED = 10.0  # metres a second: how fast vehicles are thought to pass an approach


def ask(network: str, agent: str, signal: Signal, team: maviper.Team) -> Mapping[str, float] | None:
    """Vehicles for which the trees keep a phase while somebody waits for another one; None where there are none."""
    lines, given = [], {int(action.name.removeprefix("green_")) for action in team[agent].actions}
    for k, each in product(sorted(given), signal.approaches):
        if each.phases and k not in each.phases:
            clocks = [f"red_{j} >= {MAX_RED // STEP}[steps]" for j in sorted(each.phases)]
            asked = " and ".join([f"on == green_{k}", f"{each.name}_halting >= 1[vehicles]", *clocks])
            kept = f"acts({agent}) == green_{k}"
            lines += ["[[claim]]", f'label = "{each.name}"', f'formula = "{asked} implies not {kept}"']
    with TemporaryDirectory() as folder:
        claims = Path(folder, "claims.toml")
        claims.write_text("\n".join(lines), encoding="utf-8")
        world = Path(__file__).parent / "worlds" / f"{network}-{agent}.toml"
        for result in maviper.verify_system(team, world, claims).results:
            if result.verdict == "VIOLATED":
                return {name: float(value) for name, value in result.counterexample.states[0].items()}
    return None


def routes(signal: Signal, wanted: Mapping[str, float]) -> str:
    """A file of SUMO's, in the network that runs, with about so many vehicles in each approach."""
    lines, now = [], libsumo.simulation.getTime()
    links = [link for ways in libsumo.trafficlight.getControlledLinks(signal.place) for link in ways]
    for each in signal.approaches:
        lane, to = next((lane, to) for lane, to, _ in links if lane in each.lanes)
        count = max(wanted[f"{each.name}_cars"], wanted[f"{each.name}_halting"])
        if count:
            edges, place = f"{libsumo.lane.getEdgeID(lane)} {libsumo.lane.getEdgeID(to)}", lane.rpartition("_")[2]
            times = f'begin="{now:.0f}" end="{now + 3600:.0f}" vehsPerHour="{_rate(lane, count):.0f}"'
            lines += [f'<flow id="{each.name}" {times} departLane="{place}"><route edges="{edges}"/></flow>']
    return "\n".join(["<routes>", *lines, "</routes>", ""])


def _rate(lane: str, count: float) -> float:
    """How many vehicles an hour keep so many in a lane, at most one in two seconds."""
    return 3600 * min(0.5, count * SPEED / libsumo.lane.getLength(lane))


def wait(network: str, agent: str, file: str, team: maviper.Team, seconds: int = 600) -> dict[str, int]:
    """The longest red in which somebody stood, by approach, in seconds, in traffic of a file."""
    env, policy = signals.make(network, seconds, routes=file), team[agent]
    seen, _ = env.reset(0)
    longest = dict[str, int]()
    while env.agents:
        action = policy.actions[policy.act([seen[agent].astype(policy.numbers)])[0]].name
        seen, *_ = env.step({agent: env.action_names[agent].index(action)} if agent in env.acting else {})
        told = dict(zip((each.name for each in env.features[agent]), seen[agent].tolist(), strict=True))
        for each in env.signals[agent].approaches:
            red = int(min((told[f"red_{k}"] for k in each.phases), default=0))
            if told[f"{each.name}_halting"]:
                longest[each.name] = max(red, longest.get(each.name, 0))
    return longest


def main(network: str, agent: str, profile: str, file: str) -> None:
    """Writes the file where somebody may wait, and prints the longest waits in it."""
    env, team = signals.make(network), maviper.load(profile)
    wanted = ask(network, agent, env.signals[agent], team)
    if wanted is not None:
        env.reset(0)
        Path(file).write_text(routes(env.signals[agent], wanted), encoding="utf-8")
        env.close()
    print(json.dumps(wait(network, agent, file, team)))


if __name__ == "__main__":
    main(*sys.argv[1:])
