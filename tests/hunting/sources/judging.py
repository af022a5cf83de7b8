"""What is wrong with an import: a profile that decides otherwise than the source it was read from.

Does: imports a source by the door that a user takes; compares the reference's decisions with the source's own answers.
Assumes: answers come from Python itself, or from compiled C, at rows that beside them are named.
Does not: run sources.
"""

import inspect
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

import maviper
from codegen import ir
from codegen.errors import MaviperError
from codegen.memory import initial_memory, step_memory
from tests.hunting.sources.drafts import Program
from tests.hunting.sources.observing import Box, Test

HARMLESS = ("AssertionError", "OverflowError")  # a precondition; a number beyond Python's own
NO_DECISION = ("raised", "other")
TOGETHER = 64  # sources that one process answers, or one compiler
ARRAYS = ("floats", "float64", "float32")


@dataclass
class Told:
    """What became of one source, and what is wrong with it."""

    seed: int
    verdict: str = ""  # "IMPORTED" or "REFUSED"
    kind: str = ""
    depth: int = 0
    reason: str = ""  # of a refusal
    asked_again: bool = False  # with `--arrays`, which the first refusal named
    rows: int = 0
    idle: int = 0  # rows without an answer: preconditions, overflows
    unasked: bool = False  # refused, or no answer from the source
    wrong: list[str] = field(default_factory=list)

    def tally(self) -> dict[str, int]:
        """What a record counts."""
        counts = {"rows compared": self.rows, "rows without an answer": self.idle}
        counts |= {"asked again with --arrays": self.asked_again}
        if self.reason:
            counts[f"refused: {self.reason}"] = 1
        return counts


