"""Trees of experts with continuous actions, on Gymnasium's classic games, beside plain imitation with scikit-learn.

    python -m tests.benchmarks.continuous --train FOLDER [GAME ...]
    python -m tests.benchmarks.continuous --experts FOLDER [GAME ...] [--leaves N] [--json]
    python -m tests.benchmarks.continuous --navigation
    python -m tests.benchmarks.continuous --halves

--train makes the experts by stable-baselines3, one file a game (`Pendulum-v1.zip`, ...), from seed 0, on one core.
Otherwise each game's expert is extracted in several ways, and a row says what a tree returns over the same held-out
episodes as the expert and random actions, its score (tree - random) / (expert - random) with the interval of a paired
bootstrap, and its size in leaves and in numbers. The plain rows are what forty lines of scikit-learn give: a
regressor of the expert's own episodes, and one that also plays (DAgger), with as many rounds and episodes as ours.
--navigation asks what tests of sums do for numbered actions: D of the shipped expert's trees of 16 leaves.
--halves asks it of deception: whether trees of half or a quarter of 64 leaves succeed as often, within .02.
"""

import argparse
import json
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from codegen import ir
from codegen.ir import Float64
from codegen.paths import size
from maviper.episodes import measures
from maviper.episodes.play import Policies, play, points, rollout, tree_policies
from maviper.evaluation import held_out
from maviper.evaluation.crossplay import Uniform
from maviper.experts import from_sb3
from maviper.experts.finding import find_expert
from maviper.experts.foreign.sb3 import NONE
from maviper.extraction.algorithms import extract
from maviper.extraction.settings import Settings
from maviper.worlds import World, find
from tests.benchmarks import single_agent

PARTS = 4  # of a training, after each of which the expert is written
# After rl-baselines3-zoo (hyperparams/sac.yml and ppo.yml), SAC with fewer steps; `steps` are environment steps.
EXPERTS: dict[str, dict[str, Any]] = {
    "Pendulum-v1": {
        "algorithm": "SAC",
        "envs": 1,
        "steps": 4_000,
        "net_arch": [64, 64],
        "settings": {"learning_rate": 1e-3, "gamma": 0.95},
    },
    "LunarLanderContinuous-v3": single_agent.EXPERTS["LunarLander-v3"],
    "Swimmer-v5": {
        "algorithm": "PPO",
        "envs": 4,
        "steps": 1_000_000,
        "scaled": True,
        "settings": {
            "n_steps": 1024,
            "batch_size": 256,
            "gae_lambda": 0.98,
            "gamma": 0.9999,
            "learning_rate": 6e-4,
        },
    },
}
WANTED = {"Pendulum-v1": -170.0, "LunarLanderContinuous-v3": 250.0, "Swimmer-v5": 250.0}  # of an expert, at least
REACH = {"Pendulum-v1": (0.97, 1.0), "LunarLanderContinuous-v3": (0.92, 0.98), "Swimmer-v5": (0.90, 0.98)}
LEAVES = {"Pendulum-v1": 16, "LunarLanderContinuous-v3": 32, "Swimmer-v5": 64}
ROUNDS = {"iterations": 12, "rollouts": 20, "selection_episodes": 20, "patience": 100, "max_depth": 12}
REFINED = 8_000  # episodes
WAYS: dict[str, dict[str, str | int]] = {
    "constant leaves": {"leaf": "constant"},
    "constant, splits of differences": {"leaf": "constant", "splits": "differences"},
    "constant, splits of sums": {"leaf": "constant", "splits": "sums"},
    "linear leaves": {"leaf": "linear"},
    "linear, splits of sums": {"leaf": "linear", "splits": "sums"},
    "constant leaves, refined": {"leaf": "constant", "refinement": REFINED},
    "linear, splits of sums, refined": {"leaf": "linear", "splits": "sums", "refinement": REFINED},
}
EPISODES = 200
MISSING = (
    "BipedalWalker-v3: no expert is trained",
    "mpe2's deception and spread with continuous actions: no expert with Gaussian actors",
)


