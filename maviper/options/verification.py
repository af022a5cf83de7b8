"""The options of `maviper verify` and of `maviper.verify` that say what is asked of which claim.

Does: says each option once: its name, type, default, heading and help; None: as usual.
Assumes: parameters of claims have their forms and texts in `verify.claims.language.parameters`; each other option is a
  field of `maviper.verification.ask.VerifyOptions`.
Does not: check values beyond their types.
"""

from typing import Annotated, TypedDict

from maviper.options.table import Option
from verify.claims.language.parameters import Names, Parameters

QUESTION, EXTENT, BUDGETS = "What is asked", "Where a claim holds", "Budgets"


class TeamOptions(TypedDict, total=False):
    """Whose decisions a claim is about."""

    team: Annotated[
        str | None,
        Option(
            None,
            QUESTION,
            "The team that the claim is about (default: the one with as many agents as landmarks).",
            "NAME",
        ),
    ]


class QuestionOptions(TypedDict, total=False):
    """What is asked, whatever the claim."""

    observations: Annotated[
        bool,
        Option(
            False,
            QUESTION,
            "Claims are about what agents observe, not about world states (without meanings of features: always).",
        ),
    ]
    shared: Annotated[
        Names | None,
        Option(
            None,
            QUESTION,
            "With --observations: features that all agents that have them observe alike.",
            "A,B|all",
            commas=True,
        ),
    ]
    semantics: Annotated[
        str, Option("machine", QUESTION, "machine: as deployed; real: exact arithmetic, for comparison.", "NAME")
    ]


class LimitOptions(TypedDict, total=False):
    """Where a claim holds, and what may be spent on that."""

    where: Annotated[bool, Option(False, EXTENT, "Find where claims about single decisions hold and fail.")]
    max_cells: Annotated[int | None, Option(None, EXTENT, "Limit on failing cells to find (default: 50000).")]
    solver_units: Annotated[
        int | None,
        Option(None, BUDGETS, "Limit per query to Z3, in its resource units (default: 200000000)."),
    ]
    max_zones: Annotated[
        int | None,
        Option(
            None,
            BUDGETS,
            "Limit on zones visited per claim about episodes, and on its certificate (default: 5000000).",
        ),
    ]


class VerifyOptions(TeamOptions, QuestionOptions, Parameters, LimitOptions, total=False):
    """What is asked of a claim."""


class FileOptions(QuestionOptions, LimitOptions, total=False):
    """What is asked of the claims of a property file, which says what each is about."""


class SystemOptions(TypedDict, total=False):
    """What is asked of the system that a world file defines."""

    run_reference: Annotated[
        bool,
        Option(
            False,
            QUESTION,
            "With --world: also run user code (an environment) that the file names, to measure the statement.",
            needs="world",
        ),
    ]
    max_boxes: Annotated[
        int | None,
        Option(
            None,
            BUDGETS,
            "With --world, and for episodes of teams that test sums: limit on what each claim may spend, in"
            " boxes, about a million a second (default: 60000000).",
        ),
    ]
