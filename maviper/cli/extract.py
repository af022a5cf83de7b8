"""The command extract.

Does: has trees extracted from an expert; notes the command line that repeats it.
Assumes: `maviper.extraction.run` extracts, shows progress and writes.
Does not: know how trees are grown.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Unpack, cast

import click

from codegen.errors import ExitCode
from maviper.cli.group import Verb
from maviper.cli.options import FolderPath, console_of, options_of, output
from maviper.options import ExtractOptions

RENAMED = {"--budget": "--max-episodes", "--refinement": "--refinement-episodes"}


@click.command(
    cls=Verb,
    renamed=RENAMED,
    example="maviper extract physical-deception -o small.json --max-episodes 500\n"
    "maviper extract physical-deception -o run --max-depth 5 --seeds 4",
)
@click.argument("expert")
@options_of(ExtractOptions)
@output("The profile's JSON file, or a run folder.", FolderPath(".json"))
@click.pass_context
def extract(context: click.Context, expert: str, output: Path, **options: Unpack[ExtractOptions]) -> int:
    """Extract decision trees from an expert, as a policy profile.

    EXPERT is the name of a world, an expert file, a run folder, sb3:FILE.zip of stable-baselines3 (maviper guide own),
    or module:function for your own expert. The name of a world stands for its shipped expert. A world without one uses
    its scripted expert (cooperative-navigation,agents=12).

    -o is a JSON file for the profile, or a folder for the whole run: config, metrics, finished steps and profile. In a
    folder, --resume continues an interrupted run and ends with the same profile.

    With --counterexamples, every round also learns from states in which a team violated a claim. The label of such a
    state is what the expert does there, changed for as few agents as the claim needs. The command then reports how
    often the claim fails before and after, which actions changed, and what the change costs in play. It also writes
    these figures to refit.json.
    """
    from maviper.extraction.run import extract_named, request

    asked = request(options, _command(context, expert, options))
    extract_named(expert, output, asked, console_of(context))
    return ExitCode.DONE


def _command(context: click.Context, expert: str, options: Mapping[str, object]) -> str:
    """The command line that asks for the same, without what only says how it runs on."""
    said = [
        f"--{name.replace('_', '-')} {value}"
        for name, values in sorted(options.items())
        if context.get_parameter_source(name) is click.core.ParameterSource.COMMANDLINE
        for value in (cast("tuple[object, ...]", values) if isinstance(values, tuple) else (values,))
    ]
    return " ".join(["maviper extract", expert, *(text for text in said if not text.startswith("--resume"))])
