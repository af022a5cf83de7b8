"""The files of tests/corpus: the manifest, observations at which a file is asked, and the answers after its import.

Does: draws observations at random, at numbers of the source and at thresholds, each with both neighbours.
Assumes: the manifest's ranges; names of features as the manifest or the import gives them.
Does not: run a file (originals.py).
"""

import re
import tomllib
from typing import Any

import numpy as np

import maviper
from codegen import ir
from tests.support.originals import CORPUS

NUMBER = re.compile(r"(?<![\w.])(\d+\.?\d*(?:[eE][+-]?\d+)?|\.\d+)")
SCALES = (1.0, 0.5, 2.0)  # numbers of a source are often halved or doubled before they are compared


def files() -> list[dict[str, Any]]:
    """The manifest."""
    return tomllib.loads((CORPUS / "manifest.toml").read_text())["file"]


def called(file: dict[str, Any]) -> str:
    """A file and its function, as a test is called."""
    return f"{file['path']}:{file['entry']}"


def imported(file: dict[str, Any]) -> ir.AgentPolicy:
    """The agent that the import makes of a file's function."""
    options: dict[str, Any] = {"scores": True} if file.get("scores") else {}
    options |= {"feature_names": file["features"]} if file.get("told") else {}
    options |= {"arrays": file["arrays"]} if file.get("arrays") else {}
    profile = maviper.from_file(CORPUS / file["path"], **options)
    wanted = {part.lower().strip("_") for part in file["entry"].split(".")}
    chosen = [each for each in profile.agents if each.agent in wanted or len(profile.agents) == 1]
    assert len(chosen) == 1, [each.agent for each in profile.agents]
    return chosen[0]


def columns(file: dict[str, Any], policy: ir.AgentPolicy) -> list[int]:
    """Which of the manifest's features each feature of the import is."""
    own, names = file["features"], [each.name for each in policy.features]
    lower = [each.lower() for each in own]
    if all(name in lower for name in names):
        return [lower.index(name) for name in names]
    numbered = [re.fullmatch(r"[a-z_]*?(\d+)", name) for name in names]
    if all(numbered):
        return [int(each[1]) for each in numbered if each]
    assert len(names) == len(own), (names, own)
    return list(range(len(own)))


def observations(file: dict[str, Any], policy: ir.AgentPolicy | None, count: int, seed: int = 0) -> np.ndarray:
    """[n, n_features] float64: `count` at random, then every threshold of the import with both neighbours."""
    rng = np.random.default_rng(seed)
    source = [float(each) for each in NUMBER.findall((CORPUS / file["path"]).read_text())]
    written = np.array([0.0, *(sign * each * scale for each in source for scale in SCALES for sign in (1, -1))])
    kinds, low, high = file["kinds"], file["low"], file["high"]
    singles = policy is not None and policy.numbers == "float32"
    drawn = [_column(*each, written, rng, count, singles) for each in zip(kinds, low, high, strict=True)]
    rows = np.stack(drawn, axis=1)
    if policy is None:
        return rows
    own, tree = columns(file, policy), policy.tree
    extra = [rows]
    for place in np.flatnonzero((tree.feature >= 0) & (tree.feature < len(policy.features))):
        column = own[int(tree.feature[place])]
        at = _kept(kinds[column], _beside(np.array([float(tree.threshold[place])]), kinds[column], singles))
        at = at[(at >= low[column]) & (at <= high[column])]
        more = rows[rng.integers(len(rows), size=8 * len(at))]
        more[:, column] = np.repeat(at, 8)
        extra.append(more)
    return np.concatenate(extra)


def _column(
    kind: str, low: float, high: float, written: np.ndarray, rng: np.random.Generator, count: int, singles: bool
) -> np.ndarray:
    if kind in "bi":
        values = rng.integers(int(low), int(high) + 1, size=count).astype(np.float64)
    else:
        values = rng.uniform(low, high, size=count)
    near = _beside(written, kind, singles)
    near = near[(near >= low) & (near <= high)]
    chosen = rng.random(count) < 0.4
    if len(near):
        values[chosen] = rng.choice(near, size=int(chosen.sum()))
    if kind == "f" or (kind == "d" and singles):
        values = values.astype(np.float32).astype(np.float64)
    return _kept(kind, values)


def _beside(at: np.ndarray, kind: str, singles: bool) -> np.ndarray:
    """Numbers with both neighbours, in the feature's own type."""
    if kind in "bi":
        return np.concatenate([np.floor(at) - 1, np.floor(at), np.floor(at) + 1])
    number = np.float32 if kind == "f" or singles else np.float64
    near = at.astype(number)
    beside = [np.nextafter(near, number(-np.inf)), near, np.nextafter(near, number(np.inf))]
    return np.concatenate(beside).astype(np.float64)


def _kept(kind: str, values: np.ndarray) -> np.ndarray:
    return np.clip(np.floor(values), 0, 1) if kind == "b" else np.floor(values) if kind == "i" else values


def decided(file: dict[str, Any], policy: ir.AgentPolicy, rows: np.ndarray) -> list[list[Any]]:
    """What the import answers for each observation: all that the action may be called."""
    numbers = rows[:, columns(file, policy)].astype(policy.numbers)
    names = [_names(policy, action) for action in range(len(policy.actions))]
    return [names[action] for action in ir.act(policy, numbers).tolist()]


def _names(policy: ir.AgentPolicy, action: int) -> list[Any]:
    given = policy.actions[action]
    return [given.label, given.name] if given.label is not None else [action, given.name]


def differences(theirs: list[list[Any]], ours: list[list[Any]]) -> list[int]:
    """Where the answers differ: they share no name, or another answer was called so before."""
    same: dict[str, str] = {}
    back: dict[str, str] = {}
    wrong = list[int]()
    for place, (origin, action) in enumerate(zip(theirs, ours, strict=True)):
        one, other = repr(origin[0]), repr(action)
        shared = any(_equal(a, b) for a in origin for b in action)
        if not shared or same.setdefault(one, other) != other or back.setdefault(other, one) != one:
            wrong.append(place)
    return wrong


def _equal(one: Any, other: Any) -> bool:
    if isinstance(one, str) and isinstance(other, str):
        return re.sub(r"\W+", "_", one).strip("_").lower() == re.sub(r"\W+", "_", other).strip("_").lower()
    return not isinstance(one, str) and not isinstance(other, str) and one == other
