"""How good experts are against a fixed panel: the scripts, the clones of scripts, the experts that learned by reward.

    python tests/benchmarks/panel.py [WORLD ...] [--also FILE ...] [--episodes 4000] [--json] [--demand] [--write]

Every member of the panel plays each team of its world against every member's other teams, on held-out episodes. A row
gives a team's primary measure as the mean over the panel and against the member that is worst for it. --also adds
subjects, which are nobody's opponents. --demand measures what a team's members must agree on instead (cross-seed gap,
shares of roles); --write puts that into the cards beside the shipped experts.
"""

import argparse
import json
from importlib import resources
from pathlib import Path

import numpy as np

from maviper.episodes import measures
from maviper.experts import network
from maviper.experts.demand import demand
from maviper.experts.scripted import build_script
from maviper.files import runs
from maviper.worlds import find
from maviper.worlds.games.particle import planes
from maviper.worlds.games.physical_deception import ADVERSARIES

WORLDS = (
    "physical-deception",
    "physical-deception,velocity=1",
    "physical-deception,shuffled=1",
    "cooperative-navigation",
    "predator-prey",
    "predator-prey,observation=mpe2",
)
FIRST = 12_000_000  # of the held-out episodes; nothing else uses them
RANDOM_LANDMARK = "random-landmark"
# (world, team) -> (reach, stretch), or the subject whose worst or mean figure is to be reached
TARGETS = {
    ("physical-deception", "defenders"): (0.99, 0.99),
    ("physical-deception,velocity=1", "defenders"): (0.99, 0.99),
    ("cooperative-navigation", "agents"): (0.70, 0.62),
}


class RandomLandmark:
    """An adversary that lands on a landmark which chance has chosen for the episode; all others as the script.

    Chance is the last bits of the first landmark's x, which stay what they are throughout an episode.
    """

    def __init__(self, world):
        self.script, self.n_agents = build_script(world), len(world.agents)

    def act(self, agents, observations, state):
        position, velocity = planes(state.position), planes(state.velocity)
        marks = position[self.n_agents :]
        chosen = (np.abs(marks[0, 0]) * 2**40).astype(np.int64) % len(marks)
        target = np.take_along_axis(marks, chosen[None, None], axis=0)[0]
        acted = self.script.act(agents, observations, state)
        for column, agent in enumerate(agents):
            if agent == 0:
                acted[:, column] = self.script._landing(0, target - position[0], velocity[0])
        return acted


def panel(name):
    """Member -> controller of all agents: the scripts, and every shipped seed."""
    world = find(name)
    members = {"scripted": build_script(world)}
    for each, seeds in ((network.CLONES, "clone"), (network.LEARNED, "reward")):
        stem, numbers, _ = each.get(name, ("", (), 0))
        members |= {f"{seeds} {seed}": network.load_shipped(network.file_of(stem, seed)) for seed in numbers}
    return world, members


def judged(world, subjects, opponents, episodes):
    """(team, subject) -> opponent -> the team's primary measure."""
    seeds = range(FIRST, FIRST + episodes)
    found = {}
    for name, subject in subjects.items():
        everybody = [subject] * len(world.agents)
        for opponent, other in ({name: subject} if len(world.teams) == 1 else opponents).items():
            values = measures.team_values(world, everybody, [other] * len(everybody), seeds)
            for team in world.teams:
                measure = navigation(world) or world.primary(team)
                found.setdefault((team, name), {})[opponent] = float(values[measure].mean())
    return found


def navigation(world):
    """D, the paper's measure, in the game whose primary measure adds collisions."""
    return next((measure for measure in world.measures if measure.name == "D"), None)


def figures(name, also, episodes):
    world, members = panel(name)
    subjects = {**members, **{path: network.load(path)[0] for path in also}}
    if ADVERSARIES in world.teams:
        subjects[RANDOM_LANDMARK] = RandomLandmark(world)
    for (team, subject), against in judged(world, subjects, members, episodes).items():
        if subject == RANDOM_LANDMARK and team != ADVERSARIES:
            continue
        measure = navigation(world) or world.primary(team)
        worst = (max if measure.lower_is_better else min)(against.values())
        reach, stretch = TARGETS.get((name, team), (None, None))
        yield {
            "name": f"{name}: {team} {measure.name}, {subject}",
            "value": float(np.mean(list(against.values()))),
            "worst": worst,
            "against": against,
            "reach": reach,
            "stretch": stretch,
            "better": "lower" if measure.lower_is_better else "higher",
        }


def demands(name, episodes, write):
    """What the team of each shipped expert must agree on."""
    world = find(name)
    for table in (network.CLONES, network.LEARNED):
        stem, seeds, _ = table.get(name, ("", (), 0))
        experts = {seed: network.load_shipped(network.file_of(stem, seed)) for seed in seeds}
        for seed in seeds:
            found = demand(world, experts, seed, range(FIRST, FIRST + episodes))
            if write:
                place = Path(str(resources.files("maviper.experts.shipped"))) / f"{stem}.{seed}.json"
                place.write_text(runs.as_json({**json.loads(place.read_text()), "demand": found}))
            yield {"name": f"{stem}.{seed}", **found}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("worlds", nargs="*", default=WORLDS)
    parser.add_argument("--also", nargs="*", default=[])
    parser.add_argument("--episodes", type=int, default=4_000)
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--demand", action="store_true")
    parser.add_argument("--write", action="store_true")
    options = parser.parse_args()
    if options.demand or options.write:
        found = [each for name in options.worlds for each in demands(name, options.episodes, options.write)]
        print(json.dumps(found, indent=1))
        return
    found = [each for name in options.worlds for each in figures(name, options.also, options.episodes)]
    if options.json:
        print(json.dumps({"figures": found}))
        return
    for each in found:
        print(f"{each['name']}: {each['value']:.3f}, worst {each['worst']:.3f}")


if __name__ == "__main__":
    main()
