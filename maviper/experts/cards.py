"""How an expert is trained, chosen, and written down: recipes, scores of checkpoints, and the card.

Does: knows the algorithms and the settings of each recipe, and turns a user's `name=value` into settings; one score for
  a checkpoint from all teams' primary measures, in play among the run's own networks; the config of a run, tables of
  estimates as plain data, the learning curve as an SVG picture.
Assumes: settings are frozen dataclasses of numbers; the curve needs matplotlib (the extra `maviper[train]`). A team
  whose measure is a share is judged in play among experts, by its log-odds: halving the failures counts alike at .5 and
  at .98. So is a world's only team, by its measure as it is. Touches among learners say nothing of either side, so that
  all other teams are rated against rivals: what a checkpoint gains on each of them, in the place of every team, on top
  of the rival's own rating.
Does not: import torch, or ask a script.
"""

import io
import math
import os
import platform
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields, replace
from importlib import import_module
from itertools import combinations
from typing import Any

import numpy as np

from codegen.errors import InputError, UnknownNameError
from codegen.intervals import Share
from maviper.episodes import measures
from maviper.episodes.measures import Estimate
from maviper.episodes.play import Controller
from maviper.experts.network import NetworkExpert
from maviper.files.profiles import version
from maviper.worlds import Measure, World

DEFAULT, CLONE, PAPER = "default", "clone", "paper"
RECIPES = (DEFAULT, CLONE, PAPER)
MAPPO = "mappo"
ALGORITHMS = (MAPPO, "maddpg", "vdn")
LEAST, MAX_NUMBER = {"steps": 1, "games": 1, "epochs": 1, "minibatch": 1, "hidden": 1, "batch": 1, "buffer": 1}, 1e12
MOST = {"scaled": 1, "shared": 1}  # of what is done or is not
OPTIONS = ("steps", "seed")  # settings with an option of their own

# What the default recipe changes in an algorithm's own defaults, for a game or one of its variants: reward alone.
# Fresh games for every step of the optimiser: playing costs a tenth of learning.
FRESH: dict[str, Any] = {"epochs": 1, "minibatch": 1_600}
CHOSEN: dict[tuple[str, str], dict[str, Any]] = {
    ("physical-deception", MAPPO): {**FRESH, "steps": 3_072_000, "learning_rate": 2e-3},
    ("cooperative-navigation", MAPPO): {
        **FRESH,
        "shared": 1,
        "steps": 16_384_000,
        "learning_rate": 3e-3,
        "checkpoint_steps": 512_000,
    },
    ("predator-prey", MAPPO): {
        **FRESH,
        "shared": 1,
        "steps": 24_576_000,
        "learning_rate": 2e-3,
        "past": 0.25,
        "shaping": 3.0,
        "checkpoint_steps": 1_228_800,
    },
}
# The clone recipe imitates the game's script first, and plays against it where that is said.
CLONED: dict[str, dict[str, Any]] = {
    "physical-deception": {"imitate_steps": 512_000, "steps": 2_048_000, "learning_rate": 5e-4},
    "cooperative-navigation": {
        "hidden": 128,
        "imitate_steps": 2_048_000,
        "steps": 4_096_000,
        "learning_rate": 5e-4,
        "entropy": 0.003,
    },
    "predator-prey": {
        "hidden": 128,
        "imitate_steps": 768_000,
        "steps": 4_096_000,
        "scripted": 0.5,
        "shaping": 3.0,
        "learning_rate": 5e-4,
    },
}
# The released code's training: no shaping, large batches, long, the best of many checkpoints. What differs: `schedule`.
PAPER_MADDPG = {"steps": 2_000_000, "batch": 25_600, "shaping": 0.0, "final_rate": 1.0, "explore_share": 0.3125}


