"""Trees of our own Gaussian experts, for teams: mpe2's continuous actions, and a scenario of VMAS as it comes.

    python -m tests.benchmarks.gaussian --train FOLDER [GAME ...]
    python -m tests.benchmarks.gaussian --experts FOLDER [GAME ...] [--leaves N] [--ways WAY+WAY] [--record FILE]
        [--json]

--train makes the experts by MAPPO, from rewards alone and seed 0, on one core: a run folder each. Otherwise each game's
expert is extracted in several ways, with so many leaves an agent at most. A row says what each team returns over the
same 200 held-out episodes as the expert and as random actions, all others acting by the expert: in mpe2's own
environments, or in VMAS's batch. Its score is (tree - random) / (expert - random), with the interval of a paired
bootstrap. --record FILE keeps the rows in a file of JSON, measures none that it has of this expert, and prints them as
the manual's table.
"""

import json
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from codegen import ir
from codegen.boxes import size
from codegen.ir import Float64
from maviper.episodes import measures
from maviper.episodes.play import Controller, choose_actions, play, tree_policies
from maviper.evaluation import held_out
from maviper.evaluation.crossplay import Uniform
from maviper.experts import network
from maviper.experts.cards import Request
from maviper.extraction.algorithms import extract
from maviper.extraction.settings import Settings
from maviper.worlds import ParticleWorld, World, find
from maviper.worlds.seeds import fold_seed
from tests.benchmarks.continuous import EPISODES, WAYS
from tests.benchmarks.scores import Row, align, find_rows, keep_rows, parse_options, read_rows, scored, tell_score
from tests.benchmarks.settled import Settled


class Asked(NamedTuple):
    """What rows are asked for."""

    leaves: int | None
    ways: Sequence[str]  # none: those of the game
    seed: int
    record: Path | None


class Game(NamedTuple):
    """A game in which agents give numbers."""

    world: str  # where the expert learns, and trees are extracted
    trained: Mapping[str, Any]
    extracted: Mapping[str, Any]
    leaves: int


ROUNDS = {"iterations": 10, "rollouts": 60, "selection_episodes": 60, "patience": 100, "max_depth": 12}
NAVIGATION = "vmas:navigation,n_agents=2,collisions=False,continuous_actions=True,max_steps=50"
GAMES = {
    "deception": Game(
        "physical-deception,continuous=1",
        {"steps": 1_536_000},
        ROUNDS,
        32,
    ),
    "spread": Game(
        "cooperative-navigation,continuous=1",
        {"steps": 4_096_000},
        ROUNDS,
        32,
    ),
    "vmas": Game(
        NAVIGATION,
        {"steps": 640_000, "games": 256, "minibatch": 3_200, "checkpoint_steps": 128_000},
        {**ROUNDS, "iterations": 8, "rollouts": 32, "selection_episodes": 32, "max_depth": 8},
        16,
    ),
}
SHARED = {"leaf": "linear", "share": "team", "iterations": 6, "rollouts": 100}  # it grows one tree, not one an agent
TEAM_WAYS = {**WAYS, "linear leaves, one tree a team": SHARED}
SETTLED = "linear, mates settled"
SETTLED_REFINED = f"{SETTLED}, refined"
MATES: dict[str, dict[str, Any]] = {
    SETTLED: {"leaf": "linear", "iterations": 3, "max_leaves": 2},
    SETTLED_REFINED: {"leaf": "linear", "iterations": 3, "max_leaves": 2, "refinement": 300_000},
}
USUAL = ("constant leaves", "linear leaves")
OF_SPREAD = ("constant leaves", "linear leaves, one tree a team", *MATES)
REACH, STRETCH = 0.95, 1.0


def trained(game: Game, folder: Path, seed: int = 0) -> None:
    """Trains a game's expert into a run folder, or goes on with it."""
    from maviper.experts.training.train import train

    started = time.process_time()
    card = train(find(game.world, giving=True), folder, Request("mappo", overrides={**game.trained, "seed": seed}))
    print(f"{game.world}: {card['steps']:,} steps of {card['played']['training']:,}, ", end="")
    print(f"{time.process_time() - started:.0f} CPU s", flush=True)


def returns(world: World, controllers: Sequence[Any], team: str) -> Float64:
    """The mean return of a team's agents in each held-out episode. A class in place of a controller is one of random
    actions.
    """
    seeds = range(measures.MEASUREMENT_SEEDS, measures.MEASUREMENT_SEEDS + EPISODES)
    chance = Uniform(world).start_episodes(seeds)
    players: list[Controller] = [chance if each is Uniform else each for each in controllers]
    if isinstance(world, ParticleWorld):
        return _returns_in_mpe2(world, players, seeds)[:, world.members(team)].mean(axis=1)
    assert (world.games or EPISODES) >= EPISODES
    return play(world, players, world.start_from_seeds(seeds), keep=False).returns[world.members(team)].mean(axis=0)


