"""PettingZoo's environments in which agents take turns, as ones in which they act at once."""

from pettingzoo import AECEnv, ParallelEnv

class aec_to_parallel_wrapper(ParallelEnv):
    aec_env: AECEnv
    def __init__(self, aec_env: AECEnv) -> None: ...

class turn_based_aec_to_parallel_wrapper(ParallelEnv):
    aec_env: AECEnv
    def __init__(self, aec_env: AECEnv) -> None: ...
