"""The commands show, play, evaluate, compare and worlds.

Does: prints the trees of a profile as rules or as a picture, writes the page that plays it, opens that page; has a
  profile, an expert or a mix measured in play, a frozen team answered by its opponents, and algorithms compared; prints
  what worlds there are, what is in one, and whether one can be used; writes a world file to start from.
Assumes: `maviper.evaluation` measures and writes the rules, `maviper.page` page and picture; `maviper.worlds` knows the
  worlds.
Does not: decide, train, refine, play or count.
"""

from collections.abc import Collection
from pathlib import Path
from typing import TYPE_CHECKING, Any, Unpack, cast

import click
from click.core import ParameterSource

from codegen.errors import ExitCode
from codegen.wording import format_count
from maviper.cli.options import PATH, PROFILE, SETTING, Verb, Verbs, option, options_of, output, say_json
from maviper.options import CompareOptions, EvaluateOptions, ExploitOptions, table_of
from maviper.options.verbs import ANSWERS

if TYPE_CHECKING:
    from codegen.ir import AgentPolicy, PolicyProfile
    from codegen.world import EntitySpec, WorldSpec
    from maviper.console import Console


TEXT, SVG, HTML = "text", "svg", "html"
USUAL = {TEXT: "rules.txt", SVG: "trees.svg", HTML: "play.html"}  # names of the files


def _print_schema(context: click.Context, _parameter: click.Parameter, asked: bool) -> None:
    if asked and not context.resilient_parsing:
        from codegen.profiles import schema

        say_json(schema())
        context.exit(ExitCode.DONE)


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
@option(
    "--schema",
    is_flag=True,
    is_eager=True,
    expose_value=False,
    callback=_print_schema,
    help="Print the JSON schema of profiles, and nothing of PROFILE.",
)
@option("-o", "--output", type=PATH, default=None, help="The file (default: print, or NAME.play.html).")
def show(
    console: "Console",
    profile: Path,
    agent: str | None,
    form: str,
    obs: str | None,
    state: str | None,
    output: Path | None,
) -> int:
    """Show the trees of PROFILE as rules, SVG, or a page that plays.

    Rules have one line per leaf. The picture is one SVG. Its leaves have their shares of the decisions in held-out
    episodes, if the world is one of ours. With --obs or --state, one decision is explained instead: the tests that it
    meets, and by how much. The page is one HTML file that needs no network: drag the agents and see what each tree
    does, where a claim fails, and how an episode goes on.
    """
    from codegen.errors import InputError
    from maviper.files import runs
    from maviper.files.profiles import load

    loaded = load(profile, sums=True)
    if output is None and form == HTML:
        output = _name_page(profile)
    if output is not None:
        runs.target(runs.ensure_other(output, [profile]), USUAL[form])
    if form == HTML and output is not None:
        if (agent, obs, state) != (None, None, None):
            raise InputError("a page shows all agents in any state", "--format html", "leave the other options out")
        console.give({"wrote": str(_write(loaded, output, console))})
        return ExitCode.DONE
    if form == SVG and (obs, state) != (None, None):
        raise InputError("a picture shows no single decision", "--format svg", "leave --obs and --state out")
    one = obs is not None or state is not None
    lines = _decisions(loaded, agent, obs, state) if one else _render_lines(loaded, agent, form)
    if output is None:
        console.give({"format": form, "lines": lines}, lines)
    else:
        console.give({"wrote": str(runs.write(output, "\n".join(lines) + "\n"))})
    return ExitCode.DONE


@click.command(cls=Verb, example="maviper play demo/profile.json")
@PROFILE
@option("--world", default=None, metavar="WORLD", help="Your own world, to record an episode: gymnasium:ID, ...")
@option("--certificate", type=PATH, default=None, help="Show its claim first, and what a monitor of its proof says.")
@option("-o", "--output", type=PATH, default=None, help="The page (default: NAME.play.html beside NAME.json).")
def play(console: "Console", profile: Path, world: str | None, certificate: Path | None, output: Path | None) -> int:
    """Open a page that plays PROFILE in the browser.

    The page is that of `maviper show --format html`. Without options, a play.html of the same profile that lies beside
    it is opened as it is: `demo`, `verify` and `repair` write one, with their verdicts. If no browser can be opened,
    the file is named.
    """
    console.line("playing", str(profile))
    import webbrowser

    from maviper.files import runs
    from maviper.files.profiles import load
    from maviper.page.page import shows

    loaded = load(profile, sums=True)
    file = profile.parent / USUAL[HTML]
    found = (output, world, certificate) == (None, None, None) and shows(file, loaded)
    if found:
        console.line("page", str(file))
    else:
        page = runs.ensure_other(output or _name_page(profile), _list_given(profile, world, certificate))
        file = _write(loaded, runs.target(page, USUAL[HTML]), console, world, certificate)
    if not webbrowser.open(file.resolve().as_uri()):
        console.line("", "no browser could be opened: open the file in one")
    console.give({"opened" if found else "wrote": str(file)})
    return ExitCode.DONE


