"""Code against tree over ten million on-policy states.

    python tests/benchmarks/on_policy.py [PROFILE] [--states 10000000] [--json]

Plays episodes of the profile's own trees and asks the compiled C (one decision, rows, columns, all agents, from world
states) and the Python module's batch function for every state met. Prints how many decisions were compared and how many
differ, which is 0.
"""

import argparse
import json
from pathlib import Path

import numpy as np

from codegen import ir
from codegen.agreement import readback
from codegen.agreement.compiled import CompiledC, find_compiler
from codegen.lowering.lower import lower
from codegen.targets import emit
from maviper import load
from maviper.episodes.play import play, tree_policies
from maviper.worlds.matching import matching_world

PROFILE = Path(__file__).parents[2] / "generated" / "physical_deception" / "profile.json"
GAMES = 16_384


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("profile", nargs="?", type=Path, default=PROFILE)
    parser.add_argument("--states", type=int, default=10_000_000)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    profile = load(options.profile)
    world, model, files = matching_world(profile), lower(profile), emit(profile)
    compiler = find_compiler()
    module = readback.load_python(files[f"{model.prefix}.py"])
    rng, states, compared, wrong = np.random.default_rng(0), 0, 0, 0
    team = [tree_policies(profile.agents)] * len(profile.agents)
    with CompiledC(files[f"{model.prefix}.h"], model, compiler) as compiled:
        while states < options.states:
            episodes = play(world, team, world.start(GAMES, rng))
            seen = [rows.reshape(-1, rows.shape[-1]) for rows in episodes.observations]
            wanted = [ir.act(policy, rows) for policy, rows in zip(profile.agents, seen, strict=True)]
            coordinates = np.concatenate([world.coordinates(state) for state in episodes.states[:-1]])
            together, located = compiled.all(seen), compiled.team(coordinates)
            for place, (policy, agent) in enumerate(zip(profile.agents, model.agents, strict=True)):
                answers = [compiled.act(policy.agent, seen[place]), *compiled.batch(policy.agent, seen[place])]
                answers += [together[:, place], located[:, place], module[f"act_{agent.lower}_batch"](seen[place])]
                for answer in answers:
                    compared += len(answer)
                    wrong += int((answer != wanted[place]).sum())
            states += len(coordinates)
    if options.json:
        figure = {"name": "decisions that differ", "value": wrong, "reach": 0, "stretch": 0, "better": "lower"}
        print(json.dumps({"figures": [figure]}))
        return
    print(f"{states:,} on-policy states, {compared:,} decisions compared, {wrong} differ")


if __name__ == "__main__":
    main()
