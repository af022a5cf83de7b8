"""What a comparison shows: a table of means with intervals, words for differences, figures, LaTeX and the best trees.

Does: reads the cells of a comparison; computes each number over seeds or, of several experts, over these; chooses the
  best trees by RULE.
Assumes: cells of one world, in which trees and expert of a seed played the same episodes.
Does not: play, or write files.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from codegen.errors import ExitCode
from codegen.ir import Float64, PolicyProfile
from codegen.profiles import loads
from codegen.rows import Shown, as_csv, spell
from codegen.wording import format_count
from maviper.console import tabulate
from maviper.episodes import measures
from maviper.files import runs
from maviper.page.latex import escape
from maviper.reproduction import figures, register
from maviper.reproduction.cells.cell import EXPERT, EXTRACTION
from maviper.reproduction.cells.making import JOINT
from maviper.reproduction.cells.table import CELLS, Row, read_table
from maviper.reproduction.figures import MARKS, Mark, Point, name_algorithm
from maviper.reproduction.grid import Making
from maviper.reproduction.recipes import Finder, Number, Part, Place, estimate_parts, less, times
from maviper.reproduction.register import Claim
from maviper.reproduction.statistics import MODES, Estimate, interquartile, of_differences, performance_profile
from maviper.reproduction.verdicts import OPEN, comparison, decide_family
from maviper.worlds import Measure, World

TABLE, LATEX, SUMMARY, BEST, FIGURE = "table.csv", "table.tex", "summary.txt", "best.json", "figure.svg"
PROFILES, PROFILE_FIGURE = "profiles.csv", "profiles.svg"  # where there are enough seeds
FILES = (TABLE, LATEX, SUMMARY, BEST, FIGURE, PROFILES, PROFILE_FIGURE)
THRESHOLDS = 41  # of a performance profile
NONE = "-"
Rows = Sequence[Mapping[str, Any]]
RULE = (
    "chosen: fewest leaves within one standard error of the highest ratio, then the best of its seeds",
    "a ratio that is chosen like this is too high: expect the mean of its setting",
)


@dataclass(frozen=True)
class Asked:
    """What is compared. `experts`: their labels; episodes: of one seed and line-up, and of an extraction at most."""

    world: World
    experts: tuple[str, ...]
    algorithms: tuple[str, ...]
    held_out: int
    budget: int


class Setting(NamedTuple):
    """An algorithm at a depth."""

    algorithm: str
    depth: int

    def __str__(self) -> str:
        return f"{self.algorithm}, depth {self.depth}"


@dataclass(repr=False)
class AlgorithmsCompared(Shown):
    """A comparison: `rows` for each measure and setting, words for `differences`, and the `best` trees.

    For example:

        maviper.compare(expert, depths=[2, 3], seeds=5).to_latex()
    """

    world: str
    experts: tuple[str, ...]
    table: list[dict[str, Any]]
    differences: list[dict[str, Any]]  #: of ratios: the first algorithm less each other one, depth by depth
    best: PolicyProfile
    chosen: dict[str, Any]  #: of which setting, expert and seed the best is
    profiles: list[dict[str, Any]]  #: of ratios: the share of seeds above each threshold, a row for each
    pictures: dict[str, str]  #: file name -> SVG
    latex: str
    lines: list[str]  #: everything, for people
    making: Making
    files: dict[str, str] = field(default_factory=dict[str, str])

    @property
    def rows(self) -> list[dict[str, Any]]:
        """A row for each measure of each team, algorithm and depth; those that teams are judged by come first."""
        return self.table

    @property
    def failed(self) -> dict[str, str]:
        """The cells that failed, in words, with their messages."""
        return self.making.failed

    @property
    def code(self) -> ExitCode:
        """The exit code of the command."""
        return self.making.code

    @property
    def told(self) -> list[str]:
        """A few lines: the size of the comparison, and the best."""
        settings = len({(row["algorithm"], row["depth"]) for row in self.table})
        best = ", ".join(f"{name} {spell(value)}" for name, value in self.chosen.items())
        words = [f"{each['about']}: {_shown(each, 'difference')} {each['told']}" for each in self.differences]
        return [
            f"AlgorithmsCompared in {self.world[:40]}: {format_count(settings, 'setting')}, "
            f"{format_count(self.table[0]['seeds'], 'seed')}, {format_count(len(self.experts), 'expert')}",
            f"best: {best}",
            *words[:2],
        ]

    @property
    def document(self) -> dict[str, Any]:
        """Everything as plain data."""
        told = {"world": self.world, "experts": list(self.experts), "rows": self.table}
        told |= {"differences": self.differences, "profiles": self.profiles}
        return told | {"best": self.chosen, "failed": self.failed}

    def to_latex(self) -> str:
        r"""A table for a paper, by the package booktabs: `\\usepackage{booktabs}`, then the text as it is."""
        return self.latex

    def _repr_html_(self) -> str:
        drawn = "".join(f'<div style="max-width:36em">{picture}</div>' for picture in self.pictures.values())
        return super()._repr_html_() + drawn


def read(folder: Path, asked: Asked, making: Making) -> AlgorithmsCompared:
    """Computes everything from the cells in a folder."""
    cells = _Cells(folder, asked)
    rows = [cells.row(measure, setting) for measure in cells.measures for setting in cells.settings]
    differences = cells.differences()
    setting, row = cells.choose()
    data = runs.read(folder / CELLS / row.cell / runs.PROFILE_FILE, 2**26)
    chosen = {"algorithm": setting.algorithm, "depth": setting.depth, "expert": row.expert, "seed": row.seed}
    profiles = cells.profiles()
    pictures = cells.pictures(rows) | cells.picture_profiles(profiles, setting.depth)
    lines = _lines(cells, rows, differences, f"{setting}, seed {row.seed}, expert {row.expert}", making)
    latex = _latex(cells, rows)
    best = loads(data, BEST)
    shown = rows, differences, best, chosen, profiles, pictures, latex, lines, making
    found = AlgorithmsCompared(asked.world.name, asked.experts, *shown)
    texts = {TABLE: found.to_csv(), LATEX: latex, SUMMARY: "\n".join(lines) + "\n", BEST: data.decode()}
    texts |= {PROFILES: as_csv(profiles)} if profiles else {}
    return replace(found, files=texts | pictures)


# --- numbers


class _Cells:
    """The cells of a comparison, and the numbers that they make."""

    def __init__(self, folder: Path, asked: Asked) -> None:
        self.asked, self.results = asked, read_table(folder)
        self.finder, self.game = Finder(self.results), asked.world.name.partition(",")[0]
        self.main = [asked.world.primary(team) for team in asked.world.teams]
        self.measures = list(dict.fromkeys([*self.main, *measures.list_measures(asked.world)]))
        there = {Setting(row.algorithm, row.depth) for row in self.results.cells(kind=EXTRACTION)}
        self.settings = sorted(there, key=lambda each: (asked.algorithms.index(each.algorithm), each.depth))

    @property
    def several(self) -> bool:
        """True where experts are the units."""
        return len(self.asked.experts) > 1

    def place(self, expert: str, depth: int, measure: Measure) -> Place:
        """Cells of one expert and depth."""
        return Place(self.game, expert, "", depth, measure.label)

    def number(self, name: str, of: Callable[[str], list[Part]]) -> Number:
        """A number over seeds; of several experts over these, those left out whose cells failed."""
        known: list[tuple[list[Part], Estimate, int, int]] = []
        for expert in self.asked.experts:
            try:
                parts = of(expert)
                known.append((parts, *estimate_parts(self.results, parts)))
            except KeyError:
                continue
        if not known:
            return Number(name, [], Estimate(np.nan, np.nan, 0), 0, 0)
        parts, estimate, seeds, episodes = known[0]
        if not self.several:
            return Number(name, parts, estimate, seeds, episodes)
        every = [part for parts, *_ in known for part in parts]
        return Number(name, every, of_differences([each.value for _, each, *_ in known]), len(known), episodes)

    def ratio(self, expert: str, setting: Setting, measure: Measure, seeds: Sequence[int] | None = None) -> list[Part]:
        """The ratio to the expert. KeyError where there are no cells."""
        place = self.place(expert, setting.depth, measure)
        seeds = self.finder.seeds(place, [setting.algorithm]) if seeds is None else seeds
        return self.finder.ratio(place, setting.algorithm, [JOINT.format(measure.team)], seeds)

    def value(self, expert: str, setting: Setting, measure: Measure) -> list[Part]:
        """The measure itself. KeyError where there are no cells."""
        parts = self.ratio(expert, setting, measure)
        return [Part(part.weight, part.ours) for part in parts]

    def theirs(self, expert: str, setting: Setting, measure: Measure) -> list[Part]:
        """The expert's measure in the same episodes. KeyError where there are no cells."""
        parts = self.ratio(expert, setting, measure)
        return [Part(part.weight, part.theirs) for part in parts if part.theirs is not None]

    def cells(self, setting: Setting) -> list[Row]:
        """The cells of a setting, of all experts and seeds."""
        return self.results.cells(kind=EXTRACTION, algorithm=setting.algorithm, depth=setting.depth)

    def by_seed(self, expert: str, setting: Setting, measure: Measure) -> dict[int, float]:
        """Seed -> the ratio of its trees to the expert. {} where there are no cells."""
        place, values = self.place(expert, setting.depth, measure), dict[int, float]()
        for seed in self.finder.rows(place, setting.algorithm):
            try:
                (part,) = self.ratio(expert, setting, measure, [seed])
                assert part.theirs is not None
                ((_, ours),), ((_, theirs),) = part.ours.rows(self.results), part.theirs.rows(self.results)
            except KeyError:
                continue
            with np.errstate(divide="ignore", invalid="ignore"):
                values[seed] = float(MODES[part.mode](ours.mean(), theirs.mean(), np.abs(theirs).mean()))
        return values

    def scores(self, setting: Setting, measure: Measure) -> list[Float64]:
        """The ratios of each expert, [seeds]; [] where there are too few of some: a bootstrap of few would find the
        least and the most.
        """
        every = [np.array([*self.by_seed(expert, setting, measure).values()]) for expert in self.asked.experts]
        scores = [each for each in every if len(each)]
        return scores if min(map(len, scores), default=0) >= register.read().least_seeds else []

    def profiles(self) -> list[dict[str, Any]]:
        """The performance profiles of ratios, by the measures that teams are judged by: rows for each setting."""
        every = {pair: self.scores(pair[1], pair[0]) for pair in product(self.main, self.settings)}
        known = {pair: scores for pair, scores in every.items() if scores and np.isfinite(np.concatenate(scores)).all()}
        ends = [end for scores in known.values() for each in scores for end in (each.min(), each.max())]
        thresholds = np.linspace(min([0.0, *ends]), max([1.0, *ends]), THRESHOLDS)
        return [
            {"measure": measure.label, **setting._asdict(), "threshold": float(threshold), **_three("share", *shares)}
            for (measure, setting), scores in known.items()
            for threshold, *shares in zip(thresholds, *performance_profile(scores, thresholds), strict=True)
        ]

    def row(self, measure: Measure, setting: Setting) -> dict[str, Any]:
        """The row of the table."""
        value, ratio, theirs = (
            self.number("", lambda expert, of=of: of(expert, setting, measure))
            for of in (self.value, self.ratio, self.theirs)
        )
        scores = self.scores(setting, measure)
        middle = interquartile(scores) if scores else (np.nan, np.nan, np.nan)
        cells, members = self.cells(setting), self.asked.world.teams[measure.team]
        facts = [self.results.facts(cell.cell) for cell in cells]
        return {
            "measure": measure.label,
            "better": "lower" if measure.lower_is_better else "higher",
            "algorithm": setting.algorithm,
            "depth": setting.depth,
            "experts": len({cell.expert for cell in cells}),
            "seeds": len({cell.seed for cell in cells}),
            **_three("value", value.value, *value.estimate.interval()),
            "expert": _plain(theirs.value),
            **_three("ratio", ratio.value, *ratio.estimate.interval()),
            **_three("iqm", *middle),
            "leaves": _mean([sum(told["trees"][agent]["leaves"] for agent in members) for told in facts]),
            "fidelity": _mean([np.mean([told["fidelity"][agent] for agent in members]) for told in facts]),
            "episodes": _mean([told["played"] for told in facts]),
            "cpu_seconds": _mean([cell.cpu_seconds for cell in cells]),
        }

    # --- words

    def differences(self) -> list[dict[str, Any]]:
        """The first algorithm less each other one at each depth, by the measure that teams are judged by; all words are
        corrected together.
        """
        pairs = [
            (measure, one, other)
            for measure, one, other in product(self.main, self.settings, self.settings)
            if one.depth == other.depth
            and one.algorithm == self.asked.algorithms[0]
            and other.algorithm != one.algorithm
        ]
        compared = [
            comparison(_claim(*pair[1:]), "", self.number("", lambda expert, pair=pair: self._less(expert, *pair)))
            for pair in pairs
        ]
        rows: list[dict[str, Any]] = []
        for (measure, one, other), each in zip(pairs, decide_family(compared, register.read()), strict=True):
            assert each.number is not None
            label = f"{one.algorithm} less {other.algorithm}"
            numbers = _three("difference", each.number.value, *each.number.estimate.interval())
            seen = _plain(each.visible)
            said = f"{each.word}; {seen:.3g} would have been detected" if seen and each.word == OPEN else each.word
            about = {"measure": measure.label, "depth": one.depth, "first": one.algorithm, "second": other.algorithm}
            place = f"{label}, depth {one.depth}" + (f", {measure.team}" if len(self.main) > 1 else "")
            rows.append(about | numbers | {"word": each.word, "visible": seen, "about": place, "told": said})
        return rows

    def _less(self, expert: str, measure: Measure, one: Setting, other: Setting) -> list[Part]:
        place = self.place(expert, one.depth, measure)
        seeds = self.finder.seeds(place, [one.algorithm, other.algorithm])
        return less(*(self.ratio(expert, each, measure, seeds) for each in (one, other)))

    # --- the best

    def choose(self) -> tuple[Setting, Row]:
        """The setting and the cell that RULE chooses."""
        teams = len(self.main)

        def parts(expert: str, setting: Setting) -> list[Part]:
            return [part for each in self.main for part in times(1 / teams, self.ratio(expert, setting, each))]

        numbers = {
            each: self.number("", lambda expert, each=each: parts(expert, each)).estimate for each in self.settings
        }
        worth = {each: _worth(number.value) for each, number in numbers.items()}
        best = max(worth, key=worth.__getitem__)
        error = numbers[best].error if np.isfinite(numbers[best].error) else 0.0
        near = [each for each in self.settings if worth[each] >= worth[best] - error]
        setting = min(near, key=lambda each: (self.leaves(each), -worth[each]))
        by_seed = {
            (expert, measure): self.by_seed(expert, setting, measure)
            for expert, measure in product(self.asked.experts, self.main)
        }

        def reached(cell: Row) -> float:
            return _worth(float(np.mean([by_seed[cell.expert, each].get(cell.seed, np.nan) for each in self.main])))

        return setting, max(self.cells(setting), key=reached)

    def leaves(self, setting: Setting) -> float:
        """The leaves of all agents' trees, in the mean."""
        trees = [self.results.facts(cell.cell)["trees"] for cell in self.cells(setting)]
        return float(np.mean([sum(tree["leaves"] for tree in told.values()) for told in trees]))

    # --- pictures

    def pictures(self, rows: Rows) -> dict[str, str]:
        """A figure for each team, by file name."""
        return {self._file(FIGURE, measure): self._picture(measure, rows) for measure in self.main}

    def picture_profiles(self, profiles: Rows, depth: int) -> dict[str, str]:
        """A figure of performance profiles at a depth for each team that has any, by file name."""
        drawn: dict[str, str] = {}
        for measure in self.main:
            series: dict[str, list[Point]] = {}
            for row in profiles:
                if (row["measure"], row["depth"]) == (measure.label, depth):
                    share, low, high = (row[each] for each in _names("share"))
                    series.setdefault(row["algorithm"], []).append(Point(share, low, high, row["threshold"]))
            title = f"{measure.label}: share of seeds above a ratio, depth {depth}"
            looks = _looks(series)
            if series:
                figure = figures.lines(title, "ratio to the expert", series, None, looks, to_scale=True, bands=True)
                drawn[self._file(PROFILE_FIGURE, measure)] = figure
        return drawn

    def _file(self, name: str, measure: Measure) -> str:
        """A figure's file; of each of several teams its own."""
        return name if len(self.main) == 1 else name.replace(".svg", f"-{measure.team}.svg")

    def _picture(self, measure: Measure, rows: Rows) -> str:
        shown, name = [row for row in rows if row["measure"] == measure.label], "ratio" if self.several else "value"
        series: dict[str, list[Point]] = {}
        for row in sorted(shown, key=lambda row: row["leaves"]):
            number, low, high = (np.nan if row[each] is None else row[each] for each in _names(name))
            series.setdefault(row["algorithm"], []).append(Point(number, low, high, row["leaves"]))
        known = [row["expert"] for row in shown if row["expert"] is not None]
        expert = 1.0 if self.several else float(np.mean(known)) if known else None
        what = f"{measure.label}{', ratio to the expert' if self.several else ''}"
        lower = ", lower is better" if measure.lower_is_better and not self.several else ""
        title = f"{what}{lower}, over leaves"
        ordered = {name: series[name] for name in self.asked.algorithms if name in series}
        return figures.lines(title, "leaves of the team", ordered, expert, _looks(ordered), to_scale=True)


