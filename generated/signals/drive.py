"""The C of a team drives its signals in SUMO: `python drive.py NETWORK FOLDER [SEED]` prints the hour's measures.

Does: builds the header in FOLDER, which `maviper compile` wrote, as a library; has it decide for each signal that may
  act; counts decisions, and how often the profile beside it decides otherwise.
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

import signals

import maviper


def library(header: Path, agents: list[str]) -> ctypes.CDLL:
    """Exports `act_AGENT` of each agent from a header, all of whose functions are static."""
    lines = [f'#include "{header.resolve()}"']
    lines += [f"int act_{agent}(const void *x) {{ return {header.stem}_{agent}_act(x); }}" for agent in agents]
    with TemporaryDirectory() as folder:
        source, built = Path(folder, "team.c"), Path(folder, "team.so")
        source.write_text("\n".join([*lines, ""]), encoding="utf-8")
        subprocess.run(["cc", "-std=c99", "-O2", "-shared", "-fPIC", source, "-o", built], check=True)
        return ctypes.CDLL(str(built))


def drive(network: str, folder: str, seed: int = 0, seconds: int = 3600) -> dict[str, Any]:
    """The measures of an episode, its decisions, and how many of them the profile in Python takes otherwise."""
    header, env = next(Path(folder).glob("*.h")), signals.make(network, seconds)
    team = maviper.load(header.with_suffix(".json"))
    code = library(header, list(env.possible_agents))
    seen, _ = env.reset(seed)
    decisions, differ, infos = 0, 0, {}
    while env.agents:
        chosen: dict[str, int] = {}
        for policy in (each for each in team.agents if each.agent in env.acting):
            row = seen[policy.agent].astype(policy.numbers)
            place = code[f"act_{policy.agent}"](row.ctypes.data_as(ctypes.c_void_p))
            chosen[policy.agent] = env.action_names[policy.agent].index(policy.actions[place].name)
            decisions += 1
            differ += place != policy.act([row])[0]
        seen, *_, infos = env.step(chosen)
    return {**infos[env.possible_agents[0]], "decisions": decisions, "differ": int(differ)}


if __name__ == "__main__":
    print(json.dumps(drive(sys.argv[1], sys.argv[2], *map(int, sys.argv[3:]))))
