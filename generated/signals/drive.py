"""The C of a team drives its signals in SUMO: `python drive.py NETWORK FOLDER [SEED]` prints the hour's measures.

Does: builds what `maviper compile --target shared,json` wrote in FOLDER; counts its decisions, and those that the
  profile takes otherwise; where a `monitor` of a team of one signal is there, too, its steps, and those it doubts.
Assumes: the environment of `signals.py`; a C compiler, `cc`.
Does not: compute features in C: they are SUMO's counts, and the clocks of `junctions.py`.
"""

import ctypes
import json
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import signals
import watching

import maviper


def library(folder: Path, prefix: str, watched: bool) -> ctypes.CDLL:
    """The team and, where it has one, its monitor."""
    with TemporaryDirectory() as place:
        source = f'#include "{prefix}_shared.c"\n' + watching.SOURCE.format(prefix) * watched
        Path(place, "all.c").write_text(source, encoding="utf-8")
        command = ["cc", "-std=c99", "-O2", "-shared", "-fPIC", f"-I{folder.resolve()}", "all.c", "-o", "all.so"]
        subprocess.run(command, check=True, cwd=place)
        return ctypes.CDLL(f"{place}/all.so")


def drive(network: str, folder: str, seed: int = 0, seconds: int = 3600) -> dict[str, Any]:
    """The measures of an episode, and what was counted."""
    env, (source,) = signals.make(network, seconds), Path(folder).glob("*_shared.c")
    prefix = source.stem.removesuffix("_shared")
    watched = source.with_name(f"{prefix}_monitor.h").exists()
    team, code = maviper.load(source.with_name(f"{prefix}.json")), library(source.parent, prefix, watched)
    watches = [watching.Watch(each, code, signals.MIN_GREEN) for each in env.signals.values() if watched]
    seen, _ = env.reset(seed)
    decisions, differ, infos, answer = 0, 0, {}, np.zeros(2, np.int32)
    while env.agents:
        chosen: dict[str, int] = {}
        for policy in (each for each in team.agents if each.agent in env.acting):
            row = seen[policy.agent].astype(policy.numbers)
            places = [each.ctypes.data_as(ctypes.c_void_p) for each in (row, answer, answer[1:])]
            code[f"{prefix}_{policy.agent}_decide"](places[0], ctypes.c_long(1), *places[1:])
            chosen[policy.agent] = env.action_names[policy.agent].index(policy.actions[answer[0]].name)
            decisions += 1
            differ += answer[0] != policy.act([row])[0]
        seen, *_, infos = env.step(chosen)
    told = {name: value for each in watches for name, value in each.counts.items()}
    return {**infos[env.possible_agents[0]], "decisions": decisions, "differ": int(differ), **told}


if __name__ == "__main__":
    print(json.dumps(drive(sys.argv[1], sys.argv[2], *map(int, sys.argv[3:]))))
