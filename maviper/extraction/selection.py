"""Which iterate agents, teams or all together take: scored alike (the paper), by return (released), or raced (ours).

Does: keeps the candidates of one agent, of one team or of all agents, scores them and chooses; says how the search
  stands; knows when to stop early.
Assumes: candidates with a tree for each of its agents, which meet expert opponents on the same episodes (common random
  numbers).
Does not: make candidates.
"""

import time
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence

import numpy as np

from codegen.ir import Float64, GrownTree
from codegen.wording import format_count
from maviper.episodes import measures
from maviper.episodes.measures import Estimate, score
from maviper.episodes.play import Controller
from maviper.episodes.trees import agent_policies, among
from maviper.extraction.arena import Arena, halving, halving_by_member
from maviper.extraction.extraction import Extraction, OutOfTime, Running, joint_ratio
from maviper.extraction.journal import EXPERT_STEP, EXTRACTING, SELECTING, Arrays, Progress, Underway, count_leaves
from maviper.extraction.settings import AGENT, EXPERTS, MEMBER, RACE, RETURN, TEAM, UNIFORM, group_agents
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
    """Every candidate plays the same episodes; the best has the largest ratio."""

    _reached = -np.inf

    def offer(self, trees: Sequence[GrownTree]) -> float | None:
        """Plays the candidate and keeps it if it is the best so far; see `Choice.offer`."""
        self.candidates.append(list(trees))
        scores = self._score(trees)
        estimates = self._estimates(scores)
        ratio, _ = self._ratio(estimates)
        reached = self._judge(scores, ratio)
        if reached > self._reached:
            self.best, self._reached, self.found = len(self.candidates) - 1, reached, estimates
        return ratio

    def _judge(self, scores: Arrays, ratio: float) -> float:
        """The number by which a candidate is the best."""
        del scores
        return ratio

    def choose_trees(self) -> list[list[GrownTree]]:
        """Returns the best candidate's tree of each agent; see `Choice.choose_trees`."""
        return [[tree] for tree in self.candidates[self.best]]


class ByReturn(Uniform):
    """The best by its return against experts, as the released code has it; nothing stops early."""

    stops = False

    def _judge(self, scores: Arrays, ratio: float) -> float:
        return float(scores[_return(self.teams[0])].mean())

    def _compute_scores(self, trees: Sequence[GrownTree]) -> Arrays:
        values, (team,) = self._play_candidate(trees), self.teams
        return {team: values[self.world.primary(team)], _return(team): values[Measure(team, measures.RETURN)]}


def _return(team: str) -> str:
    return Measure(team, measures.RETURN).label


