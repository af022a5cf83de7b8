"""The checker of proofs about single decisions: adds exact numbers along the cycles of bounds that a proof names.

Does: walks the search that README.md specifies and closes each of its branches again; counts them.
Assumes: the modules of the trusted base that README.md lists.
Does not: search for cycles, or import an engine.
"""

from collections.abc import Callable, Iterator, Sequence
from functools import cache, partial
from typing import TypeAlias

from codegen.ir import ROOT, PolicyProfile
from verify.checker.reading import (
    LONGEST,
    Bounds,
    Choice,
    Edge,
    Flat,
    Known,
    Reading,
    RejectedError,
    SearchTree,
    region_formula,
)
from verify.claims.formula import Formula, agents
from verify.claims.region import Region
from verify.semantics import Semantics

UNKNOWN: Known = None, 0  # no action, and no part of the claim is known to hold
DENIED = -1  # in place of a tree's number: the denied claim was added, so no tree is left


# Where the search stands: a tree, its node, and what is known of each agent. Agents before the tree's are at leaves,
# those after it at their roots.
Place: TypeAlias = tuple[int, int, tuple[Known, ...]]
# A branch that must be closed: how many bounds of the path it keeps, what it adds to them, the choices that are still
# to be made, the parts that were chosen, and its place.
Branch: TypeAlias = tuple[int, Bounds, tuple[Choice, ...], tuple[Bounds, ...], Place]


def check(
    profile: PolicyProfile, claim: Formula, region: Region, goal: str | None, semantics: Semantics, proof: Iterator[int]
) -> int:
    """The number of branches closed; RejectedError when `proof` does not show the claim for this goal."""
    return check_all(profile, (claim,), region, goal, semantics, proof)


def check_all(
    profile: PolicyProfile,
    claims: Sequence[Formula],
    region: Region,
    goal: str | None,
    semantics: Semantics,
    proof: Iterator[int],
) -> int:
    """Checks several claims that must all hold, see `check`: `proof` is that of each, one after the other."""
    closed = sum(_check_claim(profile, claim, region, goal, semantics, proof) for claim in claims)
    if next(proof, None) is not None:
        raise RejectedError("the proof continues after its last branch")
    return closed


def _check_claim(
    profile: PolicyProfile, claim: Formula, region: Region, goal: str | None, semantics: Semantics, proof: Iterator[int]
) -> int:
    """The number of branches that the beginning of `proof` closes, which is the claim's own proof."""
    team = [policy for policy in profile.agents if policy.agent in agents(claim)]
    reading = Reading([policy.agent for policy in team], goal)
    start = reading.flat(region_formula(region), True)
    denied = cache(partial(reading.flat, claim, False))
    denied((UNKNOWN,) * len(team))  # numbers the claim's bounds and parts
    trees = [reading.tree(policy, semantics) for policy in team]
    edges, known, closed = reading.edges(), list[list[Known]](), 0
    try:
        for agent, tree in enumerate(trees):
            lemmas = Lemmas(reading, agent, tree, next(proof))
            if lemmas.claimed:
                closed += lemmas.close(start, edges, proof)
            known.append(lemmas.find_known())
        closed += Denial(denied, trees, known).close(start, edges, proof)
    except (StopIteration, IndexError):
        raise RejectedError("the proof ends early, or names a bound that its branch does not have") from None
    return closed


