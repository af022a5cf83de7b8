"""The lowered monitor: what is asked of a state before a claim that is proved says something of it.

Does: joins a lowered profile, the region or cover of a certificate, ranges, motion and fallbacks.
Assumes: a checked profile; for a region, world states with coordinates; a proof that was accepted.
Does not: write text (codegen/targets/monitor.py), or read a certificate.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from codegen import ir
from codegen.check import identifier
from codegen.errors import InputError
from codegen.lowering.covering import Cover, Lookup, look_up
from codegen.lowering.lower import region_of
from codegen.lowering.model import Agent, Double, Model, Place, Region
from codegen.lowering.tracking import Edges, Start, Track, track
from codegen.numbers.literals import decimal_literal
from codegen.region import RegionSpec

ROUNDED = 1.0 + 2.0**-20  # by which a speed at its limit may be above it: simulators round where they cut it
LATE = 1.5  # steps; inputs that are older, or checks that come later, are invalid
EARLY = 0.5  # steps; checks that come sooner are invalid, where a proof is about whole steps
WORD_BITS = 32
WORDS = ("OK", "LEAVING", "OUTSIDE", "INVALID")


@dataclass(frozen=True)
class Watched:
    """A coordinate that must be measured, new, finite and within `low` and `high`."""

    place: Place
    low: Double
    high: Double


@dataclass(frozen=True)
class Moved:
    """A position of the region, and the velocity by which it moves until the next step, or for another time."""

    place: Place
    velocity: Place
    time: Double | None = None


@dataclass(frozen=True)
class Given:
    """An output: the least and most that it may be, and what is given where the monitor does not vouch for it."""

    constant: str  # its name in C: PREFIX_AGENT_Y_OUTPUT_FALLBACK
    low: Double
    high: Double
    rest: Double


@dataclass(frozen=True)
class Fallback:
    """An agent, and the action or outputs that it gives where the monitor does not vouch for its policy."""

    agent: Agent
    action: int
    outputs: tuple[Given, ...] = ()

    @property
    def constant(self) -> str:
        """Its name in C: PREFIX_AGENT_FALLBACK."""
        return f"{self.agent.names.act.removesuffix('act').upper()}FALLBACK"


@dataclass(frozen=True)
class Watch:
    """A monitor, ready to be written."""

    model: Model  # of the profile; its region and the name of its check are the certificate's
    guard: str  # of the header of the profile
    certificate: str  # content hash
    claim: str  # in words
    watched: tuple[Watched, ...]  # first those that may be out of range inside
    open: int  # how many these are: all others are within narrower bounds inside
    moved: tuple[Moved, ...]
    fallbacks: tuple[Fallback, ...]
    max_age: str  # seconds
    places: Mapping[str, Place]  # of all numbers of a state, by upper-case name
    size: str  # how many there are, in C
    dt: str  # seconds of a step
    ahead: Model | None = None  # with what of the region moves until the next step; None: nothing does, or a cover
    lookup: Lookup | None = None  # of a cover; None: of a region
    ever: bool = True  # whether what is proved holds at every step
    early: str = "0.0"  # seconds before which a step comes too soon
    track: Track | None = None  # of episodes from the region: `moved` and `ahead` are empty then
    coasts: bool = False  # whether positions are moved to where agents come to rest, and have to be in the region there
    inputs: bool = False  # whether observations are watched, of which nothing is proved

    @property
    def acts(self) -> tuple[Fallback, ...]:
        """The agents that take actions."""
        return tuple(each for each in self.fallbacks if not each.outputs)

    @property
    def gives(self) -> tuple[Fallback, ...]:
        """The agents that give numbers."""
        return tuple(each for each in self.fallbacks if each.outputs)

    @property
    def count(self) -> str:
        """How many numbers a state has, by the name of this in Python."""
        return "N_INPUTS" if self.inputs else "N_VARIABLES" if self.lookup else "N_COORDINATES"

    @property
    def says(self) -> Mapping[str, str]:
        """What the words OK, LEAVING, OUTSIDE and INVALID say of a state w."""
        invalid = "a number is missing, too old, not finite or out of its range, or the step came late"
        leaving = "w is, and this is the last step of the proof"
        if self.inputs:
            return {"OK": "all observations are as they should be", "LEAVING": "never", "OUTSIDE": "never"} | {
                "INVALID": f"{invalid}; or an output is not finite, or out of its range"
            }
        if self.track is not None and self.track.noise:
            near = decimal_literal(self.track.near)
            inside = f"w is within {near} of `last`, the state of an episode of the proof: decide from that"
        elif self.track is not None:
            inside = "w is a start of the proof, or follows from the state before by the actions and the rules"
        elif self.coasts:
            inside = "positions are within the edges of the proof, also where agents come to rest that nobody pushes"
            leaving = "never"
        elif self.lookup is None:
            inside = "w is in the region of the proof, and so are the positions one step on"
            leaving = "w is, but the positions one step on are not"
        else:
            inside = f"w is in a set of which the claim is proved, {'for ever' if self.ever else 'until the last step'}"
            leaving = "never" if self.ever else leaving
        invalid += "" if self.early == "0.0" else " or early"
        return {"OK": inside, "LEAVING": leaving, "OUTSIDE": "w is not: nothing is proved there", "INVALID": invalid}

    @property
    def word_width(self) -> int:
        """How many characters the longest of the words has in C: PREFIX_M_LEAVING."""
        return len(self.model.prefix.upper()) + len("_M_") + max(map(len, WORDS))

    @property
    def last(self) -> int:
        """The last step of a cover, from 0."""
        if self.track is not None:
            return self.track.steps
        return 0 if self.lookup is None else self.lookup.steps - 1

    @property
    def masks(self) -> tuple[str, ...]:
        """A bit for each number of a state, in words of 32, as C writes them."""
        whole = range(0, len(self.places), WORD_BITS)
        return tuple(f"{(1 << min(WORD_BITS, len(self.places) - at)) - 1:#x}UL" for at in whole)

    @property
    def counted(self) -> bool:
        """Whether steps are counted since the start."""
        return self.track is not None or (self.lookup is not None and not self.ever)

    @property
    def region(self) -> Region:
        """The region of the certificate."""
        assert self.model.region is not None
        return self.model.region

    @property
    def own_guard(self) -> str:
        """Of the header of the monitor."""
        return f"{self.model.prefix.upper()}_MONITOR_{self.certificate[:16].upper()}_H"

    @property
    def comparisons(self) -> int:
        """How many comparisons one step makes at most."""
        if self.inputs:
            return 2 + 3 * len(self.watched) + 2 * sum(len(each.outputs) for each in self.fallbacks)
        if self.lookup is not None:
            return 2 + 3 * len(self.watched) + self.lookup.comparisons
        if self.track is not None:
            both = 4 if self.track.noise else 16  # axes; also whether anything moves an agent along them
            moved = sum(both * (1 + len(each.pushes)) for each in self.track.agents) + 2 * len(self.track.still)
            begun = self.region.comparisons + 4 * len(self.track.agents)
            near = 2 * len(self.places) + 2 * len(self.region.bounds) + 4 * len(self.region.goals)
            return 2 + 3 * len(self.watched) + max(moved, begun) + (near if self.track.noise else 0)
        ahead = self.ahead.region.comparisons if self.ahead and self.ahead.region else 0
        return 2 + 3 * len(self.watched) + self.region.comparisons + ahead


def watch(profile: ir.PolicyProfile, model: Model, spec: RegionSpec, certificate: str, claim: str) -> Watch:
    """The monitor of a profile for the region of a certificate with this content hash, of a `claim` in words.

    InputError where agents do not decide from world states, so that no state can be watched.
    """
    if not model.located:
        what = "a monitor watches world states, and the features have no meanings"
        raise InputError(what, "--target monitor", "give each feature a meaning")
    region = region_of(spec)
    asked = {name for first, second, *_ in region.bounds for name in (first, second) if name}
    asked |= {f"{entity}_{axis}" for first, second, _ in region.apart for entity in (first, second) for axis in "XY"}
    asked |= {f"{entity}_{axis}" for entity in (*region.goals, *(["GOAL"] if region.goals else [])) for axis in "XY"}
    moved = tuple(
        Moved(place, model.places[name]) for upper, place in model.places.items()
        if upper in asked and (name := f"{upper[:-1]}V{upper[-1]}") in model.places
    )  # fmt: skip
    velocities = {each.velocity.upper for each in moved}
    ranges = _ranges(profile.world)
    watched = tuple(
        Watched(place, Double.of(ranges[place.name][0]), Double.of(ranges[place.name][1]))
        for upper, place in model.places.items()
        if place.readers or upper in asked or upper in velocities
    )
    fallbacks = [Fallback(agent, _at_rest(policy)) for agent, policy in zip(model.agents, profile.agents, strict=True)]
    names = replace(model.names, in_region=f"{model.prefix}_monitor_within")
    own = replace(model, region=region, names=names)
    age = decimal_literal(LATE * profile.world.dt)
    whole = model.places, model.names.n_coordinates, model.dt, _ahead(own, moved)
    watched, open_ = _order_watched(watched, _collect_bounds(region))
    return Watch(own, model.names.guard, certificate, claim, watched, open_, moved, tuple(fallbacks), age, *whole)


def watch_start(profile: ir.PolicyProfile, model: Model, start: Start, certificate: str, claim: str) -> Watch:
    """The monitor of a profile for episodes from the starts of a certificate. InputError as `watch` and `track`."""
    made = watch(profile, model, start.region, certificate, claim)
    ranges = _ranges(profile.world)
    watched = tuple(
        Watched(place, Double.of(ranges[place.name][0]), Double.of(ranges[place.name][1]))
        for place in model.places.values()
    )
    early = decimal_literal(EARLY * profile.world.dt)
    followed = track(profile, model, start)
    watched, open_ = _order_watched(watched, followed.bound_coordinates(_collect_bounds(made.region)))
    return replace(made, watched=watched, open=open_, moved=(), ahead=None, ever=False, early=early, track=followed)


def watch_edges(profile: ir.PolicyProfile, model: Model, edges: Edges, certificate: str, claim: str) -> Watch:
    """The monitor of a profile for edges that agents never cross. InputError as `watch`."""
    made, time = watch(profile, model, edges.region, certificate, claim), Double.of(edges.coasting)
    moved = tuple(replace(each, time=time) for each in made.moved)
    return replace(made, moved=moved, coasts=True, early=decimal_literal(EARLY * profile.world.dt))


def _order_watched(
    watched: Sequence[Watched], inside: Mapping[str, tuple[float, float]]
) -> tuple[tuple[Watched, ...], int]:
    """Those first that may be out of their range where a state is within these bounds, and how many there are."""

    def is_held(one: Watched) -> bool:
        low, high = inside.get(one.place.upper, (-math.inf, math.inf))
        return float(one.low.decimal) <= low and high <= float(one.high.decimal)

    open_ = [one for one in watched if not is_held(one)]
    return (*open_, *(one for one in watched if is_held(one))), len(open_)


def _collect_bounds(region: Region) -> dict[str, tuple[float, float]]:
    """The coordinates that a region bounds by numbers; a goal is where its landmarks are."""
    bounds = {
        first: (float(low.decimal), float(high.decimal)) for first, second, low, high in region.bounds if not second
    }
    for axis in "XY":
        marks = [bounds.get(f"{goal}_{axis}") for goal in region.goals]
        known = [mark for mark in marks if mark is not None]
        if known and len(known) == len(marks):
            bounds[f"GOAL_{axis}"] = min(low for low, _ in known), max(high for _, high in known)
    return bounds


def _ahead(model: Model, moved: Sequence[Moved]) -> Model | None:
    """A model whose region is what of a region may fail once positions have moved, where it held before."""
    names, region = {each.place.upper for each in moved}, model.region
    if region is None or not names:
        return None
    bounds = tuple(bound for bound in region.bounds if {bound[0], bound[1]} & names)
    apart = tuple(pair for pair in region.apart if {f"{one}_{axis}" for one in pair[:2] for axis in "XY"} & names)
    moving = {f"{one}_{axis}" for one in (*region.goals, "GOAL") for axis in "XY"} & names
    part = Region(bounds, apart, region.goals if moving else ())
    return replace(model, region=part, names=replace(model.names, in_region=f"{model.prefix}_monitor_ahead"))


def watch_cover(profile: ir.PolicyProfile, model: Model, cover: Cover, certificate: str, claim: str) -> Watch:
    """The monitor of a lowered profile for what a certificate about a stated system proves.

    InputError for sets of too many boxes, and for variables that code cannot tell apart.
    """
    places: dict[str, Place] = {}
    for at, one in enumerate(cover.variables):
        upper = identifier(one.name.replace(".", "_")).upper()
        if upper in places:
            what = f"the variables {places[upper].name} and {one.name} have one name in code"
            raise InputError(what, "--target monitor", "rename one of them in the world file")
        places[upper] = Place(at, one.name, upper, f"{model.prefix.upper()}_S_{upper}", ())
    ranges = zip(places.values(), cover.variables, strict=True)
    watched = tuple(Watched(place, Double.of(one.low), Double.of(one.high)) for place, one in ranges)
    watched, open_ = _order_watched(
        watched, {place.upper: cover.bounds(at) for at, place in enumerate(places.values())}
    )
    fallbacks = [
        replace(_make_fallback(agent, policy), action=_place_action(policy, cover.rests.get(agent.name)))
        for agent, policy in zip(model.agents, profile.agents, strict=True)
    ]
    return Watch(
        model=model,
        guard=model.names.guard,
        certificate=certificate,
        claim=claim,
        watched=watched,
        open=open_,
        moved=(),
        fallbacks=tuple(fallbacks),
        max_age=decimal_literal(LATE * cover.dt),
        places=places,
        size=f"{model.prefix.upper()}_N_VARIABLES",
        dt=decimal_literal(cover.dt),
        lookup=look_up(cover, f"certificate {certificate[:12]}"),
        ever=cover.ever,
        early=decimal_literal(EARLY * cover.dt if cover.paced else 0.0),
    )


def watch_inputs(profile: ir.PolicyProfile, model: Model) -> Watch:
    """The monitor of a profile for what it states itself: the ranges of what agents observe and of what they give. All
    observations are one state, agent by agent. Where the world states no time, a step is 1.
    """
    upper, places, watched = model.prefix.upper(), dict[str, Place](), list[Watched]()
    for agent in model.agents:
        for feature in agent.features:
            name = f"{agent.lower.upper()}_{feature.upper}"
            places[name] = Place(len(places), f"{agent.name}: {feature.name}", name, f"{upper}_I_{name}", ())
            ends = (Double.of(_finite(float(end))) for end in (feature.low_seen, feature.high_seen))
            watched.append(Watched(places[name], *ends))
    dt = profile.world.dt or 1.0
    claim = "nothing: ranges, ages and finiteness are checked"
    return Watch(
        model=model,
        guard=model.names.guard,
        certificate="none",
        claim=claim,
        watched=tuple(watched),
        open=len(watched),
        moved=(),
        fallbacks=tuple(_make_fallback(*both) for both in zip(model.agents, profile.agents, strict=True)),
        max_age=decimal_literal(LATE * dt),
        places=places,
        size=f"{upper}_N_INPUTS",
        dt=decimal_literal(dt),
        inputs=True,
    )


def _make_fallback(agent: Agent, policy: ir.AgentPolicy) -> Fallback:
    """What an agent falls back to: of outputs what is next to 0."""
    outputs: list[Given] = []
    for name, output in zip(agent.names.outputs, policy.outputs, strict=True):
        most = float(np.finfo(policy.tree.gives).max)
        low = -most if output.low is None else float(output.low)
        high = most if output.high is None else float(output.high)
        rest = min(max(0.0, low), high)
        outputs.append(Given(f"{name}_FALLBACK", Double.of(low), Double.of(high), Double.of(rest)))
    return Fallback(agent, 0 if outputs else _at_rest(policy), tuple(outputs))


def _place_action(policy: ir.AgentPolicy, name: str | None) -> int:
    """The place of an action among those of a profile; the first one where it has none of this name."""
    return next((at for at, action in enumerate(policy.actions) if action.name == name), 0)


def _finite(value: float) -> float:
    """The nearest finite number."""
    most = float(np.finfo(np.float64).max)
    return min(max(value, -most), most)


def _ranges(world: ir.WorldSpec) -> dict[str, tuple[float, float]]:
    """What each coordinate can be: speeds have limits where the world states them, other lengths the IR's."""
    ranges = dict.fromkeys(world.coordinates(), (-ir.MAX_LENGTH, ir.MAX_LENGTH))
    for agent in world.agents:
        if agent.max_speed is not None:
            limit = agent.max_speed * ROUNDED
            ranges |= {f"{agent.name}.v{axis}": (-limit, limit) for axis in "xy"}
    return ranges | {each.name: (each.low, each.high) for each in world.variables}


def _at_rest(policy: ir.AgentPolicy) -> int:
    """The first action that pushes nobody, else the first."""
    return next((i for i, action in enumerate(policy.actions) if action.effect in (None, (0.0, 0.0))), 0)
