"""SVG: a picture of each tree, whose elements also say what it decides.

Does: emits PREFIX_AGENT.svg for each agent: leaves side by side, splits above the middle of their parts.
Assumes: trees that are looked at; thousands of leaves make a wide picture.
Does not: need Graphviz.
"""

from dataclasses import dataclass

from codegen import ir
from codegen.errors import InputError
from codegen.lowering.model import Agent, Model, Node
from codegen.lowering.render import render
from codegen.wording import counted

LEAF_WIDTH, LEVEL_HEIGHT, MARGIN = 72, 62, 40
MAX_NODES = 4_096


@dataclass(frozen=True)
class Box:
    """A node and where it is drawn."""

    node: Node
    x: float
    y: float

    @property
    def width(self) -> int:
        """Of its frame."""
        return 124 if self.node.feature else 60

    @property
    def height(self) -> int:
        """Of its frame."""
        return 28 if self.node.feature else 24

    @property
    def left(self) -> float:
        """Of its frame."""
        return self.x - self.width // 2

    @property
    def top(self) -> float:
        """Of its frame."""
        return self.y - self.height // 2

    @property
    def lines(self) -> tuple[float, ...]:
        """The base lines of its texts."""
        return (self.y - 1, self.y + 11) if self.node.feature else (self.y + 4,)


@dataclass(frozen=True)
class Edge:
    """A line from a split to its child."""

    x0: float
    y0: float
    x1: float
    y1: float


@dataclass(frozen=True)
class Picture:
    """A tree, laid out."""

    title: str
    width: float
    height: float
    boxes: tuple[Box, ...]
    edges: tuple[Edge, ...]


def emit(model: Model, profile: ir.PolicyProfile) -> dict[str, str]:
    """The pictures."""
    return {
        f"{model.prefix}_{agent.lower}.svg": render("svg/tree.svg.j2", model=model, agent=agent, picture=picture(agent))
        for agent in model.agents
    }


def picture(agent: Agent) -> Picture:
    """Where each node goes. InputError for a tree that no page shows."""
    if len(agent.nodes) > MAX_NODES:
        what = f"the tree of {agent.name} has {counted(len(agent.nodes), 'node')}"
        raise InputError(what, "--target svg", f"a picture shows at most {MAX_NODES}: extract a smaller tree")
    level = [0] * len(agent.nodes)
    for node in agent.nodes:  # preorder: parents come first
        if node.feature:
            level[node.left] = level[node.right] = level[node.id] + 1
    leaves = [node.id for node in agent.nodes if node.action]
    x = {leaf: MARGIN + LEAF_WIDTH * (place + 0.5) for place, leaf in enumerate(leaves)}
    for node in reversed(agent.nodes):
        if node.feature:
            x[node.id] = (x[node.left] + x[node.right]) / 2
    boxes = [Box(node, round(x[node.id], 2), MARGIN + LEVEL_HEIGHT * level[node.id]) for node in agent.nodes]
    edges = [
        Edge(boxes[node.id].x, boxes[node.id].y, boxes[child].x, boxes[child].y)
        for node in agent.nodes
        if node.feature
        for child in (node.left, node.right)
    ]
    title = f"{agent.name}, team {agent.team}"
    width, height = 2 * MARGIN + LEAF_WIDTH * len(leaves), 2 * MARGIN + LEVEL_HEIGHT * max(level)
    return Picture(title, width, height, tuple(boxes), tuple(edges))
