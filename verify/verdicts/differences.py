"""Where two profiles act differently, exactly, or the proof that they act alike.

Does: for each agent every zone of states in which the profiles act differently, with their exact share and an example;
  for agents without such a zone a certificate, which the checker accepted.
Assumes: profiles that can be compared (claims/relations.py).
Does not: write reports; play episodes.

The profiles are read as one team with twice the agents (`pair_profiles`), and "acts alike" is a claim about it. So the
engines for claims about single decisions answer: zones, and Z3 where a test bounds no difference of two coordinates.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import islice, pairwise

from codegen.ir import PolicyProfile
from verify.checker.decisions import DecisionCertificate, check_certificate
from verify.claims.formula import Formula
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
from verify.verdicts.decisions import ONLY_REAL
from verify.verdicts.memories import list_whole, round_whole
from verify.verdicts.opinions import certify
from verify.zones import engine as zones
from verify.zones.search import Branch

TRIED = 64  # zones in which a float64 state is looked for, before Z3 is asked for one
SPREAD = Fraction(755, 1000), Fraction(570, 1000)  # steps of a sequence that fills a square evenly
NO_NODES, NO_CELLS = "the search ended after {:,} nodes; {}", "there are more than {:,} zones"
MANY_CELLS = f"{NO_CELLS}; a larger --effort finds more"
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
    reason = _ending(question, failing)
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


def _ending(question: DecisionQuestion, failing: Sequence[Failing]) -> str:
    """Why zones are missing; "" where none is."""
    short = [one for one in failing if not one.complete]
    if not short:
        return ""
    spent = next((one.limit for one in short if one.nodes > one.limit), 0)
    if spent:
        return NO_NODES.format(spent, question.budgets.hint("goes on"))
    return MANY_CELLS.format(question.budgets.max_cells)


def example(question: DecisionQuestion, zone: Zone) -> State | None:
    """A state well inside a zone, entities apart where that can be, in which the agents of both profiles reach its
    leaves; None where the float64 state nearest to it is outside.
    """
    failing, cells = zone.failing, zone.branch[1]
    ends = [0]
    for size in failing.problem.sizes:
        ends.append(ends[-1] + size * size)
    matrices = [cells[start:end] for start, end in pairwise(ends)]
    wanted = _spread(question.region)
    point = zones.middle(failing.problem, matrices, tuple(wanted), wanted)
    whole = list_whole(question.profile)
    point = {name: round_whole(number) if name in whole else number for name, number in point.items()}
    for state in _candidates(question, point, failing.goal):
        if _meets(question, zone, state):
            for places in range(1, MAX_PLACES):  # as few decimals as all coordinates together allow
                position = {name: round(value, places) + 0.0 for name, value in state.position.items()}
                if _meets(question, zone, rounded := State(position, state.goal)):
                    return rounded
            return state
    return None


def _spread(region: Region) -> dict[str, Fraction]:
    """Coordinate -> a place in the region's box, all entities at different ones; velocities are 0 where they may be."""
    places: dict[str, Fraction] = {}
    for number, (name, (low, high)) in enumerate(region.box.items()):
        part = (number // 2 + 1) * SPREAD[number % 2] % 1
        place = low + round((high - low) * part, 1)
        places[name] = place if name.endswith((".x", ".y")) else min(max(Fraction(0), low), high)
    return places


def _candidates(question: DecisionQuestion, point: dict[str, Fraction], goal: str | None) -> Iterator[State]:
    yield nearest(point, question.region, goal)
    if question.semantics != MACHINE:
        yield exact_point(point, question.region, goal)


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
