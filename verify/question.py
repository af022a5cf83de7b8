"""The question: what is asked of a subject, as one value; and what every claim has that may be asked.

Does: holds subject, claim, region, semantics and budgets; derives formula, goals, team, neighbouring questions and the
  shuffled controls.
Assumes: a checked profile, a claim and a region about its world.
Does not: decide.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from itertools import product
from math import factorial, prod
from typing import Any, ClassVar, Generic, Protocol, TypeVar

import numpy as np

from codegen import ir
from codegen.ir import GOAL, AgentPolicy, PolicyProfile
from verify.claims.claim import read_by, verifiable
from verify.claims.decisions import DecisionClaim, formula
from verify.claims.episodes import EpisodeClaim
from verify.claims.formula import Formula, agents, conjuncts, for_goal, names_goal
from verify.claims.region import Region
from verify.claims.region_files import everywhere
from verify.claims.views import Viewed
from verify.claims.wording import OwnFormula
from verify.kinds import MACHINE, Kind
from verify.subjects import Game, Subject

CONTROL_SEED = 0
SMALL, SAMPLED = 24, 20  # orders of leaves that are all asked about; and else how many
MAX_TOGETHER = 3  # agents of a claim that is never divided
UNITS_A_NODE = 50  # of a budget in solver resource units, so many stand for one search node
SECOND_OPINION_UNITS, DETAIL_UNITS = 20_000_000, 4_000_000


class AnyClaim(Protocol):
    """A claim of any kind."""

    kind: ClassVar[Kind]
    per_state: ClassVar[bool]  # whether a single world state fulfils or breaks it
    limits: ClassVar[tuple[str, ...]]  # the budgets, as `Budgets` names them, that deciding it may use up
    arithmetics: ClassVar[tuple[str, ...]]  # by which it may be asked

    @property
    def team(self) -> str:
        """Whose decisions it is about; "": those of all agents."""
        ...

    @property
    def name(self) -> str:
        """The name of the property."""
        ...

    @property
    def label(self) -> str:
        """The name that a user gave it; "" where nobody said."""
        ...

    @property
    def shown(self) -> str:
        """The label, or else the name."""
        ...

    @property
    def rounded(self) -> tuple[tuple[str, str], ...]:
        """Numbers as they are written, and the floats that they are read as."""
        ...


About = TypeVar("About", bound=AnyClaim, covariant=True)
Asked = TypeVar("Asked", bound=AnyClaim)


LIMITS = ("solver_units", "max_nodes", "max_cells", "max_zones", "max_boxes")
EFFORTS = {"low": Fraction(1, 10), "normal": Fraction(1), "high": Fraction(10)}  # times the usual limits


@dataclass(frozen=True)
class Budgets:
    """The limits on what is spent on a question, in units that do not depend on the machine."""

    solver_units: int = 200_000_000  # Z3 resource units per query; a depth-10 pair of trees takes far less
    max_nodes: int = 4_000_000  # search nodes per goal; half a second compiled, a minute or two in Python
    max_cells: int = 50_000  # listed where a claim fails, over all goals
    max_zones: int = 5_000_000  # visited for a claim about episodes; about a million a second
    max_boxes: int = 60_000_000  # spent on claims about a stated system, whatever is tried; about a million a second
    covers: bool = True  # whether boxes are tried; tests of what comes after them leave them out
    samples: int = 4_096  # episodes of a stated system that are played in search of a counterexample
    option: str = "--effort"  # that sets the limits on units and nodes; "" where none does

    @staticmethod
    def of_effort(effort: str) -> "Budgets":
        """Returns the limits of an effort, one of EFFORTS."""
        usual, times = Budgets(), EFFORTS[effort]
        limits = {name: int(getattr(usual, name) * times) for name in LIMITS}
        return replace(usual, **limits)

    def hint(self, what: str = "may answer") -> str:
        """Returns advice for where a limit on units or nodes ended a search."""
        return f"a larger {self.option} {what}" if self.option else "smaller trees or a smaller region may be decided"

    @property
    def second_opinion_units(self) -> int:
        """Solver units for a second opinion, where zones have a verdict: a minute of a large question by default."""
        return min(self.solver_units, max(SECOND_OPINION_UNITS, self.solver_units // 10))

    @property
    def detail_units(self) -> int:
        """Solver units for a query that tells more of a verdict: such as where else the claim fails."""
        return min(self.solver_units, max(DETAIL_UNITS, self.solver_units // 50))


@dataclass(frozen=True, eq=False)
class Question(Generic[About]):
    """The question whether a claim holds of its subject wherever a region reaches, by the arithmetic named.

    For example:

        maviper.verify(team).question.claim
    """

    subject: Subject
    claim: About
    region: Region
    semantics: str = MACHINE
    budgets: Budgets = Budgets()
    since: tuple[Any, ...] = ()  # of a stated system: earlier proofs, of which what still holds is used

    @property
    def profile(self) -> PolicyProfile:
        """Whose trees are asked about."""
        return self.subject.profile

    @property
    def origin(self) -> PolicyProfile:
        """The profile that was given: the one whose view is asked about, or else the one asked about."""
        return self.subject.origin

    @property
    def viewed(self) -> Viewed | None:
        """The view that is asked about; None where it is not about observations alone."""
        return self.subject.viewed

    @cached_property
    def formula(self: "Question[DecisionClaim]") -> Formula:
        """The claim as a formula, its assumption included."""
        return formula(self.profile, self.claim)

    def formula_for(self: "Question[DecisionClaim]", goal: str | None) -> Formula:
        """The claim as a formula for one goal."""
        if goal not in self._for_goals:
            self._for_goals[goal] = for_goal(self.formula, goal)
        return self._for_goals[goal]

    @cached_property
    def _for_goals(self) -> dict[str | None, Formula]:
        return {}

    @property
    def goals(self) -> tuple[str | None, ...]:
        """The goals that are asked about one by one; None alone where the world has none."""
        return self.region.goal_cases

    @cached_property
    def names_goal(self: "Question[DecisionClaim]") -> bool:
        """True if the claim or a test of an agent that it speaks of names the goal: else all goals have one answer."""
        acting = agents(self.formula)
        policies = (policy for policy in self.profile.agents if policy.agent in acting)
        return names_goal(self.formula) or any(GOAL in read_by(policy) for policy in policies)

    @cached_property
    def parts(self: "Question[DecisionClaim]") -> "tuple[Question[DecisionClaim], ...]":
        """Questions that are answered one by one instead: about fewer agents each, where a claim about many is a
        conjunction of claims about several; else this one. What is about one agent needs no dividing.
        """
        parts, everybody = conjuncts(self.formula), agents(self.formula)
        largest = max((len(agents(part)) for part in parts), default=0)  # nothing to fail: no parts
        if len(everybody) <= MAX_TOGETHER or not 1 < largest < len(everybody):
            return (self,)
        claim = self.claim
        own = [OwnFormula(claim.team, claim.margin, claim.radius, eps=claim.eps, statement=part) for part in parts]
        return tuple(self.about(part) for part in own)

    @property
    def cases(self: "Question[DecisionClaim]") -> "list[Case]":
        """The cases that are answered one by one: each part for each goal."""
        return list(product(self.goals, self.parts))

    @cached_property
    def team(self) -> tuple[AgentPolicy, ...]:
        """The policies of the team that the claim is about; InputError where it cannot be asked about them."""
        return verifiable(self.profile, self.claim.team)

    @property
    def controls(self) -> "list[Question[About]]":
        """The same question about the team with its leaves shuffled, once for each way; of a view, with its copies."""
        shuffled, viewed = list_shuffled(self.origin, self.claim.team), self.viewed
        asked: list[Question[About]] = list(map(self.of, shuffled))
        if viewed is not None:
            views = [viewed._replace(origin=each) for each in shuffled]
            asked = [replace(self, subject=replace(self.subject, profile=each.profile, viewed=each)) for each in views]
        known = {name: self.__dict__[name] for name in ("formula", "_for_goals") if name in self.__dict__}
        for each in asked:
            each.__dict__.update(known)  # which do not hang on the actions of leaves
        return asked

    def of(self, profile: PolicyProfile) -> "Question[About]":
        """The same question about another profile."""
        return replace(self, subject=self.subject.of(profile))

    def about(self, claim: "Asked") -> "Question[Asked]":
        """The same question about another claim."""
        return Question(self.subject, claim, self.region, self.semantics, self.budgets)

    def within(self, region: Region) -> "Question[About]":
        """The same question about another region."""
        return replace(self, region=region)

    def for_one_goal(self, goal: str | None) -> "Question[About]":
        """The same question about one goal of the region (None without goals)."""
        return self.within(replace(self.region, goals=() if goal is None else (goal,)))

    def by(self, semantics: str) -> "Question[About]":
        """The same question in another arithmetic."""
        return replace(self, semantics=semantics)

    def spending(self, **limits: int) -> "Question[About]":
        """The same question with other limits in its budgets."""
        return replace(self, budgets=replace(self.budgets, **limits))

    def with_margin(self: "Question[DecisionClaim]", margin: Fraction) -> "Question[DecisionClaim]":
        """The same question with another margin."""
        return self.about(replace(self.claim, margin=margin))

    def with_eps(self: "Question[DecisionClaim]", eps: Fraction) -> "Question[DecisionClaim]":
        """The same question with other errors of features."""
        return self.about(replace(self.claim, eps=eps))


DecisionQuestion = Question[DecisionClaim]
Case = tuple[str | None, DecisionQuestion]  # a goal (None without goals), and a part of a question
EpisodeQuestion = Question[EpisodeClaim]


def list_shuffled(profile: PolicyProfile, team: str) -> list[PolicyProfile]:
    """The controls: the same trees, with the actions of leaves in every other order of small teams, else in SAMPLED
    random ones.
    """
    leaves: list[list[int]] = [
        policy.tree.action[ir.leaves(policy.tree)].tolist() if team in ("", policy.team) else []
        for policy in profile.agents
    ]
    if prod(map(_count_orders, leaves)) > SMALL:
        shuffled = (shuffle_leaves(profile, team, seed) for seed in range(10 * SAMPLED))
        found: dict[tuple[bytes, ...], PolicyProfile] = {}
        while len(found) < SAMPLED and (one := next(shuffled, None)) is not None:
            found[tuple(each.tree.action.tobytes() for each in one.agents)] = one
        return list(found.values())
    return [_with_leaves(profile, orders) for orders in product(*map(_list_orders, leaves)) if list(orders) != leaves]


def _count_orders(actions: Sequence[int]) -> int:
    return factorial(len(actions)) // prod(factorial(count) for count in Counter(actions).values())


def _list_orders(actions: list[int]) -> list[list[int]]:
    """All different orders of some actions."""
    if len(set(actions)) <= 1:
        return [actions]
    rests = {first: [*actions[:place], *actions[place + 1 :]] for place, first in enumerate(actions)}
    return [[first, *rest] for first in sorted(rests) for rest in _list_orders(rests[first])]


def _with_leaves(profile: PolicyProfile, orders: Sequence[list[int]]) -> PolicyProfile:
    """The same trees with the actions of leaves in some order; no actions: as they are."""
    policies: list[AgentPolicy] = []
    for policy, order in zip(profile.agents, orders, strict=True):
        action = policy.tree.action.copy()
        action[ir.leaves(policy.tree)] = order or action[ir.leaves(policy.tree)]
        grown = None if order else policy.grown
        policies.append(replace(policy, tree=replace(policy.tree, action=action), grown=grown))
    return replace(profile, agents=tuple(policies))


def shuffle_leaves(profile: PolicyProfile, team: str, seed: int = CONTROL_SEED) -> PolicyProfile:
    """The same trees, with the actions of each team member's leaves shuffled; "": those of all agents."""
    rng = np.random.default_rng(seed)
    policies: list[AgentPolicy] = []
    for policy in profile.agents:
        if team in ("", policy.team):
            action, leaf = policy.tree.action.copy(), ir.leaves(policy.tree)
            action[leaf] = action[rng.permutation(leaf)]
            while (action == policy.tree.action).all() and len(set(action[leaf])) > 1:  # a tree of two leaves, often
                action[leaf] = action[rng.permutation(leaf)]
            policy = replace(policy, tree=replace(policy.tree, action=action), grown=None)
        policies.append(policy)
    return replace(profile, agents=tuple(policies))


def from_start(profile: PolicyProfile, claim: Asked, semantics: str = MACHINE) -> Question[Asked]:
    """The question about the start region."""
    return Question(Game(profile), claim, everywhere(profile), semantics)
