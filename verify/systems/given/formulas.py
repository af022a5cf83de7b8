"""Formulas about what agents of a world file observe and give.

Does: numbers beside a feature as the agents compare them; `out(AGENT).OUTPUT` in a text as the input that it is, and
  each comparison with an input as one for each action, of the affine form that the action sets it to.
Assumes: a feature is the exact value of a variable, rounded once; a statement whose agents that give numbers were read
  with a profile (agents.py).
Does not: read formulas, or touch variables of which agents observe sums or functions alone.
"""

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from fractions import Fraction
from functools import partial
from math import inf

from codegen.errors import InputError
from codegen.ir import AgentPolicy
from codegen.numbers import nearest_number, neighbour
from verify.claims.formula import Acts, And, Formula, Linear, Not, Or, below, conjunction, disjunction, negate
from verify.claims.language.compared import Compared, read_as_compared
from verify.claims.language.formulas import StatedFormula, Vocabulary, read_statement
from verify.claims.wording.views import UNLIKE
from verify.systems.language.expressions import affine
from verify.systems.statement import Agent, Statement
from verify.systems.system import Affine, Measure
from verify.toml_places import Place


def find_numbers(statement: Statement, policies: Iterable[AgentPolicy]) -> dict[str, str]:
    """Returns what the agents that observe a variable compare: float32 or float64; UNLIKE where some compare either."""
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
    """Reads a text of which the vocabulary knows the features. InputError as of `read_statement`."""
    known = {
        name: compare_variable(name, numbers) for name, numbers in vocabulary.observed.items() if numbers != UNLIKE
    }
    stated = read_statement(text, vocabulary, where)
    return stated.read_by(partial(read_as_compared, known=known)) if known else stated


def compare_variable(name: str, numbers: str) -> Compared:
    """Returns the comparison of a variable by agents, whose exact value is rounded once, to the nearest float."""

    def cut(threshold: float) -> tuple[Formula, Formula]:
        end = (Fraction(threshold) + Fraction(float(neighbour(threshold, inf, numbers)))) / 2
        at_most = Linear(((Fraction(1), name),), end, nearest_number(end, numbers) > threshold)
        return at_most, negate(at_most)

    return Compared(numbers, cut)


GIVEN = re.compile(r"\bout\(\s*([A-Za-z][A-Za-z0-9_]*)\s*\)\s*\.\s*([A-Za-z_][A-Za-z0-9_]*)")

CHOSEN = re.compile(r"\bacts\(\s*'?([A-Za-z][A-Za-z0-9_-]*)'?\s*\)")


def name_inputs(text: str) -> str:
    """The text with `out(AGENT).OUTPUT` as `AGENT.OUTPUT`, of the same length, so that places in it stay."""
    return GIVEN.sub(lambda match: f"{match[1]}.{match[2]}".ljust(len(match[0])), text)


def spell_inputs(text: str, statement: Statement) -> str:
    """The text with `AGENT.OUTPUT` as `out(AGENT).OUTPUT`."""
    for agent in statement.agents:
        for output in agent.outputs:
            text = re.sub(rf"\b{re.escape(agent.name)}\.{re.escape(output)}\b", f"out({agent.name}).{output}", text)
    return text


def ensure_choosing(text: str, statement: Statement, where: Place) -> None:
    """InputError where a text asks for the action of an agent that gives numbers."""
    giving = {each.name: each.outputs for each in statement.agents if each.outputs}
    for match in CHOSEN.finditer(text):
        if match[1] in giving:
            what = f"{match[1]} gives numbers, and takes no action"
            advice = " or ".join(f"out({match[1]}).{output}" for output in giving[match[1]])
            raise InputError(what, where.of_offset(text, match.start()), f"compare {advice}")


def of_actions(formula: Formula, statement: Statement, acting: Mapping[str, AgentPolicy], where: Place) -> Formula:
    """The formula without inputs. InputError for an input that some action sets to what is not affine."""
    if isinstance(formula, Linear):
        return _rewrite_comparison(formula, statement, acting, where)
    if isinstance(formula, And):
        return conjunction(*(of_actions(part, statement, acting, where) for part in formula.parts))
    if isinstance(formula, Or):
        return disjunction(*(of_actions(part, statement, acting, where) for part in formula.parts))
    return Not(of_actions(formula.part, statement, acting, where)) if isinstance(formula, Not) else formula


def _rewrite_comparison(
    formula: Linear, statement: Statement, acting: Mapping[str, AgentPolicy], where: Place
) -> Formula:
    """One comparison: whatever the action is, the comparison of what it sets."""
    agent = next((each for _, name in formula.terms for each in statement.agents if name in each.inputs), None)
    if agent is None:
        return formula
    own = {name: weight for weight, name in formula.terms if name in agent.inputs}
    parts: list[Formula] = []
    for number, action in enumerate(acting[agent.name].actions):
        form = Affine.of({name: weight for weight, name in formula.terms if name not in own}, -formula.bound)
        for name, weight in own.items():
            added = affine(agent.actions[action.name][name])
            if added is None:
                what = f"{name} is not affine in the state where {agent.name} does {action.name}"
                raise InputError(what, where, "compare what is affine")
            form = form.plus(added, Fraction(weight))
        kept = below(dict(form.terms), -form.constant, formula.strict)
        inner = of_actions(kept, statement, acting, where)
        beyond = [each for name in own for each in _beyond(statement, agent, action.name, name)]
        parts.append(disjunction(Not(Acts(agent.name, number)), *beyond, inner))
    return conjunction(*parts)


def _beyond(statement: Statement, agent: Agent, action: str, name: str) -> Iterator[Formula]:
    """The states in which an action would set an output beyond its bounds: no real agent takes it there."""
    form = affine(agent.actions[action][name])
    if agent.name not in statement.acting or form is None or not form.terms:
        return
    real = statement.acting[agent.name].real
    spec = next((each for each in real.outputs if f"{agent.name}.{each.name}" == name), None)
    if spec is None:  # what an action sets is not cut
        return
    if spec.high is not None:
        yield below({each: -weight for each, weight in form.terms}, form.constant - Fraction(spec.high), strict=True)
    if spec.low is not None:
        yield below(dict(form.terms), Fraction(spec.low) - form.constant, strict=True)
