"""The checker of proofs about episodes: closes every branch again, by adding exact numbers along given cycles.

Does: follows the search that episode_certificate.py specifies; takes nothing from a proof but its branches and cycles.
Assumes: what must be right: codegen/ir.py; of verify/ formula, thresholds, bounds, episodes, episode_reading, this.
Does not: search, share more than thresholds.py with the engine, or know hashes (episode_certificate.py does).
"""

from collections.abc import Iterable, Iterator
from itertools import pairwise
from typing import Any

from codegen.ir import PolicyProfile
from verify.bounds import LONGEST, RejectedError
from verify.episode_reading import AWAY, CLAIM, REGION, Episode, Part, matchings
from verify.episodes import ClosedLoop
from verify.spec import Region

SPLIT = -1  # no answer is said to be the only one


def check(
    profile: PolicyProfile, claim: ClosedLoop, region: Region, parts: Iterable[tuple[Part, Iterator[int]]]
) -> int:
    """The number of branches closed; RejectedError when the parts do not show the claim for all goals of the region."""
    found, allowed, closed = list(parts), matchings(profile, claim), 0
    for goal in region.goals or ("",):
        shown = [part for part, _ in found if part.goal in ("", goal)]
        pairs = {(part.agent, part.landmark) for part in shown}
        if ("", "") not in pairs and not any(pairs.issuperset(own) for own in allowed):
            raise RejectedError(f"goal {goal or 'none'}: the parts are not the claim")
    for part, proof in found:
        own = [((part.agent, part.landmark),)] if part.agent else allowed
        closed += close(Episode(profile, claim, region, part.goal, part.followed, own), proof)
    return closed


def close(episode: Episode, proof: Iterator[int]) -> int:
    """The number of branches closed; RejectedError when `proof` does not close all of them."""
    most = [[episode.far] * episode.nodes for _ in range(episode.nodes)]
    closed, upper, lower, trail = 0, 0, 0, []
    stack: list[Any] = [(0, None, SPLIT, REGION, episode.region, (), episode.start)]
    try:
        while stack:
            kept, side, only, stage, node, chosen, now = stack.pop()
            while len(trail) > kept:
                upper, lower, before = trail.pop()
                most[upper][lower] = before
            if side is not None:
                upper, lower, bound = episode.bound(side, now)
                trail.append((upper, lower, most[upper][lower]))
                most[upper][lower] = min(bound, most[upper][lower])
            here, code = len(trail), 0 if side is None and isinstance(node, int) else next(proof)
            if code > episode.answers:
                cycle = [lower, *[next(proof) for _ in range(code - episode.answers - 1)], upper]
                total = most[upper][lower] + sum(most[p][q] for p, q in pairwise(cycle))
                if total >= 0 or len(cycle) >= LONGEST:
                    raise RejectedError(f"the bounds of branch {closed} can hold together: {cycle[:9]}")
                closed += 1
                continue
            if code:
                if only != SPLIT:
                    raise RejectedError(f"branch {closed} is said to answer two questions at once")
                only = code - 1
                stack.append((here, None, SPLIT, stage, only, chosen, now))
                if stage == CLAIM and only == AWAY:  # starts that have arrived may go on
                    continue
            if only == SPLIT and isinstance(node, int):
                if following := episode.onward(stage, node, chosen, now):
                    stack.append((here, None, SPLIT, *following))
            elif isinstance(node, int):
                raise RejectedError(f"branch {closed} has another answer than the one that is said to be the only one")
            else:
                stack += [(here, s, only, stage, s.child, chosen, now) for s in reversed(node) if s.child != only]
    except (StopIteration, IndexError):
        raise RejectedError("the proof ends early, or names a bound that its branch does not have") from None
    if next(proof, None) is not None:
        raise RejectedError("the proof goes on after its last branch")
    return closed
