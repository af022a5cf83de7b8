"""What trees keep of an expert: every algorithm and preset beside each other, over extraction seeds.

    python -m tests.benchmarks.quality [EXPERT] [--seeds 3] [--algorithms a,b] [--presets a,b] [--max-depth 4]
                                       [--critic learned|measured|none] [--set NAME=VALUE] [--cross] [--demo]
                                       [--jobs 2] [--full] [--json]

One row a team, measure, algorithm and preset: the mean over seeds against expert opponents on 1,000 held-out episodes
(the same ones for all), the expert's own, the ratio (the inverse where lower is better), each with the 95 % interval of
a bootstrap over seeds and episodes; leaves and seconds per run. --full: 10 seeds. --cross: the first algorithm's and
preset's teams against the trees of every other algorithm of that preset too (the paper's robustness table). --demo: the
demo's small extraction. Settings are the preset's, early stopping included.
"""

import time

import numpy as np

from maviper import tour as demo
from maviper.episodes import measures
from maviper.episodes.play import tree_policies
from maviper.experts.finding import find_expert
from maviper.extraction.algorithms import extract
from maviper.extraction.settings import FITTED_Q, RELEASED, Settings
from maviper.files.jobs import side_by_side
from tests.benchmarks.common import figure, reader, tell

EPISODES, DRAWS = 1_000, 2_000
ALGORITHMS = ("maviper", "iviper", "imitation", "fitted-q", "maviper-no-prediction", "maviper-iviper-resampling")
# expert, depth, team, measure -> reach, stretch, of what
TARGETS = {
    ("physical-deception", 4, "defenders", "success r=0.316"): (0.98, 1.00, "ratio"),
    ("physical-deception", 4, "defenders", "success r=0.1"): (0.85, 0.95, "ratio"),
    ("physical-deception", 4, "adversaries", "success r=0.316"): (0.58, 0.64, "value"),
    ("predator-prey", 4, "predators", "touches"): (0.80, 0.95, "ratio"),
    ("predator-prey", 4, "prey", "touches"): (1.00, 1.10, "ratio"),
    ("cooperative-navigation", 4, "agents", "D"): (0.80, 0.70, "value"),
    ("cooperative-navigation", 6, "agents", "D"): (0.69, 0.60, "value"),
}
SEEDS = range(measures.MEASUREMENT_SEEDS, measures.MEASUREMENT_SEEDS + EPISODES)


def one(name, critic, given):
    """One extraction: its policies, each measure in each episode, leaves and seconds."""
    expert, world = find_expert(name, critic)
    started = time.perf_counter()
    profile = extract(world, expert, Settings.of(given))
    seconds = time.perf_counter() - started
    trees = tree_policies(profile.agents)
    agents = len(world.agents)
    found = measures.team_values(world, [trees] * agents, [expert] * agents, SEEDS)
    leaves = sum(int((policy.tree.feature < 0).sum()) for policy in profile.agents)
    return profile.agents, {measure.label: row for measure, row in found.items()}, leaves, seconds


def interval(values, base=None, lower=False, rng=None):
    """Mean of values [seeds, episodes], or its ratio to base [episodes], with a bootstrap interval."""
    rng = np.random.default_rng(0)

    def of(seeds, episodes):
        mean = values[np.ix_(seeds, episodes)].mean()
        if base is None:
            return mean
        theirs = base[episodes].mean()
        return theirs / mean if lower else mean / theirs

    n_seeds, n_episodes = values.shape
    point = of(np.arange(n_seeds), np.arange(n_episodes))
    draws = [of(rng.integers(n_seeds, size=n_seeds), rng.integers(n_episodes, size=n_episodes)) for _ in range(DRAWS)]
    return [float(number) for number in (point, *np.quantile(draws, (0.025, 0.975)))]


def text(found):
    return f"{found[0]:.3f} [{found[1]:.3f}, {found[2]:.3f}]"


