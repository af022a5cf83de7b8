"""Plain torch state dicts as experts, CleanRL's among them, with an architecture that the user states.

Does: finds the fully connected layers under a name; takes activation and kind of outputs as stated.
Assumes: an `nn.Sequential` of linear layers with one activation after each but the last.
Does not: guess: a state dict holds neither activations nor what its outputs mean.
"""

import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from codegen.errors import InputError, UnknownNameError
from maviper.experts.foreign.layers import LayersExpert, Normalization
from maviper.experts.foreign.weights import MAX_BYTES, layers, of_torch, read
from maviper.files import runs
from maviper.worlds import World

SAFETENSORS = ".safetensors"


def from_torch(
    weights: str | Path | Mapping[str, Any],
    world: World,
    net: str,
    activation: str,
    outputs: str,
    normalization: Normalization | None = None,
) -> LayersExpert:
    """The expert in a state dict, or in a file of one (torch's or safetensors); every agent of `world` plays by it.

    `net`: the name before the layers' numbers (CleanRL: `actor` of PPO, `network` of DQN); `activation`: relu, tanh,
    elu, leakyrelu or sigmoid; `outputs`: logits or q. InputError where that does not describe what is there.
    """
    if isinstance(weights, Mapping):
        tensors, where, digest = of_torch(weights, "state dict"), "state dict", ""
    else:
        path = Path(weights)
        data = runs.read(path, MAX_BYTES)
        where, digest = str(path), hashlib.sha256(data).hexdigest()
        tensors = read(data, where, path.suffix == SAFETENSORS)
    known = dict.fromkeys(name.rsplit(".", 2)[0] for name in tensors if name.count(".") >= 2)
    if net not in known:
        raise UnknownNameError("network", net, known, where)
    linear_layers = layers(tensors, net, where)
    if not linear_layers:
        raise InputError("there are no layers under that name", f"{where}: {net}", "name what comes before `.0.weight`")
    return LayersExpert(
        world, linear_layers, activation, outputs, normalization, {"algorithm": "torch state dict"}, digest
    )
