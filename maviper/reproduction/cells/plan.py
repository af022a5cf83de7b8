"""The plan of a reproduction: which cells there are, for what is asked.

Does: finds experts; lists the cells of each tier, with what cannot be made and why; deals them out to shards.
Assumes: options that were read from text (run.py).
Does not: make cells, or look at what is finished.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from importlib.util import find_spec
from itertools import product
from pathlib import Path

from codegen.errors import InputError, UnknownNameError
from maviper.experts import network
from maviper.experts.finding import find_expert
from maviper.extraction.settings import (
    ALGORITHMS,
    FITTED_Q,
    HISTOGRAM,
    IMITATION,
    IVIPER,
    IVIPER_RESAMPLING,
    MAVIPER,
    NO_PREDICTION,
    PAPER,
    PRESETS,
    RELEASED,
    VARIANTS,
)
from maviper.files import runs
from maviper.files.kinds import EXPERT as EXPERT_FILE
from maviper.files.kinds import kind_of
from maviper.reproduction.cells import making
from maviper.reproduction.cells.cell import (
    BLOCKS,
    CROSSPLAY,
    EXPERT,
    EXPLOITABILITY,
    EXTRACTION,
    Cell,
    Source,
    Task,
    estimate,
)
from maviper.worlds import WORLDS, options_of

DECEPTION, NAVIGATION, PREY = "physical-deception", "cooperative-navigation", "predator-prey"
GAMES = (DECEPTION, NAVIGATION, PREY)
MIXED = (DECEPTION, PREY)  # games with opponents
MAPPO, MADDPG = "mappo", "maddpg"
COMPARED = (MAVIPER, IVIPER, IMITATION, FITTED_Q)  # everywhere, as in the paper
ABLATIONS = (NO_PREDICTION, IVIPER_RESAMPLING)  # in deception at depth 4, as in the paper
DEPTHS, MAIN_DEPTH, SEEDS = (2, 4, 6), 4, 10
NO_CARD = " (no card)"


@dataclass(frozen=True)
class Asked:
    """The choices of a user that decide which cells there are; None: as the tier says."""

    quick: bool = False  # the quick tier
    experts: tuple[str, ...] = (MAPPO,)
    games: tuple[str, ...] | None = None
    depths: tuple[int, ...] | None = None
    algorithms: tuple[str, ...] | None = None
    presets: tuple[str, ...] = (PAPER,)
    seeds: int | None = None
    first_seed: int = 0
    exploit_depths: tuple[int, ...] | None = None

    def ensure_known(self) -> "Asked":
        """The same; UnknownNameError or InputError for what there is not."""
        for kind, names, known in (
            ("game", self.games or (), GAMES),
            ("algorithm", self.algorithms or (), (*ALGORITHMS, *VARIANTS)),
            ("preset", self.presets, tuple(PRESETS)),
        ):
            for name in names:
                if name not in known:
                    raise UnknownNameError(kind, name, known, f"--{kind}s")
        return self


@dataclass(frozen=True)
class Known:
    """An expert that was found: its label in every table, the game, where it lies, its hash."""

    label: str
    game: str
    source: Source
    hash: str


@dataclass(frozen=True)
class Plan:
    """Tasks in the order in which they are made, and what is left out, each with its reason."""

    tasks: tuple[Task, ...]
    left_out: tuple[tuple[str, str], ...]

    @property
    def ids(self) -> frozenset[str]:
        """The ids of all cells."""
        return frozenset(task.id for task in self.tasks)


# --- experts


def rejoin_names(texts: Sequence[str]) -> list[str]:
    """Names of experts; an option of the world before it belongs to that one, though a comma stands in between."""
    names: list[str] = []
    for text in texts:
        game = names[-1].partition(",")[0].rpartition("=")[2] if names else ""
        option, _, value = text.partition("=")
        if value and game in WORLDS and option in options_of(game) and not Path(value).exists():
            names[-1] += f",{text}"
        else:
            names.append(text)
    return names


def experts_of(asked: Asked) -> tuple[list[Known], list[tuple[str, str]]]:
    """The experts that there are, and those that are missing, with what to do about it."""
    games = asked.games or ((DECEPTION,) if asked.quick else GAMES)
    known: list[Known] = []
    missing: list[tuple[str, str]] = []
    for text in rejoin_names(asked.experts):
        if text in (MAPPO, MADDPG):
            for game in games:
                name = game if text == MAPPO else f"{game}@{MADDPG}"
                if name in network.SHIPPED:
                    known.append(_resolve_expert(text, name))
                else:
                    train = f"maviper train {game} --algorithm {text} -o RUN"
                    missing.append((f"{text} for {game}", f"none is shipped; `{train}`, then --experts {text}=RUN"))
            continue
        label, _, where = text.partition("=")
        if not where or "," in label or Path(text).exists():  # no NAME=, but a world's option or a file's name
            label, where = "", text
        one = _resolve_expert(label or _family(where), where)
        if one.game.partition(",")[0] in games:
            known.append(one)
        else:
            missing.append((one.label, f"it plays {one.game}, which is not asked for"))
    if not known:
        reasons = "; ".join(f"{what}: {why}" for what, why in missing)
        raise InputError("there is no expert to reproduce with", "--experts", reasons)
    return tell_apart(known), missing


def _family(text: str) -> str:
    """The label of an expert that got none: shipped ones of the same kind have the same in every game."""
    game, _, kind = text.partition("@")
    if text not in network.SHIPPED and not (kind and game.partition(",")[0] in GAMES):
        return Path(text).name
    return f"{MAPPO}-{kind}" if kind.isdigit() else kind or MAPPO


def _resolve_expert(label: str, text: str) -> Known:
    expert, world = find_expert(text)
    place, data = Path(text), b""
    if text not in network.SHIPPED and ":" not in text and place.exists():
        data = runs.read(place / "expert.safetensors" if place.is_dir() else place, network.MAX_BYTES)
    if data and kind_of(data) is not EXPERT_FILE:
        raise InputError("not an expert's file", text, "name an expert as for `maviper extract`")
    if world.spec.name not in GAMES:
        raise InputError("the expert plays none of the paper's games", f"{text}: {world.name}", f"{', '.join(GAMES)}")
    label = label if expert.card else label + NO_CARD
    return Known(label, world.name, Source(text if not data else place.name, data, world.name), expert.hash or text)


def tell_apart(experts: Iterable[Known]) -> list[Known]:
    """Experts of one label and one game get numbers; one that is named twice is one."""
    seen: dict[tuple[str, str], int] = {}
    told: list[Known] = []
    for one in {(each.label, each.game, each.hash): each for each in experts}.values():
        game = one.game.partition(",")[0]
        number = seen[one.label, game] = seen.get((one.label, game), 0) + 1
        told.append(one if number == 1 else replace(one, label=f"{one.label}-{number}"))
    return told


# --- cells


def plan_cells(asked: Asked, register: str) -> Plan:
    """All cells for what is asked, those that others need first."""
    experts, left_out = experts_of(asked)
    count = asked.seeds if asked.seeds is not None else 1 if asked.quick else SEEDS
    seeds = range(asked.first_seed, asked.first_seed + count)
    depths = asked.depths or ((MAIN_DEPTH,) if asked.quick else DEPTHS)
    tasks: dict[str, Task] = {}
    for one in experts:
        chosen = list(product(asked.algorithms or COMPARED, depths))
        if not asked.algorithms and one.game.partition(",")[0] == DECEPTION and MAIN_DEPTH in depths:
            chosen += [(name, MAIN_DEPTH) for name in ABLATIONS]
        pairs = {(preset, name, depth) for preset in asked.presets for name, depth in chosen}
        grid = sorted(each for each in pairs if each[:2] != (RELEASED, FITTED_Q))  # which that preset does not have
        cells = [Cell(EXPERT, one.game, one.label, seed=first) for first in seeds[::BLOCKS]]
        cells += [
            Cell(EXTRACTION, one.game, one.label, preset, name, depth, 0, HISTOGRAM, seed)
            for seed, (preset, name, depth) in product(seeds, grid)  # so that an interrupted run has whole seeds
        ]
        made = [Task(cell, one.source, one.hash, register) for cell in cells]
        for task in (*made, *_crossplays(made), *_answers(asked, made, left_out)):
            tasks.setdefault(task.id, task)
    return Plan(tuple(tasks.values()), tuple(dict.fromkeys(left_out)))


def _crossplays(made: Sequence[Task], depths: Sequence[int] = (MAIN_DEPTH,)) -> list[Task]:
    """The paper's algorithms and the expert against one another, wherever two of them or more were extracted alike, at
    some depths.
    """
    alike: dict[Cell, dict[str, Task]] = {}
    for each in made:
        cell = each.cell
        wanted = cell.algorithm in COMPARED and cell.depth in depths
        if wanted and cell.game.partition(",")[0] in MIXED:
            alike.setdefault(replace(cell, kind=CROSSPLAY, algorithm=""), {})[cell.algorithm] = each
    several = [(cell, of) for cell, of in alike.items() if len(of) > 1]
    return [
        replace(next(iter(of.values())), cell=cell, of={name: task.id for name, task in of.items()})
        for cell, of in several
    ]


def _answers(asked: Asked, made: Sequence[Task], left_out: list[tuple[str, str]]) -> list[Task]:
    """Deception's profiles of depth 4, or of the depths asked for, each answered by everybody of its seed, and by whom
    the tier trains.
    """
    depths = asked.exploit_depths or (MAIN_DEPTH,)
    alike = [each for each in _crossplays(made, depths) if each.cell.game == DECEPTION and each.cell.preset == PAPER]
    if not alike:
        return []
    effort = making.UNTRAINED if asked.quick else making.USUAL
    if effort["steps"] and not find_spec("torch"):
        left_out.append(("networks that respond", "torch is not installed: pip install 'maviper[train]'"))
        effort = {**effort, "steps": 0}
    return [
        replace(task, cell=replace(task.cell, kind=EXPLOITABILITY, algorithm=name), effort=effort)
        for task in alike
        for name in task.of
    ]


# --- shards


def shard(plan: Plan, number: int, of: int) -> Plan:
    """Part `number`, from 1, of `of` parts of about the same cost. Cells that need one another stay together, so that
    no part waits for another one.
    """
    groups: dict[tuple[str | int, ...], list[Task]] = {}
    for task in plan.tasks:
        cell = task.cell
        groups.setdefault((cell.game, cell.expert, cell.preset, cell.depth, cell.seed), []).append(task)
    costs = {key: sum(map(estimate, tasks)) for key, tasks in groups.items()}
    loads, mine = [0.0] * of, set[str]()
    for key in sorted(groups, key=lambda key: (-costs[key], list(groups).index(key))):
        lightest = loads.index(min(loads))
        loads[lightest] += costs[key]
        mine |= {task.id for task in groups[key]} if lightest == number - 1 else set()
    return replace(plan, tasks=tuple(task for task in plan.tasks if task.id in mine))
