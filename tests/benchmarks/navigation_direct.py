"""Fifty lines of numpy and scikit-learn that know one game: weighted trees of N agents, who cover as many targets.

    python tests/benchmarks/navigation_direct.py N

Two rounds of seven episodes, weights by Q that is measured over twelve steps beside one draw of the others' actions,
and a thousand episodes of trees and of the expert, much as `maviper extract --max-episodes 30` does. Its expert takes
the least-squares assignment too, but looks one action ahead.
"""

import sys

import numpy as np
from scipy.optimize import linear_sum_assignment
from sklearn.tree import DecisionTreeClassifier

N, STEPS, AHEAD = int(sys.argv[1]), 25, 12
PUSH = 5.0 * np.array([[0, 0], [-1, 0], [1, 0], [0, -1], [0, 1]])
rng = np.random.default_rng(0)


def step(place, speed, goals, acted):
    gaps = place[:, :, None] - place[:, None]
    squared, push = np.square(gaps).sum(axis=-1), PUSH[acted]
    near = np.nonzero((squared < 0.1) & (squared > 0))  # farther apart nobody pushes
    far = np.sqrt(squared[near])
    np.add.at(push, near[:2], (0.1 * np.logaddexp(0, (0.3 - far) / 1e-3) / far)[:, None] * gaps[near])
    return place + 0.1 * speed, 0.75 * speed + 0.1 * push, goals


def expert(place, speed, goals):
    costs = np.square(place[:, :, None] - goals[:, None]).sum(axis=-1)
    chosen = np.array([linear_sum_assignment(cost)[1] for cost in costs])
    left = np.take_along_axis(goals, chosen[..., None], axis=1) - place - 0.4 * speed
    return np.square(left[..., None, :] - 0.04 * PUSH).sum(axis=-1).argmin(axis=-1)


def paid(place, goals, agent):
    nearest = np.sqrt(np.square(place[:, :, None] - goals[:, None]).sum(axis=-1).min(axis=1)).sum(axis=1)
    return -nearest - (np.linalg.norm(place - place[:, agent, None], axis=-1) < 0.3).sum(axis=1)


def observe(place, speed, goals, agent):
    here = place[:, agent, None]
    return np.hstack(
        [speed[:, agent], place[:, agent], *((each - here).reshape(len(place), -1) for each in (goals, place))]
    )


def play(count, act):
    state, met = (rng.uniform(-1, 1, (count, N, 2)), np.zeros((count, N, 2)), rng.uniform(-1, 1, (count, N, 2))), []
    for _ in range(STEPS):
        met.append(state)
        state = step(*state, act(*state))
    return [np.concatenate(part) for part in zip(*met, strict=True)]


def weights(state, wanted, agent):
    acted = np.repeat(rng.integers(5, size=(len(wanted), N)), 5, axis=0)
    acted[:, agent] = np.tile(np.arange(5), len(wanted))
    branch, total = [np.repeat(part, 5, axis=0) for part in state], 0.0
    for ahead in range(AHEAD):
        branch = step(*branch, acted)
        total = total + 0.95**ahead * paid(branch[0], branch[2], agent)
        acted = expert(*branch) if ahead < AHEAD - 2 else acted
    total = total.reshape(-1, 5)
    return np.take_along_axis(total, wanted[:, agent, None], axis=1)[:, 0] - total.min(axis=1)


def decide(*state):
    return np.stack([tree.predict(observe(*state, agent)) for agent, tree in enumerate(trees)], axis=1)


data, trees = [], []
for _ in range(2):
    met = play(7, decide if trees else expert)
    wanted = expert(*met)
    data.append((met, wanted, [weights(met, wanted, agent) for agent in range(N)]))
    trees = []
    for agent in range(N):
        rows = np.concatenate([observe(*met, agent) for met, _, _ in data])
        labels, weight = (
            np.concatenate(each) for each in zip(*((w[:, agent], q[agent]) for _, w, q in data), strict=True)
        )
        trees.append(DecisionTreeClassifier(max_depth=4).fit(rows, labels, sample_weight=weight))
for act in (decide, expert):
    met = play(1_000, act)
    print(act.__name__, np.mean([paid(met[0], met[2], agent).mean() for agent in range(N)]))