class DecisionWalk:
    """A walk through trees, one after the other, in which the proof closes every branch."""

    def __init__(self, trees: Sequence[SearchTree], known: Sequence[Sequence[Known]]) -> None:
        self.trees, self.known = trees, known

    def ends(self, leaf: int, known: tuple[Known, ...], proof: Iterator[int]) -> list[Flat]:
        """Returns the conditions that must be impossible when all agents are at leaves; `leaf` is the last agent's."""
        raise NotImplementedError

    def is_settled(self, place: Place) -> bool:
        """Returns True if a place needs no proof, because nothing that follows it can deny the claim."""
        return False

    def close(self, start: Flat, edges: Sequence[Edge], proof: Iterator[int]) -> int:
        """Closes every branch that begins with `start`; the number of branches."""
        closed, path = 0, list[int]()  # the numbers of the bounds of the branch at hand
        root = 0, ROOT, tuple(known[ROOT] for known in self.known)
        branches: list[Branch] = [] if start is None else [(0, start, (), (), root)]
        while branches:
            kept, (added, more), choices, chosen, place = branches.pop()
            path[kept:] = added
            if self.is_settled(place):
                closed += 1
            elif length := next(proof):
                cycle = [edges[path[next(proof)]] for _ in range(length)]
                if not negative(cycle):
                    raise RejectedError(f"the bounds of branch {closed} do not contradict each other: {cycle[:9]}")
                closed += 1
            else:
                choices += more
                while choices and any(part in chosen for part in choices[0]):  # it holds already
                    choices = choices[1:]
                kept = len(path)
                if choices:
                    parts = reversed(choices[0])
                    branches += [(kept, part, choices[1:], (*chosen, part), place) for part in parts]
                elif place[0] != DENIED:
                    branches += [(kept, flat, (), (), to) for flat, to in self.following(place, proof) if flat]
                else:
                    raise RejectedError(f"branch {closed} is left open: the claim may fail there")
        return closed

    def following(self, place: Place, proof: Iterator[int]) -> list[tuple[Flat, Place]]:
        """Returns the next places, the last first: the sides of the next test, or the ends when none is left."""
        tree, node, known = place
        leaf = ROOT
        while tree < len(self.trees):
            sides, below = self.trees[tree][node], self.known[tree]
            if not isinstance(sides, int):
                before, after, ((under, left), (over, right)) = known[:tree], known[tree + 1 :], sides
                return [
                    (over, (tree, right, (*before, below[right], *after))),
                    (under, (tree, left, (*before, below[left], *after))),
                ]
            leaf, tree, node = node, tree + 1, ROOT
        return [(flat, (DENIED, ROOT, known)) for flat in reversed(self.ends(leaf, known, proof))]


class Lemmas(DecisionWalk):
    """The walk over one agent's tree, which shows at each leaf that some of the claim's parts hold there."""

    def __init__(self, reading: Reading, agent: int, tree: SearchTree, claimed: int) -> None:
        super().__init__([tree], [[UNKNOWN] * len(tree)])
        self.reading, self.agent, self.tree, self.claimed = reading, agent, tree, claimed
        self.holding = [-claimed] * len(tree)  # sets of parts, as bits: none (0), or all (-1) where nobody comes

    def ends(self, leaf: int, known: tuple[Known, ...], proof: Iterator[int]) -> list[Flat]:
        """The denials of all parts that the proof says to hold at the leaf."""
        parts, action = next(proof), self.tree[leaf]
        assert isinstance(action, int)
        self.holding[leaf] &= parts
        return self.reading.deny_parts(self.agent, action, parts)

    def find_known(self) -> list[Known]:
        """Of each node: the action if it is a leaf, and the parts that hold at all leaves below it."""
        for node, sides in reversed([*enumerate(self.tree)]):  # children come after their parents
            if not isinstance(sides, int):
                (_, left), (_, right) = sides
                self.holding[node] = self.holding[left] & self.holding[right]
        actions = [node if isinstance(node, int) else None for node in self.tree]
        return list(zip(actions, self.holding, strict=True))


class Denial(DecisionWalk):
    """The walk over all trees, which shows that the denied claim is impossible."""

    def __init__(
        self, denied: Callable[..., Flat], trees: Sequence[SearchTree], known: Sequence[Sequence[Known]]
    ) -> None:
        super().__init__(trees, known)
        self.denied = denied

    def ends(self, leaf: int, known: tuple[Known, ...], proof: Iterator[int]) -> list[Flat]:
        """The denied claim, given all actions."""
        return [self.denied(known)]

    def is_settled(self, place: Place) -> bool:
        """Returns True if what is known of the agents already makes the denied claim false."""
        tree, _, known = place
        return tree != DENIED and self.denied(known) is None


def negative(cycle: Sequence[Edge]) -> bool:
    """Returns True if bounds form a cycle whose sum is negative, so that they cannot hold together."""
    end, total = cycle[-1][1], 0
    for upper, lower, weight in cycle:
        if upper != end:
            return False
        end, total = lower, total + weight
    return total < 0 and len(cycle) < LONGEST
