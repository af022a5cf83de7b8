"""Evaluation: a profile, an expert or a mix of both, against any opponents, beside the expert in the same place.

Does: `evaluate` for controllers; finds those who are named; the answer as tables or plain data.
Assumes: evaluation episodes are the same for everybody, so that numbers can be compared across commands.
Does not: play or count anything itself (crossplay.py), or find controllers (players.py).
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import count
from typing import Any, NamedTuple, Unpack

from codegen import ir
from codegen.errors import InputError, UnknownNameError
from codegen.rows import Shown
from codegen.wording import format_count
from maviper.console import LABEL_WIDTH, Console, tabulate
from maviper.episodes import measures
from maviper.episodes.play import Controller, Episodes, counting_played, points
from maviper.evaluation.crossplay import (
    DRAWS,
    Alone,
    Interval,
    Key,
    Lineup,
    Stage,
    Standing,
    TreeFacts,
    Watch,
    cast,
    decisions,
    key,
    standings,
    tree_facts,
)
from maviper.evaluation.held_out import stop_of
from maviper.evaluation.players import RANDOM, SUBJECT, Player, find_player, find_shipped
from maviper.evaluation.why import Causes, causes, ensure_branched
from maviper.experts.finding import origin_of
from maviper.options import EvaluateOptions, make_request
from maviper.worlds import World, find
from maviper.worlds.world import Int

EPISODES = 1_000
NO_EPISODE = "no episode"
MAX_EPISODES = 100_000  # the block of seeds from MEASUREMENT_SEEDS on has a million


class Reached(NamedTuple):
    """A measure of a team, in its own unit: value and 95 % interval, the expert's value in its place, and their ratio
    with its interval. What needs an expert is None where there was none.

        maviper.evaluate(team, expert=expert)["defenders", "success"].ratio
    """

    value: float
    interval: tuple[float, float]
    expert: float | None
    ratio: float | None
    ratio_interval: tuple[float, float] | None


@dataclass(frozen=True, repr=False)
class Evaluation(Shown):
    """Holds what was measured. What needs an expert is None throughout where there was none.

        maviper.evaluate(team, episodes=100).rows

    `evaluation["defenders", "success"]` is a team's measure, by its name or the beginning of it: value, interval and
    ratio. A third name says against whom; without it, against the first.
    """

    world: str
    episodes: int
    against: Mapping[str, tuple[Standing, ...]]  #: opponents' name -> every measure of every team against them
    trees: Mapping[str, TreeFacts]  #: agent -> its tree, where it has one
    #: causes of each gap to the expert, by opponents as `against`, where `why` asked for them
    why: Mapping[str, tuple[Causes, ...]] = field(default_factory=dict[str, tuple[Causes, ...]])

    def __getitem__(self, names: str | tuple[str, ...]) -> Reached:
        team, name, *others = (names, "") if isinstance(names, str) else names
        where = others[0] if others else next(iter(self.against))
        if where not in self.against:
            raise UnknownNameError("opponent", where, self.against)
        mine = {row.measure.name: row for row in self.against[where] if row.measure.team == team}
        if not mine:
            raise UnknownNameError("team", team, dict.fromkeys(row.measure.team for row in self.against[where]))
        found = mine.get(name) or next((row for known, row in mine.items() if known.startswith(name)), None)
        if found is None:
            raise UnknownNameError("measure", name, mine)
        if found.value is None:
            raise InputError(f"no episode says anything of {found.measure.label}", "", "play more episodes")
        ratio = found.joint
        return Reached(
            found.value.value,
            (found.value.low, found.value.high),
            None if found.expert is None else found.expert.value,
            None if ratio is None else ratio.value,
            None if ratio is None else (ratio.low, ratio.high),
        )

    @property
    def rows(self) -> list[dict[str, Any]]:
        """A row for each team's measure against each of the opponents."""
        standings = ((against, row) for against, rows in self.against.items() for row in rows)
        return [
            {
                "against": against,
                "team": row.measure.team,
                "measure": row.measure.name,
                **_three("", row.value),
                **_three("expert", row.expert),
                **_three("ratio", row.joint),
            }
            for against, row in standings
        ]

    @property
    def told(self) -> list[str]:
        """The first measures, and over how many episodes."""
        first = next(iter(self.against.values()))
        said = [
            f"{row.measure.label}: {_or(row.value, NO_EPISODE)}{'' if row.joint is None else f', ratio {row.joint}'}"
            for row in first
        ]
        return [f"Evaluation of {self.world}, {format_count(self.episodes, 'episode')}", *said[:4]]