class Raced(Choice):
    """Best-arm identification: the iterates race on common episodes against experts. Until then, scores are those of
    the rollouts, each on episodes of its own and against trees; in the race they only help to decide the first round.
    In a world of others, where episodes take long, they count in all of it if nobody else's trees played in them.
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
        arena, warm, settings = self._arena(), self._warm(), self.asked.settings

        def scores(arms: Int, episodes: int) -> Float64:
            return arena.scores([self.candidates[int(arm)] for arm in arms], episodes)

        if self.world.games is None:
            return {"order": np.array(halving(scores, warm, self.race, min(FINALISTS, len(warm))))}
        # whether the race has the line-up of the rollouts: these agents by their trees, everybody else an expert
        groups = group_agents(self.world, settings.rollouts_by, range(len(self.world.agents)))
        alike = settings.rollouts_by != EXPERTS and self.agents in groups
        finalists = min(FINALISTS, len(warm)) if settings.refinement else 1
        return {"order": np.array(halving(scores, warm, self.race, finalists, alike))}

    def _arena(self) -> Arena:
        seeds = self.asked.settings.episodes(measures.SELECTION_SEEDS)
        return Arena(self.world, self.asked.expert, self.agents, seeds)

    def _warm(self) -> list[Float64]:
        """Of each candidate, scores in its rollouts, higher being better; the last ones may have none."""
        known = [*self.warm, *[np.zeros(0)] * (len(self.candidates) - len(self.warm))]
        return [score(self.world.primary(self.team), values) for values in known]

    @property
    def race(self) -> int:
        """The number of episodes of the race, none of one candidate; see `Choice.race`."""
        return self.asked.settings.selection_episodes * len(self.candidates) * (len(self.candidates) > 1)


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


def explain_stop(told: Mapping[str, str | int | float]) -> str:
    """Why an extraction stopped early, in words. `told`: what its profile says of the training."""
    patience = f"no significant improvement in {format_count(int(told['patience']), 'round')}"
    if "max_seconds" in told:
        patience = f"{told['max_seconds']:g} s are over (--max-seconds), or {patience}"
    if "enough" in told:
        return f"a ratio of {told['enough']} to the expert is reached (--set enough), or {patience} (--set patience)"
    return f"{patience} (--set patience)"


class Selection:
    """The choices of some `agents` that are extracted in the same rounds."""

    def __init__(self, asked: Extraction, agents: Sequence[int], running: Running) -> None:
        self.asked, self.agents, self.running = asked, list(agents), running
        settings, self.offered = asked.settings, 0
        self.underway(0.0, "playing")
        experts = asked.journal.arrays(EXPERT_STEP, self._experts)
        units = group_agents(asked.world, settings.selection_by, agents)
        names = [""] if len(units) == 1 else [f"-{place}" for place in range(len(units))]
        kind = Members if settings.selection_by == MEMBER else KINDS[settings.selection]
        self.choices = [kind(asked, unit, experts, name) for unit, name in zip(units, names, strict=True)]
        self.fidelity: float | None = None
        self.growth: Mapping[str, float] = {}
        self._reference, self._since_gain = -np.inf, 0
        self._since = time.monotonic()  # the last candidate

    def _experts(self) -> Arrays:
        asked = self.asked
        experts, seeds = [asked.expert] * len(asked.world.agents), common(asked)
        values = measures.values(asked.world, experts, seeds, lambda: asked.is_over(asked.settings.rollouts))
        return {team: values[asked.world.primary(team)] for team in asked.world.teams}

    def note_rollouts(self, values: Mapping[str, Float64], fidelity: float) -> None:
        """Says what the last candidate (or, before the first, the expert) did in its rollouts: `values`, each team's
        primary measure; `fidelity`, the share of actions that were the expert's.
        """
        self.fidelity = fidelity
        for choice in self.choices:
            choice.note_rollouts(values)

    def cut(self) -> bool:
        """Returns True if the first round, from which there must be some trees, is to end with the episodes that were
        played so far, since the time is over. OutOfTime in later ones.
        """
        over = self.asked.is_over(sum(choice.race for choice in self.choices))
        if over and self.offered:
            raise OutOfTime
        return over

    def underway(self, share: float, doing: str) -> None:
        """Says that a share of the work on the next candidate is done."""
        done, total = self.offered + share, self.asked.settings.iterations
        self.running.on_underway(Underway(done, total, doing, part=self.running.part))

    def note_growth(self, figures: Mapping[str, float]) -> None:
        """Says by name how the growth of the next candidate went."""
        self.growth = figures

    def offer(self, trees: Sequence[GrownTree]) -> bool:
        """Takes a candidate, trees in the order of `agents`; returns whether it is time to stop: the best of all
        choices are good enough on average, the time is over, or nothing gained more than the interval for
        `patience` candidates.
        """
        settings = self.asked.settings
        self.offered += 1
        mine = dict(zip(self.agents, trees, strict=True))
        judged = [choice.offer([mine[agent] for agent in choice.agents]) for choice in self.choices]
        scores = [ratio for ratio in judged if ratio is not None]
        over = self.asked.is_over(sum(choice.race for choice in self.choices), since=self._since)
        self._since = time.monotonic()
        if not scores:
            return over
        ratios, widths = zip(*(choice.ratio for choice in self.choices), strict=True)
        best, half_width = float(np.mean(ratios)), float(np.sqrt(np.square(widths).sum()) / len(widths))
        self._since_gain += 1
        if best > self._reference:
            self._reference, self._since_gain = best + half_width, 0
        measured = {
            self._name(choice, measure.team): estimate
            for choice in self.choices
            for measure, estimate in choice.found.items()
        }
        leaves = sum(count_leaves(choice.candidates[choice.best]) for choice in self.choices)
        told = best, measured, self.fidelity, leaves, self.growth, self.running.part
        score = float(np.mean(scores))
        self.running.on_progress(Progress(EXTRACTING, self.offered, settings.iterations, score, *told))
        if over or (settings.enough and best - half_width >= settings.enough):
            return True
        return self._since_gain >= settings.patience and all(choice.stops for choice in self.choices)

    def _name(self, choice: Choice, team: str) -> str:
        """Names a choice: by the agent where each of several agents has its own, otherwise by the team."""
        alone = self.asked.settings.selection_by == AGENT and len(self.choices) > 1
        return self.asked.world.agents[choice.agents[0]] if alone else team

    def choose_trees(self) -> list[list[GrownTree]]:
        """The best trees of each agent, the chosen one first; agents in the order of `agents`."""
        trees, total = dict[int, list[GrownTree]](), sum(choice.race for choice in self.choices)
        if total:
            told = Underway(0, total, "episodes of the race among rounds", SELECTING, self.running.part)
            self.running.on_underway(told)
        for choice in self.choices:
            trees |= dict(zip(choice.agents, choice.choose_trees(), strict=True))
        return [trees[agent] for agent in self.agents]

    @property
    def facts(self) -> dict[str, int]:
        """The entries of the provenance about the selection."""
        facts, settings = {"stopped_after": self.offered}, self.asked.settings
        if len(self.choices) == 1 and settings.selection == UNIFORM and settings.selection_by != TEAM:
            return facts | {"best_iteration": self.choices[0].best + 1}
        names: list[tuple[str, int]] = []
        for choice in self.choices:
            if choice.rounds:
                names += zip([self.asked.world.agents[agent] for agent in choice.agents], choice.rounds, strict=True)
            else:
                names.append((self._name(choice, choice.teams[0]), choice.best))
        return facts | {f"best_iteration_{name}": best + 1 for name, best in names}
