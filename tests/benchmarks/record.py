"""Records a finished reproduction in generated/reproduction/: report, claims, table, figures, and how it was made.

    maviper reproduce --experts maddpg --jobs 2 -o FOLDER
    python -m tests.benchmarks.record FOLDER generated/reproduction/maddpg -- --experts maddpg

Copies report.html, summary.txt, claims.json, recompute.py and figures/ as the command wrote them, and packs cells.csv.
Packs what recompute.py needs besides (episodes/, facts/, numbers.json) into episodes.tar.xz, unless that is larger than
--most MB. Episodes that follow one another stand there in one row.
Writes readme-1.svg and readme-2.svg, two figures on a panel of their own, and README.md with command, versions and
core-hours; the command's options stand after --. Equal folders give equal bytes. Nothing is played, and nothing in
FOLDER is changed.
"""

import argparse
import csv
import hashlib
import io
import json
import lzma
import platform
import re
import shutil
import tarfile
from contextlib import suppress
from html import escape
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from maviper.files import runs
from maviper.reproduction import report
from maviper.reproduction.cells.table import EPISODES_FOLDER, FACTS_FOLDER, TABLE_FILE
from maviper.reproduction.sections import short

COPIED = (report.PAGE, report.SUMMARY, report.CLAIMS, report.SCRIPT)
ARCHIVE, README = "episodes.tar.xz", "README.md"
TABLE = f"{TABLE_FILE}.xz"
MOST = 5.0  # MB of the archive
EFFORT = 6  # of xz
SHOWN = (  # the figures of the README: the first two that there are
    ("physical-deception", "defenders success r=0.316"),
    ("cooperative-navigation", "agents D"),
    ("predator-prey", "predators touches"),
    ("physical-deception", "adversaries success r=0.316"),
)
PACKAGES = ("maviper", "numpy", "scipy", "mpe2", "pettingzoo", "torch")  # torch, if there: responders learn with it
STYLE = ".panel{fill:#ffffff}@media (prefers-color-scheme:dark){.panel{fill:#10151a}}"
PANEL = '<rect class="panel" width="100%" height="100%" rx="6"/>'


def recorded(folder: Path, place: Path, options: str = "", most: float = MOST) -> list[Path]:
    """Writes the record of a finished folder into `place`; the files. FileNotFoundError where a report is missing."""
    shutil.rmtree(place / report.FIGURES, ignore_errors=True)
    for name in COPIED:
        runs.write(place / name, (folder / name).read_bytes())
    runs.write(place / TABLE, lzma.compress((folder / TABLE_FILE).read_bytes(), preset=9))
    figures = sorted((folder / report.FIGURES).glob("*.svg"))
    for path in figures:
        runs.write(place / report.FIGURES / path.name, path.read_bytes())
    for number, text in enumerate(readme_figures(folder), 1):
        runs.write(place / f"readme-{number}.svg", text)
    packed = archive(folder)
    kept = len(packed) <= most * 1e6
    (place / ARCHIVE).unlink(missing_ok=True)
    if kept:
        runs.write(place / ARCHIVE, packed)
    runs.write(place / README, page(folder, options, packed, kept))
    return sorted(path for path in place.rglob("*") if path.is_file())


