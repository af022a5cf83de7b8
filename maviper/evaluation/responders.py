"""Networks that learn to answer a frozen team with our own trainer: from random weights, and from an expert's actors.

Does: trains in a run folder per network, goes on where one was interrupted, seats the result in the whole game.
Assumes: the extra `maviper[train]`, but only when a network has to be trained.
Does not: choose among responders (exploitability.py), or promise a best response.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from maviper.episodes.facing import Facing
from maviper.evaluation.exploitability import Responder
from maviper.experts import store
from maviper.experts.network import NetworkExpert
from maviper.experts.recipes import Request
from maviper.experts.training import train as training
from maviper.files import runs

SCRATCH, WARM = "network from scratch", "network from the expert"
STEPS, CHECKPOINTS = 1_024_000, 20
ALGORITHM = "mappo"


@dataclass(frozen=True)
class Learning:
    """The settings with which networks learn to answer. The same values give the same networks."""

    folder: Path  # one run folder in it for each network
    steps: int = STEPS  # joint steps of the environment
    seed: int = 0
    algorithm: str = ALGORITHM
    on_step: Callable[[training.Step], None] = lambda step: None


def networks(game: Facing, expert: object, learning: Learning) -> list[Responder]:
    """A network trained from scratch; one more from the expert's actors, where `expert` has some that fit the training.

    MissingToolError without torch; InputError for settings or a folder that cannot be used.
    """
    responders = [_network(game, SCRATCH, None, learning)]
    if isinstance(expert, NetworkExpert) and set(game.agents) <= set(expert.agents) and expert.centralized:
        responders.append(_network(game, WARM, expert, learning))
    return responders


def _network(game: Facing, name: str, begin: NetworkExpert | None, learning: Learning) -> Responder:
    folder = learning.folder / name.replace(" ", "-")
    overrides: dict[str, Any] = {"steps": learning.steps, "seed": learning.seed}
    overrides["checkpoint_steps"] = max(1, learning.steps // CHECKPOINTS)
    if learning.algorithm == ALGORITHM:  # no team-mates may be alike: each its own network, as `begin` needs
        overrides |= {"shared": 0, "past": 0.0}
    if begin is not None:
        overrides["hidden"] = begin.card["hidden"]
    least = min(game.games or training.settings_of(game, Request(learning.algorithm)).games, learning.steps)
    overrides["games"] = max(1, min(least, learning.steps // game.spec.episode_steps))
    request = Request(learning.algorithm, overrides=overrides, begin=begin, critic=False)
    training.train(game, folder, request, resume=runs.holds_run(folder), on_step=learning.on_step)
    place = folder / training.EXPERT_FILE
    answer = store.decode(runs.read(place, store.MAX_BYTES), str(place), game)
    return Responder(name, game.seat_controllers(answer))
