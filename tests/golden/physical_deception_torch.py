"""Decision tree policies of 3 agents for the world physical-deception, over arrays of torch. Generated: do not edit.

profile     d7c7e9951b353c845e3729dfb7383e9f94192c6dfd621196d4fd4879d989808d
made by     tests, hand-made, preset none, seed 0

For each agent A: act_A(x) takes observations, a tensor [..., n_features], and returns the actions' numbers, [...]
int64, on the same device. The leading axes are yours: none is one observation, one is a batch. All splits are evaluated
and none branches, so that torch.compile and torch.func.vmap take every function. act_all takes a dictionary, by agent.
Numbers of other types become float32 first; another last axis is a ValueError, complex numbers and what is no tensor are a TypeError.

A split goes left iff x[feature] <= threshold, both float32. What is compared is their bits, as integers in the same
order: XLA, and whoever sets it so, takes subnormal numbers for zero. NaN goes right; infinities follow <=.
"""

from __future__ import annotations

from typing import Callable, Dict, Mapping

import torch

Array = torch.Tensor

PROFILE = "d7c7e9951b353c845e3729dfb7383e9f94192c6dfd621196d4fd4879d989808d"
AGENTS = ("adversary_0", "agent_0", "agent_1",)
FEATURES = {
    "adversary_0": ("landmark_0_dx", "landmark_0_dy", "landmark_1_dx", "landmark_1_dy", "agent_0_dx", "agent_0_dy", "agent_1_dx", "agent_1_dy",),
    "agent_0": ("goal_dx", "goal_dy", "landmark_0_dx", "landmark_0_dy", "landmark_1_dx", "landmark_1_dy", "adversary_0_dx", "adversary_0_dy", "agent_1_dx", "agent_1_dy",),
    "agent_1": ("goal_dx", "goal_dy", "landmark_0_dx", "landmark_0_dy", "landmark_1_dx", "landmark_1_dy", "adversary_0_dx", "adversary_0_dy", "agent_0_dx", "agent_0_dy",),
}
ACTIONS = {
    "adversary_0": ("stay", "left", "right", "down", "up",),
    "agent_0": ("stay", "left", "right", "down", "up",),
    "agent_1": ("stay", "left", "right", "down", "up",),
}


def _ordered(agent: str, n: int, x: Array) -> Array:
    """Observations as integers in the order of their float32 numbers, [..., n] int32; NaN is the largest."""
    if not isinstance(x, torch.Tensor):
        raise TypeError(f"{agent} observes a tensor of {n} numbers, given {type(x).__name__}: torch.as_tensor makes one")
    if x.ndim == 0 or x.shape[-1] != n:
        raise ValueError(f"{agent} observes {n} numbers, given a tensor of shape {tuple(x.shape)}")
    if x.is_complex():
        raise TypeError(f"{agent} observes {n} numbers, given a tensor of {x.dtype}")
    bits = x.to(torch.float32).view(torch.int32)
    return torch.where((bits & 0x7FFFFFFF) > 0x7F800000, 0x7FFFFFFF, bits ^ ((bits >> 31) & 0x7FFFFFFF))


def act_adversary_0(x: Array) -> Array:
    """adversary_0, team adversaries: 1 leaf, 0 splits."""
    x = _ordered("adversary_0", 8, x)
    return torch.full(x.shape[:-1], 0, dtype=torch.int64, device=x.device)


def act_agent_0(x: Array) -> Array:
    """agent_0, team defenders: 5 leaves, 4 splits."""
    x = _ordered("agent_0", 10, x)
    x0 = x[..., 0]  # goal_dx
    x2 = x[..., 2]  # landmark_0_dx
    x3 = x[..., 3]  # landmark_0_dy
    x9 = x[..., 9]  # agent_1_dy
    return torch.where(
        x0 <= 1036831948,  # node 0: goal_dx <= 0.1
        torch.where(
            x3 <= 0,  # node 1: landmark_0_dy <= 0
            1,  # left, leaf 2
            2,  # right, leaf 3
        ),
        torch.where(
            x9 <= -1051372204,  # node 4: agent_1_dy <= -0.333333
            4,  # up, leaf 5
            torch.where(
                x2 <= 2139095039,  # node 6: landmark_0_dx <= 3.40282e+38
                0,  # stay, leaf 7
                0,  # stay, leaf 8
            ),
        ),
    )


def act_agent_1(x: Array) -> Array:
    """agent_1, team defenders: 4 leaves, 3 splits."""
    x = _ordered("agent_1", 10, x)
    x4 = x[..., 4]  # landmark_1_dx
    x5 = x[..., 5]  # landmark_1_dy
    return torch.where(
        x4 <= -1028443342,  # node 0: landmark_1_dx <= -0.05
        1,  # left, leaf 1
        torch.where(
            x4 <= 1028443341,  # node 2: landmark_1_dx <= 0.05
            torch.where(
                x5 <= 0,  # node 3: landmark_1_dy <= 0
                3,  # down, leaf 4
                4,  # up, leaf 5
            ),
            2,  # right, leaf 6
        ),
    )


ACT: Dict[str, Callable[[Array], Array]] = {
    "adversary_0": act_adversary_0,
    "agent_0": act_agent_0,
    "agent_1": act_agent_1,
}


def act_all(x: Mapping[str, Array]) -> Dict[str, Array]:
    """The actions of all AGENTS, from the observations of each."""
    return {agent: act(x[agent]) for agent, act in ACT.items()}
