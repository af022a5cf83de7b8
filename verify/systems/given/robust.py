"""That an output changes little where observations are a little off: the claim `robust` as a formula.

Does: reads such a claim; says which agent is the copy that observes with errors, and how large these are.
Assumes: a statement in which the copy stands: it acts like the agent, and observes each feature as it is plus a
  variable of its own, `COPY.FEATURE`.
Does not: decide. The formula is about two agents in one state.
"""

from collections.abc import Iterable, Mapping
from fractions import Fraction
from typing import NamedTuple

from codegen.errors import InputError, UnknownNameError
from verify.claims.region_files import is_table
from verify.decimals import number, plain
from verify.systems.regions import box_of
from verify.systems.statement import Statement
from verify.systems.system import Affine, Polytope
from verify.systems.values import as_table, only, text
from verify.toml_places import Place

NAME = "robust"
KEYS = ("agent", "output", "eps", "most")
OFF = "_off"  # ends the name of a copy that observes with errors


class Robust(NamedTuple):
    """The claim |out(x + e) - out(x)| <= most, wherever each |e| is at most its `eps`."""

    formula: str
    errors: Polytope  # over the copy's variables
    words: str


def copy_called(agent: str) -> str:
    """Returns the name of the copy of an agent that observes with errors."""
    return agent + OFF


def errors_of(table: Mapping[str, object], features: Mapping[str, object], where: Place) -> dict[str, Fraction]:
    """The largest error of each feature that `eps` allows: one number for all of `features`, or a table."""
    if "eps" not in table:
        raise InputError(f"{NAME} needs the largest error of a feature", where, "write eps = 0.01")
    given, place = table["eps"], where / "eps"
    if is_table(given):
        stated = as_table(given, place)
        only(stated, features, place, "feature")
        errors = {name: number(value, place / name) for name, value in stated.items()}
    else:
        errors = dict.fromkeys(features, number(given, place))
    for name, most in errors.items():
        if most < 0:
            raise InputError(f"the error of {name} is below 0", place, "write the largest absolute value")
    return errors


def robust_of(table: Mapping[str, object], statement: Statement, where: Place) -> Robust:
    """A claim of a property table. InputError with the place of what is wrong."""
    agent = text(table.get("agent", ""), where / "agent")
    copy = copy_called(agent)
    agents = {each.name: each for each in statement.agents}
    doubled = [each.like for each in statement.agents if each.name == copy_called(each.like)]
    if agent not in doubled:
        raise UnknownNameError("agent with a copy", agent, doubled, where / "agent")
    output = text(table.get("output", ""), where / "output")
    if output not in agents[agent].outputs:
        raise UnknownNameError("output", output, agents[agent].outputs, where / "output")
    if "most" not in table:
        raise InputError(f"{NAME} needs the largest change of the output", where, "write most = 0.2")
    most = number(table["most"], where / "most")
    added = set(statement.acting[agent].features) if agent in statement.acting else set[str]()
    features = {name: each for name, each in statement.system.features[agent].items() if name not in added}
    errors = errors_of(table, features, where)
    _ensure_copied(statement, agent, features, errors, where)
    bounds = {f"{copy}.{name}": (-size, size) for name, size in errors.items()}
    for name in statement.names.known:
        if name.startswith(f"{copy}."):
            bounds.setdefault(name, (Fraction(0), Fraction(0)))
    told = ", ".join(f"{name} off by up to {plain(size)}" for name, size in errors.items())
    formula = f"|out({copy}).{output} - out({agent}).{output}| <= {plain(most)}"
    return Robust(formula, box_of(bounds), told)


def _ensure_copied(
    statement: Statement, agent: str, names: Iterable[str], errors: Mapping[str, Fraction], where: Place
) -> None:
    """InputError where a copy observes anything but the features `names` of its own, those of `errors` with them."""
    features, copy = statement.system.features, copy_called(agent)
    known = {each.name: each.range for each in statement.system.variables}
    for name in names:
        variable, size = f"{copy}.{name}", errors.get(name)
        own, off = features[agent][name], features[copy][name]
        erring = [own.form.plus(Affine.of({variable: Fraction(1)}))] if variable in known else []
        allowed = erring if size is not None else [own.form, *erring]  # an error that is not named is bounded to 0
        if off.form not in allowed or off.measure is not own.measure or off.bounds != own.bounds:
            if size is None:
                advice = "observe the same, or name it in eps"
                raise InputError(f"{copy} does not observe {name} as {agent} does", where, advice)
            advice = f'state it: {name} = "... + {variable}", with {variable} among the variables'
            raise InputError(f"{copy} does not observe {name} with an error {variable}", where, advice)
        if size is not None and not known[variable][0] <= -size <= size <= known[variable][1]:
            raise InputError(f"errors up to {plain(size)} are not within the range of {variable}", where / "eps")
