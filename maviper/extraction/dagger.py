"""Dataset aggregation for agents that become trees: VIPER, IVIPER, MAVIPER (paper, Algorithm MAVIPER), Imitation DT
and best responses.

Does: rounds of rollouts, labels and growth, as the settings say: whose trees play together, what trees are taught, what
  a state weighs, how many of a team must be predicted right.
Assumes: an expert with a critic, or one of value networks, where states do not all weigh the same.
Does not: choose among iterates (extraction/selection), write files or print.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from codegen import ir
from codegen.deciding import decide_taken
from codegen.errors import InputError
from codegen.ir import Float32, Float64, GrownTree
from maviper.episodes.measures import likeness
from maviper.episodes.play import Controller
from maviper.episodes.trees import agent_policies, among
from maviper.experts.finding import critic_of
from maviper.extraction.arena import merge_leaves
from maviper.extraction.dataset import Dataset, Met, collect, resample
from maviper.extraction.extraction import Extraction, OutOfTime, counts_of
from maviper.extraction.growth.growing import Growth, Labelled, Part, lawful, pool_points
from maviper.extraction.growth.weights import Replies, iviper_weights, maviper_weights
from maviper.extraction.journal import NOTHING_KEPT, pack_trees, unpack_trees
from maviper.extraction.selection import Selection
from maviper.extraction.settings import (
    AGENT,
    ALL,
    EQUAL,
    EXPERT,
    EXPERTS,
    NO_VOTES,
    OWN,
    RESPONSE,
    TEAM,
    Settings,
    group_agents,
)
from maviper.worlds import World
from maviper.worlds.world import Int

FIGURES = "figures"
# of each team: how much of its data the votes kept, in what share of the points in which all its members act all of
# them do right, and what that share would be if their errors had nothing to do with each other
FIGURE_NAMES = ("kept", "joint accuracy", "product of accuracies")
WITH_Q = "choose --critic learned or measured, or --set labels=expert"
EVERYBODY = -1  # whose the points of examples are
WEIGHING = 0.9  # of a round's work, where it takes long enough to be told of

Grown = tuple[list[GrownTree], dict[str, float]]  # trees in the order of agents; of each team's data, the share kept


def dagger(asked: Extraction, agents: Sequence[int], selection: Selection) -> int:
    """Offers every iterate of some agents to `selection`; returns how many points there were in the end, beside the
    examples. Lines are those of the paper's Algorithm MAVIPER.
    """
    world, settings = asked.world, asked.settings
    parties = group_agents(world, settings.rollouts_by, agents)
    names = [""] if len(parties) == 1 else [f"-{place}" for place in range(len(parties))]
    kind = _Responding if settings.labels == RESPONSE else _Group
    groups = [kind(asked, party, name) for party, name in zip(parties, names, strict=True)]  # line 1
    growers: Sequence[_Group | _Voters] = groups
    if settings.rollouts_by == AGENT and settings.least_right != NO_VOTES:
        mine = {agent: group for group in groups for agent in group.agents}
        teams = enumerate(group_agents(world, TEAM, agents))
        growers = [_Voters(asked, [mine[agent] for agent in team], f"-team-{place}") for place, team in teams]

    for iteration in range(settings.iterations):  # line 2
        met: list[Met] = []
        try:
            for place, group in enumerate(groups):  # lines 3 and 4

                def tell(share: float, place: int = place) -> None:
                    selection.underway(WEIGHING * (place + share) / len(groups), "weighing the states of a round")

                met.append(group.play(iteration, tell, selection.cut))
        except OutOfTime:
            break
        if settings.rollouts_by != EXPERTS:
            played = dict.fromkeys(team for each in met for team in each.values)
            values = {team: np.concatenate([one.values[team] for one in met if team in one.values]) for team in played}
            selection.note_rollouts(values, float(np.mean([each.fidelity for each in met])))

        trees: dict[int, GrownTree] = {}
        figures: dict[str, float] = {}
        for grower in growers:  # lines 5 and 6
            grown, told = _grow(asked, grower, iteration)
            trees, figures = trees | grown, figures | told
        for group in groups:
            group.take({agent: trees[agent] for agent in group.agents})
        selection.note_growth(figures)
        if selection.offer([trees[agent] for agent in agents]):  # line 7
            break
    return sum(group.points for group in groups)


def _grow(
    asked: Extraction, grower: "_Group | _Voters", iteration: int
) -> tuple[dict[int, GrownTree], dict[str, float]]:
    """The next trees by agent, and figures of their growth by name: read from the journal, or grown and kept there."""
    grower.gather()
    teams = [team for team in asked.world.teams if set(asked.world.members(team)) <= set(grower.agents)]

    def grow() -> Mapping[str, np.ndarray]:
        data = grower.known
        trees, kept = grower.grow(data, iteration)
        by_agent = dict(zip(grower.agents, trees, strict=True))
        each = [figure for team in teams for figure in (kept[team], *accuracies(asked.world, data, by_agent, team))]
        return pack_trees(trees) | {FIGURES: np.array(each)}

    arrays = asked.journal.arrays(f"{iteration:04d}-trees{grower.name}", grow)
    grown = unpack_trees({name: array for name, array in arrays.items() if name != FIGURES})
    names = [f"{name} {team}" for team in teams for name in FIGURE_NAMES]
    return dict(zip(grower.agents, grown, strict=True)), dict(zip(names, map(float, arrays[FIGURES]), strict=True))


class _Group:
    """Agents whose trees play together, all others act by the expert; `name`: prefix of its journal steps."""

    def __init__(self, asked: Extraction, agents: Sequence[int], name: str) -> None:
        self.asked, self.agents, self.name = asked, list(agents), name
        teams = [asked.world.team_of(asked.world.agents[agent]) for agent in agents]
        self.examples = asked.examples.of_teams(*teams)
        self.journal, self.growth = asked.journal, Growth(asked.world, asked.settings)
        self.data: Dataset | None = None
        # no data yet, and the experts play first
        self.controllers: Sequence[Controller] = [asked.expert] * len(asked.world.agents)

    @property
    def points(self) -> int:
        """The number of points."""
        return 0 if self.data is None else len(self.data)

    def play(self, iteration: int, told: Callable[[float], None], over: Callable[[], bool]) -> Met:
        """Episodes of the group, labelled by the expert, with each agent's weights. `told`: of the share that is
        weighed; `over`: as in `rollout`.
        """
        asked = self.asked
        seeds = asked.settings.rollout_episodes(iteration)
        most, weighed = len(seeds) * asked.world.spec.episode_steps * len(self.agents), 0

        def weigh(observations: tuple[Float32, ...], state: Any, wanted: Int) -> Float64:
            nonlocal weighed
            columns = list[Float64]()
            for column in self.columns(observations, state, wanted):
                columns.append(column)
                weighed += len(wanted)
                told(min(1.0, weighed / most))
            return np.concatenate(columns, axis=1)

        given = (asked.world, asked.expert, self.controllers, self.agents, seeds, weigh, over)
        met = self.journal.load_or_collect(f"{iteration:04d}-rollouts{self.name}", collect, *given)  # line 3
        self.data = met.data if self.data is None else self.data + met.data  # line 4
        return met

    def columns(self, observations: tuple[Float32, ...], state: Any, wanted: Int) -> Iterator[Float64]:
        """Yields the weights of the states for each agent in turn, [n, 1]."""
        for agent in self.agents:
            yield weights(self.asked, [agent], observations, state, wanted)

    def gather(self) -> None:
        """The points of the round are there already."""

    @property
    def known(self) -> Dataset:
        """The examples, then the points."""
        assert self.data is not None
        return self.examples.before(self.asked.world, self.data, self.agents)

    def grow(self, data: Dataset, iteration: int) -> Grown:
        """The next trees of the group, from all that is known."""
        return grow_teams(self.asked.world, data, self.asked.settings, self.growth, self.agents, iteration)

    def take(self, trees: Mapping[int, GrownTree]) -> None:
        """Takes the trees, agent -> tree, by which the group plays from now on."""
        if self.asked.settings.rollouts_by != EXPERTS:
            mine = agent_policies(self.asked.world, [trees[agent] for agent in self.agents], self.agents)
            self.controllers = among(self.asked.world, mine, self.controllers)


class _Responding(_Group):
    """A group whose trees are taught the best replies to their mates' present trees. Agents reply in turn, each to the
    newest trees; those that share a tree reply together. Rollouts are played again when a run goes on, since a journal
    keeps no states, in which Q is asked.
    """

    def __init__(self, asked: Extraction, agents: Sequence[int], name: str) -> None:
        super().__init__(asked, agents, name)
        if critic_of(asked.expert) == "none":
            raise InputError("replies are the best actions by the expert's Q", "--critic none", WITH_Q)
        self.journal = NOTHING_KEPT
        self.replies = {agent: Replies(asked.world, asked.expert, agent) for agent in agents}
        self.trees: Mapping[int, GrownTree] = {}
        self.state: Any = None  # of all points

    def columns(self, observations: tuple[Float32, ...], state: Any, wanted: Int) -> Iterator[Float64]:
        """Keeps the states. Every point weighs the same until there are trees to reply to."""
        self.state = state if self.state is None else state.concatenate([self.state, state])
        yield np.ones((len(wanted), len(self.agents)))

    def take(self, trees: Mapping[int, GrownTree]) -> None:
        """Takes the trees that play and are replied to from now on; see `_Group.take`."""
        super().take(trees)
        self.trees = trees

    def grow(self, data: Dataset, iteration: int) -> Grown:
        """The next trees, one agent's after the other's: each is taught the replies to the present trees of its mates,
        weighed by what they are worth. Nobody votes, so everything is kept.
        """
        settings, world, points = self.asked.settings, self.asked.world, self.data
        assert points is not None
        present, units = dict(self.trees), group_agents(world, TEAM if settings.share else AGENT, self.agents)
        first = iteration % len(units)
        for unit in [*units[first:], *units[:first]]:
            labels, weights = points.labels.copy(), np.zeros((len(points), len(unit)))
            for place, agent in enumerate(unit):
                acting = points.labels.copy()
                for mate in world.members(world.team_of(world.agents[agent])):
                    if mate != agent and mate in present:
                        tree = present[mate]
                        acting[:, mate] = tree.action[ir.apply(tree, points.observations[mate])]
                reply = self.replies[agent].to(acting, points, self.state)
                labels[:, agent] = reply.labels
                worth = reply.worth if settings.weights == OWN else 1.0
                weights[:, place] = np.where(points.alive[:, agent], worth, 0)
            replied = self.examples.before(world, replace(points, labels=labels, weights=weights), unit)
            trees, _ = grow_teams(world, replied, settings, self.growth, unit, iteration)
            present |= dict(zip(unit, trees, strict=True))
        return [present[agent] for agent in self.agents], dict.fromkeys(world.teams, 1.0)


class _Voters:
    """A team whose members have data of their own, and vote on each other's. `groups`: one for each of them."""

    def __init__(self, asked: Extraction, groups: Sequence[_Group], name: str) -> None:
        self.asked, self.groups, self.name = asked, list(groups), name
        self.agents = [agent for group in groups for agent in group.agents]
        self.growth = Growth(asked.world, asked.settings)
        self.whose = np.zeros(0, dtype=np.int64)  # [n] the place of the group that met a point
        self.data: Dataset | None = None  # the points of all groups, those of a round behind those before it

    def gather(self) -> None:
        """Takes the points that the members met in the round."""
        for place, group in enumerate(self.groups):
            assert group.data is not None
            fresh = group.data.since(int((self.whose == place).sum()))
            self.data = fresh if self.data is None else self.data + fresh
            self.whose = np.append(self.whose, np.full(len(fresh), place))

    @property
    def known(self) -> Dataset:
        """The examples, then the points of all members."""
        assert self.data is not None
        return self.groups[0].known.before(self.groups[0].points) + self.data

    def grow(self, data: Dataset, iteration: int) -> Grown:
        """The next trees of the team: each member counts its own points, and all predict one another."""
        settings, world = self.asked.settings, self.asked.world
        whose = np.append(np.full(len(data) - len(self.whose), EVERYBODY), self.whose)
        parts: list[Part] = []
        seeds: dict[int, int] = {}
        for place, group in enumerate(self.groups):
            (agent,), known = group.agents, group.known
            rng = np.random.default_rng([settings.seed, agent, iteration])  # the draws that it has without votes
            mine, counts = np.isin(whose, (place, EVERYBODY)), np.zeros(len(whose), dtype=np.int64)
            counts[mine] = _draw_counts(known.weights[:, 0], known.alive[:, agent], settings, rng)
            seeds[agent] = int(rng.integers(2**31, size=1)[0])
            labels = np.ascontiguousarray(data.labels[:, agent])
            parts.append(Part(agent, data.observations[agent], labels, counts, data.alive[:, agent] & mine))
        kept: list[float] = []
        alive, votes = data.alive[:, self.agents], settings.votes_of(len(self.agents))
        trees = _legally(world, data, self.agents, self.growth.jointly(parts, seeds, votes, alive, kept))
        return trees, {world.team_of(world.agents[self.agents[0]]): float(np.mean(kept))}


