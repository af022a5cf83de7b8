"""The command import.

Does: has trees of other programs read and replayed, writes the profile, and says what was compared.
Assumes: `maviper.importing.trees` reads them.
Does not: read or compare anything itself.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Unpack

import click

from codegen.errors import ExitCode
from codegen.wording import format_count
from maviper.cli.group import Verb
from maviper.cli.options import PATH, console_of, option, options_of, output
from maviper.options import ImportOptions
from maviper.options.profiles import IMPORTED


def _agents(_context: click.Context, parameter: click.Parameter, value: str | None) -> dict[str, Path] | None:
    """Reads agent=file,agent=file."""
    if value is None:
        return None
    pairs = [part.strip().partition("=") for part in value.split(",")]
    if any(not agent.strip() or not file for agent, _, file in pairs):
        raise click.BadParameter("give agent=file, with commas in between", param=parameter)
    files = {agent.strip(): Path(file) for agent, _, file in pairs}
    if len(files) < len(pairs):
        raise click.BadParameter("an agent appears twice", param=parameter)
    return files


@click.command("import", cls=Verb, example="maviper import policy.py -o profile.json")
@click.argument("file", type=PATH, required=False)
@option(
    "--agents",
    default=None,
    metavar="NAME=FILE,...",
    callback=_agents,
    section=IMPORTED,
    help="A team: one file for each agent, instead of FILE.",
)
@options_of(ImportOptions)
@output("The profile's file, a .json.", PATH)
@click.pass_context
def import_verb(
    context: click.Context,
    file: Path | None,
    agents: dict[str, Path] | None,
    output: Path,
    **options: Unpack[ImportOptions],
) -> int:
    """Import decision trees of other programs: exact, or refused.

    FILE is if/else Python or C (one function per agent), an ONNX model, a tree or a small sum of trees of XGBoost
    (JSON) or LightGBM (text), a tree of treelite (JSON) or dtControl (JSON), or a C header of `maviper compile`. Its
    kind is detected. The only code that is run is if/else Python, behind a gate, and compiled C, each in a process of
    its own, to compare its answers with the tree; `--no-run` runs neither.

    The profile decides as FILE does for every observation of the numbers that FILE compares, float32 or float64. It is
    written only after a comparison: both must decide the same at every threshold, at its neighbours, at random
    observations, and for Python at every number of the source. A file that is not understood in full is refused.
    `maviper guide importing` says what can come in.
    """
    console = console_of(context)
    console.line("importing", "" if file is None else str(file))
    from codegen import policy_json
    from maviper.files import runs
    from maviper.importing.trees import import_trees

    runs.target(runs.ensure_other(output, [*(agents or {}).values(), *([] if file is None else [file])]))
    profile = import_trees(file, agents, **options)
    for policy in profile.agents:
        _say(policy, profile.provenance.training, console)
    runs.write(output, policy_json.dumps(profile))
    console.line("wrote", str(output))
    return ExitCode.DONE


def _say(policy: Any, facts: Mapping[str, Any], console: Any) -> None:
    """What an agent's tree is, and what it was compared with."""
    from codegen.deciding import kind_decided, list_decided

    leaves = int((policy.tree.feature < 0).sum())
    size = ", ".join(
        [
            format_count(leaves, "leaf"),
            format_count(len(policy.features), "feature"),
            format_count(len(list_decided(policy)), kind_decided(policy).removesuffix("s")),
            policy.numbers,
            *([f"sums {facts[sums]}"] if (sums := f"{policy.agent} sums") in facts else []),
        ]
    )
    console.line(policy.agent, f"{facts[f'{policy.agent} from']}: {size}")
    count, by = facts[f"{policy.agent} replayed"], facts[f"{policy.agent} replayed by"]
    if count:
        console.line("replayed", f"{format_count(count, 'observation')}, by {by}: no difference")
    else:
        console.line("compared", f"none, {by}")
    for kind in ("features", kind_decided(policy)):
        console.line(kind, str(facts[f"{policy.agent} {kind}"]))
    if f"{policy.agent} notes" in facts:
        console.line("notes", str(facts[f"{policy.agent} notes"]))
    if policy.seen:
        from codegen.importers.names import format_first

        ends = zip(policy.features, policy.seen, strict=True)
        console.line("seen", format_first([f"{one.name} {low:.3g} to {high:.3g}" for one, (low, *_, high) in ends]))
    if f"{policy.agent} permits" in facts:
        console.line("permits", str(facts[f"{policy.agent} permits"]))
    console.line("given", str(facts[f"{policy.agent} given"]))
    console.line("NaN", str(facts[f"{policy.agent} NaN"]))
