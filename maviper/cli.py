"""The command line: parse, call, print.

Does: one function a verb (those about claims are in cli_claims.py); turns errors into three lines and an exit code.
Assumes: every verb is also a Python function elsewhere.
Does not: import anything heavy before a verb needs it.
"""

from pathlib import Path
from typing import Any

import click

from codegen.errors import ExitCode, suggestion
from maviper import cli_claims, exits
from maviper.cli_parts import OUTPUT, console_of

# named here again, so that --help imports nothing; a test compares them with the ones that there are
ALGORITHMS = "maviper, maviper-no-prediction, maviper-iviper-resampling, iviper, viper, imitation, fitted-q"
FEATURES = "velocity, goal, differences, signs (several with +)"
EXIT_CODES = """\b
Exit codes:
  0   done, and everything asked was proved
  1   a property is violated, or a threshold was missed
  2   usage, configuration or input error
  3   inconclusive: VACUOUS, UNKNOWN or SKIPPED
  4   generated code disagrees with the profile
  5   something outside is missing (an optional package)
  70  a bug in maviper
  130 interrupted
When several apply, 70 > 4 > 1 > 3. Only `demo` expects a violation: it exits
with 0 when every step gave the expected outcome."""


class Verbs(click.Group):
    """A group that suggests the closest verb."""

    def resolve_command(self, ctx: click.Context, args: list[str]) -> Any:
        """As click's, with a suggestion."""
        if args and self.get_command(ctx, args[0]) is None and not args[0].startswith("-"):
            ctx.fail(f"unknown command '{args[0]}'; {suggestion(args[0], self.list_commands(ctx))}")
        return super().resolve_command(ctx, args)


@click.group(cls=Verbs, epilog=EXIT_CODES, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="maviper")
@click.option("-q", "--quiet", is_flag=True, help="Print results and errors only.")
@click.option("-v", "--verbose", is_flag=True, help="Show the traceback of an error.")
@click.pass_context
def cli(context: click.Context, quiet: bool, verbose: bool) -> None:
    """Neural multi-agent policies as small decision trees: extracted jointly, compiled exactly, proved."""
    context.obj = {"quiet": quiet, "verbose": verbose}


@cli.command()
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    default=Path("demo"),
    show_default=True,
    help="Folder for results.",
)
@click.option("--seed", default=None, type=int, help="Seed of the extraction.")
@click.pass_context
def demo(context: click.Context, output: Path, seed: int | None) -> int:
    """The whole chain in about a minute, on a shipped expert: extract, compile, check, verify, report."""
    console = console_of(context)
    console.line("maviper", "physical deception, from a neural expert to verified C")
    from maviper.demo import run

    return run(output, console, seed)


@cli.group()
def worlds() -> None:
    """The games: their agents, teams, features and actions."""


@worlds.command("list")
def worlds_list() -> int:
    """The worlds, their options with defaults, and their shipped experts (EXPERT@SEED is one trained seed)."""
    from maviper.experts.store import SHIPPED
    from maviper.worlds import WORLDS, find, options_of

    for name in WORLDS:
        agents = ", ".join(f"{team} ({len(members)})" for team, members in find(name).teams.items())
        click.echo(f"{name}  {agents}")
        click.echo(f"  options: {', '.join(f'{key}={value}' for key, value in options_of(name).items())}")
        click.echo(f"  experts: {', '.join(expert for expert in SHIPPED if expert.startswith(name))}")
    return ExitCode.DONE


@worlds.command("show")
@click.argument("world")
def worlds_show(world: str) -> int:
    """Agents, features with unit, range and meaning, and actions of WORLD."""
    from maviper.worlds import find

    found = find(world)
    pace = f" of {found.spec.dt} s" if found.spec.dt else ""
    click.echo(f"{found.name}, after {found.spec.reference}, {found.spec.episode_steps} steps{pace}")
    for agent, features, actions in zip(found.agents, found.features, found.actions, strict=True):
        click.echo(f"\n{agent}, team {found.team_of(agent)}")
        for feature in features:
            meaning = feature.meaning or "no meaning"
            click.echo(f"  {feature.name:<16} {feature.unit} [{feature.low:g}, {feature.high:g}]  {meaning}")
        click.echo(f"  actions: {', '.join(action.name for action in actions)}")
    return ExitCode.DONE


@worlds.command("check")
@click.argument("world")
def worlds_check(world: str) -> int:
    """What WORLD has, lacks or has wrong, one line each; 2 when it cannot be used.

    WORLD is a name from `maviper worlds list`, or module:function for a PettingZoo parallel environment of your own,
    with options after commas: module:function,n=3,max_steps=50.
    """
    from maviper.worlds.checking import check, usable

    findings = check(world)
    for finding in findings:
        click.echo(str(finding))
    return ExitCode.DONE if usable(findings) else ExitCode.INPUT


