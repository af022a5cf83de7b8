"""The parts of the report beyond performance: features, trees, exploitability, leaf budgets, curves, and checks.

Does: turns facts of cells, numbers of special cells, and the histories that extraction cells keep, one row for each
  round, into figures and tables.
Assumes: facts as the cells keep them, histories of cells that refine nothing; rounds of agents that are extracted one
  by one are numbered as parts; parts that a tier does not play are said to be missing.
Does not: judge claims, write files, or show held-out performance in place of the score that an extraction chooses by.
"""

import statistics
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import product
from statistics import mean
from typing import Any

from codegen.errors import MaviperError
from codegen.lowering.lower import lower
from codegen.targets import svg
from maviper.evaluation.exploitability import OWN
from maviper.files import runs
from maviper.files.profiles import load
from maviper.reproduction import figures, register
from maviper.reproduction.cells.cell import EXPLOITABILITY, EXTRACTION
from maviper.reproduction.cells.table import CELLS, Row
from maviper.reproduction.figures import Point, name_algorithm
from maviper.reproduction.recipes import IMPURITY, Part, Place, Source
from maviper.reproduction.sections import (
    COMPARED,
    MAIN_DEPTH,
    MEASURES,
    NONE,
    Collected,
    Context,
    Figure,
    Section,
    Table,
    format_number,
    key,
    point_of,
    ratio_row,
    short,
)
from maviper.worlds.world import RETURN

BUDGETS = (100, 250, 500, 1_000, 2_500, 10_000)  # rollout episodes
Rounds = Sequence[Mapping[str, Any]]


def curves(context: Context) -> Section:
    """Plots the growth of the best iterate's score with the episodes played, first seed."""
    lead = (
        "The score by which an extraction chooses, of its best iterate, against episodes played. First seed, "
        "depth 4; the first agent's where agents are extracted one by one."
    )
    made = Collected()
    for game, expert in context.places():
        series: dict[str, list[Point]] = {}
        for algorithm in COMPARED:
            histories = _rounds(context, Place(game, expert, depth=MAIN_DEPTH), algorithm)
            first: Rounds = histories[0] if histories else []
            points = [_step(step) for step in first if not step.get("part")]
            series[algorithm] = [point for point in points if point is not None]
        if any(series.values()):
            picture = figures.lines(f"{game}, {expert}", "episodes", series, None)
            made.figures.append(Figure(short("curve", game, expert), picture))
    return made.section("curves", "Learning curves", lead, context.command())


def _rounds(context: Context, place: Place, algorithm: str) -> list[Rounds]:
    """The history of each seed's extraction."""
    rows = context.finder.rows(place, algorithm)
    return [context.book.results.facts(rows[seed].cell).get("curve", []) for seed in sorted(rows)]


def _step(step: Mapping[str, Any]) -> Point | None:
    score, episodes = step.get("best", step.get("score")), step.get("episodes")
    if not isinstance(score, int | float) or not isinstance(episodes, int | float):
        return None
    return Point(float(score), float("nan"), float("nan"), float(episodes))


# --- budgets


def budgets(context: Context) -> Section:
    """Shows what a team of trees reaches after so many rollout episodes, and what whole extractions spent."""
    lead = (
        "The primary measure of a team of trees against expert opponents, in the iterate that is the best so far by "
        "all teams, after at most so many rollout episodes. Depth 4, mean over seeds. It is measured in the episodes "
        "by which iterates are chosen, so it is slightly too high; those do not count. IVIPER extracts one agent after "
        "the other and has no team before its end. The tables give the spending of whole extractions beside their "
        "held-out ratios."
    )
    made = Collected()
    for game, expert in context.places():
        place = Place(game, expert, depth=MAIN_DEPTH)
        for team, measure in _primary(game, place.world.teams).items():
            here = Place(game, expert, depth=MAIN_DEPTH, measure=measure)
            series = {name: _average_budgets(_rounds(context, here, name), team) for name in COMPARED}
            if any(series.values()):
                alone = context.find_number(key(here, "expert alone"), lambda here=here: _alone(context, here))
                reference = None if alone is None else alone.value
                title = f"{measure}, {expert}"
                picture = figures.lines(title, "rollout episodes, at most", series, reference)
                made.figures.append(Figure(short("budget", game, expert, team), picture))
        rows = [row for name in COMPARED for row in _spending(context, place, name)]
        head = ["algorithm", "rollout episodes", "measure", "joint ratio", "trees", "expert"]
        made.tables += [Table(f"{game}, expert {expert}: whole extractions", head, rows)] if rows else []
    return made.section("budgets", "Budget curves", lead, context.command(f"--depths {MAIN_DEPTH}"))


def _primary(game: str, teams: Mapping[str, Sequence[str]]) -> dict[str, str]:
    """Team -> the measure that extractions choose by."""
    known = {team: [each for each in MEASURES.get(game, ()) if each.startswith(f"{team} ")] for team in teams}
    return {team: measures[0] for team, measures in known.items() if measures}


def _alone(context: Context, place: Place) -> list[Part]:
    return [Part(1.0, context.finder.alone(place))]


