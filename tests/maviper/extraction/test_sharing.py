"""One tree for a team: the same for all its agents, grown from the points of all, voted on by all."""

import numpy as np
import pytest

from codegen.errors import InputError
from maviper.evaluation import held_out
from maviper.experts.finding import find_expert
from maviper.extraction.algorithms import extract
from maviper.extraction.dataset import Dataset
from maviper.extraction.growth.growing import Growth, pool_points
from maviper.extraction.settings import TEAM, Settings
from maviper.worlds import find

SMALL = {"iterations": 2, "rollouts": 8, "selection_episodes": 6, "max_depth": 3, "share": TEAM}


@pytest.fixture(autouse=True)
def quick(monkeypatch):
    monkeypatch.setattr(held_out, "EVALUATION_EPISODES", 8)


@pytest.fixture(scope="module")
def navigation():
    return find_expert("cooperative-navigation")


def columns(tree):
    return [getattr(tree, name).tolist() for name in ("feature", "threshold", "left", "right", "action")]


@pytest.mark.parametrize("algorithm", ["maviper", "maviper-no-prediction", "iviper", "imitation"])
@pytest.mark.parametrize("splits", ["exact", "histogram"])
def test_all_agents_of_a_team_get_the_same_tree(navigation, algorithm, splits):
    expert, world = navigation
    profile = extract(world, expert, Settings.of({"algorithm": algorithm, "splits": splits, **SMALL}, world))
    first, *others = [columns(policy.tree) for policy in profile.agents]
    assert len(others) == 2 and all(other == first for other in others)
    assert len(first[0]) > 1 and profile.provenance.training["share"] == TEAM
    again = extract(world, expert, Settings.of({"algorithm": algorithm, "splits": splits, **SMALL}, world))
    assert columns(again.agents[0].tree) == first


def random_points(n=200, members=3):
    rng = np.random.default_rng(0)
    seen = tuple(rng.normal(size=(n, 4)).astype(np.float32) for _ in range(members))
    labels = np.stack([(each[:, 0] > each[:, 1]).astype(int) + (each[:, 2] > 0) for each in seen], axis=1)
    alive = rng.random((n, members)) < 0.8
    return Dataset(seen, labels, np.ones((n, members)), alive)


class Three:
    """A world of which growth needs only the numbers of actions, and that there are no outputs."""

    actions, outputs = ((0, 1, 2),) * 3, ()


@pytest.mark.parametrize("splits", ["exact", "histogram"])
def test_without_votes_it_is_the_tree_of_one_agent_that_met_all_points(splits):
    data = random_points()
    counts = data.alive.astype(int).T
    part = pool_points(data, [0, 1, 2], counts)
    alone = Dataset((part.obs,) * 3, np.stack([part.labels] * 3, 1), np.ones((600, 3)), np.stack([part.alive] * 3, 1))
    settings = {"splits": splits, "max_depth": 4}
    shared = Growth(Three(), Settings(**settings, share=TEAM)).team([0, 1, 2], data, counts, [5] * 3, 0)
    (wanted,) = Growth(Three(), Settings(**settings)).team([0], alone, [part.counts] * 3, [5] * 3, 0)
    assert all(columns(tree) == columns(wanted) for tree in shared)
    assert part.obs[:3].tolist() == [data.observations[k][0].tolist() for k in range(3)]


def test_a_vote_drops_a_point_for_all_who_share():
    """One agent's labels are noise: where all must be right, its points take the others' along."""
    data = random_points()
    data.labels[:, 2] = np.random.default_rng(1).integers(3, size=len(data))
    counts, kept, all_kept = np.ones((3, 200), int), [], []
    growth = Growth(Three(), Settings(max_depth=3, share=TEAM))
    growth.team([0, 1, 2], data, counts, [0] * 3, 3, kept)
    growth.team([0, 1, 2], data, counts, [0] * 3, 0, all_kept)
    assert all_kept == [1.0] * 3 and all(0 < share < 0.8 for share in kept)
    assert all(round(share * 200) == pytest.approx(share * 200) for share in kept)  # whole points


def test_unequal_spaces_are_refused():
    world = find("tests.support.environments:unequal")
    with pytest.raises(InputError, match="left_runner and runner_1 cannot share a tree"):
        extract(world, None, Settings.of({"algorithm": "iviper", **SMALL}, world))
