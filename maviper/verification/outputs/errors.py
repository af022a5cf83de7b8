"""How far the outputs of an agent may change where its observations are off, as a table.

Does: reads what errors are meant; sums up the ends of outputs around observations; makes the table.
Assumes: observations that were read (robust.py).
Does not: compute ends (verify.extent), or prove.
"""

import csv
import io
import math
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import ROUND_CEILING, Context
from fractions import Fraction
from typing import Any

from codegen.errors import InputError, UnknownNameError
from codegen.ir import AgentPolicy
from codegen.wording import format_count
from verify.decimals import exact, plain
from verify.extent.changes import Ends, ends_of

HEADER = ("row", "output", "value", "least", "most", "change", "exact")
MARK = "changes.csv"
OPTION = "--error"
UP = Context(prec=6, rounding=ROUND_CEILING)


@dataclass(frozen=True)
class Changes:
    """How far each output of an agent may change around the observations of a file, in its order."""

    policy: AgentPolicy
    observations: tuple[tuple[float, ...], ...]  # [n, n_features]
    errors: tuple[Fraction, ...]  # [n_features] the largest of each feature
    ends: tuple[tuple[Ends, ...], ...]  # [n, n_outputs]

    @property
    def line(self) -> str:
        """What sums them up: the largest change of each output, with six digits, never less than it is."""
        parts: list[str] = []
        for place, output in enumerate(self.policy.outputs):
            most = max((each[place] for each in self.ends), key=lambda one: one.change)
            size = _spell_up(most.change) if math.isfinite(most.change) else "any amount"
            unit = f" {output.unit}" if output.unit not in ("", "none") else ""
            parts.append(f"{output.name} changes by at most {size}{unit}")
        return f"{self.policy.agent}, {format_count(len(self.ends), 'observation')}: {', '.join(parts)}"

    @property
    def largest(self) -> float:
        """No output changes by more at any of the observations; infinite where nothing is known."""
        return max(each.change for row in self.ends for each in row)

    @property
    def largest_seen(self) -> float:
        """By so much an output does change."""
        return max(each.change_seen for row in self.ends for each in row)

    @property
    def exact(self) -> bool:
        """Whether all changes are met by observations, so that none is a bound only."""
        return all(each.exact for row in self.ends for each in row)

    def rows(self) -> list[dict[str, Any]]:
        """The table as plain data; what is not finite is null."""
        named = [
            (number, output.name, each)
            for number, row in enumerate(self.ends, 1)
            for output, each in zip(self.policy.outputs, row, strict=True)
        ]
        return [
            {"row": number, "output": name, "value": _finite(each.value), "least": _finite(each.least)}
            | {"most": _finite(each.most), "change": _finite(each.change), "exact": each.exact}
            for number, name, each in named
        ]

    def document(self) -> dict[str, Any]:
        """The table, the errors, and observations that give the least and the most that was seen, as plain data."""
        names = [feature.name for feature in self.policy.features]
        seen = [each for row in self.ends for each in row]
        rows = [
            row | {"lowest": list(each.lowest), "highest": list(each.highest), "seen": [*map(_finite, each.seen)]}
            for row, each in zip(self.rows(), seen, strict=True)
        ]
        errors = dict(zip(names, map(plain, self.errors), strict=True))
        return {"agent": self.policy.agent, "errors": errors, "largest": _finite(self.largest), "changes": rows}

    @property
    def files(self) -> dict[str, str]:
        """The table as CSV."""
        text = io.StringIO()
        table = csv.writer(text, lineterminator="\n")
        table.writerow(HEADER)
        table.writerows([*list(row.values())[:-1], "yes" if row["exact"] else "no"] for row in self.rows())
        return {MARK: text.getvalue()}


def _spell_up(size: float) -> str:
    """Six digits of a number, never less than it is."""
    near = f"{size:g}"
    return near if float(near) >= size else f"{float(UP.create_decimal_from_float(size)):g}"


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def read_errors(given: str, policy: AgentPolicy) -> tuple[Fraction, ...]:
    """The largest error of each feature: one number for all, or FEATURE=NUMBER with commas, others being 0. InputError
    for anything else.
    """
    names = [feature.name for feature in policy.features]
    if "=" not in given:
        errors = dict.fromkeys(names, exact(given, OPTION))
    else:
        errors: dict[str, Fraction] = {}
        for part in given.split(","):
            name, _, number = (each.strip() for each in part.partition("="))
            if name not in names:
                raise UnknownNameError("feature", name, names, OPTION)
            if name in errors:
                raise InputError(f"{name} is given twice", OPTION, "give each feature once")
            errors[name] = exact(number, f"{OPTION}: {name}")
    for name, most in errors.items():
        if most < 0:
            raise InputError(f"the error of {name} is below 0", OPTION, "write the largest absolute value")
    return tuple(errors.get(name, Fraction(0)) for name in names)


def find_changes(policy: AgentPolicy, observations: Sequence[tuple[float, ...]], errors: Sequence[Fraction]) -> Changes:
    """Finds how far each output may change around each observation."""
    ends = tuple(ends_of(policy, each, errors) for each in observations)
    return Changes(policy, tuple(observations), tuple(errors), ends)