def _average_budgets(histories: Sequence[Rounds], team: str) -> list[Point]:
    """The mean over seeds at each budget that all seeds reached; an extraction that ended keeps what it had."""
    if any(step.get("part") for rounds in histories for step in rounds):
        return []
    points: list[Point] = []
    for budget in BUDGETS:
        within = [[step for step in rounds if step["episodes"] <= budget] for rounds in histories]
        best = [steps[-1].get(f"best {team}") for steps in within if steps]
        values = [float(value) for value in best if isinstance(value, int | float)]
        if values and len(values) == len(histories):
            points.append(Point(mean(values), float("nan"), float("nan"), budget))
    return points


def _spending(context: Context, place: Place, algorithm: str) -> list[list[str]]:
    """Returns the episodes that whole extractions of one algorithm spent, a row for each team's held-out ratio."""
    spent: list[int] = []
    for rounds in _rounds(context, place, algorithm):
        last = {step.get("part", 0): step["episodes"] for step in rounds}
        spent.append(sum(last.values()))
    rows: list[list[str]] = []
    for measure in _primary(place.game, place.world.teams).values() if spent else ():
        here = Place(place.game, place.expert, depth=place.depth, measure=measure)
        ratio, told = ratio_row(context, register.JOINT, here, algorithm)
        rows += [[name_algorithm(algorithm), f"{mean(spent):.0f}", measure, *told]] if ratio is not None else []
    return rows


FULL = "--full"
RELEASED, EXACT, HISTOGRAM = "released", "exact", "histogram"
SHARE = "distinct_targets"


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
        names = {agent: _names(context, rows, agent) for agent in agents}
        columns = list(dict.fromkeys(name for each in names.values() for name in each))
        if not columns:
            continue
        values = [[_mean(context, rows, agent, what, name) for name in columns] for agent in agents]
        title = f"{name_algorithm(algorithm)}, {what}, {expert}"
        picture = Figure(short("features", algorithm, what, expert), figures.heat(title, agents, columns, values))
        made.figures.append(picture)
    return made.section("features", "Feature importances", lead, context.command())


def _names(context: Context, rows: list[Row], agent: str) -> list[str]:
    told: dict[str, Any] = context.book.results.facts(rows[0].cell).get("importances", {}) if rows else {}
    return list(told.get(agent, {}).get(IMPURITY, {}))


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


# --- budgets of leaves, and what was checked


def leaf_budgets(context: Context) -> Section:
    """Joint ratios with trees of at most 4, 8, 16 and 32 leaves."""
    made = Collected()
    results = context.book.results
    for game, expert in context.places():
        for measure in MEASURES.get(game, ())[:1]:
            series: dict[str, list[Point]] = {}
            rows: list[list[str]] = []
            cells = [row for row in results.cells(kind=EXTRACTION, game=game, expert=expert) if row.leaves]
            for leaves, depth, algorithm in sorted({(row.leaves, row.depth, row.algorithm) for row in cells}):
                place = Place(game, expert, depth=depth, measure=measure, leaves=leaves)
                ratio, told = _joint(context, place, algorithm)
                series.setdefault(algorithm, []).append(point_of(ratio, leaves))
                rows.append([str(leaves), name_algorithm(algorithm), *told, _expert(context, place)])
            if rows:
                picture = figures.lines(f"{measure}, joint, {expert}", "leaves of a tree, at most", series)
                made.figures.append(Figure(short("leaves", game, expert), picture))
                head = ["leaves", "algorithm", "ratio", "trees", "expert"]
                made.tables.append(Table(f"{game}, {measure}, expert {expert}", head, rows))
    return made.section(
        "leaves", "Leaf budgets", "Trees of at most so many leaves, whole teams.", context.command(FULL)
    )


def _joint(context: Context, place: Place, algorithm: str) -> tuple[Any, list[str]]:
    """The joint ratio and value of one algorithm."""
    finder, lineups = context.finder, [f"joint:{place.team}"]
    name = f"{algorithm}/{place.splits or 'most'}"
    ratio = context.find_number(
        key(place, "joint", name), lambda: finder.ratio(place, algorithm, lineups, finder.seeds(place, [algorithm]))
    )
    value = context.find_number(
        key(place, "joint value", name),
        lambda: finder.absolute(place, algorithm, lineups, finder.seeds(place, [algorithm])),
    )
    return ratio, [format_number(ratio), format_number(value)]


# --- what was checked


def _expert(context: Context, place: Place) -> str:
    """Returns the expert's result against itself in the episodes of ten seeds."""
    name = f"expert/{place.game}/{place.expert}/{place.measure}"
    return format_number(context.find_number(name, lambda: [Part(1.0, context.finder.alone(place))]))