@dataclass(frozen=True)
class Request:
    """The options with which a training is requested."""

    algorithm: str = ""  # "": the recipe's
    recipe: str = DEFAULT
    overrides: Mapping[str, Any] = field(default_factory=dict[str, Any])
    device: str = "cpu"
    against: tuple[str, ...] = ()  # experts that the learner meets
    begin: NetworkExpert | None = None  # whose actors the training starts from; None: random ones
    critic: bool = True  # whether actors that learned without a critic get one in the end

    def complete(self) -> "Request":
        """The request with its algorithm; UnknownNameError for a recipe or algorithm that there is not."""
        if self.recipe not in RECIPES:
            raise UnknownNameError("recipe", self.recipe, RECIPES, "--recipe")
        algorithm = self.algorithm or ("maddpg" if self.recipe == PAPER else MAPPO)
        if algorithm not in ALGORITHMS:
            raise UnknownNameError("algorithm", algorithm, ALGORITHMS, "--algorithm")
        if self.recipe == PAPER and algorithm != "maddpg":
            raise InputError(f"the paper has no recipe for {algorithm}", "--recipe paper", "leave --algorithm out")
        if self.recipe == CLONE and algorithm != MAPPO:
            raise InputError(f"{algorithm} cannot imitate", "--recipe clone", "leave --algorithm out")
        if self.against and algorithm != MAPPO:
            raise InputError(f"{algorithm} meets no experts", "--against", "leave it out, or train with mappo")
        return replace(self, algorithm=algorithm)


def settings(world: World, request: Request, kind: type) -> Any:
    """The settings of a request: the recipe's, with the user's on top. `kind`: the algorithm's settings class.

    UnknownNameError for a name that there is not, InputError for a value that cannot be used.
    """
    chosen = dict(PAPER_MADDPG) if request.recipe == PAPER else {}
    if request.recipe == CLONE:
        if world.spec.name not in CLONED:
            raise InputError("there is no script to clone for this world", world.name, "leave --recipe out")
        chosen = CLONED[world.spec.name]
    if request.recipe == DEFAULT:
        general = CHOSEN.get((world.spec.name, request.algorithm), {})
        chosen = CHOSEN.get((world.name, request.algorithm), general)
    types: dict[str, type] = {item.name: type(item.default) for item in fields(kind)}
    given = {name: _value(name, value, types) for name, value in request.overrides.items()}
    combined = kind(**{**chosen, **given})
    values = asdict(combined)
    for name, value in values.items():
        least, most = LEAST.get(name, 0), MOST.get(name, MAX_NUMBER)
        if not least <= value <= most:
            where = f"--{name}" if name in OPTIONS else f"--set {name}"
            raise InputError(f"setting {name} must be from {least} to {most:g}, not {value}", where)
    if not values["seed"] < 2**32:
        raise InputError("the seed must be from 0 to 4294967295", "--seed")
    least = values["games"] * world.spec.episode_steps
    if values["steps"] < least:
        raise InputError(f"steps must be at least {least}: one episode of each game", "--steps")
    return combined


def schedule(request: Request, chosen: Any) -> str:
    """Describes the episodes that a training of these settings plays and when it is judged, and where `paper` is not as
    released or as the recipe has it.
    """
    imitated = min(chosen.steps, getattr(chosen, "imitate_steps", 0))
    copied = f", the first {imitated:,} to imitate a script" if imitated else ""
    said = f"{chosen.steps:,} steps in {chosen.games:,} parallel games, a checkpoint every {chosen.checkpoint_steps:,}"
    said += copied
    if request.recipe != PAPER:
        return said
    changed = {name: usual for name, usual in PAPER_MADDPG.items() if getattr(chosen, name) != usual}
    told = [f"; {name} {getattr(chosen, name):,} (recipe: {usual:,})" for name, usual in changed.items()]
    return f"{said} (released: one game, a checkpoint every 25,000, the best by summed return)" + "".join(told)


def _value(name: str, value: Any, types: Mapping[str, type]) -> Any:
    if name not in types:
        raise UnknownNameError("setting", name, types, "--set")
    try:
        read = types[name](value)
        if isinstance(value, float) and read != value:
            raise ValueError(value)
        return read
    except (TypeError, ValueError, OverflowError):
        kind = "a whole number" if types[name] is int else "a number"
        raise InputError(f"setting {name} must be {kind}, not '{value}'", "--set", f"--set {name}=VALUE") from None


N_RIVALS = 3  # of a checkpoint: the best before it


@dataclass(frozen=True)
class Rival:
    """An earlier checkpoint of the same run."""

    controller: Controller
    score: float


@dataclass(frozen=True)
class Judged:
    """A score (higher is better) and the estimates in play among experts, returns included."""

    score: float
    among: dict[Measure, Estimate]

    def primary(self, world: World) -> dict[str, Estimate]:
        """Returns each team's primary measure, by which it is judged."""
        return {team: self.among[world.primary(team)] for team in world.teams}


