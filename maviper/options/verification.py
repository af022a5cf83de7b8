"""The options of `maviper verify` and of `maviper.verify` that say what is asked of which claim.

Does: says each option once: its name, type, default, heading and help; None: as usual.
Assumes: parameters of claims have their forms and texts in `verify.claims.language.parameters`; each other option is a
  field of `maviper.verification.ask.VerifyOptions`.
Does not: check values beyond their types.
"""

from collections.abc import Sequence
from fractions import Fraction
from typing import Annotated, TypedDict

from maviper.options.table import Option
from verify.claims.language import parameters
from verify.claims.language.parameters import Form

QUESTION, PARAMETERS, EXTENT, BUDGETS = "What is asked", "Parameters of claims", "Where a claim holds", "Budgets"
# exact: a text such as "1/40" or "0.025"; a float means the decimal that Python prints for it
Number = Fraction | float | str
Names = Sequence[str]


def of_claims(name: str) -> Option:
    """A parameter that some claims read; without it, as the claim says."""
    (spec,) = (each for each in parameters.PARAMETERS if each.name == name)
    form = "" if spec.form is Form.COUNT else spec.form.value
    return Option(None, PARAMETERS, spec.help, form, commas=spec.form is Form.NAMES)


class VerifyOptions(TypedDict, total=False):
    """What is asked of a claim."""

    team: Annotated[
        str | None,
        Option(
            None,
            QUESTION,
            "The team that the claim is about (default: the one with as many agents as landmarks).",
            "NAME",
        ),
    ]
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
    margin: Annotated[Number | None, of_claims("margin")]
    radius: Annotated[Number | None, of_claims("radius")]
    landmarks: Annotated[Names | None, of_claims("landmarks")]
    others: Annotated[Names | None, of_claims("others")]
    steps: Annotated[int | None, of_claims("steps")]
    kappa: Annotated[Number | None, of_claims("kappa")]
    of: Annotated[str | None, of_claims("of")]
    eps: Annotated[Number | None, of_claims("eps")]
    agents: Annotated[Names | None, of_claims("agents")]
    agent: Annotated[str | None, of_claims("agent")]
    feature: Annotated[str | None, of_claims("feature")]
    direction: Annotated[str | None, of_claims("direction")]
    order: Annotated[Names | None, of_claims("order")]
    where: Annotated[
        bool, Option(False, EXTENT, "Find where claims hold and fail (reaches, covers: the share of starts that fail).")
    ]
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
