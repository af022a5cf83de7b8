"""Jitter and delay for the checker: periods of one length in which time runs at some pace, and late observations.

Does: a flow whose periods vary as one whose derivatives have a factor; sends sets down trees for each delay.
Assumes: jitter by which a period stays longer than 0; variables that keep earlier values, as systems/system.py says.
Does not: step or ask claims.

If x' = f(x) + w for h seconds, then y(s) = x(p s) solves y' = p f(y) + p w for h / p seconds. So a period of any length
between T + a and T + b is a period of length T with one pace p in [1 + a/T, 1 + b/T], which stays for that period. It
goes through the same states. The pace is an input that is held, and p w lies in the hull of its products at the ends.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from codegen.ir import AgentPolicy
from verify.checker.covers.boxes import BoxList, join_by_cell, together
from verify.checker.covers.trees import TreeCuts
from verify.systems.expressions import Name, Product
from verify.systems.system import Flow, Interval, System

PACE = "pace of the period"  # an input; no text can write it


def pace_of(flow: Flow) -> Interval:
    """Between which numbers the pace lies."""
    low, high = flow.jitter
    return 1 + low / flow.period, 1 + high / flow.period


def pace_flow(flow: Flow) -> Flow:
    """The flow with all periods of one length, at a pace; itself where there is no jitter."""
    if not any(flow.jitter):
        return flow
    errors = {name: _products(pace_of(flow), error) for name, error in flow.error.items()}
    return replace(flow, rates={name: Product(Name(PACE), rate) for name, rate in flow.rates.items()}, error=errors)


def _products(one: Interval, other: Interval) -> Interval:
    ends = [a * b for a in one for b in other]
    return min(ends), max(ends)


class LateTrees:
    """The tree of one agent, once for each way in which its observations may be late."""

    def __init__(self, system: System, policy: AgentPolicy, columns: Mapping[str, int]) -> None:
        assert system.flow is not None
        seen = [{name: columns[each.get(name, name)] for name in columns} for each in system.flow.seen]
        self.ways = [TreeCuts(system, policy, each) for each in seen]

    @property
    def actions(self) -> int:
        """The number of the agent's actions."""
        return self.ways[0].actions

    def split_at_tests(self, boxes: BoxList) -> BoxList:
        """The boxes by what the agent may do, whichever way it is."""
        if len(self.ways) == 1:
            return self.ways[0].split_at_tests(boxes)
        parts = together([tree.split_at_tests(boxes) for tree in self.ways])
        return join_by_cell(parts, parts.joint[:, None])
