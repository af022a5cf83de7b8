"""What an extraction is asked for: the settings that an algorithm's name stands for, and those that a user changed.

Does: names the algorithms, the bundle of settings of each, and the rungs of the ladder from IVIPER to MAVIPER; holds
  the settings of every algorithm, their presets and the limits they must keep.
Assumes: presets change defaults; whatever a user says goes on top.
Does not: know how an algorithm works.
"""

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from fractions import Fraction
from typing import Any

from codegen import ir
from codegen.errors import InputError, UnknownNameError
from maviper.episodes import measures
from maviper.evaluation import held_out
from maviper.extraction.journal import MEASURING, REFINING, SELECTING
from maviper.options import ExtractOptions, table_of
from maviper.options.extraction import DEPTH, RELEASED, ensure_together, option_of
from maviper.worlds import World
from maviper.worlds.outside.playing import START_EPISODES

MAVIPER, IVIPER, VIPER, IMITATION, FITTED_Q = "maviper", "iviper", "viper", "imitation", "fitted-q"
NO_PREDICTION, IVIPER_RESAMPLING = "maviper-no-prediction", "maviper-iviper-resampling"
ALGORITHMS = (MAVIPER, IVIPER, VIPER, IMITATION, FITTED_Q, NO_PREDICTION, IVIPER_RESAMPLING)
RGMDT = "rgmdt"  # not of the paper; what is known of it is its description
BEST_RESPONSE = "best-response"  # ours
KNOWN = (*ALGORITHMS, BEST_RESPONSE, RGMDT)
DESCRIBED = {RGMDT: "after the description in arXiv 2410.16517"}
JOINT = (MAVIPER, NO_PREDICTION, IVIPER_RESAMPLING)  # the trees of all agents come from the same episodes

AGENT, TEAM, ALL = "agent", "team", "all"  # who plays, or is chosen, together
MEMBER = "member"  # each member of a team has a round of its own, judged by how the team plays
NOTHING, SHARES = "", ("", TEAM)  # for whom there is one tree
EXPERTS = "experts"  # no tree plays while data are collected
ROLLOUTS_BY, SELECTION_BY = (EXPERTS, AGENT, TEAM, ALL), (AGENT, MEMBER, TEAM, ALL)
EXPERT, RESPONSE = "expert", "response"  # what a tree is taught: the expert's action, or the best reply to its mates
LABELS = (EXPERT, RESPONSE)
OWN, AVERAGED, EQUAL = "own", "averaged", "equal"
WEIGHTS = (OWN, AVERAGED, EQUAL)
N_LESS_1, NO_VOTES = "N-1", "0"
UNIFORM, RETURN, RACE = "uniform", "return", "race"
CHOSEN_BY = {UNIFORM: ALL, RETURN: TEAM, RACE: TEAM}  # unless an algorithm says otherwise

_JOINT: dict[str, str] = {"rollouts_by": ALL, "weights": AVERAGED, "least_right": N_LESS_1}
_ALONE: dict[str, str] = {"rollouts_by": AGENT, "weights": OWN, "least_right": NO_VOTES, "selection_by": AGENT}
_EXPERTS: dict[str, str] = {"rollouts_by": EXPERTS, "weights": EQUAL, "least_right": NO_VOTES}
BUNDLES: dict[str, dict[str, str]] = {
    MAVIPER: _JOINT,
    NO_PREDICTION: {**_JOINT, "least_right": NO_VOTES},
    IVIPER_RESAMPLING: {**_JOINT, "weights": OWN},
    IVIPER: _ALONE,
    VIPER: _ALONE,
    IMITATION: _EXPERTS,
    FITTED_Q: _EXPERTS,
    RGMDT: {"rollouts_by": ALL, "weights": EQUAL, "least_right": NO_VOTES},
    BEST_RESPONSE: {"labels": RESPONSE, "rollouts_by": ALL, "weights": OWN, "least_right": NO_VOTES},
}
PARTS = ("labels", "rollouts_by", "weights", "least_right", "selection_by")

