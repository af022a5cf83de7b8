"""Affine forms over the variables of a state, in exact numbers; intervals and boxes.

Does: the data; a form's value in a state; sums of forms.
Assumes: nothing.
Does not: know systems or expressions.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

State = Mapping[str, Fraction]
Interval = tuple[Fraction, Fraction]
Box = Mapping[str, Interval]  # closed; a variable that is not named is free


@dataclass(frozen=True)
class Affine:
    """A sum of multiples of variables and a constant: `terms` by name, in order, none of them 0."""

    terms: tuple[tuple[str, Fraction], ...] = ()
    constant: Fraction = Fraction(0)

    @staticmethod
    def of(terms: Mapping[str, Fraction], constant: Fraction = Fraction(0)) -> Affine:
        """The form with these terms, in the one order in which equal forms are equal data."""
        return Affine(tuple(sorted((name, factor) for name, factor in terms.items() if factor)), constant)

    def at(self, state: State) -> Fraction:
        """Its value in a state."""
        return self.constant + sum((factor * state[name] for name, factor in self.terms), Fraction(0))

    def plus(self, other: Affine, times: Fraction = Fraction(1)) -> Affine:
        """This form and a multiple of another."""
        if not other.terms:
            return Affine(self.terms, self.constant + (other.constant if times == 1 else times * other.constant))
        terms = dict(self.terms)
        for name, factor in other.terms:
            terms[name] = terms.get(name, Fraction(0)) + times * factor
        return Affine.of(terms, self.constant + times * other.constant)
