"""The command show.

Does: prints the trees of a profile as rules.
Assumes: `maviper.evaluation.show` writes the rules.
Does not: draw; the target svg does.
"""

from pathlib import Path

import click

from codegen.errors import ExitCode
from maviper.cli.group import Verb
from maviper.cli.options import PROFILE, option


@click.command(cls=Verb, example="maviper show demo/profile.json --agent agent_0")
@PROFILE
@option("--agent", default=None, metavar="NAME", help="One agent only.")
def show(profile: Path, agent: str | None) -> int:
    """Print the trees of PROFILE as rules, one line per leaf."""
    from codegen.errors import UnknownNameError
    from maviper.evaluation.show import rules
    from maviper.files.profiles import load

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
