"""Training as a command: one seed with a live line, or several side by side, of which the best is kept.

Does: joins worlds, trainers, console and run folders.
Assumes: the extra `maviper[train]`.
Does not: know how an algorithm learns.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from codegen.errors import ExitCode, InputError
from maviper import runs
from maviper.console import Console
from maviper.evaluate.metrics import Estimate, shown
from maviper.experts import train as training
from maviper.experts.recipes import Request
from maviper.jobs import side_by_side
from maviper.worlds import World, find

MOST_SEEDS = 1_000
SEEDS_FILE = "seeds.json"


def train_command(name: str, folder: Path, options: Mapping[str, Any], console: Console) -> int:
    """Trains what the command line asks for; 0, or 1 when a training had to stop early."""
    overrides: dict[str, Any] = {"seed": options["seed"]}
    overrides |= {} if options["steps"] is None else {"steps": options["steps"]}
    overrides |= dict(_setting(text) for text in options["settings"])
    request = Request(options["algorithm"], options["recipe"], overrides, options["device"]).checked()
    world = find(name)
    seeds = range(options["seed"], options["seed"] + options["seeds"])
    if not 1 <= len(seeds) <= MOST_SEEDS or options["jobs"] < 1:
        raise InputError(f"--seeds must be from 1 to {MOST_SEEDS}, --jobs at least 1", "--seeds, --jobs")
    console.line("training", f"{world.name}, {request.algorithm}, recipe {request.recipe}, {_seeds(seeds)}")
    if len(seeds) == 1:
        card = _one(world, folder, request, options["resume"], console)
    else:
        card = _several(name, folder, request, seeds, options["jobs"], options["resume"], console)
    for label, value in card["measured"].items():
        if isinstance(value, list):
            console.line("measured", f"{label}: {value[0]:.3f} [{value[1]:.3f}, {value[2]:.3f}]")
    if "stopped" in card:
        console.line("stopped", f"{card['stopped']}; the last good checkpoints were kept")
    console.line("wrote", str(folder / training.EXPERT_FILE))
    return ExitCode.VIOLATED if "stopped" in card else ExitCode.DONE


def _setting(text: str) -> tuple[str, str]:
    name, separator, value = text.partition("=")
    if not separator:
        raise InputError(f"'{text[:40]}' is not a setting", "--set", "write --set NAME=VALUE")
    return name, value


def _seeds(seeds: Sequence[int]) -> str:
    return f"seed {seeds[0]}" if len(seeds) == 1 else f"seeds {seeds[0]} to {seeds[-1]}"


def _one(world: World, folder: Path, request: Request, resume: bool, console: Console) -> dict[str, Any]:
    best: list[training.Checkpoint] = []
    with console.live("steps", 1) as live:

        def show(checkpoint: training.Checkpoint, total: int) -> None:
            if not best or checkpoint.score > best[0].score:
                best[:] = [checkpoint]
            live.total = total
            live.update(checkpoint.steps, f"best {_measured(best[0].measured)}; return {_measured(checkpoint.returns)}")

        return training.train(world, folder, request, show, resume)


def _measured(found: Mapping[str, Estimate]) -> str:
    return ", ".join(f"{team} {shown(value)}" for team, value in found.items())


def _several(
    name: str, folder: Path, request: Request, seeds: Sequence[int], jobs: int, resume: bool, console: Console
) -> dict[str, Any]:
    """Each seed in a folder of its own; the one with the best score on its finalists' episodes becomes the run's."""
    folders = [folder / f"seed-{seed}" for seed in seeds]
    asked = [replace(request, overrides={**request.overrides, "seed": seed}) for seed in seeds]
    tasks = [
        (name, place, one, resume and (place / runs.CONFIG_FILE).exists())
        for place, one in zip(folders, asked, strict=True)
    ]
    cards: list[dict[str, Any]] = []
    for seed, card in zip(seeds, side_by_side(_quietly, tasks, jobs), strict=True):
        cards.append(card)
        console.line("seed", f"{seed}: score {card['score']:.3f}, {card['steps']} steps, {card['seconds']:.0f} s")
    best = max(range(len(cards)), key=lambda index: (cards[index]["score"], -index))
    for file in (training.EXPERT_FILE, training.CARD_FILE, training.CURVE_FILE):
        runs.write(folder / file, (folders[best] / file).read_bytes())
    table = {str(seed): {"score": card["score"], **card["measured"]} for seed, card in zip(seeds, cards, strict=True)}
    runs.write(folder / SEEDS_FILE, runs.as_json({"best": seeds[best], "seeds": table}))
    console.line("best", f"seed {seeds[best]}")
    return cards[best]


def _quietly(name: str, folder: Path, request: Request, resume: bool) -> dict[str, Any]:
    return training.train(find(name), folder, request, resume=resume)
