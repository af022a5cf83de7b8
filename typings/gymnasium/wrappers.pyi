"""The two wrappers that `gymnasium.make` puts around an environment."""

from gymnasium import Wrapper

class OrderEnforcing(Wrapper): ...

class TimeLimit(Wrapper):
    _max_episode_steps: int
