"""Which iterate becomes the profile: scored alike (the paper), by return (the released code), or raced (ours).

Does: keeps candidates and their scores, knows when to stop early, chooses.
Assumes: candidates meet expert opponents on the same episodes (common random numbers).
Does not: make candidates.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from codegen import ir
from codegen.ir import Float64, GrownTree
from maviper.episodes import measures
from maviper.episodes.measures import Estimate
from maviper.episodes.play import Controller
from maviper.episodes.trees import agent_policies, among
from maviper.experts.expert import Expert
from maviper.extraction.journal import Arrays, Journal
from maviper.extraction.outcome import joint_ratio
from maviper.extraction.selection.arena import Arena, halving, score
from maviper.extraction.settings import RACE, RETURN, UNIFORM, Settings
from maviper.worlds import Measure, World
from maviper.worlds.world import Int

FINALISTS = 4  # iterates of a team whose trees its agents may exchange afterwards
EXTRACTING, REFINING = "extracting", "refining"


@dataclass(frozen=True)
class Progress:
    """What one step gave. Scores: the mean over teams of the ratio to the expert while extracting, and the primary
    measure, higher being better, while refining.
    """

    stage: str
    done: int
    total: int
    score: float  # of this step's candidate
    best: float
    measured: Mapping[str, Estimate]  # team -> primary measure of the best, against expert opponents
    fidelity: float | None  # share of the step's decisions that were the expert's
    leaves: int  # of the best, all agents
    growth: Mapping[str, float] = field(default_factory=dict)  # figures of the step's growth, where teams grow jointly

    @property
    def line(self) -> dict[str, float | int | str | None]:
        """As one line of a metrics file."""
        found: dict[str, float | int | str | None] = {"stage": self.stage, "step": self.done, "score": self.score}
        found |= {"best": self.best}
        for team, estimate in self.measured.items():
            low, high = estimate.interval
            found |= {f"best {team}": estimate.value, f"best {team} low": low, f"best {team} high": high}
        return found | {"fidelity": self.fidelity, "leaves": self.leaves, **self.growth}


OnProgress = Callable[[Progress], None]


def count_leaves(trees: Sequence[GrownTree]) -> int:
    """Leaves of some trees together."""
    return sum(int((tree.feature == ir.NO_FEATURE).sum()) for tree in trees)


class Selection(ABC):
    """The candidates of an extraction: trees of all agents, or of some `agents` among experts."""

    def __init__(
        self,
        world: World,
        expert: Expert,
        settings: Settings,
        journal: Journal,
        on_progress: OnProgress,
        agents: Sequence[int] | None = None,
    ) -> None:
        self.world, self.expert, self.settings, self.journal = world, expert, settings, journal
        self.on_progress = on_progress
        self.agents = list(range(len(world.agents)) if agents is None else agents)
        self.teams = [team for team in world.teams if set(world.members(team)) & set(self.agents)]
        self.experts: list[Controller] = [expert] * len(world.agents)
        self.seeds = settings.episodes(measures.SELECTION_SEEDS)[: settings.selection_episodes]
        arrays = journal.arrays("expert", lambda: self._labelled(measures.values(world, self.experts, self.seeds)))
        self.base = self._estimates(arrays)
        self.candidates: list[list[GrownTree]] = []
        self.fidelity: float | None = None
        self.growth: Mapping[str, float] = {}
        self._reference, self._since_gain = -np.inf, 0
        self._begin()

    @abstractmethod
    def _begin(self) -> None:
        """Sets up what a way of selecting keeps besides."""

    def members(self, team: str) -> list[int]:
        """The team's agents that candidates have trees for."""
        return [agent for agent in self.world.members(team) if agent in self.agents]

    def met(self, values: Mapping[str, Float64], fidelity: float) -> None:
        """Says what the last candidate (or, before the first, the expert) did in its rollouts: `values`, each team's
        primary measure; `fidelity`, the share of actions that were the expert's.
        """
        del values
        self.fidelity = fidelity

    def grown(self, figures: Mapping[str, float]) -> None:
        """Says by name how the growth of the next candidate went."""
        self.growth = figures

    @abstractmethod
    def offer(self, trees: Sequence[GrownTree]) -> bool:
        """Takes a candidate, trees in the order of `agents`; returns whether it is time to stop: no gain above the
        interval for `patience` of them.
        """

    @abstractmethod
    def chosen(self) -> list[list[GrownTree]]:
        """The best trees of each agent, the chosen one first; agents in the order of `agents`."""

    @property
    @abstractmethod
    def facts(self) -> dict[str, int]:
        """What the provenance says of the selection."""

    def _played(self, trees: Sequence[GrownTree]) -> dict[Measure, Float64]:
        """The measures and returns of the candidate's teams against experts, in each of the common episodes."""
        controllers = among(self.world, agent_policies(self.world, trees, self.agents), self.experts)
        return measures.team_values(self.world, controllers, self.experts, self.seeds, self.teams)

    def _labelled(self, found: Mapping[Measure, Float64]) -> Arrays:
        return {team: found[self.world.primary(team)] for team in self.teams}

    def _estimates(self, arrays: Mapping[str, Float64]) -> dict[Measure, Estimate]:
        return measures.estimates({self.world.primary(team): arrays[team] for team in self.teams})

    def _ratio(self, found: Mapping[Measure, Estimate]) -> tuple[float, float]:
        """The mean ratio of the teams to the expert, and the half width of its 95 % interval."""
        return joint_ratio(self.world, found, self.base, self.teams)

    def _judged(self, score: float, found: Mapping[Measure, Estimate], leaves: int) -> bool:
        """Says how the search stands after a candidate with that score; returns whether patience has run out. `found`:
        of the best so far.
        """
        best, half_width = self._ratio(found)
        self._since_gain += 1
        if best > self._reference:
            self._reference, self._since_gain = best + half_width, 0
        measured = {measure.team: estimate for measure, estimate in found.items()}
        done, total = len(self.candidates), self.settings.iterations
        shown = Progress(EXTRACTING, done, total, score, best, measured, self.fidelity, leaves, self.growth)
        self.on_progress(shown)
        return self._since_gain >= self.settings.patience