def asking(
    program: Callable[[int, bool], Program], judge: Callable[[list[Program], bool], list[Told]]
) -> Callable[..., Told]:
    """A language's answer to the hunt, by its sources and who judges many of them at once."""

    @lru_cache(maxsize=4)
    def judge_many(number: int, beyond: bool, run: bool) -> list[Told]:
        return judge([program(number * TOGETHER + place, beyond) for place in range(TOGETHER)], run)

    def ask(seed: int, thorough: bool = False, *, beyond: bool = False, run: bool = False) -> Told:
        """What became of the source of a seed. `run`: imported as a user does, compared by the product itself too."""
        if not thorough:
            return judge_many(seed // TOGETHER, beyond, run)[seed % TOGETHER]
        told = judge([program(seed, beyond)], run)[0]
        print(program(seed, beyond).source)
        return told

    return ask


@dataclass
class Import:
    """A source that was read: its agent, the columns of its features, what its tree tests."""

    policy: ir.AgentPolicy
    columns: list[int]
    given: str
    nan: bool
    tests: list[Test]
    program: Program


def read(program: Program, file: Path, told: Told, run: bool) -> Import | None:
    """The import of a program; None where it is refused, which `told` says."""
    options: dict[str, Any] = dict(program.options)
    if "run" in inspect.signature(maviper.from_file).parameters:
        options["run"] = run
    file.write_text(program.source)
    try:
        try:
            profile = maviper.from_file(file, **options)
        except MaviperError as error:
            if 'arrays="' not in f"{error.what} {error.next_step}" or file.suffix != ".py":
                raise
            told.asked_again = True
            kinds = [each for each in ARRAYS if each in error.next_step]
            if program.options:  # 0.1 is no number of those that float32 arrays give
                kinds.remove("float32")
            arrays = kinds[program.seed % len(kinds)]
            profile = maviper.from_file(file, **options, arrays=arrays)
    except MaviperError as error:
        told.verdict, told.reason = "REFUSED", reason_of(error)
        return None
    except Exception as error:  # whatever else ends a reading is wrong
        told.verdict, told.reason = "REFUSED", type(error).__name__
        told.wrong.append(f"{type(error).__name__}: {error}")
        return None
    told.verdict = "IMPORTED"
    agents = {policy.agent: policy for policy in profile.agents}
    policy = agents.get(program.agent) or (profile.agents[0] if len(agents) == 1 else None)
    if policy is None:
        told.wrong.append(f"the agents are {', '.join(agents)}, not {program.agent}")
        return None
    columns = [place_of(feature.name, program) for feature in policy.features if feature.initial is None]
    if None in columns:
        told.wrong.append(f"the features are {', '.join(each.name for each in policy.features)}")
        return None
    kept = profile.provenance.training
    given, missing = str(kept.get(f"{policy.agent} given", "")), str(kept.get(f"{policy.agent} NaN", ""))
    told.depth = int(ir.depth(policy.tree).max())
    known = [each for each in columns if each is not None]
    return Import(policy, known, given, missing.startswith("decided"), tests_of(policy, known), program)


def reason_of(error: MaviperError) -> str:
    """Why something is refused, without its names and numbers."""
    text = re.sub(r"'[^']*'|\"[^\"]*\"|`[^`]*`", "'...'", error.what)
    text = re.sub(r"\b(feature|class|decorator|function) \S+", r"\1 ...", re.sub(r": .*", "", text))
    return re.sub(r"\d[\d.e+-]*", "N", text)[:70]


def place_of(name: str, program: Program) -> int | None:
    """Which of the program's features a name means."""
    names = [feature.name for feature in program.features]
    if name in names:
        return names.index(name)
    if re.fullmatch(r"x\d+", name) and int(name[1:]) < len(names):
        return int(name[1:])
    return None


def tests_of(policy: ir.AgentPolicy, columns: list[int]) -> list[Test]:
    """What each split tests, in the program's features."""
    tree, out, count = policy.tree, [], len(policy.features)
    boxes: dict[int, Box] = {ir.ROOT: {}}
    for node in ir.splits(tree):
        feature, threshold, box = int(tree.feature[node]), float(tree.threshold[node]), boxes[node]
        left = right = box
        if feature < len(columns):
            place = columns[feature]
            low, high = box.get(place, (-np.inf, np.inf))
            left, right = box | {place: (low, min(high, threshold))}, box | {place: (max(low, threshold), high)}
        boxes |= {int(tree.left[node]): left, int(tree.right[node]): right}
        terms = ((1.0, feature),) if feature < count else tree.sums[feature - count].terms
        flat = flatten(terms)
        known = tuple((float(weight), columns[place]) for weight, place in flat if 0 <= place < len(columns))
        if known:
            out.append((known, threshold, box))
    return out


def flatten(terms: Any, by: float = 1.0) -> Iterator[tuple[float, int]]:
    """The terms of a sum and of those within it, each with its weight in all."""
    for weight, place in terms:
        yield from [(by * weight, place)] if isinstance(place, int) else flatten(place.terms, by * weight)


def number_of(value: Any) -> float:
    """A number that a label has: whole, or a double in hexadecimal."""
    return float.fromhex(value) if isinstance(value, str) else value


def accepts(action: ir.ActionSpec, place: int, label: list[Any], labels: dict[str, Any]) -> bool:
    """Whether an action is what a source answers. `labels`: names that the source has for a number, or for a text."""
    kind, value = label[0], label[1]
    if kind == "text":
        return action.label == value or (action.label is None and action.name == value)
    if kind == "member":
        if action.name == value or action.label in (value, label[2]):
            return True
        return label[3] and action.label is None and place == label[2]
    number, known = number_of(value), labels.get(action.name)
    if action.label is not None:
        return action.label == number or (known == number and action.label == action.name)
    return place == number and known in (None, number)


def compare(
    read_: Import,
    rows: np.ndarray,
    answers: np.ndarray,
    labels: list[list[Any]],
    how: str,
    told: Told,
    enumerators: dict[str, int],
) -> None:
    """Notes rows that are decided otherwise. `enumerators`: numbers by the names that a source has for them."""
    policy = read_.policy
    odd = ~np.isfinite(rows).all(axis=1)
    inner = any(not isinstance(place, int) for each in policy.tree.sums for _, place in each.terms)  # x + y - y
    infinite = np.isinf(rows).sum(axis=1) > (0 if inner else 1)
    skip = np.array([each[0] == "raised" and each[1] in HARMLESS for each in labels])[answers]
    skip |= odd & np.array([each[0] == "raised" for each in labels])[answers]
    if not read_.nan:  # a sum of infinities is NaN, which goes right, as importing.md says
        skip |= infinite
    if policy.memory:  # what is remembered after a row without an answer is not known
        skip = np.logical_or.accumulate(skip)
    told.idle += int(skip.sum())
    told.rows += int((~skip).sum())
    x = rows[:, read_.columns]
    if policy.outputs or read_.program.options.get("output_names"):
        good = _same_numbers(policy, x, answers, labels)
    else:
        chosen = act_in_turn(policy, x) if policy.memory else ir.act(policy, x)
        if read_.program.options.get("scores"):
            labels = [
                ["number", int(np.argmax([float.fromhex(n) for n in each[1:]]))] if each[0] == "numbers" else each
                for each in labels
            ]
        named = enumerators | {each[1]: each[1] for each in labels if each[0] == "text"}
        table = np.array(
            [
                [each[0] not in NO_DECISION and accepts(action, place, each, named) for each in labels]
                for place, action in enumerate(policy.actions)
            ]
        )
        good = table[chosen, answers]
    bad = np.flatnonzero(~good & ~skip)
    if len(bad):
        row = int(bad[0])
        one = x[row : row + 1]
        decided = ir.outputs(policy, one)[0].tolist() if policy.outputs else policy.actions[int(chosen[row])].name
        said = f"the source says {labels[answers[row]]}, the profile {decided}"
        told.wrong.append(f"{len(bad)} of {len(rows)} rows otherwise, {how}: at {rows[row].tolist()} {said}")


def act_in_turn(policy: ir.AgentPolicy, x: np.ndarray) -> np.ndarray:
    """The actions of one who remembers, one row after the other from a reset."""
    memory, taken = initial_memory(policy)[None], []
    for row in x:
        action, memory = step_memory(policy, memory, row[None])
        taken.append(int(action[0]))
    return np.array(taken, dtype=np.int64)


def _same_numbers(policy: ir.AgentPolicy, x: np.ndarray, answers: np.ndarray, labels: list[list[Any]]) -> np.ndarray:
    """Whether numbers are the same, zeros with their sign."""
    given = ir.outputs(policy, x)
    width = given.shape[1]
    numbers = [[number_of(n) for n in each[1:]] if each[0] in ("numbers", "number") else [] for each in labels]
    sized = np.array([len(each) == width for each in numbers])
    table = np.array([each if len(each) == width else [np.nan] * width for each in numbers])
    with np.errstate(all="ignore"):
        table = table.astype(given.dtype)[answers]
    same = ((given == table) & (np.signbit(given) == np.signbit(table))) | (np.isnan(given) & np.isnan(table))
    return same.all(axis=1) & sized[answers]
