"""The options of verify that say what is asked.

Does: options for the claims, their parameters, where they hold, and budgets.
Assumes: `maviper.verification.ask.VerifyOptions` has a field for each.
Does not: check values beyond their form.
"""

from typing import Any

import click

from codegen.errors import ExitCode
from maviper.cli.options import BUDGETS, EXTENT, MARGIN, PARAMETERS, PATH, QUESTION, REGION, fraction, names, option


def _list_properties(context: click.Context, _parameter: click.Parameter, asked: bool) -> None:
    if asked and not context.resilient_parsing:
        from maviper.cli.properties import print_properties

        print_properties(as_json=False)
        context.exit(ExitCode.DONE)


QUESTION_OPTIONS = (
    option(
        "--property",
        "names",
        multiple=True,
        metavar="NAME",
        section=QUESTION,
        help="A built-in property (repeatable; default: distinct_targets).",
    ),
    option("--properties", "file", type=PATH, default=None, section=QUESTION, help="A property file (TOML)."),
    option(
        "--list",
        is_flag=True,
        is_eager=True,
        expose_value=False,
        callback=_list_properties,
        section=QUESTION,
        help="List the built-in properties.",
    ),
    option(
        "--world",
        type=PATH,
        default=None,
        section=QUESTION,
        help="A world's file (TOML): claims are about the system that it states, those of the file or of --properties.",
    ),
    option(
        "--run-reference",
        is_flag=True,
        section=QUESTION,
        help="With --world: also run an environment of somebody's own that the file names, to measure the statement.",
    ),
    REGION,
    option(
        "--team",
        default=None,
        metavar="NAME",
        section=QUESTION,
        help="The team that the claim is about (default: the one with as many agents as landmarks).",
    ),
    option(
        "--observations",
        is_flag=True,
        section=QUESTION,
        help="Claims are about what agents observe, not about world states (without meanings of features: always).",
    ),
    option(
        "--shared",
        callback=names,
        metavar="A,B|all",
        section=QUESTION,
        help="With --observations: features that all agents that have them observe alike.",
    ),
    option(
        "--semantics",
        default="machine",
        show_default=True,
        section=QUESTION,
        metavar="NAME",
        help="machine: as deployed; real: exact arithmetic, for comparison.",
    ),
)
PARAMETER_OPTIONS = (
    MARGIN,
    option(
        "--radius",
        callback=fraction,
        metavar="NUMBER",
        section=PARAMETERS,
        help="An agent is at a landmark within this distance along each axis (default: 1/10; reaches, covers: 2/5). "
        "keeps_apart: the minimum distance (default: the distance at which they touch).",
    ),
    option(
        "--landmarks",
        callback=names,
        metavar="A,B",
        section=PARAMETERS,
        help="own_target, reaches, covers: one landmark per agent of the team.",
    ),
    option(
        "--others",
        callback=names,
        metavar="A,B",
        section=PARAMETERS,
        help="keeps_apart: what the team keeps away from (default: one another).",
    ),
    option(
        "--steps",
        default=None,
        type=int,
        section=PARAMETERS,
        help="reaches, covers, keeps_apart: steps of an episode (default: the world's).",
    ),
    option(
        "--kappa",
        callback=fraction,
        metavar="NUMBER",
        section=PARAMETERS,
        help="aligned: ahead by kappa times the sideways offset (default: 1/2).",
    ),
    option("--of", default=None, metavar="NAME", section=PARAMETERS, help="steady: the property that must stay true."),
    option(
        "--eps",
        callback=fraction,
        metavar="NUMBER",
        section=PARAMETERS,
        help="steady: the largest error of each feature (default: 1/100).",
    ),
)
COMPARED_OPTIONS = (
    option("--agents", callback=names, metavar="A,B", section=PARAMETERS, help="agree: the two agents."),
    option("--agent", default=None, metavar="NAME", section=PARAMETERS, help="monotone: the agent."),
    option("--feature", default=None, metavar="NAME", section=PARAMETERS, help="monotone: the feature to raise."),
    option(
        "--direction",
        default=None,
        metavar="NAME",
        section=PARAMETERS,
        help="monotone: increasing (default) or decreasing.",
    ),
    option(
        "--order",
        callback=names,
        metavar="A,B",
        section=PARAMETERS,
        help="monotone: all actions, lowest first (default: the profile's order).",
    ),
)
LIMIT_OPTIONS = (
    option(
        "--where",
        is_flag=True,
        section=EXTENT,
        help="Find where claims hold and fail (reaches, covers: the share of starts that fail).",
    ),
    option(
        "--max-cells", default=None, type=int, section=EXTENT, help="Limit on failing cells to find (default: 50000)."
    ),
    option(
        "--solver-units",
        default=None,
        type=int,
        section=BUDGETS,
        help="Limit per query to Z3, in its resource units (default: 200000000).",
    ),
    option(
        "--max-zones",
        default=None,
        type=int,
        section=BUDGETS,
        help="Limit on zones visited per claim about episodes, and on its certificate (default: 5000000).",
    ),
)


STATED_OPTIONS = (
    option(
        "--max-states",
        default=None,
        type=int,
        section=BUDGETS,
        help="With --world: limit on symbolic states visited per claim (default: 200000).",
    ),
)


def asked(command: Any) -> Any:
    """Adds all of them to a command."""
    for each in reversed((*QUESTION_OPTIONS, *PARAMETER_OPTIONS, *COMPARED_OPTIONS, *LIMIT_OPTIONS, *STATED_OPTIONS)):
        command = each(command)
    return command
