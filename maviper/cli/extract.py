"""The command extract.

Does: has trees extracted from an expert; notes the command line that repeats it.
Assumes: `maviper.extraction.run` extracts, shows progress and writes.
Does not: know how trees are grown.
"""

from pathlib import Path
from typing import Any

import click

from codegen.errors import ExitCode
from maviper.cli.group import Verb
from maviper.cli.options import PATH, console_of, option, output

# named here again, so that --help imports nothing; a test compares them with the ones that there are
ALGORITHMS = "maviper, maviper-no-prediction, maviper-iviper-resampling, iviper, viper, imitation, fitted-q"
FEATURES = "velocity, goal, differences, signs (several with +)"
WHAT, EPISODES, LEARNS, HOW = "What is extracted", "Episodes", "What it learns from", "How it runs"
RENAMED = {"--budget": "--max-episodes", "--refinement": "--refinement-episodes"}


@click.command(
    cls=Verb,
    renamed=RENAMED,
    example="maviper extract physical-deception -o small.json --max-episodes 500\n"
    "maviper extract physical-deception -o run --max-depth 5 --seeds 4",
)
@click.argument("expert")
@option(
    "--algorithm",
    default="maviper",
    show_default=True,
    metavar="NAME",
    section=WHAT,
    help=f"One of {ALGORITHMS}.",
)
@option(
    "--preset",
    default="default",
    show_default=True,
    metavar="NAME",
    section=WHAT,
    help="default; paper, to the letter; or released, as the authors' code does.",
)
@option("--max-depth", default=4, show_default=True, section=WHAT, help="Splits on the longest path.")
@option("--agent", default=None, metavar="NAME", section=WHAT, help="The one agent that VIPER extracts.")
@option("--splits", default=None, metavar="NAME", section=WHAT, help="exact or histogram (default: the preset's).")
@option(
    "--least-right",
    default="N-1",
    show_default=True,
    metavar="VOTES",
    section=WHAT,
    help="Members that must be predicted right, of a team of N: N, N-1, 2, or a share such as 0.5.",
)
@option("--features", default="", metavar="NAMES", section=WHAT, help=f"Further features: {FEATURES}, or auto.")
@option(
    "--max-episodes", type=int, default=None, section=EPISODES, help="Episodes in all, instead of the counts below."
)
@option(
    "--iterations",
    type=int,
    default=None,
    section=EPISODES,
    help="Rounds of rollouts and growth (default: the paper's).",
)
@option("--rollouts", type=int, default=None, section=EPISODES, help="Episodes a round (default: the paper's).")
@option(
    "--patience",
    type=int,
    default=None,
    section=EPISODES,
    help="Stop after this many rounds without a gain (default: 10).",
)
@option(
    "--selection",
    default=None,
    metavar="NAME",
    section=EPISODES,
    help="uniform, return or race (default: the preset's).",
)
@option(
    "--selection-episodes",
    type=int,
    default=None,
    section=EPISODES,
    help="Episodes for each candidate and team (default: 100).",
)
@option(
    "--refinement-episodes",
    type=int,
    default=None,
    section=EPISODES,
    help="Episodes per team to refine the trees with (default: the preset's).",
)
@option(
    "--measure",
    default=None,
    metavar="NAME",
    section=EPISODES,
    help="The measure that teams are judged by (default: the world's first; preset paper: the paper's).",
)
@option(
    "--explore",
    default=0.0,
    show_default=True,
    section=LEARNS,
    help="fitted-q: share of uniform actions while it collects.",
)
@option(
    "--critic",
    default="learned",
    show_default=True,
    section=LEARNS,
    help="Whose Q weighs states: learned, measured, none.",
)
@option("--world", default=None, section=LEARNS, help="module:function of the expert's environment, if it is your own.")
@option(
    "--counterexamples",
    multiple=True,
    type=PATH,
    metavar="PATH",
    section=LEARNS,
    help="A file of `maviper verify -o`, or its folder, to learn from (repeatable).",
)
@option("--seed", default=0, show_default=True, section=HOW, help="The seed of everything random.")
@option("--seeds", default=1, show_default=True, section=HOW, help="Extract this many seeds; keep the best.")
@option(
    "--jobs", default=1, show_default=True, section=HOW, help="Processes: for seeds, IVIPER's agents, or refinement."
)
@option("--resume", is_flag=True, section=HOW, help="Go on with the run in the folder.")
@output("The profile's JSON file, or a run folder.")
@click.pass_context
def extract(context: click.Context, expert: str, output: Path, **options: Any) -> int:
    """Extract decision trees from an expert, as a policy profile.

    EXPERT is a world's name, an expert file or a run folder. A world's name means its shipped expert, or its scripted
    one where no network is shipped (cooperative-navigation,agents=12). module:function calls one of your own.

    -o names the profile's JSON file, or a folder for the whole run: config, metrics, finished steps and profile. An
    interrupted run in a folder goes on with --resume, and ends with the same profile.

    With --counterexamples every round also learns from states in which a team failed a claim. In each it learns what
    the expert does there, changed for as few agents as the claim needs. The command then says how often the claim fails
    before and after, which actions changed, and what that costs in play. It also writes this into refit.json.
    """
    from maviper.extraction.run import ExtractOptions, extracted

    asked = ExtractOptions(**options, command=_command(context, expert, options))
    extracted(expert, output, asked, console_of(context))
    return ExitCode.DONE


def _command(context: click.Context, expert: str, options: dict[str, Any]) -> str:
    """The command line that asks for the same, without what only says how it runs on."""
    said = [
        f"--{name.replace('_', '-')} {value}"
        for name, values in sorted(options.items())
        if context.get_parameter_source(name) is click.core.ParameterSource.COMMANDLINE
        for value in (values if isinstance(values, tuple) else (values,))
    ]
    return " ".join(["maviper extract", expert, *(text for text in said if not text.startswith("--resume"))])
