"""The commands show and play.

Does: prints the trees of a profile as rules or as a picture, writes the page that plays it, opens that page.
Assumes: `maviper.evaluation.show` writes the rules, `maviper.page` page and picture.
Does not: decide.
"""

from pathlib import Path
from typing import TYPE_CHECKING

import click

from codegen.errors import ExitCode
from maviper.cli.group import Verb
from maviper.cli.options import PATH, PROFILE, console_of, option

if TYPE_CHECKING:
    from codegen.ir import AgentPolicy, PolicyProfile

TEXT, SVG, HTML = "text", "svg", "html"
USUAL = {TEXT: "rules.txt", SVG: "trees.svg", HTML: "play.html"}  # names of the files
WORLD = option(
    "--world",
    default=None,
    metavar="WORLD",
    help="Your own world, to record an episode: gymnasium:ID, ...",
)


@click.command(cls=Verb, example="maviper show demo/profile.json --agent agent_0")
@PROFILE
@option("--agent", default=None, metavar="NAME", help="One agent only.")
@option(
    "--format",
    "form",
    type=click.Choice([TEXT, SVG, HTML]),
    default=TEXT,
    show_default=True,
    help="Rules, a picture of the trees, or a page that plays the policy.",
)
@option("--obs", default=None, metavar="NUMBERS", help="Explain one decision of --agent: numbers, or NAME=NUMBER,...")
@option("--state", default=None, metavar="NAME=VALUE,...", help="Explain what the agents do in a world state.")
@WORLD
@option("-o", "--output", type=PATH, default=None, help="The file (default: print, or play.html).")
@click.pass_context
def show(
    context: click.Context,
    profile: Path,
    agent: str | None,
    form: str,
    obs: str | None,
    state: str | None,
    world: str | None,
    output: Path | None,
) -> int:
    """Show the trees of PROFILE as rules, SVG, or a page that plays.

    Rules have one line per leaf. The picture is one SVG. Its leaves have their shares of the decisions in held-out
    episodes, if the world is one of ours. With --obs or --state, one decision is explained instead: the tests that it
    meets, and by how much. The page is one HTML file that needs no network: drag the agents and see what each tree
    does, where a claim fails, and how an episode goes on.
    """
    from codegen.errors import InputError
    from maviper.console import say
    from maviper.files import runs
    from maviper.files.profiles import load
    from maviper.page.page import FILE

    loaded = load(profile, sums=True)
    if output is not None:
        runs.target(runs.ensure_other(output, _list_given(profile, world)), USUAL[form])
    if form == HTML:
        if (agent, obs, state) != (None, None, None):
            raise InputError("a page shows all agents in any state", "--format html", "leave the other options out")
        _write(loaded, output or Path(FILE), context, world)
        return ExitCode.DONE
    if world is not None:
        raise InputError("only a page records an episode of a world", "--world", "add --format html, or leave it out")
    if form == SVG and (obs, state) != (None, None):
        raise InputError("a picture shows no single decision", "--format svg", "leave --obs and --state out")
    text = "\n".join(
        _render_lines(loaded, agent, form) if obs is None and state is None else _decisions(loaded, agent, obs, state)
    )
    if output is None:
        say(text)
    else:
        runs.write(output, text + "\n")
    return ExitCode.DONE


@click.command(cls=Verb, example="maviper play demo/profile.json")
@PROFILE
@WORLD
@option("--certificate", type=PATH, default=None, help="Show its claim first, and what a monitor of its proof says.")
@option("-o", "--output", type=PATH, default=None, help="The page (default: play.html beside the profile).")
@click.pass_context
def play(
    context: click.Context, profile: Path, world: str | None, certificate: Path | None, output: Path | None
) -> int:
    """Open a page that plays PROFILE in the browser.

    As `maviper show --format html`, with the page opened. Where no browser can be opened, the line names the file.
    """
    import webbrowser

    from maviper.files import runs
    from maviper.files.profiles import load
    from maviper.page.page import FILE

    loaded = load(profile, sums=True)
    file = runs.target(
        runs.ensure_other(output or profile.parent / FILE, _list_given(profile, world, certificate)), FILE
    )
    written = _write(loaded, file, context, world, certificate)
    if not webbrowser.open(written.resolve().as_uri()):
        console_of(context).line("", "no browser could be opened: open the file in one")
    return ExitCode.DONE


def _write(
    profile: "PolicyProfile", file: Path, context: click.Context, world: str | None, certificate: Path | None = None
) -> Path:
    from maviper.evaluation.players import playing
    from maviper.files import runs
    from maviper.page.document import usual_claims
    from maviper.page.page import contents_of, page
    from maviper.page.results import with_proof

    played = None if world is None else playing(profile, world, "--world")
    contents = contents_of(profile, usual_claims(profile), played=played)
    if certificate is not None:
        contents = with_proof(contents, profile, certificate)
    written = runs.write(file, page(profile, contents))
    console_of(context).line("page", str(written))
    return written


def _list_given(profile: Path, world: str | None, certificate: Path | None = None) -> list[Path]:
    """The files that a page or a picture is made from."""
    stated = [] if world is None else [Path(world.removeprefix("system:"))]
    return [profile, *stated, *([] if certificate is None else [certificate])]


def _render_lines(profile: "PolicyProfile", agent: str | None, form: str) -> list[str]:
    """Rules or a picture, line by line."""
    if form == TEXT:
        return _rules(profile, agent)
    from maviper.page.trees import svg

    return svg(profile, [policy.agent for policy in _select_agents(profile, agent)]).splitlines()


def _rules(profile: "PolicyProfile", agent: str | None) -> list[str]:
    from codegen.importers.reading import find_uncompared
    from maviper.evaluation.show import bounds, rules

    lines: list[str] = []
    for policy in _select_agents(profile, agent):
        told = ", its source was not compared" if policy.agent in find_uncompared(profile) else ""
        lines.append(f"{policy.agent}, team {policy.team}{told}")
        lines += [f"  {line}" for line in (*bounds(policy), *rules(policy))]
    return lines


def _decisions(profile: "PolicyProfile", agent: str | None, obs: str | None, state: str | None) -> list[str]:
    """One decision of an agent, or of all in a world state."""
    from codegen.errors import InputError
    from maviper.evaluation import decision

    chosen = _select_agents(profile, agent)
    if obs is not None and state is not None:
        raise InputError("a state says what is observed", "--obs", "leave one of them out")
    if obs is None:
        seen = decision.observe_state(profile, state or "")
    elif len(chosen) == 1:
        seen = {chosen[0].agent: decision.observation_of(chosen[0], obs)}
    else:
        raise InputError("an observation is one agent's", "--obs", "say whose: --agent NAME")
    return [line for policy in chosen for line in decision.lines(policy, seen[policy.agent])]


def _select_agents(profile: "PolicyProfile", agent: str | None) -> "list[AgentPolicy]":
    """The agent of that name alone, or all."""
    from codegen.errors import UnknownNameError

    names = [policy.agent for policy in profile.agents]
    if agent is not None and agent not in names:
        raise UnknownNameError("agent", agent, names, "--agent")
    return [policy for policy in profile.agents if agent in (None, policy.agent)]
