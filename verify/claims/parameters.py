"""The parameters that claims read beside their team: one table, from which files, options and Python take them.

Does: name, type and help of each. Its usual value stands in the class of the claim.
Assumes: a name means the same in every claim that reads it.
Does not: check values.
"""

from collections.abc import Sequence
from enum import Enum
from fractions import Fraction
from typing import Annotated, Any, Literal, NamedTuple, TypedDict, get_args, get_type_hints

# exact: a text such as "1/40" or "0.025"; a float means the decimal that Python prints for it
Number = Fraction | float | str
Names = Sequence[str]
Steps = int | Literal["always"]  # "always": for ever


class Form(Enum):
    """The form in which a parameter is given; the values are what an option's help calls it."""

    NUMBER = "NUMBER"  # exact
    STEPS = "N|always"
    NAMES = "A,B"
    NAME = "NAME"


FORMS = {Fraction: Form.NUMBER, int: Form.STEPS, str: Form.NAME}  # by the first type that a parameter may have


class Parameters(TypedDict, total=False):
    """The parameters of claims, with the help text of each; a claim reads some of them."""

    margin: Annotated[Number | None, "An agent closes on a landmark when it is ahead by more than this (default: 0)."]
    radius: Annotated[
        Number | None,
        "An agent is at a landmark within this distance along each axis (default: 1/10; reaches, covers: 2/5). "
        "keeps_apart: the minimum distance (default: the distance at which they touch). stays_in: how far from the "
        "origin (default: 3).",
    ]
    landmarks: Annotated[Names | None, "own_target, reaches, covers: one landmark per agent of the team."]
    others: Annotated[Names | None, "keeps_apart: what the team keeps away from (default: one another)."]
    steps: Annotated[
        Steps | None,
        "reaches, covers, keeps_apart: steps of an episode (default: the world's). keeps_apart, stays_in: also always, "
        "which is for ever.",
    ]
    kappa: Annotated[Number | None, "aligned: ahead by kappa times the sideways offset (default: 1/2)."]
    of: Annotated[str | None, "steady: the property that must stay true."]
    eps: Annotated[Number | None, "steady: the largest error of each feature (default: 1/100)."]
    agents: Annotated[Names | None, "agree, differ: the two agents."]
    agent: Annotated[str | None, "monotone, ignores, symmetric: the agent."]
    feature: Annotated[str | None, "monotone: the feature to raise; ignores: the feature that does not matter."]
    actions: Annotated[
        Names | None, "monotone, ignores: only whether it takes one of these (default: which action it takes)."
    ]
    direction: Annotated[str | None, "monotone: increasing (default) or decreasing."]
    features: Annotated[Names | None, "symmetric: the features whose sign changes (default: all)."]
    order: Annotated[
        Names | None,
        "monotone: all actions, lowest first; symmetric: the first is opposite to the last, and so on "
        "(default: the profile's order).",
    ]


class ParameterSpec(NamedTuple):
    """One parameter."""

    name: str
    form: Form
    help: str


def _spec(name: str, hint: Any) -> ParameterSpec:
    written, told = get_args(hint)
    return ParameterSpec(name, FORMS.get(get_args(written)[0], Form.NAMES), told)


PARAMETERS = tuple(_spec(name, hint) for name, hint in get_type_hints(Parameters, include_extras=True).items())
PARAMETER_NAMES = tuple(each.name for each in PARAMETERS)


def of_form(form: Form) -> tuple[str, ...]:
    """The names of the parameters that are given so."""
    return tuple(each.name for each in PARAMETERS if each.form is form)