def rows(place: Path) -> list[dict[str, str]]:
    """The table of a record, a row per line-up and measure of each cell."""
    with lzma.open(place / TABLE, "rt", encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def archive(folder: Path) -> bytes:
    """What the numbers are computed from, in a tar file without times or owners, compressed by xz."""
    names = [report.NUMBERS]
    names += [f"{part}/{path.name}" for part in (EPISODES_FOLDER, FACTS_FOLDER) for path in (folder / part).iterdir()]
    data = io.BytesIO()
    with tarfile.open(fileobj=data, mode="w", format=tarfile.USTAR_FORMAT) as tar:
        for name in sorted(names):
            content = (folder / name).read_bytes()
            content = in_rows(content) if name.startswith(EPISODES_FOLDER) else content
            member = tarfile.TarInfo(name)
            member.size = len(content)
            tar.addfile(member, io.BytesIO(content))
    return lzma.compress(data.getvalue(), preset=EFFORT)


def in_rows(table: bytes) -> bytes:
    """The same values, those of episodes that follow one another in one row: line-up, measure, first episode, values.
    It packs into less than half, as no row says again what it is about.
    """
    (header, *values), wide = csv.reader(io.StringIO(table.decode(), newline="")), list[list[str]]()
    for lineup, measure, episode, value in values:
        last = wide[-1] if wide else []
        if last[:2] == [lineup, measure] and int(last[2]) + len(last) - 3 == int(episode):
            last.append(value)
        else:
            wide.append([lineup, measure, episode, value])
    text = io.StringIO(newline="")
    csv.writer(text, lineterminator="\n").writerows([header, *wide])
    return text.getvalue().encode()


def readme_figures(folder: Path) -> list[str]:
    """Joint performance against depth, for the expert of most claims; each on a panel, so that text is readable on
    any page, and with a size, so that two stand side by side.
    """
    expert = json.loads((folder / report.CLAIMS).read_text())["claims"][0]["expert"]
    found = []
    for game, measure in SHOWN:
        path = folder / report.FIGURES / f"{short('joint', game, expert, measure)}.svg"
        if path.exists():
            title = f"{game.replace('-', ' ')}, {measure.split()[0]}, ratio to {expert} expert"
            text = path.read_text(encoding="utf-8").replace(escape(f"{measure}, joint, {expert}"), title)
            text = text.replace("<style>", f"<style>{STYLE}", 1).replace("</style>", f"</style>\n{PANEL}", 1)
            text = re.sub(r'viewBox="0 0 (\d+) (\d+)"', r'width="\1" height="\2" \g<0>', text, count=1)
            found.append(text)
    return found[:2]


def page(folder: Path, options: str, packed: bytes, kept: bool) -> str:
    """README.md: what was run, with what, and what lies here."""
    claims = json.loads((folder / report.CLAIMS).read_text())
    table = io.StringIO((folder / TABLE_FILE).read_text(encoding="utf-8"), newline="")
    cells = {row["cell"]: row for row in csv.DictReader(table)}
    hours = sum(float(row["cpu_seconds"]) for row in cells.values()) / 3600
    words = [claim["verdict"] for claim in claims["claims"]]
    experts = ", ".join(sorted({row["expert"] for row in cells.values()}))
    command = " ".join(word for word in ("maviper reproduce", options, "-o FOLDER") if word)
    size, digest = f"{len(packed) / 1e6:.1f} MB", hashlib.sha256(packed).hexdigest()
    lies = f"`{ARCHIVE}` ({size}) holds what they are made of: `tar xf {ARCHIVE} && python {report.SCRIPT}`."
    left = f"What they are made of ({size} packed, sha256 {digest}) is left out; the command makes it again."
    return f"""# A reproduction of the paper, experts: {experts}

    {command}

{report.counts(words)}. {len(cells)} cells, {hours:.1f} core-hours.
Register of claims: sha256 {claims["register"]}. Versions: {_versions()}.

- `{report.SUMMARY}`: a line for each claim; `{report.CLAIMS}`: every comparison, with p-values.
- `{report.PAGE}`: tables and figures on one page; `{report.FIGURES}/`: the figures alone.
- `{TABLE}`: the mean of every line-up and measure of every cell, with its CPU time.
- `{report.SCRIPT}` computes all numbers again without maviper. {lies if kept else left}

This folder was written by `python -m tests.benchmarks.record`.
"""


def _versions() -> str:
    found = [("Python", platform.python_version())]
    for name in PACKAGES:
        with suppress(PackageNotFoundError):
            found.append((name, version(name)))
    return ", ".join(f"{name} {number}" for name, number in found)


def main() -> None:
    """Records the folder that is named."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("place", type=Path)
    parser.add_argument("--most", type=float, default=MOST, help="MB of the archive, at most")
    parser.add_argument("options", nargs="*", help="those of maviper reproduce")
    given = parser.parse_args()
    for path in recorded(given.folder, given.place, " ".join(given.options), given.most):
        print(f"{path.stat().st_size:>9}  {path}")


if __name__ == "__main__":
    main()
