"""Particle games without contacts as world files.

Does: the text of the file that states a profile's game for one goal, with a start region.
Assumes: nothing pushes anything and no speed is limited; otherwise the game is refused.
Does not: decide. What float64 arithmetic rounds in a game is no part of the statement.
"""

from collections.abc import Iterator
from fractions import Fraction

from codegen.errors import InputError
from codegen.ir import GOAL, AgentPolicy, EntitySpec, FeatureSpec, PolicyProfile, WorldSpec
from verify.claims.region import Region
from verify.decimals import plain

MEASURES = {"": "{}", "sign": "sign({})", "positive": "positive({})"}
FAR = 100  # of places and speeds: more than any episode reaches


def world_file(profile: PolicyProfile, region: Region, goal: str | None) -> str:
    """The file of a profile's game, whose episodes start at rest in a region. InputError for a game with contacts or
    speed limits, and for a region that is no convex set.
    """
    world = profile.world
    if world.contact_force and sum(entity.collides for entity in world.agents + world.landmarks) > 1:
        raise InputError("a game with contacts is no piecewise affine system", world.name, "ask without --world")
    if any(agent.max_speed is not None for agent in world.agents):
        raise InputError("a speed limit along a circle is not affine", world.name, "ask without --world")
    if region.apart:
        raise InputError("a region that keeps entities apart is not convex", region.name, "leave apart out")
    lines = [f'name = "{world.name}"', f"steps = {world.episode_steps}", f'dt = "{_exact(world.dt)} s"', ""]
    lines += ["[variables]"]
    for name in _variables(world):
        unit = "length/s" if name.rpartition(".")[2].startswith("v") else "length"
        lines.append(f'{name} = {{ unit = "{unit}", range = [-{FAR}, {FAR}] }}')
    for policy in profile.agents:
        lines += ["", *_agent(policy, world, goal)]
    lines += ["", *_start(world, region), "", "[dynamics.next]", *_motion(world)]
    return "\n".join(lines) + "\n"


def _exact(number: float) -> str:
    """The decimal that Python prints, which is what the game's author wrote."""
    return plain(Fraction(repr(number)))


def _variables(world: WorldSpec) -> Iterator[str]:
    for entity in world.agents + world.landmarks:
        yield from (f"{entity.name}.{axis}" for axis in "xy")
    for agent in world.agents:
        yield from (f"{agent.name}.v{axis}" for axis in "xy")


def _agent(policy: AgentPolicy, world: WorldSpec, goal: str | None) -> list[str]:
    entity = next(each for each in world.agents if each.name == policy.agent)
    lines = [f"[agents.{policy.agent}]", f'team = "{policy.team}"', "", f"[agents.{policy.agent}.features]"]
    lines += [f'{feature.name} = "{_feature(feature, goal)}"' for feature in policy.features]
    lines += ["", f"[agents.{policy.agent}.actions]"]
    for action in policy.actions:
        lines.append(f"{action.name} = {{ {_push(entity, action.effect)} }}")
    return lines


def _feature(feature: FeatureSpec, goal: str | None) -> str:
    meaning = feature.meaning
    if meaning is None or meaning.function not in MEASURES:
        what = f"the feature {feature.name} is no affine form, nor a sign of one"
        raise InputError(what, "", "a world file cannot state it")
    named = ((weight, _of_goal(name, goal)) for weight, name in meaning.terms)
    terms = " + ".join(f"{plain(Fraction(weight))}*{name}" for weight, name in named)
    return MEASURES[meaning.function].format(terms or "0")


def _of_goal(name: str, goal: str | None) -> str:
    entity, _, axis = name.rpartition(".")
    return f"{goal}.{axis}" if entity == GOAL else name


def _push(entity: EntitySpec, effect: tuple[float, float] | None) -> str:
    pushes = zip("xy", effect or (0.0, 0.0), strict=True)
    return ", ".join(
        f'a{axis} = "{plain(Fraction(repr(entity.force)) * Fraction(repr(push)))} length/s^2"' for axis, push in pushes
    )


def _start(world: WorldSpec, region: Region) -> list[str]:
    lines = ["[start]", "[start.box]"]
    for name in _variables(world):
        low, high = region.box.get(name, (Fraction(0), Fraction(0)))
        low, high = (Fraction(0), Fraction(0)) if name.rpartition(".")[2].startswith("v") else (low, high)
        lines.append(f'{name} = ["{plain(low)}", "{plain(high)}"]')
    said = [f'"{plain(low)} <= {a} - {b}", "{a} - {b} <= {plain(high)}"' for a, b, (low, high) in region.differences]
    return [lines[0], f"where = [{', '.join(said)}]", *lines[1:]]


def _motion(world: WorldSpec) -> Iterator[str]:
    kept = plain(1 - Fraction(repr(world.damping)))
    for agent in world.agents:
        for axis in "xy":
            place, speed = f"{agent.name}.{axis}", f"{agent.name}.v{axis}"
            yield f'{place} = "{place} + dt*{speed}"'
            yield f'{speed} = "{kept}*{speed} + dt*{agent.name}.a{axis}"'
    for mark in world.landmarks:
        yield from (f'{mark.name}.{axis} = "{mark.name}.{axis}"' for axis in "xy")
