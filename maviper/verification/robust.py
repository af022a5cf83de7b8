"""How far features may be off around the observations of a file: radii of actions, changes of outputs.

Does: reads observations (CSV with a header, or a JSON list) and errors; for agents that take actions finds how far each
  observation may be off before another action is taken, and has that proved and checked; for agents that give numbers
  sums up the ends of outputs; makes the tables.
Assumes: a checked profile; numbers are float64, each read by the agent after rounding to its own.
Does not: compute ends (verify.extent), or know what an environment can show.
"""

import csv
import io
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from decimal import ROUND_CEILING, ROUND_FLOOR, Context
from fractions import Fraction
from functools import cached_property
from pathlib import Path
from typing import Any, cast

from codegen.deciding import ensure_floats, ensure_plain
from codegen.errors import InputError, UnknownNameError, escape_text
from codegen.ir import AgentPolicy, PolicyProfile
from codegen.profiles import ensure
from codegen.rows import Shown
from codegen.wording import format_count
from maviper.files import runs
from verify.certificates.games import to_json
from verify.checker.decisions import DecisionCertificate
from verify.claims.formula import Acts
from verify.claims.observed import View
from verify.claims.region import Interval, Region
from verify.claims.views import Viewed
from verify.claims.wording import OwnFormula
from verify.decimals import exact, plain
from verify.exact import MAX_NUMBER
from verify.extent.radius import Ends, Radius, ends_of, radius
from verify.question import DecisionQuestion, Question
from verify.subjects import Game
from verify.verdicts.decisions import by_zones

CHANGED = ("row", "output", "value", "least", "most", "change", "exact")
MARK = "changes.csv"
OPTION = "--error"
UP = Context(prec=6, rounding=ROUND_CEILING)


@dataclass(frozen=True, repr=False)
class Changes(Shown):
    """Bounds on how far each output of an agent may change around the observations of a file, in its order.

    For example:

        maviper.robust(spring, "moves.csv", error="0.01").largest
    """

    policy: AgentPolicy
    observations: tuple[tuple[float, ...], ...]  #: [n, n_features]
    errors: tuple[Fraction, ...]  #: [n_features] the largest of each feature
    ends: tuple[tuple[Ends, ...], ...]  #: [n, n_outputs]

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
    def told(self) -> list[str]:
        """The summary."""
        return [f"Changes: {self.line}"]

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
        """True if all changes are met by observations, so that none is a bound only."""
        return all(each.exact for row in self.ends for each in row)

    @property
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
            for row, each in zip(self.rows, seen, strict=True)
        ]
        errors = dict(zip(names, map(plain, self.errors), strict=True))
        return {"agent": self.policy.agent, "errors": errors, "largest": _finite(self.largest), "changes": rows}

    @property
    def files(self) -> dict[str, str]:
        """The table as CSV."""
        text = io.StringIO()
        table = csv.writer(text, lineterminator="\n")
        table.writerow(CHANGED)
        table.writerows([*list(row.values())[:-1], "yes" if row["exact"] else "no"] for row in self.rows)
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


MAX_BYTES, MAX_ROWS = 1 << 26, 100_000
DOWN = Context(prec=6, rounding=ROUND_FLOOR)
HEADER: tuple[str, ...] = ("row", "action", "leaf", "radius", "other_action", "other_leaf")
ADVICE = "give a CSV file whose first line names the features, or a JSON list of observations"


