"""The judge's episodes: played in mpe2, and in numpy by the same text to find starts worth playing there.

Does: episodes from rest of a profile's own trees; whether one fulfils a claim about episodes, exactly; a start from
  which one does not, confirmed in mpe2.
Assumes: the three games, whose environments the profile's world names.
Does not: import anything of ours.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from functools import cache
from itertools import combinations, permutations
from typing import Any

import numpy as np

from tests.hunting.judge import Violation, within
from tests.hunting.places import Case, described, sampled
from tests.hunting.reading import MACHINE, Array, Profile, acting

COINCIDING = 1e-150  # so near the centres of two that push each other have no direction: no claim is about such starts
TRIED = 6  # starts that are played in mpe2
ROOM = 1e-9  # by which numpy's episodes may miss mpe2's where entities touch


@cache
def environment_of(reference: str, agents: int, landmarks: int, prey: int) -> Any:
    """mpe2's environment of a game, reset."""
    import mpe2

    name = reference.rpartition(".")[2]
    made = {
        "simple_adversary_v3": lambda: mpe2.simple_adversary_v3.parallel_env(N=agents - 1),
        "simple_spread_v3": lambda: mpe2.simple_spread_v3.parallel_env(N=agents),
        "simple_tag_v3": lambda: mpe2.simple_tag_v3.parallel_env(
            num_good=prey, num_adversaries=agents - prey, num_obstacles=landmarks
        ),
    }
    __import__(f"mpe2.{name}")
    env = made[name]()
    env.reset(seed=0)
    return env.aec_env.unwrapped


def environment(profile: Profile) -> Any:
    """The environment of a profile's world."""
    prey = sum(agent.team == "prey" for agent in profile.agents)
    return environment_of(profile.world["reference"], len(profile.movers), len(profile.landmarks), prey)


def played(profile: Profile, state: Mapping[str, float], goal: str | None, steps: int) -> dict[str, Array]:
    """An episode from rest in mpe2: coordinate -> [steps + 1, 1], with the actions taken, "agent!" -> [steps, 1]."""
    env = environment(profile)
    world = env.world
    names = [*profile.movers, *profile.landmarks]
    entities = dict(zip(names, world.agents + world.landmarks, strict=True))
    for name, entity in entities.items():
        entity.state.p_pos = np.array([state[f"{name}.x"], state[f"{name}.y"]])
        entity.state.p_vel = np.zeros(2)
    found: dict[str, list[Any]] = {}
    for step in range(steps + 1):
        at = _seen(entities, profile.movers, goal)
        for name, value in at.items():
            found.setdefault(name, []).append(value)
        if step < steps:
            chosen = acting(profile.agents, at, MACHINE)
            for agent in world.agents:
                name = next(name for name, entity in entities.items() if entity is agent)
                found.setdefault(f"{name}!", []).append(chosen[name])
                said = [] if agent.silent else [0]
                env._set_action([int(chosen[name][0]), *said], agent, None)
            with np.errstate(invalid="ignore", divide="ignore"):  # mpe2 computes NaN where centres coincide
                world.step()
    return {name: np.array(values) for name, values in found.items()}


def _seen(entities: Mapping[str, Any], movers: Sequence[str], goal: str | None) -> dict[str, Array]:
    at = {}
    for place, axis in enumerate("xy"):
        at |= {f"{name}.{axis}": entity.state.p_pos[place : place + 1].copy() for name, entity in entities.items()}
        at |= {f"{name}.v{axis}": entities[name].state.p_vel[place : place + 1].copy() for name in movers}
        at |= {f"goal.{axis}": at[f"{goal}.{axis}"]} if goal else {}
    return at


def simulated(
    profile: Profile, at: Mapping[str, Array], goal: str | None, steps: int, fixed: Mapping[str, int] | None = None
) -> dict[str, Array]:
    """Episodes from rest in numpy, [steps + 1, batch] each. `fixed`: agent -> the one action it takes instead."""
    names, movers, world = [*profile.movers, *profile.landmarks], profile.movers, profile.world
    place = np.array([[at[f"{name}.{axis}"] for axis in "xy"] for name in names])
    speed = np.zeros((len(movers), *place.shape[1:]))
    forces = {entity["name"]: entity["force"] for entity in world["agents"]}
    found: dict[str, list[Any]] = {}
    for step in range(steps + 1):
        now = {f"{name}.{axis}": place[k, j] for k, name in enumerate(names) for j, axis in enumerate("xy")}
        now |= {f"{name}.v{axis}": speed[k, j] for k, name in enumerate(movers) for j, axis in enumerate("xy")}
        now |= {f"goal.{axis}": now[f"{goal}.{axis}"] for axis in "xy"} if goal else {}
        for name, value in now.items():
            found.setdefault(name, []).append(value)
        if step < steps:
            chosen = acting(profile.agents, now, MACHINE)
            chosen |= {name: np.full(place.shape[2], action) for name, action in (fixed or {}).items()}
            push = np.array([profile.agent(name).effects[chosen[name]].T * forces[name] for name in movers])
            place, speed = _stepped(world, place, speed, push + _contacts(world, place)[: len(movers)])
    return {name: np.array(values) for name, values in found.items()}


def _stepped(world: Mapping[str, Any], place: Array, speed: Array, push: Array) -> tuple[Array, Array]:
    moved = place.copy()
    moved[: len(speed)] += speed * world["dt"]
    faster = speed * (1 - world["damping"]) + push * world["dt"]
    for number, entity in enumerate(world["agents"]):
        if entity["max_speed"] is not None:
            size = np.sqrt((faster[number] ** 2).sum(axis=0))
            fast = size > entity["max_speed"]
            faster[number][:, fast] = faster[number][:, fast] / size[fast] * entity["max_speed"]
    return moved, faster


