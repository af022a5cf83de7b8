"""Experts: what trees are extracted from.

Does: the numpy network that every shipped expert is, its file format, the trainer that makes one, and those of others.
Assumes: discrete actions, vector observations.
Does not: import torch unless training or a file of torch is asked for.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path
    from typing import Any

    from maviper.experts.foreign.layers import LayersExpert, Normalization
    from maviper.worlds import World


def from_sb3(
    file: str | Path,
    world: World,
    normalization: Normalization | str | None = None,
    activation: str | None = None,
) -> LayersExpert:
    """The expert in a zip of stable-baselines3: as `maviper.experts.foreign.libraries.from_sb3`."""
    from maviper.experts.foreign import libraries

    return libraries.from_sb3(file, world, normalization, activation)


def from_torch(
    weights: str | Path | Mapping[str, Any],
    world: World,
    net: str,
    activation: str,
    outputs: str,
    normalization: Normalization | None = None,
) -> LayersExpert:
    """The expert in a torch state dict or its file: as `maviper.experts.foreign.libraries.from_torch`."""
    from maviper.experts.foreign import libraries

    return libraries.from_torch(weights, world, net, activation, outputs, normalization)
