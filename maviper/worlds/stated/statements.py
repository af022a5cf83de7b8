"""Findings on a world file: what it states, whether its enclosures hold, how far it is from its reference.

Does: one finding for each thing that was looked at; enclosures are those that the checker shows again.
Assumes: a file that could be read.
Does not: print or play.
"""

from collections.abc import Iterator

from codegen.wording import format_count
from maviper.worlds.findings import Finding, Mark
from maviper.worlds.stated.deviation import deviation
from maviper.worlds.stated.integrating import check_integration
from maviper.worlds.stated.reference import is_known
from verify.checker.reading import RejectedError
from verify.checker.systems.enclosures import ensure_enclosed
from verify.decimals import plain
from verify.systems.properties import ensure_claims
from verify.systems.statement import Statement

NO_CLAIMS = "add [[property]], or give `maviper verify` a file of them"


def check_statement(statement: Statement) -> Iterator[Finding]:
    """Lists what a file states."""
    system = statement.system
    yield Finding(Mark.OK, f"file: {system.name}, units fit, and every number is exact")
    variables = ", ".join(f"{each.name} {each.unit}".removesuffix(" 1") for each in system.variables)
    yield Finding(Mark.OK, f"variables: {variables}")
    sizes = ", ".join(
        f"{agent.name} {len(system.features[agent.name])} and {len(agent.actions)}" for agent in statement.agents
    )
    yield Finding(Mark.OK, f"features and actions: {sizes}")
    claims = ensure_claims(statement, system.name)
    yield Finding(Mark.OK, f"claims: {claims}") if claims else Finding(Mark.MISSING, "claims: none", NO_CLAIMS)
    if not statement.moves:
        said = "dynamics: none, so claims are about single decisions"
        yield Finding(Mark.MISSING, said, "add [dynamics.next] or [dynamics.flow] for claims about episodes")
        return
    if system.flow is not None:
        told = f"{format_count(len(system.flow.rates), 'derivative')}, a period of {plain(system.flow.period)} s"
        yield Finding(Mark.OK, f"flow: {told}, {format_count(system.steps, 'period')}")
        yield check_integration(statement)
        return
    pieces = "one piece" if len(system.pieces) == 1 else f"{len(system.pieces)} pieces"
    yield Finding(Mark.OK, f"dynamics: {pieces}, {format_count(system.steps, 'step')}")
    yield _check_enclosures(statement)


def _check_enclosures(statement: Statement) -> Finding:
    """Checks by the checker that the pieces hold what the rules say."""
    try:
        shown = ensure_enclosed(statement)
    except RejectedError as error:
        return Finding(Mark.WRONG, f"enclosures: {error}", "cut the ranges of more variables, or into more parts")
    return Finding(Mark.OK, f"enclosures: {shown} bounds shown" if shown else "enclosures: none, every rule is affine")


def measure_reference(statement: Statement, run: bool) -> Iterator[Finding]:
    """Measures the distance of a statement from its reference. `run`: also where that is code that the file names."""
    name = statement.system.reference
    if not (run or is_known(name)):
        said = f"reference: {name} is code that the file names, and was not run"
        yield Finding(Mark.MISSING, said, "add --run-reference to run it and measure the statement")
        return
    measurement = deviation(statement)
    reach = ", ".join(f"{name} [{low:.2g}, {high:.2g}]" for name, (low, high) in measurement.off.items())
    where = "all over the ranges" if measurement.placed else "where its episodes lead"
    yield Finding(Mark.OK, f"reference: {name}, {measurement.steps} steps {where}, off by {reach}")
    if measurement.outside:
        yield Finding(Mark.MISSING, f"reference: {measurement.outside} steps began where nothing is stated")
    if measurement.beyond:
        advice = "widen the error of the variable, narrow its range, or mend the rule"
        yield Finding(
            Mark.WRONG, f"reference: {measurement.beyond} steps beyond the stated error; {measurement.worst}", advice
        )
    else:
        yield Finding(Mark.OK, "error: no step is off by more than stated")
