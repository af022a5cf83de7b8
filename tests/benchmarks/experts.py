"""How good the shipped experts are, beside the targets: 1,000 episodes that nothing else uses, worse ends of intervals.

    python -m tests.benchmarks.experts [--all] [--json]

--all: every shipped seed, not only the default ones. Training times are those of the cards; they belong to the machine
that the card names.

"""

import json
from importlib import resources

import numpy as np

from maviper.episodes import measures
from maviper.episodes.play import play
from maviper.experts import network
from maviper.experts.scripted import build_script
from maviper.worlds.games.predator_prey import PREDATORS
from tests.benchmarks.common import figure, reader, tell

SEEDS = range(9_100_000, 9_101_000)
# (world, label of the measure) -> (reach, stretch)
TARGETS = {
    ("physical-deception", "defenders success r=0.316"): (0.98, 0.99),
    ("physical-deception", "defenders success r=0.1"): (0.60, 0.90),
    ("physical-deception", "adversaries success r=0.316"): (0.55, 0.64),
    ("physical-deception,velocity=1", "defenders success r=0.316"): (0.98, 0.99),
    ("physical-deception,velocity=1", "defenders success r=0.1"): (0.60, 0.90),
    ("physical-deception,velocity=1", "adversaries success r=0.316"): (0.55, 0.64),
    ("cooperative-navigation", "agents D + collisions"): (0.70, 0.60),
}
RATIO_TARGETS = {"predators": (1.25, 1.5), "prey": (0.80, 0.60)}
TIME_TARGETS = (15 * 60, 3 * 60)


def card_of(name):
    stem = network.SHIPPED[name].removesuffix(".safetensors")
    return json.loads((resources.files("maviper.experts.shipped") / f"{stem}.json").read_text())


def of_expert(name):
    expert, world = network.load(name)
    among = measures.evaluate(world, [expert] * len(world.agents), SEEDS)
    for measure in world.measures:
        found = among[measure]
        worse = found.interval[1 if measure.lower_is_better else 0]
        reach, stretch = TARGETS.get((world.name, measure.label), (None, None))
        better = "lower" if measure.lower_is_better else "higher"
        yield figure(f"{name}: {measure.label} {measures.format_estimate(found)}", worse, reach, stretch, better)
    if PREDATORS in world.teams:
        yield from touches(name, world, expert)
    yield figure(f"{name}: training seconds", card_of(name)["seconds"], *TIME_TARGETS, "lower")


def touches(name, world, expert):
    """Against fixed scripts, in the scripts' touches; the worse end of a bootstrap over common episodes."""
    script, rng = build_script(world), np.random.default_rng(0)
    episodes = world.start_from_seeds(SEEDS)
    draws = rng.integers(len(SEEDS), size=(2_000, len(SEEDS)))
    base = play(world, [script] * len(world.agents), episodes).values[0]
    for team in world.teams:
        mixed = [expert if agent in world.members(team) else script for agent in range(len(world.agents))]
        ours = play(world, mixed, episodes).values[0]
        ratios = ours[draws].mean(axis=1) / base[draws].mean(axis=1)
        low, high = np.quantile(ratios, (0.025, 0.975))
        lower = world.primary(team).lower_is_better
        text = f"{name}: {team} against the script, ratio {ours.mean() / base.mean():.3f} [{low:.3f}, {high:.3f}]"
        yield figure(text, high if lower else low, *RATIO_TARGETS[team], "lower" if lower else "higher")


def main() -> None:
    parser = reader(__doc__)
    parser.add_argument("--all", action="store_true")
    options = parser.parse_args()
    names = [name for name in network.SHIPPED if options.all or "@" not in name]
    tell((found for name in names for found in of_expert(name)), options.json)


if __name__ == "__main__":
    main()
