"""The selection of an extraction: what agents, teams or all together choose, and when there is enough to choose from.

Does: hands candidates to those who choose; says how the search stands; knows when to stop early.
Assumes: candidates with a tree for each of its agents.
Does not: make candidates; know how a choice is made (choices.py).
"""

from collections.abc import Mapping, Sequence

import numpy as np

from codegen.ir import Float64, GrownTree
from codegen.wording import format_count
from maviper.episodes import measures
from maviper.extraction.bundles import AGENT, TEAM, UNIFORM, group_agents
from maviper.extraction.extraction import Extraction, Running
from maviper.extraction.journal import EXPERT_STEP, Arrays
from maviper.extraction.selection.choices import Choice, common, kind_of
from maviper.extraction.selection.progress import EXTRACTING, SELECTING, Progress, Underway, count_leaves


def explain_stop(told: Mapping[str, str | int | float]) -> str:
    """Why an extraction stopped early, in words. `told`: what its profile says of the training."""
    patience = f"no significant improvement in {format_count(int(told['patience']), 'round')}"
    if "enough" in told:
        return f"a ratio of {told['enough']} to the expert is reached (--enough), or {patience} (--patience)"
    return f"{patience} (--patience)"


class Selection:
    """The choices of some `agents` that are extracted in the same rounds."""

    def __init__(self, asked: Extraction, agents: Sequence[int], running: Running) -> None:
        self.asked, self.agents, self.running = asked, list(agents), running
        settings, self.offered = asked.settings, 0
        self.underway(0.0, "playing")
        experts = asked.journal.arrays(EXPERT_STEP, self._experts)
        units = group_agents(asked.world, settings.selection_by, agents)
        names = [""] if len(units) == 1 else [f"-{place}" for place in range(len(units))]
        kind = kind_of(settings)
        self.choices = [kind(asked, unit, experts, name) for unit, name in zip(units, names, strict=True)]
        self.fidelity: float | None = None
        self.growth: Mapping[str, float] = {}
        self._reference, self._since_gain = -np.inf, 0

    def _experts(self) -> Arrays:
        asked = self.asked
        values = measures.values(asked.world, [asked.expert] * len(asked.world.agents), common(asked))
        return {team: values[asked.world.primary(team)] for team in asked.world.teams}

    def note_rollouts(self, values: Mapping[str, Float64], fidelity: float) -> None:
        """Says what the last candidate (or, before the first, the expert) did in its rollouts: `values`, each team's
        primary measure; `fidelity`, the share of actions that were the expert's.
        """
        self.fidelity = fidelity
        for choice in self.choices:
            choice.note_rollouts(values)

    def underway(self, share: float, doing: str) -> None:
        """Says that a share of the work on the next candidate is done."""
        done, total = self.offered + share, self.asked.settings.iterations
        self.running.on_underway(Underway(done, total, doing, part=self.running.part))

    def note_growth(self, figures: Mapping[str, float]) -> None:
        """Says by name how the growth of the next candidate went."""
        self.growth = figures

    def offer(self, trees: Sequence[GrownTree]) -> bool:
        """Takes a candidate, trees in the order of `agents`; returns whether it is time to stop: the best of all
        choices are good enough on average, or nothing gained more than the interval for `patience` candidates.
        """
        settings = self.asked.settings
        self.offered += 1
        mine = dict(zip(self.agents, trees, strict=True))
        judged = [choice.offer([mine[agent] for agent in choice.agents]) for choice in self.choices]
        scores = [ratio for ratio in judged if ratio is not None]
        if not scores:
            return False
        ratios, widths = zip(*(choice.ratio for choice in self.choices), strict=True)
        best, half_width = float(np.mean(ratios)), float(np.sqrt(np.square(widths).sum()) / len(widths))
        self._since_gain += 1
        if best > self._reference:
            self._reference, self._since_gain = best + half_width, 0
        self.running.on_progress(self._progress(float(np.mean(scores)), best))
        if settings.enough and best - half_width >= settings.enough:
            return True
        return self._since_gain >= settings.patience and all(choice.stops for choice in self.choices)

    def _progress(self, score: float, best: float) -> Progress:
        measured = {
            self._name(choice, measure.team): estimate
            for choice in self.choices
            for measure, estimate in choice.found.items()
        }
        leaves = sum(count_leaves(choice.candidates[choice.best]) for choice in self.choices)
        total = self.asked.settings.iterations
        told = self.offered, total, score, best, measured, self.fidelity, leaves, self.growth, self.running.part
        return Progress(EXTRACTING, *told)

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
