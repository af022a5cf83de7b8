"""The command train.

Does: has an expert trained, and says how good it is.
Assumes: the extra `maviper[train]`.
Does not: know how an algorithm learns.
"""

from pathlib import Path
from typing import Unpack

import click

from codegen.errors import ExitCode
from maviper.cli.group import Verb
from maviper.cli.options import console_of, options_of, output
from maviper.options import TrainOptions


@click.command(cls=Verb, example="maviper train predator-prey,prey=1 --seeds 4 --jobs 2 -o run")
@click.argument("world")
@options_of(TrainOptions)
@output("The run folder.")
@click.pass_context
def train(context: click.Context, world: str, output: Path, **options: Unpack[TrainOptions]) -> int:
    """Train an expert for WORLD into a run folder.

    Training needs the extra maviper[train]. WORLD is a game, with options after commas (predator-prey,prey=1), or
    module:function for your own environment.

    The folder always holds the best checkpoint so far. --resume continues an interrupted run and ends with the same
    expert.
    """
    from maviper.experts.cards import how_learned
    from maviper.experts.training.train import EXPERT_FILE, train_expert

    console = console_of(context)
    card = train_expert(world, output, console, **options)
    for label, value in card["measured"].items():
        if isinstance(value, list):
            console.line("measured", f"{label}: {value[0]:.3f} [{value[1]:.3f}, {value[2]:.3f}]")
    played = ", ".join(f"{steps:,} steps for the {what}" for what, steps in card["played"].items())
    console.line("played", f"{played}; the expert is the checkpoint after {card['steps']:,}; {card['seconds']:.0f} s")
    console.line("learned", f"by {how_learned(card)}; the critic's reward is {card['critic_reward']}")
    if "stopped" in card:
        console.line("stopped", f"{card['stopped']}; the last good checkpoints were kept")
    console.line("wrote", str(output / EXPERT_FILE))
    return ExitCode.VIOLATED if "stopped" in card else ExitCode.DONE