def _three(name: str, number: Interval | None) -> dict[str, float | None]:
    """A number and its interval under three names."""
    ends = (None, None, None) if number is None else (number.value, number.low, number.high)
    return dict(zip((name or "value", f"{name} low".strip(), f"{name} high".strip()), ends, strict=True))


@dataclass(frozen=True)
class Contest:
    """The subject and its opponents. The subject and each of the opponents are one controller for each agent."""

    world: World
    subject: Sequence[Controller]
    opponents: Mapping[str, Sequence[Controller]]
    expert: Controller | None = None
    trees: Sequence[ir.AgentPolicy] = ()  # the subject's, where agents have them
    why: bool = False  # whether the gap to the expert is split into its causes


def evaluate(
    contest: Contest,
    teams: Sequence[str] = (),
    episodes: int = EPISODES,
    on_played: Callable[[int, int], None] = lambda done, total: None,
) -> Evaluation:
    """Every measure of `teams` (all when empty) on held-out episodes, the same ones for every line-up.

    A team's own agents are the subject, the expert or one the subject and the others the expert; all other teams are
    the opponents. `on_played`: done and total episodes. InputError for a number of episodes out of range,
    UnknownNameError for a team.
    """
    world, subject, opponents = contest.world, contest.subject, contest.opponents
    expert, trees = contest.expert, contest.trees
    ensure_episodes(episodes)
    for team in teams:
        if team not in world.teams:
            raise UnknownNameError("team", team, world.teams, "--team")
    asked = [team for team in world.teams if team in (teams or world.teams)]
    casts = {name: [cast(world, team, subject, others, expert) for team in asked] for name, others in opponents.items()}
    everybody = [each for per_team in casts.values() for each in per_team]
    for each in everybody if contest.why else ():
        ensure_branched(world, each)
    lineups = {key(lineup): lineup for each in everybody for lineup in each.lineups}
    placed = {world.agents.index(tree.agent): tree for tree in trees if world.team_of(tree.agent) in asked}
    own: Lineup = tuple(subject)
    experts: Lineup = () if expert is None else (expert,) * len(world.agents)
    watches: dict[Key, Watch] = {}
    if placed:
        watches[key(own)] = lambda met: decisions(placed, met, None if expert is None else _ask_expert(expert, met))
        watches |= {key(experts): lambda met: decisions(placed, met, met.actions)} if experts else {}
        lineups |= {key(lineup): lineup for lineup in (own, experts) if lineup}
    stage = Stage(world, range(measures.MEASUREMENT_SEEDS, measures.MEASUREMENT_SEEDS + episodes))
    seen: dict[Key, ir.Float64] = {}
    explained = len(everybody) if contest.why else 0  # each takes as long as a line-up, about
    total, played = episodes * (len(lineups) + explained), episodes * len(lineups)
    with counting_played(lambda done: on_played(done, total)):
        for name, lineup in lineups.items():
            seen[name] = stage.play(lineup, watches.get(name))
    against = {name: tuple(row for each in of for row in standings(stage, each)) for name, of in casts.items()}
    why = dict[str, tuple[Causes, ...]]()
    for name, per_team in casts.items() if contest.why else ():
        for each in per_team:
            why[name] = (*why.get(name, ()), *causes(world, each, stage.seeds))
            played += episodes
            on_played(played, total)
    facts = tree_facts(placed, seen[key(own)], seen[key(experts)] if experts else None) if placed else {}
    return Evaluation(world.name, episodes, against, facts, why)