def trained(game: str, file: Path, seed: int = 0) -> None:
    """Trains a game's expert in parts, and writes it after each of them as stable-baselines3 does."""
    found = single_agent.learner(game, EXPERTS[game], seed)
    for part in range(PARTS):
        found.learn(EXPERTS[game]["steps"] // PARTS, reset_num_timesteps=part == 0)
        found.save(file)
        print(f"{game}: {found.num_timesteps:,} steps", flush=True)


def plain(world: World, expert: Any, leaves: int, plays: bool) -> Any:
    """Imitation by scikit-learn alone: a regressor of what the expert does in its own episodes, or (`plays`) in those
    of the regressor before it too; the last one.
    """
    from sklearn.tree import DecisionTreeRegressor

    def episodes(player: Any, seeds: range) -> tuple[Any, Any]:
        parts = rollout(world, [player], seeds)
        seen = np.concatenate([points(part)[0][0] for part in parts])
        return seen, expert.give_numbers(0, seen)

    seen, given = episodes(expert, range(ROUNDS["rollouts"]))
    model = DecisionTreeRegressor(max_leaf_nodes=leaves, random_state=0)
    for number in range(1, ROUNDS["iterations"]):
        model.fit(seen, given)
        fitted = model

        def act(obs: Any, fitted: Any = fitted) -> Any:
            return fitted.predict(obs).reshape(len(obs), -1).astype(np.float32)

        first = number * ROUNDS["rollouts"]
        more = episodes(Policies([act]) if plays else expert, range(first, first + ROUNDS["rollouts"]))
        seen, given = np.concatenate([seen, more[0]]), np.concatenate([given, more[1]])
    model.fit(seen, given)
    return Policies([lambda obs: model.predict(obs).reshape(len(obs), -1).astype(np.float32)])


def returns(world: World, player: Any) -> Float64:
    """The return of each held-out episode."""
    seeds = range(measures.MEASUREMENT_SEEDS, measures.MEASUREMENT_SEEDS + EPISODES)
    if player is not None:
        return np.concatenate([part.returns[0] for part in rollout(world, [player], seeds, keep=False)])
    at_once = world.games or EPISODES
    parts = [seeds[low : low + at_once] for low in range(0, EPISODES, at_once)]
    return np.concatenate(
        [play(world, [Uniform(world).start_episodes(part)], world.start_from_seeds(part)).returns[0] for part in parts]
    )


def scored(tree: Float64, expert: Float64, random: Float64) -> tuple[float, float, float]:
    """The score and the interval of a paired bootstrap."""
    rng = np.random.default_rng(0)
    drawn = rng.integers(len(tree), size=(2_000, len(tree)))
    ours, theirs, chance = (each[drawn].mean(axis=1) for each in (tree, expert, random))
    low, high = np.quantile((ours - chance) / (theirs - chance), [0.025, 0.975])
    value = (tree.mean() - random.mean()) / (expert.mean() - random.mean())
    return float(value), float(low), float(high)


def measured(game: str, file: Path, leaves: int, ways: Sequence[str], seed: int) -> list[dict[str, Any]]:
    """A row for each way, of trees with so many leaves at most, and for plain imitation."""
    world = find(f"gymnasium:{game}", giving=True)
    expert = from_sb3(file, world, NONE if EXPERTS[game].get("scaled") else None)  # rewards alone were scaled
    best, random = returns(world, expert), returns(world, None)
    print(f"{game}: expert {best.mean():.1f} (wanted: {WANTED[game]:.0f}), random {random.mean():.1f}", flush=True)
    rows: list[dict[str, Any]] = []
    for name in ways:
        started = time.process_time()
        numbers: int | None = None
        if name.startswith("plain"):
            found, count = plain(world, expert, leaves, "DAgger" in name), leaves
        else:
            given = {"algorithm": "viper", "max_leaves": leaves, "seed": seed, **ROUNDS, **WAYS[name]}
            (policy,) = extract(world, expert, Settings.of(given, world)).agents
            found, count, numbers = tree_policies([policy]), len(ir.leaves(policy.tree)), size(policy)
        spent = time.process_time() - started
        values = returns(world, found)
        score, low, high = scored(values, best, random)
        rows.append({"way": name, "score": score, "leaves": count})
        told = f"{count} leaves" + ("" if numbers is None else f" of {numbers} numbers")
        print(f"  {name}: {values.mean():.1f}, score {score:.3f} [{low:.3f}, {high:.3f}], {told}, {spent:.0f} CPU s")
    return rows


NAVIGATION = {
    "least_right": "0",
    "weights": "equal",
    "max_leaves": 16,
    "max_depth": 9,
    "iterations": 10,
    "rollouts": 60,
    "selection_episodes": 60,
    "patience": 100,
}


def navigation() -> list[dict[str, Any]]:
    """D of trees of 16 leaves in cooperative navigation, by what they test."""
    held_out.EVALUATION_EPISODES = 400
    expert, world = find_expert("cooperative-navigation")
    figures: list[dict[str, Any]] = []
    for splits in ("histogram", "differences", "sums"):
        started = time.process_time()
        profile = extract(world, expert, Settings.of({**NAVIGATION, "splits": splits}, world))
        reached, sizes = profile.provenance.evaluation, [size(policy) for policy in profile.agents]
        told = f"expert {float(reached['agents expert D']):.3f}, {sizes} numbers"
        spent = time.process_time() - started
        print(f"navigation, {splits}: D {float(reached['agents D']):.3f}, {told}, {spent:.0f} CPU s", flush=True)
        name = f"navigation: D at 16 leaves, splits {splits}"
        figures.append({"name": name, "value": float(reached["agents D"]), "reach": 0.8, "stretch": 0.7})
        figures[-1]["better"] = "lower"
    return figures


HALVES = {**NAVIGATION, "max_depth": 12, "iterations": 5, "rollouts": 40, "selection_episodes": 40}
WHOLE, WITHIN = 64, 0.02  # leaves of trees that test single features; of their share of successes


def halves() -> list[dict[str, Any]]:
    """How often both teams of deception succeed with fewer leaves that test sums, beside trees of 64 leaves."""
    held_out.EVALUATION_EPISODES = 1_000
    expert, world = find_expert("physical-deception")
    figures, whole = list[dict[str, Any]](), dict[str, float]()
    singly = (("histogram", WHOLE), ("histogram", WHOLE // 2), ("histogram", WHOLE // 4))
    for splits, leaves in (*singly, ("sums", WHOLE // 2), ("sums", WHOLE // 4)):
        started = time.process_time()
        settings = Settings.of({**HALVES, "splits": splits, "max_leaves": leaves}, world)
        profile = extract(world, expert, settings)
        reached = profile.provenance.evaluation
        shares = {team: float(reached[f"{team} success r=0.316"]) for team in world.teams}
        told = ", ".join(f"{team} {share:.3f}" for team, share in shares.items())
        sizes = [size(policy) for policy in profile.agents]
        spent = time.process_time() - started
        print(f"deception, {splits}, {leaves} leaves: {told}; {sizes} numbers, {spent:.0f} CPU s", flush=True)
        if leaves == WHOLE:
            whole = shares
        if splits == "histogram":
            continue
        least = min(share - whole[team] for team, share in shares.items())
        name = f"deception: success at {leaves} leaves with sums, above that at {WHOLE}"
        figures.append({"name": name, "value": round(least, 3), "reach": -WITHIN, "stretch": 0.0, "better": "higher"})
    return figures


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("games", nargs="*", default=list(EXPERTS))
    parser.add_argument("--train", type=Path)
    parser.add_argument("--experts", type=Path)
    parser.add_argument("--leaves", type=int)
    parser.add_argument("--ways", help="several with +", default="+".join((*WAYS, "plain imitation", "plain DAgger")))
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--navigation", action="store_true")
    parser.add_argument("--halves", action="store_true")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    held_out.EVALUATION_EPISODES = 10  # a profile's own figures are not asked for
    if options.train:
        options.train.mkdir(exist_ok=True)
        for game in options.games:
            trained(game, options.train / f"{game}.zip", options.seed)
    figures = navigation() if options.navigation else list[dict[str, Any]]()
    figures += halves() if options.halves else []
    for game in options.games if options.experts else ():
        file = options.experts / f"{game}.zip"
        if not file.exists():
            print(f"{game}: no expert; --train FOLDER {game} makes it")
            continue
        leaves = options.leaves or LEAVES[game]
        for row in measured(game, file, leaves, options.ways.split("+"), options.seed):
            reach, stretch = REACH[game]
            name = f"{game}: score of {row['way']} at {leaves} leaves"
            figures.append({"name": name, "value": round(row["score"], 3), "reach": reach, "stretch": stretch})
            figures[-1]["better"] = "higher"
    print("\n".join(f"not measured: {each}" for each in MISSING))
    if options.json:
        print(json.dumps({"figures": figures}))


if __name__ == "__main__":
    main()
