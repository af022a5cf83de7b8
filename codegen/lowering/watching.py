"""The lowered monitor: what is asked of a state before a claim that is proved says something of it.

Does: joins a lowered profile, what a certificate proves, ranges, motion and fallbacks.
Assumes: a checked profile; for a region, world states with coordinates; a proof that was accepted.
Does not: write text (codegen/targets/rendered.py), or read a certificate.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, NamedTuple

import numpy as np

from codegen import ir
from codegen.check import identifier
from codegen.errors import InputError
from codegen.lowering.covering import LARGEST, Cover, Lookup, doubles_of, lookup
from codegen.lowering.lower import region_of
from codegen.lowering.model import Agent, Double, Model, Place, Region
from codegen.lowering.tracking import Edges, Start, Track, track
from codegen.numbers import decimal_literal
from codegen.world import RegionSpec

ROUNDED = 1.0 + 2.0**-20  # by which a speed at its limit may be above it: simulators round where they cut it
LATE = 1.5  # steps; inputs that are older, or checks that come later, are invalid
EARLY = 0.5  # steps; checks that come sooner are invalid, where a proof is about whole steps
WORD_BITS = 32
WORDS = ("OK", "LEAVING", "OUTSIDE", "INVALID")
NEVER, LAST = "never", "w is, and this is the last step of the proof"
OUTPUT = "; or an output is not finite, or out of its range"


@dataclass(frozen=True)
class Watched:
    """A number that must be measured, new, finite and within `low` and `high`."""

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

    @property
    def count(self) -> int:
        """The number of actions that are taken: those that also change memory are behind them."""
        return len(self.agent.actions) - (len(self.agent.machine.changes) if self.agent.machine else 0)


class Said(NamedTuple):
    """The texts that explain OK, LEAVING and OUTSIDE for a state w, and what is INVALID beside what always is."""

    inside: str
    leaving: str
    outside: str = "w is not: nothing is proved there"
    fault: str = ""


# What is asked of a state whose numbers are valid: these two, a Track or a Lookup, which templates know by their kind.


@dataclass(frozen=True)
class RegionCheck:
    """The check that a state is in the region of the model, and its positions are once they have moved."""

    kind: ClassVar = "region"
    count: ClassVar = "N_COORDINATES"  # the name of how many numbers a state has
    counted: ClassVar = False  # whether steps are counted since the start

    region: Region
    moved: tuple[Moved, ...]
    ahead: Model | None  # with what of the region moves; None: nothing does
    coasts: bool  # whether they move to where agents come to rest, and have to be in the region there

    @property
    def comparisons(self) -> int:
        """The most that it takes."""
        ahead = self.ahead.region.comparisons if self.ahead and self.ahead.region else 0
        return self.region.comparisons + ahead


@dataclass(frozen=True)
class InputCheck:
    """Nothing more of what agents observe, and of their outputs that each is within its bounds."""

    kind: ClassVar = "inputs"
    count: ClassVar = "N_INPUTS"
    counted: ClassVar = False

    outputs: int

    @property
    def comparisons(self) -> int:
        """The most that it takes."""
        return 2 * self.outputs


@dataclass(frozen=True)
class Watch:
    """A monitor, ready to be written."""

    model: Model  # of the profile; its region and the name of its check are the certificate's
    certificate: str  # content hash
    claim: str  # in words
    check: RegionCheck | Track | Lookup | InputCheck
    said: Said
    places: Mapping[str, Place]  # of all numbers of a state, by upper-case name
    watched: tuple[Watched, ...]  # first those that may be out of range inside
    open: int  # how many these are: all others are within narrower bounds inside
    fallbacks: tuple[Fallback, ...]
    step: float  # seconds
    paced: bool = False  # whether a step may come too soon

    @property
    def acts(self) -> tuple[Fallback, ...]:
        """The agents that take actions."""
        return tuple(each for each in self.fallbacks if not each.outputs)

    @property
    def gives(self) -> tuple[Fallback, ...]:
        """The agents that give numbers."""
        return tuple(each for each in self.fallbacks if each.outputs)

    @property
    def size(self) -> str:
        """The name in C of how many numbers a state has."""
        return f"{self.model.prefix.upper()}_{self.check.count}"

    @property
    def dt(self) -> str:
        """Seconds of a step."""
        return decimal_literal(self.step)

    @property
    def max_age(self) -> str:
        """Seconds after which a number is too old, and a step late."""
        return decimal_literal(LATE * self.step)

    @property
    def early(self) -> str:
        """Seconds before which a step comes too soon."""
        return decimal_literal(EARLY * self.step if self.paced else 0.0)

    @property
    def says(self) -> Mapping[str, str]:
        """The meanings of the words, for a state w."""
        said = self.said
        late = "the step came late or early" if self.paced else "the step came late"
        invalid = f"a number is missing, too old, not finite or out of its range, or {late}{said.fault}"
        return {"OK": said.inside, "LEAVING": said.leaving, "OUTSIDE": said.outside, "INVALID": invalid}

    @property
    def word_width(self) -> int:
        """The number of characters of the longest word in C: PREFIX_M_LEAVING."""
        return len(self.model.prefix.upper()) + len("_M_") + max(map(len, WORDS))

    @property
    def masks(self) -> tuple[str, ...]:
        """A bit for each number of a state, in words of 32, as C writes them."""
        whole = range(0, len(self.places), WORD_BITS)
        return tuple(f"{(1 << min(WORD_BITS, len(self.places) - at)) - 1:#x}UL" for at in whole)

    @property
    def guard(self) -> str:
        """Of the header of the monitor."""
        return f"{self.model.prefix.upper()}_MONITOR_{self.certificate[:16].upper()}_H"

    @property
    def comparisons(self) -> int:
        """The number of comparisons that one step makes at most."""
        return 2 + 3 * len(self.watched) + self.check.comparisons


def watch(
    profile: ir.PolicyProfile, model: Model, proved: RegionSpec | Edges | Start | Cover, certificate: str, claim: str
) -> Watch:
    """The monitor of a lowered profile for what a certificate with this content hash proves, of a `claim` in words.

    InputError where agents do not decide from world states, so that no state can be watched, for episodes that are not
    followed, for sets of too many boxes, and for variables that code cannot tell apart.
    """
    match proved:
        case Cover():
            return _watch_cover(profile, model, proved, certificate, claim)
        case Start():
            return _watch_start(profile, model, proved, certificate, claim)
        case Edges():
            made, time = _watch_region(profile, model, proved.region, certificate, claim), Double.of(proved.coasting)
            assert isinstance(made.check, RegionCheck)
            moved = tuple(replace(each, time=time) for each in made.check.moved)
            inside = "positions are within the edges of the proof, also where agents come to rest that nobody pushes"
            check = replace(made.check, moved=moved, coasts=True)
            return replace(made, check=check, said=Said(inside, NEVER), paced=True)
        case RegionSpec():
            return _watch_region(profile, model, proved, certificate, claim)


def _watch_region(profile: ir.PolicyProfile, model: Model, spec: RegionSpec, certificate: str, claim: str) -> Watch:
    """For single states of a game."""
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
    asked |= {each.velocity.upper for each in moved}
    places = [place for upper, place in model.places.items() if place.readers or upper in asked]
    own = replace(model, region=region, names=replace(model.names, in_region=f"{model.prefix}_monitor_within"))
    inside = "w is in the region of the proof, and so are the positions one step on"
    watched, open_ = _order_watched(_watch_places(profile.world, places), _collect_bounds(region))
    fallbacks = [Fallback(agent, _at_rest(policy)) for agent, policy in zip(model.agents, profile.agents, strict=True)]
    return Watch(
        model=own,
        certificate=certificate,
        claim=claim,
        check=RegionCheck(region, moved, _ahead(own, moved), coasts=False),
        said=Said(inside, "w is, but the positions one step on are not"),
        places=model.places,
        watched=watched,
        open=open_,
        fallbacks=tuple(fallbacks),
        step=profile.world.dt,
    )


def _watch_start(profile: ir.PolicyProfile, model: Model, start: Start, certificate: str, claim: str) -> Watch:
    """For episodes of a game, of which all coordinates are compared."""
    made = _watch_region(profile, model, start.region, certificate, claim)
    assert isinstance(made.check, RegionCheck)
    followed, region = track(profile, model, start), made.check.region
    watched, open_ = _order_watched(
        _watch_places(profile.world, model.places.values()), followed.bound_coordinates(_collect_bounds(region))
    )
    inside = "w is a start of the proof, or follows from the state before by the actions and the rules"
    if followed.noise:
        near = decimal_literal(followed.near)
        inside = f"w is within {near} of `last`, the state of an episode of the proof: decide from that"
    return replace(made, check=followed, said=Said(inside, LAST), watched=watched, open=open_, paced=True)


def _watch_places(world: ir.WorldSpec, places: Iterable[Place]) -> list[Watched]:
    """Coordinates, each with its range: speeds have limits where the world states them, other lengths the IR's."""
    ranges = dict.fromkeys(world.coordinates(), (-ir.MAX_LENGTH, ir.MAX_LENGTH))
    for agent in world.agents:
        if agent.max_speed is not None:
            limit = agent.max_speed * ROUNDED
            ranges |= {f"{agent.name}.v{axis}": (-limit, limit) for axis in "xy"}
    ranges |= {each.name: (each.low, each.high) for each in world.variables}
    return [Watched(place, *map(Double.of, ranges[place.name])) for place in places]


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


