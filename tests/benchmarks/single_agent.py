"""VIPER on the classic single-agent games: trees from experts of stable-baselines3, with a budget of leaves.

    python tests/benchmarks/single_agent.py --train FOLDER [GAME ...]
    python tests/benchmarks/single_agent.py --experts FOLDER [GAME ...] [--leaves N] [--weights W] [--json]

--train makes the experts, one file a game (`CartPole-v1.zip`, ...), from seed 0 with hyperparameters of the RL
Baselines3 Zoo. Otherwise each game's expert is extracted, and a row says what tree, expert and random actions return:
mean and standard deviation over --episodes held-out ones (random: 200), and (tree - random) / (expert - random).
--leaves, --weights, --iterations and --seed change what is extracted in all of the games, to try something. The
trees of CartPole and LunarLander are refined in play, which takes a quarter and half an hour of one core.
"""

import argparse
import json
import math
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from codegen import ir
from codegen.intervals import Z95
from maviper.episodes import measures
from maviper.episodes.play import Policies
from maviper.evaluation import held_out
from maviper.experts import from_sb3
from maviper.extraction.algorithms import extract
from maviper.extraction.settings import Settings
from maviper.worlds import find

# Zoo settings as facts (rl-baselines3-zoo, hyperparams/ppo.yml and dqn.yml); `steps` are environment steps.
EXPERTS = {
    "CartPole-v1": {
        "algorithm": "PPO",
        "envs": 8,
        "steps": 100_000,
        "linear": {"learning_rate": 1e-3, "clip_range": 0.2},
        "settings": {"n_steps": 32, "batch_size": 256, "gae_lambda": 0.8, "gamma": 0.98, "n_epochs": 20},
    },
    "Acrobot-v1": {
        "algorithm": "PPO",
        "envs": 16,
        "steps": 150_000,
        "settings": {"n_steps": 256, "gae_lambda": 0.94, "gamma": 0.99, "n_epochs": 4, "ent_coef": 0.0},
    },
    "MountainCar-v0": {
        "algorithm": "DQN",
        "envs": 1,
        "steps": 120_000,
        "net_arch": [256, 256],
        "settings": {
            "learning_rate": 4e-3,
            "batch_size": 128,
            "buffer_size": 10_000,
            "learning_starts": 1_000,
            "gamma": 0.98,
            "target_update_interval": 600,
            "train_freq": 16,
            "gradient_steps": 8,
            "exploration_fraction": 0.2,
            "exploration_final_eps": 0.07,
        },
    },
    "LunarLander-v3": {
        "algorithm": "PPO",
        "envs": 16,
        "steps": 1_000_000,
        "settings": {
            "n_steps": 1024,
            "batch_size": 64,
            "gae_lambda": 0.98,
            "gamma": 0.999,
            "n_epochs": 4,
            "ent_coef": 0.01,
        },
    },
}


def learner(game: str, recipe: Mapping[str, Any], seed: int = 0) -> Any:
    """A learner of stable-baselines3 by a recipe, on one core, that has not learned yet. `scaled`: it learns from
    rewards in parts of their running deviation; what it observes is never scaled.
    """
    import stable_baselines3
    import torch
    from stable_baselines3.common.env_util import make_vec_env
    from stable_baselines3.common.vec_env import VecNormalize

    torch.set_num_threads(1)
    falling = {key: (lambda left, top=top: left * top) for key, top in recipe.get("linear", {}).items()}
    policy = {"net_arch": recipe["net_arch"]} if "net_arch" in recipe else None
    kind = getattr(stable_baselines3, recipe["algorithm"])
    # the library would have the games ready to be drawn, for which LunarLander keeps hundreds of particles
    env = make_vec_env(game, recipe["envs"], seed=seed, env_kwargs={"render_mode": None})
    settings = recipe["settings"] | falling
    if recipe.get("scaled"):
        env = VecNormalize(env, norm_obs=False, gamma=settings["gamma"])
    return kind("MlpPolicy", env, policy_kwargs=policy, device="cpu", seed=seed, **settings)