def _name_page(profile: Path) -> Path:
    """A page beside the profile, by a name that no run writes: theirs have verdicts."""
    from maviper.files.runs import PACKED

    return profile.with_name(f"{profile.name.removesuffix(PACKED).removesuffix('.json')}.{USUAL[HTML]}")


def _write(
    profile: "PolicyProfile",
    file: Path,
    console: "Console",
    world: str | None = None,
    certificate: Path | None = None,
) -> Path:
    from maviper.evaluation.players import playing
    from maviper.files import runs
    from maviper.page.document import usual_claims
    from maviper.page.page import contents_of, page, with_proof

    played = None if world is None else playing(profile, world, "--world")
    contents = contents_of(profile, usual_claims(profile), played=played)
    if certificate is not None:
        contents = with_proof(contents, profile, certificate)
    written = runs.write(file, page(profile, contents))
    console.line("page", str(written))
    return written


def _list_given(profile: Path, world: str | None, certificate: Path | None) -> list[Path]:
    """The files that a page is made from."""
    stated = [] if world is None else [Path(world.removeprefix("system:"))]
    return [profile, *stated, *([] if certificate is None else [certificate])]


def _render_lines(profile: "PolicyProfile", agent: str | None, form: str) -> list[str]:
    """Rules or a picture, line by line."""
    if form == TEXT:
        from maviper.evaluation.show import tell_rules

        return list(tell_rules(profile, _select_agents(profile, agent)))
    from maviper.page.page import svg

    return svg(profile, [policy.agent for policy in _select_agents(profile, agent)]).splitlines()


def _decisions(profile: "PolicyProfile", agent: str | None, obs: str | None, state: str | None) -> list[str]:
    """One decision of an agent, or of all in a world state."""
    from codegen.errors import InputError
    from maviper.evaluation import show

    chosen = _select_agents(profile, agent)
    if obs is not None and state is not None:
        raise InputError("a state says what is observed", "--obs", "leave one of them out")
    if obs is None:
        seen = show.observe_state(profile, state or "")
    elif len(chosen) == 1:
        seen = {chosen[0].agent: show.observation_of(chosen[0], obs)}
    else:
        raise InputError("an observation is one agent's", "--obs", "say whose: --agent NAME")
    return [line for policy in chosen for line in show.lines(policy, seen[policy.agent])]


def _select_agents(profile: "PolicyProfile", agent: str | None) -> "list[AgentPolicy]":
    """The agent of that name alone, or all."""
    from codegen.errors import UnknownNameError

    names = [policy.agent for policy in profile.agents]
    if agent is not None and agent not in names:
        raise UnknownNameError("agent", agent, names, "--agent")
    return [policy for policy in profile.agents if agent in (None, policy.agent)]


RARE = ("steps", "refinement_episodes", "seed")  # given by --set


