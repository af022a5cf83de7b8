"""Trees of experts with continuous actions, on Gymnasium's classic games, beside plain imitation with scikit-learn.

    python -m tests.benchmarks.continuous --train FOLDER [GAME ...]
    python -m tests.benchmarks.continuous --experts FOLDER [GAME ...] [--leaves N] [--json]
    python -m tests.benchmarks.continuous --navigation
    python -m tests.benchmarks.continuous --halves [--experts FOLDER]

--train makes the experts by stable-baselines3, one file a game (`Pendulum-v1.zip`, ...), from seed 0, on one core; of
PPO the layers that act as safetensors too. generated/continuous has those of LunarLander.
Otherwise each game's expert is extracted in several ways, and a row says what a tree returns over the same held-out
episodes as the expert and random actions, its score (tree - random) / (expert - random) with the interval of a paired
bootstrap, and its size in leaves and in numbers. The plain rows are what forty lines of scikit-learn give: a
regressor of the expert's own episodes, and one that also plays (DAgger), with as many rounds and episodes as ours.
--navigation asks what tests of sums do for numbered actions: D of the shipped expert's trees of 16 leaves.
--halves asks it of deception: whether trees of half or a quarter of 64 leaves succeed as often, within .02; with
--experts, of LunarLander's return instead. --record FILE keeps the rows in a file of JSON, measures none that
it has of this expert, and prints them as the manual's table.
"""

import argparse
import json
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

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
from maviper.experts.foreign.layers import MEANS
from maviper.experts.foreign.sb3 import NONE
from maviper.experts.foreign.state_dicts import from_torch
from maviper.extraction.algorithms import extract
from maviper.extraction.settings import Settings
from maviper.worlds import World, find
from tests.benchmarks import single_agent

WEIGHTS = ".safetensors"  # of experts without the rest of a zip
PART = 100_000  # environment steps of a training, after which the expert is written
# After rl-baselines3-zoo (hyperparams/sac.yml and ppo.yml), with fewer environment steps (`steps`). `then`: settings by
# which a training goes on, with larger batches, which cost a third, and shorter steps in the end.
LARGE = {"n_steps": 256, "batch_size": 512, "n_epochs": 8, "ent_coef": 0.0}
EXPERTS: dict[str, dict[str, Any]] = {
    "Pendulum-v1": {
        "algorithm": "SAC",
        "envs": 1,
        "steps": 4_000,
        "net_arch": [64, 64],
        "settings": {"learning_rate": 1e-3, "gamma": 0.95},
    },
    "LunarLanderContinuous-v3": {
        **single_agent.EXPERTS["LunarLander-v3"],
        "steps": 250_000,
        "then": (
            {"envs": 32, "steps": 319_488, "settings": {**LARGE, "learning_rate": 7e-4}},
            {"envs": 32, "steps": 163_840, "settings": {**LARGE, "learning_rate": 2e-4}},
        ),
    },
    "Swimmer-v5": {
        "algorithm": "PPO",
        "envs": 16,
        "steps": 600_000,
        "scaled": True,
        "settings": {
            "n_steps": 256,
            "batch_size": 512,
            "gae_lambda": 0.98,
            "gamma": 0.9999,
            "learning_rate": 8e-4,
        },
    },
}
WANTED = {"Pendulum-v1": -170.0, "LunarLanderContinuous-v3": 250.0, "Swimmer-v5": 250.0}  # of an expert, at least
REACH = {"Pendulum-v1": (0.97, 1.0), "LunarLanderContinuous-v3": (0.92, 0.98), "Swimmer-v5": (0.90, 0.98)}
LEAVES = {"Pendulum-v1": 16, "LunarLanderContinuous-v3": 32, "Swimmer-v5": 64}
ROUNDS = {"iterations": 12, "rollouts": 20, "selection_episodes": 20, "patience": 100, "max_depth": 12}
REFINED = {"Pendulum-v1": 4_000, "LunarLanderContinuous-v3": 4_000, "Swimmer-v5": 2_000}  # episodes
AXIS_ALIGNED = "constant leaves"
WITH_SUMS = ("constant, splits of sums", "linear, splits of sums")
WAYS: dict[str, dict[str, str | int]] = {
    AXIS_ALIGNED: {"leaf": "constant"},
    "constant, splits of differences": {"leaf": "constant", "splits": "differences"},
    "constant, splits of sums": {"leaf": "constant", "splits": "sums"},
    "linear leaves": {"leaf": "linear"},
    "linear, splits of sums": {"leaf": "linear", "splits": "sums"},
    "constant leaves, refined": {"leaf": "constant", "refinement": 0},
    "linear, splits of sums, refined": {"leaf": "linear", "splits": "sums", "refinement": 0},
}
PLAIN = ("plain imitation", "plain DAgger")
EPISODES = 200
MISSING = ("Swimmer-v5 without an expert: its recipe was not run; BipedalWalker-v3: no recipe",)


