"""The parts of the report: ratios, rewards, robustness, ablations, features, trees and exploitability.

Does: turns numbers, and facts of cells, into figures and tables whose cells are text; says "not run" where cells are
  missing.
Assumes: numbers come from recipes alone, so that all of them can be computed again.
Does not: judge claims, or write files.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import product
from typing import Any

from codegen.errors import MaviperError
from codegen.lowering.lower import lower
from codegen.targets import svg
from maviper.evaluation.exploitability import OWN
from maviper.files import runs
from maviper.files.profiles import load
from maviper.reproduction import figures, register
from maviper.reproduction.cells.cell import CROSSPLAY, EXPLOITABILITY, EXTRACTION
from maviper.reproduction.cells.table import CELLS, Row
from maviper.reproduction.figures import Point, name_algorithm
from maviper.reproduction.recipes import IMPURITY, OPPONENTS, Book, Finder, Number, Part, Place, Source
from maviper.reproduction.register import Register, command
from maviper.reproduction.statistics import PAPER
from maviper.worlds.games.particle import SUCCESS
from maviper.worlds.world import RETURN

COMPARED = ("maviper", "iviper", "imitation", "fitted-q")
ABLATIONS = ("maviper-no-prediction", "maviper-iviper-resampling")
ABLATED = ("maviper", *ABLATIONS, "iviper")
MAIN_DEPTH = 4
NONE = "–"
MEASURES = {
    "physical-deception": tuple(f"{team} {name}" for name in SUCCESS for team in ("defenders", "adversaries")),
    "cooperative-navigation": ("agents D", "agents success r=0.316", "agents success r=0.1"),
    "predator-prey": ("predators touches", "prey touches"),
}


@dataclass(frozen=True)
class Figure:
    """A picture of its own, `name`.svg."""

    name: str
    svg: str


@dataclass(frozen=True)
class Table:
    """Rows of text under a head."""

    title: str
    head: Sequence[str]
    rows: Sequence[Sequence[str]]
    note: str = ""


@dataclass(frozen=True)
class Section:
    """A part of the report. `missing`: what was not run, and how to run it."""

    name: str
    title: str
    lead: str
    figures: Sequence[Figure] = ()
    tables: Sequence[Table] = ()
    missing: Sequence[str] = ()


@dataclass(frozen=True)
class Context:
    """The material from which sections are made. `experts`: labels in the order of the report."""

    book: Book
    known: Register
    finder: Finder
    games: Sequence[str]
    experts: Sequence[str]

    def find_number(self, name: str, parts: Callable[[], Sequence[Part]]) -> Number | None:
        """A number, or None where its cells are missing."""
        try:
            return self.book.number(name, parts())
        except KeyError:
            return None

    def command(self, options: str = "", *experts: str) -> str:
        """The command that plays what is missing, by some experts; by default all of the report."""
        return command(experts or self.experts, options)

    def places(self) -> Iterator[tuple[str, str]]:
        """Game and expert, of which there are cells."""
        for game, expert in product(self.games, self.experts):
            if self.book.results.cells(game=game, expert=expert):
                yield game, expert


@dataclass
class Collected:
    """Figures, tables and what is missing, while a section is made."""

    figures: list[Figure] = field(default_factory=list[Figure])
    tables: list[Table] = field(default_factory=list[Table])
    missing: list[str] = field(default_factory=list[str])

    def section(self, name: str, title: str, lead: str, otherwise: str = "") -> Section:
        """The section. `otherwise`: how to run it where nothing was found."""
        missing = self.missing
        if not self.figures and not self.tables and not missing:
            missing = [f"not run: {otherwise}"]
        return Section(name, title, lead, self.figures, self.tables, list(dict.fromkeys(missing)))


def format_number(number: Number | None, digits: int = 3) -> str:
    """A number with its interval, as text."""
    point = point_of(number)
    if number is None or not point.finite:
        return NONE
    if not point.ends:
        return f"{point.value:z.{digits}f}"
    low, high = point.ends
    return f"{point.value:z.{digits}f} [{low:z.{digits}f}, {high:z.{digits}f}]"


def point_of(number: Number | None, x: float = 0.0) -> Point:
    """A number as a figure shows it."""
    if number is None:
        return Point(float("nan"), float("nan"), float("nan"), x)
    return Point(number.value, *number.estimate.interval(), x)


def key(place: Place, *rest: str) -> str:
    """The name of a number."""
    where = [place.game, place.expert, place.preset, f"depth-{place.depth}"]
    where += [place.splits] * bool(place.splits)
    return "/".join([*rest, *where, *([place.measure] if place.measure else [])])


def short(*words: str) -> str:
    """The name of a file."""
    return "-".join("".join(c if c.isalnum() else "-" for c in word).strip("-") for word in words)


# --- ratios against depth


def performance(context: Context, statistic: str) -> Section:
    """The individual or joint performance ratio against depth, with the absolute values beside it."""
    one = "One tree, all other agents are experts; the mean over the team's agents."
    team = "All agents of a team are trees, their opponents are experts."
    lead = f"{one if statistic == register.INDIVIDUAL else team} A ratio of 1 is the expert's performance. "
    lead += "Where lower is better it is the inverse. A ratio is to the expert in the same episodes; beside it the "
    lead += "expert's value stands over the episodes of ten seeds."
    made = Collected()
    for game, expert in context.places():
        _ratios(context, made, statistic, Place(game, expert), MEASURES.get(game, ()), reward=False)
    return made.section(statistic, f"{statistic.capitalize()} performance", lead, context.command())


def rewards(context: Context) -> Section:
    """The ratios by reward, with the paper's formula beside ours."""
    lead = (
        "Ours is one plus the gain over the mean size of the expert's return, so that more is better and nothing is "
        "divided by 0. The paper's ||A|-|B||/A hides which of the two is larger; A is the expert."
    )
    made = Collected()
    for statistic, (game, expert) in product((register.INDIVIDUAL, register.JOINT), context.places()):
        place = Place(game, expert)
        measures = [f"{team} {RETURN}" for team in place.world.teams]
        _ratios(context, made, statistic, place, measures, reward=True)
    return made.section("reward", "Performance by reward", lead, context.command())