def weights(
    asked: Extraction, agents: Sequence[int], observations: tuple[Float32, ...], state: object, wanted: Int
) -> Float64:
    """Returns the weight of each state for each of some agents, [n, len(agents)]."""
    given = (asked.world, asked.expert, observations, state, wanted)
    if asked.settings.weights == EQUAL:
        return np.ones((len(wanted), len(agents)))
    if asked.settings.weights == OWN:
        return np.stack([iviper_weights(*given, agent) for agent in agents], axis=1)
    return maviper_weights(*given, agents)


def accuracies(world: World, data: Dataset, trees: Mapping[int, GrownTree], team: str) -> tuple[float, float]:
    """The share of a data set's points in which all members act as the expert, and the product of each one's share."""
    members = world.members(team)
    together = data.alive[:, members].all(axis=1)
    if not together.any():
        return 1.0, 1.0
    policies = agent_policies(world, [trees[agent] for agent in members], members)
    right: list[Float64] = []
    for agent, policy in zip(members, policies, strict=True):
        seen, wanted = data.observations[agent][together], data.labels[together, agent]
        right.append(likeness(world.given[agent], decide_taken(policy, seen), wanted))
    return float(np.min(right, axis=0).mean()), float(np.prod([each.mean() for each in right]))


def grow_teams(
    world: World, data: Dataset, settings: Settings, growth: Growth, agents: Sequence[int], iteration: int
) -> tuple[list[GrownTree], dict[str, float]]:
    """Resampling and TrainJointTrees for some agents, team by team: their trees, and the share of its data that each
    team's votes kept. `data`: with a column of weights for each of them.
    """
    together = settings.rollouts_by in (EXPERTS, ALL) and settings.labels == EXPERT
    whose = list[int]() if together else agents  # data or labels of its own, draws of its own
    rng = np.random.default_rng([settings.seed, *whose, iteration])
    columns = zip(agents, data.weights.T, strict=True)
    counts = {agent: _draw_counts(column, data.alive[:, agent], settings, rng) for agent, column in columns}
    seeds = dict(zip(agents, map(int, rng.integers(2**31, size=len(agents))), strict=True))
    trees: dict[int, GrownTree] = {}
    shares: dict[str, float] = {}
    for members in group_agents(world, TEAM, agents):
        kept: list[float] = []
        grown = growth.team(members, data, counts, seeds, settings.votes_of(len(members)), kept)
        trees |= dict(zip(members, _legally(world, data, members, grown), strict=True))
        shares[world.team_of(world.agents[members[0]])] = float(np.mean(kept))
    return [trees[agent] for agent in agents], shares


def _legally(world: World, data: Dataset, members: Sequence[int], trees: Sequence[GrownTree]) -> list[GrownTree]:
    """The trees of a team as they may play: with legal actions only. Those who share a tree still do."""
    legal_trees: list[GrownTree] = []
    for agent, tree in zip(members, trees, strict=True):
        mask, sharing = world.mask(agent), [other for other, its in zip(members, trees, strict=True) if its is tree]
        if mask is None or sharing[0] != agent:
            legal_trees.append(tree if mask is None else legal_trees[members.index(sharing[0])])
            continue
        points = pool_points(data, sharing, dict(enumerate(data.alive.T.astype(np.int64))))
        known = Labelled(points.obs[points.alive], points.labels[points.alive])
        legal_trees.append(lawful(merge_leaves(tree), mask, known))
    return legal_trees


def _draw_counts(column: Float64, alive: ir.Bool, settings: Settings, rng: np.random.Generator) -> Int:
    """Counts each point in an agent's data; nothing is drawn where all weigh the same."""
    return counts_of(column) if settings.weights == EQUAL else resample(column, alive, settings.max_samples, rng)
