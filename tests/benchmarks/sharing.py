"""Teams of small trees that share out the landmarks of cooperative navigation by two tests, then go there.

Does: chooses two levels of tests that all agents can ask, differences of two places on one axis, and who goes where
  in each of their four cases; extracts trees for each agent and landmark, puts them below, and refines the whole.
Assumes: as many agents as landmarks, and features of mpe2's game: where landmarks and mates are from an agent.
Does not: measure the team.

The tests and roles are those that make the ways of all agents shortest at the start of episodes, exactly: of all
trees of depth 2 over such tests none has a lower mean (30 tests and 6 roles with three agents).
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import combinations, permutations

import numpy as np

from codegen.ir import NO_ACTION, NO_CHILD, ROOT, Bool, Float64, GrownTree, Int32, PolicyProfile
from codegen.lowering.deploy import SummedTree
from maviper.episodes.measures import ROLLOUT_SEEDS
from maviper.episodes.trees import agent_policies, reopen_tree
from maviper.experts.expert import Expert
from maviper.extraction.algorithms import extract
from maviper.extraction.extraction import Extraction, profile_of
from maviper.extraction.growth.sums import as_summed, with_sum
from maviper.extraction.journal import NOTHING_KEPT, Journal
from maviper.extraction.selection import refine
from maviper.extraction.settings import Settings
from maviper.worlds import World
from tests.benchmarks.settled import Settled

Roles = tuple[int, ...]  # the landmark of each agent
Goals = Mapping[tuple[int, int], GrownTree]  # an agent and a landmark -> a tree that goes there
Apart = tuple[str, str, str]  # two entities and an axis: goes left where the first one's place is at most the other's
CASES = 4
STARTS = 3_000  # episodes whose starts choose the tests


@dataclass(frozen=True)
class Sharing:
    """Who goes where: `root`, then `below[0]` where that goes left and `below[1]` where it goes right."""

    root: Apart
    below: tuple[Apart, Apart]
    roles: tuple[Roles, Roles, Roles, Roles]  # of the four cases, from left to right
    length: float  # of all agents' ways together, the mean over the episodes that chose it


def choose_sharing(world: World, seeds: range) -> Sharing:
    """The sharing with the shortest ways at the start of these episodes."""
    agents = world.agents
    entities = [*agents, *(f"landmark_{place}" for place in range(len(agents)))]
    place = world.start_from_seeds(seeds).position
    tests = [(one, other, axis) for one, other in combinations(entities, 2) for axis in "xy"]
    at = {name: place[:, index] for index, name in enumerate(entities)}
    left = np.array([at[one][:, "xy".index(axis)] <= at[other][:, "xy".index(axis)] for one, other, axis in tests])
    ways = np.linalg.norm(place[:, : len(agents), None] - place[:, None, len(agents) :], axis=-1)
    roles = list(permutations(range(len(agents))))
    lengths = np.array([sum(ways[:, agent, goal] for agent, goal in enumerate(each)) for each in roles]).T
    chosen: list[tuple[float, int, int, int]] = []
    for root, goes_left in enumerate(left):
        on_left, one = _choose_below(left[:, goes_left], lengths[goes_left])
        on_right, other = _choose_below(left[:, ~goes_left], lengths[~goes_left])
        chosen.append((on_left + on_right, root, one, other))
    total, root, one, other = min(chosen)
    cases = [left[root] & left[one], left[root] & ~left[one], ~left[root] & left[other], ~left[root] & ~left[other]]
    given = [roles[int(lengths[rows].sum(axis=0).argmin())] for rows in cases]
    first, second, third, fourth = given
    return Sharing(tests[root], (tests[one], tests[other]), (first, second, third, fourth), total / len(place))


def _choose_below(left: Bool, lengths: Float64) -> tuple[float, int]:
    """The lowest total of one test with the best roles on either side, and the test. `left`: [n_tests, n]."""
    on_left = left @ lengths
    totals = on_left.min(axis=1) + (lengths.sum(axis=0) - on_left).min(axis=1)
    test = int(totals.argmin())
    return float(totals[test]), test


def extract_shared(world: World, expert: Expert, settings: Settings, journal: Journal = NOTHING_KEPT) -> PolicyProfile:
    """A team whose trees share out landmarks by tests, each with as many leaves as the settings say at most.

    An agent's tree for one landmark is that of an expert whose mates are settled on the others, and has a quarter of
    the leaves. As many such teams are extracted as there are landmarks, each agent going to another one in each of
    them. Their refinement takes half of the episodes, that of the team in the end as many.
    """
    settings = settings.complete()
    world, n_agents = settings.judge_world(world), len(world.agents)
    sharing = choose_sharing(world, settings.episodes(ROLLOUT_SEEDS)[:STARTS])
    half = settings.refinement // 2
    small = replace(settings, max_leaves=settings.max_leaves // CASES, refinement=half // n_agents)
    goals: dict[tuple[int, int], GrownTree] = {}
    for turn in range(n_agents):
        roles = [(agent + turn) % n_agents for agent in range(n_agents)]
        policies = extract(world, Settled(expert, world, roles), small, journal=journal.part(f"turn-{turn}")).agents
        goals |= {(agent, roles[agent]): reopen_tree(policy) for agent, policy in enumerate(policies)}
    chosen = [[tree] for tree in join_trees(world, sharing, goals)]
    asked = Extraction(world, expert, replace(settings, refinement=half), journal.part("team"))
    trees, _ = refine.refine_trees(asked, range(n_agents), chosen)
    return profile_of(world, expert, settings, agent_policies(world, trees), {})


def join_trees(world: World, sharing: Sharing, goals: Goals) -> list[GrownTree]:
    """A tree for each agent: the tests of the sharing, and below them its trees for the landmarks of its roles. Where
    two cases have one landmark for an agent, their test goes.
    """
    return [_join(world, agent, sharing, goals) for agent in range(len(world.agents))]


def _join(world: World, agent: int, sharing: Sharing, goals: Goals) -> GrownTree:
    cases = [goals[agent, roles[agent]] for roles in sharing.roles]
    sides = [
        one if one is other else _split(_weigh(world, agent, test), one, other)
        for test, one, other in zip(sharing.below, cases[::2], cases[1::2], strict=True)
    ]
    return sides[0] if sides[0] is sides[1] else _split(_weigh(world, agent, sharing.root), *sides)


def _weigh(world: World, agent: int, test: Apart) -> Float64:
    """What an agent tests, at most 0, to go left: [n_features]."""
    names = [feature.name for feature in world.features[agent]]
    weights = np.zeros(len(names))
    for entity, sign in zip(test[:2], (1, -1), strict=True):
        if entity != world.agents[agent]:
            weights[names.index(f"{entity}_d{test[2]}")] = sign
    return weights


def _split(weights: Float64, left: GrownTree, right: GrownTree) -> SummedTree:
    """A tree whose root tests that this sum is at most 0."""
    n_features = len(weights)
    sides = [as_summed(each, n_features) for each in (left, right)]
    nodes, sums = (1, 1 + len(left.feature)), (0, len(sides[0].tests))  # where those of each side begin
    moved = list(zip(sides, nodes, sums, strict=True))
    tested = [np.where(each.feature >= n_features, each.feature + first, each.feature) for each, _, first in moved]
    tree = SummedTree(
        feature=np.concatenate([[0], *tested]),
        threshold=np.concatenate([[0.0], *(each.threshold for each in sides)]),
        left=np.concatenate([[nodes[0]], *(_move(each.left, node) for each, node, _ in moved)]),
        right=np.concatenate([[nodes[1]], *(_move(each.right, node) for each, node, _ in moved)]),
        action=np.concatenate([[NO_ACTION], *(each.action for each in sides)]),
        tests=np.concatenate([each.tests for each in sides]),
        given=np.zeros((0, 0, n_features + 1)),
    )
    return with_sum(tree, ROOT, weights, 0.0)


def _move(child: Int32, first: int) -> Int32:
    """Children in a tree whose nodes begin at `first`."""
    return np.where(child == NO_CHILD, NO_CHILD, child + first)
