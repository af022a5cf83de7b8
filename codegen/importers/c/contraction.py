"""Contraction: a compiler of C may round a product and the sum that follows it once instead of twice.

Does: steps that know their exact result; the same feature as a compiler that joins such pairs computes it.
Assumes: both steps are of one type, as C's rules for fused operations say.
Does not: decide whether that matters (arithmetic.py).
"""

import operator
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

import numpy as np

from codegen.importers.c.kinds import DOUBLE, Kind, round_number
from codegen.importers.symbolic.feature import FALLING, RISING, Feature, Step

FLOATING: Mapping[str, Callable[[Any, Any], Any]] = {
    "+": operator.add, "-": operator.sub, "*": operator.mul, "/": lambda a, b: a / b,
}  # fmt: skip
NEGATE = Step("negated", operator.neg, FALLING, form=("*", -1))


@dataclass(frozen=True)
class Rounding(Step):
    """A step that rounds an exact result, so that a compiler may join it with another one."""

    exact: Callable[[Fraction], Fraction] = field(default=lambda exact: exact, compare=False)
    kind: Kind = DOUBLE
    sums: bool = False  # whether it adds; else it multiplies


def make_step(sign: str, c: Any, kind: Kind, *, first: bool) -> Step:
    """Arithmetic of a feature, which stands `first` or last, and a number of its type."""
    make = kind.float_type
    compute, exact = FLOATING[sign], Fraction(float(c))

    def apply(v: Any) -> Any:
        return make(compute(make(v), c) if first else compute(c, make(v)))

    falls = (sign == "-" and not first) or (sign in "*/" and c < 0)
    key, sense = f"{sign}{c!r}{first}{kind}", FALLING if falls else RISING
    form = (sign if first or sign != "-" else "c-", c)
    if sign == "/":  # which no compiler joins with another step
        return Step(key, apply, sense, form=form)

    def precisely(v: Fraction) -> Fraction:
        return compute(v, exact) if first else compute(exact, v)

    return Rounding(key, apply, sense, precisely, kind, sign in "+-", form=form)


def contract_feature(feature: Feature) -> Feature | None:
    """The feature with each product kept exact until the sum that follows it; None: there is no such pair."""
    steps, product, pairs = list[Step](feature.steps), -1, 0
    for at, step in enumerate(feature.steps):
        before = feature.steps[product] if product >= 0 else None
        if isinstance(step, Rounding) and step.sums and isinstance(before, Rounding) and before.kind == step.kind:
            steps[product] = _exact(before)
            steps[at], pairs = _once(step), pairs + 1
        if not isinstance(step, Rounding) and step is not NEGATE:
            product = -1
        elif isinstance(step, Rounding):
            product = -1 if step.sums else at
    return Feature(feature.place, tuple(steps)) if pairs else None


def _exact(product: Rounding) -> Step:
    """A product without its rounding."""

    def apply(v: Any) -> Any:
        return product.exact(Fraction(float(v))) if np.isfinite(v) else product.apply(v)

    return Step(f"exactly {product.key}", apply, product.sense)


def _once(total: Rounding) -> Step:
    """A sum of an exact number."""

    def apply(v: Any) -> Any:
        return round_number(total.exact(v), total.kind) if isinstance(v, Fraction) else total.apply(v)

    return Step(f"once {total.key}", apply, total.sense)
