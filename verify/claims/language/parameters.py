"""The parameters that claims read beside their team: one table, from which files, options and Python take them.

Does: name, kind and help of each. Its usual value stands in the class of the claim.
Assumes: a name means the same in every claim that reads it.
Does not: check values.
"""

from enum import Enum
from typing import NamedTuple


class Form(Enum):
    """How a parameter is given; the values are what an option's help calls it."""

    NUMBER = "NUMBER"  # exact
    COUNT = "INTEGER"
    NAMES = "A,B"
    NAME = "NAME"


class ParameterSpec(NamedTuple):
    """One parameter."""

    name: str
    form: Form
    help: str


PARAMETERS = (
    ParameterSpec(
        "margin",
        Form.NUMBER,
        "An agent closes on a landmark when it is ahead by more than this (default: 0).",
    ),
    ParameterSpec(
        "radius",
        Form.NUMBER,
        "An agent is at a landmark within this distance along each axis (default: 1/10; reaches, covers: 2/5). "
        "keeps_apart: the minimum distance (default: the distance at which they touch).",
    ),
    ParameterSpec("landmarks", Form.NAMES, "own_target, reaches, covers: one landmark per agent of the team."),
    ParameterSpec("others", Form.NAMES, "keeps_apart: what the team keeps away from (default: one another)."),
    ParameterSpec("steps", Form.COUNT, "reaches, covers, keeps_apart: steps of an episode (default: the world's)."),
    ParameterSpec("kappa", Form.NUMBER, "aligned: ahead by kappa times the sideways offset (default: 1/2)."),
    ParameterSpec("of", Form.NAME, "steady: the property that must stay true."),
    ParameterSpec("eps", Form.NUMBER, "steady: the largest error of each feature (default: 1/100)."),
    ParameterSpec("agents", Form.NAMES, "agree, differ: the two agents."),
    ParameterSpec("agent", Form.NAME, "monotone: the agent."),
    ParameterSpec("feature", Form.NAME, "monotone: the feature to raise."),
    ParameterSpec("direction", Form.NAME, "monotone: increasing (default) or decreasing."),
    ParameterSpec("order", Form.NAMES, "monotone: all actions, lowest first (default: the profile's order)."),
)
NAMES = tuple(each.name for each in PARAMETERS)


def of_form(form: Form) -> tuple[str, ...]:
    """The names of the parameters that are given so."""
    return tuple(each.name for each in PARAMETERS if each.form is form)
