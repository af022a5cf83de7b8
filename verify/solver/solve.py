"""Asking Z3, with a budget that does not depend on the machine.

Does: decides a question, returns an exact model or the reason why there is no answer.
Assumes: budgets are Z3 resource counts, which repeat from run to run; there is no wall clock.
Does not: interpret models.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import cast

import z3

from verify.question import Budgets
from verify.solver.encode import Query


@dataclass(frozen=True)
class Answer:
    """`holds` is True (satisfiable), False (not) or None (budget ended); `model` gives every position exactly."""

    holds: bool | None
    model: dict[str, Fraction] | None
    resources: int
    reason: str = ""


def solver_name() -> str:
    """The solver and its version."""
    return f"Z3 {z3.get_version_string()}"


@dataclass(frozen=True)
class BitsAnswer:
    """An answer like Answer, whose `model` gives constants of bits, as unsigned numbers."""

    holds: bool | None
    model: dict[str, int] | None
    resources: int
    reason: str = ""


def ask(query: Query, budget: int = Budgets().solver_units) -> Answer:
    """Asks whether the question's constraints can hold together; no answer where they were not written."""
    if query.beyond:
        return Answer(None, None, 0, query.beyond)
    context = z3.Context()  # a fresh one, so that earlier questions leave no trace in the search or the count
    constraints = [constraint.translate(context) for constraint in query.constraints]
    holds, model, spent, reason = _run_solver("QF_LRA", context, constraints, budget)
    if model is None:
        return Answer(holds, None, spent, reason)
    variables = {name: variable.translate(context) for name, variable in query.variables.items()}
    # the numbers in models of linear arithmetic are rationals
    values = {
        name: cast(z3.RatNumRef, model.eval(variable, model_completion=True)) for name, variable in variables.items()
    }
    exact = {name: Fraction(value.numerator_as_long(), value.denominator_as_long()) for name, value in values.items()}
    return Answer(True, exact, spent)


def ask_bits(text: str, names: Sequence[str], budget: int = Budgets().solver_units) -> BitsAnswer:
    """Asks whether the assertions of an SMT-LIB text about floats and bits can hold together; the model gives the
    constants `names`, 0 for what does not matter.
    """
    context = z3.Context()
    holds, model, spent, reason = _run_solver("QF_FPBV", context, z3.parse_smt2_string(text, ctx=context), budget)
    if model is None:
        return BitsAnswer(holds, None, spent, reason)
    values = {constant.name(): cast(z3.BitVecNumRef, model[constant]) for constant in model.decls()}
    return BitsAnswer(True, {name: values[name].as_long() if name in values else 0 for name in names}, spent)


def _run_solver(
    logic: str, context: z3.Context, constraints: Sequence[z3.BoolRef] | z3.AstVector, budget: int
) -> tuple[bool | None, z3.ModelRef | None, int, str]:
    """Satisfiable or not (None: budget ended), a model, resources spent, and why there is no answer."""
    solver = z3.SolverFor(logic, ctx=context)
    solver.set("rlimit", budget)
    solver.set("random_seed", 0)
    solver.add(*constraints)
    result = solver.check()
    spent = _count_units(solver)
    if result == z3.unknown and "interrupted" in solver.reason_unknown():
        raise KeyboardInterrupt  # Ctrl-C during the search, which the solver catches itself
    if result == z3.unknown:
        return None, None, spent, solver.reason_unknown()
    return result == z3.sat, solver.model() if result == z3.sat else None, spent, ""


def smt_lib(query: Query) -> str:
    """The question as SMT-LIB 2, for any solver; equal questions give equal texts. Not for one that was not written."""
    assert not query.beyond, query.beyond
    context, known = z3.Context(), dict[int, tuple[z3.ExprRef, z3.ExprRef]]()
    solver = z3.SolverFor("QF_LRA", ctx=context)
    standard = [_standard(constraint.translate(context), known) for constraint in query.constraints]
    solver.add(*cast("list[z3.BoolRef]", standard))
    return solver.to_smt2()


_JOINED: dict[int, Callable[..., z3.ExprRef]] = {z3.Z3_OP_AND: z3.And, z3.Z3_OP_OR: z3.Or, z3.Z3_OP_ADD: z3.Sum}


def _standard(term: z3.ExprRef, known: dict[int, tuple[z3.ExprRef, z3.ExprRef]]) -> z3.ExprRef:
    """The term without sums, conjunctions and disjunctions of fewer than two parts, which SMT-LIB does not have.

    `known`: terms by their ids, which stay theirs while they are kept, and what became of them.
    """
    place = term.get_id()
    if place not in known:
        before, kind = term.children(), term.decl().kind()
        parts = [_standard(part, known) for part in before]
        if kind in _JOINED and len(parts) < 2:
            made = parts[0] if parts else z3.BoolVal(kind == z3.Z3_OP_AND, ctx=term.ctx)
        elif [part.get_id() for part in parts] == [part.get_id() for part in before]:
            made = term
        else:
            made = _JOINED.get(kind, term.decl())(*parts)
        known[place] = term, made
    return known[place][1]


def _count_units(solver: z3.Solver) -> int:
    statistics = solver.statistics()
    return int(statistics.get_key_value("rlimit count")) if "rlimit count" in statistics.keys() else 0  # noqa: SIM118


def false_facts(definitions: str, facts: Sequence[str]) -> list[int]:
    """Lists, by place, those SMT-LIB formulas without variables that do not hold, given definitions."""
    text = definitions + "\n".join(f"(assert {fact})" for fact in facts)
    parsed = z3.parse_smt2_string(text, ctx=z3.Context())
    return [place for place in range(len(parsed)) if not z3.is_true(z3.simplify(parsed[place]))]
