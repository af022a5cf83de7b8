"""Trees of experts with continuous actions, on Gymnasium's classic games, beside plain imitation with scikit-learn.

    python -m tests.benchmarks.continuous --train FOLDER [GAME ...]
    python -m tests.benchmarks.continuous --experts FOLDER [GAME ...] [--leaves N] [--json]
    python -m tests.benchmarks.continuous --experts FOLDER --halves [GAME ...]

--train makes the experts by stable-baselines3, one file a game (`Pendulum-v1.zip`, ...), from seed 0, on one core; of
PPO the layers that act as safetensors too. generated/continuous has those of LunarLander and Swimmer.
Otherwise each game's expert is extracted in several ways, and a row says what a tree returns over the same held-out
episodes as the expert and random actions, its score (tree - random) / (expert - random) with the interval of a paired
bootstrap, and its size in leaves and in numbers. The plain rows are what forty lines of scikit-learn give: a
regressor of the expert's own episodes, and one that also plays (DAgger), with as many rounds and episodes as ours.
--halves asks whether trees of half or a quarter of 64 leaves score as high, within .02, once they have sums.
--record FILE keeps the rows in a file of JSON, measures none that it has of this expert, and prints them as the
manual's table.
"""

import json
import sys
import time
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from codegen import ir
from codegen.boxes import size
from codegen.ir import Float64
from maviper.episodes import measures
from maviper.episodes.play import Policies, play, points, rollout, tree_policies
from maviper.evaluation import held_out
from maviper.evaluation.crossplay import Uniform
from maviper.experts import from_sb3
from maviper.experts.foreign.layers import MEANS
from maviper.experts.foreign.libraries import NONE, from_torch
from maviper.extraction.algorithms import extract
from maviper.extraction.settings import Settings
from maviper.worlds import World, find
from tests.benchmarks import single_agent
from tests.benchmarks.scores import Row, align, find_rows, keep_rows, parse_options, read_rows, scored, tell_score

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
        "envs": 4,
        "steps": 307_200,
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
REFINED = {"Pendulum-v1": 4_000, "LunarLanderContinuous-v3": 4_000, "Swimmer-v5": 2_000}  # episodes
AXIS_ALIGNED = "constant leaves"
WITH_SUMS = ("constant, splits of sums", "linear leaves", "linear, splits of sums")
WHOLE, WITHIN = 64, 0.02  # leaves of the tree that has no sums; of its score
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
MISSING = ("BipedalWalker-v3: no recipe",)


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
        recent = float(np.mean([episode["r"] for episode in learner.ep_info_buffer]))
        print(f"{game}: {learner.num_timesteps:,} steps, the last episodes return {recent:.1f}", flush=True)


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


def measure_once(setting: Setting, name: str, leaves: int, seed: int, record: Path | None) -> Row:
    """A row as the record has it, for this expert, or measured and kept there."""
    about = {"game": setting.game, "way": name, "asked": leaves, "seed": seed, "expert_sha256": setting.expert.hash}
    for row in find_rows(record, **about):
        return row
    row = setting.measure(name, leaves, seed)
    keep_rows(record, [row])
    return row


def table(record: Path) -> list[str]:
    """The lines of a table of a record's rows, as the manual has them."""
    order = [*WAYS, *PLAIN]
    rows = sorted(read_rows(record), key=lambda row: (row["game"], row["asked"], order.index(row["way"])))
    cells = [("game", "leaves", "way", "numbers", "return", "score")]
    for row in rows:
        sizes = str(row["asked"]), row["way"], str(row["numbers"] or "")
        cells.append((row["game"], *sizes, f"{row['return']:.1f}", tell_score(row)))
    return align(cells)


def find_file(experts: Path, game: str) -> Path | None:
    """The file of a game's expert in a folder."""
    files = [experts / f"{game}{suffix}" for suffix in (".zip", WEIGHTS)]
    return next((each for each in files if each.exists()), None)


def halve_leaves(setting: Setting, record: Path | None, seed: int) -> list[dict[str, Any]]:
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


def main() -> None:
    options = parse_options(__doc__, list(EXPERTS), (*WAYS, *PLAIN), "--halves")
    held_out.EVALUATION_EPISODES = 10  # a profile's own figures are not asked for
    if options.train:
        options.train.mkdir(exist_ok=True)
        for game in options.games:
            train_expert(game, options.train / f"{game}.zip", options.seed)
    elif not options.experts:
        sys.exit("nothing to do: --experts FOLDER measures trees of its experts, --train FOLDER makes experts")
    figures = list[dict[str, Any]]()
    files = {game: find_file(options.experts, game) for game in options.games} if options.experts else {}
    missing = [game for game, file in files.items() if file is None]
    for game, file in files.items():
        if file is None:
            continue
        leaves, setting = options.leaves or LEAVES[game], Setting.of(game, file)
        if options.halves:
            figures += halve_leaves(setting, options.record, options.seed)
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
    if missing:
        told = f"{options.experts} has no expert of {', '.join(missing)}"
        sys.exit(f"{told}: nothing was measured there; --train FOLDER {' '.join(missing)} makes it")


if __name__ == "__main__":
    main()
