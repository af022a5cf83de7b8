"""The checker of proofs: closes every branch of a question again, by adding exact numbers along given cycles.

Does: follows the search order that certificate.py specifies; takes nothing from a proof but places of bounds.
Assumes: what must be right: codegen/ir.py, verify/thresholds.py, verify/formula.py, verify/bounds.py and this file.
Does not: search, share more than thresholds.py with the engine, or know properties and hashes (certificate.py does).
"""

from collections.abc import Callable, Iterator, Sequence
from functools import cache
from typing import Any

from codegen.ir import PolicyProfile
from verify.bounds import LONGEST, NOTHING, Flat, Reading, RejectedError, region_formula
from verify.formula import Formula, agents
from verify.spec import Region, Semantics


def check(
    profile: PolicyProfile, claim: Formula, region: Region, goal: str, semantics: Semantics, proof: Iterator[int]
) -> int:
    """The number of branches closed; RejectedError when `proof` does not show the claim for this goal."""
    team = [policy for policy in profile.agents if policy.agent in agents(claim)]
    reading = Reading([policy.agent for policy in team], goal)
    start, _ = reading.flat(region_formula(region), True), reading.flat(claim, False, [(None, 0)] * len(team))
    trees, edges, kinds, closed = [reading.tree(policy, semantics) for policy in team], reading.edges(), [], 0
    try:
        for place, tree in enumerate(trees):
            masks = [-next(proof)] * len(tree)

            def lemmas(leaf: int, _: Any, place: int = place, masks: list[int] = masks) -> list[Flat]:
                masks[leaf] &= (mask := next(proof))
                return reading.denied(place, trees[place][leaf], mask)

            closed += _walk(proof, edges, start, [tree], [masks], lemmas) if masks[0] else 0
            for v in reversed(range(len(tree))):
                masks[v] = masks[v] if isinstance(tree[v], int) else masks[tree[v][0][1]] & masks[tree[v][1][1]]
            kinds.append([(v if isinstance(v, int) else None, mask) for v, mask in zip(tree, masks, strict=True)])
        denial = cache(lambda known: reading.flat(claim, False, known))
        closed += _walk(proof, edges, start, trees, kinds, lambda _, known: [denial(known)], denial)
    except (StopIteration, IndexError):
        raise RejectedError("the proof ends early, or names a bound that its branch does not have") from None
    if next(proof, None) is not None:
        raise RejectedError("the proof goes on after its last branch")
    return closed


def _walk(  # closes every branch below `start`: of the trees, then of what `ends` gives at their leaves
    proof: Iterator[int], edges: Sequence[tuple[str, str, int]], start: Flat, trees: Sequence[Any],
    kinds: Sequence[Any], ends: Callable[[int, Any], list[Flat]], denial: Callable[[Any], Flat] = lambda _: NOTHING
) -> int:  # fmt: skip
    leaf, closed, path, known = 0, 0, [], tuple(kind[0] for kind in kinds)
    stack: list[Any] = [(0, start, (), (), 0, 0, known)] if start else []
    while stack:
        kept, (numbers, more), ors, chosen, k, v, known = stack.pop()
        path[kept:] = numbers
        if length := 0 if (done := k >= 0 and denial(known) is None) else next(proof):
            cycle = [edges[path[next(proof)]] for _ in range(length)]
            end, total = cycle[-1][1], 0
            for upper, lower, weight in cycle:
                end, total = lower if upper == end else None, total + weight
            if end is None or total >= 0 or length >= LONGEST:
                raise RejectedError(f"the bounds of branch {closed} can hold together: {cycle[:9]}")
        if done or length:
            closed += 1
            continue
        here, ors = len(path), ors + more
        while ors and any(part in chosen for part in ors[0]):
            ors = ors[1:]
        if ors:
            stack += [(here, part, ors[1:], (*chosen, part), k, v, known) for part in reversed(ors[0])]
            continue
        while 0 <= k < len(trees) and isinstance(trees[k][v], int):
            leaf, k, v = v, k + 1, 0
        if k < 0:
            raise RejectedError(f"branch {closed} is left open: the claim may fail there")
        if k == len(trees):
            stack += [(here, flat, (), (), -1, 0, known) for flat in reversed(ends(leaf, known)) if flat]
            continue
        stack += [(here, f, (), (), k, w, (*known[:k], kinds[k][w], *known[k + 1 :])) for f, w in trees[k][v] if f]
    return closed
