"""Judges a record of generated/reproduction again: all claims there are now, with the words of today's rules.

    python -m tests.benchmarks.judged generated/reproduction/maddpg
    python -m tests.benchmarks.judged generated/reproduction/maddpg-deception --first 10     on fresh seeds alone

Reads cells.json.xz and plays nothing. Writes claims.json, summary.txt and recompute.py, the claims on report.html, what
each number is made of into cells.json.xz, and the counts into README.md. `--first`: the first seed that counts, of a
second look whose earlier seeds had been judged before. Then claims about other games are left out, and the page, which
shows all seeds, is taken away.

Numbers about facts that a record does not keep stand as it has them: those of attention, of all of its seeds.
"""

import argparse
import json
import math
import re
from pathlib import Path

import numpy as np

from codegen.lowering.render import render
from maviper.evaluation.crossplay import DRAWS
from maviper.files import runs
from maviper.reproduction import report, verdicts
from maviper.reproduction.cells.cell import EXPERT
from maviper.reproduction.cells.table import Results, Row
from maviper.reproduction.recipes import IMPURITY, Book, Number
from maviper.reproduction.register import Register, read
from maviper.reproduction.statistics import DRAW_SEED, Estimate
from tests.benchmarks import compact

FORGOTTEN = {"goal_x": 0.0, "landmark_0_x": 0.0}  # stands where importances were: no number is read from it
README = "README.md"
COUNTS = r"\d+ of \d+ claims? agrees?[^.;]*?comparable(?:; \d+ more repeats? one of these numbers)?"
FRESH = "Claims are judged on the seeds from "


def table_of(place: Path, document: dict, first: int = 0) -> Results:
    """The table of a record, of seeds from `first` on. Where it has means only, every episode of a line-up has their
    mean, or half of them have one value and half another, with the mean of their sizes.
    """
    rows: list[Row] = []
    values, facts, higher = {}, {}, {}
    for name, cell in document["cells"].items():
        about = {key: int(text) if key in ("depth", "leaves", "seed") else text for key, text in cell["about"].items()}
        if about["kind"] == EXPERT or about["seed"] >= first:
            rows.append(Row(**about, cell=name, cpu_seconds=float(cell["cpu_seconds"])))
        told = [(lineup, *each) for lineup, of in cell["values"].items() for each in of.items()]
        told = [each for each in told if each[1] != compact.INSIDE]
        values[name] = {(lineup, measure): (_episodes(of), _column(of)) for lineup, measure, of in told}
        higher |= {measure: measure not in cell["lower_is_better"] for _, measure, _ in told}
        facts[name] = {"importances": {f"agent_{k}": {IMPURITY: FORGOTTEN} for k in (0, 1)}, **cell.get("facts", {})}
    return Results(place, tuple(sorted(rows)), higher, values, facts)


def _episodes(told):
    return np.array(told.get("episodes") or range(told["first"], told["first"] + told["count"]), dtype=float)


def _column(told):
    if "values" in told:
        return np.array(told["values"], dtype=float)
    mean, signs = told["mean"], np.where(np.arange(told["count"]) % 2, -1.0, 1.0)
    if "size" not in told:
        return np.full(told["count"], mean)
    assert told["count"] % 2 == 0
    return mean + told["size"] * signs


def judged(place: Path, first: int = 0) -> tuple[list[verdicts.Verdict], Book, Register]:
    """The verdicts of a record with one expert, the numbers that they rest on, and the register."""
    document = compact.unpacked(place / compact.FILE)
    book, known = Book(table_of(place, document, first)), read()
    for claim in json.loads((place / report.CLAIMS).read_text())["claims"]:
        for each in claim["comparisons"]:
            if each["number"] is not None and each["number"] not in document["numbers"]:
                value, error = (math.nan if each[name] is None else each[name] for name in ("value", "error"))
                estimate = Estimate(value, error, each["freedom"])
                book.numbers[each["number"]] = Number(each["number"], (), estimate, each["seeds"], each["episodes"])
    (expert,) = {row.expert for row in book.results.rows}
    found = verdicts.judge_claims(book, known, expert)
    return [each for each in found if each.run or not first], book, known


def judge_again(place: Path, first: int = 0) -> list[str]:
    """Writes a record's verdicts; the lines of its summary."""
    if FRESH in (place / README).read_text() and not first:
        raise SystemExit(f"{place} is a second look: say from which seed on it is judged (--first)")
    found, book, known = judged(place, first)
    document = compact.unpacked(place / compact.FILE)
    numbers = {name: number.document for name, number in sorted(book.numbers.items()) if number.parts}
    facts = report.describe_run(book.results, known, [found[0].expert])
    lines = report.summary(found, facts)
    lines[-1] = lines[-1].replace(f"{report.PAGE}, ", "") if first else lines[-1]
    files = {
        report.CLAIMS: report.lay_out_claims(report.document(found, known)),
        report.SUMMARY: "\n".join(lines) + "\n",
        report.SCRIPT: render("reproduction/recompute.py.j2", seed=DRAW_SEED, draws=DRAWS),
        compact.FILE: compact.packed(document["cells"], numbers=numbers),
        README: _readme((place / README).read_text(), lines[0], first),
    }
    if first:
        (place / report.PAGE).unlink(missing_ok=True)
    elif (place / report.PAGE).exists():
        files[report.PAGE] = _page(place, found, facts)
    runs.write_all(place, files)
    return lines


def _page(place: Path, found: list[verdicts.Verdict], facts: dict) -> str:
    """The page of a record with today's claims on it. Figures and tables stay as they are: some are of facts that the
    record does not keep.
    """
    old, new = (place / report.PAGE).read_text(), report.lay_out_page(found, facts, [])
    for part in (r"<p><strong>.*?</p>", r'<h2 id="claims">.*?(?=\n<h2 id=|\n<details>\n<summary>What was run)'):
        (now,) = re.findall(part, new, re.DOTALL)
        old, count = re.subn(part, lambda _, now=now: now.rstrip(), old, count=1, flags=re.DOTALL)
        assert count == 1, part
    return old


def _readme(text: str, counts: str, first: int) -> str:
    """README.md with other counts, and from which seed on they are."""
    text = re.sub(rf"^{COUNTS}\.", f"{counts}.", text, flags=re.MULTILINE)
    if first and FRESH not in text:
        said = f"{FRESH}{first} on, as the earlier ones had been judged before; those about attention on all."
        text = text.replace("\n\n- `summary.txt`", f"\n\n{said}\n\n- `summary.txt`")
        text = re.sub(r"^- `report.html`.*\n", "", text, flags=re.MULTILINE)
    return text


def main() -> None:
    """Judges the record that is named."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("place", type=Path)
    parser.add_argument("--first", type=int, default=0, metavar="SEED")
    given = parser.parse_args()
    print(*judge_again(given.place, given.first), sep="\n")


if __name__ == "__main__":
    main()