def _ratios(
    context: Context, made: Collected, statistic: str, place: Place, measures: Sequence[str], reward: bool
) -> None:
    """A figure for each measure and one table for the game."""
    rows: list[list[str]] = []
    for measure in measures:
        series: dict[str, list[Point]] = {}
        depths = context.book.results.list_values("depth", kind=EXTRACTION, game=place.game, preset="paper")
        for depth, algorithm in product(depths, COMPARED):
            here = Place(place.game, place.expert, depth=depth, measure=measure)
            ratio, row = ratio_row(context, statistic, here, algorithm, reward)
            if ratio is not None:
                series.setdefault(algorithm, []).append(point_of(ratio, depth))
                rows.append([measure, str(depth), name_algorithm(algorithm), *row])
        if any(point.finite for points in series.values() for point in points):
            name = short(statistic, place.game, place.expert, measure)
            title = f"{place.game}, {statistic}: {measure}; more is better"
            made.figures.append(Figure(name, figures.lines(title, "maximum depth", series)))
    head = ["measure", "depth", "algorithm", "ratio", *(["paper's formula"] if reward else []), "trees", "expert"]
    if rows:
        made.tables.append(Table(f"{place.game}, {statistic}, expert {place.expert}", head, rows))
    else:
        made.missing.append(
            f"{place.game} with {place.expert}, not run: {context.command(f'--games {place.game}', place.expert)}"
        )


def ratio_row(
    context: Context, statistic: str, place: Place, algorithm: str, reward: bool = False
) -> tuple[Number | None, list[str]]:
    """The ratio of one algorithm, and as text: the ratio, by reward the paper's too, the trees' value, the expert's."""
    finder = context.finder
    try:
        seeds = finder.seeds(place, [algorithm])
        lineups = finder.lineups(place, statistic)
        ratio = context.book.number(key(place, statistic, algorithm), finder.ratio(place, algorithm, lineups, seeds))
        absolute = context.book.number(
            key(place, f"{statistic} value", algorithm), finder.absolute(place, algorithm, lineups, seeds)
        )
        expert = context.book.number(key(place, "expert beside", algorithm), [Part(1.0, finder.alone(place))])
        formula = [
            format_number(
                context.book.number(
                    key(place, f"{statistic} formula", algorithm), finder.ratio(place, algorithm, lineups, seeds, PAPER)
                )
            )
        ]
    except KeyError:
        return None, []
    return ratio, [format_number(ratio), *(formula if reward else []), format_number(absolute), format_number(expert)]


# --- robustness


