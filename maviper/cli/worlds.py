"""The commands worlds list, worlds show, worlds new and worlds check.

Does: prints what worlds there are, what is in one, and whether one can be used; writes a world file to start from.
Assumes: `maviper.worlds` knows the worlds.
Does not: play.
"""

from pathlib import Path

import click

from codegen.errors import ExitCode
from codegen.wording import format_count
from maviper.cli.group import Verb, Verbs
from maviper.cli.options import PATH, console_of, option


@click.group(cls=Verbs, example="maviper worlds list")
def worlds() -> None:
    """List the games, show one, or state and check one of your own."""


@worlds.command("list", cls=Verb, example="maviper worlds list")
def worlds_list() -> int:
    """List the worlds, their options and their shipped experts.

    Options are shown with their defaults. EXPERT@SEED is the expert of one training seed.
    """
    from maviper.experts.store import SHIPPED
    from maviper.worlds import WORLDS, find, options_of

    for name in WORLDS:
        agents = ", ".join(f"{team} ({len(members)})" for team, members in find(name).teams.items())
        click.echo(f"{name}  {agents}")
        click.echo(f"  options: {', '.join(f'{key}={value}' for key, value in options_of(name).items())}")
        experts = ", ".join(expert for expert in SHIPPED if expert.startswith(name))
        click.echo(f"  experts: {experts or f'{name}@scripted'}")
    return ExitCode.DONE


@worlds.command("show", cls=Verb, example="maviper worlds show physical-deception,defenders=3")
@click.argument("world")
@option("--features-file", type=PATH, default=None, help="Names and units of what agents observe (TOML).")
def worlds_show(world: str, features_file: Path | None) -> int:
    """Print the agents of WORLD, their features and actions.

    Each feature is shown with its unit, range and meaning.
    """
    from codegen.ir import FORK, PHYSICS
    from maviper.worlds import find
    from maviper.worlds.games.particle import FORK_MOTION
    from maviper.worlds.naming import with_names

    game = find(world, giving=True)
    game = game if features_file is None else with_names(game, features_file)
    pace = f" of {game.spec.dt} s" if game.spec.dt else ""
    click.echo(f"{game.name}, after {game.spec.reference}, {format_count(game.spec.episode_steps, 'step')}{pace}")
    if game.spec.options.get(PHYSICS) == FORK:
        click.echo(f"{PHYSICS}={FORK}: {FORK_MOTION}; the verifier covers mpe2's motion only")
    everything = zip(game.agents, game.features, game.actions, game.given, strict=True)
    for agent, features, actions, outputs in everything:
        click.echo(f"\n{agent}, team {game.team_of(agent)}")
        for feature in features:
            meaning = feature.meaning or "no meaning"
            click.echo(f"  {feature.name:<16} {feature.unit} [{feature.low:g}, {feature.high:g}]  {meaning}")
        for output in outputs:
            click.echo(f"  gives {output.name:<10} {output.unit} [{output.low:g}, {output.high:g}]")
        if actions:
            click.echo(f"  actions: {', '.join(action.name for action in actions)}")
    return ExitCode.DONE


@worlds.command("new", cls=Verb, example="maviper worlds new cart.toml")
@click.argument("file", type=PATH)
@option("--flow", is_flag=True, help="In continuous time: derivatives, and samples at a period.")
def worlds_new(file: Path, flow: bool) -> int:
    """Write a world file to start from, for you to edit.

    FILE states a system of your own: its variables with units and ranges, what agents observe and do, where episodes
    start, and how the state moves. It explains itself in comments.
    """
    from maviper.worlds.checking import new

    new(file, flow)
    click.echo(f"written; maviper worlds check {file}")
    return ExitCode.DONE


@worlds.command("check", cls=Verb, example="maviper worlds check mygame:make,n=2")
@click.argument("world")
@option("--run-reference", is_flag=True, help="Also run user code (an environment) that a world file names.")
@click.pass_context
def worlds_check(context: click.Context, world: str, run_reference: bool) -> int:
    """Report what WORLD provides, what is missing and what is wrong.

    Prints one line per finding. Exits with 2 if the world cannot be used.

    WORLD is a name from `maviper worlds list`, gymnasium:ID for a single-agent environment of Gymnasium, vmas:SCENARIO,
    module:function for your own PettingZoo environment, or a world file (TOML). Options follow after commas:
    module:function,n=3,max_steps=50.

    If a world file names a reference, 100,000 steps of that environment are compared with what the file states. A
    step that is off by more than the stated error is a fault.
    """
    console = console_of(context)
    console.line("checking", world)
    from maviper.worlds.checking import check, usable
    from verify.progress import listening

    with console.following("checking") as listener, listening(listener):
        findings = check(world, run_reference, lambda finding: click.echo(str(finding)))
    return ExitCode.DONE if usable(findings) else ExitCode.INPUT
