"""Experts of a user's own: what their code raises or returns wrongly is told as their code's, with its place.

Does: makes the expert that a `module:function` returns; checks every answer that it gives.
Assumes: whoever names a module means to run its code.
Does not: change what a correct expert does.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, cast

import numpy as np

from codegen.errors import InputError
from codegen.ir import Float32, Float64
from codegen.wording import format_count
from maviper.experts.wrapped import Wrapped
from maviper.worlds import World
from maviper.worlds.outside.making import import_maker
from maviper.worlds.outside.silence import output_aside
from maviper.worlds.outside.sources import Source, fault
from maviper.worlds.world import Int, bounds

MEMBERS = ("world", "agents", "act", "q")
FIX = "fix it there"
ROWS = "return an array of action numbers [batch, len(agents)], as np.stack(columns, axis=1) of one column per agent"


@dataclass(frozen=True)
class Given(Wrapped):
    """A user's expert, whose answers are checked. InputError for those that are not what `Expert` says."""

    source: Source

    @property
    def card(self) -> Mapping[str, Any]:
        """The expert's; {} where it has none."""
        return getattr(self.expert, "card", {})

    @property
    def hash(self) -> str:
        """The expert's; "" where it has none."""
        return getattr(self.expert, "hash", "")

    @property
    def centralized(self) -> bool:
        """The expert's; True where it does not say."""
        return bool(getattr(self.expert, "centralized", True))

    @property
    def world(self) -> World:
        """The world that it plays."""
        return cast("Any", self.expert).world

    def act(self, agents: Sequence[int], observations: Sequence[Float32], state: Any) -> Int:
        """Returns the agents' actions, checked; see `Controller.act`."""
        actions = self._call_expert("act", agents, observations, state)
        if self.world.outputs:
            return self._numbers(actions, len(observations[0]), agents)
        wanted = (len(observations[0]), len(agents))
        if actions.dtype.kind not in "iu":
            what = f"act of your expert returns {_kind(actions)}, not numbers of actions"
            raise InputError(
                what, self.source.text, "return whole numbers, such as logits.argmax(axis=1) of each agent"
            )
        if actions.shape != wanted:
            asked = f"{format_count(wanted[0], 'observation')} of {format_count(wanted[1], 'agent')}"
            what = f"act of your expert returns shape {actions.shape} for {asked}"
            raise InputError(f"{what}, not {wanted}", self.source.text, ROWS)
        acting = self.world.alive(state)
        for place, agent in enumerate(agents):
            n = len(self.world.actions[agent])
            wrong = (actions[:, place] < 0) | (actions[:, place] >= n)
            if (wrong & acting[:, agent]).any():
                action = actions[wrong & acting[:, agent], place][0]
                what = f"act of your expert returns action {action} for {self.agents[agent]}, which has {n}"
                raise InputError(
                    what, self.source.text, f"its actions are 0 to {n - 1}: {_list_actions(self.world, agent)}"
                )
            actions[wrong, place] = 0  # of who no longer acts, which means nothing
        return actions.astype(np.int64)

    def _numbers(self, given: Any, batch: int, agents: Sequence[int]) -> Any:
        """Returns its numbers, [batch, len(agents), n_outputs], as float32; InputError for anything else."""
        outputs = self.world.outputs
        wanted = (batch, len(agents), max(len(outputs[agent]) for agent in agents))
        fits = given.ndim == 3 and given.shape[:2] == wanted[:2] and given.shape[2] >= wanted[2]
        if given.dtype.kind not in "fiu" or not fits or not np.isfinite(given).all():
            seen = _kind(given) if fits else f"shape {given.shape}"
            what = f"act of your expert returns {seen}, not finite numbers of shape {wanted}"
            raise InputError(what, self.source.text, "return the numbers of each agent, zeros behind those of few")
        numbers = np.zeros(wanted, np.float32)
        for place, agent in enumerate(agents):
            low, high = bounds(outputs[agent])
            numbers[:, place, : len(low)] = np.clip(given[:, place, : len(low)], low, high)
        return numbers

    def q(self, agent: int, observations: Sequence[Float32], state: Any, joint: Int, given: Int) -> Float64:
        """Returns the agent's Q, checked; see `Expert.q`."""
        try:
            values = self._call_expert("q", agent, observations, state, joint, given)
        except InputError as error:
            if not isinstance(error.__cause__, NotImplementedError):
                raise
            what = "your expert has no critic: its q raises NotImplementedError"
            advice = "add --critic none, or --critic measured where the game can be tried out"
            raise InputError(what, self.source.text, advice) from None
        wanted = (len(given), len(joint))
        if values.dtype.kind not in "fiu" or values.shape != wanted or not np.isfinite(values).all():
            seen = _kind(values) if values.shape == wanted else f"shape {values.shape}"
            what = f"q of your expert returns {seen}, not finite numbers of shape {wanted}"
            raise InputError(
                what, self.source.text, "return one worth for each state and joint action, or --critic none"
            )
        return values.astype(np.float64)

    def _call_expert(self, verb: str, *given: Any) -> np.ndarray:
        doing = f"{verb} of your expert"
        return _run(lambda: np.array(getattr(self.expert, verb)(*given)), self.source, doing)


def import_expert(source: Source) -> Given:
    """The expert that the function of a module returns. InputError when it raises, or returns something else."""
    function = import_maker(source)
    expert = _run(lambda: function(**source.options), source, source.function)
    missing = [name for name in MEMBERS if not hasattr(expert, name)]
    if missing:
        what = f"what it returns is not an expert: it lacks {', '.join(missing)}"
        advice = "return a maviper.experts.adapter.TorchExpert, or an object with these members"
        raise InputError(what, source.text, advice)
    if not isinstance(expert.world, World):
        what = f"`world` of your expert is a {type(expert.world).__name__}, not a world"
        raise InputError(what, source.text, "write self.world = maviper.worlds.find(NAME)")
    agents: Any = expert.agents
    if not isinstance(agents, Sequence) or tuple(cast("Sequence[Any]", agents)) != expert.world.agents:
        what = f"`agents` of your expert are not those of its world, {', '.join(expert.world.agents)}"
        raise InputError(what, source.text, "write self.agents = self.world.agents")
    return Given(expert, source)


def _run(function: Callable[[], Any], source: Source, doing: str) -> Any:
    """Returns the result of a user's code; InputError, with the cause, when it raises."""
    try:
        with output_aside():
            return function()
    except (Exception, SystemExit) as error:
        raise fault(error, source, doing, FIX) from error


def _kind(array: np.ndarray) -> str:
    """Describes in words the kind of values that an array holds."""
    kinds = {
        "f": "floats",
        "b": "truth values",
        "O": "objects",
        "U": "texts",
        "i": "whole numbers",
        "u": "whole numbers",
    }
    nan = " that are not finite" if array.dtype.kind == "f" and not np.isfinite(array).all() else ""
    return f"{kinds.get(array.dtype.kind, str(array.dtype))}{nan}"


def _list_actions(world: World, agent: int) -> str:
    names = [action.name for action in world.actions[agent]]
    return ", ".join(names[:8]) + (", ..." if len(names) > 8 else "")