@cli.command()
@click.argument("world")
@click.option("--algorithm", default="", help="mappo, maddpg or vdn (default: the recipe's).")
@click.option("--recipe", default="default", show_default=True, help="default, or paper: MADDPG as released.")
@click.option("--seed", default=0, show_default=True, help="Seed of everything random.")
@click.option("--seeds", default=1, show_default=True, help="Train so many seeds, from --seed on; keep the best.")
@click.option("--steps", default=None, type=int, help="Joint environment steps (default: the recipe's).")
@click.option("--set", "settings", multiple=True, metavar="NAME=VALUE", help="Another setting of the algorithm.")
@click.option("--device", default="cpu", show_default=True, help="Any device that torch has.")
@click.option("--jobs", default=1, show_default=True, help="Seeds trained at the same time.")
@click.option("--resume", is_flag=True, help="Go on with the run in the folder.")
@OUTPUT
@click.pass_context
def train(context: click.Context, world: str, output: Path, **options: Any) -> int:
    """Train an expert for WORLD into a run folder (needs the extra maviper[train]).

    WORLD is a game, with options after commas (predator-prey,prey=1), or module:function for an environment of yours.
    The folder holds the best checkpoint so far at all times; an interrupted run goes on with --resume and ends with
    the same expert.
    """
    from maviper.training import train_command

    return train_command(world, output, options, console_of(context))


@cli.command()
@click.argument("expert")
@click.option("--algorithm", default="maviper", show_default=True, metavar="NAME", help=f"One of {ALGORITHMS}.")
@click.option("--preset", default="default", show_default=True, help="default; paper, to the letter; or released code.")
@click.option("--max-depth", default=4, show_default=True, help="Splits on the longest path.")
@click.option("--iterations", type=int, default=None, help="Rounds of rollouts and growth (default: the paper's).")
@click.option("--rollouts", type=int, default=None, help="Episodes a round (default: the paper's).")
@click.option("--selection-episodes", type=int, default=None, help="Episodes an iterate and team (default: 100).")
@click.option("--selection", default=None, help="uniform, return or race (default: the preset's).")
@click.option("--refinement", type=int, default=None, help="Episodes a team to refine by (default: the preset's).")
@click.option("--budget", type=int, default=None, help="Episodes in all, instead of the counts above.")
@click.option("--patience", type=int, default=None, help="Stop after so many rounds without a gain (default: 10).")
@click.option("--splits", default=None, help="exact or histogram (default: the preset's).")
@click.option("--agent", default=None, help="VIPER's one agent.")
@click.option("--seed", default=0, show_default=True, help="Seed of everything random.")
@click.option("--seeds", default=1, show_default=True, help="So many seeds, from --seed on; the best is kept.")
@click.option("--jobs", default=1, show_default=True, help="Seeds, IVIPER's agents or teams to refine at a time.")
@click.option("--critic", default="learned", show_default=True, help="Whose Q weighs states; also measured, none.")
@click.option("--features", default="", metavar="NAMES", help=f"Further features: {FEATURES}, or auto.")
@click.option("--world", default=None, help="module:function of the environment that the expert plays, if it is yours.")
@click.option(
    "--counterexamples",
    multiple=True,
    type=click.Path(path_type=Path),
    metavar="PATH",
    help="A file of `maviper verify -o`, or its folder, to learn from (repeatable).",
)
@click.option("--resume", is_flag=True, help="Go on with the run in the folder.")
@OUTPUT
@click.pass_context
def extract(context: click.Context, expert: str, output: Path, **options: Any) -> int:
    """Extract a policy profile from EXPERT: a world's name, an expert file or a run folder.

    A world's name means its shipped expert, or its scripted one where no network is shipped
    (cooperative-navigation,agents=12); module:function calls yours. -o names the profile's JSON file, or a folder for
    the whole run: config, metrics, finished steps, profile. An interrupted run in a folder goes on with --resume and
    ends with the same profile.

    With --counterexamples every round also learns from world states in which a team failed a claim: in each, what the
    expert does there, changed for as few agents as the claim needs. The command then says, and writes into refit.json
    beside the profile, how often the claim fails before and after, which actions changed, and what play costs.
    """
    from maviper.extraction import extract_command

    said = [
        f"--{name.replace('_', '-')} {value}"
        for name, values in sorted(options.items())
        if _said(context, name)
        for value in (values if isinstance(values, tuple) else (values,))
    ]
    command = " ".join(["maviper extract", expert, *(text for text in said if not text.startswith("--resume"))])
    extract_command(expert, output, {**options, "command": command}, console_of(context))
    return ExitCode.DONE


def _said(context: click.Context, name: str) -> bool:
    """Whether a user gave an option."""
    return context.get_parameter_source(name) is click.core.ParameterSource.COMMANDLINE


