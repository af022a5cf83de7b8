"""Decision tree policies of 3 agents for the world physical-deception, over arrays of torch. Generated: do not edit.

profile     5d30e215800a19546299a607e3d5abdb7864ddeb9e9e5efbbf24f5d164b4cfc2
made by     maviper 0.3.0, maviper, preset default, seed 0

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

PROFILE = "5d30e215800a19546299a607e3d5abdb7864ddeb9e9e5efbbf24f5d164b4cfc2"
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
    """adversary_0, team adversaries: 12 leaves, 11 splits."""
    x = _ordered("adversary_0", 8, x)
    x0 = x[..., 0]  # landmark_0_dx
    x2 = x[..., 2]  # landmark_1_dx
    x3 = x[..., 3]  # landmark_1_dy
    return torch.where(
        x2 <= -1003683731,  # node 0: landmark_1_dx <= -0.00643916
        torch.where(
            x3 <= 1041158581,  # node 1: landmark_1_dy <= 0.139472
            torch.where(
                x3 <= -1047787744,  # node 2: landmark_1_dy <= -0.238254
                torch.where(
                    x2 <= -1052718539,  # node 3: landmark_1_dx <= -0.373457
                    1,  # left, leaf 4
                    3,  # down, leaf 5
                ),
                torch.where(
                    x2 <= -1045157202,  # node 6: landmark_1_dx <= -0.199056
                    1,  # left, leaf 7
                    3,  # down, leaf 8
                ),
            ),
            torch.where(
                x0 <= 1042136968,  # node 9: landmark_0_dx <= 0.154051
                1,  # left, leaf 10
                4,  # up, leaf 11
            ),
        ),
        torch.where(
            x3 <= -1056494612,  # node 12: landmark_1_dy <= -0.485993
            torch.where(
                x2 <= 1066058484,  # node 13: landmark_1_dx <= 1.08407
                3,  # down, leaf 14
                2,  # right, leaf 15
            ),
            torch.where(
                x2 <= 1053232814,  # node 16: landmark_1_dx <= 0.388784
                torch.where(
                    x3 <= 1042900599,  # node 17: landmark_1_dy <= 0.16543
                    2,  # right, leaf 18
                    4,  # up, leaf 19
                ),
                torch.where(
                    x3 <= 1063183505,  # node 20: landmark_1_dy <= 0.870675
                    2,  # right, leaf 21
                    4,  # up, leaf 22
                ),
            ),
        ),
    )


def act_agent_0(x: Array) -> Array:
    """agent_0, team defenders: 15 leaves, 14 splits."""
    x = _ordered("agent_0", 10, x)
    x0 = x[..., 0]  # goal_dx
    x1 = x[..., 1]  # goal_dy
    x2 = x[..., 2]  # landmark_0_dx
    x3 = x[..., 3]  # landmark_0_dy
    return torch.where(
        x3 <= -1036858052,  # node 0: landmark_0_dy <= -0.100194
        torch.where(
            x2 <= 1049221404,  # node 1: landmark_0_dx <= 0.269235
            torch.where(
                x2 <= -1047048043,  # node 2: landmark_0_dx <= -0.227232
                torch.where(
                    x3 <= -1059472327,  # node 3: landmark_0_dy <= -0.649472
                    3,  # down, leaf 4
                    1,  # left, leaf 5
                ),
                3,  # down, leaf 6
            ),
            torch.where(
                x1 <= -1058056964,  # node 7: goal_dy <= -0.565109
                torch.where(
                    x0 <= 1064531399,  # node 8: goal_dx <= 0.951016
                    3,  # down, leaf 9
                    2,  # right, leaf 10
                ),
                2,  # right, leaf 11
            ),
        ),
        torch.where(
            x2 <= 1041197484,  # node 12: landmark_0_dx <= 0.140052
            torch.where(
                x3 <= 1040819626,  # node 13: landmark_0_dy <= 0.134421
                torch.where(
                    x2 <= -1036831948,  # node 14: landmark_0_dx <= -0.1
                    1,  # left, leaf 15
                    torch.where(
                        x2 <= 0,  # node 16: landmark_0_dx <= 0
                        torch.where(
                            x3 <= -8388609,  # node 17: landmark_0_dy < 0
                            3,  # down, leaf 18
                            4,  # up, leaf 19
                        ),
                        2,  # right, leaf 20
                    ),
                ),
                torch.where(
                    x2 <= -1047799265,  # node 21: landmark_0_dx <= -0.238426
                    1,  # left, leaf 22
                    4,  # up, leaf 23
                ),
            ),
            torch.where(
                x3 <= 1053680299,  # node 24: landmark_0_dy <= 0.40212
                2,  # right, leaf 25
                torch.where(
                    x2 <= 1061492892,  # node 26: landmark_0_dx <= 0.769907
                    4,  # up, leaf 27
                    2,  # right, leaf 28
                ),
            ),
        ),
    )


def act_agent_1(x: Array) -> Array:
    """agent_1, team defenders: 18 leaves, 17 splits."""
    x = _ordered("agent_1", 10, x)
    x4 = x[..., 4]  # landmark_1_dx
    x5 = x[..., 5]  # landmark_1_dy
    x6 = x[..., 6]  # adversary_0_dx
    x9 = x[..., 9]  # agent_0_dy
    return torch.where(
        x4 <= 1042888100,  # node 0: landmark_1_dx <= 0.165244
        torch.where(
            x5 <= 1044792367,  # node 1: landmark_1_dy <= 0.193619
            torch.where(
                x4 <= -1042098821,  # node 2: landmark_1_dx <= -0.153482
                torch.where(
                    x5 <= -1054782475,  # node 3: landmark_1_dy <= -0.434967
                    3,  # down, leaf 4
                    1,  # left, leaf 5
                ),
                torch.where(
                    x5 <= -8388609,  # node 6: landmark_1_dy < 0
                    3,  # down, leaf 7
                    torch.where(
                        x5 <= 1036831947,  # node 8: landmark_1_dy <= 0.1
                        torch.where(
                            x4 <= -8388609,  # node 9: landmark_1_dx < 0
                            1,  # left, leaf 10
                            2,  # right, leaf 11
                        ),
                        4,  # up, leaf 12
                    ),
                ),
            ),
            torch.where(
                x4 <= -1050840019,  # node 13: landmark_1_dx <= -0.317473
                torch.where(
                    x5 <= 1062407615,  # node 14: landmark_1_dy <= 0.824428
                    1,  # left, leaf 15
                    4,  # up, leaf 16
                ),
                4,  # up, leaf 17
            ),
        ),
        torch.where(
            x5 <= 1052525049,  # node 18: landmark_1_dy <= 0.367691
            torch.where(
                x5 <= -1059055541,  # node 19: landmark_1_dy <= -0.624629
                torch.where(
                    x4 <= 1063117974,  # node 20: landmark_1_dx <= 0.866769
                    3,  # down, leaf 21
                    2,  # right, leaf 22
                ),
                torch.where(
                    x9 <= -1069236508,  # node 23: agent_0_dy <= -1.46292
                    torch.where(
                        x5 <= -8388609,  # node 24: landmark_1_dy < 0
                        3,  # down, leaf 25
                        2,  # right, leaf 26
                    ),
                    2,  # right, leaf 27
                ),
            ),
            torch.where(
                x4 <= 1062468101,  # node 28: landmark_1_dx <= 0.828034
                torch.where(
                    x6 <= 1059675643,  # node 29: adversary_0_dx <= 0.66159
                    4,  # up, leaf 30
                    2,  # right, leaf 31
                ),
                torch.where(
                    x5 <= 1065448709,  # node 32: landmark_1_dy <= 1.01138
                    2,  # right, leaf 33
                    4,  # up, leaf 34
                ),
            ),
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