def trained(game: str, file: Path, seed: int = 0) -> None:
    """Trains a game's expert and writes it as stable-baselines3 does."""
    found = learner(game, EXPERTS[game], seed)
    found.learn(EXPERTS[game]["steps"])
    found.save(file)


# What is asked of VIPER: the leaves of the task, then how much it may play.
TREES = {
    "CartPole-v1": {
        "max_depth": 2,
        "iterations": 20,
        "rollouts": 5,
        "selection_episodes": 20,
        "refinement": 120_000,
        "seed": 1,
    },
    "Acrobot-v1": {"max_leaves": 32, "max_depth": 10, "iterations": 20, "rollouts": 10, "selection_episodes": 10},
    "MountainCar-v0": {"max_leaves": 32, "max_depth": 10, "iterations": 20, "rollouts": 10, "selection_episodes": 10},
    "LunarLander-v3": {
        "max_leaves": 64,
        "max_depth": 14,
        "iterations": 80,
        "rollouts": 40,
        "selection_episodes": 60,
        "weights": "equal",
        "refinement": 60_000,
    },
}
REACH = 0.9
RANDOM_EPISODES = 200


def measured(game: str, file: Path, changes: dict[str, object]) -> dict[str, float]:
    """What the tree, its expert and random actions return in a game, and how long the extraction took."""
    world = find(f"gymnasium:{game}")
    expert = from_sb3(file, world)
    started = time.perf_counter()
    given = {"algorithm": "viper", "patience": 1_000, **TREES[game], **changes}
    profile = extract(world, expert, Settings.of(given, world))
    seconds = time.perf_counter() - started
    rows = profile.provenance.evaluation
    count, label = int(rows["episodes"]), "agent return"
    deviation = (float(rows[f"{label} high"]) - float(rows[label])) / Z95 * math.sqrt(count)
    rng = np.random.default_rng(0)
    chance = Policies([lambda seen: rng.integers(len(world.actions[0]), size=len(seen))])
    random = measures.evaluate(world, [chance], range(RANDOM_EPISODES))[world.measures[0]].value
    tree, best = float(rows[label]), float(rows["agent expert return"])
    return {
        "leaves": len(ir.leaves(profile.agents[0].tree)),
        "tree": tree,
        "deviation": deviation,
        "expert": best,
        "random": random,
        "share": (tree - random) / (best - random) if best > random else math.nan,  # an expert that learned nothing
        "seconds": seconds,
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("games", nargs="*", default=list(EXPERTS))
    parser.add_argument("--train", type=Path)
    parser.add_argument("--experts", type=Path)
    parser.add_argument("--seed", type=int)
    parser.add_argument("--leaves", type=int)
    parser.add_argument("--weights")
    parser.add_argument("--iterations", type=int)
    parser.add_argument("--episodes", type=int, default=held_out.EVALUATION_EPISODES)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    held_out.EVALUATION_EPISODES = held_out.OUTSIDE_EPISODES = options.episodes
    if options.train:
        options.train.mkdir(exist_ok=True)
        for game in options.games:
            trained(game, options.train / f"{game}.zip", options.seed or 0)
            print(f"{game} trained", flush=True)
    tried = {"max_leaves": options.leaves, "weights": options.weights, "iterations": options.iterations}
    tried["seed"] = options.seed
    changes = {name: value for name, value in tried.items() if value is not None}
    figures = []
    for game in options.games if options.experts else ():
        found = measured(game, options.experts / f"{game}.zip", changes)
        name = f"{game}: (tree - random) / (expert - random) at {found['leaves']} leaves"
        figures.append({"name": name, "value": round(found["share"], 3), "reach": REACH, "better": "higher"})
        if not options.json:
            told = "{leaves} leaves: {tree:.1f} +- {deviation:.1f}, expert {expert:.1f}, random {random:.1f}"
            print(f"{game}: {told.format(**found)}, share {found['share']:.3f}, {found['seconds']:.0f} s", flush=True)
    if options.json:
        print(json.dumps({"figures": figures}))


if __name__ == "__main__":
    main()
