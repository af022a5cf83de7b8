"""Whether a query to Z3 is too large to be written within a question's budget.

Does: counts the tests of trees that a query would state, before anything is written.
Assumes: a formula whose parts about one agent's action each follow that agent's tree once (encode.py).
Does not: bound the search in Z3, which has resource units of its own (solve.py).
"""

from collections.abc import Iterator

from verify.claims.formula import And, Formula, Not, Or, agents
from verify.question import DecisionQuestion

MAX_TESTS = 280_000  # of trees that a query states: half a minute, and below two gigabytes with the solver's own copy
FEW_TESTS = 20_000  # that any budget allows
UNITS_A_TEST = 64  # of a budget in solver units: so many allow one test more


def beyond_budget(question: DecisionQuestion) -> str:
    """Why a question is too large for its budget to be written down; "" where it is not."""
    tests = _tests(question)
    most = min(MAX_TESTS, max(FEW_TESTS, question.budgets.solver_units // UNITS_A_TEST))
    return f"a query with {tests:,} tests of trees, more than {most:,}, is not asked" if tests > most else ""


def beyond_any(question: DecisionQuestion) -> bool:
    """Returns True if no budget allows the question to be written down."""
    return _tests(question) > MAX_TESTS


def _tests(question: DecisionQuestion) -> int:
    """The tests of trees that a query states."""
    lone = dict.fromkeys(_lone(question.formula))  # each follows its agent's tree
    return sum(len(question.profile.policy(next(iter(agents(part)))).tree.left) // 2 for part in lone)


def _lone(formula: Formula) -> Iterator[Formula]:
    """The largest parts of a formula that speak of one agent's action."""
    acting = agents(formula)
    if len(acting) == 1:
        yield formula
    elif acting:
        for part in (
            formula.parts if isinstance(formula, (And, Or)) else [formula.part] if isinstance(formula, Not) else []
        ):
            yield from _lone(part)
