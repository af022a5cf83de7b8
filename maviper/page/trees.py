"""The trees of a profile as one SVG, with how often each leaf decides.

Does: lays trees out one below the other; widths of edges and numbers at leaves are shares of on-policy decisions.
Assumes: trees that are looked at (`codegen.targets.svg` refuses larger ones); visits are known for worlds of ours,
  or kept in the profile.
Does not: play.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from codegen import ir
from codegen.lowering.lower import lower
from codegen.lowering.model import Agent
from codegen.lowering.render import render
from codegen.targets.svg import Box, Edge, Picture, picture
from maviper.page.page import read_visits, visits_of
from maviper.worlds.matching import matching_world

GAP = 34  # above a tree, for its title
THINNEST, WIDEST = 1.0, 9.0  # of edges


@dataclass(frozen=True)
class Drawn:
    """A tree with its place: `top` of its picture, and of each edge and node the share of decisions, if known."""

    picture: Picture
    top: float
    edges: tuple[tuple[Edge, float], ...]  # with its width
    boxes: tuple[tuple[Box, float | None], ...]
    agent: Agent


def svg(profile: ir.PolicyProfile, agents: Sequence[str]) -> str:
    """The picture of these agents' trees. InputError for a tree that no page shows."""
    world = matching_world(profile)
    visits = read_visits(profile) if world is None else visits_of(profile, world)
    drawn = tuple(_stack_pictures(profile, agents, visits))
    width = max(one.picture.width for one in drawn)
    height = drawn[-1].top + drawn[-1].picture.height
    return render("svg/team.svg.j2", profile=profile.world.name, trees=drawn, width=width, height=height)


def _stack_pictures(
    profile: ir.PolicyProfile, agents: Sequence[str], visits: Mapping[str, Sequence[int]]
) -> Iterator[Drawn]:
    top = 0.0
    for agent in lower(profile).agents:
        if agent.name not in agents:
            continue
        drawing, shares = picture(agent), _shares(profile.policy(agent.name).tree, visits.get(agent.name))
        split = [box.node for box in drawing.boxes if box.split]
        children = [child for node in split for child in (node.left, node.right)]
        edges = [
            (edge, THINNEST + (WIDEST - THINNEST) * shares[child] if shares else THINNEST)
            for edge, child in zip(drawing.edges, children, strict=True)
        ]
        boxes = [(box, shares[box.node.id] if shares else None) for box in drawing.boxes]
        yield Drawn(drawing, top + GAP, tuple(edges), tuple(boxes), agent)
        top += GAP + drawing.height


def _shares(tree: ir.Tree, visits: Sequence[int] | None) -> list[float] | None:
    """The share of decisions that goes through each node. `visits`: of leaves, by node; None where they are unknown."""
    if visits is None or not sum(visits):
        return None
    counts = [float(count) for count in visits]
    for node in reversed(list(ir.splits(tree))):  # children come after their parents
        counts[node] = counts[tree.left[node]] + counts[tree.right[node]]
    return [count / counts[ir.ROOT] for count in counts]
