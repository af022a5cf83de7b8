"""Edges that agents never cross, for claims about episodes of any length, with proofs and a certificate.

Does: moves edges outwards until no tree pushes beyond them; says who would, and from where, when they cannot be moved.
Assumes: a claim and a profile that `states.episodes.playable` lets pass; the checker says what edges ask.
Does not: sample the region (verdicts/episodes.py), or look for counterexamples.

Edges begin where episodes start. Where a tree pushes outwards near one, the edge is moved so far that this place is
harmless. The team is followed alone first: a proof then holds whatever all others do. If edges would have to be too far
away, all agents are followed together; others that still go too far are given no edges.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from itertools import product
from math import ceil
from typing import Literal

from verify.checker.episodes.certificates import UNBOUNDED, EpisodeCertificate
from verify.checker.episodes.unbounded import SLACK, EdgeReading, Edges, Side, ensure_shown
from verify.checker.reading import RejectedError
from verify.claims.claim import read_by
from verify.claims.region import Interval, goal_text
from verify.claims.wording import OwnFormula, account_of
from verify.episodes.certificates import certify, inhabitant
from verify.question import EpisodeQuestion, Question
from verify.result import Verdict
from verify.subjects import Game
from verify.zones.engine import Outcome
from verify.zones.engine import decide as decided
from verify.zones.tables import BeyondZonesError

FARTHEST_EDGE = Fraction(64)
GRID = 64  # parts of a length unit to whose multiples edges are moved
SPENT = "more than the budget of {:,} zones is needed ({:,} were visited); a larger --effort may answer"
OVERLAP = "agents stay within edges for ever, but these do not show the claim: {}; {}"


@dataclass(frozen=True)
class EdgesDecision:
    """PROVED with a certificate, which is not checked yet, or UNKNOWN with a reason. `zones`: visited."""

    verdict: Verdict
    zones: int
    reason: str = ""
    certificate: EpisodeCertificate | None = None


class _Spent(Exception):
    """The budget has ended."""


class _Far(Exception):
    """An edge would have to be too far away."""

    def __init__(self, agent: str, said: str) -> None:
        super().__init__(said)
        self.agent = agent


def decide(question: EpisodeQuestion) -> EdgesDecision:
    """Decides a claim by edges. UNKNOWN where no edges are found, with the state from which one would be crossed."""
    profile, claim = question.profile, question.claim
    team = [policy.agent for policy in profile.team(claim.team)]
    everybody = [*team, *(policy.agent for policy in profile.agents if policy.agent not in team)]
    try:
        search = _EdgeSearch(question)
    except RejectedError as error:
        return EdgesDecision(Verdict.UNKNOWN, 0, str(error))
    try:
        certificate = search.certificate(team, everybody)
        return EdgesDecision(Verdict.PROVED, search.zones, certificate=certificate)
    except _Spent:
        return EdgesDecision(Verdict.UNKNOWN, search.zones, SPENT.format(question.budgets.max_zones, search.zones))
    except (RejectedError, BeyondZonesError, _Far) as error:
        return EdgesDecision(Verdict.UNKNOWN, search.zones, str(error))


class _EdgeSearch:
    """The search of one question. `zones`: visited."""

    def __init__(self, question: EpisodeQuestion) -> None:
        self._question, self.zones = question, 0
        self._reading = EdgeReading(question.profile, question.region)
        self._outcomes: dict[tuple[str, bool, tuple[tuple[str, Interval], ...]], Outcome] = {}

    def certificate(self, team: list[str], everybody: list[str]) -> EpisodeCertificate:
        """The certificate, of edges of the team alone or of all agents. _Far, _Spent, RejectedError."""
        try:
            return self._build_certificate(team)
        except (_Far, RejectedError):
            profile, others = self._question.profile, {*everybody} - {*team}
            if not any(read_by(profile.policy(agent)) & others for agent in team):
                raise
        followed = everybody
        while True:
            try:
                return self._build_certificate(followed)
            except _Far as far:
                if far.agent in team:
                    raise
                followed = [agent for agent in followed if agent != far.agent]

    def _build_certificate(self, followed: list[str]) -> EpisodeCertificate:
        profile, claim, region = self._question.profile, self._question.claim, self._question.region
        edges = {name: region.box[name] for name in self._reading.axes if name.rpartition(".")[0] in followed}
        proofs = self._proofs(edges)
        self._reading.ensure(edges)
        try:
            ensure_shown(profile, claim, region, edges)
        except RejectedError as error:
            ends = {name: f"[{float(low):.4g}, {float(high):.4g}]" for name, (low, high) in edges.items()}
            words = ", ".join(f"{name} in {each}" for name, each in ends.items())
            raise RejectedError(OVERLAP.format(error, words)) from None
        return certify(self._question, UNBOUNDED, inhabitant(profile, region), Edges(edges, nest_proofs(proofs)))

    def _proofs(self, edges: dict[str, Interval]) -> dict[Side, bytes]:
        """The proofs that nobody crosses edges, once they have been moved outwards. _Far, _Spent."""
        moving, proofs = True, dict[Side, bytes]()
        while moving:
            moving = False
            proofs.clear()
            for name, upper in product(edges, (False, True)):
                outcome = self._ask_edge(edges, name, upper)
                while outcome is not None and outcome.verdict is not Verdict.PROVED:
                    self._move(edges, name, upper, outcome)
                    moving = True
                    outcome = self._ask_edge(edges, name, upper)
                if outcome is not None:  # else no action pushes that way
                    proofs |= {(name, upper, goal): proof for goal, proof in outcome.proofs.items()}
        return proofs

    def _ask_edge(self, edges: dict[str, Interval], name: str, upper: bool) -> Outcome | None:
        """Asks whether a tree pushes beyond an edge. _Spent."""
        question, harmless = self._question, self._reading.harmless(name, upper)
        if harmless is None:
            return None
        key = name, upper, tuple(edges.items())
        if key not in self._outcomes:
            left = question.budgets.max_zones - self.zones
            if left <= 0:
                raise _Spent
            profile, region = question.profile, self._reading.danger(edges, name, upper)
            claim = OwnFormula(profile.policy(name.rpartition(".")[0]).team, statement=harmless)
            asked = Question(Game(profile), claim, region, question.semantics, question.budgets)
            outcome = decided(asked.spending(max_nodes=left))
            self.zones += outcome.nodes
            if outcome.verdict is Verdict.UNKNOWN:
                raise _Spent
            self._outcomes[key] = outcome
        return self._outcomes[key]

    def _move(self, edges: dict[str, Interval], name: str, upper: bool, outcome: Outcome) -> None:
        """Moves an edge so far that what happened is harmless. _Far."""
        assert outcome.state is not None
        axis, out = self._reading.axes[name], 1 if upper else -1
        strongest, fastest = axis.strongest(out), axis.fastest(out)
        reach = axis.coasting * (strongest + fastest) + 2 * SLACK
        place = out * outcome.state[name]
        low, high = edges[name]
        edge = max(Fraction(ceil((place + reach) * GRID), GRID), (high if upper else -low) + Fraction(1, GRID))
        claim, own = self._question.claim, name.rpartition(".")[0]
        most, farthest = FARTHEST_EDGE, account_of(claim).farthest
        if farthest is not None and self._question.profile.policy(own).team == claim.team:
            most = farthest - SLACK
        if place + reach > most:
            rest = place + axis.coasting * (fastest + strongest)
            raise _Far(own, self._describe_crossing(name, out, outcome, most, rest))
        edge = min(edge, most)
        edges[name] = (low, edge) if upper else (-edge, high)

    def _describe_crossing(self, name: str, out: int, outcome: Outcome, most: Fraction, rest: Fraction) -> str:
        """Describes who may cross an edge, from where, and where that leads."""
        agent, _, axis = name.rpartition(".")
        policy, state = self._question.profile.policy(agent), outcome.state or {}
        pushing = " or ".join(policy.actions[action].name for action in self._reading.axes[name].outward(out))
        read = {*read_by(policy), agent, *([outcome.goal] if outcome.goal else [])}
        seen = [f"{place} = {float(value):.4g}" for place, value in state.items() if place.rpartition(".")[0] in read]
        goal = f", goal {outcome.goal}" if outcome.goal else ""
        may = f"{agent} may leave {float(most):.4g} along {axis}: it goes {pushing} at {', '.join(seen)}{goal}"
        return f"{may}; at its top speed it then comes to rest at {axis} = {out * float(rest):.4g}"


def nest_proofs(proofs: Mapping[Side, bytes]) -> dict[str, dict[Literal["lower", "upper"], dict[str, bytes]]]:
    """Proofs as certificates have them."""
    nested: dict[str, dict[Literal["lower", "upper"], dict[str, bytes]]] = {}
    for (name, upper, goal), proof in proofs.items():
        nested.setdefault(name, {}).setdefault("upper" if upper else "lower", {})[goal_text(goal)] = proof
    return nested
