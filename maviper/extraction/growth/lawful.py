"""Trees that only take legal actions, whatever the mask that they observe.

Does: tests the mask before a leaf's action, where the path to the leaf has not made sure that the action is legal; then
  comes the action that most labels there name, and the last one needs no test.
Assumes: features of a mask are 0 or 1; in every state in which an agent acts some action is legal, and labels are.
Does not: grow trees, or choose what is tested above the leaves.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from codegen.ir import NO_ACTION, NO_CHILD, NO_FEATURE, ROOT, Float32, GrownTree
from codegen.legality import LEGAL, Mask
from maviper.worlds.world import Int

Legal = Mapping[int, bool]  # of some actions, whether they are legal


@dataclass(frozen=True)
class Labelled:
    """The points that one agent's second choices are learned from."""

    observations: Float32  # [n, n_features]
    labels: Int  # [n]


def lawful(tree: GrownTree, mask: Mask, known: Labelled) -> GrownTree:
    """The tree with the tests of the mask that it needs: it decides as before wherever its own action is legal."""
    completion = _Completion(tree, mask, known)
    always = {action: True for action, place in enumerate(mask) if place is None}
    completion.below(ROOT, np.arange(len(known.labels)), always)
    return GrownTree(*(np.array(column) for column in zip(*completion.rows, strict=True)))


class _Completion:
    """A tree while it is written anew, node by node. Each method returns where in `rows` its part begins."""

    def __init__(self, tree: GrownTree, mask: Mask, known: Labelled) -> None:
        self.tree, self.mask, self.known = tree, mask, known
        self.rows: list[tuple[int, float, int, int, int]] = []
        self.asked = {place: action for action, place in enumerate(mask) if place is not None}
        self.usual = np.bincount(known.labels, minlength=len(mask))

    def below(self, node: int, here: Int, legal: Legal) -> int:
        """The part of the tree from a node on. `here`: the points that reach it."""
        tree, feature = self.tree, int(self.tree.feature[node])
        if feature == NO_FEATURE:
            return self._choice(int(tree.action[node]), here, legal)
        left, right, threshold = int(tree.left[node]), int(tree.right[node]), float(tree.threshold[node])
        action = self.asked.get(feature)
        if action is None:
            sides = self._split_points(here, feature, threshold)
            return self._split(feature, threshold, ((left, sides[0], legal), (right, sides[1], legal)))
        if not 0 <= threshold < 1 or action in legal:  # decided before it is asked
            goes_left = threshold >= 1 or (threshold >= 0 and not legal[action])
            return self.below(left if goes_left else right, here, legal)
        sides = self._split_points(here, feature, LEGAL)  # one threshold says what any other in [0, 1) does
        known = ({**legal, action: False}, {**legal, action: True})
        return self._split(feature, LEGAL, ((left, sides[0], known[0]), (right, sides[1], known[1])))

    def _split(self, feature: int, threshold: float, sides: Sequence[tuple[int, Int, Legal]]) -> int:
        place = self._leaf(NO_ACTION)
        left, right = (self.below(*side) for side in sides)
        self.rows[place] = (feature, threshold, left, right, NO_ACTION)
        return place

    def _choice(self, action: int, here: Int, legal: Legal) -> int:
        """An action where it is legal, else the others in their order."""
        others = [other for other in range(len(self.mask)) if other != action and legal.get(other, True)]
        if legal.get(action) or not others:  # also where the path says that none is legal: nobody gets there
            return self._leaf(action)
        if not legal.get(action, True):
            return self._choice(self._best(others, here), here, legal)
        feature = self.mask[action]
        assert feature is not None
        place, illegal = self._leaf(NO_ACTION), self._split_points(here, feature, LEGAL)[0]
        left = self._choice(self._best(others, illegal), illegal, {**legal, action: False})
        self.rows[place] = (feature, LEGAL, left, self._leaf(action), NO_ACTION)
        return place

    def _best(self, actions: Sequence[int], here: Int) -> int:
        """The action that most of some points are labelled with, of equals the one that most of all points are."""
        counts = np.bincount(self.known.labels[here], minlength=len(self.mask))
        return max(actions, key=lambda action: (counts[action], self.usual[action], -action))

    def _split_points(self, here: Int, feature: int, threshold: float) -> tuple[Int, Int]:
        # float32 against float64, as scikit-learn compares
        goes_left = self.known.observations[here, feature] <= np.float64(threshold)
        return here[goes_left], here[~goes_left]

    def _leaf(self, action: int) -> int:
        self.rows.append((NO_FEATURE, 0.0, NO_CHILD, NO_CHILD, action))
        return len(self.rows) - 1