@click.command(
    cls=Verb,
    settings=RARE,
    example="maviper evaluate demo/profile.json --against random --episodes 500\n"
    "maviper evaluate demo/profile.json --exploit defenders --against scripted",
)
@click.argument("subject")
@options_of(EvaluateOptions)
@option("--exploit", metavar="TEAM", section=ANSWERS, help="What do the opponents of this team gain by answering it?")
@options_of(ExploitOptions, "networks", *RARE)
@SETTING
def evaluate(console: "Console", subject: str, exploit: str | None, **options: Any) -> int:
    """Measure trees or an expert in play.

    SUBJECT is a profile, or an expert named as for `maviper extract`. A name that ends in .json is always a profile.
    --with mixes them.

    Each team plays against the opponents. For comparison, the expert plays the same episodes in its place. The output
    has measures, returns and ratios to the expert, all with intervals. For a joint ratio the whole team is replaced;
    for an individual ratio, one agent among experts. For trees, the output adds size, comparisons per decision, and
    fidelity to the expert. By default the opponents are the expert, or SUBJECT if there is no expert.

    With --exploit, the policies of TEAM stay as they are. Its own opponents, the expert, every --against, a tree
    refined in play and, with --networks, two trained networks answer them. The best responder is chosen on some
    episodes; its gain over the own opponents, measured on others, is a lower bound on the exploitability.
    """
    context = click.get_current_context()
    given = {name for name in options if context.get_parameter_source(name) is ParameterSource.COMMANDLINE}
    if exploit is not None:
        _ensure_unread(given & {"replaced", "team", "why"}, "with --exploit")
        asked = cast("ExploitOptions", {name: options[name] for name in table_of(ExploitOptions)})
        from maviper.extraction.exploiting import exploit_team, lines

        console.line("exploiting", f"{exploit} of {subject}")
        exploitability = exploit_team(subject, exploit, console, **asked)
        console.give(exploitability.document(), lines(exploitability))
        return ExitCode.DONE
    _ensure_unread(given & {"networks", *RARE}, "without --exploit TEAM")
    console.line("evaluating", subject)
    from maviper.evaluation.run import document, evaluate_live, lines, request

    asked = request(subject, **cast("EvaluateOptions", {name: options[name] for name in table_of(EvaluateOptions)}))
    measured = evaluate_live(asked, console)
    console.give(document(asked, measured), lines(asked, measured))
    return ExitCode.DONE


def _ensure_unread(names: Collection[str], where: str) -> None:
    """InputError for options that nothing reads."""
    from codegen.errors import InputError

    for name in names:
        flag = {"replaced": "--with"}.get(name, f"--{name.replace('_', '-')}")
        raise InputError(f"{flag} has no effect {where}", flag, "leave it out")


@click.command(
    cls=Verb,
    example="maviper compare cooperative-navigation --max-episodes 400 -o compared\n"
    "maviper compare mygame:act --world mygame:make --depths 2,3 -o mine",
)
@click.argument("expert")
@options_of(CompareOptions)
@output("The folder of the comparison.")
def compare(console: "Console", expert: str, output: Path, **options: Unpack[CompareOptions]) -> int:
    """Compare algorithms and depths on an expert, over seeds.

    EXPERT is named as for `maviper extract`. Each algorithm is given the same number of episodes at every depth and
    seed, and its trees are measured in held-out episodes that the expert plays, too. The output has means with 95 %
    intervals, ratios to the expert, leaves, fidelity, episodes, CPU time, and verdicts on differences.

    The folder gets this table as CSV and LaTeX, a figure and the best trees. An interrupted call goes on when it is
    repeated, and several calls may work on one folder at the same time.
    """
    console.line("comparing", expert)
    from maviper.reproduction.compare import compare_algorithms, request

    found = compare_algorithms(expert, output, request(options), console)
    console.give(found.document, found.lines)
    return found.code


@click.group(cls=Verbs, example="maviper worlds list")
def worlds() -> None:
    """List the games, show one, or state and check one of your own."""


@worlds.command("list", cls=Verb, example="maviper worlds list")
def worlds_list(console: "Console") -> int:
    """List the worlds, their options and their shipped experts.

    Options are shown with their defaults. EXPERT@SEED is the expert of one training seed.
    """
    from maviper.experts.network import SHIPPED
    from maviper.worlds import WORLDS, find, options_of

    known, lines = dict[str, Any](), list[str]()
    for name in WORLDS:
        teams = {team: list(members) for team, members in find(name).teams.items()}
        options = dict(options_of(name))
        experts = [expert for expert in SHIPPED if expert.startswith(name)] or [f"{name}@scripted"]
        known[name] = {"teams": teams, "options": options, "experts": experts}
        lines.append(f"{name}  {', '.join(f'{team} ({len(members)})' for team, members in teams.items())}")
        lines.append(f"  options: {', '.join(f'{key}={value}' for key, value in options.items())}")
        lines.append(f"  experts: {', '.join(experts)}")
    console.give({"worlds": known}, lines)
    return ExitCode.DONE


