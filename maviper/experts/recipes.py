"""How each game's expert is trained when nobody says otherwise, and what may be said.

Does: knows the algorithms, the settings of each recipe, and turns a user's `name=value` into settings.
Assumes: settings are frozen dataclasses of numbers.
Does not: import torch.
"""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields, replace
from typing import Any

from codegen.errors import InputError, UnknownNameError
from maviper.experts.network import NetworkExpert
from maviper.worlds import World

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
        chosen = _find_clone_recipe(world)
    if request.recipe == DEFAULT:
        general = CHOSEN.get((world.spec.name, request.algorithm), {})
        chosen = CHOSEN.get((world.name, request.algorithm), general)
    types: dict[str, type] = {item.name: type(item.default) for item in fields(kind)}
    given = {name: _value(name, value, types) for name, value in request.overrides.items()}
    combined = kind(**{**chosen, **given})
    _check(asdict(combined), world)
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


def _find_clone_recipe(world: World) -> dict[str, Any]:
    if world.spec.name not in CLONED:
        raise InputError("there is no script to clone for this world", world.name, "leave --recipe out")
    return CLONED[world.spec.name]


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


def _check(values: Mapping[str, Any], world: World) -> None:
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