# What the released code does besides its text, each of which can be undone alone: leaves that stand still, a collector
# that starts a new episode at every step, and 500 expert episodes ahead of all. Who does which:
LEAVES, RESTARTS, WARM_UP = "leaves", "restarts", "warm-up"
ACCIDENTS: dict[str, tuple[str, ...]] = {
    IVIPER: (LEAVES, WARM_UP),
    VIPER: (LEAVES, WARM_UP),
    IMITATION: (LEAVES, RESTARTS),
    **dict.fromkeys(JOINT, (WARM_UP,)),
}

# From IVIPER to MAVIPER and one step beyond: each rung is one difference from the one before it.
RUNGS: dict[str, dict[str, str]] = {
    "iviper": {"algorithm": IVIPER},
    "joint-rollouts": {"algorithm": MAVIPER, "weights": OWN, "least_right": NO_VOTES, "selection_by": AGENT},
    "joint-selection": {"algorithm": MAVIPER, "weights": OWN, "least_right": NO_VOTES},
    "averaged-weights": {"algorithm": NO_PREDICTION},
    "vote-N-1": {"algorithm": MAVIPER},
    "vote-N": {"algorithm": MAVIPER, "least_right": "N"},
}
# Fitted Q that sees other actions than its expert's while it collects, so that its trees are no constant.
EXPLORING = "fitted-q-exploring"
VARIANTS: dict[str, dict[str, Any]] = {**RUNGS, EXPLORING: {"algorithm": FITTED_Q, "explore": 0.3}}
# From joint selection to best responses, where rounds are chosen by races.
OUR_RUNGS: dict[str, dict[str, str]] = {
    "joint-selection": RUNGS["joint-selection"],
    "member-selection": {"algorithm": BEST_RESPONSE, "labels": EXPERT},
    "best-response": {"algorithm": BEST_RESPONSE},
}


def bundle(algorithm: str, selection: str, share: str = NOTHING) -> dict[str, str]:
    """The settings that an algorithm's name stands for. `selection`: how an iterate is chosen; `share`: members of a
    team that share a tree play and choose together, where each would do so alone.
    """
    settings = {"labels": EXPERT, "selection_by": CHOSEN_BY[selection], **BUNDLES[algorithm]}
    if algorithm == BEST_RESPONSE and selection == RACE and not share:
        settings["selection_by"] = MEMBER
    if share == TEAM:
        settings |= {name: TEAM for name in ("rollouts_by", "selection_by") if settings[name] == AGENT}
    return settings


def group_agents(world: World, by: str, agents: Sequence[int]) -> list[list[int]]:
    """Some agents in the groups that a setting makes of them, in the world's order."""
    if by == AGENT:
        return [[agent] for agent in agents]
    if by in (TEAM, MEMBER):
        mine = [[agent for agent in world.members(team) if agent in agents] for team in world.teams]
        return [members for members in mine if members]
    return [list(agents)]


def wider(one: str, other: str) -> str:
    """That of two groupings whose groups hold the other's."""
    return max(one, other, key=(AGENT, MEMBER, TEAM, ALL, EXPERTS).index)


