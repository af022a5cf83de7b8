"""Curves of the report: how extractions learn, and what a budget of episodes buys.

Does: reads the histories that extraction cells keep, one row for each round.
Assumes: histories of cells that refine nothing; rounds of agents that are extracted one by one are numbered as parts.
Does not: play, or show held-out performance in place of the score that an extraction chooses by.
"""

from collections.abc import Mapping, Sequence
from statistics import mean
from typing import Any

from maviper.reproduction import figures, register
from maviper.reproduction.figures import Point, name_algorithm
from maviper.reproduction.recipes import Part, Place
from maviper.reproduction.sections import (
    COMPARED,
    MAIN_DEPTH,
    MEASURES,
    Collected,
    Context,
    Figure,
    Section,
    Table,
    key,
    ratio_row,
    short,
)

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
