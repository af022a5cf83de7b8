"""Proves a part of a claim step by step, putting symbolic states into hulls where they become too many.

Does: the symbolic states of one step after the other; the proof in the order in which the checker reads it.
Assumes: the questions of the checker's search, answered by a prover.
Does not: choose how much to merge (decide.py does).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

from codegen.ir import PolicyProfile
from verify.certificates.proofs import encode_numbers
from verify.checker.systems.proofs import FollowedPart, Hull
from verify.checker.systems.rows import Branch
from verify.checker.systems.walk import SystemQuestions
from verify.reach.hulls import Hulls
from verify.reach.search import SystemProver
from verify.systems.claims import SystemClaim
from verify.systems.system import System


class Merging(NamedTuple):
    """When symbolic states of a step are put into hulls: once there are more than `limit`; and into how many."""

    limit: int
    parts: int  # for each group that decides alike


@dataclass
class _Node:
    """A symbolic state with the answers that are given about it, and those that follow from it."""

    branch: Branch
    numbers: list[int] = field(default_factory=list[int])
    following: list[_Node] = field(default_factory=list["_Node"])
    hull: int | None = None


class Unfolding:
    """A proof of a part, as it is being made."""

    def __init__(
        self, profile: PolicyProfile, system: System, claim: SystemClaim, part: FollowedPart, prover: SystemProver
    ) -> None:
        self._search = SystemQuestions(profile, system, claim, part, prover)
        self._part, self._prover = part, prover
        self._hulls = Hulls(self._search, prover.programs)
        self._made: list[Hull] = []

    def run(self, merging: Merging | None) -> FollowedPart:
        """The part with its proof. BudgetError, or what the prover's `open_` raises."""
        roots = [_Node(branch) for branch in self._search.roots()]
        level = roots
        while level:
            level = [after for node in level for after in self._follow_node(node)]
            if merging is not None and len(level) > merging.limit:
                level = self._merge_level(level, merging.parts)
                roots += level
        numbers = [number for root in roots for number in self._write_answers(root)]
        return FollowedPart(self._part.followed, self._part.shows, tuple(self._made), encode_numbers(numbers))

    def _follow_node(self, node: _Node) -> list[_Node]:
        self._prover.numbers = node.numbers
        self._prover.visit(node.branch)
        node.following = [_Node(branch) for branch in self._search.follow_branch(node.branch)]
        return node.following

    def _merge_level(self, level: list[_Node], parts: int) -> list[_Node]:
        """Hulls that hold all symbolic states of a step, as symbolic states."""
        roots: list[_Node] = []
        for group in self._hulls.group_branches([node.branch for node in level], parts):
            number = len(self._made)
            self._made.append(self._hulls.hull([level[place].branch for place in group]))
            self._search.hulls = tuple(self._made)
            for place in group:
                node = level[place]
                node.hull, self._prover.numbers = number, node.numbers
                self._search.ensure_within(node.branch, number)
            root = self._search.root(self._made[-1])
            assert root is not None, "a hull that holds a symbolic state is not empty"
            roots.append(_Node(root))
        return roots

    def _write_answers(self, root: _Node) -> list[int]:
        """The answers about a symbolic state and all that follow from it, in the order of the checker's search."""
        numbers, pending = list[int](), [root]
        while pending:
            node = pending.pop()
            if self._made and node is not root:
                numbers.append(0 if node.hull is None else node.hull + 1)
            numbers += node.numbers
            pending += reversed(node.following)
        return numbers
