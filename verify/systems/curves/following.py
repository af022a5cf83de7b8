"""A formula that names next values, such as `x' <= 2`, by two that do not: by what rules make of a state.

Does: puts the rule of each piece, under each joint action, in the place of next values, with the worst and the best of
  its error.
Assumes: pieces of a checked system; what they say holds of every step (the rules, or enclosures of these).
Does not: enclose rules, or decide.

A claim about a next value is one about all errors, all choices and all pieces that hold a state. A formula that holds
with the worst error of each comparison is true of all of them. Where rules are as they are written, one that holds at
the ends of all errors is implied by it; where they are enclosures, one with the best error of each comparison is.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from functools import partial
from itertools import product
from math import prod

from codegen.errors import InputError
from codegen.ir import AgentPolicy
from verify.claims.formula import Acts, Formula, Linear, atoms, conjunction, disjunction, negate
from verify.claims.formula import normal as pushed
from verify.language.parser import PRIME
from verify.systems.claims import atom
from verify.systems.curves.formulas import beyond, with_comparisons
from verify.systems.system import Affine, HalfSpace, Interval, Piece, Variable

MAX_PARTS = 20_000  # of a formula: pieces times joint actions
MAX_ENDS = 4  # variables whose errors are taken to both ends
Worst = Callable[[Iterable[Fraction]], Fraction]  # of what errors add to a comparison
Action = Mapping[str, str]  # what each agent that matters does


def name_next_values(variables: Sequence[Variable]) -> dict[str, str]:
    """The names of next values, and whose they are. A mode has none: it is no number."""
    return {one.name + PRIME: one.name for one in variables if not one.modes}


def without_next(
    formula: Formula,
    pieces: Sequence[Piece],
    following: Mapping[str, str],
    acting: Mapping[str, AgentPolicy],
    exact: bool,
    where: object,
) -> tuple[Formula, Formula]:
    """A formula without next values that implies this one, and one that it implies. `exact`: pieces are the rules as
    they are written. InputError with `where` for too many pieces and actions.
    """
    stated = pushed(formula)
    terms = [name for part in atoms(stated) if isinstance(part, Linear) for _, name in part.terms]
    named = sorted({following[name] for name in terms if name in following})
    moving = [agent for agent in acting if any(_moves(piece, agent, named) for piece in pieces)]
    parts = len(pieces) * prod(len(acting[agent].actions) for agent in moving)
    if parts > MAX_PARTS:
        advice = "name fewer next values, or state the claim about fewer agents"
        raise InputError(f"{parts:,} pieces and joint actions, of at most {MAX_PARTS:,}", where, advice)
    both: tuple[list[Formula], list[Formula]] = ([], [])
    for piece in pieces:
        beyond = _beyond(piece)
        for actions in _joint(moving, acting):
            done = [negate(Acts(agent, _number(acting[agent], name))) for agent, name in actions.items()]
            after = {name + PRIME: _after(piece, name, actions) for name in named}
            errors = {name + PRIME: piece.error[name] for name in named if name in piece.error}
            surely = _put(stated, after, errors, max)
            maybe = conjunction(*_iterate_implied(stated, after, errors, exact))
            for formulas, held in zip(both, (surely, maybe), strict=True):
                formulas.append(disjunction(beyond, *done, held))
    return conjunction(*both[0]), conjunction(*both[1])


def _moves(piece: Piece, agent: str, named: Sequence[str]) -> bool:
    return any(one == agent and forms.keys() & {*named} for (one, _), forms in piece.effect.items())


def _joint(moving: Sequence[str], acting: Mapping[str, AgentPolicy]) -> Iterator[Action]:
    for names in product(*([action.name for action in acting[agent].actions] for agent in moving)):
        yield dict(zip(moving, names, strict=True))


def _number(policy: AgentPolicy, name: str) -> int:
    return [action.name for action in policy.actions].index(name)


def _after(piece: Piece, name: str, actions: Action) -> Affine:
    """The next value of a variable, without its error."""
    form = piece.move.get(name, Affine())
    for choice in actions.items():
        form = form.plus(piece.effect.get(choice, {}).get(name, Affine()))
    return form


def _beyond(piece: Piece) -> Formula:
    """That a state is none of a piece."""
    return disjunction(beyond(piece.where), *(negate(atom(half)) for half in piece.when))


def _iterate_implied(
    formula: Formula, after: Mapping[str, Affine], errors: Mapping[str, Interval], exact: bool
) -> Iterator[Formula]:
    """Yields what a formula implies in a piece: itself at the ends of all errors; for enclosures, with the best."""
    if not exact:
        yield _put(formula, after, errors, min)
        return
    ends = [[(name, end) for end in dict.fromkeys(bounds)] for name, bounds in errors.items()]
    for chosen in product(*ends) if len(ends) <= MAX_ENDS else zip(*ends, strict=False):
        yield _put(formula, after, {name: (end, end) for name, end in chosen}, max)


def _put(formula: Formula, after: Mapping[str, Affine], errors: Mapping[str, Interval], worst: Worst) -> Formula:
    """A formula whose negations stand before actions alone, with forms in place of next values."""
    return with_comparisons(formula, partial(_rewrite_comparison, after=after, errors=errors, worst=worst))


def _rewrite_comparison(
    one: Linear, after: Mapping[str, Affine], errors: Mapping[str, Interval], worst: Worst
) -> Formula:
    total = Affine.of({}, -one.bound)
    for weight, name in one.terms:
        if name not in after:
            total = total.plus(Affine.of({name: Fraction(1)}), weight)
            continue
        total = total.plus(after[name], weight)
        if name in errors:
            total = total.plus(Affine.of({}, worst(weight * end for end in errors[name])))
    return atom(HalfSpace(total, one.strict))
