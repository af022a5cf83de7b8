"""Signals of real cities: RESCO's six networks in SUMO, as an environment whose agents choose who gets green.

Does: simulates by `libsumo`; finds the networks in the installed package `sumo-rl`, without importing it.
Assumes: `pip install 'maviper[signals]'`. SUMO 1.28 itself may play cologne1 in two ways from one seed.
Does not: simulate pedestrians, or change the demand. A seed is SUMO's own: it is about how drivers drive.

Every 5 s a signal `signal_0`, `signal_1`, ... does `green_K`, which gives green to phase K of its own program. If
another one is on, clearance takes these 5 s: 3 s of yellow, then 2 s of all red, for whoever loses green. A signal does
not act before 10 s of green: `acting` masks all actions of it at once. Where no signal may act, another 5 s pass.

An approach is the lanes of one road that have green in the same phases, named by where its traffic comes from, as in
`south_west_2`. A signal observes, in this order:
- `on_K` for each phase: 1 where K is on, else 0;
- `green`: seconds since the phase that is on got its green;
- `red_K` for each phase: seconds since K had green, 0 where it is on;
- for each approach A `A_cars` and `A_halting`, its vehicles and those that stand, and `A_ahead`, those in the lanes it
  leads to: counts, and at most what fits there.
Clocks count to 240 s. An hour starts with phase 0 and all clocks at 0, so `red_K` says nothing before K is served.

A reward is minus the vehicles that stand before the signal. `measures` are RESCO's: `delay` and `waiting` in seconds a
trip, those that never departed included, and `queue`, the vehicles that stand before all signals.
"""

import xml.etree.ElementTree as ET
from collections.abc import Mapping
from importlib.util import find_spec
from pathlib import Path
from shutil import rmtree
from tempfile import mkdtemp
from typing import Any
from weakref import finalize

import junctions
import libsumo
import numpy as np
from gymnasium.spaces import Box, Discrete
from junctions import STEP
from pettingzoo import ParallelEnv

NETWORKS = ("cologne1", "cologne3", "cologne8", "ingolstadt1", "ingolstadt7", "ingolstadt21")
YELLOW, MIN_GREEN = 3, 10  # seconds
Dicts = tuple[dict[str, Any], ...]


class Signals(ParallelEnv):
    """The signals of a network. `own`: they play its own program, fixed in time, whatever agents choose; `routes`: a
    file of SUMO's with the traffic, in place of the network's.
    """

    metadata: dict[str, Any] = {"name": "signals"}  # noqa: RUF012
    alone = True  # libsumo has one simulation a process
    measures = {name: (name, "last", "lower") for name in ("delay", "waiting", "queue")}  # noqa: RUF012

    def __init__(self, network: str, seconds: int, own: bool, routes: str) -> None:
        self.config, folder = ["-c", network_file(network), *(["-r", routes] if routes else [])], mkdtemp()
        finalize(self, rmtree, folder)
        self.trips = f"{folder}/trips.xml"
        self.own, self.max_cycles, self.queues = own, seconds // STEP, list[int]()
        self._start(0)
        self.signals = junctions.signals()
        self.possible_agents, self.agents = list(self.signals), []
        self.features = {agent: signal.features for agent, signal in self.signals.items()}
        self.action_names = {a: [f"green_{k}" for k in range(len(s.states))] for a, s in self.signals.items()}
        self.close()

    def _start(self, seed: int) -> None:
        trips = ["--tripinfo-output", self.trips, "--tripinfo-output.write-unfinished"]
        options = ["--tripinfo-output.write-undeparted", "--no-step-log", "--no-warnings", "--time-to-teleport", "-1"]
        libsumo.start(["sumo", *self.config, "--seed", str(seed), *trips, *options])

    @property
    def acting(self) -> list[str]:
        """Those whose phase has had its least green."""
        return [agent for agent in self.agents if self.own or self.signals[agent].green >= MIN_GREEN]

    def observation_space(self, agent: Any) -> Box:
        """As `features` say."""
        high = np.array([each.high for each in self.features[agent]], np.float32)
        return Box(np.zeros_like(high), high)

    def action_space(self, agent: Any) -> Discrete:
        """One action for each phase."""
        return Discrete(len(self.action_names[agent]))

    def reset(self, seed: int | None = None, options: Any = None) -> Dicts:
        """The first moment of the hour at which somebody may act."""
        self.close()
        self._start(seed or 0)
        self.agents, self.queues = list(self.possible_agents), []
        for signal in self.signals.values():
            signal.start()
        self._pass_time({})
        return {agent: signal.observe() for agent, signal in self.signals.items()}, {a: {} for a in self.agents}

    def step(self, actions: Mapping[str, int]) -> Dicts:
        """Five seconds at a time, until somebody may act again: clearance where a signal switches, else green."""
        rewards = self._pass_time(actions)
        seen = {agent: signal.observe() for agent, signal in self.signals.items()}
        cut = len(self.queues) >= self.max_cycles
        ends = dict.fromkeys(self.agents, False), dict.fromkeys(self.agents, cut)
        infos = dict.fromkeys(self.agents, self._means() if cut else {})
        self.agents = [] if cut else self.agents
        return seen, rewards, *ends, infos

    def _pass_time(self, actions: Mapping[str, int]) -> dict[str, float]:
        """Returns what each agent is paid meanwhile."""
        paid = dict.fromkeys(self.agents, 0.0)
        while True:
            chosen = {agent: int(actions[agent]) for agent in self.acting if agent in actions}
            moved = {} if self.own else self.signals
            self._move({agent: chosen.get(agent, signal.phase) for agent, signal in moved.items()})
            standing = {agent: signal.standing() for agent, signal in self.signals.items()}
            self.queues.append(sum(standing.values()))
            paid, actions = {agent: paid[agent] - count for agent, count in standing.items()}, {}
            if self.acting or len(self.queues) >= self.max_cycles:
                return paid

    def _move(self, phases: Mapping[str, int]) -> None:
        for seconds, shown in ((YELLOW, "y"), (STEP - YELLOW, "r")):
            for agent, phase in phases.items():
                self.signals[agent].clear(phase, shown)
            libsumo.simulationStep(libsumo.simulation.getTime() + seconds)
        for agent, phase in phases.items():
            self.signals[agent].show(phase)

    def _means(self) -> dict[str, float]:
        """Ends the simulation, and returns means over its trips, as RESCO counts them."""
        self.close()
        trips = [trip.attrib for trip in ET.parse(self.trips).iter("tripinfo")]
        lost = [float(trip["timeLoss"]) + float(trip["departDelay"]) for trip in trips]
        stood = [float(trip["waitingTime"]) for trip in trips]
        means = {"delay": lost, "waiting": stood, "queue": self.queues}
        return {name: float(np.mean(numbers)) for name, numbers in means.items()}

    def close(self) -> None:
        """Ends the simulation, if one runs."""
        if libsumo.isLoaded():
            libsumo.close()


def network_file(network: str) -> str:
    """Where SUMO's configuration of a network lies. ValueError for a name that is none."""
    if network not in NETWORKS:
        raise ValueError(f"network is one of {', '.join(NETWORKS)}")
    spec = find_spec("sumo_rl")
    (folder,) = (spec and spec.submodule_search_locations) or [""]
    return str(Path(folder, "nets/RESCO", network, f"{network}.sumocfg"))


def make(network: str = "cologne3", seconds: int = 3600, own: int = 0, routes: str = "") -> Signals:
    """A network of RESCO's, as `maviper worlds check signals:make,network=cologne1` reads it."""
    return Signals(network, seconds, bool(own), routes)