def ensure_episodes(episodes: int) -> None:
    """InputError for a number of held-out episodes out of range."""
    if not 1 <= episodes <= MAX_EPISODES:
        raise InputError(f"the number of episodes must be from 1 to {MAX_EPISODES}, not {episodes}", "--episodes")


def _ask_expert(expert: Controller, episodes: Episodes) -> Int:
    """The expert's actions in the states of episodes, as `Episodes.actions`."""
    observations, state = points(episodes)
    return expert.act(range(len(observations)), observations, state).reshape(episodes.actions.shape)


@dataclass(frozen=True)
class Request:
    """The evaluation that is asked for, found and checked."""

    world: World
    subject: Player
    replaced: Mapping[str, Player]  # agent or team -> who plays in the subject's place
    against: Mapping[str, Player]  # {}: the subject itself
    expert: Player | None
    notes: tuple[str, ...]  # what was left out, and why
    teams: tuple[str, ...] = ()  # (): all
    episodes: int = EPISODES
    why: bool = False

    @property
    def players(self) -> list[Player]:
        """The subject's player for each agent; what is named later wins."""
        places = dict.fromkeys(self.world.agents, self.subject)
        for name, player in self.replaced.items():
            places |= dict.fromkeys(self.world.teams.get(name, (name,)), player)
        return list(places.values())


def request(text: Any, **options: Unpack[EvaluateOptions]) -> Request:
    """Finds everything that is named, or given itself. InputError for what cannot be used."""
    asked = make_request(EvaluateOptions, options)
    given = None if asked.world is None else find(asked.world, giving=True)
    subject, world = find_player(text, SUBJECT, given)
    replaced = dict(_replacement(item, world) for item in asked.replaced)
    expert = None if asked.expert is None else find_player(asked.expert, "--expert", world)[0]
    if expert and expert.kind == RANDOM:
        raise InputError("random is not an expert", "--expert", "to play against it, use --against random")
    known = [subject, *replaced.values()]
    origins = {player.origin for player in known if player.trees}
    notes: list[str] = []
    if expert is None and len(origins) == 1 and "" not in origins:
        (origin,) = origins
        alike = [player for player in known if origin in (player.id, origin_of(player.controller))]
        expert = alike[0] if alike else find_shipped(origin, world)
    if expert is None:
        why = "the expert of the profile is not a shipped one" if origins - {""} else "nothing to compare with"
        notes.append(f"no ratios, no fidelity: {why}; --expert names it")
    elif origins - {expert.id, origin_of(expert.controller), ""}:
        notes.append("another expert than the one that the profile was extracted from")
    against = _against(asked.against, world) or ({expert.name: expert} if expert else {})
    teams = (asked.team,) if asked.team else ()
    return Request(world, subject, replaced, against, expert, tuple(notes), teams, asked.episodes, asked.why)


def _against(texts: Sequence[Any], world: World) -> dict[str, Player]:
    if texts and len(world.teams) == 1:
        raise InputError("there are no opponents in this world", f"--against: {world.name}", "leave --against out")
    named: dict[str, Player] = {}
    for text in texts:
        player = find_player(text, "--against", world)[0]
        names = (f"{player.name} #{k}" if k > 1 else player.name for k in count(1))
        named[next(name for name in names if name not in named)] = player
    return named


def _replacement(text: Any, world: World) -> tuple[str, Player]:
    name, separator, named = text.partition("=") if isinstance(text, str) else (str(text[0]), "=", text[1])
    if not separator or not named:
        advice = "write --with AGENT=SUBJECT or TEAM=SUBJECT"
        raise InputError(f"'{str(text)[:40]}' does not say whom it replaces", "--with", advice)
    if name not in (*world.agents, *world.teams):
        raise UnknownNameError("agent or team", name, [*world.agents, *world.teams], "--with")
    return name, find_player(named, "--with", world)[0]