STARTING, ROLLOUTS = "start", "rollouts"
EXACT, HISTOGRAM = "exact", "histogram"
DIFFERENCES = "differences"  # a histogram that has differences of two features too
SUMS = "sums"  # of few features, by alternating optimisation of a tree that a histogram grew
SUMMED = (DIFFERENCES, SUMS)  # after which nothing is refined unless that is asked for
SPLITS = (EXACT, HISTOGRAM, *SUMMED)
CONSTANT, LINEAR = "constant", "linear"
LEAF_KINDS = ("", CONSTANT, LINEAR)  # "": leaves have actions
SELECTIONS = (UNIFORM, RETURN, RACE)
PAPER, DEFAULT = "paper", "default"
REFINEMENT = 300_000
MAX_NUMBER = 1_000_000  # of anything that is counted
MAX_RATIO = 100  # to the expert
# profiles do not name these where they are empty
UNSAID = ("agent", "measure", "share", "max_leaves", "leaf", "explore", "undo", "enough", "max_seconds")
PRESETS: dict[str, dict[str, Any]] = {
    PAPER: {"splits": HISTOGRAM, "selection": UNIFORM, "refinement": 0, "patience": MAX_NUMBER},
    RELEASED: {"splits": EXACT, "selection": RETURN, "refinement": 0, "patience": MAX_NUMBER},
    DEFAULT: {"splits": HISTOGRAM, "selection": RACE, "refinement": REFINEMENT},
}
DEALT = ("iterations", "rollouts", "selection_episodes", "patience", "refinement")  # what a budget decides
MAX_EPISODES = 100_000_000
LARGE_BUDGET = 30_000  # from it on, there is enough to refine by
MAX_ROLLOUTS = 2_000
EPISODES_AN_ITERATION = 5
EPISODES_AN_OUTSIDE_ITERATION = 1
EPISODES_PER_SEED = 100_000  # the episode seeds of two extraction seeds do not meet
# What the paper's protocol changes for an algorithm, in every preset; imitation adds 5,000 samples per iteration.
PROTOCOL: dict[str, dict[str, Any]] = {
    IVIPER: {"iterations": 50},
    VIPER: {"iterations": 50},
    IMITATION: {"iterations": 20, "rollouts": 200, "patience": 20},
    RGMDT: {"iterations": 10, "rollouts": 200, "patience": 10},
    FITTED_Q: {"iterations": 10, "rollouts": 1_200, "patience": 10},
}
VOTES = re.compile(r"N(?:-(?P<less>\d{1,3}))?|(?P<number>\d{1,3})|(?P<share>0?\.\d{1,9}|1\.0)")
# What the preset `paper` changes for a game: IVIPER's and VIPER's counts, and what teams are judged by.
PAPER_COUNTS: dict[str, dict[str, int]] = {
    "cooperative-navigation": {"iterations": 100},
    "predator-prey": {"iterations": 100, "rollouts": 100},
}
PAPER_MEASURES = {"cooperative-navigation": "D"}