def _watch_cover(profile: ir.PolicyProfile, model: Model, cover: Cover, certificate: str, claim: str) -> Watch:
    """For states of a system that a file states."""
    places: dict[str, Place] = {}
    for at, one in enumerate(cover.variables):
        upper = identifier(one.name.replace(".", "_")).upper()
        if upper in places:
            what = f"the variables {places[upper].name} and {one.name} have one name in code"
            raise InputError(what, "--target monitor", "rename one of them in the world file")
        places[upper] = Place(at, one.name, upper, f"{model.prefix.upper()}_S_{upper}", ())
    ranges = zip(places.values(), cover.variables, strict=True)
    watched = [Watched(place, Double.of(one.low), Double.of(one.high)) for place, one in ranges]
    fallbacks: list[Fallback] = []
    for agent, policy in zip(model.agents, profile.agents, strict=True):
        rest = cover.rests.get(agent.name)
        action = next((at for at, each in enumerate(policy.actions) if each.name == rest), 0)
        fallbacks.append(replace(_make_fallback(agent, policy), action=action))
    inside = f"w is in a set of which the claim is proved, {'for ever' if cover.ever else 'until the last step'}"
    inside += ", with what is remembered before the decision" if model.remembers else ""
    bounds = {place.upper: cover.bounds(at) for at, place in enumerate(places.values())}
    watched, open_ = _order_watched(watched, bounds)
    found = lookup(cover.steps, f"certificate {certificate[:12]}")
    return Watch(
        model=model,
        certificate=certificate,
        claim=claim,
        check=replace(found, sums=cover.sums, ever=cover.ever),
        said=Said(inside, NEVER if cover.ever else LAST),
        places=places,
        watched=watched,
        open=open_,
        fallbacks=tuple(fallbacks),
        step=cover.dt,
        paced=cover.paced,
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
            ends = np.clip([float(feature.low_seen), float(feature.high_seen)], -LARGEST, LARGEST)
            watched.append(Watched(places[name], *doubles_of(ends)))
    fallbacks = tuple(_make_fallback(*both) for both in zip(model.agents, profile.agents, strict=True))
    check = InputCheck(sum(len(each.outputs) for each in fallbacks))
    said = Said("all observations are as they should be", NEVER, NEVER, OUTPUT)
    claim, step = "nothing: ranges, ages and finiteness are checked", profile.world.dt or 1.0
    return Watch(
        model=model,
        certificate="none",
        claim=claim,
        check=check,
        said=said,
        places=places,
        watched=tuple(watched),
        open=len(watched),
        fallbacks=fallbacks,
        step=step,
    )


def _make_fallback(agent: Agent, policy: ir.AgentPolicy) -> Fallback:
    """Returns what an agent falls back to: of outputs what is next to 0."""
    outputs: list[Given] = []
    for name, output in zip(agent.names.outputs, policy.outputs, strict=True):
        most = float(np.finfo(policy.tree.gives).max)
        low = -most if output.low is None else float(output.low)
        high = most if output.high is None else float(output.high)
        rest = min(max(0.0, low), high)
        outputs.append(Given(f"{name}_FALLBACK", Double.of(low), Double.of(high), Double.of(rest)))
    return Fallback(agent, 0 if outputs else _at_rest(policy), tuple(outputs))


def _at_rest(policy: ir.AgentPolicy) -> int:
    """The first action that pushes nobody, else the first."""
    return next((i for i, action in enumerate(policy.actions) if action.effect in (None, (0.0, 0.0))), 0)