def robustness(context: Context) -> Section:
    """Tables 1, 3 and 4, ours and the published number in the same cell."""
    lead = (
        "Each cell: ours with its interval, then the paper's number. Teams of trees of depth 4 against the teams of "
        "all others; our expert stands where the paper has MADDPG."
    )
    made = Collected()
    for expert in context.experts:
        # Table 1: means over all opponents
        told = context.known.tables["average"]
        rows: list[list[str]] = []
        for row in told["rows"]:
            measure = context.known.tables[row["game"]][row["side"]]["measure"]
            place = Place(row["game"], expert, depth=MAIN_DEPTH, measure=measure)
            numbers = [_against(context, place, algorithm, []) for algorithm in told["algorithms"]]
            if any(numbers):
                paper = [f"{mean:g} ({spread:g})" for mean, spread in zip(row["mean"], row["deviation"], strict=True)]
                cells = [f"{format_number(number, 2)} | {text}" for number, text in zip(numbers, paper, strict=True)]
                rows.append([row["game"], measure, *cells])
        head = ["game", "measure", *map(name_algorithm, told["algorithms"])]
        average = [Table(f"{told['title']}, expert {expert}", head, rows, told["note"])] if rows else []
        each = [
            table for game in ("predator-prey", "physical-deception") for table in _opponents(context, game, expert)
        ]
        made.tables += [*average, *each]
        if each and not average:
            against = f"not run against all of {', '.join(OPPONENTS)}"
            here = context.command(f"--depths {MAIN_DEPTH}", expert)
            made.missing.append(f"Table 1, {expert}: {against}: {here}")
    return made.section("robustness", "Robustness: Tables 1, 3 and 4", lead, context.command("--depths 4"))


def _against(context: Context, place: Place, algorithm: str, opponents: list[str]) -> Number | None:
    """The mean measure of a team over opponents; [] stands for all of them."""

    def parts() -> list[Part]:
        seeds = context.finder.seeds(place, [""], CROSSPLAY)
        return context.finder.against(place, algorithm, opponents or OPPONENTS, seeds)

    return context.find_number(key(place, "against", "-".join(opponents) or "all", algorithm), parts)


def _opponents(context: Context, game: str, expert: str) -> list[Table]:
    """Table 3 or 4, one table for each side that the paper prints."""
    told = context.known.tables[game]
    tables: list[Table] = []
    algorithms = context.known.tables["opponents"]["algorithms"]
    for side in ("attackers", "defenders"):
        printed = told.get("attack" if side == "attackers" else "defence", told["attack"])
        place = Place(game, expert, depth=MAIN_DEPTH, measure=told[side]["measure"])
        rows: list[list[str]] = []
        for line, one in enumerate(algorithms):
            cells: list[str] = []
            for column, other in enumerate(algorithms):
                ours, theirs = (one, other) if side == "attackers" else (other, one)
                number = _against(context, place, ours, [theirs])
                cells.append(NONE if number is None else f"{format_number(number, 2)} | {printed[line][column]:g}")
            rows.append([f"{told['attackers']['team']}: {name_algorithm(one)}", *cells])
        head = [
            f"{place.measure}, by",
            *(f"{told['defenders']['team']}: {name_algorithm(name)}" for name in algorithms),
        ]
        if any(cell != NONE for row in rows for cell in row[1:]):
            tables.append(Table(f"{told['title']}; {place.measure}; expert {expert}", head, rows))
    return tables


# --- ablations


def ablation(context: Context) -> Section:
    """The paper's two ablations, of deception's defenders."""
    made = Collected()
    for game, expert in context.places():
        measure = MEASURES.get(game, ("",))[0]
        place = Place(game, expert, depth=MAIN_DEPTH, measure=measure)
        for statistic in (register.JOINT, register.INDIVIDUAL):
            rows = {name: ratio_row(context, statistic, place, name) for name in ABLATED}
            there = {name: both for name, both in rows.items() if both[0] is not None}
            if any(name in there for name in ABLATIONS):
                title = f"ablation, {statistic}, {measure}, {expert}"
                dots = [(name_algorithm(name), name, point_of(ratio)) for name, (ratio, _) in there.items()]
                made.figures.append(Figure(short(title, game), figures.dots(title, "ratio to the expert", dots)))
                texts = [[name_algorithm(name), *row] for name, (_, row) in there.items()]
                head = ["algorithm", "ratio", "trees", "expert"]
                made.tables.append(Table(f"{title}, depth {place.depth}", head, texts))
    lead = "Ratios at depth 4: of the paper's two ablations, and of what they are between."
    return made.section("ablation", "Ablations", lead, context.command("--depths 4"))


# --- features and trees


def features(context: Context) -> Section:
    """Shows the features on which the defenders' trees rest, MAVIPER's and IVIPER's."""
    lead = (
        "Means over seeds at depth 4. First the share of the impurity that splits on a feature remove, on the "
        "expert's own states, which are the same for all trees; then the share of decisions that test the feature."
    )
    made = Collected()
    games = [each for each in context.places() if each[0] == "physical-deception"]
    for (game, expert), algorithm, what in product(games, ("maviper", "iviper"), (IMPURITY, "tested")):
        place = Place(game, expert, depth=MAIN_DEPTH)
        rows = list(context.finder.rows(place, algorithm).values())
        agents = place.world.teams["defenders"]
        told: dict[str, Any] = context.book.results.facts(rows[0].cell).get("importances", {}) if rows else {}
        names = {agent: list(told.get(agent, {}).get(IMPURITY, {})) for agent in agents}
        columns = list(dict.fromkeys(name for each in names.values() for name in each))
        if not columns:
            continue
        values = [[_mean(context, rows, agent, what, name) for name in columns] for agent in agents]
        title = f"{name_algorithm(algorithm)}, {what}, {expert}"
        picture = Figure(short("features", algorithm, what, expert), figures.heat(title, agents, columns, values))
        made.figures.append(picture)
    return made.section("features", "Feature importances", lead, context.command())


