"""The commands properties list and properties new.

Does: prints the built-in properties; writes a property file to start from.
Assumes: `maviper.verification` knows both.
Does not: verify.
"""

from pathlib import Path

import click

from codegen.errors import ExitCode, InputError
from maviper.cli.group import Verb, Verbs
from maviper.cli.options import PATH, option

MAX_STARTER_BYTES = 2**24


@click.group(cls=Verbs, example="maviper properties list")
def properties() -> None:
    """List the built-in properties, or write a starter property file."""


@properties.command("list", cls=Verb, example="maviper properties list")
@option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def properties_list(as_json: bool) -> int:
    """List the built-in properties.

    For each property: what it claims, and its parameters with their defaults.
    """
    return print_properties(as_json)


@properties.command("new", cls=Verb, example="maviper properties new physical-deception -o claims.toml")
@click.argument("subject", metavar="WORLD|PROFILE")
@option("-o", "--output", type=PATH, default=None, help="The file (default: print it).")
def properties_new(subject: str, output: Path | None) -> int:
    """Write claims to start from, for WORLD or a profile's .json file.

    The file names agents, actions, and landmarks or features, and explains itself in comments.
    """
    from maviper.files import runs
    from maviper.verification.starters import starter

    if output is not None:
        runs.target(output, "claims.toml")
    text = starter(subject)
    if output is None:
        click.echo(text, nl=False)
    elif not runs.create(output, text) and runs.read(output, MAX_STARTER_BYTES) != text.encode():
        raise InputError("the file exists, with other content", str(output), "choose another name with -o")
    return ExitCode.DONE


def print_properties(as_json: bool) -> int:
    """Prints the built-in properties, for people or as JSON."""
    from codegen.policy_json import layout
    from maviper.verification.ask import option_of
    from maviper.verification.starters import list_properties

    if as_json:
        click.echo(layout({"properties": list_properties()}))
        return ExitCode.DONE
    for entry in list_properties():
        click.echo(f"{entry['name']}: {entry['sentence']}")
        for name, default in entry["parameters"].items():
            click.echo(f"  {option_of(name)} (default: {default or _of_the_world(entry['name'], name)})")
    return ExitCode.DONE


def _of_the_world(claim: str, parameter: str) -> str:
    """A default that depends on the world, in words."""
    usual = {"steps": "the world's episode", "radius": "the distance at which they touch", "others": "one another"}
    usual |= dict.fromkeys(("agents", "agent", "feature"), "none, state it") | {
        "order": "the profile's order",
        "features": "all of them",
    }
    if parameter in usual:
        return usual[parameter]
    return "any matching" if claim == "covers" else "the order of the world"
