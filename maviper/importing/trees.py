"""Trees of others, from files to a profile, of its own or of the agents of a game.

Does: reads the trees of a file, or one file for each agent of a team.
Assumes: `codegen.importers` recognises, reads and replays them; games.py makes agents of a game of them.
Does not: import games where none is named. It writes nothing.
"""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Unpack

from codegen.errors import InputError, escape_text
from codegen.importers import reading as foreign
from codegen.importers.origin import Names, profile_of
from codegen.importers.reading import Origin, Said
from codegen.ir import PolicyProfile
from maviper.files import kinds, runs
from maviper.options import ImportOptions, make_request


def import_trees(
    file: Path | None, agents: Mapping[str, Path] | None = None, **options: Unpack[ImportOptions]
) -> PolicyProfile:
    """The profile of the trees in a file, or in a file for each agent. InputError for what is not understood."""
    asked = make_request(ImportOptions, options)
    (features, reads), (actions, acts) = map(_take_calls, (asked.feature_names, asked.action_names))
    plain = tuple(each for each in features or () if "=" not in each)
    outputs = tuple(asked.output_names or ())
    if outputs and (asked.scores or asked.action_names):
        raise InputError("numbers are given, and no action is taken", "--outputs", "leave --scores and --actions out")
    said = Said(
        asked.scores,
        features=plain,
        arrays=asked.arrays or "",
        outputs=outputs,
        run=asked.run,
        prefer=tuple(asked.prefer or ()),
        reads=reads,
        acts=acts,
    )
    names = Names(features, actions, asked.name, asked.output_names)
    if file is not None and agents is None:
        origins = _read(file, said)
    elif file is not None or not agents:
        raise InputError("nothing or too much is given", "", "give a file, or --agents with a file for each agent")
    else:
        origins = {agent: _one(agent, path, said) for agent, path in agents.items()}
    if asked.name != Names.world:
        from maviper.importing import games  # which takes time

        world = games.find_game(asked.name)
        if world is not None:
            return games.tie_trees(origins, world, features, actions)
    return profile_of(origins, names, asked.numbers)


def _take_calls(names: Iterable[str] | None) -> tuple[list[str] | None, tuple[str, ...]]:
    """Names without the `()` of those that are calls, and the functions that these call."""
    if names is None:
        return None, ()
    given = list(names)
    called = [each.rpartition("=")[2].removesuffix("()") for each in given if each.endswith("()")]
    return [each.removesuffix("()") for each in given], tuple(called)


def _read(path: Path, said: Said) -> dict[str, Origin]:
    data = runs.read(path, foreign.MAX_BYTES)
    kinds.ensure(data, str(path), "a tree of another program")
    return foreign.read(data, path.name, replace(said, beside=partial(_beside, path)))


def _beside(path: Path, name: str) -> bytes | None:
    """The content of a file in the folder of a source, or below it; None: there is none."""
    folder = path.resolve().parent
    place = (folder / name).resolve()
    if not place.is_relative_to(folder) or not place.is_file():
        return None
    return runs.read(place, foreign.MAX_BYTES)


def _one(agent: str, path: Path, said: Said) -> Origin:
    """The tree for one agent: the only one of a file, or the one that is named like the agent."""
    trees = _read(path, replace(said, wanted=agent))
    if len(trees) > 1 and agent not in trees:
        what = f"the file has {len(trees)} trees, none of them named {escape_text(agent)!r}"
        raise InputError(
            what, str(path), f"name the agent like its tree: {', '.join(map(escape_text, list(trees)[:5]))}"
        )
    return trees.get(agent) or next(iter(trees.values()))
