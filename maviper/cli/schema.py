"""The command schema.

Does: prints the JSON schema of profiles.
Assumes: nothing.
Does not: check a profile; every command that reads one does.
"""

import click

from codegen.errors import ExitCode
from maviper.cli.group import Verb


@click.command(cls=Verb, example="maviper schema > profile.schema.json")
def schema() -> int:
    """Print the JSON schema of policy profiles."""
    from codegen.policy_json import layout
    from codegen.profiles import schema as profile_schema

    click.echo(layout(profile_schema()))
    return ExitCode.DONE
