"""The checker of proofs about episodes: adds exact numbers along the cycles of bounds that a proof names.

Does: walks the search that README.md specifies and closes each of its branches again; counts them.
Assumes: the modules of the trusted base that README.md lists.
Does not: search for cycles, or import an engine.
"""

from collections.abc import Iterable, Iterator
from itertools import pairwise
from typing import TypeAlias

from codegen.ir import PolicyProfile
from verify.checker.episodes.reading import AWAY, CLAIM, REGION, EpisodeReading, Gap, Place, ProofPart, Side, matchings
from verify.checker.reading import LONGEST, RejectedError
from verify.claims.episodes import EpisodeClaim
from verify.claims.region import Region, goal_of

GO_ON = 0  # the number of a branch below which the search goes on
EVERY = -1  # no answer: below every answer the search goes on


# A branch that must be closed: how many bounds it keeps, the side that it adds to them, its place, and either EVERY or
# the answer to which all its starts are said to come. A side's child is asked next, else the question of the place.
Branch: TypeAlias = tuple[int, Side | None, Place, int]


def check(
    profile: PolicyProfile,
    claim: EpisodeClaim,
    region: Region,
    parts: Iterable[tuple[ProofPart, Iterator[int]]],
    reading: type[EpisodeReading] = EpisodeReading,
) -> int:
    """The number of branches closed; RejectedError when the parts do not show the claim for all goals of the region."""
    proofs, allowed, closed = list(parts), matchings(profile, claim), 0
    for goal in region.goal_cases:
        pairs = {(part.agent, part.landmark) for part, _ in proofs if part.goal in ("", goal)}
        whole_team = ("", "") in pairs
        if not whole_team and not any(pairs.issuperset(matching) for matching in allowed):
            raise RejectedError(f"goal {goal or 'none'}: the parts do not make up the claim")
    for part, proof in proofs:
        own = [((part.agent, part.landmark),)] if part.agent else allowed
        closed += close(reading(profile, claim, region, goal_of(part.goal), part.followed, own), proof)
    return closed


def close(episode: EpisodeReading, proof: Iterator[int]) -> int:
    """The number of branches closed; RejectedError when `proof` does not close all of them."""
    try:
        closed = EpisodeWalk(episode, proof).close()
    except (StopIteration, IndexError):
        raise RejectedError("the proof ends early, or names a bound that its branch does not have") from None
    if next(proof, None) is not None:
        raise RejectedError("the proof continues after its last branch")
    return closed


class EpisodeWalk:
    """The walk through an episode's questions, step by step."""

    def __init__(self, episode: EpisodeReading, proof: Iterator[int]) -> None:
        self.episode, self.proof, self.closed = episode, proof, 0
        self.bounds = BranchBounds(episode)

    def close(self) -> int:
        """Closes every branch; how many there are."""
        episode, bounds, proof = self.episode, self.bounds, self.proof
        branches: list[Branch] = [(0, None, (REGION, episode.region, (), episode.start), EVERY)]
        while branches:
            kept, side, place, only = branches.pop()
            stage, node, chosen, now = place
            bounds.keep(kept)
            if side is not None:
                bounds.add(*episode.bound(side, now))
                node, kept = side.child, kept + 1
            code = GO_ON if side is None and not isinstance(node, tuple) else next(proof)
            if code > episode.answers:
                self.ensure_empty(code - episode.answers - 1)
                self.closed += 1
                continue
            if isinstance(node, Gap):
                if code != GO_ON:
                    raise RejectedError(f"branch {self.closed} is said to answer how far two are apart")
                number = next(proof)
                node = episode.cut(node, number) if number else node
            elif code != GO_ON:  # all starts are said to come to one answer: the search goes on with it, at last
                if only != EVERY:
                    raise RejectedError(f"branch {self.closed} is said to answer two questions at once")
                only = code - 1
                branches.append((kept, None, (stage, only, chosen, now), EVERY))
                if (stage, only) == (CLAIM, AWAY):  # nothing need be shown: starts that have arrived may go on
                    continue
            if isinstance(node, tuple):
                branches += [(kept, side, place, only) for side in reversed(node) if side.child != only]
            elif only != EVERY:
                raise RejectedError(f"branch {self.closed} has an answer other than the one given as the only one")
            elif following := episode.onward(stage, node, chosen, now):
                branches.append((kept, None, following, EVERY))
        return self.closed

    def ensure_empty(self, between: int) -> None:
        """RejectedError unless the bounds around a cycle have a negative sum, so that no start meets them all.

        The cycle begins and ends with the bound that was added last; the proof names the coordinates in `between`.
        """
        upper, lower = self.bounds.last
        cycle = [upper, lower, *[next(self.proof) for _ in range(between)], upper]
        if len(cycle) > LONGEST or sum(self.bounds.most[p][q] for p, q in pairwise(cycle)) >= 0:
            raise RejectedError(f"the bounds of branch {self.closed} do not contradict each other: {cycle[1:10]}")


class BranchBounds:
    """The least bound on each difference of two coordinates that the branch at hand has, and what it had before."""

    def __init__(self, episode: EpisodeReading) -> None:
        self.most = [[episode.far] * episode.nodes for _ in range(episode.nodes)]  # [upper][lower]
        self.last = 0, 0  # (upper, lower) of the bound that was added or taken back last
        self._before: list[tuple[int, int, int]] = []

    def add(self, upper: int, lower: int, most: int) -> None:
        """Adds upper - lower <= most."""
        row, self.last = self.most[upper], (upper, lower)
        self._before.append((upper, lower, row[lower]))
        if most < row[lower]:
            row[lower] = most

    def keep(self, count: int) -> None:
        """Takes back all bounds but the first `count`."""
        while len(self._before) > count:
            upper, lower, before = self._before.pop()
            self.most[upper][lower] = before
            self.last = upper, lower
