"""What is written down about an expert: how it was made, how good it is, how it learned.

Does: the config of a run, tables of estimates as plain data, the learning curve as an SVG picture.
Assumes: the curve needs matplotlib (the extra `maviper[train]`).
Does not: measure anything.
"""

import io
import os
import platform
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from importlib import import_module
from typing import Any

from maviper.episodes.measures import Estimate
from maviper.experts.judging import Judged
from maviper.experts.recipes import DEFAULT, Request, schedule
from maviper.files.profiles import version
from maviper.worlds import Measure, World

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