@worlds.command("show", cls=Verb, example="maviper worlds show physical-deception,defenders=3")
@click.argument("world")
@option("--features-file", type=PATH, default=None, help="Names and units of what agents observe (TOML).")
def worlds_show(console: "Console", world: str, features_file: Path | None) -> int:
    """Print the agents of WORLD, their features, actions and measures.

    Each feature is shown with its unit, range and meaning; entities of a game with places, with how they move; options
    of a shipped game, with their ranges and defaults.
    """
    from codegen.ir import FORK, PHYSICS
    from maviper.worlds import WORLDS, explain_option, find, options_of
    from maviper.worlds.games.particle import FORK_MOTION, ParticleWorld
    from maviper.worlds.matching import with_names

    game = find(world, giving=True)
    game = game if features_file is None else with_names(game, features_file)
    pace = f" of {game.spec.dt} s" if game.spec.dt else ""
    lines = [f"{game.name}, after {game.spec.reference}, {format_count(game.spec.episode_steps, 'step')}{pace}"]
    if game.spec.options.get(PHYSICS) == FORK:
        lines.append(f"{PHYSICS}={FORK}: {FORK_MOTION}; the verifier covers mpe2's motion only")
    for entity in (*game.spec.agents, *game.spec.landmarks) if isinstance(game, ParticleWorld) else ():
        lines.append(f"  {entity.name:<16} {_body(entity, game.spec)}")
    agents: list[dict[str, Any]] = []
    for agent, features, actions, outputs in zip(game.agents, game.features, game.actions, game.given, strict=True):
        does = {"actions": [action.name for action in actions], "outputs": [output.name for output in outputs]}
        seen = {one.name: str(one.meaning or "") for one in features}
        agents.append({"agent": agent, "team": game.team_of(agent), "features": seen, **does})
        lines += ["", f"{agent}, team {game.team_of(agent)}"]
        for one in features:
            lines.append(f"  {one.name:<16} {one.unit} [{one.low:g}, {one.high:g}]  {one.meaning or 'no meaning'}")
        lines += [f"  gives {one.name:<10} {one.unit} [{one.low:g}, {one.high:g}]" for one in outputs]
        lines += [f"  actions: {', '.join(does['actions'])}"] if actions else []
    lines += ["", "measures"]
    for measure in game.measures:
        lines.append(f"  {measure.label}, {'lower' if measure.lower_is_better else 'higher'} is better")
    if (name := game.name.partition(",")[0]) in WORLDS:
        lines += ["", "options", *(f"  {key:<16} {explain_option(name, key)}" for key in options_of(name))]
    console.give({"world": game.name, "reference": game.spec.reference, "agents": agents}, lines)
    return ExitCode.DONE


def _body(entity: "EntitySpec", spec: "WorldSpec") -> str:
    """Says how large an entity is, how it moves and where it starts."""
    low, high = entity.start or (spec.start_low, spec.start_high)
    moves = f"acceleration {entity.force:g}" if entity.force else "fixed"
    speed = "" if entity.max_speed is None else f", top speed {entity.max_speed:g}"
    collides = "collides" if entity.collides else "passes through"
    return f"radius {entity.size:g}, {moves}{speed}, {collides}, starts within {low:g} to {high:g}"


@worlds.command("new", cls=Verb, example="maviper worlds new cart.toml")
@click.argument("file", type=PATH)
@option("--flow", is_flag=True, help="In continuous time: derivatives, and samples at a period.")
def worlds_new(console: "Console", file: Path, flow: bool) -> int:
    """Write a world file to start from, for you to edit.

    FILE states a system of your own: its variables with units and ranges, what agents observe and do, where episodes
    start, and how the state moves. It explains itself in comments.
    """
    from maviper.worlds.checking import new

    new(file, flow)
    console.give({"wrote": str(file)}, [f"wrote {file}; check it with `maviper worlds check {file}`"])
    return ExitCode.DONE


@worlds.command("check", cls=Verb, example="maviper worlds check mygame:make,n=2")
@click.argument("world")
@option("--run-reference", is_flag=True, help="Also run user code (an environment) that a world file names.")
def worlds_check(console: "Console", world: str, run_reference: bool) -> int:
    """Report what WORLD provides, what is missing and what is wrong.

    Prints one line per finding. Exits with 2 if the world cannot be used.

    WORLD is a name from `maviper worlds list`, gymnasium:ID for a single-agent environment of Gymnasium, vmas:SCENARIO,
    module:function for your own PettingZoo environment, or a world file (TOML). Options follow after commas:
    module:function,n=3,max_steps=50.

    If a world file names a reference, 100,000 steps of that environment are compared with what the file states. A
    step that is off by more than the stated error is a fault.
    """
    console.line("checking", world)
    from maviper.worlds.checking import check, usable
    from verify.spending import listening

    with console.following("checking") as listener, listening(listener):
        findings = check(world, run_reference, lambda finding: None if console.json else click.echo(str(finding)))
    console.give({"usable": usable(findings), "findings": [str(finding) for finding in findings]})
    return ExitCode.DONE if usable(findings) else ExitCode.INPUT
