"""What the page knows of an expert that is a network.

Does: packs the layers that decide for an agent.
Assumes: a NetworkExpert.
Does not: write HTML, or decide.
"""

import base64

import numpy as np

from codegen import ir
from maviper.experts.network import ACTOR, LAYERS, VALUE, NetworkExpert


def layers_of(expert: NetworkExpert, agent: str) -> list[dict[str, str]]:
    """The layers that decide: float32 weights [inputs, outputs], row by row, little-endian, in base64."""
    net = ACTOR if expert.centralized else VALUE
    layers = [
        (expert.tensors[f"{agent}.{net}.{layer}.weight"], expert.tensors[f"{agent}.{net}.{layer}.bias"])
        for layer in LAYERS
    ]
    return [{"weight": _pack_numbers(weight), "bias": _pack_numbers(bias)} for weight, bias in layers]


def _pack_numbers(numbers: ir.Float32) -> str:
    return base64.b64encode(np.ascontiguousarray(numbers, "<f4").tobytes()).decode()
