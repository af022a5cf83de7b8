"""The best joint trees of coordination games: against brute force, and against play."""

from itertools import combinations, product

import numpy as np
import pytest

from maviper.worlds import find
from tests.support.optimum import Search, optimum, rules_of_depth, worth


def by_hand(world, rules):
    """The expected payoff of rules [n_agents, n_cells], summed over hidden states and everybody's readings."""
    n_cells, agents = len(world.cells), range(len(world.agents))
    likelihoods = [world.likelihood(world.kind(agent)) for agent in agents]
    total = 0.0
    for hidden in range(n_cells):
        read = np.array(list(product(range(n_cells), repeat=len(agents))))
        likely = np.prod([likelihoods[agent][hidden, read[:, agent]] for agent in agents], axis=0)
        chosen = np.stack([rules[agent][read[:, agent]] for agent in agents], axis=1)
        total += likely @ world.payoff((chosen - world.demanded[hidden]) % world.conventions)
    return total / n_cells


SMALL = [
    "coordination,agents=2,signals=2,noise=10",
    "coordination,signals=2,conventions=2,payoff=30,noise=15",
    "coordination,signals=2,payoff=60,agree=70,kinds=3,blur=25,table=4",
    "coordination,signals=2,rule=climbing,noise=10",
    "coordination,agents=4,signals=1,rule=penalty,kinds=1,noise=20",
    "coordination,agents=2,signals=1,levels=3,rule=climbing,table=2",
]


@pytest.mark.parametrize("name", SMALL)
def test_worth_is_the_expected_payoff(name):
    world, rng = find(name), np.random.default_rng(0)
    for _ in range(10):
        rules = rng.integers(world.conventions, size=(len(world.agents), len(world.cells)))
        assert worth(world, rules) == pytest.approx(by_hand(world, rules), abs=1e-12)


def followed(world, depth, inside):
    """All rules of trees, the simple way: a set of tuples over the cells `inside`, None elsewhere."""
    cells = range(len(world.cells))
    found = {tuple(each if cell in inside else None for cell in cells) for each in range(world.conventions)}
    for signal, level in product(range(world.signals), range(world.levels)) if depth else ():
        left = {cell for cell in inside if world.cells[cell, signal] <= level}
        for low, high in product(followed(world, depth - 1, left), followed(world, depth - 1, inside - left)):
            found.add(tuple(low[cell] if cell in left else high[cell] for cell in cells))
    return found


@pytest.mark.parametrize("depth", [0, 1, 2])
@pytest.mark.parametrize("name", ["coordination", "coordination,signals=2,levels=3,conventions=2", *SMALL[4:]])
def test_rules_are_those_that_trees_follow(name, depth):
    world = find(name)
    found = rules_of_depth(world, depth)
    assert {tuple(rule) for rule in found.tolist()} == followed(world, depth, set(range(len(world.cells))))
    assert len(np.unique(found, axis=0)) == len(found)


@pytest.mark.slow
@pytest.mark.parametrize("name", [*SMALL, "coordination,agents=2,signals=2,agree=40,payoff=80,table=7"])
def test_no_team_is_better_by_brute_force(name):
    """All teams of distinct rules; what a rule is worth is tested above."""
    world = find(name)
    rules, found = rules_of_depth(world, 1), optimum(world, 1)
    assert found.worth == pytest.approx(by_hand(world, found.rules), abs=1e-12)
    teams = product(range(len(rules)), repeat=len(world.agents))
    best = max(worth(world, rules[list(team)]) for team in teams)
    assert found.worth == pytest.approx(best, abs=1e-12)


@pytest.mark.parametrize("n_agents", [2, 3, 4, 5])
def test_branch_and_bound_against_brute_force_on_random_pairs(n_agents):
    rng, nodes = np.random.default_rng(n_agents), 0
    for _ in range(20):
        sizes = rng.integers(2, 6, size=n_agents)
        pairs = {(a, b): rng.normal(size=(sizes[a], sizes[b])) for a, b in combinations(range(n_agents), 2)}
        search = Search(pairs, n_agents)
        search.run()
        best = max(search.value(team) for team in product(*map(range, sizes)))
        assert search.reached == pytest.approx(best) == search.value(search.best)
        nodes += search.nodes
    assert n_agents < 4 or nodes > 20  # bounds that always close at once would show nothing
