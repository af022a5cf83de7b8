"""The command replay.

Does: has a counterexample replayed, and says what the team does in it.
Assumes: `maviper.verification.files.counterexamples` replays.
Does not: look for counterexamples.
"""

from pathlib import Path

import click

from codegen.errors import ExitCode, escape_text
from maviper.cli.group import Verb
from maviper.cli.options import PATH, console_of, option


@click.command(cls=Verb, example="maviper replay report/counterexample-1-distinct_targets.json")
@click.argument("counterexample", type=PATH)
@option(
    "--profile", type=PATH, default=None, help="The profile to replay it with (default: profile.json beside the file)."
)
@option(
    "--world",
    type=PATH,
    default=None,
    help="The world file of a counterexample in a stated system (default: world.toml beside it).",
)
@click.pass_context
def replay(context: click.Context, counterexample: Path, profile: Path | None, world: Path | None) -> int:
    """Replay a counterexample, with the same profile or another.

    `maviper verify -o` writes a COUNTEREXAMPLE for each violated claim. The reference, the compiled C and the
    environment replay it, and must act alike. A counterexample about episodes is played again from its start, one in a
    stated system in exact numbers with its errors.

    Exits with 1 if the claim fails there, and with 0 if it holds, as it should for a repaired profile.
    """
    from maviper.files.profiles import find_profile
    from maviper.verification.files.counterexamples import ensure_counterexample
    from maviper.verification.files.counterexamples import replay as replayed

    console = console_of(context)
    ensure_counterexample(counterexample)  # before the profile beside it, which need not be there
    outcome = replayed(counterexample, find_profile(profile, beside=counterexample, sums=True), world)
    if not outcome.same_policy:
        console.line("profile", "not the one that the counterexample was made from")
    for agent, action in outcome.actions.items():
        was = outcome.before.get(agent, action)
        changed = "" if action == was else f" (was {escape_text(was)})"
        console.line(agent, f"{action}{changed}")
    told, _, said = outcome.says.partition(" ")
    console.line(told, f"{said}, which all act the same" if outcome.by else said)
    console.line("VIOLATED" if outcome.violated else "holds", outcome.property)
    return ExitCode.VIOLATED if outcome.violated else ExitCode.DONE