def violations(context: Context) -> Section:
    """The exact share of world states in which two defenders go for one target."""
    lead = (
        "The claim distinct_targets: no two defenders go for the same target. The share of the start region in which "
        "it fails is exact for each team of trees; the interval is over seeds."
    )
    made = Collected()
    rows: list[list[str]] = []
    results = context.book.results
    wanted = {"kind": EXTRACTION, "game": "physical-deception", "leaves": 0}
    kinds = {(row.expert, row.preset, row.depth, row.algorithm, row.splits) for row in results.cells(**wanted)}
    for expert, preset, depth, algorithm, splits in sorted(kinds):
        about = {"expert": expert, "preset": preset, "depth": depth, "algorithm": algorithm, "splits": splits}
        cells = [row.cell for row in results.cells(**wanted, **about)]
        known = [cell for cell in cells if isinstance(results.facts(cell).get(SHARE, {}).get("share"), float | int)]
        if not known:
            continue
        source = Source(tuple((cell, "") for cell in known), facts=((1.0, (SHARE, "share")),))
        place = Place("physical-deception", expert, preset, depth, splits=splits)
        number = context.find_number(key(place, SHARE, algorithm), lambda source=source: [Part(1.0, source)])
        least, most = (pick(results.facts(cell)[SHARE]["share"] for cell in known) for pick in (min, max))
        extent = f"{least:.4f} to {most:.4f}"  # as the share itself
        about = [expert, preset, splits, str(depth), name_algorithm(algorithm), format_number(number, 4), extent]
        rows.append([*about, f"{len(known)} of {len(cells)}"])
    head = ["expert", "preset", "splits", "depth", "algorithm", "violating share", "least to most", "teams known"]
    made.tables += [Table("States that violate distinct_targets", head, rows)] if rows else []
    return made.section(
        "violations", "Violations of distinct_targets", lead, context.command("--games physical-deception")
    )


def released_code(context: Context) -> Section:
    """The authors' code beside the paper's text: which share of the published gap is an artefact."""
    lead = (
        "Joint performance at depth 4. Preset paper follows the text, released the authors' code with its accidents: "
        "its IVIPER and imitation trees do nothing wherever no action has a majority."
    )
    made = Collected()
    for game, expert in context.places():
        rows: list[list[str]] = []
        for measure, algorithm in product(MEASURES.get(game, ())[:2], COMPARED):
            here = [
                _joint(context, Place(game, expert, preset, MAIN_DEPTH, measure), algorithm)
                for preset in ("paper", RELEASED)
            ]
            if here[1][0] is not None:
                paper = _read_published(context, game, measure, algorithm)
                ours = [text for _, told in here for text in told]
                rows.append(
                    [
                        measure,
                        name_algorithm(algorithm),
                        *ours,
                        _expert(context, Place(game, expert, measure=measure)),
                        paper,
                    ]
                )
        head = ["measure", "algorithm", "paper: ratio", "paper: trees", "released: ratio", "released: trees"]
        made.tables += [Table(f"{game}, expert {expert}", [*head, "expert", "published: trees"], rows)] if rows else []
    return made.section("released", "The released code", lead, context.command(FULL))


def _read_published(context: Context, game: str, measure: str, algorithm: str) -> str:
    """Reads the value in the paper's Tables 3 and 4 for a team of trees against experts."""
    told, names = context.known.tables.get(game), context.known.tables["opponents"]["algorithms"]
    if told is None or algorithm not in names:
        return NONE
    if told["attackers"]["measure"] == measure:
        return f"{told['attack'][names.index(algorithm)][names.index('expert')]:g}"
    table = told.get("defence", told["attack"])
    known = told["defenders"]["measure"] == measure
    return f"{table[names.index('expert')][names.index(algorithm)]:g}" if known else NONE


def splits(context: Context) -> Section:
    """MAVIPER with every threshold beside histograms, one cell a game."""
    lead = "MAVIPER at depth 4, one seed: every threshold beside thresholds from histograms. Intervals are of episodes."
    made = Collected()
    rows: list[list[str]] = []
    for game, expert in context.places():
        for measure in MEASURES.get(game, ())[:2]:
            place = Place(game, expert, depth=MAIN_DEPTH, measure=measure, splits=EXACT)
            seeds = set(context.finder.rows(place, "maviper"))
            other = context.finder.rows(replace(place, splits=HISTOGRAM), "maviper")
            if seeds & set(other):
                rows.append([game, expert, measure, *_both(context, place, sorted(seeds & set(other)))])
    head = ["game", "expert", "measure", "exact", "histogram", "seconds, exact", "seconds, histogram"]
    made.tables += [Table("Joint values", head, rows)] if rows else []
    return made.section("splits", "Exact splits and histograms", lead, context.command())


def _both(context: Context, place: Place, seeds: list[int]) -> list[str]:
    values: list[str] = []
    seconds: list[str] = []
    for kind in (EXACT, HISTOGRAM):
        here = replace(place, splits=kind)
        rows = context.finder.rows(here, "maviper")
        number = context.find_number(
            key(here, "splits", "maviper"),
            lambda here=here: context.finder.absolute(here, "maviper", [f"joint:{here.team}"], seeds),
        )
        values.append(format_number(number))
        seconds.append(f"{statistics.mean(rows[seed].cpu_seconds for seed in seeds):.1f}")
    return [*values, *seconds]


ALL = (features, trees, exploitability, curves, budgets, leaf_budgets, violations, released_code, splits)