class Uniform(Selection):
    """Every candidate plays the same episodes; one iteration's trees are taken for all agents."""

    def _begin(self) -> None:
        self.best, self.score = -1, -np.inf

    def offer(self, trees: Sequence[GrownTree]) -> bool:
        """As `Selection.offer`."""
        place = len(self.candidates)
        self.candidates.append(list(trees))
        found = self._estimates(self.journal.arrays(f"{place:04d}-score", self._scored, trees))
        reached, _ = self._ratio(found)
        if reached > self.score:
            self.best, self.score, self._found = place, reached, found
        return self._judged(reached, self._found, count_leaves(self.candidates[self.best]))

    def _scored(self, trees: Sequence[GrownTree]) -> Arrays:
        return self._labelled(self._played(trees))

    def chosen(self) -> list[list[GrownTree]]:
        """As `Selection.chosen`."""
        return [[tree] for tree in self.candidates[self.best]]

    @property
    def facts(self) -> dict[str, int]:
        """As `Selection.facts`."""
        return {"stopped_after": len(self.candidates), "best_iteration": self.best + 1}


class _EachTeams(Selection):
    """Each team takes its own best iteration."""

    def _begin(self) -> None:
        self.best = dict.fromkeys(self.teams, 0)

    def _trees(self, candidate: int, team: str) -> list[GrownTree]:
        return [self.candidates[candidate][self.agents.index(agent)] for agent in self.members(team)]

    @property
    def facts(self) -> dict[str, int]:
        """As `Selection.facts`."""
        best = {f"best_iteration_{team}": place + 1 for team, place in self.best.items()}
        return {"stopped_after": len(self.candidates), **best}


