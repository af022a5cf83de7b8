"""Where two profiles act differently, exactly, or the proof that they act alike.

Does: for each agent every zone of states in which the profiles act differently, with their exact share and an example;
  for agents without such a zone a certificate, which the checker accepted. Profiles that remember the same become two
  that remember nothing: an action with other updates is another action.
Assumes: profiles that can be compared (claims/relations.py); of memory the same names and initial values.
Does not: write reports; play episodes.

The profiles are read as one team with twice the agents (`pair_profiles`), and "acts alike" is a claim about it. So the
engines for claims about single decisions answer: zones, and Z3 where a test bounds no difference of two coordinates.

Agents that remember are compared where what is remembered is in the ranges of both. That is enough: both begin there
alike, and one leaves the other's range by an update that the other does not make. Memory is whole, and zones are of
real numbers. A test of memory is moved down to a whole number, and what is said of it is closed and has whole ends. So
each zone of it is (a, b] between whole numbers, or ends at one, and holds a whole one.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import islice, pairwise

import numpy as np

from codegen.errors import InputError
from codegen.ir import ActionSpec, AgentPolicy, FeatureSpec, PolicyProfile, Update
from codegen.memory import tabulate_updates
from verify.checker.decisions import DecisionCertificate, check_certificate
from verify.claims.formula import Acts, Formula, below, conjunction, disjunction
from verify.claims.region import Region
from verify.claims.relations import alike, counterpart, ensure_comparable, pair_profiles
from verify.claims.wording import OwnFormula
from verify.counterexamples.search import MAX_PLACES, confirm_point
from verify.extent.violations import ExactShare, Failing, exact_share, measure_union, violations
from verify.kinds import MACHINE
from verify.question import Budgets, DecisionQuestion, Question
from verify.result import Verdict
from verify.solver import solve as solver
from verify.states.shares import explain_unstated
from verify.states.state import State, exact_point, inside, leaf_at, nearest
from verify.subjects import Game
from verify.verdicts.decisions import ONLY_REAL, certify
from verify.zones import engine as zones
from verify.zones.search import Branch

ROUNDING = Fraction(1, 1 << 22)  # more than float32 hides beside a number
UNSHARED = "what is remembered has values that no episode may meet"
Does = tuple[str, frozenset[Update]]  # the action that is taken, and what it updates


def unite_actions(first: PolicyProfile, second: PolicyProfile) -> tuple[PolicyProfile, PolicyProfile]:
    """Both profiles with the same actions: those that are taken, then all that change memory. InputError where an agent
    remembers or takes something else in the other one.
    """
    others = {policy.agent: policy for policy in second.agents}
    pairs = [_unite(policy, others[policy.agent]) for policy in first.agents if policy.agent in others]
    united = [{each.agent: each for each in side} for side in zip(*pairs, strict=True)]
    return tuple(  # type: ignore[return-value]
        replace(profile, agents=tuple(of.get(each.agent, each) for each in profile.agents))
        for profile, of in zip((first, second), united, strict=True)
    )


def _unite(one: AgentPolicy, other: AgentPolicy) -> tuple[AgentPolicy, AgentPolicy]:
    if [(each.name, each.initial) for each in one.memory] != [(each.name, each.initial) for each in other.memory]:
        told = " and ".join(", ".join(map(_tell, policy.memory)) or "nothing" for policy in (one, other))
        advice = "name it alike in both sources, and begin with the same; or verify the same claims of both"
        raise InputError(f"{one.agent} remembers different things: {told}", one.agent, advice)
    plain = [[each for each in policy.actions if not each.acts] for policy in (one, other)]
    if plain[0] != plain[1]:
        raise InputError(f"{one.agent} takes different actions in the two profiles", one.agent, "name them alike")
    actions = {_does(each): each for each in plain[0]}
    taken = {each.name for each in plain[0]}
    for each in (each for policy in (one, other) for each in policy.actions if each.acts):
        if _does(each) not in actions:
            name = next(n for n in (each.name, *(f"{each.name}_{k}" for k in range(2, 1_000))) if n not in taken)
            taken.add(name)
            actions[_does(each)] = replace(each, name=name)
    order = {each: place for place, each in enumerate(actions)}
    return _renumber(one, order, [*actions.values()]), _renumber(other, order, [*actions.values()])


def _tell(memory: FeatureSpec) -> str:
    return f"{memory.name} {memory.low:g} to {memory.high:g}, {memory.initial} first"


def _does(action: ActionSpec) -> Does:
    return action.acts or action.name, frozenset(action.updates)


def _renumber(policy: AgentPolicy, order: dict[Does, int], actions: Sequence[ActionSpec]) -> AgentPolicy:
    places = np.array([order[_does(each)] for each in policy.actions])
    chosen = np.where(policy.tree.action >= 0, places[policy.tree.action], policy.tree.action)
    return replace(policy, actions=tuple(actions), tree=replace(policy.tree, action=chosen), grown=None)


def forget(profile: PolicyProfile, other: PolicyProfile) -> PolicyProfile:
    """The profile as if its memory were observed, in the ranges that it and another one have."""
    theirs = {policy.agent: {each.name: each for each in policy.memory} for policy in other.agents}
    return replace(profile, agents=tuple(_forget(policy, theirs.get(policy.agent, {})) for policy in profile.agents))


def _forget(policy: AgentPolicy, others: Mapping[str, FeatureSpec]) -> AgentPolicy:
    if not policy.memory:
        return policy
    width, tree = len(policy.features) - len(policy.memory), policy.tree
    threshold = np.where(tree.feature >= width, np.floor(tree.threshold), tree.threshold)
    features = tuple(_narrow(each, others.get(each.name, each)) for each in policy.features)
    return replace(policy, features=features, tree=replace(tree, threshold=threshold))


def _narrow(one: FeatureSpec, other: FeatureSpec) -> FeatureSpec:
    if one.initial is None:
        return one
    return replace(one, initial=None, low=max(one.low, other.low), high=min(one.high, other.high))


def say_alike(first: PolicyProfile, view: PolicyProfile) -> Callable[[Sequence[str]], Formula]:
    """Returns what says that agents do the same in both profiles, memory included. `view`: the first one, as claims
    over observations read it.
    """

    def state(agents: Sequence[str]) -> Formula:
        return conjunction(*(_alike(first.policy(agent), view.policy(agent)) for agent in agents))

    return state


def _alike(policy: AgentPolicy, viewed: AgentPolicy) -> Formula:
    other, taken = counterpart(policy.agent), policy.taken
    keeps, adds = tabulate_updates(policy)
    names = list(name_memory(viewed, [each.name for each in policy.memory]))
    ways: list[Formula] = []
    for k in range(len(taken)):
        for j in range(len(taken)):
            if taken[k] == taken[j]:
                same = (_same(*each) for each in zip(names, keeps[k], adds[k], keeps[j], adds[j], strict=True))
                ways.append(conjunction(Acts(policy.agent, k), Acts(other, j), *same))
    return disjunction(*ways)


def _same(name: str, kept: int, added: int, kept_there: int, added_there: int) -> Formula:
    """Where both leave the same number: everywhere, nowhere, or at one number."""
    if kept == kept_there:
        return below({}, 0 if added == added_there else -1)
    at = int(added_there - added) if kept else int(added - added_there)
    return conjunction(below({name: 1}, at + 1, strict=True), below({name: -1}, 1 - at, strict=True))


def name_memory(viewed: AgentPolicy, remembered: Sequence[str]) -> tuple[str, ...]:
    """The variables of a view that are what an agent remembers."""
    features = {each.name: each for each in viewed.features}
    return tuple(features[name].meaning.terms[0][1] for name in remembered)  # type: ignore[union-attr]


def list_whole(profile: PolicyProfile) -> set[str]:
    """The variables of a view that are whole numbers, since actions update them."""
    named = {policy.agent: {each.memory for a in policy.actions for each in a.updates} for policy in profile.agents}
    return {name for policy in profile.agents for name in name_memory(policy, sorted(named[policy.agent]))}


def round_whole(number: Fraction) -> Fraction:
    """The whole number that a number in a zone stands for: the next one, unless it is a rounding above one."""
    return Fraction(math.ceil(number - (abs(number) + 1) * ROUNDING))


def make_whole(region: Region, names: Sequence[str]) -> Region:
    """The region with whole bounds of what is remembered. InputError where it holds no whole number, or compares it."""
    box = dict(region.box)
    for name in names:
        low, high = box[name]
        box[name] = type(low)(math.ceil(low)), type(high)(math.floor(high))
        if box[name][0] > box[name][1]:
            raise InputError(f"{name} is remembered, and no whole number is in the region", "--region", "widen it")
    for a, b, _ in region.differences:
        if {a, b} & {*names}:
            raise InputError(f"the region compares {a} and {b}, and memory is compared with numbers", "--region", "")
    return replace(region, box=box)


TRIED = 64  # zones in which a float64 state is looked for, before Z3 is asked for one
SPREAD = Fraction(755, 1000), Fraction(570, 1000)  # steps of a sequence that fills a square evenly
NO_NODES = "the search ended after {:,} nodes; {}"
MANY_CELLS = "there are more than {:,} zones; a larger --effort finds more"
WITHOUT_ZONES = "a test bounds neither a coordinate nor a difference of two, so Z3 decides alone, without zones"
Span = tuple[Fraction, Fraction]  # the least and the most that a share of the region may be


@dataclass(frozen=True)
class Zone:
    """Some states of one goal in which an agent acts differently: one leaf in each profile."""

    failing: Failing
    branch: Branch
    volume: int | None  # in the unit of its agent's share


@dataclass(frozen=True)
class AgentDifference:
    """The difference of one agent. PROVED: it acts alike in both profiles; VIOLATED: it acts differently somewhere."""

    agent: str
    verdict: Verdict
    reason: str = ""  # why there is no answer, or not all zones
    failing: tuple[Failing, ...] = ()  # goal by goal
    share: ExactShare | None = None  # of the zones in the region
    unmeasured: str = ""  # why no share of the region is told, and what to state
    example: State | None = None  # in which it acts differently, as both profiles' trees confirm

    @property
    def complete(self) -> bool:
        """True if the zones are all that there are."""
        return bool(self.failing) and all(one.complete for one in self.failing)

    @property
    def zones(self) -> list[Zone]:
        """All zones, the largest first."""
        rows = [
            Zone(failing, branch, None if self.share is None else self.share.zones[place][number])
            for place, failing in enumerate(self.failing)
            for number, branch in enumerate(failing.zones)
        ]
        return sorted(rows, key=lambda row: -(row.volume or 0))

    @property
    def span(self) -> Span:
        """Between which bounds the share of the region lies in which it acts differently."""
        if self.verdict is Verdict.PROVED:
            return Fraction(0), Fraction(0)
        if self.share is None:
            return Fraction(0), Fraction(1)
        return self.share.value, self.share.value if self.complete else Fraction(1)


@dataclass(frozen=True)
class Difference:
    """Two profiles in a region, agent by agent."""

    first: PolicyProfile
    second: PolicyProfile
    question: DecisionQuestion  # whether all of these agents act alike, of both profiles as one
    agents: tuple[AgentDifference, ...]
    together: Span  # the share of the region in which some agent acts differently
    certificate: DecisionCertificate | None = None  # that the agents that are PROVED act alike
    branches: int = 0  # that it closes
    unmeasured: str = ""  # why no share of the region is told of any agents

    @property
    def verdict(self) -> Verdict:
        """PROVED where all agents act alike, VIOLATED where some does not."""
        verdicts = {one.verdict for one in self.agents}
        worst = (Verdict.VIOLATED, Verdict.UNKNOWN, Verdict.VACUOUS, Verdict.PROVED)
        return next(verdict for verdict in worst if verdict in verdicts)


def difference(
    first: PolicyProfile,
    second: PolicyProfile,
    agents: Sequence[str],
    region: Region,
    semantics: str = MACHINE,
    budgets: Budgets | None = None,
    state: Callable[[Sequence[str]], Formula] | None = None,
    unmeasured: str = "",
) -> Difference:
    """Where these agents act differently. InputError for profiles that cannot be compared.

    `max_nodes` of the budgets limits each search, `max_cells` the zones of an agent, `solver_units` each query to Z3.
    `state`: says that agents act alike; default that they take the same action. `unmeasured`: why no share is told.
    """
    ensure_comparable(first, second, agents)
    agents = [policy.agent for policy in first.agents if policy.agent in agents]  # each once, as certificates have them
    pair = pair_profiles(first, second)

    def question_of(*names: str) -> DecisionQuestion:
        claim = OwnFormula(first.policy(names[0]).team, statement=state(names) if state else alike(first, names))
        return Question(Game(pair), claim, region, semantics, budgets or Budgets())

    by_agent = [_compare_agent(question_of(one), one, unmeasured) for one in agents]
    proved = [one.agent for one in by_agent if one.verdict is Verdict.PROVED and one.failing]
    certificate, branches = None, 0
    if proved:
        question = question_of(*proved)
        outcome = zones.decide(question)
        if outcome.verdict is Verdict.VIOLATED:
            raise AssertionError(f"no zone in which the profiles act differently, yet {outcome.state} is in one")
        if outcome.verdict is Verdict.PROVED:
            both = None if state else (first, second)  # else the certificate is about the pair as one profile
            certificate = certify(question, outcome, pair=both)
            branches = check_certificate(certificate, *(both or (pair,)))
        else:  # what is not certified is not proved
            answer = {"verdict": outcome.verdict, "reason": outcome.reason}
            by_agent = [replace(one, **answer) if one.agent in proved else one for one in by_agent]
    zoned = [one.agent for one in by_agent if one.zones]
    together = _together(by_agent, question_of(*zoned) if len(zoned) > 1 and not unmeasured else None)
    return Difference(first, second, question_of(*agents), tuple(by_agent), together, certificate, branches, unmeasured)


def _compare_agent(question: DecisionQuestion, agent: str, unmeasured: str) -> AgentDifference:
    unmeasured = unmeasured or explain_unstated(question)
    try:
        failing = tuple(violations(question))
    except zones.BeyondZonesError:
        return replace(_by_solver(question, agent), unmeasured=unmeasured)
    share = unmeasured or exact_share(question, failing)
    known = share if isinstance(share, ExactShare) else None
    short = [one for one in failing if not one.complete]
    reason = MANY_CELLS.format(question.budgets.max_cells) if short else ""  # why zones are missing
    spent = next((one.limit for one in short if one.nodes > one.limit), 0)
    reason = NO_NODES.format(spent, question.budgets.hint("goes on")) if spent else reason
    outcome = AgentDifference(agent, Verdict.VIOLATED, reason, failing, known, unmeasured)
    if not outcome.zones:
        return replace(outcome, verdict=Verdict.UNKNOWN if reason else Verdict.PROVED)
    shown = (example(question, zone) for zone in islice(outcome.zones, TRIED))
    state = next(filter(None, shown), None)
    if state is None and not list_whole(question.profile):  # of Z3, numbers that are whole may be any
        goal = outcome.zones[0].failing.goal
        answer = solver.decide(question.for_one_goal(goal)).answer
        state = None if answer is None else confirm_point(question, goal, answer)[0]
    if state is None:
        return replace(outcome, verdict=Verdict.UNKNOWN, reason=ONLY_REAL)
    return replace(outcome, example=state)


def example(question: DecisionQuestion, zone: Zone) -> State | None:
    """A state well inside a zone, entities apart where that can be, in which the agents of both profiles reach its
    leaves; None where the float64 state nearest to it is outside.
    """
    failing, cells = zone.failing, zone.branch[1]
    ends = [0]
    for size in failing.problem.sizes:
        ends.append(ends[-1] + size * size)
    matrices = [cells[start:end] for start, end in pairwise(ends)]
    # places in the region's box, all entities at different ones; velocities are 0 where they may be
    wanted: dict[str, Fraction] = {}
    for number, (name, (low, high)) in enumerate(question.region.box.items()):
        part = (number // 2 + 1) * SPREAD[number % 2] % 1
        place = low + round((high - low) * part, 1)
        wanted[name] = place if name.endswith((".x", ".y")) else min(max(Fraction(0), low), high)
    point = zones.middle(failing.problem, matrices, tuple(wanted), wanted)
    whole = list_whole(question.profile)
    point = {name: round_whole(value) if name in whole else value for name, value in point.items()}
    states = [nearest(point, question.region, failing.goal)]
    states += [exact_point(point, question.region, failing.goal)] if question.semantics != MACHINE else []
    for state in states:
        if _meets(question, zone, state):
            for places in range(1, MAX_PLACES):  # as few decimals as all coordinates together allow
                position = {name: round(value, places) + 0.0 for name, value in state.position.items()}
                if _meets(question, zone, rounded := State(position, state.goal)):
                    return rounded
            return state
    return None


def _meets(question: DecisionQuestion, zone: Zone, state: State) -> bool:
    """Returns True if a state of the region leads the agents of both profiles to the leaves of a zone."""
    profile = question.profile
    return inside(question.region, state) and all(
        leaf_at(profile, profile.policy(agent), state, question.semantics) == leaf
        for agent, leaf in zip(zone.failing.agents, zone.branch[0], strict=True)
    )


def _by_solver(question: DecisionQuestion, agent: str) -> AgentDifference:
    """The answer by Z3 alone: without zones and without a certificate."""
    decision = solver.decide(question)
    if decision.answer is None:
        return AgentDifference(agent, decision.verdict, decision.reason or WITHOUT_ZONES)
    state, _ = confirm_point(question, decision.goal, decision.answer)
    if state is None:
        return AgentDifference(agent, Verdict.UNKNOWN, ONLY_REAL)
    return AgentDifference(agent, Verdict.VIOLATED, WITHOUT_ZONES, example=state)


def _together(differences: Sequence[AgentDifference], question: DecisionQuestion | None) -> Span:
    """The share of states in which some agent acts differently. `question`: about those that have zones, where several
    have: also one whose zones hold no float64 state that was found.
    """
    spans = [one.span for one in differences]
    least, most = max(low for low, _ in spans), min(Fraction(1), sum((high for _, high in spans), Fraction(0)))
    if question is None or any(low != high for low, high in spans):
        return least, most
    share = measure_union(question, [one.failing for one in differences if one.zones])
    return (least, most) if share is None else (share, share)


def differing_leaves(difference: Difference, zone: Zone) -> tuple[int, int]:
    """The leaves of a zone's agent, in the first and the second profile."""
    leaves = dict(zip(zone.failing.agents, zone.branch[0], strict=True))
    agent = next(name for name in leaves if counterpart(name) in leaves)
    return leaves[agent], leaves[counterpart(agent)]