def evaluate_live(asked: Request, console: Console) -> Evaluation:
    """Measures what is asked for, with a live line of the episodes; see `evaluate`."""
    everybody, players = range(len(asked.world.agents)), asked.players
    subject = [player.controller for player in players]
    opponents = {name: [player.controller for _ in everybody] for name, player in asked.against.items()}
    expert = asked.expert and asked.expert.controller
    trees = [player.trees[agent] for agent, player in enumerate(players) if player.trees]
    contest = Contest(asked.world, subject, opponents or {asked.subject.name: subject}, expert, trees, asked.why)
    with console.live("playing", 1) as live:

        def show(done: int, total: int) -> None:
            live.total = total
            live.update(done, "episodes")

        return evaluate(contest, asked.teams, asked.episodes, show)


def lines(asked: Request, answer: Evaluation) -> list[str]:
    """The answer for people: who plays, a table for each of the opponents, one of the trees."""
    who = [("world", answer.world), ("subject", str(asked.subject))]
    who += [("with", f"{name} by {player}") for name, player in asked.replaced.items()]
    who += [("expert", str(asked.expert))] if asked.expert else []
    told = [row for rows in answer.against.values() for row in rows]
    cut = any(
        each.cut for row in told for each in (row.value, row.expert, row.individual and row.individual.value) if each
    )
    who += [("cut", f"episodes that went on after {stop_of(asked.world)}")] if cut else []
    who += [("episodes", f"{answer.episodes:,} held out, the same ones for every line-up; intervals of 95 %")]
    said = [f"{label:<{LABEL_WIDTH}}{text}" for label, text in (*who, *(("note", note) for note in asked.notes))]
    for name, rows in answer.against.items():
        opponents = asked.against.get(name, "itself")
        said += [
            "",
            *([f"against {opponents}"] if len(asked.world.teams) > 1 else []),
            *tabulate(_standings(rows), 3 if asked.expert else 2),
        ]
        said += _ratios(rows) if asked.expert else []
    for name, rows in answer.why.items():
        opponents = f"against {asked.against.get(name, 'itself')}, " if len(asked.world.teams) > 1 else ""
        said += ["", f"why, {opponents}gap = individual + shift + interaction; positive: worse than the expert"]
        said += tabulate(_causes(rows), 2)
    if answer.trees:
        said += ["", *tabulate(_trees(answer.trees))]
    return said


def _ratios(rows: Sequence[Standing]) -> list[str]:
    """Explains the ratios that are not the subject's value over the expert's."""
    lower = dict.fromkeys(row.measure.name for row in rows if row.measure.lower_is_better)
    negative = dict.fromkeys(row.measure.name for row in rows if row.expert and row.expert.value < 0)
    said = [f"lower is better, and the ratio the expert's over the subject's, in {', '.join(lower)}"] if lower else []
    if negative:
        said += [f"the expert is below 0, and the ratio 1 + (subject - expert) / |expert|, in {', '.join(negative)}"]
    return said


def _standings(rows: Sequence[Standing]) -> list[list[str]]:
    if all(row.expert is None for row in rows):
        plain = ([row.measure.team, row.measure.name, _or(row.value, NO_EPISODE)] for row in rows)
        return [["team", "measure", "subject"], *plain]
    table = [["team", "measure", "kind", "subject", "expert", "ratio"]]
    for row in rows:
        if row.individual is None or row.agents is None:
            numbers = [_or(row.value, NO_EPISODE), _or(row.expert, NO_EPISODE), ""]
            table.append([row.measure.team, row.measure.name, "joint", *numbers])
            continue
        several = len(row.agents) > 1
        kinds = [("joint" if several else "joint, individual", row.value, row.joint)]
        kinds += [("individual", row.individual.value, row.individual.ratio)] if several else []
        for kind, value, ratio in kinds:
            numbers = [_or(value, NO_EPISODE), str(row.expert), _or(ratio, "no ratio")]
            table.append([row.measure.team, row.measure.name, kind, *numbers])
    return table


