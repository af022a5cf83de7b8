"""The report of a reproduction: one page, its figures, the verdicts as data and as text, and how to compute it again.

Does: reads the table of a folder and writes report.html, figures/*.svg, claims.json, numbers.json, summary.txt and
  recompute.py there.
Assumes: nothing but the table, its cells and the register; equal tables give equal bytes.
Does not: play, or contain times, paths or facts about the machine.
"""

import json
import math
import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

from codegen.lowering.render import render
from codegen.wording import format_count
from maviper.evaluation.crossplay import DRAWS
from maviper.files import runs
from maviper.reproduction import register, sections, verdicts
from maviper.reproduction.cells.cell import EXPERT, KINDS
from maviper.reproduction.cells.table import Results, read_table
from maviper.reproduction.figures import MARKS, name_algorithm
from maviper.reproduction.recipes import Book
from maviper.reproduction.register import Register
from maviper.reproduction.sections import Context, Section
from maviper.reproduction.statistics import DRAW_SEED
from maviper.reproduction.verdicts import Verdict

PAGE, SUMMARY, CLAIMS, NUMBERS, SCRIPT = "report.html", "summary.txt", "claims.json", "numbers.json", "recompute.py"
FILES, FIGURES = (PAGE, SUMMARY, CLAIMS, NUMBERS, SCRIPT), "figures"
GAMES = tuple(sections.MEASURES)
SIGNS: dict[str, str] = dict(
    zip(verdicts.WORDS, ("✓", "✗", "?", "–"), strict=True)
)  # so that no meaning rests on colour
_NEXT = ",\n"
STYLE = re.compile(r"<style>.*?</style>\n", re.DOTALL)  # of a figure
WIDTH = 150  # of a line of the summary


def write_report(folder: Path) -> list[str]:
    """Writes the report of a folder's table into it; the lines for the terminal. InputError for a damaged table."""
    table, known = read_table(folder), register.read()
    book = Book(table)
    labels = [row.expert for row in table.rows]
    experts = sorted(set(labels), key=lambda label: (-labels.count(label), label))  # those of most cells first
    judged = [verdict for expert in experts for verdict in verdicts.judge_claims(book, known, expert)]
    context = Context(book, known, book.finder, GAMES, experts)
    first = [sections.performance(context, statistic) for statistic in (register.JOINT, register.INDIVIDUAL)]
    rest = (sections.robustness, sections.ablation, sections.features, sections.trees, sections.exploitability)
    parts = [*first, *(make(context) for make in rest), sections.rewards(context)]
    facts = describe_run(table, known, experts)
    lines = summary(judged, facts)
    pictures = {f"{FIGURES}/{figure.name}.svg": figure.svg for part in parts for figure in part.figures}
    numbers = [f"{json.dumps(name)}: {json.dumps(number.document)}" for name, number in sorted(book.numbers.items())]
    files = {
        **pictures,
        CLAIMS: lay_out_claims(document(judged, known)),
        NUMBERS: "{\n" + ",\n".join(numbers) + "\n}\n",
        SCRIPT: render("reproduction/recompute.py.j2", seed=DRAW_SEED, draws=DRAWS),
        SUMMARY: "\n".join(lines) + "\n",
        PAGE: lay_out_page(judged, facts, parts),
    }
    runs.write_all(folder, files)
    for old in (folder / FIGURES).glob("*.svg"):  # of an earlier report
        if f"{FIGURES}/{old.name}" not in files:
            old.unlink()
    return lines


def lay_out_page(judged: Sequence[Verdict], facts: Mapping[str, Any], parts: Sequence[Section]) -> str:
    """The page: verdicts on all claims among the sections of the report. It holds the style of figures once."""
    bare = [[replace(each, svg=STYLE.sub("", each.svg, count=1)) for each in part.figures] for part in parts]
    return render(
        "reproduction/report.html.j2",
        sections=[replace(part, figures=drawn) for part, drawn in zip(parts, bare, strict=True)],
        marks=tuple(MARKS.values()),
        several=len({verdict.expert for verdict in judged}) > 1,
        facts=facts,
        verdicts=_encode_verdicts(judged),
        overview=_overview(judged),
        counts=counts((verdict.claim.id, verdict.word) for verdict in judged),
    )


def _encode_verdicts(judged: Sequence[Verdict]) -> list[dict[str, Any]]:
    """All verdicts; the first of each claim is what links to it find."""
    known: set[str] = set()
    entries: list[dict[str, Any]] = []
    for verdict in judged:
        found = verdict.word in (verdicts.AGREES, verdicts.DIFFERS)
        claim, paper = verdict.claim, verdict.claim.published
        rows: list[list[str]] = []
        for each in verdict.comparisons:
            shown = sections.format_number(each.number)
            beside = [each.size, verdicts.UNTESTABLE if each.untestable else ""]
            rows.append([each.label, shown, _state(each), "; ".join(filter(None, beside))])
        published = "" if paper is None else f"{paper.number} ({paper.place})" if paper.number else paper.place
        entries.append(
            {
                "id": claim.id,
                "sign": SIGNS[verdict.word],
                "word": verdict.word,
                "class": verdict.word.lower().replace(" ", "-"),
                "says": claim.says,
                "place": claim.place,
                "main": claim.main,
                "family": claim.family,
                "expert": verdict.expert,
                "told": list(filter(None, [verdict.reason, *verdict.notes, *_beside(verdict)])),
                "published": published,
                "rows": rows,
                "found": found,
                "first": claim.id not in known,
            }
        )
        known.add(claim.id)
    return sorted(entries, key=lambda entry: entry["word"] != verdicts.DIFFERS)


