"""A signal of a network in SUMO: its phases, its approaches, and the clocks that count its greens and reds.

Does: reads them from the simulation that runs, observes by them, shows phases and clearance.
Assumes: each state of the signal's own program that shows green and no yellow is a phase.
Does not: choose a phase, or let time pass.
"""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from math import atan2, ceil, pi
from typing import NamedTuple

import numpy as np
from libsumo import lane as lanes
from libsumo import trafficlight as lights

from maviper.profiles import FeatureSpec

STEP, CLOCK = 5, 240  # seconds: of a decision, and to which clocks count
NEAR, SPACE = 100.0, 5.0  # metres: how far an approach is seen at least, and what a standing vehicle takes at least
SIDES = ("east", "north_east", "north", "north_west", "west", "south_west", "south", "south_east")
Feeders = Mapping[str, Sequence[str]]  # lane -> the lanes that lead there


class Approach(NamedTuple):
    """Lanes of one road with green in the same phases, and near ones that lead there; `ahead`: where they lead to."""

    name: str
    lanes: Sequence[str]
    ahead: Sequence[str]
    phases: frozenset[int]


class Signal:
    """The signal `place`. `states`: what each phase shows to each link, in SUMO's letters."""

    def __init__(self, place: str, feeders: Feeders) -> None:
        self.place, (program, *_) = place, lights.getAllProgramLogics(place)
        shown = dict.fromkeys(phase.state for phase in program.phases)
        self.states = [state for state in shown if not {*"yu"} & {*state} and {*"Gg"} & {*state}]
        self.approaches = list(self._approaches(feeders))
        self.counts = {
            f"{each.name}_{kind}": (count, where, _room(where))
            for each in self.approaches
            for kind, count, where in (
                ("cars", lanes.getLastStepVehicleNumber, each.lanes),
                ("halting", lanes.getLastStepHaltingNumber, each.lanes),
                ("ahead", lanes.getLastStepVehicleNumber, each.ahead),
            )
        }
        self.features = list(self._features())
        self.start()

    def _approaches(self, feeders: Feeders) -> Iterator[Approach]:
        ahead, phases = defaultdict[str, set[str]](set), defaultdict[str, set[int]](set)
        for link, ways in enumerate(lights.getControlledLinks(self.place)):
            for lane, to, _ in ways:
                ahead[lane].add(to)
                phases[lane] |= {k for k, state in enumerate(self.states) if state[link] in "Gg"}
        roads, sides = defaultdict[tuple[str, frozenset[int]], list[str]](list), defaultdict[str, int](int)
        for lane in sorted(ahead):
            roads[lanes.getEdgeID(lane), frozenset(phases[lane])].append(lane)
        for (_, served), own in roads.items():
            side = _side(own[0])
            sides[side] += 1
            name = side if sides[side] == 1 else f"{side}_{sides[side]}"
            far = {each for lane in own if lanes.getLength(lane) < NEAR for each in feeders.get(lane, ())}
            yield Approach(name, sorted({*own, *far}), sorted({to for lane in own for to in ahead[lane]}), served)

    def _features(self) -> Iterator[FeatureSpec]:
        phases = range(len(self.states))
        yield from (FeatureSpec(f"on_{k}", "0 or 1", 0.0, 1.0, None) for k in phases)
        yield from (FeatureSpec(name, "s", 0.0, CLOCK, None) for name in ("green", *(f"red_{k}" for k in phases)))
        yield from (FeatureSpec(name, "vehicles", 0.0, room, None) for name, (*_, room) in self.counts.items())

    def start(self) -> None:
        """Sets phase 0, and all clocks to 0."""
        self.phase, self.green, self.red = 0, 0, [0] * len(self.states)

    def observe(self) -> np.ndarray:
        """The features, [n_features] of float32."""
        on = [k == self.phase for k in range(len(self.states))]
        counts = [min(sum(map(count, where)), room) for count, where, room in self.counts.values()]
        return np.array([*on, self.green, *self.red, *counts], np.float32)

    def standing(self) -> int:
        """How many vehicles stand before it."""
        watched = {lane for each in self.approaches for lane in each.lanes}
        return sum(map(lanes.getLastStepHaltingNumber, watched))

    def clear(self, phase: int, shown: str) -> None:
        """Shows `shown` to those who have green, and none in `phase`."""
        pairs = zip(self.states[self.phase], self.states[phase], strict=True)
        state = "".join(shown if old in "Gg" and new not in "Gg" else old for old, new in pairs)
        lights.setRedYellowGreenState(self.place, state)

    def show(self, phase: int) -> None:
        """Shows a phase at the end of a step, and moves the clocks."""
        self.green = min(self.green + STEP, CLOCK) if phase == self.phase else 0
        self.red = [0 if k == phase else min(red + STEP, CLOCK) for k, red in enumerate(self.red)]
        self.phase = phase
        lights.setRedYellowGreenState(self.place, self.states[phase])


def signals() -> dict[str, Signal]:
    """The signals of the simulation that runs, `signal_0` and so on in the order of their names in SUMO."""
    feeders = defaultdict[str, list[str]](list)
    for lane in lanes.getIDList():
        for link in lanes.getLinks(lane):
            feeders[link[0]].append(lane)
    return {f"signal_{k}": Signal(place, feeders) for k, place in enumerate(sorted(lights.getIDList()))}


def _room(where: Sequence[str]) -> float:
    """How many vehicles fit into lanes."""
    return float(sum(ceil(lanes.getLength(lane) / SPACE) for lane in where))


def _side(lane: str) -> str:
    """The point of the compass from which a lane leads to its signal."""
    (x, y), (to_x, to_y) = lanes.getShape(lane)[-2:]
    return SIDES[round(atan2(y - to_y, x - to_x) / (pi / 4)) % 8]
