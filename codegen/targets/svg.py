"""SVG: a picture of each tree, whose elements also say what it decides.

Does: emits PREFIX_AGENT.svg for each agent: leaves side by side, splits above the middle of their parts.
Assumes: trees that are looked at; thousands of leaves make a wide picture.
Does not: need Graphviz.
"""

import math
from dataclasses import dataclass

from codegen import ir
from codegen.errors import InputError
from codegen.lowering.model import Agent, Model, Node, SumNode
from codegen.lowering.render import render
from codegen.wording import format_count

LEAF_WIDTH, LEVEL_HEIGHT, MARGIN = 72, 62, 40
MAX_NODES = 4_096
GIVING_WIDTH, ROW_HEIGHT, BAR_WIDTH = 168, 22, 132  # of leaves that give numbers
CLEAR = 8  # beside the outermost frames
CHARACTER, MAX_CHARACTERS = 6.9, 24  # the width of one, about, and how many a frame has at most


@dataclass(frozen=True)
class Row:
    """A number that a leaf gives: its text, and the share of a bar where it is a number within bounds."""

    text: str
    y: float  # the text's base line
    bar: tuple[float, float] | None  # the bar's left end and how far it reaches

    @property
    def bar_y(self) -> float:
        """The top of its bar."""
        return self.y + 3


@dataclass(frozen=True)
class Box:
    """A node and where it is drawn."""

    node: Node | SumNode
    x: float
    y: float
    width: int
    height: int
    split: bool
    words: str  # what it tests, or the action that it takes
    test: str
    rows: tuple[Row, ...] = ()

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
        return (self.y - 1, self.y + 11) if self.split else (self.y + 4,)

    @property
    def share_dy(self) -> int:
        """The distance from a leaf's middle down to its share: under its frame."""
        return self.height // 2 + 12


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
    return {f"{model.prefix}_{agent.lower}.svg": _draw_tree(model, agent) for agent in model.agents}


def _draw_tree(model: Model, agent: Agent) -> str:
    return render("svg/tree.svg.j2", model=model, agent=agent, picture=picture(agent))


def picture(agent: Agent) -> Picture:
    """Where each node goes. InputError for a tree that no page shows."""
    nodes = agent.tree
    if len(nodes) > MAX_NODES:
        what = f"the tree of {agent.name} has {format_count(len(nodes), 'node')}"
        raise InputError(what, "--target svg", f"a picture shows at most {MAX_NODES}: extract a smaller tree")
    level = [0] * len(nodes)
    for node in nodes:  # preorder: parents come first
        if node.split:
            level[node.left] = level[node.right] = level[node.id] + 1
    leaves = [node.id for node in nodes if not node.split]
    rows = max(len(node.given) for node in nodes)
    wide, tall = (GIVING_WIDTH, LEVEL_HEIGHT + ROW_HEIGHT * (rows - 1)) if rows else (LEAF_WIDTH, LEVEL_HEIGHT)
    x = {leaf: MARGIN + wide * (place + 0.5) for place, leaf in enumerate(leaves)}
    for node in reversed(nodes):
        if node.split:
            x[node.id] = (x[node.left] + x[node.right]) / 2
    boxes = [_box(node, round(x[node.id], 2), MARGIN + tall * level[node.id]) for node in nodes]
    beyond = max(0.0, *(CLEAR - box.left for box in boxes))  # wide frames over few leaves
    if beyond:
        boxes = [_box(box.node, box.x + beyond, box.y) for box in boxes]
    edges = [
        Edge(boxes[node.id].x, boxes[node.id].y, boxes[child].x, boxes[child].y)
        for node in nodes
        if node.split
        for child in (node.left, node.right)
    ]
    title = f"{agent.name}, team {agent.team}"
    width, height = 2 * MARGIN + wide * len(leaves), 2 * MARGIN + tall * max(level) + ROW_HEIGHT * max(0, rows - 1)
    width = max(width, *(math.ceil(box.left + box.width) + CLEAR for box in boxes))
    return Picture(title, width, height, tuple(boxes), tuple(edges))


def _box(node: Node | SumNode, x: float, y: float) -> Box:
    """The frame of a node and what stands in it."""
    if node.split:
        plain = isinstance(node, Node)  # a feature's name may stick out of its frame, a sum is cut
        words = node.tested if plain else shorten_text(node.tested)
        width = 0 if plain else round(CHARACTER * len(words)) + 12
        return Box(node, x, y, max(124, width), 28, True, words, node.test)
    if node.action:
        return Box(node, x, y, 60, 24, False, node.action.name, "")
    height = ROW_HEIGHT * len(node.given) + 6
    words, rows = [f"{each.output.name} = {each.shown}" for each in node.given], list[Row]()
    for place, (each, text) in enumerate(zip(node.given, words, strict=True)):
        bar = None if each.share is None else (x - BAR_WIDTH // 2, round(BAR_WIDTH * each.share, 2))
        rows.append(Row(shorten_text(text), y - height // 2 + ROW_HEIGHT * place + 14, bar))
    return Box(node, x, y, GIVING_WIDTH - 12, height, False, ", ".join(words), "", tuple(rows))


def shorten_text(text: str) -> str:
    """A text that fits into a frame; its title says the whole."""
    return text if len(text) <= MAX_CHARACTERS else text[: MAX_CHARACTERS - 1] + "…"