PLACE = re.compile(r"(table|figure) (\w+)", re.IGNORECASE)  # of the paper
FIRST = (register.JOINT, register.ROBUSTNESS, register.INDIVIDUAL)  # of the rows that begin the page


def _overview(judged: Sequence[Verdict]) -> list[dict[str, Any]]:
    """A row for each table and figure of the paper that claims are about: of its main claim, or its first, with the
    words of all.
    """
    groups: dict[str, list[Verdict]] = {}
    for verdict in judged:
        if named := PLACE.search(verdict.claim.place):
            groups.setdefault(f"{named[1]} {named[2]}".capitalize(), []).append(verdict)

    rows = {place: _main_of(group) for place, group in groups.items()}
    statistics = {place: shown.claim.statistic for place, shown in rows.items()}
    ranks = {place: FIRST.index(name) if name in FIRST else len(FIRST) for place, name in statistics.items()}
    return [_row(place, groups[place]) for place in sorted(groups, key=ranks.__getitem__)]


def _main_of(group: Sequence[Verdict]) -> Verdict:
    return next((verdict for verdict in group if verdict.claim.main), group[0])


def _row(place: str, group: Sequence[Verdict]) -> dict[str, Any]:
    """The row of a table or figure of the paper. `group`: the verdicts on its claims."""
    shown = _main_of(group)
    compared = next(iter(shown.run), None)
    words = Counter(verdict.word for verdict in group)
    games = dict.fromkeys(game for verdict in group for game in verdict.claim.list_values("game"))
    paper = shown.claim.published
    return {
        "place": place,
        "id": shown.claim.id,
        "game": ", ".join(games),
        "published": sections.NONE if paper is None or not paper.number else paper.number,
        "ours": sections.format_number(None if compared is None else compared.number),
        "label": "" if compared is None else compared.label,
        "word": f"{SIGNS[shown.word]} {shown.word}",
        "class": shown.word.lower().replace(" ", "-"),
        "others": ", ".join(f"{count} {word}" for word, count in words.items()) if len(group) > 1 else "",
    }


def document(judged: Sequence[Verdict], known: Register) -> dict[str, Any]:
    """All verdicts as plain data, as in claims.json."""
    rules = {name: getattr(known, name) for name in ("alpha", "margin", "power", "least_seeds")}
    return {
        "register": known.sha256,
        "more_claims": known.more,
        **rules,
        "claims": [_plain(verdict) for verdict in judged],
    }


def _plain(verdict: Verdict) -> dict[str, Any]:
    claim = verdict.claim
    names = ("id", "place", "says", "family", "statistic", "test", "main", "bound")
    paper = {} if claim.published is None else {"number": claim.published.number, "place": claim.published.place}
    told = {name: getattr(claim, name) for name in names} | {"published": paper, "expert": verdict.expert}
    said = {"verdict": verdict.word, "reason": verdict.reason, "notes": list(verdict.notes)}
    said |= {"by_depth": {str(depth): text for depth, text in verdict.by_depth.items()}}
    return {**told, **said, "comparisons": [_plain_comparison(each) for each in verdict.comparisons]}


def _plain_comparison(comparison: verdicts.Comparison) -> dict[str, Any]:
    entry: dict[str, Any] = {"label": comparison.label, "word": comparison.word, "number": None}
    if comparison.number is None:
        return entry | {"word": "not run"}
    number = {name: value for name, value in comparison.number.document.items() if name != "parts"}
    visible = comparison.visible if math.isfinite(comparison.visible) else None
    tests = {"p": dict(comparison.p), "adjusted": dict(comparison.adjusted), "visible": visible}
    tests |= {"size": comparison.size, "untestable": comparison.untestable}
    return entry | {"number": comparison.number.id, **number, **tests}


def lay_out_claims(document: Mapping[str, Any]) -> str:
    """JSON of all verdicts, one line per comparison after a line of its claim: scripts read it, and a line is found."""
    claims = [
        _join_last(claim, "comparisons", [_flat(each) for each in claim["comparisons"]]) for claim in document["claims"]
    ]
    return _join_last(document, "claims", claims) + "\n"


def _join_last(document: Mapping[str, Any], name: str, rows: Sequence[str]) -> str:
    """A JSON object with the list of that name at its end, whose entries are already text, a line each."""
    others = _flat({key: value for key, value in document.items() if key != name})
    return f"{others[:-1]},{json.dumps(name)}:[{_NEXT.join(('', *rows))[1:]}]}}"


