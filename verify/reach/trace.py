"""Counterexamples along cells: an exact episode that goes from each cell of a list to the next, then breaks a claim.

Does: chooses for each step what the step before may set to any number, so that agents act as the next cell asks: a leaf
  of a tree asks for numbers within its bounds.
Assumes: the list leads from the start to a state that may break the claim.
Does not: look ahead, or believe what it finds: the episode is replayed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from fractions import Fraction
from itertools import islice, product
from math import floor

from codegen.ir import AgentPolicy, PolicyProfile
from verify.checker.systems.reading import sides_of
from verify.claims.formula import Formula, Linear, holds
from verify.reach.covering import set_anew
from verify.reach.replay import Course, replay_course, shrink_counterexample, take_step
from verify.reach.results import SystemCounterexample
from verify.systems.claims import SystemClaim
from verify.systems.system import FREE, Interval, State, System

MAX_CHOICES = 4_096  # of leaves, one for each agent
Bounds = Mapping[str, Interval]


def trace_cells(
    profile: PolicyProfile,
    system: System,
    claim: SystemClaim,
    start: Bounds,
    cells: int,
    inside: Callable[[State, int], bool],
) -> SystemCounterexample | None:
    """The episode that a list of cells leads to; None where none is found. `inside`: whether a state lies in the cell
    of a place in the list.
    """
    anew = sorted(set_anew(system))
    choices = list(islice(_iterate_choices(profile, system, set(anew)), MAX_CHOICES))
    state, ends = {name: low for name, (low, _) in start.items()}, {name: start[name] for name in anew}
    first, errors, pieces = state, list[Mapping[str, Fraction]](), list[int]()
    for place in range(cells):
        for choice in choices:
            chosen = {name: _pick(choice.get(name, FREE), ends[name]) for name in anew}
            taken = take_step(profile, system, {**state, **chosen}, {})
            goes_on = taken is not None and (
                holds(claim.violation_at(place + 1), taken.after, {})
                if place + 1 == cells
                else inside(taken.after, place + 1)
            )
            if taken is not None and goes_on:
                break
        else:
            return None
        if pieces:
            errors.append({name: chosen[name] - system.pieces[pieces[-1]].move[name].constant for name in anew})
        else:
            first = {**state, **chosen}
        piece = system.pieces[taken.piece]
        state, pieces = taken.after, [*pieces, taken.piece]
        for name in anew:
            low, high = piece.error.get(name, (Fraction(0), Fraction(0)))
            ends[name] = piece.move[name].constant + low, piece.move[name].constant + high
    found = replay_course(profile, system, claim, Course(first, errors, pieces))
    return None if found is None else shrink_counterexample(profile, system, claim, found)


def _pick(asked: Interval, ends: Interval) -> Fraction:
    """A number within bounds that exclude the lower one, a whole one if possible; within `ends` in any case."""
    low, high = max(asked[0], ends[0]), min(asked[1], ends[1])
    whole = Fraction(floor(high))
    return min(max(whole if whole > low else (low + high) / 2, ends[0]), ends[1])


def _iterate_choices(profile: PolicyProfile, system: System, anew: set[str]) -> Iterator[Bounds]:
    """What each choice of a leaf of every agent asks of some variables."""
    leaves = [list(_iterate_leaves(policy, sides_of(system, policy), anew, 0, {})) for policy in profile.agents]
    for chosen in product(*leaves):
        asked: dict[str, Interval] = {}
        for name, (low, high) in (each for leaf in chosen for each in leaf.items()):
            before = asked.get(name, FREE)
            asked[name] = max(low, before[0]), min(high, before[1])
        yield asked


def _iterate_leaves(
    policy: AgentPolicy, sides: Mapping[int, Formula], anew: set[str], node: int, bounds: Bounds
) -> Iterator[Bounds]:
    """What each leaf below a node asks of some variables."""
    if node not in sides:
        yield bounds
        return
    side, left, right = sides[node], bounds, bounds
    if isinstance(side, Linear) and len(side.terms) == 1 and side.terms[0][1] in anew:
        ((weight, name),) = side.terms
        (low, high), end = bounds.get(name, FREE), side.bound / weight
        below, above = {**bounds, name: (low, min(high, end))}, {**bounds, name: (max(low, end), high)}
        left, right = (below, above) if weight > 0 else (above, below)
    yield from _iterate_leaves(policy, sides, anew, int(policy.tree.left[node]), left)
    yield from _iterate_leaves(policy, sides, anew, int(policy.tree.right[node]), right)