@cli.command()
@click.argument("subject")
@click.option("--with", "replaced", multiple=True, metavar="NAME=SUBJECT", help="Another SUBJECT for an agent or team.")
@click.option("--against", multiple=True, metavar="OPPONENT", help="Another SUBJECT, scripted or random (repeatable).")
@click.option(
    "--expert", default=None, help="What ratios and agreement refer to (default: a profile's own, if shipped)."
)
@click.option("--team", default=None, help="Measure one team only.")
@click.option("--episodes", default=1_000, show_default=True, help="Held-out episodes, at most 100,000.")
@click.option("--world", default=None, help="module:function of the environment, if it is yours.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
@click.pass_context
def evaluate(context: click.Context, subject: str, **options: Any) -> int:
    """Measure SUBJECT in play: a profile (FILE.json), or an expert as `maviper extract` reads it, or a mix.

    Each team plays against the opponents, beside the expert in the same place in the same episodes: measures, returns
    and ratios (joint: the whole team is SUBJECT; individual: one agent among experts), all with intervals; the trees'
    size, comparisons and agreement with the expert. Opponents are the expert by default, or SUBJECT where there is
    none. FILE.json is always a profile; what else is named is an expert.
    """
    console = console_of(context)
    console.line("evaluating", subject)
    from maviper.evaluation import evaluate_command

    return evaluate_command(subject, options, console)


@cli.command()
def schema() -> int:
    """Print the JSON schema of policy profiles."""
    from codegen.policy_json import layout
    from codegen.schema import schema as profile_schema

    click.echo(layout(profile_schema()))
    return ExitCode.DONE


@cli.command()
@click.argument("profile", type=click.Path(path_type=Path))
@click.option("--agent", default=None, help="One agent only.")
def show(profile: Path, agent: str | None) -> int:
    """Print the policies of PROFILE as rules, one line a leaf."""
    from codegen.errors import UnknownNameError
    from maviper import load
    from maviper.show import rules

    loaded = load(profile)
    names = [policy.agent for policy in loaded.agents]
    if agent is not None and agent not in names:
        raise UnknownNameError("agent", agent, names, "--agent")
    for policy in loaded.agents:
        if agent in (None, policy.agent):
            click.echo(f"{policy.agent}, team {policy.team}")
            for rule in rules(policy):
                click.echo(f"  {rule}")
    return ExitCode.DONE


@cli.command("compile")
@click.argument("profile", type=click.Path(path_type=Path))
@click.option(
    "--target", default="c,python,json", show_default=True, help="Some of c,python,json,javascript,rust,smt,svg,onnx."
)
@click.option("--prefix", default=None, help="Start of every public name (default: the world's name).")
@click.option("--style", default="auto", show_default=True, help="How C decides: nested, ordered, walk or auto.")
@click.option("--test-vectors", is_flag=True, help="Also write observations with answers, and a short test of them.")
@click.option("--prove", is_flag=True, help="Also prove C and Python equal to the trees for all observations, by Z3.")
@click.option("--budget", default=None, type=int, help="Solver resource units a proof.")
@click.option("--pass", "names", default="", help="Passes over the trees first: some of drop,merge,reorder.")
@click.option("--region", default=None, help="For the pass drop: `start` or a region file.")
@OUTPUT
@click.pass_context
def compile_command(
    context: click.Context,
    profile: Path,
    target: str,
    prefix: str | None,
    style: str,
    test_vectors: bool,
    prove: bool,
    budget: int | None,
    names: str,
    region: str | None,
    output: Path,
) -> int:
    """Compile PROFILE to code in a folder, after proving by replay that code, profile and learned tree decide alike.

    With --prove, a solver is asked for an observation (any float32 numbers for C, any doubles for Python) for which
    ..._act of the text and the tree act differently; the questions, in SMT-LIB, and the answers are written beside
    the code.

    \b
    Passes, each proved, leave trees that decide the same with less (after drop:
    the same within the region):
      merge     splits whose sides decide alike, tests that those before them decide
      reorder   the order of tests, for fewer on average over on-policy states
      drop      leaves that no world state of --region reaches; the region becomes part of the code's contract
    """
    from maviper.compilation import compile_to_folder

    targets = [name.strip() for name in target.split(",")]
    passes = [name.strip() for name in names.split(",") if name.strip()]
    console = console_of(context)
    return compile_to_folder(
        profile, targets, prefix, style, test_vectors, output, console, prove, budget, passes, region
    )


for command in cli_claims.COMMANDS:
    cli.add_command(command)


def run(arguments: list[str]) -> int:
    """Runs the command line inside a program; returns the exit code."""
    verbose = bool({"-v", "--verbose"} & set(arguments))
    return exits.answered(lambda: cli.main(args=arguments, prog_name="maviper", standalone_mode=False), verbose)