def _looks(names: Mapping[str, Any]) -> dict[str, Mark]:
    """A mark for each algorithm, its own where it has one, else one that no other has, while there are any."""
    own = {name: MARKS[name] for name in names if name in MARKS}
    free = (mark for name, mark in reversed(MARKS.items()) if name != EXPERT and mark not in own.values())
    return {name: own.get(name) or next(free, MARKS[""]) for name in names}


def _claim(one: Setting, other: Setting) -> Claim:
    return Claim(
        id="compared",
        place="",
        says="",
        family="compared",
        statistic=register.JOINT,
        test=register.GREATER,
        first=[one.algorithm],
        second=[other.algorithm],
        cells={},
    )


def _worth(number: float) -> float:
    return number if np.isfinite(number) else -np.inf


def _mean(values: Sequence[Any]) -> float:
    return float(np.mean(values))


def _plain(number: float) -> float | None:
    return float(number) if np.isfinite(number) else None


def _names(name: str) -> tuple[str, str, str]:
    return (name, "low", "high") if name == "value" else (name, f"{name} low", f"{name} high")


def _three(name: str, *numbers: float) -> dict[str, float | None]:
    """A number and the ends of its interval, under three names; None for what is not finite."""
    return dict(zip(_names(name), map(_plain, numbers), strict=True))


