"""What we use of PettingZoo, which has no types that checkers may read. Unless an environment is ours, its agents,
observations and actions are what its author chose.
"""

from collections.abc import Mapping
from typing import Any, Generic

from gymnasium.spaces import Space
from typing_extensions import TypeVar

_Agent = TypeVar("_Agent", default=Any)
_Seen = TypeVar("_Seen", default=Any)
_Action = TypeVar("_Action", default=Any)

class AECEnv:
    metadata: dict[str, Any]
    agents: list[Any]
    agent_selection: Any

class ParallelEnv(Generic[_Agent, _Seen, _Action]):
    metadata: dict[str, Any]
    agents: list[_Agent]
    possible_agents: list[_Agent]
    @property
    def unwrapped(self) -> ParallelEnv[_Agent, _Seen, _Action]: ...
    def observation_space(self, agent: _Agent) -> Space: ...
    def action_space(self, agent: _Agent) -> Space: ...
    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Mapping[_Agent, _Seen], Mapping[_Agent, Any]]: ...
    def step(self, actions: dict[_Agent, _Action]) -> tuple[Mapping[_Agent, Any], ...]: ...
    def render(self) -> Any: ...
    def close(self) -> None: ...
