"""What we use of Gymnasium. It has types, but those of spaces and environments say nothing until they are told what is
observed and done, which of other people's environments nobody knows before they are made.
"""

from collections.abc import Mapping
from typing import Any, SupportsFloat

from gymnasium import error as error
from gymnasium.spaces import Space

class Spec:
    name: str
    entry_point: object
    max_episode_steps: int | None

class Env:
    metadata: dict[str, Any]
    spec: Spec | None
    observation_space: Space
    action_space: Space
    @property
    def unwrapped(self) -> Env: ...
    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]: ...
    def step(self, action: Any) -> tuple[Any, SupportsFloat, bool, bool, dict[str, Any]]: ...
    def render(self) -> Any: ...
    def close(self) -> None: ...

class Wrapper(Env):
    env: Env

registry: Mapping[str, Spec]

def make(name: str, *, disable_env_checker: bool, **options: Any) -> Env: ...
