"""Tables of a reproduction that nobody played: values with known effects, in the form that cells are kept in."""

import csv
import functools
import hashlib
import json
import zlib
from itertools import product

import numpy as np

from maviper.reproduction.cells.table import COLUMNS, EPISODE_COLUMNS
from maviper.worlds import find
from maviper.worlds.world import RETURN, Measure

DECEPTION, NAVIGATION, PREDATORS = "physical-deception", "cooperative-navigation", "predator-prey"
GAMES = (DECEPTION, NAVIGATION, PREDATORS)
FOUR = ("maviper", "iviper", "imitation", "fitted-q")
ABLATIONS = ("maviper-no-prediction", "maviper-iviper-resampling")
ORDERED = dict(zip((*FOUR, *ABLATIONS), (0.85, 0.6, 0.4, 0.05, 0.7, 0.65), strict=True))  # of the expert's
EXPERT = 0.9
EPISODES = 24
FIRST = 3_000_000


@functools.cache
def hardness(episode):
    """What an episode adds to everybody's values; to make a generator takes longer than to draw from it."""
    return np.random.default_rng(episode).normal()


class Maker:
    """Writes cells into a folder. `strength`: algorithm -> its share of the expert's performance."""

    def __init__(self, folder, strength=ORDERED, noise=0.02, seeds=6, shared=False):
        self.folder, self.strength, self.noise, self.seeds, self.shared = folder, strength, noise, seeds, shared
        self.rows = []

    def episodes(self, seed):
        block = 0 if self.shared else seed
        return range(FIRST + EPISODES * block, FIRST + EPISODES * (block + 1))

    def values(self, measure, share, episodes, key):
        """Values around a share of the expert's; some episodes are hard for everybody."""
        hard = np.array([hardness(each) for each in episodes])
        own = np.random.default_rng(zlib.crc32(key.encode()))
        drawn = share + self.noise * (hard + own.normal() / 2 + own.normal(size=len(hard)))
        if measure.name == RETURN:
            return 5 * (drawn - 1)
        return EXPERT / np.maximum(drawn, 0.01) if measure.lower_is_better else EXPERT * drawn

    def cell(self, about, episodes, lineups, facts):
        """`lineups`: name -> [(measure, the values in each episode)]."""
        about = {"preset": "", "algorithm": "", "depth": 0, "leaves": 0, "splits": "", "seed": 0, **about}
        id_ = hashlib.sha256(json.dumps(about, sort_keys=True).encode()).hexdigest()[:16]
        place = self.folder / "cells" / id_
        place.mkdir(parents=True, exist_ok=True)
        with (place / "episodes.csv").open("w", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(EPISODE_COLUMNS)
            for lineup, measured in lineups.items():
                for measure, values in measured:
                    label = measure if isinstance(measure, str) else measure.label
                    higher = int(isinstance(measure, str) or not measure.lower_is_better)
                    pairs = zip(episodes, values.tolist(), strict=True)
                    writer.writerows([lineup, label, each, repr(value)] for each, value in pairs)
                    row = {**about, "cell": id_, "lineup": lineup, "measure": label, "higher_is_better": higher}
                    self.rows.append({**row, "episodes": len(values), "mean": float(values.mean()), "cpu_seconds": 1.5})
        (place / "facts.json").write_text(json.dumps(facts))
        return id_

    def write(self):
        with (self.folder / "cells.csv").open("w", newline="") as file:
            writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
            writer.writeheader()
            writer.writerows(self.rows)
        return self.folder

    # --- cells of each kind

    def played(self, world, lineups, episodes, key):
        """lineups: name -> (teams whose measures are kept, share of the expert's)."""
        found = {}
        for name, (teams, share) in lineups.items():
            measures = [each for each in world.measures if each.team in teams]
            measures += [Measure(team, RETURN) for team in teams]
            found[name] = [
                (each, self.values(each, share, episodes, f"{key} {name} {each.label}")) for each in measures
            ]
        return found

    def expert(self, game, label="mappo"):
        """A cell for each ten seeds."""
        world = find(game)
        for first in range(0, 1 if self.shared else self.seeds, 10):
            last = 1 if self.shared else min(first + 10, self.seeds)
            episodes = range(FIRST + EPISODES * first, FIRST + EPISODES * last)
            lineups = self.played(world, {"expert": (tuple(world.teams), 1.0)}, episodes, game)
            self.cell({"kind": "expert", "game": game, "expert": label, "seed": first}, episodes, lineups, {})

    def extraction(self, game, algorithm, depth, seed, label="mappo", **about):
        world, share = find(game), self.strength.get(algorithm, 0.5)
        lineups = {f"joint:{team}": ((team,), share) for team in world.teams}
        lineups |= {f"individual:{agent}": ((world.team_of(agent),), (1 + share) / 2) for agent in world.agents}
        lineups["all"] = tuple(world.teams), share
        about = {"preset": "paper", "splits": "histogram", **about, "algorithm": algorithm, "depth": depth}
        about |= {"kind": "extraction", "game": game, "expert": label, "seed": seed}
        key = f"{label} {game} {algorithm} {depth} {seed}"
        played = self.played(world, lineups, self.episodes(seed), key)
        return self.cell(about, self.episodes(seed), played, self.facts(world, algorithm, depth))

    def facts(self, world, algorithm, depth):
        told = {"trees": {agent: {"leaves": 2**depth, "depth": depth} for agent in world.agents}}
        told["importances"] = {
            agent: {
                "impurity": looks(features, place, algorithm),
                "tested": dict.fromkeys([each.name for each in features], 0.25),
            }
            for place, (agent, features) in enumerate(zip(world.agents, world.features, strict=True))
        }
        return told

    def crossplay(self, game, seed, label="mappo", players=(*FOUR, "expert")):
        world = find(game)
        lineups = {
            f"{team}:{one}-vs-{other}": ((team,), self.strength.get(one, 1.0))
            for team, one, other in product(world.teams, players, players)
        }
        about = {"kind": "crossplay", "game": game, "expert": label, "preset": "paper", "depth": 4}
        about |= {"splits": "histogram", "seed": seed}
        played = self.played(world, lineups, self.episodes(seed), f"{label} {game} {seed}")
        return self.cell(about, self.episodes(seed), played, {})

    def exploitability(self, algorithm, seed, label="mappo"):
        share, episodes, found = self.strength[algorithm], self.episodes(seed), {}
        for team, (name, gain) in product(
            ("defenders", "adversaries"), (("own opponents", 0.0), ("expert", 1 - share))
        ):
            for ending in ("", ":chosen-on"):
                key = f"{algorithm} {seed} {team} {name}{ending}"
                rng = np.random.default_rng(zlib.crc32(key.encode()))
                values = 0.3 + gain + self.noise * rng.normal(size=len(episodes))
                found[f"{team}:{name}{ending}"] = [("worth", values), ("return", 2 * values)]
        about = {"kind": "exploitability", "game": DECEPTION, "expert": label, "preset": "paper", "depth": 4}
        about |= {"splits": "histogram", "seed": seed, "algorithm": algorithm}
        return self.cell(about, episodes, found, {})


def looks(features, place, algorithm):
    """Importances of a defender: MAVIPER's second and third agents look at a target each, all others at the goal."""
    wanted = f"landmark_{place % 2}" if algorithm == "maviper" else "goal"
    names = [feature.name for feature in features]
    mine = [name for name in names if name.startswith(wanted)]
    return {name: 1 / len(mine) if name in mine else 0.0 for name in names}


def whole(folder, games=GAMES, depths=(2, 4, 6), experts=("mappo",), **rest):
    """Everything that the default tier plays."""
    return filled(Maker(folder, **rest), games, depths, experts)


def filled(maker, games, depths, experts):
    """The same by a maker of one's own; its folder."""
    for label, game in product(experts, games):
        maker.expert(game, label)
        for algorithm, depth, seed in product(FOUR, depths, range(maker.seeds)):
            maker.extraction(game, algorithm, depth, seed, label)
        for seed in range(maker.seeds):
            if game != NAVIGATION:
                maker.crossplay(game, seed, label)
            if game == DECEPTION:
                for algorithm in ABLATIONS:
                    maker.extraction(game, algorithm, 4, seed, label)
                for algorithm in FOUR:
                    maker.exploitability(algorithm, seed, label)
        maker.extraction(game, "maviper", 4, 0, label, splits="exact")
    return maker.write()