# --- what people read


def _shown(row: Mapping[str, Any], name: str, digits: int = 3) -> str:
    """A number with its interval."""
    number, low, high = (row[each] for each in _names(name))
    if number is None:
        return NONE
    interval = "" if low is None or high is None else f" [{low:z.{digits}f}, {high:z.{digits}f}]"
    return f"{number:z.{digits}f}{interval}"


HEAD = ("algorithm", "depth", "mean", "ratio", "IQM", "leaves", "fidelity", "episodes", "CPU s")


def _lines(cells: _Cells, rows: Rows, differences: Rows, best: str, making: Making) -> list[str]:
    asked = cells.asked
    units = format_count(len(asked.experts), "expert") if cells.several else format_count(rows[0]["seeds"], "seed")
    lines = [
        f"world {asked.world.name}, {'experts' if cells.several else 'expert'} {', '.join(asked.experts)}",
        f"means with 95 % intervals over {units}; {asked.held_out} held-out episodes of each seed, as the expert's",
        f"equal budgets: every extraction may play {asked.budget:,} episodes; the column says how many it did",
    ]
    for measure in cells.main:
        shown = [row for row in rows if row["measure"] == measure.label]
        lower = ", lower is better" if measure.lower_is_better else ""
        lines += ["", f"{measure.label}{lower}; the expert's is {spell(shown[0]['expert'])}"]
        lines += tabulate([_with_iqm(each, HEAD.index("IQM"), shown) for each in (HEAD, *map(_row, shown))], 2)
    least = register.read().least_seeds
    if not _has_iqm(rows):
        lines += ["", f"no interquartile means (IQM) of ratios: they need {least} seeds of each expert"]
    if differences:
        few = f"under {least} {units.split()[1].removesuffix('s')}s decide nothing"
        lines += ["", f"differences of ratios; the chance of any false word is at most 5 %; {few}"]
        lines += tabulate(
            [
                ("ratios", "difference", "verdict"),
                *((each["about"], _shown(each, "difference"), each["told"]) for each in differences),
            ]
        )
    return [*lines, "", f"{BEST}: {best}", *RULE, *making.lines]