def _flat(value: Any) -> str:
    return json.dumps(_shorten(value), sort_keys=True, separators=(",", ":"))


def _shorten(value: Any) -> Any:
    """Plain data with numbers of ten digits: more than any interval has."""
    if isinstance(value, Mapping):
        return {name: _shorten(each) for name, each in cast("Mapping[str, Any]", value).items()}
    if isinstance(value, list | tuple):
        return [_shorten(each) for each in cast("Sequence[Any]", value)]
    return float(f"{value:.10g}") if isinstance(value, float) else value


def describe_run(table: Results, known: Register, experts: Sequence[str]) -> dict[str, Any]:
    """Describes what was run, in words."""
    spent = sum(row.cpu_seconds for row in table.rows)
    kinds = {kind: len(table.cells(kind=kind)) for kind in KINDS}
    games = table.list_values("game")
    cells = ", ".join(f"{count} {kind}" for kind, count in kinds.items() if count)
    played = Counter[tuple[str, str]]()
    for row in table.cells(kind=EXPERT):
        played[row.game, row.expert] += sum(len(values[0]) for values in list(table.values(row.cell).values())[:1])
    return {
        "experts": ", ".join(experts) or "none",
        "games": ", ".join(games) or "none",
        "algorithms": ", ".join(name_algorithm(name) for name in table.list_values("algorithm") if name) or "none",
        "presets": ", ".join(name for name in table.list_values("preset") if name) or "none",
        "depths": ", ".join(str(depth) for depth in table.list_values("depth") if depth) or "none",
        "seeds": len({row.seed for row in table.rows if row.kind != EXPERT}),
        "cells": cells or "none",
        "expert's episodes": ", ".join(map(str, sorted(set(played.values())))) or "none",
        "CPU hours": f"{spent / 3600:.2f}",
        "rules": f"alpha {known.alpha:g}, margin {known.margin:g}, power {known.power:g}, Holm within a family",
        "register": known.sha256,
    }


# --- verdicts, for people


def counts(words_by_id: Iterable[tuple[str, str]]) -> str:
    """Counts the claims with each verdict, such as `5 of 40 claims agree, 7 differ, 25 are not decided`, by id and word
    of each. Those that repeat another's number do not count.
    """
    told, repeats = list(words_by_id), register.read().repeats
    words = [word for name, word in told if name not in repeats]
    repeated = len(told) - len(words)
    agree, differ, open_, apart = (words.count(word) for word in verdicts.WORDS)
    be = ("are", "is")
    told = [f"{agree} of {format_count(len(words), 'claim')} {'agrees' if agree == 1 else 'agree'}"]
    told += [f"{differ} {'differs' if differ == 1 else 'differ'}", f"{open_} {be[open_ == 1]} not decided"]
    text = ", ".join([*told, f"{apart} {be[apart == 1]} not comparable"])
    again = f"; {repeated} more {'repeats' if repeated == 1 else 'repeat'} one of these numbers"
    return text + again if repeated else text


def _beside(verdict: Verdict) -> list[str]:
    """The words of a claim depth by depth, where they say more than its own."""
    words = verdict.by_depth
    told = [f"by depth: {', '.join(f'{depth} {text}' for depth, text in words.items())}"]
    told = told if set(words.values()) - {verdict.word} else []
    first = register.read().repeats.get(verdict.claim.id)
    return [*told, f"not counted: the number is that of {first}"] if first else told


def _state(comparison: verdicts.Comparison) -> str:
    if comparison.number is None:
        return "not run"
    if comparison.word != verdicts.OPEN or not math.isfinite(comparison.visible):
        return comparison.word
    return f"{comparison.word}; {comparison.visible:.3g} would have been detected"


def summary(judged: Sequence[Verdict], facts: dict[str, Any]) -> list[str]:
    """A line for each claim, the main ones marked, after what was run."""
    lines = [counts((verdict.claim.id, verdict.word) for verdict in judged)]
    lines += [
        f"experts {facts['experts']}; games {facts['games']}; seeds {facts['seeds']}; {facts['CPU hours']} CPU hours"
    ]
    experts = {verdict.expert for verdict in judged}
    for verdict in judged:
        claim = verdict.claim
        name = claim.id if len(experts) == 1 else f"{claim.id} ({verdict.expert})"
        notes = "; ".join([text for text in (verdict.reason, *verdict.notes) if text])
        lines.append(summarise_claim(verdict.word, claim.main, name, notes or claim.says))
        lines += [_cut(f"{'':<19}{text}") for text in _beside(verdict)]
    return [*lines, f"* main comparison; the whole: {PAGE}, {CLAIMS}"]


def summarise_claim(word: str, main: bool, name: str, text: str) -> str:
    """A claim's line of the summary."""
    return _cut(f"{SIGNS[word]} {word:<14} {'*' if main else ' '} {name}: {text}")


def _cut(line: str) -> str:
    return line if len(line) <= WIDTH else line[: WIDTH - 1] + "…"
