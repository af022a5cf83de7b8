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
ALGORITHMS = "maviper, maviper-no-prediction, maviper-iviper-resampling, iviper, viper, imitation, fitted-q, rgmdt"
FEATURES = "velocity, goal, differences, signs, ahead, coasting (several with +)"
WHAT, EPISODES, LEARNS, HOW = "What is extracted", "Episodes", "What it learns from", "How it runs"
PARTS = "What the algorithm's name sets"
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
    help=f"One of {ALGORITHMS} (after the description).",
)
@option(
    "--preset",
    default="default",
    show_default=True,
    metavar="NAME",
    section=WHAT,
    help="default; paper: exactly as published; released: as in the authors' code.",
)
@option("--max-depth", default=4, show_default=True, section=WHAT, help="Splits on the longest path.")
@option(
    "--max-leaves",
    type=int,
    default=None,
    section=WHAT,
    help="Leaves of each tree, grown best first; not where members vote.",
)
@option(
    "--share",
    default=None,
    metavar="WHO",
    section=WHAT,
    help="team: one tree for all agents of a team, whose spaces must be equal.",
)
@option("--agent", default=None, metavar="NAME", section=WHAT, help="The agent to extract, for viper.")
@option("--splits", default=None, metavar="NAME", section=WHAT, help="exact or histogram (default: the preset's).")
@option(
    "--rollouts-by",
    default=None,
    metavar="NAME",
    section=PARTS,
    help="Whose trees play together among experts: agent, team or all; or experts alone.",
)
@option(
    "--weights",
    default=None,
    metavar="NAME",
    section=PARTS,
    help="What states weigh: own, averaged (over what others could do) or equal.",
)
@option(
    "--least-right",
    default=None,
    metavar="VOTES",
    section=PARTS,
    help="Members that must be predicted right, of a team of N: N, N-1, 2, or a share such as 0.5; 0: no votes.",
)
@option(
    "--selection-by",
    default=None,
    metavar="NAME",
    section=PARTS,
    help="For whom one round is chosen: agent, team or all.",
)
@option("--features", default="", metavar="NAMES", section=WHAT, help=f"Additional features: {FEATURES}, or auto.")
@option(
    "--features-file",
    type=PATH,
    default=None,
    section=WHAT,
    help="Names and units of what agents observe in your own game (TOML).",
)
@option(
    "--max-episodes",
    type=int,
    default=None,
    section=EPISODES,
    help="Total number of episodes; replaces the counts below.",
)
@option(
    "--iterations",
    type=int,
    default=None,
    section=EPISODES,
    help="Rounds of rollouts and tree growth (default: the paper's).",
)
@option("--rollouts", type=int, default=None, section=EPISODES, help="Episodes per round (default: the paper's).")
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
    help="Episodes per candidate and team (default: 100).",
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
    help="The Q that weights the states: learned, measured or none.",
)
@option("--world", default=None, section=LEARNS, help="The expert's world, where its file cannot say it.")
@option(
    "--counterexamples",
    multiple=True,
    type=PATH,
    metavar="PATH",
    section=LEARNS,
    help="A file that `maviper verify -o` wrote, or its folder (repeatable).",
)
@option("--seed", default=0, show_default=True, section=HOW, help="The random seed.")
@option("--seeds", default=1, show_default=True, section=HOW, help="Extract this many seeds; keep the best.")
@option(
    "--jobs",
    default=1,
    show_default=True,
    section=HOW,
    help="Parallel processes, for seeds, IVIPER's agents or refinement.",
)
@option("--resume", is_flag=True, section=HOW, help="Continue the run in the folder.")
@output("The profile's JSON file, or a run folder.")
@click.pass_context
def extract(context: click.Context, expert: str, output: Path, **options: Any) -> int:
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
