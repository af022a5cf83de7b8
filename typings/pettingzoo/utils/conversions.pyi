"""PettingZoo's environments in which agents take turns, as ones in which they act at once."""

from collections.abc import Callable
from typing import Any

from pettingzoo import AECEnv, ParallelEnv

# by this mpe2, which has no types either, makes its parallel environments
def parallel_wrapper_fn(env_fn: Callable[..., Any]) -> Callable[..., Any]: ...

class aec_to_parallel_wrapper(ParallelEnv):
    aec_env: AECEnv
    def __init__(self, aec_env: AECEnv) -> None: ...

class turn_based_aec_to_parallel_wrapper(ParallelEnv):
    aec_env: AECEnv
    def __init__(self, aec_env: AECEnv) -> None: ...
