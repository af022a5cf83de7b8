"""Experts trained elsewhere: torch modules, TorchScript included, as an expert of ours.

Does: asks one module per agent for its action's logits (or Q values), and critics for the worth of joint actions.
Assumes: the extra `maviper[train]`; the caller has loaded the modules, by its own means and at its own risk.
Does not: open a file. TorchScript and pickled modules can run code when they are loaded, and nothing of ours does that.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, cast

import numpy as np

from codegen.errors import InputError, MissingToolError
from codegen.ir import Float32, Float64
from codegen.wording import format_count
from maviper.experts.expert import AS_GIVEN
from maviper.experts.network import NO_CRITIC
from maviper.worlds import World
from maviper.worlds.world import Int

ROWS_AT_ONCE = 65_536


class TorchExpert:
    """An expert of torch modules (`torch.nn.Module` or `torch.jit.ScriptModule`, on any device).

    `actors`: one per agent; [batch, n_features] float32 -> [batch, n_actions], the greedy action being the argmax.
    `critics`: one per agent; ([batch, all features side by side], [batch, all actions one-hot side by side]) ->
    [batch] or [batch, 1]. Without critics, `value_based` says that the actors' outputs are Q_i(o_i, a_i); otherwise the
    expert has no critic (measure Q instead). InputError where modules and world do not fit together.
    """

    def __init__(
        self,
        world: World,
        actors: Sequence[Callable[..., Any]],
        critics: Sequence[Callable[..., Any]] | None = None,
        value_based: bool = False,
        card: Mapping[str, Any] | None = None,
    ) -> None:
        try:
            import torch  # pyright: ignore[reportMissingImports]
        except ImportError:
            advice = "install the extra: pip install 'maviper[train]'"
            raise MissingToolError("torch modules need torch", "", advice) from None
        self._torch = torch
        self.world, self.card = world, dict(card or {})
        self.hash = ""
        self.agents = world.agents
        self._actors, self._critics = list(actors), None if critics is None else list(critics)
        self.centralized = not value_based
        for kind, modules in (("actors", self._actors), ("critics", self._critics)):
            if modules is not None and len(modules) != len(self.agents):
                raise InputError(
                    f"{len(modules)} {kind} for {format_count(len(self.agents), 'agent')}", world.name, "give one each"
                )
        library: Any = torch
        for module in [*self._actors, *(self._critics or [])]:
            if isinstance(module, library.nn.Module):
                cast("Any", module).eval()
        for agent, features in enumerate(world.features):
            shape = self._outputs(agent, np.zeros((2, len(features)), np.float32)).shape
            wanted = (2, len(world.actions[agent]))
            if shape != wanted:
                where = f"{world.name}: actor of {self.agents[agent]}"
                raise InputError(f"returns shape {shape} for {wanted[0]} observations, but {wanted} is needed", where)

    def _run(self, module: Callable[..., Any], *inputs: Any) -> Float64:
        """A module's answer as float64."""
        torch: Any = self._torch
        parameters = cast("Any", module).parameters() if isinstance(module, torch.nn.Module) else iter(())
        device = next((parameter.device for parameter in parameters), torch.device("cpu"))
        given = [torch.from_numpy(np.ascontiguousarray(array, np.float32)).to(device) for array in inputs]
        try:
            with torch.no_grad():
                return module(*given).detach().cpu().double().numpy()
        except (RuntimeError, TypeError, ValueError, AttributeError) as error:
            reason = str(error).strip().splitlines()[-1][:200]
            raise InputError("a torch module failed", f"{self.world.name}: {reason}", "check its inputs") from None

    def _outputs(self, agent: int, obs: Float32) -> Float64:
        return self._run(self._actors[agent], obs)

    def act(self, agents: Sequence[int], observations: Sequence[Float32], state: Any) -> Int:
        """Returns the agents' actions; see `Controller.act`."""
        return np.stack([self._outputs(agent, observations[agent]).argmax(axis=1) for agent in agents], axis=1)

    def q(self, agent: int, observations: Sequence[Float32], state: Any, joint: Int, given: Int) -> Float64:
        """Returns the agent's Q; see `Expert.q`."""
        asked = np.where(joint[None] == AS_GIVEN, given[:, None], joint[None])  # [batch, n_joint, n_agents]
        if not self.centralized:
            return np.take_along_axis(self._outputs(agent, observations[agent]), asked[..., agent], axis=1)
        if self._critics is None:
            raise InputError("this expert has no critic", self.world.name, NO_CRITIC)
        seen = np.concatenate(list(observations), axis=1)
        flat = asked.reshape(-1, asked.shape[2])
        choices = [len(actions) for actions in self.world.actions]
        one_hot = np.concatenate([np.eye(n, dtype=np.float32)[flat[:, k]] for k, n in enumerate(choices)], axis=1)
        rows = np.repeat(np.arange(len(seen)), len(joint))
        values = np.empty(len(flat))
        for low in range(0, len(flat), ROWS_AT_ONCE):
            part = slice(low, low + ROWS_AT_ONCE)
            values[part] = self._run(self._critics[agent], seen[rows[part]], one_hot[part]).reshape(-1)
        return values.reshape(asked.shape[:2])
