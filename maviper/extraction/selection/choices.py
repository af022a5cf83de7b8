"""Which iterate some agents take: scored alike (the paper), by return (the released code), or raced (ours).

Does: keeps the candidates of one agent, of one team or of all agents, scores them and chooses.
Assumes: candidates meet expert opponents on the same episodes (common random numbers).
Does not: make candidates; stop an extraction (selection.py).
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence

import numpy as np

from codegen.ir import Float64, GrownTree
from maviper.episodes import measures
from maviper.episodes.measures import Estimate, score
from maviper.episodes.play import Controller
from maviper.episodes.trees import agent_policies, among
from maviper.extraction.bundles import MEMBER, RACE, RETURN, UNIFORM
from maviper.extraction.extraction import Extraction
from maviper.extraction.journal import Arrays
from maviper.extraction.outcome import joint_ratio
from maviper.extraction.selection.arena import Arena, halving, halving_by_member
from maviper.extraction.settings import Settings
from maviper.worlds import Measure
from maviper.worlds.world import Int

FINALISTS = 4  # iterates of a team whose trees its agents may exchange afterwards


class Choice(ABC):
    """The candidates of some agents, of which they take one together. Everybody else is at the expert.

    `experts`: team -> its primary measure in the common episodes, all experts; `name`: of this choice among the steps
    of a journal.
    """

    stops = True  # whether an extraction may stop because nothing gains

    def __init__(self, asked: Extraction, agents: Sequence[int], experts: Arrays, name: str = "") -> None:
        self.asked, self.world, self.agents, self.name = asked, asked.world, list(agents), name
        self.teams = [team for team in self.world.teams if set(self.world.members(team)) & set(self.agents)]
        self.base = self._estimates(experts)
        self.candidates: list[list[GrownTree]] = []
        self.best = 0  # the candidate that is the best so far, or of the first agent where each has its own
        self.rounds: list[int] = []  # the candidate that each agent takes, where each has its own
        self.found: Mapping[Measure, Estimate] = {}  # of the best: each team's primary measure

    def note_rollouts(self, values: Mapping[str, Float64]) -> None:
        """Says what the last candidate (or, before the first, the expert) did in its rollouts: `values`, each team's
        primary measure.
        """
        del values

    @abstractmethod
    def offer(self, trees: Sequence[GrownTree]) -> float | None:
        """Takes a candidate, trees in the order of `agents`; returns the ratio to the expert of the last one that was
        judged. None: nothing can be said yet.
        """

    @abstractmethod
    def choose_trees(self) -> list[list[GrownTree]]:
        """The best trees of each agent, the chosen one first; agents in the order of `agents`."""

    @property
    def race(self) -> int:
        """The number of episodes that are played once all candidates are there."""
        return 0

    @property
    def ratio(self) -> tuple[float, float]:
        """The best one's mean ratio to the expert over teams, and the half width of its 95 % interval."""
        return self._ratio(self.found)

    def _play_candidate(self, trees: Sequence[GrownTree]) -> dict[Measure, Float64]:
        """The measures and returns of the candidate's teams against experts, in each of the common episodes."""
        experts: list[Controller] = [self.asked.expert] * len(self.world.agents)
        controllers = among(self.world, agent_policies(self.world, trees, self.agents), experts)
        return measures.team_values(self.world, controllers, experts, common(self.asked), self.teams)

    def _compute_scores(self, trees: Sequence[GrownTree]) -> Arrays:
        values = self._play_candidate(trees)
        return {team: values[self.world.primary(team)] for team in self.teams}

    def _score(self, trees: Sequence[GrownTree]) -> Arrays:
        """The scores of the candidate that was added last."""
        return self.asked.journal.arrays(
            f"{len(self.candidates) - 1:04d}-score{self.name}", self._compute_scores, trees
        )

    def _estimates(self, arrays: Arrays) -> dict[Measure, Estimate]:
        return measures.estimates({self.world.primary(team): arrays[team] for team in self.teams})

    def _ratio(self, estimates: Mapping[Measure, Estimate]) -> tuple[float, float]:
        return joint_ratio(self.world, estimates, self.base, self.teams)


class Uniform(Choice):
    """Every candidate plays the same episodes."""

    _reached = -np.inf

    def offer(self, trees: Sequence[GrownTree]) -> float | None:
        """Plays the candidate and keeps it as the best if its ratio is the largest so far; see `Choice.offer`."""
        self.candidates.append(list(trees))
        estimates = self._estimates(self._score(trees))
        reached, _ = self._ratio(estimates)
        if reached > self._reached:
            self.best, self._reached, self.found = len(self.candidates) - 1, reached, estimates
        return reached

    def choose_trees(self) -> list[list[GrownTree]]:
        """Returns the best candidate's tree of each agent; see `Choice.choose_trees`."""
        return [[tree] for tree in self.candidates[self.best]]


