"""How much of a region's starts a claim about episodes fails from: bounds of the share, by volume.

Does: follows the team's agents one after the other, or together where any matching will do; where that takes too much,
  bounds the share by what each agent does alone.
Assumes: a world without contacts; `reaches` or `covers`, over starts at rest, goals equally likely.
Does not: sample starts to count them; give one number where only bounds are known.

Starts nearer to an edge of a cell than roundings reach are counted on neither side (sure.py), so the bounds hold for
the deployed arithmetic. Where no budget ends, nothing else lies between them.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from math import prod
from typing import NamedTuple

from codegen import ir
from verify.checker.episodes.reading import Matching, RejectedError, matchings
from verify.claims.episodes import Arrival
from verify.claims.verifiable import read_by
from verify.extent.guaranteed import GuaranteedEpisode
from verify.extent.sure import Following, Measured, NoShareError
from verify.question import EpisodeQuestion, Question
from verify.result import Verdict
from verify.states.episodes import at_rest, find_met_ways, play
from verify.states.shares import SAMPLE_SEED
from verify.states.state import sample
from verify.zones.volume import DEFAULT_FACES

SAMPLES = 2_000  # that say which matching to try first
NOT_APART = "it is counted for reaches and covers only"
NOBODY = "the region holds no start at rest"


@dataclass(frozen=True)
class StartShare:
    """Bounds of the share of starts that fail; or `reason`, why there are none."""

    least: Fraction = Fraction(0)
    most: Fraction = Fraction(1)
    exact: bool = False  # nothing but starts within roundings of an edge lies between them
    answers: int = 0  # looked at
    budget: int = 0
    spent: str = ""  # which budget ended: of ANSWERS, of FACES
    reason: str = ""


class ShareBounds(NamedTuple):
    """Of the share that fails for a goal."""

    least: Fraction
    most: Fraction
    spent: str  # the budget that ended in the search that they rest on; where none did, they are as near as can be


def start_share(question: EpisodeQuestion, verdict: Verdict, faces: int = DEFAULT_FACES) -> StartShare:
    """The share of starts from which a claim with that verdict fails. `faces`: of volumes, for each search."""
    claim = question.claim.arrival
    if verdict is Verdict.PROVED:
        return StartShare(most=Fraction(0), exact=True)
    if verdict is Verdict.VACUOUS or claim is None:
        return StartShare(reason=NOBODY if verdict is Verdict.VACUOUS else NOT_APART)
    try:
        return _Share(question.about(claim), faces).share()
    except (RejectedError, NoShareError) as error:
        return StartShare(reason=str(error))


class _Share:
    """The share of one question."""

    def __init__(self, question: Question[Arrival], faces: int) -> None:
        self._question, self._faces, self._left = question, faces, 0
        self._ways = self._order_matchings(matchings(question.profile, question.claim))
        self._answers = 0

    def share(self) -> StartShare:
        """The mean over goals; one search stands for all where nobody who is followed reads the goal."""
        profile, budget = self._question.profile, self._question.budgets.max_zones
        team = [agent for agent, _ in self._ways[0]]
        read = any(ir.GOAL in read_by(profile.policy(agent)) for agent in self._acting(team))
        asked = self._question.goals if read else (None,)
        bounds: list[ShareBounds] = []
        for goal in asked:
            self._left = budget // len(asked)
            bounds.append(self._bound_matching(goal, self._ways[0]) if len(self._ways) == 1 else self._bound_any(goal))
        least = sum((each.least for each in bounds), Fraction(0)) / len(asked)
        most = sum((each.most for each in bounds), Fraction(0)) / len(asked)
        spent = _first_spent(bounds)
        return StartShare(least, most, not spent, self._answers, budget, spent)

    def _bound_any(self, goal: str | None) -> ShareBounds:
        """The team fails where it fails every matching, and where one of its agents is at no landmark; what it does
        together is followed with the answers that this leaves.
        """
        first = self._bound_matching(goal, self._ways[0])
        marks = dict.fromkeys(mark for way in self._ways for _, mark in way)
        nowhere = [self._measure(goal, [[((agent, mark),) for mark in marks]]).fails for agent, _ in self._ways[0]]
        whole = self._measure(goal, [self._ways])
        return ShareBounds(max(whole.fails, *nowhere), min(1 - whole.holds, first.most), whole.spent)

    def _bound_matching(self, goal: str | None, way: Matching) -> ShareBounds:
        """The team fails a matching where an agent fails its own landmark; groups that share nothing do so
        independently.
        """
        groups = [self._bound_group(goal, group) for group in self._independent(goal, way)]
        least = 1 - prod((1 - group.least for group in groups), start=Fraction(1))
        most = 1 - prod((1 - group.most for group in groups), start=Fraction(1))
        return ShareBounds(least, most, _first_spent(groups))

    def _bound_group(self, goal: str | None, pairs: Matching) -> ShareBounds:
        """A group fails where one of its agents fails alone, and no more often than all of them together."""
        alone = [self._measure(goal, [[(pair,)]]) for pair in pairs] if len(pairs) > 1 else []
        # each agent arrives at a time of its own, so they are followed in turn
        whole = self._measure(goal, [[(pair,)] for pair in pairs])
        least, most = max(whole.fails, *(one.fails for one in alone), Fraction(0)), 1 - whole.holds
        most = min(most, sum((1 - one.holds for one in alone), Fraction(0))) if alone else most
        return ShareBounds(least, most, whole.spent)

    def _measure(self, goal: str | None, passes: Sequence[Sequence[Matching]]) -> Measured:
        """The shares of starts that fail and hold, when `passes` of agents are followed, one after the other. Each
        search may take half of the answers that are left.
        """
        question, readings = self._question, list[GuaranteedEpisode]()
        for allowed in passes:
            acting = self._acting(agent for way in allowed for agent, _ in way)
            readings.append(GuaranteedEpisode(question.profile, question.claim, question.region, goal, acting, allowed))
        measured = Following(readings, self._left // 2, self._faces).measure_shares()
        self._left -= measured.looked
        self._answers += measured.looked
        return measured

    def _acting(self, agents: Iterable[str]) -> list[str]:
        """The agents with those whom they read, and so on, in the profile's order."""
        profile, acting, waiting = self._question.profile, set[str](), list(agents)
        everybody = [policy.agent for policy in profile.agents]
        while waiting:
            agent = waiting.pop()
            acting.add(agent)
            waiting += (read_by(profile.policy(agent)) & set(everybody)) - acting
        return [agent for agent in everybody if agent in acting]

    def _independent(self, goal: str | None, way: Matching) -> list[Matching]:
        """The pairs in groups of which the starts that matter have no coordinate in common, and no bound joins them."""
        region = self._question.region
        links = [{name.rpartition(".")[0] for name in pair[:2]} for pair in region.differences]
        links += [set(pair[:2]) for pair in region.apart]
        groups: list[tuple[set[str], Matching]] = []
        for pair in way:
            acting = self._acting(pair[:1])
            read = frozenset[str]().union(*(read_by(self._question.profile.policy(agent)) for agent in acting))
            mine = {*acting, pair[1], *(read - {ir.GOAL}), *([goal] if goal and ir.GOAL in read else [])}
            own = {entity for entity in mine if not self._is_fixed(entity)}
            while any(link & own and not link <= own for link in links):
                own = own.union(*(link for link in links if link & own))
            meeting = [group for group in groups if group[0] & own]
            groups = [group for group in groups if not group[0] & own]
            pairs = tuple(other for _, others in meeting for other in others)
            groups.append((own.union(*(entities for entities, _ in meeting)), (*pairs, pair)))
        return [pairs for _, pairs in groups]

    def _is_fixed(self, entity: str) -> bool:
        return all(low == high for low, high in (self._question.region.box[f"{entity}.{axis}"] for axis in "xy"))

    def _order_matchings(self, ways: list[Matching]) -> list[Matching]:
        """The matchings, those first that most sampled episodes end in."""
        if len(ways) == 1:
            return ways
        question = self._question
        coordinates, _ = sample(at_rest(question.region), question.profile.world, SAMPLES, SAMPLE_SEED)
        episode, _ = play(question.profile, coordinates, question.claim.steps)

        def often(way: Matching) -> int:
            named = replace(question.claim, landmarks=tuple(mark for _, mark in way))
            return int(find_met_ways(question.profile, named, episode).sum())

        return sorted(ways, key=often, reverse=True)


def _first_spent(bounds: Iterable[ShareBounds]) -> str:
    return next((each.spent for each in bounds if each.spent), "")