class ByReturn(_EachTeams):
    """Each team's best iteration by its return against experts, as the released code has it; nothing stops early."""

    def _begin(self) -> None:
        super()._begin()
        self._returned = dict.fromkeys(self.teams, -np.inf)  # of the best
        self._found: dict[str, Float64] = {}

    def offer(self, trees: Sequence[GrownTree]) -> bool:
        """As `Selection.offer`."""
        place = len(self.candidates)
        self.candidates.append(list(trees))
        found = self.journal.arrays(f"{place:04d}-score", self._scored, trees)
        for team in self.teams:
            returned = float(found[_return(team)].mean())
            if returned > self._returned[team]:
                self.best[team], self._returned[team], self._found[team] = place, returned, found[team]
        leaves = count_leaves(self.candidates[place])
        self._judged(self._ratio(self._estimates(found))[0], self._estimates(self._found), leaves)
        return False

    def _scored(self, trees: Sequence[GrownTree]) -> Arrays:
        found = self._played(trees)
        returns = {_return(team): found[Measure(team, measures.RETURN)] for team in self.teams}
        return {**self._labelled(found), **returns}

    def chosen(self) -> list[list[GrownTree]]:
        """As `Selection.chosen`."""
        places = {agent: self.best[team] for team in self.teams for agent in self.members(team)}
        return [[self.candidates[places[agent]][index]] for index, agent in enumerate(self.agents)]


def _return(team: str) -> str:
    return Measure(team, measures.RETURN).label


class Raced(_EachTeams):
    """Best-arm identification: each team's iterates race on common episodes against experts, and each team takes its
    own best. Until then, scores are those of the rollouts, each on episodes of its own and against trees; in the race
    they only help to decide the first round.
    """

    def _begin(self) -> None:
        super()._begin()
        self.warm: list[dict[str, Float64]] = []  # per candidate: team -> scores in its rollouts

    def met(self, values: Mapping[str, Float64], fidelity: float) -> None:
        """As `Selection.met`."""
        super().met(values, fidelity)
        if len(self.warm) < len(self.candidates):
            self.warm.append({team: values[team] for team in self.teams})

    def offer(self, trees: Sequence[GrownTree]) -> bool:
        """As `Selection.offer`; the candidate's own rollouts come later, so this judges those before it."""
        self.candidates.append(list(trees))
        if not self.warm:
            return False
        for team in self.teams:
            signed = [score(self.world.primary(team), known[team]).mean() for known in self.warm]
            self.best[team] = int(np.argmax(signed))
        found = self._estimates({team: self.warm[self.best[team]][team] for team in self.teams})
        leaves = count_leaves([tree for team in self.teams for tree in self._trees(self.best[team], team)])
        return self._judged(self._ratio(self._estimates(self.warm[-1]))[0], found, leaves)

    def chosen(self) -> list[list[GrownTree]]:
        """As `Selection.chosen`."""
        found: list[list[GrownTree]] = [[] for _ in self.agents]
        for team in self.teams:
            step = f"race-{list(self.world.teams).index(team)}"  # a user's team may have any name
            order = [int(place) for place in self.journal.arrays(step, self._raced, team)["order"]]
            self.best[team] = order[0]
            for candidate in order:
                for agent, tree in zip(self.members(team), self._trees(candidate, team), strict=True):
                    found[self.agents.index(agent)].append(tree)
        return found

    def _raced(self, team: str) -> Arrays:
        seeds = self.settings.episodes(measures.SELECTION_SEEDS)
        arena = Arena(self.world, self.expert, self.members(team), seeds)
        nothing = {name: np.zeros(0) for name in self.teams}
        known = [*self.warm, *[nothing] * (len(self.candidates) - len(self.warm))]
        warm = [score(self.world.primary(team), values[team]) for values in known]

        def scores(arms: Int, episodes: int) -> Float64:
            return arena.scores([self._trees(int(arm), team) for arm in arms], episodes)

        episodes = self.settings.selection_episodes * len(self.candidates)
        return {"order": np.array(halving(scores, warm, episodes, min(FINALISTS, len(known))))}


KINDS: Mapping[str, type[Selection]] = {UNIFORM: Uniform, RETURN: ByReturn, RACE: Raced}
