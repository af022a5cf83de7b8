"""What teams of trees are worth in a coordination game, summed over all that may be hidden and read."""

from itertools import product

import numpy as np

from codegen import ir


def worth(world, policies):
    """The expected payoff of a team, without sampling."""
    cells, n_agents = world.cells, len(policies)
    rules = [ir.act(policy, cells.astype(np.float32)) for policy in policies]
    read = np.array(list(product(range(len(cells)), repeat=n_agents)))
    chosen = np.stack([rule[read[:, agent]] for agent, rule in enumerate(rules)], axis=1)
    total = 0.0
    for hidden, demanded in enumerate(world.demanded):
        likely = [world.likelihood(world.kind(agent))[hidden, read[:, agent]] for agent in range(n_agents)]
        total += np.prod(likely, axis=0) @ world.payoff((chosen - demanded) % world.conventions)
    return total / len(cells)


def followed(world, depth, inside):
    """Every rule (the convention in each cell) that trees of a depth follow in the cells `inside`; None elsewhere."""
    cells = range(len(world.cells))
    found = {tuple(each if cell in inside else None for cell in cells) for each in range(world.conventions)}
    for signal, level in product(range(world.signals), range(world.levels)) if depth else ():
        left = {cell for cell in inside if world.cells[cell, signal] <= level}
        for low, high in product(followed(world, depth - 1, left), followed(world, depth - 1, inside - left)):
            found.add(tuple(low[cell] if cell in left else high[cell] for cell in cells))
    return found


def best_of_three(world, depth):
    """The most that three agents of two kinds can reach where all must be right. Agents 0 and 2, of one kind, have one
    rule: of two rules p and q, sum_c w_c p_c q_c with w >= 0 is at most the larger of sum_c w_c p_c^2 and of q's.
    """
    rules = np.array(sorted(followed(world, depth, set(range(len(world.cells))))))

    def right(kind):
        """How likely an agent with each rule is right in each hidden state, [n_rules, n_hidden]."""
        read = world.likelihood(kind)
        return np.stack([(rules == each) @ read[hidden] for hidden, each in enumerate(world.demanded)], axis=1)

    return (right(0) ** 2 @ right(1).T).max() / len(world.cells)
