"""What a claim about a stated system says, in words that are made from its data alone.

Does: spells a claim with its regions, ranges and formula.
Assumes: claims.py.
Does not: decide, or read files.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction

from verify.claims.formula import Acts, And, Formula, Goal, Linear, Not, Or, coordinates
from verify.decimals import MAX_PLACES, plain
from verify.systems.claims import SystemClaim, atom
from verify.systems.system import Affine, HalfSpace, Interval, Polytope

EVERY_FLOAT = 1_074  # places of a float64 at most: formulas take no fractions of numbers that large


def spell_claim(claim: SystemClaim, actions: Mapping[str, Sequence[str]], ranges: Mapping[str, Interval]) -> str:
    """The claim in words that are made from its data alone, as a file's own words may say anything. `actions`: of each
    agent, by number. `ranges`: of the system's variables, which bound what a claim about decisions says.
    """
    regions = " or ".join(_conditions(region) for region in claim.regions)
    if not claim.about_decisions:
        return replace(claim, region=regions).sentence
    named = coordinates(claim.formula).union(*(coordinates(atom(half)) for region in claim.regions for half in region))
    bounds = ", ".join(
        f"{name} in [{plain(low)}, {plain(high)}]" for name, (low, high) in ranges.items() if name in named
    )
    where = "of the ranges" + (f" ({bounds})" if bounds else "") + (f" with {regions}" if regions else "")
    return f"in every state {where}, {spell_formula(claim.formula, actions)}"


def _conditions(region: Polytope) -> str:
    return " and ".join(map(_condition, region)) or "any state"


def _condition(half: HalfSpace, places: int = MAX_PLACES) -> str:
    """An inequality whose first factor is 1. `places`: of decimals at most, what needs more is a fraction."""
    lead = half.form.terms[0][1] if half.form.terms else Fraction(1)
    form = Affine().plus(half.form, 1 / lead)
    sign = f"{'<' if lead > 0 else '>'}{'' if half.strict else '='}"
    return f"{_sum(form.terms, places)} {sign} {plain(-form.constant, places)}"


def _sum(terms: Sequence[tuple[str, Fraction]], places: int) -> str:
    text = ""
    for name, factor in terms:
        times = name if abs(factor) == 1 else f"{plain(abs(factor), places)}*{name}"
        sign = "-" if factor < 0 else "+"
        text += f" {sign} {times}" if text else times if factor > 0 else f"-{times}"
    return text or "0"


def spell_formula(formula: Formula, actions: Mapping[str, Sequence[str]]) -> str:
    """A formula in the language of property files. `actions`: of each agent, by number."""
    match formula:
        case Linear(terms, bound, strict):
            half = HalfSpace(Affine.of({name: factor for factor, name in terms}, -bound), strict)
            return _condition(half, EVERY_FLOAT)
        case Acts(agent, action):
            return f"acts({agent}) == {actions[agent][action]}"
        case Not(part):
            return f"not {spell_formula(part, actions)}"
        case And(()) | Or(()):
            return "true" if isinstance(formula, And) else "false"
        case And(parts) | Or(parts):
            joined = f" {'and' if isinstance(formula, And) else 'or'} ".join(
                spell_formula(part, actions) for part in parts
            )
            return f"({joined})"
        case Goal(landmark):
            return f"goal == {landmark}"
