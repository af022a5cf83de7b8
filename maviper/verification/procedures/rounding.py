"""Whether a claim about decisions fails only where a variable is rounded when it is observed.

Does: asks the claim again with one bound moved to the next float beyond it; says with which bound it is proved.
Assumes: a violated claim about a stated system, whose numbers are exact.
Does not: decide. A claim that fails elsewhere too is left as it is.

`x < 80` holds at 80 - 1e-15, which an agent reads as 80. So `x < 80 implies acts(A) == low` fails for a tree that tests
just this, and is proved of `x <= 79.99999999999999`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from fractions import Fraction
from functools import partial
from math import inf
from typing import TYPE_CHECKING

from codegen.numbers import nearest_number, neighbour
from maviper.verification.procedures.conditions import answer_alone
from verify.claims.formula import Linear, atoms, below, normal
from verify.claims.language.compared import last_of
from verify.decimals import plain
from verify.result import Verdict
from verify.systems.claims import SystemClaim
from verify.systems.curves.formulas import with_comparisons
from verify.systems.given.compared import find_numbers
from verify.verdicts.systems import SystemResult

if TYPE_CHECKING:
    from maviper.verification.stated import StatedWorld

MOST = 16  # bounds that are tried
SAID = "fails only where {name} is rounded when it is observed: proved with {moved} in place of {stated}"


def with_bound(result: SystemResult, world: StatedWorld) -> SystemResult:
    """The result, which says from which bound on its claim is proved, where only rounding makes it fail."""
    claim = result.claim
    if result.verdict is not Verdict.VIOLATED or not claim.about_decisions or claim.curved or world.statement.observed:
        return result
    numbers = find_numbers(world.statement, world.origin.agents)
    for stated, moved in list(_iterate_moved(claim, numbers))[:MOST]:
        formula = with_comparisons(normal(claim.formula), partial(_move, stated, moved))
        again = answer_alone(result.question, replace(claim, formula=formula), world)
        if again.verdict is Verdict.PROVED:
            left = any(stated in atoms(condition.claim.formula) for condition in claim.conditions)
            said = SAID.format(
                name=", ".join(name for _, name in stated.terms), moved=_spell(moved, left), stated=_spell(stated, left)
            )
            return replace(result, evidence=replace(result.evidence, rounding=said))
    return result


def _move(stated: Linear, moved: Linear, atom: Linear) -> Linear:
    return moved if atom == stated else atom


def _iterate_moved(claim: SystemClaim, numbers: Mapping[str, str]) -> Iterator[tuple[Linear, Linear]]:
    """Each bound on a variable that is observed, and the weaker one at the next float beyond what is read as it."""
    for atom in dict.fromkeys(atoms(normal(claim.formula))):
        if not isinstance(atom, Linear) or len(atom.terms) != 1:
            continue
        ((weight, name),) = atom.terms
        if not numbers.get(name):
            continue
        kind, bound = numbers[name], atom.bound / abs(weight)  # of the variable, or of its opposite
        end = bound if atom.strict else max(bound, Fraction(nearest_number(bound, kind)))
        after = float(neighbour(last_of(end, kind, below=atom.strict), inf, kind))
        moved = below({name: 1 if weight > 0 else -1}, Fraction(repr(after)), strict=True)
        if moved != atom and isinstance(moved, Linear):
            yield atom, moved


def _spell(atom: Linear, left: bool) -> str:
    """A bound in words; its opposite where it is of the left side of an implication."""
    ((weight, name),) = atom.terms
    low, strict = (weight < 0) != left, atom.strict != left
    return f"{name} {'>' if low else '<'}{'' if strict else '='} {plain(atom.bound / weight)}"
