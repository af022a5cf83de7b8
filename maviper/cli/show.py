"""The commands show and play.

Does: prints the trees of a profile as rules, writes the page that plays it, opens that page.
Assumes: `maviper.evaluation.show` writes the rules, `maviper.page` the page.
Does not: draw trees alone; the target svg does.
"""

from pathlib import Path
from typing import TYPE_CHECKING

import click

from codegen.errors import ExitCode
from maviper.cli.group import Verb
from maviper.cli.options import PATH, PROFILE, console_of, option

if TYPE_CHECKING:
    from codegen.ir import PolicyProfile

TEXT, HTML = "text", "html"
PAGE = "play.html"


@click.command(cls=Verb, example="maviper show demo/profile.json --agent agent_0")
@PROFILE
@option("--agent", default=None, metavar="NAME", help="One agent only.")
@option(
    "--format",
    "form",
    type=click.Choice([TEXT, HTML]),
    default=TEXT,
    show_default=True,
    help="Rules, or a page that plays the policy.",
)
@option("-o", "--output", type=PATH, default=None, help="The file (default: print rules, or play.html).")
@click.pass_context
def show(context: click.Context, profile: Path, agent: str | None, form: str, output: Path | None) -> int:
    """Show the trees of PROFILE as rules, or as a page that plays.

    Rules have one line per leaf. The page is one HTML file that needs no network: drag the agents and see what each
    tree does, where a claim fails, and how an episode goes on.
    """
    from codegen.errors import InputError
    from maviper.console import say
    from maviper.files import runs
    from maviper.files.profiles import load

    loaded = load(profile)
    if form == HTML:
        if agent is not None:
            raise InputError("a page shows all agents", "--agent", "leave it out")
        _write(loaded, output or Path(PAGE), context)
        return ExitCode.DONE
    text = "\n".join(_rules(loaded, agent))
    if output is None:
        say(text)
    else:
        runs.write(output, text + "\n")
    return ExitCode.DONE


@click.command(cls=Verb, example="maviper play demo/profile.json")
@PROFILE
@option("-o", "--output", type=PATH, default=None, help="The page (default: play.html beside the profile).")
@click.pass_context
def play(context: click.Context, profile: Path, output: Path | None) -> int:
    """Open a page that plays PROFILE in the browser.

    As `maviper show --format html`, with the page opened. Where no browser can be opened, the line names the file.
    """
    import webbrowser

    from maviper.files.profiles import load

    written = _write(load(profile), output or profile.parent / PAGE, context)
    if not webbrowser.open(written.resolve().as_uri()):
        console_of(context).line("", "no browser could be opened: open the file in one")
    return ExitCode.DONE


def _write(profile: "PolicyProfile", file: Path, context: click.Context) -> Path:
    from maviper.files import runs
    from maviper.page.page import contents_of, page

    written = runs.write(file, page(profile, contents_of(profile)))
    console_of(context).line("page", str(written))
    return written


def _rules(profile: "PolicyProfile", agent: str | None) -> list[str]:
    from codegen.errors import UnknownNameError
    from maviper.evaluation.show import rules

    names = [policy.agent for policy in profile.agents]
    if agent is not None and agent not in names:
        raise UnknownNameError("agent", agent, names, "--agent")
    lines: list[str] = []
    for policy in profile.agents:
        if agent in (None, policy.agent):
            lines += [f"{policy.agent}, team {policy.team}", *(f"  {rule}" for rule in rules(policy))]
    return lines
