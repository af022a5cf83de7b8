"""Figures 2, 6 and 7 of the paper, with all rounds, from the cells of this record (needs numpy): python figures.py

Figure 2 is the performance of single trees among experts, figures 6 and 7 the reward of single trees and of teams. Each
row has the ratio to the expert of MAVIPER, IVIPER and imitation, mean over ten seeds, and what MAVIPER has more than
IVIPER, with the 95 % interval. A reward is 1 less what is lost, in parts of the mean size of the expert's.
"""

from itertools import product

import numpy as np
from recompute import CELLS, LOWER, interval

ALGORITHMS = ("maviper-every-round", "iviper", "imitation")
TEAMS = {
    "defenders": ("physical-deception", "defenders success r=0.316"),
    "adversaries": ("physical-deception", "adversaries success r=0.316"),
    "navigation": ("cooperative-navigation", "agents D"),
    "predators": ("predator-prey", "predators touches"),
    "prey": ("predator-prey", "prey touches"),
}


def ratio(document, lineups, label):
    """The mean over line-ups of the ratio to the expert."""
    theirs = document["values"]["expert"][label]
    ours = [of[label]["mean"] for name, of in document["values"].items() if name.startswith(lineups) and label in of]
    mean, scale = theirs["mean"], theirs.get("size", abs(theirs["mean"]))
    return np.mean([mean / each if label in LOWER else 1 + (each - mean) / scale for each in ours])


def row(team, game, label, lineups, expert, depth):
    """One row."""
    values = []
    for algorithm in ALGORITHMS:
        names = [f"{game}.{expert}.paper.{algorithm}.depth-{depth}.seed-{seed}.json" for seed in range(100, 110)]
        values.append([ratio(CELLS[name], lineups, label) for name in names])
    lead = np.subtract(values[0], values[1])
    low, high = interval(lead)
    means = " / ".join(f"{np.mean(each):.3f}" for each in values)
    return f"  {team}, {expert.upper()}, depth {depth}: {means}, lead {lead.mean():+.3f} [{low:+.3f}, {high:+.3f}]"


for title, start, reward in (
    ("figure 2, single trees", "individual:", False),
    ("figure 6, reward of single trees", "individual:", True),
    ("figure 7, reward of teams", "joint:", True),
):
    print(title)
    for (team, (game, measure)), expert, depth in product(TEAMS.items(), ("maddpg", "mappo"), (2, 4, 6)):
        member = measure.partition(" ")[0]
        print(row(team, game, f"{member} return" if reward else measure, start, expert, depth))
