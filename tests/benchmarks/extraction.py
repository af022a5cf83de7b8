"""How long extraction takes, what it needs, and what histograms cost against exact splits.

    python -m tests.benchmarks.extraction [--full] [--json]

Whole protocol: every iteration of the paper's 100 x 50 rollouts and selection over all iterates, without the default's
refinement, which is ours (its seconds stand beside). By default a tenth of it; --full runs all of it. Then exact
against histogram splits on the same data, interleaved; then time per agent, sample and non-constant feature over N in
navigation, with the scripted expert and measured Q, and whole commands beside fifty lines of numpy and scikit-learn
(navigation_direct.py). --sizes: these alone. --growth: joint growth alone, beside scikit-learn's fits of the points.
"""

import sys
import tempfile
import time
from functools import partial
from pathlib import Path

import numpy as np

from maviper.extraction.settings import REFINEMENT
from tests.benchmarks.common import figure, interleave, reader, spent, spent_by, tell

GAMES = (("physical-deception", 4, 90, 30), ("cooperative-navigation", 6, 240, 90), ("predator-prey", 4, 240, 90))
SIZES = (3, 4, 6, 12, 24)
LINES = Path(__file__).with_name("navigation_direct.py")


def one_run(name, depth, iterations, refinement=0):
    """How a run ended."""
    chosen = {"iterations": iterations, "patience": 1000, "refinement": refinement}
    words = [word for each in chosen.items() for word in ("--set", "{}={}".format(*each))]
    with tempfile.TemporaryDirectory() as folder:
        return spent("extract", name, "--max-depth", depth, *words, "-o", f"{folder}/run.json")


def growth(rounds, episodes=1_000, depth=4):
    """CPU seconds of a joint growth of deception's teams on so many episodes' points, interleaved: by either way of
    searching splits, and by scikit-learn, which fits each agent alone.
    """
    from maviper.episodes.play import play, points
    from maviper.experts import network
    from maviper.experts.expert import labels
    from maviper.extraction.dataset import Dataset
    from maviper.extraction.growth.exact import cart
    from maviper.extraction.growth.growing import Growth
    from maviper.extraction.settings import Settings

    expert, world = network.load("physical-deception")
    met = play(world, [expert] * 3, world.start_from_seeds(range(episodes)))
    observations, state = points(met)
    wanted = labels(expert, observations, state)
    data = Dataset(observations, wanted, np.ones(wanted.shape), np.ones(wanted.shape, bool))
    ones = [np.ones(len(wanted), dtype=np.int64)] * 3

    def grow(way):
        growing = Growth(world, Settings.of({"splits": way, "max_depth": depth}))
        for team in ([0], [1, 2]):
            growing.team(team, data, ones, [0, 0, 0], len(team) - 1)

    def fit():
        for agent in range(3):
            cart(observations[agent], wanted[:, agent], ones[agent], depth, 0)

    ways = {"exact": partial(grow, "exact"), "histogram": partial(grow, "histogram"), "scikit-learn": fit}
    return {way: np.array(took) for way, took in interleave(ways, rounds).items()}


def by_size(n):
    """CPU seconds per agent, sample and non-constant feature of one iteration in navigation with `n` agents: the
    script's rollouts and labels, measured Q, weights and growth.
    """
    from maviper.experts.expert import Measured
    from maviper.experts.scripted import build_script
    from maviper.extraction.dagger import grow_teams, weights
    from maviper.extraction.dataset import collect
    from maviper.extraction.extraction import Extraction
    from maviper.extraction.growth.growing import Growth
    from maviper.extraction.settings import Settings
    from maviper.worlds import find

    world = find(f"cooperative-navigation,agents={n}")
    expert = Measured(world, build_script(world))
    settings = Settings.of({"rollouts": 4})
    weigh = partial(weights, Extraction(world, expert, settings), range(n))
    started = time.process_time()
    data = collect(world, expert, [expert] * n, range(n), settings.rollout_episodes(0), weigh).data
    grow_teams(world, data, settings, Growth(world, settings), range(n), 0)
    seconds = time.process_time() - started
    features = sum(feature.low < feature.high for feature in world.features[0])
    return seconds / (n * len(data) * features)


