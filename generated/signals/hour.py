r"""An hour of a signal by three controllers: `python hour.py` writes hour/hour.json, which `city.py` draws.

Does: has SUMO play the same hour by greedy, by the tree that was extracted from it, and by that tree with guards; keeps
  which phase is on every 5 s, for how long somebody stood in an approach without green, and the delay.
Assumes: the environment of `signals.py`; the trees in hour/, which these commands made:
  maviper extract baselines:greedy,network=ingolstadt1 --critic none --max-episodes 20 --max-depth 3 \
    --set measure=delay -o hour/learned.json
  python repaired.py ingolstadt1 hour/learned.json hour
Does not: say that one hour is like another.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import baselines
import signals
from junctions import STEP
from libsumo import lane as lanes
from libsumo import trafficlight as lights

import maviper
from codegen.form import layout

NETWORK, AGENT, SEED, PLACE = "ingolstadt1", "signal_0", 3_000_000, Path(__file__).parent / "hour"
WAYS = {"l": "left", "L": "left", "s": "straight", "r": "right", "R": "right", "t": "back"}


def controllers() -> dict[str, Callable[[Any, Any], int]]:
    """Name -> the phase for a signal and what it observes."""
    found = {"expert": lambda signal, seen: int(baselines.RULES["greedy"](signal, seen[None])[0])}
    for name, file in (("tree", "learned.json"), ("guarded", f"{NETWORK}.json")):
        policy = maviper.load(PLACE / file)[AGENT]
        phases = [int(action.name.removeprefix("green_")) for action in policy.actions]
        found[name] = lambda signal, seen, policy=policy, phases=phases: phases[int(policy.act([seen])[0])]
    return found


def play(env: signals.Signals, choose: Callable[[Any, Any], int]) -> dict[str, Any]:
    """What is kept of an hour."""
    signal, seconds = env.signals[AGENT], {each.name: [0, 0] for each in env.signals[AGENT].approaches}
    show, phases = signal.show, list[int]()

    def look(phase: int) -> None:
        before = signal.phase
        show(phase)
        phases.append(phase)
        for each in signal.approaches:
            stands = sum(map(lanes.getLastStepHaltingNumber, each.lanes))
            now, most = seconds[each.name]
            now = 0 if {before, phase} <= each.phases or not (stands or now) else now + STEP
            seconds[each.name] = [now, max(now, most)]

    signal.show = look
    seen, _ = env.reset(SEED)
    infos = {}
    while env.agents:
        seen, *_, infos = env.step({agent: choose(signal, seen[agent]) for agent in env.acting})
    signal.show = show
    stood = {name: most for name, (_, most) in seconds.items()}
    return {"delay": infos[AGENT]["delay"], "stood": stood, "phases": "".join(map(str, phases))}


def hour() -> dict[str, Any]:
    """The approaches with the phases that serve them, and what is kept of each controller."""
    env = signals.make(NETWORK)
    played = {name: play(env, choose) for name, choose in controllers().items()}
    env.reset(SEED)  # where lanes lead can be asked of a simulation that runs
    own = {*lights.getControlledLanes(env.signals[AGENT].place)}
    approaches = {
        each.name: {
            "phases": sorted(each.phases),
            "turns": sorted({WAYS[link[6]] for lane in {*each.lanes} & own for link in lanes.getLinks(lane)}),
        }
        for each in env.signals[AGENT].approaches
    }
    env.close()
    return {"network": NETWORK, "seed": SEED, "place": env.signals[AGENT].place, "approaches": approaches, **played}


if __name__ == "__main__":
    (PLACE / "hour.json").write_text(layout(hour()) + "\n", encoding="utf-8")
