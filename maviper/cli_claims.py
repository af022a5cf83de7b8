"""The commands about claims: verify, repair, properties, check, replay.

Does: parse, call, print.
Assumes: cli.py adds them to the group.
Does not: import anything heavy before a command needs it.
"""

from fractions import Fraction
from pathlib import Path
from typing import Any

import click

from codegen.errors import ExitCode
from maviper.cli_parts import OUTPUT, console_of


def _fraction(_context: click.Context, parameter: click.Parameter, value: str | None) -> Fraction | None:
    from verify.spec import exact

    return None if value is None else exact(value, f"--{parameter.name}")


def _names(_context: click.Context, _parameter: click.Parameter, value: str | None) -> tuple[str, ...] | None:
    return None if value is None else tuple(name.strip() for name in value.split(","))


def _list_properties(context: click.Context, _parameter: click.Parameter, asked: bool) -> None:
    if asked and not context.resilient_parsing:
        from maviper.verification import list_properties

        list_properties(as_json=False)
        context.exit(ExitCode.DONE)


@click.command()
@click.argument("profile", type=click.Path(path_type=Path))
@click.option("--property", "names", multiple=True, help="Built-in property (repeatable; default: distinct_targets).")
@click.option("--properties", type=click.Path(path_type=Path), default=None, help="A property file (TOML).")
@click.option(
    "--list", is_flag=True, is_eager=True, expose_value=False, callback=_list_properties, help="List the properties."
)
@click.option("--region", default="start", show_default=True, help="`start` (the start box) or a region file (TOML).")
@click.option(
    "--team", default=None, help="The team that the claim is about (default: the one with an agent a landmark)."
)
@click.option("--margin", callback=_fraction, help="An agent closes when it is ahead by more (default: 0).")
@click.option(
    "--radius",
    callback=_fraction,
    help="An agent is at a landmark within it (default: 1/10; of reaches and covers 2/5). Of keeps_apart: the least "
    "distance (default: at which they touch).",
)
@click.option("--kappa", callback=_fraction, help="Of aligned: ahead by kappa times what is sideways (default: 1/2).")
@click.option(
    "--landmarks",
    callback=_names,
    metavar="A,B",
    help="Of own_target, reaches, covers: one for each agent of the team.",
)
@click.option("--others", callback=_names, metavar="A,B", help="Of keeps_apart: from whom (default: from one another).")
@click.option("--steps", default=None, type=int, help="Of reaches, covers, keeps_apart (default: the world's episode).")
@click.option(
    "--zones",
    default=None,
    type=int,
    help="That claims about episodes may visit (default: 5000000); more also allow larger certificates.",
)
@click.option("--eps", callback=_fraction, help="Of steady: by how much a feature may be off (default: 1/100).")
@click.option("--of", default=None, metavar="NAME", help="Of steady: the property that stays true.")
@click.option(
    "--semantics", default="machine", show_default=True, help="machine: as deployed; real: exact, for comparison."
)
@click.option("--where", is_flag=True, help="Say where claims about single decisions hold and fail (see below).")
@click.option("--where-zones", default=None, type=int, help="Of --where: violating zones to look for (default: 50000).")
@click.option("--smt", type=click.Path(path_type=Path), default=None, help="Folder for the questions as SMT-LIB.")
@click.option("--budget", default=None, type=int, help="Solver resource units a query.")
@click.option("--json", "as_json", is_flag=True, help="Print the report as JSON.")
@click.option(
    "-o", "--output", type=click.Path(path_type=Path), default=None, help="Folder for the report and the certificates."
)
@click.pass_context
def verify(context: click.Context, profile: Path, **options: Any) -> int:
    """Decide claims about PROFILE over all world states of a region, for the deployed arithmetic.

    `maviper properties list` names the built-in properties, `maviper properties new WORLD` writes a property file to
    start from, for claims of your own.

    reaches, covers and keeps_apart are about whole episodes that start in the region, at rest: each agent comes to its
    own landmark at some step; the team is matched to the landmarks after the last one; nobody of the team comes too
    near to the others. Where entities may touch, pushes are over-approximated, so proofs need starts that are apart.

    --where finds all zones (leaves of the agents and bounds on positions) in which a violated claim fails, their exact
    share of the region, and the largest region found in which the claim is proved and something could go wrong; with -o
    also as files, of which the region is one for --region.

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

    return verify_command(profile, options, console_of(context))


@click.command()
@click.argument("profile", type=click.Path(path_type=Path))
@click.option("--property", "name", default="distinct_targets", show_default=True, help="Or own_target.")
@click.option("--team", default=None, help="The team to repair (default: the one with an agent a landmark).")
@click.option("--region", default="start", show_default=True, help="`start` (the start box) or a region file (TOML).")
@click.option("--margin", callback=_fraction, help="An agent closes when it is ahead by more (default: 0).")
@click.option("--radius", callback=_fraction, help="An agent is at a landmark within it (default: 1/10).")
@click.option("--landmarks", callback=_names, metavar="A,B", help="Of own_target: one for each agent of the team.")
@click.option("--max-depth", type=int, default=None, help="Prefer repairs within so many splits (default: any).")
@click.option("--episodes", default=1_000, show_default=True, help="Held-out episodes, before and after.")
@OUTPUT
@click.pass_context
def repair(context: click.Context, profile: Path, **options: Any) -> int:
    """Make a property of PROFILE true in a region: guard the leaves that violate it until both engines prove it.

    Each agent of the team gets a landmark of its own. A leaf that a counterexample ends in becomes a small tree, with
    tests on the agent's offset to its landmark, that keeps the agent closing on it or at it; all other leaves decide
    as before. Says how many actions change, and what the team reaches before and after in the same episodes. Writes
    the repaired profile, its certificate, the report and the costs (repair.json).

    \b
    Exits with 0 when the property is proved within --max-depth, with 1 when the
    trees are deeper, with 3 when no repair was found (then nothing is written).
    """
    from maviper.repairing import repair_command

    return repair_command(profile, options, console_of(context))


@click.group()
def properties() -> None:
    """What can be claimed: built-in properties, and files for claims of your own."""


@properties.command("list")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def properties_list(as_json: bool) -> int:
    """The built-in properties: what each claims, and its parameters with their defaults."""
    from maviper.verification import list_properties

    return list_properties(as_json)


@properties.command("new")
@click.argument("world")
@click.option("-o", "--output", type=click.Path(path_type=Path), default=None, help="The file (default: print it).")
def properties_new(world: str, output: Path | None) -> int:
    """A commented property file for WORLD, with its agents, landmarks and actions."""
    from maviper import runs
    from maviper.questions import starter

    text = starter(world)
    if output is None:
        click.echo(text, nl=False)
    else:
        runs.write(output, text)
    return ExitCode.DONE


@click.command()
@click.argument("certificate", type=click.Path(path_type=Path))
@click.option(
    "--profile",
    type=click.Path(path_type=Path),
    default=None,
    help="The policy that it is about (default: profile.json beside it).",
)
def check(certificate: Path, profile: Path | None) -> int:
    """Check CERTIFICATE, which `maviper verify -o` wrote: does it prove its property of its policy in its region?

    \b
    Exits with 0 when the proof holds, with 1 when it does not, with 2 when the
    file cannot be read or is about another policy. The checker closes every
    branch of the proof anew with exact numbers, from the profile, the region and
    the property; only the arithmetic of thresholds is shared with the engine.
    A proof about episodes holds from rest, for agents that follow their trees and
    whatever all others do.
    """
    from maviper.certifying import check_command

    return check_command(certificate, profile)


@click.command()
@click.argument("counterexample", type=click.Path(path_type=Path))
@click.option(
    "--profile", type=click.Path(path_type=Path), default=None, help="The policy (default: profile.json beside it)."
)
@click.pass_context
def replay(context: click.Context, counterexample: Path, profile: Path | None) -> int:
    """Replay COUNTEREXAMPLE, which `maviper verify -o` wrote: by the reference, the compiled C and the environment.

    A counterexample about whole episodes is played again from its start.

    Exits with 1 when the claim fails in its world state or episode, with 0 when it holds, as it should for a mended
    policy.
    """
    from maviper.replaying import replay_command

    return replay_command(counterexample, profile, console_of(context))


COMMANDS = (verify, repair, properties, check, replay)
