"""Answers as people and other programs take them up: a short repr, rows for a table, CSV, a table in notebooks.

Does: gives a dataclass these four, from its fields of plain values or from rows of its own.
Assumes: rows of plain values; `pandas.DataFrame(answer.rows)` reads them.
Does not: import a library of tables.
"""

import csv
import io
from collections.abc import Mapping
from dataclasses import fields
from html import escape
from pathlib import Path
from typing import Any

LONGEST = 480  # characters of a repr
WIDEST = 110  # of one of its lines
DRAWN = 60  # rows of a table in a notebook


class Shown:
    """What is shown of an answer. `rows` has one line at least; a class says others where it has a table."""

    @property
    def rows(self) -> list[dict[str, Any]]:
        """The answer as rows, names -> plain values, so that `pandas.DataFrame(answer.rows)` is a table."""
        given = ((each.name, getattr(self, each.name)) for each in fields(self))  # type: ignore[arg-type]
        return [{name: value for name, value in given if isinstance(value, str | int | float)}]

    @property
    def told(self) -> list[str]:
        """What a person is told in few lines: by default the first rows."""
        rows = [", ".join(f"{name} {spell(value)}" for name, value in row.items()) for row in self.rows[:3]]
        more = [f"and {len(self.rows) - 3} more rows"] if len(self.rows) > 3 else []
        return [f"{type(self).__name__}: {rows[0] if rows else 'no rows'}", *rows[1:], *more]

    def __repr__(self) -> str:
        lines = [line if len(line) <= WIDEST else f"{line[: WIDEST - 3]}..." for line in self.told]
        return "\n".join(lines)[:LONGEST]

    def to_csv(self, path: str | Path | None = None) -> str:
        """The rows as CSV text, which is also written where a path is given, whole or not at all.

        OSError where it cannot be written.
        """
        text = as_csv(self.rows)
        if path is not None:
            part = Path(path).with_name(f".{Path(path).name}.part")
            part.write_text(text, encoding="utf-8")
            part.replace(path)
        return text

    def _repr_html_(self) -> str:
        rows = self.rows
        names = _columns(rows)
        head = "".join(f"<th>{escape(name)}</th>" for name in names)
        body = "".join(f"<tr>{_cells(row, names)}</tr>" for row in rows[:DRAWN])
        more = f"<p>and {len(rows) - DRAWN} more rows</p>" if len(rows) > DRAWN else ""
        first = escape(self.told[0])
        return f"<p>{first}</p><table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>{more}"


def as_csv(rows: list[dict[str, Any]]) -> str:
    """Rows as CSV text, with all their names as its head."""
    text = io.StringIO()
    table = csv.DictWriter(text, _columns(rows), lineterminator="\n")
    table.writeheader()
    table.writerows(rows)
    return text.getvalue()


def _columns(rows: list[dict[str, Any]]) -> list[str]:
    """The names of all rows, in the order in which they come."""
    return list(dict.fromkeys(name for row in rows for name in row))


def _cells(row: Mapping[str, Any], names: list[str]) -> str:
    return "".join(f"<td>{escape(spell(row.get(name)))}</td>" for name in names)


def spell(value: Any) -> str:
    """A plain value for people: numbers with four digits, nothing for None."""
    return "" if value is None else f"{value:.4g}" if isinstance(value, float) else str(value)