def main() -> None:
    parser = reader(__doc__)
    parser.add_argument("--full", action="store_true")
    parser.add_argument("--sizes", action="store_true")
    parser.add_argument("--growth", action="store_true")
    options = parser.parse_args()
    asked = [(options.sizes, sizes), (options.growth, partial(joint_growth, 3))]
    parts = [part for wanted, part in asked if wanted] or [partial(protocols, options.full), sizes]
    tell([each for part in parts for each in part()], options.json)


def protocols(full):
    """The figures of whole protocols, or of a tenth of them, and of growth alone."""
    figures, iterations = [], 100 if full else 10
    runs = {game: one_run(game, depth, iterations) for game, depth, *_ in GAMES}
    for game, depth, *targets in GAMES:
        name = f"{game}, depth {depth}, {iterations} iterations, CPU s"
        figures.append(figure(name, runs[game].seconds, *targets * full))
    refined, unrefined = (one_run("physical-deception", 4, 1, spend).seconds for spend in (REFINEMENT, 0))
    name = f"the default's refinement by {REFINEMENT:,} episodes per team, deception, CPU s"
    figures.append(figure(name, refined - unrefined))
    peak = max(run.megabytes for run in runs.values()) / 1024
    figures.append(figure("peak memory of these runs, GB", peak, 1.5, 0.5))
    return [*figures, *joint_growth(5 if full else 2)]


def joint_growth(rounds):
    """The figures of joint growth alone, medians over rounds: every threshold, histograms, scikit-learn's fits."""
    figures = []
    for episodes, depth in ((400, 4), (1_600, 4), (1_600, 6)):
        took, told = growth(rounds, episodes, depth), f"{25 * episodes:,} points, depth {depth}"
        for one, other, *targets in (("exact", "scikit-learn", 3, 1.5), ("histogram", "exact", None, None)):
            ratio = float(np.median(took[one] / took[other]))
            figures.append(figure(f"joint growth, {one} over {other}, {told}, CPU", ratio, *targets))
    return figures


def sizes():
    """The figures of teams of 3 to 24: the median of three runs each. With 3, each state's Q is measured for all 25
    joint actions of the others, with more of them for 5 that are drawn.
    """
    costs = {n: float(np.median([by_size(n) for _ in range(3)])) for n in SIZES}
    text = "navigation, measured Q: CPU us per agent, sample and feature with {} agents"
    figures = [figure(text.format(n), 1e6 * cost) for n, cost in costs.items()]
    for least, *targets in ((3, 1.5, 1.2), (4, None, None)):
        figures.append(figure(f"the same with 24 agents over that with {least}", costs[24] / costs[least], *targets))
    return [*figures, *commands()]


def commands():
    """The figures of whole commands with 24 agents. Three agents have a network with a critic; more have the script,
    whose Q is measured by play, as it is in the other two ratios.
    """
    game, measured = "cooperative-navigation", "the whole command, 30 episodes, 24 agents"
    large, small = by_command(f"{game},agents=24"), by_command(game)
    scripted = by_command(f"{game}@scripted", "--world", game)
    one, other = (spent_by(sys.executable, LINES, n).seconds for n in (24, 3))
    return [
        figure(f"{measured} over 3, CPU", large / small, 8, 5),
        figure(f"{measured} over 3 with the script too, CPU", large / scripted),
        figure("fifty lines of numpy and scikit-learn, 24 agents over 3, CPU", one / other),
        figure(f"{measured}, over the fifty lines, CPU", large / one),
    ]


def by_command(*words):
    """CPU seconds of `extract` with 30 episodes, process start included: the least of three."""
    with tempfile.TemporaryDirectory() as folder:
        runs = [spent("extract", *words, "--max-episodes", "30", "-o", f"{folder}/{k}.json") for k in range(3)]
    return min(run.seconds for run in runs)


if __name__ == "__main__":
    main()