def train_expert(game: str, file: Path, seed: int = 0) -> None:
    """Trains a game's expert in parts, and writes it after each of them as stable-baselines3 does."""
    recipe = EXPERTS[game]
    learner = single_agent.learner(game, recipe, seed)
    _learn(learner, game, file, recipe["steps"])
    for number, then in enumerate(recipe.get("then", ()), 1):
        more = {**recipe, **then, "settings": {**recipe["settings"], **then["settings"]}}
        fresh = single_agent.learner(game, more, seed + number)
        fresh.set_parameters(str(file))
        fresh.num_timesteps, learner = learner.num_timesteps, fresh
        _learn(fresh, game, file, more["steps"])


def _learn(learner: Any, game: str, file: Path, steps: int) -> None:
    last = learner.num_timesteps + steps
    while learner.num_timesteps < last:
        first = learner.num_timesteps == 0
        learner.learn(min(PART, last - learner.num_timesteps), reset_num_timesteps=first)
        learner.save(file)
        if EXPERTS[game]["algorithm"] == "PPO":
            write_actor(learner, file.with_suffix(WEIGHTS))
        print(f"{game}: {learner.num_timesteps:,} steps", flush=True)


def write_actor(learner: Any, file: Path) -> None:
    """Writes the layers of PPO's policy alone, as safetensors: `torch:FILE,net=pi,activation=tanh,outputs=means`."""
    from safetensors.numpy import save_file

    state = learner.policy.state_dict()
    layers = [name for name in state if name.startswith(("mlp_extractor.policy_net.", "action_net."))]
    places = {name: 2 * place for place, name in enumerate(dict.fromkeys(name.rpartition(".")[0] for name in layers))}
    save_file({f"pi.{places[name.rpartition('.')[0]]}.{name.rpartition('.')[2]}": state[name].numpy()
               for name in layers}, file)  # fmt: skip


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


class Setting(NamedTuple):
    """A game with its expert, and what that and random actions return in the held-out episodes."""

    game: str
    world: World
    expert: Any
    best: Float64
    random: Float64

    @staticmethod
    def of(game: str, file: Path) -> "Setting":
        """The game of an expert's file."""
        world = find(f"gymnasium:{game}", giving=True)
        if file.suffix == WEIGHTS:
            expert = from_torch(file, world, "pi", "tanh", MEANS)
        else:
            expert = from_sb3(file, world, NONE if EXPERTS[game].get("scaled") else None)  # rewards alone were scaled
        setting = Setting(game, world, expert, returns(world, expert), returns(world, None))
        told = f"expert {setting.best.mean():.1f} (wanted: {WANTED[game]:.0f}), random {setting.random.mean():.1f}"
        print(f"{game}: {told}", flush=True)
        return setting

    def measure(self, name: str, leaves: int, seed: int) -> dict[str, Any]:
        """A row of one way, of a tree with so many leaves at most, or of plain imitation."""
        started, numbers = time.process_time(), 0
        if name.startswith("plain"):
            player, count = plain(self.world, self.expert, leaves, "DAgger" in name), leaves
        else:
            way = WAYS[name] | ({"refinement": REFINED[self.game]} if "refinement" in WAYS[name] else {})
            given = {"algorithm": "viper", "max_leaves": leaves, "seed": seed, **ROUNDS, **way}
            (policy,) = extract(self.world, self.expert, Settings.of(given, self.world)).agents
            player, count, numbers = tree_policies([policy]), len(ir.leaves(policy.tree)), size(policy)
        spent = time.process_time() - started
        values = returns(self.world, player)
        score, low, high = scored(values, self.best, self.random)
        told = f"{count} leaves" + (f" of {numbers} numbers" if numbers else "")
        interval = f"[{low:.3f}, {high:.3f}]"
        print(f"  {name}: {values.mean():.1f}, score {score:.3f} {interval}, {told}, {spent:.0f} CPU s", flush=True)
        figures = {"return": values.mean(), "score": score, "low": low, "high": high}
        about = {"expert": self.best.mean(), "random": self.random.mean(), "episodes": EPISODES, "seed": seed}
        about |= {"expert_sha256": self.expert.hash}
        rounded = {key: round(float(value), 3) for key, value in figures.items()}
        sizes = {"asked": leaves, "leaves": count, "numbers": numbers}
        return {"game": self.game, "way": name, **sizes, **rounded, **about}


def measure_once(setting: Setting, name: str, leaves: int, seed: int, record: Path | None) -> dict[str, Any]:
    """A row as the record has it, for this expert, or measured and kept there."""
    for row in json.loads(record.read_text()) if record and record.exists() else ():
        asked = row["game"], row["way"], row["asked"], row["seed"], row["expert_sha256"]
        if asked == (setting.game, name, leaves, seed, setting.expert.hash):
            return row
    row = setting.measure(name, leaves, seed)
    if record:
        keep_rows(record, [row])
    return row


