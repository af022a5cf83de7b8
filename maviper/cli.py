"""The command line: parse, call, print.

Does: one function a verb; turns errors into three lines and an exit code.
Assumes: every verb is also a Python function elsewhere.
Does not: import anything heavy before a verb needs it.
"""

from fractions import Fraction
from pathlib import Path
from typing import Any

import click

from codegen.errors import ExitCode, suggestion
from maviper import exits

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


def _console(context: click.Context) -> Any:
    from maviper.console import Console

    return Console(context.obj["quiet"])


OUTPUT = click.option("-o", "--output", type=click.Path(path_type=Path), required=True, help="Where results go.")


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
    console = _console(context)
    console.line("maviper", "physical deception, from a neural expert to verified C")
    from maviper.demo import run

    return run(output, console, seed)


@cli.group()
def worlds() -> None:
    """The games: their agents, teams, features and actions."""


@worlds.command("list")
def worlds_list() -> int:
    """Names of the worlds and of their shipped experts."""
    from maviper.experts.store import SHIPPED
    from maviper.worlds import WORLDS, find

    for name in WORLDS:
        agents = ", ".join(f"{team} ({len(members)})" for team, members in find(name).teams.items())
        click.echo(f"{name}  {agents}{'  expert shipped' if name in SHIPPED else ''}")
    return ExitCode.DONE


@worlds.command("show")
@click.argument("world")
def worlds_show(world: str) -> int:
    """Agents, features with unit, range and meaning, and actions of WORLD."""
    from maviper.worlds import find

    found = find(world)
    click.echo(f"{found.name}, after {found.spec.reference}, {found.spec.episode_steps} steps of {found.spec.dt} s")
    for agent, features, actions in zip(found.agents, found.features, found.actions, strict=True):
        click.echo(f"\n{agent}, team {found.team_of(agent)}")
        for feature in features:
            click.echo(f"  {feature.name:<16} {feature.unit} [{feature.low:g}, {feature.high:g}]  {feature.meaning}")
        click.echo(f"  actions: {', '.join(action.name for action in actions)}")
    return ExitCode.DONE


@cli.command()
@click.argument("world")
@click.option("--seed", default=0, show_default=True, help="Seed of everything random.")
@click.option(
    "--steps", default=None, type=int, help="Joint environment steps (default: 6,000,000, as for the shipped expert)."
)
@OUTPUT
@click.pass_context
def train(context: click.Context, world: str, seed: int, steps: int | None, output: Path) -> int:
    """Train an expert for WORLD into a run folder (needs the extra maviper[train]).

    The folder holds the best checkpoint so far at all times, so an interrupted run still has a valid expert.
    """
    from maviper.experts import train as training
    from maviper.worlds import find

    console = _console(context)
    found = find(world)
    overrides = {"seed": seed} | ({} if steps is None else {"steps": steps})
    console.line("training", f"{found.name}, MADDPG, seed {seed}")
    lines: dict[str, Any] = {}
    with console.live("steps", 1) as live:

        def show(checkpoint: training.Checkpoint, total: int) -> None:
            if not lines or checkpoint.score > lines["best"].score:
                lines["best"] = checkpoint
            live.total = total
            live.update(checkpoint.steps, "best " + _shares(lines["best"].success))

        card = training.train(found, output, overrides, show)
    for name, value in card["measured"].items():
        if isinstance(value, list):
            console.line("measured", f"{name}: {value[0]:.3f} [{value[1]:.3f}, {value[2]:.3f}]")
    console.line("wrote", str(output / training.EXPERT_FILE))
    return ExitCode.DONE


def _shares(success: dict[str, Any]) -> str:
    from maviper.evaluate.metrics import shown

    return ", ".join(f"{team} {shown(won)}" for team, won in success.items())


@cli.command()
@click.argument("expert")
@click.option("--algorithm", default="maviper", show_default=True, help="How trees are grown (maviper).")
@click.option("--preset", default="paper", show_default=True, help="Whose reading of the algorithm (paper).")
@click.option("--max-depth", default=4, show_default=True, help="Splits on the longest path.")
@click.option("--iterations", default=100, show_default=True, help="Rounds of rollouts and joint growth.")
@click.option("--rollouts", default=50, show_default=True, help="Episodes a round.")
@click.option("--selection-episodes", default=100, show_default=True, help="Episodes to score each iterate.")
@click.option("--seed", default=0, show_default=True, help="Seed of everything random.")
@OUTPUT
@click.pass_context
def extract(context: click.Context, expert: str, algorithm: str, output: Path, **settings: Any) -> int:
    """Extract a policy profile from EXPERT: a world's name for its shipped expert, or an expert file or run folder.

    -o names the profile's JSON file.
    """
    from codegen.errors import UnknownNameError
    from maviper.extraction import extract_to_file

    if algorithm != "maviper":
        raise UnknownNameError("algorithm", algorithm, ["maviper"], "--algorithm")
    extract_to_file(expert, settings, output, _console(context))
    return ExitCode.DONE


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
@click.option("--target", default="c,python,json", show_default=True, help="Languages, with commas between them.")
@click.option("--prefix", default=None, help="Start of every public name (default: the world's name).")
@OUTPUT
@click.pass_context
def compile_command(context: click.Context, profile: Path, target: str, prefix: str | None, output: Path) -> int:
    """Compile PROFILE to code in a folder, after proving by replay that code, profile and learned tree decide alike."""
    from maviper.compilation import compile_to_folder

    return compile_to_folder(profile, [name.strip() for name in target.split(",")], prefix, output, _console(context))


def _fraction(_context: click.Context, parameter: click.Parameter, value: str) -> Fraction:
    from verify.spec import exact

    return exact(value, f"--{parameter.name}")


@cli.command()
@click.argument("profile", type=click.Path(path_type=Path))
@click.option(
    "--property", "names", multiple=True, default=("distinct_targets",), show_default=True, help="Built-in property."
)
@click.option("--region", default="start", show_default=True, help="`start` (the start box) or a region file (TOML).")
@click.option(
    "--team", default=None, help="The team that the claim is about (default: the one with an agent a landmark)."
)
@click.option(
    "--margin", default="0", show_default=True, callback=_fraction, help="An agent closes when it is ahead by more."
)
@click.option(
    "--radius", default="1/10", show_default=True, callback=_fraction, help="An agent is at a landmark within it."
)
@click.option("--budget", default=None, type=int, help="Solver resource units a query.")
@click.option("--json", "as_json", is_flag=True, help="Print the report as JSON.")
@click.option(
    "-o", "--output", type=click.Path(path_type=Path), default=None, help="Folder for report.html, .json and .txt."
)
@click.pass_context
def verify(context: click.Context, profile: Path, **options: Any) -> int:
    """Decide claims about PROFILE over all world states of a region, for the deployed arithmetic.

    \b
    A region file states exact bounds; positions it leaves out have the start box's:
      goals = ["landmark_0"]
      default = [-1, 1]
      [box]
      "agent_0.x" = [-0.5, 0.25]
      [difference]
      "agent_0.x - agent_1.x" = [0, 1]
      [apart]
      "landmark_0 - landmark_1" = 0.2
    """
    from maviper.verification import verify_command

    return verify_command(profile, options, _console(context))


def run(arguments: list[str]) -> int:
    """Runs the command line inside a program; returns the exit code."""
    verbose = bool({"-v", "--verbose"} & set(arguments))
    return exits.answered(lambda: cli.main(args=arguments, prog_name="maviper", standalone_mode=False), verbose)