def main() -> None:
    parser = reader(__doc__)
    parser.add_argument("expert", nargs="?", default="physical-deception")
    parser.add_argument("--seeds", type=int, default=None)
    parser.add_argument("--algorithms", default="maviper")
    parser.add_argument("--presets", default="default")
    parser.add_argument("--max-depth", type=int, default=4)
    parser.add_argument("--critic", default="learned")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE")
    parser.add_argument("--cross", action="store_true")
    parser.add_argument("--demo", action="store_true")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--full", action="store_true")
    options = parser.parse_args()
    seeds = range(options.seeds or (10 if options.full else 3))
    algorithms = ALGORITHMS if options.algorithms == "all" else options.algorithms.split(",")
    more = {name: int(value) for name, value in (each.split("=") for each in options.set)}
    if options.demo:
        more |= {"iterations": demo.ITERATIONS, "rollouts": demo.ROLLOUTS, "refinement": demo.REFINEMENT}
        more |= {"selection_episodes": demo.SELECTION_EPISODES}
    expert, world = find_expert(options.expert, options.critic)
    experts = [expert] * len(world.agents)
    base = {measure.label: row for measure, row in measures.values(world, experts, SEEDS).items()}
    kinds = [(algorithm, preset) for preset in options.presets.split(",") for algorithm in algorithms]
    kinds = [kind for kind in kinds if kind != (FITTED_Q, RELEASED)]
    tasks = [
        (
            options.expert,
            options.critic,
            {"algorithm": algorithm, "preset": preset, "max_depth": options.max_depth, "seed": seed, **more},
        )
        for algorithm, preset in kinds
        for seed in seeds
    ]
    runs = list(side_by_side(one, tasks, options.jobs))
    figures, rows = [], []
    for place, (algorithm, preset) in enumerate(kinds):
        mine = runs[place * len(seeds) : (place + 1) * len(seeds)]
        leaves, seconds = (float(np.mean([run[part] for run in mine])) for part in (2, 3))
        for measure in world.measures:
            values = np.stack([run[1][measure.label] for run in mine])
            found, kept = interval(values), interval(values, base[measure.label], measure.lower_is_better)
            rows.append((measure.label, f"{algorithm}, {preset}", found, kept, base[measure.label].mean()))
            goal = TARGETS.get((options.expert, options.max_depth, measure.team, measure.name))
            if goal and place == 0 and not more:
                reach, stretch, of = goal
                lower = measure.lower_is_better and of == "value"
                worse = (kept if of == "ratio" else found)[2 if lower else 1]
                name = f"{measure.label}, {algorithm}, {preset}: {of}, worse end"
                figures.append(figure(name, worse, reach, stretch, "lower" if lower else "higher"))
        figures.append(figure(f"{algorithm}, {preset}: seconds per run", seconds))
        if not options.json:
            spread = {
                team: [round(float(run[1][world.primary(team).label].mean()), 3) for run in mine]
                for team in world.teams
            }
            print(f"{algorithm}, {preset}: {leaves:.1f} leaves, {seconds:.1f} s a run; by seed {spread}", flush=True)
    if options.cross:
        first = runs[: len(seeds)]
        for place, (algorithm, preset) in enumerate(kinds):
            theirs = runs[place * len(seeds) : (place + 1) * len(seeds)]
            for team in world.teams:
                measure, members = world.primary(team), world.members(team)
                values = []
                for ours, opponents in zip(first, theirs, strict=True):
                    mixed = [
                        tree_policies((ours if agent in members else opponents)[0]) for agent in range(len(experts))
                    ]
                    values.append(measures.values(world, mixed, SEEDS)[measure])
                found = interval(np.stack(values))
                name = f"{measure.label} of {', '.join(kinds[0])} against trees of {algorithm}, {preset}"
                rows.append((name, "", found, None, None))
                if (options.expert, team) == ("physical-deception", "defenders"):
                    figures.append(figure(f"{name}: worse end", found[1], 0.98, 0.99, "higher"))
    for label, kind, found, kept, theirs in sorted(rows, key=lambda row: row[0]) if not options.json else []:
        ratio = "" if kept is None else f"  expert {theirs:.3f}  ratio {text(kept)}"
        print(f"{label:<28} {kind:<36} {text(found)}{ratio}")
    tell(figures, options.json)


if __name__ == "__main__":
    main()