def _contacts(world: Mapping[str, Any], place: Array) -> Array:
    found = np.zeros_like(place)
    entities = [*world["agents"], *world["landmarks"]]
    for (a, one), (b, other) in combinations(enumerate(entities), 2) if world["contact_force"] else ():
        if one["collides"] and other["collides"]:
            gap = place[a] - place[b]
            far, margin = np.sqrt((gap**2).sum(axis=0)), world["contact_margin"]
            with np.errstate(invalid="ignore", divide="ignore"):
                depth = np.logaddexp(0, -(far - one["size"] - other["size"]) / margin) * margin
                force = np.nan_to_num(world["contact_force"] * gap / far * depth)
            found[a] += force
            found[b] -= force
    return found


# --- what claims say of episodes


def marks(case: Case) -> list[str]:
    """From whom distances are measured."""
    if case.claim["name"] == "keeps_apart":
        return list(case.claim["others"]) or [agent.name for agent in case.team]
    return case.profile.landmarks


def fulfilled(case: Case, course: Mapping[str, Array], room: float = 0.0) -> Array:
    """Which episodes fulfil the claim, up to rounding. `room`: by how much distances must be better."""
    claim, radius = case.claim, float(case.claim["radius"])
    gaps = {(a.name, b): _gap(course, a.name, b) for a in case.team for b in marks(case) if a.name != b}
    if claim["name"] == "keeps_apart":
        return np.logical_and.reduce([(gap >= radius + room).all(axis=0) for gap in gaps.values()])
    counted = gaps if claim["name"] == "reaches" else {pair: gap[-1:] for pair, gap in gaps.items()}
    met = {pair: (gap <= radius - room).any(axis=0) for pair, gap in counted.items()}
    return np.logical_or.reduce([np.logical_and.reduce([met[pair] for pair in way]) for way in _ways(case)])


def _gap(course: Mapping[str, Array], a: str, b: str) -> Array:
    return np.maximum(*(np.abs(course[f"{a}.{axis}"] - course[f"{b}.{axis}"]) for axis in "xy"))


def _ways(case: Case) -> list[list[tuple[str, str]]]:
    team, own = [agent.name for agent in case.team], case.claim["landmarks"]
    ways = [own] if own else list(permutations(case.profile.landmarks, len(team)))
    return [list(zip(team, way, strict=True)) for way in ways]


def fails(case: Case, course: Mapping[str, Array]) -> bool:
    """Whether one episode, [steps + 1, 1] each, violates the claim: float64 positions, exact distances."""
    if not all(np.isfinite(values).all() for values in course.values()) or _coinciding(case.profile, course):
        return False
    claim = case.claim

    @cache
    def met(a: str, b: str) -> bool:
        rows = range(len(course[f"{a}.x"])) if claim["name"] != "covers" else [-1]
        gaps = [
            max(abs(Fraction(course[f"{a}.{x}"][t, 0]) - Fraction(course[f"{b}.{x}"][t, 0])) for x in "xy")
            for t in rows
        ]
        if claim["name"] == "keeps_apart":
            return all(gap >= claim["radius"] for gap in gaps)
        return any(gap <= claim["radius"] for gap in gaps)

    if claim["name"] == "keeps_apart":
        return not all(met(a.name, b) for a in case.team for b in marks(case) if a.name != b)
    return not any(all(met(*pair) for pair in way) for way in _ways(case))


def _coinciding(profile: Profile, course: Mapping[str, Array]) -> bool:
    world = profile.world
    if not world["contact_force"]:
        return False
    solid = [entity["name"] for entity in (*world["agents"], *world["landmarks"]) if entity["collides"]]
    return any((_gap(course, a, b) <= COINCIDING).any() for a, b in combinations(solid, 2))


def violates(case: Case, state: Mapping[str, Any], goal: str | None) -> bool:
    """Whether the episode from a start of the region, at rest, violates the claim in mpe2."""
    start = {name: state.get(name, 0.0) for name in case.names}
    if any(start[name] for name in case.names if name[-2] == "v") or not within(case, start, goal):
        return False
    return fails(case, played(case.profile, start, goal, case.claim["steps"]))


def look(case: Case, seed: int) -> tuple[Violation | None, bool]:
    """(a start that violates the claim, whether other actions would violate it from some start)."""
    rng, conflict, found = np.random.default_rng([seed, 1]), False, None
    team = [agent.name for agent in case.team]
    for goal in case.goals:
        states = sampled(case, goal, rng)
        states[:, [name[-2] == "v" for name in case.names]] = 0.0
        if not len(states):
            continue
        at, steps = case.at(states, goal), case.claim["steps"]
        if not conflict:
            conflict = any(
                not fulfilled(case, simulated(case.profile, at, goal, steps, dict.fromkeys(team, action))).all()
                for action in range(5)
            )
        course = simulated(case.profile, at, goal, steps)
        near = np.flatnonzero(~fulfilled(case, course, ROOM))
        clear = np.flatnonzero(~fulfilled(case, course))
        for row in [*clear[:TRIED], *rng.permutation(near)[:TRIED]] if found is None else []:
            state = described(states[row].tolist(), case.names)
            if violates(case, state, goal):
                found = Violation(state, goal, {})
                break
    return found, conflict