def part_settings(options: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Of the options of an extraction those that are no settings, and those that are, by the settings' names."""
    names = {name: option.setting or name for name, option in table_of(ExtractOptions).items()}
    known = {field.name for field in fields(Settings)}
    settings = {names[name]: value for name, value in options.items() if names[name] in known}
    return {name: value for name, value in options.items() if names[name] not in known}, settings


@dataclass(frozen=True)
class Settings:
    """Settings of an extraction; the defaults are the paper's for physical deception."""

    algorithm: str = MAVIPER
    preset: str = PAPER
    splits: str = HISTOGRAM  # how a split is searched: every threshold, or the bins of a histogram; and of what
    leaf: str = ""  # what leaves give where agents give numbers; "": they have actions
    max_depth: int = 4
    iterations: int = 100
    rollouts: int = 50  # episodes per iteration
    max_samples: int = 300_000
    # every iterate alike and one iteration for all agents; each team's best by return; a race in each team
    selection: str = UNIFORM
    selection_episodes: int = 100  # per candidate and team, on average
    # What an algorithm's name stands for; "": as it says.
    labels: str = ""  # what trees are taught: the expert's actions, or the best replies to their mates' trees
    rollouts_by: str = ""  # whose trees play together among experts while data are collected; or `experts` alone
    weights: str = ""  # others at expert actions, averaged over the others' actions, or every state alike
    least_right: str = ""  # right predictions that a point needs in joint growth: a number, or a share of the N
    selection_by: str = ""  # for whom one iterate is chosen
    share: str = NOTHING  # who shares a tree: nobody, or the agents of a team
    max_leaves: int = 0  # of each tree, which then grows best first; 0: as many as the depth allows
    explore: float = 0.0  # Fitted Q's: share of uniform actions while it collects
    measure: str = ""  # what teams are judged by; "": the preset's, or the world's first
    refinement: int = 0  # episodes per team
    budget: int = 0  # episodes in all; 0: as the others say
    held_out: int | None = None  # episodes that each measured line-up plays; None: as the world says
    patience: int = 10  # stop after so many iterations without a gain above the interval
    enough: float = 0.0  # stop at this ratio to the expert; 0: never
    max_seconds: float = 0.0  # of all stages, as far as their pace tells; 0: no limit
    agent: str = ""  # VIPER's: the one agent that becomes a tree
    undo: str = ""  # which accidents of the preset `released` are left out, joined by +
    seed: int = 0

    @staticmethod
    def of(given: Mapping[str, Any], world: World | None = None, weighed: bool = True) -> "Settings":
        """Settings from what a user said; the rest is the algorithm's and the preset's, in `paper` the game's too. In a
        `world` that plays few games at a time nothing is refined unless that is asked for, and in the preset `default`
        each state counts once where the expert has no Q to weigh it by (`weighed`): draws would only lose some.
        """
        algorithm, preset = given.get("algorithm", MAVIPER), given.get("preset", DEFAULT)
        if algorithm not in KNOWN:
            raise UnknownNameError("algorithm", algorithm, KNOWN, "--algorithm")
        if preset not in PRESETS:
            raise UnknownNameError("preset", preset, PRESETS, "--preset")
        said = {name: value for name, value in given.items() if value is not None}
        usual = {"preset": preset, **PROTOCOL.get(algorithm, {}), **PRESETS[preset]}
        if preset == PAPER and world is not None and algorithm in (IVIPER, VIPER):
            usual |= PAPER_COUNTS.get(world.spec.name, {})
        unrefined = (world is not None and world.games is not None) or said.get("max_leaves") or said.get("share")
        unrefined = unrefined or said.get("splits") in SUMMED
        usual |= {"refinement": 0} if unrefined else {}
        if "budget" in said:
            if not 1 <= said["budget"] <= MAX_EPISODES:
                what = f"{option_of('budget')} must be from 1 to {MAX_EPISODES}, not {said['budget']}"
                raise InputError(what, option_of("budget"), "leave it out for the counts of the preset")
            both = [option_of(name) for name in DEALT if name in said]
            if both:
                raise InputError(
                    f"--max-episodes already determines {', '.join(both)}", "--max-episodes", "give one or the other"
                )
        selection = said.get("selection", usual["selection"])
        usual |= bundle(algorithm, selection, said.get("share", NOTHING)) if selection in SELECTIONS else {}
        if world is not None and world.games is not None and preset == DEFAULT and not weighed:
            usual |= {"weights": EQUAL}
        if world is not None and world.continuous:
            usual |= {"leaf": CONSTANT, "weights": EQUAL, "least_right": NO_VOTES, "refinement": 0}
        return Settings(**{**usual, **said})._ensure_usable()

    @property
    def changed(self) -> list[str]:
        """The names of the settings that are not as the algorithm's name says, of settings that are filled."""
        usual = bundle(self.algorithm, self.selection, self.share)
        return [name for name in PARTS if getattr(self, name) != usual[name]]

    @property
    def leaves(self) -> int:
        """The number of leaves that a tree may have."""
        return self.max_leaves or 2 ** min(self.max_depth, MAX_NUMBER.bit_length())

    @property
    def together(self) -> str:
        """Whose iterates depend on one another: of such agents there is one loop of rounds."""
        voting = AGENT if self.least_right == NO_VOTES else TEAM
        widest = wider(voting, wider(self.rollouts_by, self.selection_by))
        return TEAM if widest == MEMBER else widest

    def votes_of(self, team: int) -> int:
        """Counts the right predictions a point needs in a team of so many: `least_right`, a share rounded up."""
        votes = VOTES.fullmatch(self.least_right)
        assert votes
        if votes["share"]:
            return math.ceil(Fraction(votes["share"]) * team)
        return min(team, int(votes["number"])) if votes["number"] else max(0, team - int(votes["less"] or 0))

    def keeps(self, accident: str) -> bool:
        """Returns True if an accident of the released code is not undone."""
        return accident not in self.undo.split("+")

    def measure_in(self, world: World) -> str:
        """The name of what a world's teams are judged by; "": each by its first measure."""
        return self.measure or (PAPER_MEASURES.get(world.spec.name, "") if self.preset == PAPER else "")

    def judge_world(self, world: World) -> World:
        """The world, its teams judged as these settings say; UnknownNameError for a measure that it has not."""
        return world.judge_by(self.measure_in(world))

    def deal_budget(self, world: World, jobs: int = 1) -> "Settings":
        """The settings with a budget dealt out; InputError where it is too small for one iteration. `jobs`: processes
        that work at a time.

        In a world of others all that is played counts: what is played to get to know it, and, a quarter at most unless
        `held_out` says more, the held-out episodes. Of the rest, half, at most MAX_ROLLOUTS episodes, goes to rollouts,
        in iterations whose number is the root of a fifth of that: few points are worth labelling often. In a world of
        others it is the root of all, since episodes take longer there than growth, and small trees of different rounds
        differ widely. The others go to selection; from LARGE_BUDGET on, only as much as to rollouts does, and what is
        left to refinement.
        """
        if not self.budget:
            return self
        budget, held = self.budget, self.held_out
        if world.games is not None:
            if self.preset == RELEASED:
                what = "the authors' code counts samples, not episodes"
                raise InputError(what, f"--max-episodes, --preset {RELEASED}", "choose another --preset")
            budget -= START_EPISODES * (1 if jobs == 1 else 1 + jobs)
            lineups = len(world.teams) + 1
            held = held or max(1, min(held_out.default_episodes(world), budget // 4 // lineups))
            budget -= held * lineups
        runs, loops, sides, refined = self._counts(world)
        plain = not self.max_leaves and not self.share and not self.leaf and self.splits not in SUMMED
        large = budget >= LARGE_BUDGET and world.games is None and plain
        rollouts = min(MAX_ROLLOUTS, max(0, budget) // 2)
        selection = rollouts if large else max(0, budget) - rollouts
        few = EPISODES_AN_ITERATION if world.games is None else EPISODES_AN_OUTSIDE_ITERATION
        iterations = max(1, round((rollouts / runs / few) ** 0.5))
        dealt = replace(
            self,
            iterations=iterations,
            rollouts=rollouts // (runs * iterations),
            selection_episodes=selection // (iterations * sides + loops),  # the expert plays them in every loop
            patience=iterations,
            refinement=0,
            held_out=held,
        )
        if not dealt.rollouts or not dealt.selection_episodes:
            least = "give at least a few dozen"
            raise InputError(f"{self.budget} episodes are too few for one iteration", "--max-episodes", least)
        return replace(dealt, refinement=(budget - 2 * rollouts) // refined) if large else dealt

    def share_budget(self, world: World, seeds: int) -> "Settings":
        """The settings of one of several extractions that share a budget, in a world of others: what is left to it when
        the held-out episodes have been played once more, to choose among them.
        """
        if not self.budget or world.games is None:
            return self
        share = (self.budget - START_EPISODES) // seeds
        again = share // 5 if self.held_out is None else self.held_out * (len(world.teams) + 1)
        return replace(self, budget=max(1, share - again))

    def _counts(self, world: World) -> tuple[int, int, int, int]:
        """Counts groups that play rollouts, loops of rounds, sides scored in a round, and teams that are refined."""
        agents = range(1 if self.algorithm == VIPER else len(world.agents))
        runs, loops = (len(group_agents(world, by, agents)) for by in (self.rollouts_by, self.together))
        alone = self.selection_by == AGENT  # then candidates are scored for each agent, otherwise for each team
        sides = len(agents) if alone else len(world.teams)
        return runs, loops, sides, 1 if self.algorithm == VIPER else len(world.teams)

    def count_held_out(self, world: World) -> int:
        """Counts the held-out episodes that each measured line-up plays: the trees of each team, and the expert."""
        return self.held_out or held_out.default_episodes(world)

    def plan(self, world: World) -> dict[str, int]:
        """Counts the episodes that each stage plays at most, of settings that are complete and dealt. The authors' code
        counts samples, so only its held-out episodes are known.
        """
        runs, loops, sides, refined = self._counts(world)
        learning = {
            ROLLOUTS: runs * self.rollouts * (1 if self.algorithm == FITTED_Q else self.iterations),
            SELECTING: (self.iterations * sides + loops) * self.selection_episodes,
            REFINING: self.refinement * refined,
        }
        start = {STARTING: START_EPISODES} if world.games is not None else {}
        measured = {MEASURING: (len(world.teams) + 1) * self.count_held_out(world)}
        stages = start | ({} if self.preset == RELEASED else learning) | measured
        return {stage: count for stage, count in stages.items() if count}

    def episodes(self, purpose: int) -> range:
        """The episode seeds of this extraction seed for a purpose, one of the first seeds in `metrics`."""
        first = purpose + self.seed * EPISODES_PER_SEED
        return range(first, first + EPISODES_PER_SEED)

    def rollout_episodes(self, iteration: int, before: int = 0) -> range:
        """The episode seeds of an iteration's rollouts; `before`: episodes that were played ahead of all."""
        first = self.episodes(measures.ROLLOUT_SEEDS).start + before + iteration * self.rollouts
        return range(first, first + self.rollouts)

    def complete(self) -> "Settings":
        """The settings, with what the algorithm's name stands for where nothing else was asked for; InputError or
        UnknownNameError when one cannot be used.
        """
        self._check_names({"algorithm": KNOWN, "preset": PRESETS, "selection": SELECTIONS})
        usual = bundle(self.algorithm, self.selection, self.share)
        return replace(self, **{name: getattr(self, name) or usual[name] for name in PARTS})._ensure_usable()

    def _ensure_usable(self) -> "Settings":
        self._check_names({"algorithm": KNOWN, "preset": PRESETS, "splits": SPLITS, "selection": SELECTIONS})
        self._check_names({"share": SHARES, "leaf": LEAF_KINDS})
        self._check_names({"labels": LABELS, "rollouts_by": ROLLOUTS_BY})
        self._check_names({"weights": WEIGHTS, "selection_by": SELECTION_BY})
        for name in ("refinement", "budget"):
            if not 0 <= getattr(self, name) <= MAX_EPISODES:
                what = f"{option_of(name)} must be from 0 to {MAX_EPISODES}, not {getattr(self, name)}"
                raise InputError(what, option_of(name))
        if self.held_out is not None and not 1 <= self.held_out <= EPISODES_PER_SEED:
            what = f"--held-out must be from 1 to {EPISODES_PER_SEED}, not {self.held_out}"
            raise InputError(what, "--held-out")
        for name in ("max_depth", "iterations", "rollouts", "max_samples", "selection_episodes", "patience"):
            if not 1 <= getattr(self, name) <= MAX_NUMBER:
                what = f"{option_of(name)} must be at least 1 and at most {MAX_NUMBER}, not {getattr(self, name)}"
                raise InputError(what, option_of(name))
        if not VOTES.fullmatch(self.least_right):
            what = f"'{self.least_right[:40]}' is no number of right predictions"
            raise InputError(what, "--set least_right", "write N, N-1, 2, or a share such as 0.5")
        if not 0 <= self.explore <= 1:
            raise InputError("explore is a share from 0 to 1", "--set explore", "leave it out")
        if not 0 <= self.enough <= MAX_RATIO:
            raise InputError(f"enough is a ratio from 0 to {MAX_RATIO}", "--set enough", "leave it out")
        if not 0 <= self.max_seconds < math.inf:
            raise InputError("max_seconds is a number of seconds, from 0", "--max-seconds", "leave it out")
        if self.max_leaves and not 2 <= self.max_leaves <= MAX_NUMBER:
            raise InputError(f"max_leaves is from 2 to {MAX_NUMBER}", "--max-leaves", DEPTH)
        ensure_together(vars(self), self.changed)
        for name in self.undo.split("+") if self.undo else ():
            if name not in ACCIDENTS[self.algorithm]:
                what = f"accident of the released {self.algorithm}"
                raise UnknownNameError(what, name, ACCIDENTS[self.algorithm], "--set undo")
        if self.max_depth > ir.MAX_DEPTH:
            raise InputError(f"max_depth must be at most {ir.MAX_DEPTH}", "--max-depth")
        if not 0 <= self.seed < 2**32:
            raise InputError("the seed must be from 0 to 4294967295", "--seed")
        if max(self.iterations * self.rollouts, self.selection_episodes) > EPISODES_PER_SEED:
            where = "--iterations times --rollouts, --set selection_episodes"
            raise InputError(f"more than {EPISODES_PER_SEED} episodes in all", where)
        return self

    def _check_names(self, known: Mapping[str, Iterable[str]]) -> None:
        for name, values in known.items():
            if getattr(self, name) not in values:
                raise UnknownNameError(name.replace("_", " "), getattr(self, name), values, option_of(name))