def judge(world: World, controller: Controller, seeds: range, rivals: Sequence[Rival] = ()) -> Judged:
    """Judges a controller of all agents on the episodes `seeds`. `rivals` count in a world that is rated (`is_rated`);
    the first checkpoint of all has none and scores 0.
    """
    among = measures.evaluate(world, [controller] * len(world.agents), seeds)
    if not is_rated(world):
        return Judged(_mean([_worth(measure, among[measure]) for measure in _primary(world)]), among)
    ratings = [rival.score + advantage(world, controller, rival.controller, seeds) for rival in rivals]
    return Judged(_mean(ratings) if ratings else 0.0, among)


def scores(world: World, finalists: Sequence[Controller], seeds: range) -> list[float]:
    """A score of each, on the same episodes; in a rated world (`is_rated`), what it gains on the others on average."""
    if not is_rated(world):
        return [judge(world, controller, seeds).score for controller in finalists]
    gains = np.zeros((len(finalists), len(finalists)))
    for a, b in combinations(range(len(finalists)), 2):
        gains[a, b] = advantage(world, finalists[a], finalists[b], seeds)
        gains[b, a] = -gains[a, b]
    return (gains.sum(axis=1) / max(1, len(finalists) - 1)).tolist()


def is_rated(world: World) -> bool:
    """Returns True if checkpoints are rated against rivals: several teams, not all of whose measures are shares."""
    return len(world.teams) > 1 and not all(measure.share for measure in _primary(world))


def advantage(world: World, ours: Controller, theirs: Controller, seeds: range) -> float:
    """Measures by how much each team does better when `ours` plays it and `theirs` all others than the other way round:
    the mean over teams, in the measure's unit. What `ours` gains on `theirs`, `theirs` loses.
    """
    gained = dict.fromkeys(world.teams, 0.0)
    played: dict[tuple[bool, ...], dict[Measure, Estimate]] = {}
    for team in world.teams:
        members, measure = world.members(team), world.primary(team)
        for sign, mine in ((1, True), (-1, False)):
            who = tuple(mine if agent in members else not mine for agent in range(len(world.agents)))
            if who not in played:
                played[who] = measures.evaluate(world, [ours if each else theirs for each in who], seeds)
            gained[team] += sign * _worth(measure, played[who][measure])
    return _mean(list(gained.values()))


def _primary(world: World) -> list[Measure]:
    return [world.primary(team) for team in world.teams]


def _worth(measure: Measure, estimate: Estimate) -> float:
    """Higher is better. A share's log-odds, with half a failure and half a success added, so that a perfect one is
    finite.
    """
    value = estimate.value
    if isinstance(estimate, Share):
        value = math.log((estimate.hits + 0.5) / (estimate.count - estimate.hits + 0.5))
    return -value if measure.lower_is_better else value


def _mean(values: Sequence[float]) -> float:
    return float(np.mean(values))


BEGINS_WITH = "begins_with"  # the hash of the expert whose actors a training starts from
PACKAGES = ("mpe2", "numpy", "torch")
UNSAID = ("scaled",)  # settings that cards do not name where they are 0, as those before them did not


def config(world: World, request: Request, chosen: Any, rule: str) -> dict[str, Any]:
    """Returns all that is known of an expert before it is trained. `chosen`: its settings, a dataclass."""
    settings = {name: value for name, value in asdict(chosen).items() if value or name not in UNSAID}
    command = ["maviper train", world.name, f"--algorithm {request.algorithm}"]
    command += [f"--recipe {request.recipe}"] if request.recipe != DEFAULT else []
    for name, value in sorted(request.overrides.items()):
        command.append(f"--{name} {value}" if name in ("seed", "steps") else f"--set {name}={value}")
    command += [f"--against {name}" for name in request.against]
    begun = {} if request.begin is None else {BEGINS_WITH: request.begin.hash}
    return begun | {
        "world": world.name,
        "reference": world.spec.reference,
        "algorithm": request.algorithm,
        "recipe": request.recipe,
        "command": " ".join(command),
        "hidden": settings["hidden"],
        "settings": settings,
        "critic_reward": reward_of(settings, world),
        "schedule": schedule(request, chosen),
        "versions": {"python": platform.python_version()} | versions(),
        "rule": rule,
    }


def versions() -> dict[str, str]:
    """The versions of the packages that a training rests on."""
    from importlib import metadata  # here, since its import takes longer than that of most of our rooms

    return {"maviper": version()} | {name: metadata.version(name) for name in PACKAGES}