class ByReturn(Uniform):
    """The best by its return against experts, as the released code has it; nothing stops early."""

    stops = False

    def offer(self, trees: Sequence[GrownTree]) -> float | None:
        """Plays the candidate and keeps it as the best if its return is the largest so far; see `Choice.offer`."""
        self.candidates.append(list(trees))
        arrays = self._score(trees)
        estimates, (team,) = self._estimates(arrays), self.teams
        returned = float(arrays[_return(team)].mean())
        if returned > self._reached:
            self.best, self._reached, self.found = len(self.candidates) - 1, returned, estimates
        return self._ratio(estimates)[0]

    def _compute_scores(self, trees: Sequence[GrownTree]) -> Arrays:
        values, (team,) = self._play_candidate(trees), self.teams
        return {team: values[self.world.primary(team)], _return(team): values[Measure(team, measures.RETURN)]}


def _return(team: str) -> str:
    return Measure(team, measures.RETURN).label


class Raced(Choice):
    """Best-arm identification: the iterates race on common episodes against experts. Until then, scores are those of
    the rollouts, each on episodes of its own and against trees; in the race they only help to decide the first round.
    """

    def __init__(self, asked: Extraction, agents: Sequence[int], experts: Arrays, name: str = "") -> None:
        super().__init__(asked, agents, experts, name)
        (self.team,) = self.teams
        self.warm: list[Float64] = []  # per candidate: scores in its rollouts

    def note_rollouts(self, values: Mapping[str, Float64]) -> None:
        """Keeps the values of the rollouts; see `Choice.note_rollouts`."""
        if len(self.warm) < len(self.candidates):
            self.warm.append(values[self.team])

    def offer(self, trees: Sequence[GrownTree]) -> float | None:
        """Takes a candidate; its own rollouts come later, so this judges those before it; see `Choice.offer`."""
        self.candidates.append(list(trees))
        if not self.warm:
            return None
        signed = [score(self.world.primary(self.team), known).mean() for known in self.warm]
        self.best = int(np.argmax(signed))
        self.found = self._estimates({self.team: self.warm[self.best]})
        return self._ratio(self._estimates({self.team: self.warm[-1]}))[0]

    def choose_trees(self) -> list[list[GrownTree]]:
        """Returns the trees in the order of the race; see `Choice.choose_trees`."""
        order = [int(place) for place in self.asked.journal.arrays(f"race{self.name}", self._run_race)["order"]]
        self.best = order[0]
        return [[self.candidates[place][index] for place in order] for index in range(len(self.agents))]

    def _run_race(self) -> Arrays:
        arena, warm = self._arena(), self._warm()

        def scores(arms: Int, episodes: int) -> Float64:
            return arena.scores([self.candidates[int(arm)] for arm in arms], episodes)

        return {"order": np.array(halving(scores, warm, self.race, min(FINALISTS, len(warm))))}

    def _arena(self) -> Arena:
        seeds = self.asked.settings.episodes(measures.SELECTION_SEEDS)
        return Arena(self.world, self.asked.expert, self.agents, seeds)

    def _warm(self) -> list[Float64]:
        """Of each candidate, scores in its rollouts, higher being better; the last ones may have none."""
        known = [*self.warm, *[np.zeros(0)] * (len(self.candidates) - len(self.warm))]
        return [score(self.world.primary(self.team), values) for values in known]

    @property
    def race(self) -> int:
        """The number of episodes of the race; see `Choice.race`."""
        return self.asked.settings.selection_episodes * len(self.candidates)


class Members(Raced):
    """Each member of a team gets a round of its own, judged by how the team plays: trees of all rounds race beside
    mates of other rounds, then the teams that the finalists can form.
    """

    def choose_trees(self) -> list[list[GrownTree]]:
        """Returns each agent's trees in the order of its own race; see `Choice.choose_trees`."""
        if len(self.agents) == 1:
            return super().choose_trees()
        race = self.asked.journal.arrays(f"race{self.name}", self._run_member_race)
        orders = race["orders"].tolist()
        self.rounds = [order[0] for order in orders]
        self.best = self.rounds[0]
        return [[self.candidates[place][index] for place in order] for index, order in enumerate(orders)]

    def _run_member_race(self) -> Arrays:
        arena = self._arena()

        def scores(teams: Int, episodes: int) -> Float64:
            together = [[self.candidates[int(k)][place] for place, k in enumerate(team)] for team in teams]
            return arena.scores(together, episodes)

        rng = np.random.default_rng([self.asked.settings.seed, *self.agents])
        return {"orders": np.array(halving_by_member(scores, self._warm(), len(self.agents), self.race, rng))}


def common(asked: Extraction) -> range:
    """The seeds of the episodes that all candidates play."""
    return asked.settings.episodes(measures.SELECTION_SEEDS)[: asked.settings.selection_episodes]


KINDS: Mapping[str, type[Choice]] = {UNIFORM: Uniform, RETURN: ByReturn, RACE: Raced}


def kind_of(settings: Settings) -> type[Choice]:
    """Returns the kind of choice that some settings ask for."""
    return Members if settings.selection_by == MEMBER else KINDS[settings.selection]