@dataclass(frozen=True, repr=False)
class Radii(Shown):
    """The radii around the observations of a file, in its order; certificates where they were asked for.

    For example:

        maviper.robust(team, "seen.csv", agent="cart").least
    """

    policy: AgentPolicy
    observations: tuple[tuple[float, ...], ...]  #: [n, n_features]
    radii: tuple[Radius, ...]
    certificates: tuple[DecisionCertificate, ...] = ()  #: each accepted by the checker

    @property
    def line(self) -> str:
        """What sums them up, with six digits; never more than the radius itself."""
        least, median = (
            f"{float(DOWN.create_decimal_from_float(size)):g}" if math.isfinite(size) else "any"
            for size in (self.least, self.median)
        )
        return f"{len(self.radii)} of {self.policy.agent}: least {least}, median {median}"

    @property
    def told(self) -> list[str]:
        """The summary."""
        return [f"Radii: {self.line}"]

    @cached_property
    def ordered(self) -> list[float]:
        """The largest radii as float64, ascending; infinite where nothing leads to another action."""
        return sorted(one.largest for one in self.radii)

    @property
    def least(self) -> float:
        """The smallest radius."""
        return self.ordered[0]

    @property
    def median(self) -> float:
        """The lower median."""
        return self.ordered[(len(self.ordered) - 1) // 2]

    @property
    def rows(self) -> list[dict[str, Any]]:
        """The table as plain data; the radius is null where nothing leads to another action."""
        names, action = [one.name for one in self.policy.actions], self.policy.tree.action
        rows = list[dict[str, Any]]()
        for number, one in enumerate(self.radii, 1):
            other = ("", None) if one.distance is None else (names[int(action[one.other])], one.other)
            size = one.largest if math.isfinite(one.largest) else None
            rows.append(dict(zip(HEADER, (number, names[one.action], one.leaf, size, *other), strict=True)))
        return rows

    def document(self) -> dict[str, Any]:
        """The table and what sums it up, as plain data."""
        least, median = (value if math.isfinite(value) else None for value in (self.least, self.median))
        return {"agent": self.policy.agent, "least": least, "median": median, "radii": self.rows}

    @property
    def files(self) -> dict[str, str]:
        """radii.csv, and a certificate for each radius that was proved."""
        text = io.StringIO()
        table = csv.DictWriter(text, HEADER, lineterminator="\n")
        table.writeheader()
        table.writerows(self.rows)
        made = {f"certificate-{row}-robust.json": one for row, one in enumerate(self.certificates, 1)}
        return {"radii.csv": text.getvalue()} | {name: to_json(one) for name, one in made.items()}


def robust(
    profile: PolicyProfile, path: Path, agent: str | None = None, certify: bool = False, error: str | None = None
) -> Radii | Changes:
    """The radii of an agent (default: the only one) around the observations in a file; the changes of its outputs, if
    it gives numbers.

    `certify`: each radius is proved by zones too, and its certificate checked. `error`: of an agent that gives numbers,
    how far its features may be off, "0.01" or "x=0.01,v=0.2". InputError for a file that is no table of finite
    observations of that agent, and for options of the other kind of agent.
    """
    policy = find_agent(ensure(profile), agent)
    if policy.outputs:
        if certify:
            what = f"{policy.agent} gives numbers, and radii are proved of agents that take actions"
            raise InputError(
                what, "--certify", 'leave it out; `maviper verify` proves name = "robust" (`maviper guide claims`)'
            )
        if error is None:
            what = f"{policy.agent} gives numbers: how far may its features be off?"
            raise InputError(what, OPTION, f"write {OPTION} 0.01, or {OPTION} {policy.features[0].name}=0.01")
        return find_changes(policy, read_observations(path, policy), read_errors(error, policy))
    if policy.tree.arithmetic:
        ensure_plain(profile, "a radius")
    ensure_floats(profile, "a radius")
    if error is not None:
        what = f"{policy.agent} takes actions, and an error is for agents that give numbers"
        raise InputError(what, OPTION, "leave it out: the radius is the largest error that changes no action")
    observations = read_observations(path, policy)
    radii = tuple(radius(policy.tree, each) for each in observations)
    made: list[DecisionCertificate] = []
    for row, (each, one) in enumerate(zip(observations, radii, strict=True), 1):
        if certify:
            certificate = by_zones(_question(profile, policy, each, one)).certificate
            if certificate is None:  # our bug
                raise AssertionError(f"the radius of row {row} is not proved")
            made.append(certificate)
    return Radii(policy, observations, radii, tuple(made))


def find_agent(profile: PolicyProfile, agent: str | None) -> AgentPolicy:
    """The agent that is meant: the only one, or the one named. InputError where that is not known."""
    known = [policy.agent for policy in profile.agents]
    if agent is None and len(known) > 1:
        raise InputError("the profile has several agents", "--agent", f"name one of {', '.join(known)}")
    if agent is not None and agent not in known:
        raise UnknownNameError("agent", agent, known, "--agent")
    return profile.policy(agent or known[0])


def _question(
    profile: PolicyProfile, policy: AgentPolicy, observation: Sequence[float], radius: Radius
) -> DecisionQuestion:
    """That the agent acts the same within the radius, as a question over observations."""
    viewed = Viewed(profile, View())
    box: dict[str, Interval] = {
        one.name: (Fraction(one.low), Fraction(one.high)) for one in viewed.profile.world.variables
    }
    size = Fraction(radius.largest) if math.isfinite(radius.largest) else Fraction(2 * MAX_NUMBER)
    for feature, value in zip(viewed.profile.policy(policy.agent).features, observation, strict=True):
        assert feature.meaning is not None, feature
        box[feature.meaning.terms[0][1]] = Fraction(value) - size, Fraction(value) + size
    claim = OwnFormula(policy.team, statement=Acts(policy.agent, radius.action))
    return Question(Game(viewed.profile, viewed=viewed), claim, Region(box, ()))


def read_observations(path: Path, policy: AgentPolicy) -> tuple[tuple[float, ...], ...]:
    """The observations [n, n_features] in a file. InputError for names that are no features, and for numbers that are
    missing, not finite or beyond MAX_NUMBER.
    """
    try:
        text = runs.read(path, MAX_BYTES).decode("utf-8-sig")  # spreadsheets begin a file with a mark
    except UnicodeDecodeError:
        raise InputError("not a table of observations", f"{path}: not UTF-8 text", ADVICE) from None
    names = [feature.name for feature in policy.features]
    rows = _from_json(text, path) if text.lstrip().startswith("[") else _from_csv(text, names, path)
    if not 1 <= len(rows) <= MAX_ROWS:
        raise InputError(f"{len(rows)} observations; 1 to {MAX_ROWS} are read", str(path), ADVICE)
    return tuple(_row(each, names, f"{path}: row {row}") for row, each in enumerate(rows, 1))


def _from_csv(text: str, known: Sequence[str], path: Path) -> list[Any]:
    table = csv.DictReader(io.StringIO(text), skipinitialspace=True)
    names = list(table.fieldnames or ())
    if len(set(names)) < len(names):
        raise InputError("a feature is named twice", f"{path}: first line", ADVICE)
    for name in names:
        if name not in known:
            raise UnknownNameError("feature", escape_text(name), known, f"{path}: first line")
    try:
        return list(table)
    except csv.Error as error:
        raise InputError("not a table of observations", f"{path}: {error}", ADVICE) from None


def _from_json(text: str, path: Path) -> list[Any]:
    try:
        return cast("list[Any]", json.loads(text))
    except (ValueError, RecursionError) as error:
        raise InputError("not a list of observations", f"{path}: {escape_text(error)}", ADVICE) from None


def _row(given: Any, names: Sequence[str], where: str) -> tuple[float, ...]:
    if isinstance(given, Mapping):
        stated = cast("Mapping[Any, Any]", given)
        for name in stated:
            if name not in names:
                raise UnknownNameError("feature", escape_text(name or "a number without a name"), names, where)
        missing = [name for name in names if stated.get(name) is None]
        if missing:
            raise InputError(f"no number for {missing[0]}", where, f"features: {', '.join(names)}")
        values = [stated[name] for name in names]
    else:
        values = cast("list[Any]", given) if isinstance(given, list) else [given]
        if len(values) != len(names):
            raise InputError(f"{len(values)} numbers for {len(names)} features", where, f"in order: {', '.join(names)}")
    return tuple(_number(value, f"{where}: {name}") for name, value in zip(names, values, strict=True))


def _number(value: Any, where: str) -> float:
    try:
        number = math.nan if isinstance(value, bool) or not isinstance(value, (int, float, str)) else float(value)
    except (ValueError, OverflowError):
        number = math.nan
    if not abs(number) <= MAX_NUMBER:
        raise InputError(f"not a finite number up to {MAX_NUMBER}: {escape_text(str(value)[:40])!r}", where, ADVICE)
    return number