IMITATION, VALUES, REWARD = "imitation", "values alone", "reward"  # what steps of a training teach the actors
SHAPED = ("mappo", "maddpg", "vdn")  # algorithms whose settings have a `shaping`
SHAPED_LATER = (
    "cooperative-navigation",
)  # worlds that had no shaping term when cards did not tell the critic's reward


def count_steps(card: Mapping[str, Any]) -> dict[str, int]:
    """Joint steps that taught an expert, by kind; {} where its card does not tell. Older cards have settings only."""
    settings, steps = card.get("settings", {}), card.get("steps")
    if "learned" in card or card.get("algorithm") not in SHAPED or steps is None:
        return dict(card.get("learned", {}))
    imitated = min(steps, settings.get("imitate_steps", 0))
    values = min(steps - imitated, settings["value_steps"]) if imitated else 0
    return {IMITATION: imitated, VALUES: values, REWARD: steps - imitated - values}


def how_learned(card: Mapping[str, Any]) -> str:
    """`count_steps` in words; "" where the card does not tell."""
    steps = count_steps(card)
    if not steps:
        return ""
    alone = f", {steps[VALUES]:,} of values alone" if steps[VALUES] else ""
    copied = f"{steps[IMITATION]:,} steps of imitating a script{alone}, " if steps[IMITATION] else ""
    return f"{copied}{steps[REWARD]:,} {'' if copied else 'steps '}of reward"


def critic_reward(card: Mapping[str, Any], world: World) -> str:
    """Returns the kind of reward that an expert's critic adds up; "" where the card does not tell."""
    if "critic_reward" in card or card.get("algorithm") not in SHAPED:
        return str(card.get("critic_reward", ""))
    if world.spec.name in SHAPED_LATER:
        return "environment"
    return reward_of(card["settings"], world)


def reward_of(settings: Mapping[str, Any], world: World) -> str:
    """The reward that a training with these settings fits its critic to: the environment's, with so much of the world's
    shaping term.
    """
    weight = settings["shaping"] * settings.get("critic_shaping", 1.0)
    return f"environment + {weight:g} * shaping" if weight and world.shaped else "environment"


def machine(device: str) -> str:
    """The kind of machine, without its name."""
    return f"{platform.system()} {platform.machine()}, {os.cpu_count()} cores, device {device}"


def row(estimate: Estimate) -> list[float]:
    """An estimate as [value, low, high]."""
    return [estimate.value, *(round(end, 6) for end in estimate.interval)]


def table(judged: Judged) -> dict[str, list[float]]:
    """All estimates by label."""
    return {measure.label: row(value) for measure, value in judged.among.items()}


def learning_curve(world: World, lines: Sequence[Mapping[str, Any]]) -> str:
    """Each team's primary measure over the steps of a training, with its 95 % intervals, as SVG; the same bytes for the
    same lines.
    """
    mpl: Any = import_module("matplotlib")
    drawing: Any = import_module("matplotlib.figure")

    measures = [world.primary(team) for team in world.teams]
    with mpl.rc_context({"svg.hashsalt": "maviper", "svg.fonttype": "none", "font.size": 9}):
        figure = drawing.Figure(figsize=(6, 2.6 * len(measures)), layout="constrained")
        panels = figure.subplots(len(measures), 1, squeeze=False, sharex=True)[:, 0]
        for panel, measure in zip(panels, measures, strict=True):
            _curve(panel, measure, lines)
        panels[-1].set_xlabel("joint environment steps, millions")
        file = io.StringIO()
        figure.savefig(file, format="svg", metadata={"Date": None, "Creator": None})
    return file.getvalue()


def _curve(panel: Any, measure: Measure, lines: Sequence[Mapping[str, Any]]) -> None:
    millions = [line["steps"] / 1e6 for line in lines]
    values, lows, highs = zip(*(line[measure.label] for line in lines), strict=True)
    panel.fill_between(millions, lows, highs, alpha=0.25, linewidth=0)
    if len(lines) == 1:  # a line and a band of one point would show nothing
        panel.vlines(millions, lows, highs, linewidth=1.2)
    panel.plot(millions, values, linewidth=1.2, marker="o" if len(lines) == 1 else None)
    panel.set_title(measure.label + (" (lower is better)" if measure.lower_is_better else ""), loc="left")
    panel.grid(alpha=0.3)