def _row(row: Mapping[str, Any]) -> list[str]:
    sizes = [f"{row['leaves']:.1f}", f"{row['fidelity']:.3f}", f"{row['episodes']:,.0f}", f"{row['cpu_seconds']:.1f}"]
    numbers = [_shown(row, "value"), _shown(row, "ratio", 2), _shown(row, "iqm", 2)]
    return [row["algorithm"], str(row["depth"]), *numbers, *sizes]


def _has_iqm(rows: Rows) -> bool:
    return any(row["iqm"] is not None for row in rows)


def _with_iqm(line: Sequence[str], place: int, rows: Rows) -> list[str]:
    """A line of a table, without the interquartile mean at its place where no row has one."""
    return [each for k, each in enumerate(line) if k != place or _has_iqm(rows)]


def _latex(cells: _Cells, rows: Rows) -> str:
    """A tabular by booktabs, with a part for each team."""
    head = ["Algorithm", "Depth", "Mean", "Ratio", "IQM of ratios", "Leaves", "Fidelity", "Episodes"]
    place = head.index("IQM of ratios")
    columns, head = "".join(_with_iqm("lrllllrr", place, rows)), _with_iqm(head, place, rows)
    lines = ["% \\usepackage{booktabs}", f"\\begin{{tabular}}{{{columns}}}", "\\toprule", f"{' & '.join(head)} \\\\"]
    for measure in cells.main:
        shown = [row for row in rows if row["measure"] == measure.label]
        lower = ", lower is better" if measure.lower_is_better else ""
        title = escape(f"{measure.label}{lower}; expert {spell(shown[0]['expert'])}")
        lines += ["\\midrule", f"\\multicolumn{{{len(head)}}}{{l}}{{{title}}} \\\\"]
        for row in shown:
            numbers = [_shown(row, "value"), _shown(row, "ratio", 2), _shown(row, "iqm", 2)]
            sizes = [f"{row['leaves']:.1f}", f"{row['fidelity']:.2f}", f"{row['episodes']:.0f}"]
            words = [name_algorithm(row["algorithm"]), str(row["depth"])]
            lines.append(f"{' & '.join(map(escape, _with_iqm([*words, *numbers, *sizes], place, rows)))} \\\\")
    return "\n".join([*lines, "\\bottomrule", "\\end{tabular}"]) + "\n"
