"""Trees of others, from files to a profile.

Does: reads the trees of a file, or one file for each agent of a team, and makes a profile of them.
Assumes: `codegen.importers` recognises, reads and replays them.
Does not: write anything.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from codegen.errors import InputError, shown
from codegen.importers import kinds as foreign
from codegen.importers.origin import Names, Origin, Said, profile_of
from codegen.ir import PolicyProfile
from maviper.files import kinds, runs


@dataclass(frozen=True)
class ImportOptions:
    """What is imported: a file, or a file for each agent; and names instead of the file's own, for every agent."""

    file: Path | None
    agents: Mapping[str, Path] | None = None
    features: tuple[str, ...] | None = None
    actions: tuple[str, ...] | None = None
    world: str = "imported"
    numbers: str | None = None  # that agents compare: float32, or as the files do
    scores: bool = False  # whether a list of numbers holds a score for each action
    arrays: str | None = None  # of which numbers if/else Python is given arrays; None: it is given Python's floats


def imported(asked: ImportOptions) -> PolicyProfile:
    """The profile of the trees in a file, or of a team. InputError for what is not understood."""
    said = Said(asked.scores, asked.arrays or "")
    names = Names(asked.features, asked.actions, asked.world)
    if asked.file is not None and asked.agents is None:
        return profile_of(_read(asked.file, said), names, asked.numbers)
    if asked.file is not None or not asked.agents:
        raise InputError("nothing or too much is given", "", "give a file, or --agents with a file for each agent")
    return profile_of({agent: _one(agent, path, said) for agent, path in asked.agents.items()}, names, asked.numbers)


def _read(path: Path, said: Said) -> dict[str, Origin]:
    data = runs.read(path, foreign.MAX_BYTES)
    kinds.ensure(data, str(path), "a tree of another program")
    return foreign.read(data, path.name, said)


def _one(agent: str, path: Path, said: Said) -> Origin:
    """The tree for one agent: the only one of a file, or the one that is named like the agent."""
    found = _read(path, said)
    if len(found) > 1 and agent not in found:
        what = f"the file has {len(found)} trees, none of them named {shown(agent)!r}"
        raise InputError(what, str(path), f"name the agent like its tree: {', '.join(map(shown, list(found)[:5]))}")
    return found.get(agent) or next(iter(found.values()))