def _mean(context: Context, rows: list[Row], agent: str, what: str, feature: str) -> float:
    """The mean over seeds; 0 for a feature that the agent does not have."""
    path = ("importances", agent, what, feature)
    source = Source(tuple((row.cell, "") for row in rows), facts=((1.0, path),))
    name = f"features/{rows[0].game}/{rows[0].expert}/{rows[0].algorithm}/{'/'.join(path[1:])}"
    number = context.find_number(name, lambda: [Part(1.0, source)])
    return 0.0 if number is None else number.value


def trees(context: Context) -> Section:
    """The trees of depth 2 that the first seed of MAVIPER gives in navigation, as in the paper's figure 1."""
    lead = "MAVIPER's trees of depth 2 in cooperative navigation, first seed. A split goes left if it holds."
    made = Collected()
    for expert in context.experts:
        rows = context.finder.rows(Place("cooperative-navigation", expert, depth=2), "maviper")
        path = context.book.results.folder / CELLS / (rows[min(rows)].cell if rows else "") / runs.PROFILE_FILE
        if not rows or not path.is_file():
            continue
        try:
            profile = load(path)
        except MaviperError as error:
            made.missing.append(str(error).split("\n")[0])
            continue
        pictures = svg.emit(lower(profile), profile)
        made.figures += [Figure(short("tree", expert, name[:-4]), text) for name, text in pictures.items()]
    return made.section("trees", "Trees", lead, context.command("--games cooperative-navigation --depths 2"))


# --- exploitability


def exploitability(context: Context) -> Section:
    """Shows the gain of the best of several responders: a lower bound."""
    lead = (
        "A lower bound: what the responder that was best on some episodes gains over the team's own opponents on other "
        "episodes. Its interval may cross 0. The paper plots the responder's raw return, which stands beside it. "
        "Lower is better."
    )
    made = Collected()
    for (game, expert), depth in product(
        context.places(), context.book.results.list_values("depth", kind=EXPLOITABILITY)
    ):
        place = Place(game, expert, depth=depth)
        for team in place.world.teams:
            rows: list[list[str]] = []
            dots: list[tuple[str, str, Point]] = []
            for algorithm in context.book.results.list_values(
                "algorithm", kind=EXPLOITABILITY, game=game, expert=expert
            ):
                told = _read_exploitability(context, place, algorithm, team)
                if told is not None:
                    dots.append((name_algorithm(algorithm), algorithm, told[0]))
                    rows.append([name_algorithm(algorithm), *told[1]])
            title = f"exploitability of {team}, depth {depth}, {expert}"
            if rows:
                picture = figures.dots(title, "gain of the opponents, at least", dots)
                made.figures.append(Figure(short("exploitability", game, team, str(depth), expert), picture))
                head = ["algorithm", "gain, at least", "raw return", "responders chosen (seeds)"]
                made.tables.append(Table(title, head, rows))
    return made.section("exploitability", "Exploitability", lead, context.command())


def _read_exploitability(context: Context, place: Place, algorithm: str, team: str) -> tuple[Point, list[str]] | None:
    finder = context.finder
    try:
        seeds = finder.seeds(place, [algorithm], EXPLOITABILITY)
        gained = finder.exploitability(place, algorithm, team, seeds)
        gain = context.book.number(key(place, "exploitability", algorithm, team), gained)
    except KeyError:
        return None
    places = gained[0].ours.places
    raw = context.find_number(
        key(place, "raw return", algorithm, team), lambda: [Part(1.0, Source(places, _returns(context, places[0])))]
    )
    names = [lineup.partition(":")[2] for _, lineup in places]
    counts = ", ".join(f"{name} ({names.count(name)})" for name in sorted(set(names), key=lambda each: each != OWN))
    return point_of(gain), [format_number(gain), format_number(raw), counts]


def _returns(context: Context, place: tuple[str, str]) -> str:
    """The return's name among the measures of a line-up. KeyError where it has none."""
    cell, lineup = place
    names = [measure for name, measure in context.book.results.values(cell) if name == lineup]
    returns = sorted(name for name in names if name.endswith(RETURN))
    if not returns:
        raise KeyError("no return")
    return returns[0]
