"""Which actions a tree may take where an agent observes what is legal: an action mask.

Does: finds the feature that says whether an action is legal; the leaves that may take an illegal one.
Assumes: sound trees; in every observation at least one action is legal.
Does not: change a tree (maviper's extraction does).
"""

from collections.abc import Iterator, Sequence
from typing import Final, TypeAlias

from codegen.ir import NO_FEATURE, ROOT, ActionSpec, FeatureSpec, Tree
from codegen.paths import EVERYTHING, Box

LEGAL: Final = 0.5  # a mask's feature is above it where its action is legal
Mask: TypeAlias = tuple[int | None, ...]  # per action: the feature that says whether it is legal; None: it always is


def mask_of(features: Sequence[FeatureSpec], actions: Sequence[ActionSpec]) -> Mask | None:
    """The mask of an agent's actions; None where all are always legal, or a mask names a feature that is not there."""
    places = {feature.name: place for place, feature in enumerate(features)}
    if not all(action.legal_if in places for action in actions if action.legal_if):
        return None
    mask = tuple(places[action.legal_if] if action.legal_if else None for action in actions)
    return mask if any(place is not None for place in mask) else None


def illegal_leaves(tree: Tree, mask: Mask) -> Iterator[int]:
    """The leaves that some observation reaches in which their action is illegal although another one is legal."""
    stack: list[tuple[int, Box]] = [(ROOT, EVERYTHING)]
    while stack:
        node, box = stack.pop()
        if tree.feature[node] == NO_FEATURE:
            if not _lawful(box, mask, int(tree.action[node])):
                yield node
            continue
        sides = box.split_at(int(tree.feature[node]), float(tree.threshold[node]))
        for child, side in zip((tree.right[node], tree.left[node]), reversed(sides), strict=True):
            if side is not None:
                stack.append((int(child), side))


def _lawful(box: Box, mask: Mask, action: int) -> bool:
    own = mask[action]
    if own is None or box.low.get(own, LEGAL - 1) >= LEGAL:
        return True
    others = [place for place in mask if place != own]  # what has the same feature is illegal with it
    return all(place is not None and box.high.get(place, LEGAL + 1) <= LEGAL for place in others)