def _causes(rows: Sequence[Causes]) -> list[list[str]]:
    table = [["team", "measure", "gap", "individual", "shift", "interaction"]]
    for row in rows:
        terms = (row.gap, row.individual, row.shift, row.interaction)
        table.append([row.measure.team, row.measure.name, *map(str, terms)])
        if len(row.agents) > 1:
            table += [["", f"  {agent} alone", "", str(own), "", ""] for agent, own in row.agents.items()]
    return table


def _trees(facts: Mapping[str, TreeFacts]) -> list[list[str]]:
    compared = next(iter(facts.values())).fidelity_own is not None
    head = ["tree", "leaves", "depth", "comparisons per decision"]
    table = [head + ["fidelity in its own states", "in the expert's states"] * compared]
    for agent, tree in facts.items():
        leaves = f"{tree.leaves}" + ("" if tree.numbers is None else f" of {format_count(tree.numbers, 'number')}")
        row = [agent, leaves, str(tree.depth), f"{tree.comparisons}, worst {tree.depth}"]
        table.append(row + [_or(tree.fidelity_own, ""), _or(tree.fidelity_expert, "")] * compared)
    return table


def _or(estimate: Interval | None, otherwise: str) -> str:
    return otherwise if estimate is None else str(estimate)


def document(asked: Request, answer: Evaluation) -> dict[str, Any]:
    """The answer as plain data; an end of an interval that is infinite is null."""
    first = measures.MEASUREMENT_SEEDS
    return {
        "world": answer.world,
        "subject": _player(asked.subject),
        "with": {name: _player(player) for name, player in asked.replaced.items()},
        "expert": asked.expert and _player(asked.expert),
        "episodes": answer.episodes,
        **({} if asked.world.length_stated else {"episodes_are_cut_after": asked.world.spec.episode_steps}),
        "first_episode_seed": first,
        "bootstrap_draws": DRAWS,
        "notes": list(asked.notes),
        "against": {
            name: {
                "opponents": _player(asked.against[name]) if name in asked.against else None,
                "measures": [_row(row) for row in rows],
            }
            for name, rows in answer.against.items()
        },
        "trees": {agent: _tree(tree) for agent, tree in answer.trees.items()},
    } | ({"why": {name: [_cause(row) for row in rows] for name, rows in answer.why.items()}} if answer.why else {})


def _player(player: Player) -> dict[str, str]:
    return {"name": player.name, "kind": player.kind, "id": player.id}


def _row(row: Standing) -> dict[str, Any]:
    measure = row.measure
    return {
        "team": measure.team,
        "measure": measure.name,
        "lower_is_better": measure.lower_is_better,
        "subject": _plain(row.value),
        "expert": _plain(row.expert),
        "joint_ratio": _plain(row.joint),
        "individual": row.individual and _alone(row.individual),
        "agents": {agent: _alone(alone) for agent, alone in (row.agents or {}).items()},
    }


def _alone(alone: Alone) -> dict[str, Any]:
    return {"subject": _plain(alone.value), "ratio": _plain(alone.ratio)}


def _cause(row: Causes) -> dict[str, Any]:
    terms = {name: _plain(getattr(row, name)) for name in ("gap", "individual", "shift", "interaction")}
    agents = {agent: _plain(own) for agent, own in row.agents.items()}
    return {"team": row.measure.team, "measure": row.measure.name, **terms, "agents": agents}


def _tree(tree: TreeFacts) -> dict[str, Any]:
    return {
        "leaves": tree.leaves,
        **({} if tree.numbers is None else {"numbers": tree.numbers}),
        "depth": tree.depth,
        "comparisons": _plain(tree.comparisons),
        "most_comparisons": tree.depth,
        "fidelity_in_own_states": _plain(tree.fidelity_own),
        "fidelity_in_the_experts_states": _plain(tree.fidelity_expert),
    }


def _plain(estimate: Interval | None) -> dict[str, float | None] | None:
    if estimate is None:
        return None
    low, high = (round(end, 6) if math.isfinite(end) else None for end in (estimate.low, estimate.high))
    return {"value": estimate.value, "low": low, "high": high} | ({"cut": estimate.cut} if estimate.cut else {})
