"""How fast the trees decide under JAX and PyTorch, beside the network that they were extracted from, in one run.

    python tests/benchmarks/arrays.py [--batch 65536] [--rounds 9] [--json]

The committed physical-deception profile and the expert it names; all three agents, random float32 observations, both
compiled by the library (jit, torch.compile) on the device that it chooses. The network is its actors' three matrix
products and an argmax in float32. Ratios are medians over rounds of network / trees within a round, so that above 1 the
trees are faster; rates are decisions per second. A library that is missing is named.
"""

import argparse
import importlib
import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from codegen.agreement import readback
from codegen.targets import emit
from maviper import load
from maviper.experts import network

PROFILE = Path(__file__).parents[2] / "generated" / "physical_deception" / "profile.json"
TARGETS = {"jax": (1.0, 10.0), "torch": (1.0, 10.0)}  # of the ratio: reach, stretch


def weights(expert: Any, agent: str) -> list[tuple[np.ndarray, np.ndarray]]:
    """The layers of an agent's actor."""
    return [
        tuple(expert.tensors[f"{agent}.actor.{layer}.{part}"] for part in ("weight", "bias")) for layer in (1, 2, 3)
    ]


def decided(x: Any, layers: Any, relu: Callable[[Any], Any]) -> Any:
    """The greedy actions of a network."""
    for place, (weight, bias) in enumerate(layers):
        x = x @ weight + bias
        x = relu(x) if place < len(layers) - 1 else x
    return x.argmax(-1)


def under_jax(team: Any, expert: Any, rows: dict[str, np.ndarray]) -> tuple[str, list[Callable[[], Any]]]:
    """The device, and a call of the trees and of the network."""
    jax = importlib.import_module("jax")
    trees = jax.jit(readback.load_python(emit(team, ["jax"])["physical_deception_jax.py"])["act_all"])
    nets = {agent: jax.tree.map(jax.numpy.asarray, weights(expert, agent)) for agent in rows}
    network = jax.jit(lambda seen: {agent: decided(x, nets[agent], jax.nn.relu) for agent, x in seen.items()})
    seen = jax.tree.map(jax.numpy.asarray, rows)
    calls = [lambda: jax.block_until_ready(trees(seen)), lambda: jax.block_until_ready(network(seen))]
    return str(jax.devices()[0].device_kind), calls


def under_torch(team: Any, expert: Any, rows: dict[str, np.ndarray]) -> tuple[str, list[Callable[[], Any]]]:
    """The same under PyTorch."""
    torch = importlib.import_module("torch")
    device = "cuda" if torch.cuda.is_available() else "cpu"
    module = readback.load_python(emit(team, ["torch"])["physical_deception_torch.py"])
    nets = {
        agent: [[torch.tensor(a, device=device) for a in pair] for pair in weights(expert, agent)] for agent in rows
    }
    seen = {agent: torch.tensor(x, device=device) for agent, x in rows.items()}
    trees = torch.compile(module["act_all"])
    network = torch.compile(lambda seen: {agent: decided(x, nets[agent], torch.relu) for agent, x in seen.items()})

    def run(act: Any) -> Any:
        with torch.no_grad():
            found = act(seen)
        if device == "cuda":
            torch.cuda.synchronize()
        return found

    return device, [lambda: run(trees), lambda: run(network)]


def timed(calls: list[Callable[[], Any]], rounds: int) -> np.ndarray:
    """Seconds of each call in each round, [rounds, calls]; the first calls, which compile, are not counted."""
    for call in calls:
        call()
    found = np.zeros((rounds, len(calls)))
    for row in found:
        for place, call in enumerate(calls):
            start = time.perf_counter()
            call()
            row[place] = time.perf_counter() - start
    return found


def main() -> None:
    """Reads the options, measures, prints."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--batch", type=int, default=65_536)
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    team, expert, rng = load(PROFILE), network.load("physical-deception")[0], np.random.default_rng(0)
    shapes = {policy.agent: (options.batch, len(policy.features)) for policy in team.agents}
    rows = {agent: rng.uniform(-2, 2, shape).astype(np.float32) for agent, shape in shapes.items()}
    figures = []
    for library, prepared in (("jax", under_jax), ("torch", under_torch)):
        try:
            device, calls = prepared(team, expert, rows)
        except ImportError as error:
            print(f"{library}: not measured ({error})")
            continue
        seconds = timed(calls, options.rounds)
        rates = len(rows) * options.batch / np.median(seconds, axis=0)
        ratio = float(np.median(seconds[:, 1] / seconds[:, 0]))
        print(
            f"{library:<6} {device}: trees {rates[0]:.3g}/s, network {rates[1]:.3g}/s, trees {ratio:.2f} times as fast"
        )
        reach, stretch = TARGETS[library]
        figures.append(
            {
                "name": f"{library}, trees / network",
                "value": ratio,
                "reach": reach,
                "stretch": stretch,
                "better": "higher",
            }
        )
    if options.json:
        print(json.dumps({"figures": figures}))


if __name__ == "__main__":
    main()
