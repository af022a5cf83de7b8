"""Training runs: an expert in a run folder, the best of its checkpoints on held-out episodes.

Does: trains, scores checkpoints, keeps the best in the folder at all times, measures the winner on fresh episodes.
Assumes: the extra `maviper[train]`.
Does not: resume an interrupted training (what the folder holds stays valid).
"""

import heapq
import json
import platform
from collections.abc import Callable
from dataclasses import asdict, dataclass
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np

from codegen.errors import InputError, MissingToolError
from codegen.ir import Float32
from maviper import runs
from maviper.evaluate import metrics
from maviper.experts import store
from maviper.worlds import ParticleWorld
from verify.shares import Share

CHECKPOINT_EPISODES = 1_000
FINALISTS = 5
FINAL_EPISODES = 4_000
EXPERT_FILE = "expert.safetensors"
RULE = (
    "a checkpoint's score is the mean over teams of the primary measure, all agents experts, on "
    f"{CHECKPOINT_EPISODES} episodes; the {FINALISTS} best are scored again on {FINAL_EPISODES} fresh ones, and the "
    f"best of these is the expert; `measured` comes from {FINAL_EPISODES} other episodes that no choice has seen"
)


@dataclass(frozen=True)
class Checkpoint:
    """A checkpoint's place in training and what it scored."""

    steps: int
    score: float
    success: dict[str, Share]


def train(
    world: ParticleWorld, folder: Path, overrides: dict[str, Any], on_checkpoint: Callable[[Checkpoint, int], None]
) -> dict[str, Any]:
    """Trains an expert for `world` into `folder`; returns its card.

    `overrides`: settings of `maddpg.Settings` that differ from the defaults. `on_checkpoint` gets each checkpoint and
    the number of steps in all. MissingToolError without torch.
    """
    try:
        import torch  # pyright: ignore[reportMissingImports]

        from maviper.experts import maddpg
    except ImportError:
        raise MissingToolError("training needs torch", "", "install the extra: pip install 'maviper[train]'") from None
    settings = maddpg.Settings(**overrides)
    least = settings.games * world.spec.episode_steps
    if settings.steps < least or not 0 <= settings.seed < 2**32:
        raise InputError(f"steps must be at least {least}, the seed from 0 to 4294967295", "--steps, --seed")
    torch.set_num_threads(1)  # small products: threads cost more than they give, and one thread repeats bit for bit
    runs.folder(folder)
    card = _card(world, asdict(settings), overrides)
    runs.write(folder / "config.json", json.dumps(card, indent=2, sort_keys=True) + "\n")
    log: list[str] = []
    finalists: list[tuple[float, int, dict[str, Float32]]] = []  # a heap, the worst first

    def score(tensors: dict[str, Float32]) -> tuple[float, dict[str, Share]]:
        return measured(world, tensors, settings.hidden, metrics.CHECKPOINT_SEEDS, CHECKPOINT_EPISODES)[:2]

    for steps, tensors, (value, success) in maddpg.train(world, settings, score):
        log.append(json.dumps({"steps": steps, "score": value, **{team: won.value for team, won in success.items()}}))
        runs.write(folder / "metrics.jsonl", "\n".join(log) + "\n")
        if not finalists or value > max(entry[0] for entry in finalists):
            provisional = card | {"steps": steps, "measured": {"note": "interrupted before the final measurement"}}
            runs.write(folder / EXPERT_FILE, store.encode(tensors, provisional))
        heapq.heappush(finalists, (value, steps, tensors))
        if len(finalists) > FINALISTS:
            heapq.heappop(finalists)
        on_checkpoint(Checkpoint(steps, value, success), settings.steps)

    again = [
        (measured(world, tensors, settings.hidden, metrics.FINALIST_SEEDS, FINAL_EPISODES)[0], steps, tensors)
        for _, steps, tensors in finalists
    ]
    _, steps, tensors = max(again, key=lambda entry: entry[:2])
    card |= {"steps": steps, "measured": facts(world, tensors, settings.hidden)}
    runs.write(folder / EXPERT_FILE, store.encode(tensors, card))
    return card


def _card(world: ParticleWorld, settings: dict[str, Any], overrides: dict[str, Any]) -> dict[str, Any]:
    """What is known of an expert before it is trained."""
    options = (f"--{key.replace('_', '-')} {value}" for key, value in sorted(overrides.items()))
    return {
        "world": world.name,
        "reference": world.spec.reference,
        "algorithm": "maddpg",
        "command": " ".join(["maviper train", world.name, *options]),
        "hidden": settings["hidden"],
        "settings": settings,
        "versions": versions(),
        "rule": RULE,
    }


def measured(
    world: ParticleWorld, tensors: dict[str, Float32], hidden: int, first_seed: int, episodes: int
) -> tuple[float, dict[str, Share], list[dict[str, Share]]]:
    """Mean over teams of the primary measure, each team's share at the primary radius, and the shares at all radii."""
    expert = store.decode(store.encode(tensors, {"world": world.name, "hidden": hidden}), "checkpoint")
    tables = metrics.success(world, expert.policies(), range(first_seed, first_seed + episodes))
    return float(np.mean([won.value for won in tables[0].values()])), tables[0], tables


def facts(world: ParticleWorld, tensors: dict[str, Float32], hidden: int) -> dict[str, Any]:
    """The winner's measured success for the card."""
    tables = measured(world, tensors, hidden, metrics.MEASUREMENT_SEEDS, FINAL_EPISODES)[2]
    return {"episodes": FINAL_EPISODES, "first_episode_seed": metrics.MEASUREMENT_SEEDS} | {
        f"{team} success r={squared**0.5:.3g}": [won.value, *(round(end, 4) for end in won.interval)]
        for squared, table in zip(world.squared_radii, tables, strict=True)
        for team, won in table.items()
    }


def versions() -> dict[str, str]:
    """Versions of what took part."""
    return {"python": platform.python_version()} | {
        name: metadata.version(name) for name in ("maviper", "mpe2", "numpy", "torch")
    }
