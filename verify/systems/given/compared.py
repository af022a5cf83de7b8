"""Formulas about what agents of a world file observe: numbers beside a feature as the agents compare them.

Does: finds the variables that are features, and what their agents compare; reads formulas about these.
Assumes: a feature is the exact value of a variable, rounded once.
Does not: touch variables of which agents observe sums or functions alone.
"""

from collections.abc import Callable, Iterable
from fractions import Fraction
from functools import partial
from math import inf

from codegen.ir import AgentPolicy
from codegen.numbers import nearest_number, neighbour
from verify.claims.formula import Formula, Linear, negate
from verify.claims.language.compared import Compared, read_as_compared
from verify.claims.language.formulas import StatedFormula, Vocabulary, read_statement
from verify.claims.uncertified.views import UNLIKE
from verify.systems.statement import Statement
from verify.systems.system import Affine, Measure


def find_numbers(statement: Statement, policies: Iterable[AgentPolicy]) -> dict[str, str]:
    """What the agents that observe each variable compare: float32 or float64; UNLIKE where some compare either."""
    by_variable: dict[str, str] = {}
    for policy in policies:
        read = statement.acting.get(policy.agent)
        numbers = policy.numbers if read is None else read.real.numbers
        for feature in statement.system.features[policy.agent].values():
            name = next((name for name, _ in feature.form.terms), "")
            if feature.measure is Measure.VALUE and feature.form == Affine.of({name: Fraction(1)}):
                by_variable[name] = UNLIKE if by_variable.get(name, numbers) != numbers else numbers
    return by_variable


def read_observed(text: str, vocabulary: Vocabulary, where: Callable[[int], str]) -> StatedFormula:
    """What a text states, of which the vocabulary knows the features. InputError as of `read_statement`."""
    known = {
        name: compare_variable(name, numbers) for name, numbers in vocabulary.observed.items() if numbers != UNLIKE
    }
    stated = read_statement(text, vocabulary, where)
    return stated.read_by(partial(read_as_compared, known=known)) if known else stated


def compare_variable(name: str, numbers: str) -> Compared:
    """How agents compare a variable, whose exact value is rounded once, to the nearest float."""

    def cut(threshold: float) -> tuple[Formula, Formula]:
        end = (Fraction(threshold) + Fraction(float(neighbour(threshold, inf, numbers)))) / 2
        at_most = Linear(((Fraction(1), name),), end, nearest_number(end, numbers) > threshold)
        return at_most, negate(at_most)

    return Compared(numbers, cut)