def keep_rows(record: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    """Writes rows into a record, in the place of those of the same game, way, leaves and seed."""
    known = json.loads(record.read_text()) if record.exists() else []
    by_key = {tuple(str(row[key]) for key in ("game", "asked", "way", "seed")): row for row in (*known, *rows)}
    record.parent.mkdir(parents=True, exist_ok=True)
    record.write_text("[\n" + ",\n".join(json.dumps(by_key[key]) for key in sorted(by_key)) + "\n]\n")


def table(record: Path) -> list[str]:
    """The lines of a table of a record's rows, as the manual has them."""
    order = [*WAYS, *PLAIN]
    rows = sorted(json.loads(record.read_text()), key=lambda row: (row["game"], row["asked"], order.index(row["way"])))
    cells = [("game", "leaves", "way", "numbers", "return", "score")]
    for row in rows:
        sizes = str(row["asked"]), row["way"], str(row["numbers"] or "")
        score = f"{row['score']:.3f} [{row['low']:.3f}, {row['high']:.3f}]"
        cells.append((row["game"], *sizes, f"{row['return']:.1f}", score))
    wide = [max(map(len, column)) for column in zip(*cells, strict=True)]
    lines = ["| " + " | ".join(map(str.ljust, row, wide)) + " |" for row in cells]
    return [lines[0], "|" + "|".join("-" * (width + 2) for width in wide) + "|", *lines[1:]]


def lander_halves(setting: Setting, record: Path | None, seed: int) -> list[dict[str, Any]]:
    """What trees of fewer leaves with sums score above a tree of 64 leaves that tests single features."""
    figures: list[dict[str, Any]] = []
    whole = 0.0
    for leaves, name in ((WHOLE, AXIS_ALIGNED), *((WHOLE // part, way) for part in (2, 4) for way in WITH_SUMS)):
        row = measure_once(setting, name, leaves, seed, record)
        if leaves == WHOLE:
            whole = row["score"]
            continue
        told = f"{setting.game}: score of {name} at {leaves} leaves, above {AXIS_ALIGNED} at {WHOLE}"
        figures.append({"name": told, "value": round(row["score"] - whole, 3), "reach": -WITHIN, "stretch": 0.0})
        figures[-1]["better"] = "higher"
    return figures


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


REFINED_SUMS = {"splits": "sums", "refinement": 1_500_000, "measure": "D"}
# What is tested -> the expert, features beyond those that agents observe, and settings.
TESTED: dict[str, tuple[str, str, dict[str, Any]]] = {
    "histogram": ("", "", {"splits": "histogram"}),
    "differences": ("", "", {"splits": "differences"}),
    "sums": ("", "", {"splits": "sums"}),
    "sums, refined": ("", "", REFINED_SUMS),
    "sums of where agents come to rest": ("", "coasting", {"splits": "sums", "measure": "D"}),
    "sums of where agents come to rest, refined": ("", "coasting", REFINED_SUMS),
    "the same of a script with fixed roles": ("@fixed-roles", "coasting", {"splits": "sums", "measure": "D"}),
}


def navigation() -> list[dict[str, Any]]:
    """D of trees of 16 leaves in cooperative navigation, by what they test."""
    held_out.EVALUATION_EPISODES = 400
    figures: list[dict[str, Any]] = []
    for splits, (script, features, settings) in TESTED.items():
        started = time.process_time()
        critic = "none" if script else "learned"
        expert, world = find_expert(f"cooperative-navigation{script}", critic, features=features)
        profile = extract(world, expert, Settings.of({**NAVIGATION, **settings}, world))
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
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("games", nargs="*", default=list(EXPERTS))
    parser.add_argument("--train", type=Path)
    parser.add_argument("--experts", type=Path)
    parser.add_argument("--leaves", type=int)
    parser.add_argument("--ways", help="several with +", default="+".join((*WAYS, *PLAIN)))
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--navigation", action="store_true")
    parser.add_argument("--halves", action="store_true")
    parser.add_argument("--record", type=Path)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    held_out.EVALUATION_EPISODES = 10  # a profile's own figures are not asked for
    if options.train:
        options.train.mkdir(exist_ok=True)
        for game in options.games:
            train_expert(game, options.train / f"{game}.zip", options.seed)
    figures = navigation() if options.navigation else list[dict[str, Any]]()
    figures += halves() if options.halves and not options.experts else []
    for game in options.games if options.experts else ():
        files = [options.experts / f"{game}{suffix}" for suffix in (".zip", WEIGHTS)]
        file = next((each for each in files if each.exists()), None)
        if file is None:
            print(f"{game}: no expert; --train FOLDER {game} makes it")
            continue
        leaves, setting = options.leaves or LEAVES[game], Setting.of(game, file)
        if options.halves:
            figures += lander_halves(setting, options.record, options.seed)
            continue
        for way in options.ways.split("+"):
            row = measure_once(setting, way, leaves, options.seed, options.record)
            reach, stretch = REACH[game]
            name = f"{game}: score of {row['way']} at {leaves} leaves"
            figures.append({"name": name, "value": row["score"], "reach": reach, "stretch": stretch})
            figures[-1]["better"] = "higher"
    if options.record:
        print("\n".join(table(options.record)))
    print("\n".join(f"not here: {each}" for each in MISSING))
    if options.json:
        print(json.dumps({"figures": figures}))


if __name__ == "__main__":
    main()