def _returns_in_mpe2(world: ParticleWorld, players: Sequence[Controller], seeds: Sequence[int]) -> Float64:
    """What agents are paid in episodes of mpe2's own environments, one for each seed, [episodes, n_agents]."""
    games = [world.reference_env() for _ in seeds]
    shown = [game.reset(seed=fold_seed(seed))[0] for game, seed in zip(games, seeds, strict=True)]
    paid = np.zeros((len(games), len(world.agents)))
    for _ in range(world.spec.episode_steps):
        seen = [np.array([each[agent] for each in shown]) for agent in world.agents]
        given = choose_actions(players, seen, seen[0])  # nobody here asks for the state
        for row, game in enumerate(games):
            acted = {agent: given[row, place] for place, agent in enumerate(world.agents)}
            shown[row], rewards, *_ = game.step(acted)
            paid[row] += [rewards[agent] for agent in world.agents]
    return paid


def measured(name: str, folder: Path, asked: Asked) -> list[Row]:
    """A row for each way and team: as the record has it of this expert, or measured and kept there."""
    world = find(GAMES[name].world, giving=True)
    expert, _ = network.load(str(folder), world)
    leaves, rows = asked.leaves or GAMES[name].leaves, list[Row]()
    missing: list[str] = []
    for way in asked.ways or (OF_SPREAD if name == "spread" else USUAL):
        about = {"game": name, "way": way, "asked": leaves, "seed": asked.seed, "expert_sha256": expert.hash}
        known = find_rows(asked.record, **about)
        missing += [] if known else [way]
        rows += known
    if not missing:
        return rows
    base = {team: _returns_of(world, expert, expert, team) for team in world.teams}
    chance = {team: _returns_of(world, Uniform, expert, team) for team in world.teams}
    for team in world.teams:
        print(f"{name}, {team}: expert {base[team].mean():.3f}, random {chance[team].mean():.3f}", flush=True)
    for way in missing:
        agents = _extract_agents(GAMES[name], world, expert, way, {"max_leaves": leaves, "seed": asked.seed})
        for team, members in ((team, world.members(team)) for team in world.teams):
            values = _returns_of(world, tree_policies(agents), expert, team)
            score, low, high = scored(values, base[team], chance[team])
            figures = {"return": values.mean(), "score": score, "low": low, "high": high}
            figures |= {"expert": base[team].mean(), "random": chance[team].mean()}
            row: Row = {"game": name, "team": team, "way": way, "asked": leaves}
            row["leaves"] = [len(ir.leaves(agents[agent].tree)) for agent in members]
            row["numbers"] = [size(agents[agent]) for agent in members]
            row |= {key: round(float(value), 3) for key, value in figures.items()}
            row |= {"episodes": EPISODES, "seed": asked.seed, "expert_sha256": expert.hash}
            print(f"    {team}: {row['return']:.3f}, score {tell_score(row)}", flush=True)
            keep_rows(asked.record, [row])
            rows.append(row)
    return rows


def _extract_agents(game: Game, world: World, expert: Any, way: str, given: Mapping[str, Any]) -> Sequence[Any]:
    """The trees of one way."""
    started = time.process_time()
    taught = Settled(expert, world) if way in MATES else expert
    settings = Settings.of({**given, **game.extracted, **{**TEAM_WAYS, **MATES}[way]}, world)
    agents = extract(world, taught, settings).agents
    print(f"  {way}: {[size(policy) for policy in agents]} numbers, {time.process_time() - started:.0f} CPU s")
    return agents


def table(record: Path) -> list[str]:
    """The lines of a table of a record's rows, as the manual has them."""
    order = [*TEAM_WAYS, *MATES]
    rows = sorted(read_rows(record), key=lambda row: (row["game"], row["team"], order.index(row["way"])))
    cells = [("game, team", "expert, random", "way", "leaves", "numbers", "score")]
    for row in rows:
        sizes = str(max(row["leaves"])), str(max(row["numbers"]))
        between = f"{row['expert']:.2f}, {row['random']:.2f}"
        cells.append((f"{row['game']}, {row['team']}", between, row["way"], *sizes, tell_score(row)))
    return align(cells)


def _returns_of(world: World, subject: Any, expert: Controller, team: str) -> Float64:
    """What a team returns if a subject plays it and the expert everybody else."""
    members = world.members(team)
    return returns(world, [subject if agent in members else expert for agent in range(len(world.agents))], team)


def main() -> None:
    options = parse_options(__doc__, list(GAMES), ())
    held_out.EVALUATION_EPISODES = 10  # a profile's own figures are not asked for
    if options.train:
        options.train.mkdir(exist_ok=True)
        for name in options.games:
            trained(GAMES[name], options.train / name, options.seed)
    figures: list[dict[str, Any]] = []
    for name in options.games if options.experts else ():
        if not (options.experts / name / "card.json").exists():
            print(f"{name}: no expert; --train FOLDER {name} makes it")
            continue
        ways = options.ways.split("+") if options.ways else ()
        for row in measured(name, options.experts / name, Asked(options.leaves, ways, options.seed, options.record)):
            called = f"{name}: score of {row['team']}, {row['way']}, {row['asked']} leaves"
            figures.append({"name": called, "value": row["score"], "reach": REACH, "stretch": STRETCH})
            figures[-1]["better"] = "higher"
    if options.record:
        print("\n".join(table(options.record)))
    if options.json:
        print(json.dumps({"figures": figures}))


if __name__ == "__main__":
    main()
